"""What a scene became in DART."""

from dataclasses import dataclass, field
from typing import Any

from plumbline.adapters.dart.drives import Motor
from plumbline.harness.adapter import Notice, Settings
from plumbline.harness.adapter.distance_springs import DistanceSprings
from plumbline.harness.scene import Effect, Scene
from plumbline.harness.trajectory import Floats

Loop = tuple[tuple[int, Floats], ...]
"""One or two (place of the body, point in B [m]): what a constraint holds together, or to the world."""


@dataclass(slots=True)
class Built:
    """One DART world with the scene that it was made of.

    Terms:
        nodes: one BodyNode for each body. free: bodies alone under a FreeJoint; linked: all other moving ones. belts: joints of
        kinematic bodies with (w_WB, v_WB), by body. coordinates: DART's joints that have one, by name. hung: the place of the
        body that hangs on each joint of a skeleton, by name. damped: (body, linear, angular damping [1/s]) that act as forces.
        rotors: by joint, its armature over a step [N m s/rad or N s/m]. shapes: for rays. springs: those between points of two
        bodies. loops: what constraints hold together. cone: the solver of the exact friction cone. effects: what the scene
        calls for.
    """

    scene: Scene
    dart: Any
    world: Any
    resolved: Settings
    nodes: list[Any]
    # The first skeletons belong to the bodies of `free`, in their order.
    free: list[int] = field(default_factory=list)
    linked: list[int] = field(default_factory=list)
    skeletons: list[Any] = field(default_factory=list)
    belts: dict[str, tuple[Any, Floats]] = field(default_factory=dict)
    coordinates: dict[str, Any] = field(default_factory=dict)
    hung: dict[str, int] = field(default_factory=dict)
    damped: list[tuple[int, float, float]] = field(default_factory=list)
    motors: dict[str, Motor] = field(default_factory=dict)
    rotors: dict[str, float] = field(default_factory=dict)
    shapes: list[Any] = field(default_factory=list)
    springs: DistanceSprings | None = None
    loops: list[Loop] = field(default_factory=list)
    cone: Any = None
    notices: list[Notice] = field(default_factory=list)
    effects: Effect = field(init=False)

    def __post_init__(self) -> None:
        self.effects = self.scene.effects

    @property
    def substeps(self) -> int:
        """How many steps DART takes for one of the scene's."""
        return self.resolved.substeps or 1
