"""What is to be run: a scene built in Python, a scene or robot file, or a case by its name."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, TypedDict, Unpack

from pydantic import TypeAdapter

from plumbline.api.arguments import checked, within
from plumbline.harness.intake.documents import named
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.import_wishes import Root, Scenario, Start, Wishes
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.typed_fields import FieldError, filled
from plumbline.harness.scene import Scene

if TYPE_CHECKING:
    from plumbline.harness.adapter import Adapter
    from plumbline.harness.case import Case
    from plumbline.harness.scene.importers.fidelity import Imported

Source: TypeAlias = Scene | Path | str
"""A scene, the path of a scene or robot file, or the name of a case."""


class ImportOptions(TypedDict, total=False):
    """How a robot file becomes a scene, by the names of the command line's options: what the file does not say."""

    drop: Sequence[str]
    packages: Mapping[str, str]
    root: Root
    scenario: Scenario
    start: Start
    convex: int
    one_friction: bool
    strict: bool


def _wishes(options: ImportOptions) -> Wishes:
    names = tuple(ImportOptions.__annotations__)
    for name in options:
        if name not in names:
            raise RobotError(
                f"import option {quoted(name)}: unknown, expected some of {', '.join(names)}{did_you_mean(name, names)}"
            )
    try:
        wishes = filled(TypeAdapter(Wishes), dict(options), "import option")
    except FieldError as error:
        raise RobotError(str(error)) from None
    if wishes.convex is not None and not 2 <= wishes.convex <= 64:
        raise RobotError(f"import option: convex: {wishes.convex}, expected 2..64")
    return replace(wishes, looks=True, tell=warnings.warn)


def is_case(what: Source) -> bool:
    """Is it the name of a case? A file has an ending."""
    return isinstance(what, str) and not Path(what).suffix and not Path(what).exists()


def imported(what: Source, options: ImportOptions) -> "Imported":
    """A scene, or that of a file, with what became of each of its elements. Raises: PlumblineError."""
    from plumbline.harness.scene.importers.fidelity import Imported
    from plumbline.harness.scene.importers.reading import read

    if isinstance(what, Scene):
        if options:
            raise RobotError(f"import option: {next(iter(options))}: unknown of a scene built in Python, expected none")
        return Imported(name="scene", scene=what, source="a scene built in Python")
    return read(Path(what), _wishes(options))


@checked
def load(what: Source, **options: Unpack[ImportOptions]) -> Scene:
    """The scene of a scene or robot file (TOML, JSON, URDF, MJCF, SDF), or of a case by its name.

    Args: options: of robot files, as `plumbline run` has them: root, scenario, start, drop, packages, convex, one_friction,
        strict.
    Raises: PlumblineError, with file, element, value and what was expected.
    """
    from plumbline.harness.study import plugins

    if is_case(what):
        case = plugins.case(str(what))
        return case.scene(case.parameters)
    return imported(what, options).scene


def case_of(what: Source, folder: Path, duration: float | None, dt: float | None, options: ImportOptions) -> "Case":
    """The case to run; a scene or robot is kept in the run folder with these wishes, as `plumbline run` does.

    Args: duration, dt [s]: None for what the file or case says. Raises: PlumblineError.
    """
    from plumbline.harness.store.imported_scenes import keep
    from plumbline.harness.study import plugins

    within("duration [s]", duration, 1e-9, 1e6)
    within("dt [s]", dt, 1e-9, 1.0)
    if not is_case(what):
        wished = {name: value for name, value in (("duration", duration), ("dt", dt)) if value is not None}
        path = keep(folder, replace(imported(what, options), **wished))  # type: ignore[arg-type]
        return plugins.case(f"{plugins.SCENE_PREFIX}{path.resolve()}")
    case = plugins.case(str(what))
    if duration is not None:
        remedy = f"plumbline.run(plumbline.load({case.name!r}), duration={duration:g}) runs its scene alone"
        raise RobotError(
            f"case {quoted(case.name)}: duration {duration:g} s, expected none: its truth ends at {case.duration:g} s; {remedy}"
        )
    if options:
        raise RobotError(f"case {quoted(case.name)}: import option {next(iter(options))}, expected none: it is no robot file")
    return case


def refuse_two_frictions(file: str, scene: Scene, adapters: "Mapping[str, Adapter]") -> None:
    """Refuse a scene whose static friction lies above its kinetic friction if an engine has one coefficient alone.

    Raises: RobotError.
    """
    from plumbline.harness.adapter import Feature
    from plumbline.harness.scene import Effect

    both = [law for law in scene.surfaces if law.static_friction > law.kinetic_friction]
    lacking = [name for name, adapter in adapters.items() if Feature.STATIC_FRICTION not in adapter.features]
    if not both or not lacking or Effect.FRICTION not in scene.effects:
        return
    law = both[0]
    having = [name for name in adapters if name not in lacking]
    others = f", or --engine {having[0]} runs it on what has both" if having else ""
    raise RobotError(
        f"{named(file)}: surface {'/'.join(law.between)}: static_friction {law.static_friction:g} above kinetic_friction "
        f"{law.kinetic_friction:g}, which {', '.join(lacking)} cannot express; "
        f"--one-friction takes the kinetic one for both{others}; from Python, one_friction=True"
    )
