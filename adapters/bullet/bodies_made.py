"""What has been put into a world of Bullet: its numbers of the bodies, by their places in the scene."""

from dataclasses import dataclass, field

from plumbline.adapters.bullet.drives import Actuation
from plumbline.adapters.bullet.kinematic_bodies import Belt
from plumbline.adapters.bullet.vendor import Port
from plumbline.harness.adapter import Notice
from plumbline.harness.adapter.distance_springs import DistanceSprings
from plumbline.harness.adapter.rotors import Blows
from plumbline.harness.trajectory import Floats


@dataclass(slots=True)
class Assembly:
    """A world as far as it is made; each function of the builder adds its own.

    Terms:
        unseen: the visual shape without an extent that every body has: pictures are drawn in a twin of this world, and told
        nothing, pybullet would make one of each collision shape. q_IB (n, 4): turns I against B.
        bases: (place, number) of bodies that are bases. linked: number -> places of links. actuators: number -> springs and
        drives. prescribed: the kinematic bodies.
        coordinates: (number, link, position in the initial pose) of joints with a coordinate, by name. hung: (number, link) of
        those that links of multibodies hang by. springs: those between points of two bodies. blows: what ends a run of joints
        with rotors; None where none has one. address: (number, link) -> place. grounds: numbers of planes, and of
        boxes in their place, each with whether what has faces meets it, or what has none. waiting: (number, link) of bodies
        whose contacts wait until they touch.
        notices: what the engine computes beside the scene.
    """

    port: Port
    unseen: int
    q_IB: Floats
    bases: list[tuple[int, int]] = field(default_factory=list)
    linked: dict[int, tuple[int, ...]] = field(default_factory=dict)
    actuators: dict[int, Actuation] = field(default_factory=dict)
    prescribed: list[Belt] = field(default_factory=list)
    coordinates: dict[str, tuple[int, int, float]] = field(default_factory=dict)
    hung: dict[str, tuple[int, int]] = field(default_factory=dict)
    springs: DistanceSprings | None = None
    blows: Blows | None = None
    address: dict[tuple[int, int], int] = field(default_factory=dict)
    grounds: list[tuple[int, bool]] = field(default_factory=list)
    waiting: set[tuple[int, int]] = field(default_factory=set)
    notices: list[Notice] = field(default_factory=list)
