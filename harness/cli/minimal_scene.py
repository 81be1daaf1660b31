"""The scene of a run with the effects that it needs alone, as a file beside the run that can be run itself."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import tomli_w

from plumbline.harness.findings.effects_audit import audit, idle, scenes_of
from plumbline.harness.findings.tables import effects
from plumbline.harness.scene import Effect
from plumbline.harness.scene.file import dump_toml
from plumbline.harness.scene.importers.companion import beside, load_companion
from plumbline.harness.store import disk
from plumbline.harness.store.imported_scenes import MINIMAL
from plumbline.harness.study.plugins import SCENE_PREFIX

if TYPE_CHECKING:
    from plumbline.harness.case import Case
    from plumbline.harness.store.store import Store

_OF_A_RUN = ("duration", "dt", "seed")


def write_minimal(store: "Store", case: "Case") -> tuple[Path, list[str]] | None:
    """Write the scene without the effects that its audit finds idle, by those that can judge it.

    Returns: the file and the effects; None where the audit proposes nothing. Raises: OSError.
    """
    audited = audit(effects.TABLE.rows(store))
    without = [idle(scene, audited.judged) for scene in scenes_of(audited.failed) if scene[0] == case.name]
    if not without or not without[0]:
        return None
    names = without[0]
    narrow = Effect.NONE
    for name in names:
        narrow |= Effect[name.upper()]
    scene = case.scene(case.parameters)
    minimal = replace(scene, narrow=scene.narrow | narrow, widen=scene.widen & ~narrow)
    source = Path(case.name.removeprefix(SCENE_PREFIX))
    path = store.folder / MINIMAL / f"{source.stem}.minimal.toml"
    disk.make_folder(path.parent)
    heading = f"# {case.title} without what its motion does not show: {', '.join(names)}. {audited.judges()}.\n"
    disk.write_atomically(path, (heading + dump_toml(minimal)).encode())
    own = load_companion(beside(source))
    run = {"duration": case.duration} | {key: value for key in _OF_A_RUN if (value := getattr(own, key)) is not None}
    disk.write_atomically(beside(path), tomli_w.dumps(run).encode())
    return path, names
