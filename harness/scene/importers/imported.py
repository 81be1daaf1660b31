"""The outcome of an import: one frozen value."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from plumbline.harness.scene import PlacedShape, Scene
from plumbline.harness.scene.importers.fidelity import Fidelity


@dataclass(frozen=True, slots=True, kw_only=True)
class Imported:
    """A scene and where it comes from.

    Terms:
        name: of the robot or the scene. source: the file, in words. fidelity: what became of each element. coordinates: by the
        name of each joint of the file, its value at the start [rad or m]; joints that were merged away are not among them.
        links: by the name of each link, the body that it is part of. dropped: what the user left out.
        undropped: the scene with those of them that a scene has words for; None where none of the robot's is among them.
        looks: by body, what is drawn of it where that is not in the scene itself; empty unless asked for.
        duration [s], dt [s], look_at, seed: what the companion says of the run.
    """

    name: str
    scene: Scene
    source: str
    fidelity: tuple[Fidelity, ...] = ()
    coordinates: Mapping[str, float] = field(default_factory=dict)
    links: Mapping[str, str] = field(default_factory=dict)
    dropped: tuple[str, ...] = ()
    undropped: Scene | None = None
    looks: Mapping[str, tuple[PlacedShape, ...]] = field(default_factory=dict)
    duration: float | None = None
    dt: float | None = None
    look_at: tuple[str, ...] = ()
    seed: int | None = None
