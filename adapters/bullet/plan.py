"""What a scene means to Bullet, worked out before anything of it is made."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from plumbline.adapters.bullet.frames import plus
from plumbline.adapters.bullet.options import substep, with_slop
from plumbline.adapters.bullet.shapes import Placed
from plumbline.adapters.bullet.sliding import may_slide
from plumbline.adapters.bullet.surfaces import Coefficients, braked, coefficients
from plumbline.harness.adapter import Settings
from plumbline.harness.adapter.distance_springs import DistanceSprings, is_distance_spring
from plumbline.harness.adapter.rotations import conjugate, principal_frame
from plumbline.harness.adapter.touching_kinds import Kind
from plumbline.harness.scene import Body, Effect, Joint, Quaternion, Scene, Vector3, multiply, rotate

KINEMATIC_RATIO = 1e12
"""Mass of a kinematic body over the greatest mass of the scene."""


@dataclass(frozen=True, slots=True)
class Plan:
    """A scene, its settings and what follows from both.

    Terms:
        options: all of them, the vendor's where the settings leave them open. effects: the scene's, worked out once. touching:
        do contacts wait until bodies touch? joints: none where the scene does not call for them, without the distance springs,
        which are forces (`springs`). law: what each kind of body carries. braked: the kinds that rolling or torsional friction
        acts on. sliding: may something slide? principal: of each body its moments [kg m2] and q_BI. greatest: the greatest mass
        [kg] of what moves. gravity: in W, 0 where the scene does not call for it [m/s2].
    """

    scene: Scene
    settings: Settings
    options: Mapping[str, Any]
    effects: Effect
    touching: bool
    joints: Sequence[Joint]
    springs: DistanceSprings | None
    law: Mapping[Kind, Coefficients]
    braked: frozenset[Kind]
    sliding: bool
    principal: Sequence[tuple[Vector3, Quaternion]]
    greatest: float
    gravity: Vector3

    @classmethod
    def of(cls, scene: Scene, settings: Settings, options: Mapping[str, Any]) -> "Plan":
        """The plan of a scene under checked options. Raises: Unsupported."""
        effects = scene.effects
        # Bullet brakes a body that comes within a contact's margin so that it just touches at the end of the step, and takes
        # that from the rebound: restitution is right only if contacts wait until bodies touch, and if penetration is
        # corrected apart from velocity.
        touching = options["restitution"] == "touching" and Effect.RESTITUTION in effects
        joints = scene.joints if Effect.JOINTS in effects else ()
        return cls(
            scene=scene,
            settings=settings,
            options=with_slop(settings, options) if touching else options,
            effects=effects,
            touching=touching,
            joints=[joint for joint in joints if not is_distance_spring(joint)],
            springs=DistanceSprings.of(scene, joints, substep(settings)),
            law=coefficients(scene),
            braked=braked(scene),
            sliding=may_slide(scene),
            principal=[principal_frame(body) for body in scene.bodies],
            greatest=max((b.mass for b in scene.bodies if b.movable), default=1.0),
            gravity=scene.gravity if Effect.GRAVITY in effects else (0.0, 0.0, 0.0),
        )

    @property
    def solid(self) -> bool:
        """Do bodies touch at all?"""
        return Effect.CONTACT in self.effects

    @property
    def swept(self) -> bool:
        """Are bodies in maximal coordinates swept?"""
        return Effect.CONTINUOUS_COLLISION in self.effects and self.options["coordinates"] != "multibody"

    @property
    def h(self) -> float:
        """The (sub)step [s]."""
        return substep(self.settings)

    def mass(self, place: int) -> float:
        """The mass [kg] that Bullet is told of the body at a place of the scene."""
        body = self.scene.bodies[place]
        return {"dynamic": body.mass, "static": 0.0, "kinematic": KINEMATIC_RATIO * self.greatest}[body.motion]

    def coefficients(self, body: Body) -> Coefficients:
        """What a body carries of the law of contact."""
        return self.law.get((body.material, body.movable), Coefficients())

    def q_WI(self, place: int) -> Quaternion:
        """The principal frame of the body at a place, in W."""
        return multiply(self.scene.bodies[place].q_WB, self.principal[place][1])

    def placed(self, place: int, p_LI: Vector3) -> list[Placed]:
        """The body's shapes at their poses in the link frame L, which is turned like I and has I's origin at p_LI."""
        if not self.solid:
            return []
        q_IB = conjugate(self.principal[place][1])
        return [
            (placed.shape, plus(p_LI, rotate(q_IB, placed.p_BS)), multiply(q_IB, placed.q_BS))
            for placed in self.scene.bodies[place].collision
        ]
