"""Between a robot file and a run of it: the import, kept in the run folder, and what is refused before anything runs."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbline.harness.cli.guard import USAGE, say, stop
from plumbline.harness.cli.robot_options import imported_from, is_robot
from plumbline.harness.intake.documents import named

if TYPE_CHECKING:
    from collections.abc import Mapping

    from plumbline.harness.adapter import Adapter
    from plumbline.harness.scene import Scene


def scene_to_run(name: str, folder: Path, options: "dict[str, Any]") -> str:
    """The path of the scene file that is run: a file of our own as it is, another format's import in the run folder.

    Raises: RobotError, SceneError, OSError.
    """
    path = Path(name)
    asked = any(options.values())
    if not is_robot(path) and not asked:
        return name

    from plumbline.harness.store.imported_scenes import keep

    imported = imported_from(path, options, looks=True)
    of_run = {key: options[key] for key in ("dt", "duration") if options.get(key) is not None}
    imported = replace(imported, **of_run)
    counts = {word: sum(row.outcome == word for row in imported.fidelity) for word in ("exact", "approximated", "left_out")}
    summary = ", ".join(f"{count} kinds of elements {word.replace('_', ' ')}" for word, count in counts.items())
    say(f"{imported.source}: {summary}; show --table fidelity lists them", err=True)
    for row in imported.fidelity:
        if row.element == "start" and row.outcome == "exact":
            say(f"joint '{row.name}' starts at {row.becomes}: {row.consequence} {row.value:.3g} {row.unit}", err=True)
    if imported.dropped:
        say(f"dropped by the user: {', '.join(imported.dropped)}", err=True)
    return str(keep(folder, imported))


def refuse_two_frictions(file: str, scene: "Scene", adapters: "Mapping[str, Adapter]") -> None:
    """Stop where static friction lies above kinetic friction and an engine has one coefficient alone."""
    from plumbline.harness.adapter import Feature
    from plumbline.harness.scene import Effect

    both = [law for law in scene.surfaces if law.static_friction > law.kinetic_friction]
    lacking = [name for name, adapter in adapters.items() if Feature.STATIC_FRICTION not in adapter.features]
    if not both or not lacking or Effect.FRICTION not in scene.effects:
        return
    law = both[0]
    having = [name for name in adapters if name not in lacking]
    others = f", or --engine {having[0]} runs it on what has both" if having else ""
    stop(
        USAGE,
        f"{named(file)}: surface {'/'.join(law.between)}: static_friction {law.static_friction:g} above kinetic_friction "
        f"{law.kinetic_friction:g}, which {', '.join(lacking)} cannot express; "
        f"--one-friction takes the kinetic one for both{others}",
    )
