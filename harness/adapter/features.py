"""Which features of an engine a scene uses."""

from collections.abc import Iterator

from plumbline.harness.adapter import Feature
from plumbline.harness.adapter.distance_springs import is_distance_spring
from plumbline.harness.adapter.spanning_forest import DisjointSets
from plumbline.harness.scene import WORLD, Ball, Distance, Effect, Fixed, Joint, Scene

_DAMPING = {Effect.LINEAR_DAMPING: Feature.LINEAR_DAMPING, Effect.ANGULAR_DAMPING: Feature.ANGULAR_DAMPING}
_CONTACT = {
    Effect.RESTITUTION: Feature.RESTITUTION,
    Effect.ROLLING_FRICTION: Feature.ROLLING_FRICTION,
    Effect.TORSIONAL_FRICTION: Feature.TORSIONAL_FRICTION,
    Effect.CONTINUOUS_COLLISION: Feature.CONTINUOUS_COLLISION,
}
_ALONG = {
    "armature": Feature.ARMATURE,
    "friction_loss": Feature.FRICTION_LOSS,
    "speed_limit": Feature.SPEED_LIMIT,
    "coupling": Feature.COUPLING,
}


def features_of(scene: Scene) -> Feature:
    """What an engine must be able to express for this scene, as far as an effect calls for it: bodies, joints, laws of contact.

    Neither what is asked of a running simulation (contacts, rays, pictures, saving), nor whether pairs of materials need a law
    each, nor whether one moment of inertia is turned against another.
    """
    features, effects = Feature.NONE, scene.effects  # what it takes to tell effects grows with the scene: it is done once
    for needed in (*_of_bodies(scene, effects), *_of_joints(scene, effects)):
        features |= needed
    for effect, feature in (_DAMPING | _CONTACT).items():
        if effect in effects:
            features |= feature
    if Effect.FRICTION in effects and any(law.static_friction > law.kinetic_friction for law in scene.surfaces):
        features |= Feature.STATIC_FRICTION
    return features


def _of_bodies(scene: Scene, effects: Effect) -> Iterator[Feature]:
    for body in scene.bodies:
        if body.motion == "kinematic" and (any(body.v_WB) or any(body.w_WB)):
            yield Feature.KINEMATIC
        if body.prescribed is not None:
            yield Feature.KINEMATIC | Feature.PRESCRIBED_MOTION
        if body.mass_point:
            yield Feature.MASS_POINT
        if body.massless:
            yield Feature.MASSLESS
        if len(body.collision) > 1:
            yield Feature.COMPOUND
        if Effect.CONTACT in effects:
            yield from (Feature[placed.shape.type.upper()] for placed in body.collision)
            if body.movable and any(placed.shape.type == "triangle_mesh" for placed in body.collision):
                yield Feature.MOVING_MESH


def _of_joints(scene: Scene, effects: Effect) -> Iterator[Feature]:
    joints = scene.joints if Effect.JOINTS in effects else ()
    if joints and scene.tendons:
        yield Feature.TENDON
    for joint in joints:
        if is_distance_spring(joint):
            yield Feature.DISTANCE_SPRING
            continue
        yield Feature[joint.type.upper()]
        if isinstance(joint, Fixed | Ball):
            continue
        if joint.limits is not None:
            yield Feature.LIMITS
        if joint.spring is not None:
            yield Feature.SPRINGS
        if not isinstance(joint, Distance):
            yield from (feature for name, feature in _ALONG.items() if getattr(joint, name))
            if joint.effort is not None:
                yield Feature.WRENCH
        if not isinstance(joint, Distance) and joint.drive is not None and Effect.DRIVES in effects:
            yield Feature.DRIVES
            if joint.drive.feedforward:
                yield Feature.FEEDFORWARD
    if _loops(scene, joints):
        yield Feature.CLOSED_LOOP


def _loops(scene: Scene, joints: tuple[Joint, ...]) -> bool:
    """Do joints, distances apart, hold a body to another, or to what stands still, in two ways?"""
    sets = DisjointSets[str]()
    still = {body.name for body in scene.bodies if body.motion == "static"}
    for joint in joints:
        if isinstance(joint, Distance):
            continue
        a, b = ("" if name in still or name == WORLD else name for name in (joint.parent, joint.child))
        if not sets.unite(a, b):
            return True
    return False
