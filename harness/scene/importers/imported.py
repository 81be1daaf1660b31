"""The outcome of an import: one frozen value."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from harness.scene import Scene
from harness.scene.importers.fidelity import Fidelity

__all__ = ["Imported"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Imported:
    """A scene and where it comes from.

    Terms:
        name: of the robot or the scene. source: the file, in words. fidelity: what became of each element. coordinates: by the
        name of each joint of the file, its value at the start [rad or m]; joints that were merged away are not among them.
        links: by the name of each link, the body that it is part of. dropped: kinds of elements that the user left out.
        duration [s], dt [s], look_at, seed: what the companion says of the run.
    """

    name: str
    scene: Scene
    source: str
    fidelity: tuple[Fidelity, ...] = ()
    coordinates: Mapping[str, float] = field(default_factory=dict)
    links: Mapping[str, str] = field(default_factory=dict)
    dropped: tuple[str, ...] = ()
    duration: float | None = None
    dt: float | None = None
    look_at: tuple[str, ...] = ()
    seed: int | None = None
