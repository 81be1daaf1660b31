"""What a robot is, whoever read it: joints as lines in W at the zero configuration, and masses by the joint that moves them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from plumbline.harness.scene import Surface
from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.importers.robot import Geometry, Kind, Servo
from plumbline.harness.scene.values import Vector3

FIXED = ""
"""The name that stands for the world where a joint's parent or a mass's joint is meant."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JointFacts:
    """One coordinate (three of a ball, six of a free joint).

    Terms:
        parent: the joint that moves what it hangs on, FIXED for none. axis, anchor [m]: its line in W, all coordinates at 0. An
        axis is a unit vector but where a loader keeps another length: then rates count as many times, and poses do not.
        lower, upper [rad or m]: None is open. damping [N m s/rad or N s/m], stiffness, rest: of a passive spring. armature
        [kg m2 or kg]. friction_loss, effort [N m or N], speed [rad/s or m/s]: None is unbounded. drive: None for none.
    """

    name: str
    kind: Kind
    parent: str
    axis: Array
    anchor: Array
    lower: float | None = None
    upper: float | None = None
    damping: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    armature: float = 0.0
    friction_loss: float = 0.0
    effort: float | None = None
    speed: float | None = None
    drive: Servo | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MassFacts:
    """All that one joint moves and no further one does.

    Terms: joint: its name. members: the links. mass [kg]; centre [m] in W, inertia [kg m2] about it in W's axes, all
    coordinates at 0.
    """

    joint: str
    members: tuple[str, ...]
    mass: float
    centre: Array
    inertia: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """What is neither a mass nor a joint of the tree.

    Terms:
        kind: 'mimic', 'closure', or that of what has no numbers here (a tendon, ...). name: of the joint that follows, else of
        the element. partners: the joint that is followed; of a closure the joints that move its two sides. ratio, offset [rad
        or m]: of a mimic. points [m]: of a closure, on either side, in W, all coordinates at 0. whole: does it hold all, and
        not a point alone?
    """

    kind: str
    name: str
    partners: tuple[str, ...] = ()
    ratio: float | None = None
    offset: float | None = None
    points: tuple[Vector3, Vector3] | None = None
    whole: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RobotFacts:
    """A robot.

    Terms:
        joints: parents before children. masses: by the name of their joint; what is fixed to the world has none. gravity
        [m/s2]: None where nothing is said. laws: mimics, closed loops, tendons and the like. shapes: what touches, in W, all
        coordinates at 0, by the joint that moves it, FIXED for what is still. touches: the laws of those that may touch, by
        pair of joints. wordless: what this format or loader has no word for: fields of JointFacts, 'shape', 'touch'.
    """

    source: str
    joints: tuple[JointFacts, ...]
    masses: dict[str, MassFacts]
    gravity: Vector3 | None = None
    laws: tuple[Law, ...] = ()
    shapes: Mapping[str, tuple[Geometry, ...]] = field(default_factory=dict)
    touches: Mapping[frozenset[str], Surface] = field(default_factory=dict)
    wordless: frozenset[str] = field(default_factory=frozenset)

    def joint(self, name: str) -> JointFacts:
        """The joint of a name. Raises: KeyError."""
        for joint in self.joints:
            if joint.name == name:
                return joint
        raise KeyError(name)
