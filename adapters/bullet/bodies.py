"""Bodies: statics, bodies without joints and bases, with their mass, coefficients, damping and limits."""

from typing import Any

from plumbline.adapters.bullet.bodies_made import Assembly
from plumbline.adapters.bullet.coordinates import damping_of
from plumbline.adapters.bullet.frames import xyzw
from plumbline.adapters.bullet.ground import static_parts
from plumbline.adapters.bullet.kinematic_bodies import Belt
from plumbline.adapters.bullet.plan import Plan
from plumbline.adapters.bullet.shapes import collision_shape, inner_radius, padded
from plumbline.adapters.bullet.vendor import LIFTED
from plumbline.harness.adapter import Notice, Unsupported
from plumbline.harness.scene import Effect


def put_static(plan: Plan, made: Assembly, place: int, maximal: bool) -> None:
    """A body that never moves; without contact it is nothing at all.

    Args: maximal: is some free body in maximal coordinates? One multibody makes the contact one of multibodies, so what stands
    still follows what moves.
    """
    for shapes, faces in static_parts(plan, place):
        number = made.port.call(
            "createMultiBody",
            baseMass=0.0,
            baseCollisionShapeIndex=collision_shape(made.port, shapes),
            baseVisualShapeIndex=made.unseen,
            basePosition=plan.scene.bodies[place].p_WB,
            baseOrientation=xyzw(plan.q_WI(place)),
            useMaximalCoordinates=int(maximal),
        )
        made.address[number, -1] = place
        if faces is not None:
            made.grounds.append((number, faces))
        tell_body(plan, made, number, -1, place, maximal)


def put_free(plan: Plan, made: Assembly, place: int, maximal: bool) -> None:
    """A body without joints, in maximal or in multibody coordinates."""
    number = made.port.call(
        "createMultiBody",
        baseMass=plan.mass(place),
        baseCollisionShapeIndex=collision_shape(made.port, plan.placed(place, (0.0, 0.0, 0.0))),
        baseVisualShapeIndex=made.unseen,
        basePosition=plan.scene.bodies[place].p_WB,
        baseOrientation=xyzw(plan.q_WI(place)),
        useMaximalCoordinates=int(maximal),
    )
    put_base(plan, made, number, place, maximal)


def put_base(plan: Plan, made: Assembly, number: int, place: int, maximal: bool) -> None:
    """The base that Bullet calls `number` is the body at a place of the scene."""
    body = plan.scene.bodies[place]
    made.bases.append((place, number))
    made.address[number, -1] = place
    tell_body(plan, made, number, -1, place, maximal)
    tell_multibody(plan, made, number, place, maximal)
    velocity = body.velocity_at_start
    made.port.call("resetBaseVelocity", number, *velocity)
    if body.motion == "kinematic":
        made.prescribed.append(Belt(body.name, number, plan.mass(place), plan.gravity, plan.h, velocity, velocity))


def renew_inertia(plan: Plan, made: Assembly) -> None:
    """Let bodies in maximal coordinates, alone in the world as yet, take up their inertia.

    Their inertia in W is renewed at the end of a step only, so the first step would have that of their shapes: they take
    one at rest, weightless and without touching each other.
    """
    port = made.port
    for _, number in made.bases:
        port.call("setCollisionFilterGroupMask", number, -1, 0, 0)
        port.call("resetBaseVelocity", number, [0.0] * 3, [0.0] * 3)
    if made.bases:
        port.call("stepSimulation")
    for place, number in made.bases:
        body = plan.scene.bodies[place]
        # btBroadphaseProxy: DefaultFilter meets AllFilter.
        port.call("setCollisionFilterGroupMask", number, -1, 1, -1)
        port.call("resetBasePositionAndOrientation", number, body.p_WB, xyzw(plan.q_WI(place)))
        port.call("resetBaseVelocity", number, *body.velocity_at_start)


def check_joined(plan: Plan, made: Assembly, place: int) -> None:
    """What a body in multibody coordinates has no room for. Raises: Unsupported."""
    body = plan.scene.bodies[place]
    if damping_of(plan, body) is not None:
        raise Unsupported(f"damping of body '{body.name}'", "a multibody's damping in Bullet is c v (1 + |v|)")
    if Effect.CONTINUOUS_COLLISION in plan.effects and plan.solid:
        text = "continuous collision: joined bodies are multibodies, which Bullet cannot sweep"
        notice = Notice(text, "missing", Effect.CONTINUOUS_COLLISION)
        made.notices += [] if notice in made.notices else [notice]


def tell_body(plan: Plan, made: Assembly, number: int, link: int, place: int, maximal: bool) -> None:
    """Mass, inertia, coefficients and collision margin of a body."""
    body, port = plan.scene.bodies[place], made.port
    named: dict[str, Any] = {}
    if body.motion == "dynamic":
        # In maximal coordinates the inertia alone would make NaN: both go in one call.
        named |= {"mass": body.mass, "localInertiaDiagonal": plan.principal[place][0]}
    elif body.motion == "kinematic":
        named |= {"mass": plan.mass(place), "localInertiaDiagonal": [plan.mass(place)] * 3}
    law = plan.coefficients(body)
    named |= {"lateralFriction": law.friction, "restitution": law.restitution}
    named |= {"rollingFriction": law.rolling, "spinningFriction": law.torsional}
    if link >= 0 and plan.options["damping"] == "scene":
        named["jointDamping"] = 0.0
    if plan.touching and law.restitution > 0 and body.movable:
        named["contactProcessingThreshold"] = 0.0
        made.waiting.add((number, link))
    if maximal and body.movable and plan.solid and plan.swept and body.collision:
        named["ccdSweptSphereRadius"] = 0.8 * inner_radius(body)
    port.call("changeDynamics", number, link, **named)
    if plan.solid and "margin" in plan.settings.options and padded(body):
        if link < 0:
            port.call("changeDynamics", number, -1, collisionMargin=plan.options["margin"])
        else:
            text = f"body '{body.name}': its hull keeps the vendor's margin of 1 mm, which cannot be set on a link"
            made.notices.append(Notice(text))


def tell_multibody(plan: Plan, made: Assembly, number: int, place: int | None, maximal: bool) -> None:
    """What belongs to a whole multibody: damping, the clamp on velocities, sleeping.

    In calls without anything else: the binding turns a call with one of these to the base, whatever link it names.
    """
    port, body = made.port, None if place is None else plan.scene.bodies[place]
    prescribed = body is not None and body.motion == "kinematic"
    if plan.options["damping"] == "scene" or prescribed:
        port.call("changeDynamics", number, -1, linearDamping=0.0, angularDamping=0.0)
    if maximal and body is not None:
        port.call("changeDynamics", number, -1, activationState=port.bullet.ACTIVATION_STATE_DISABLE_SLEEPING)
        damping = damping_of(plan, body)
        if damping is not None:
            port.call("changeDynamics", number, -1, **damping)
    elif "velocity_limit" in plan.settings.options or prescribed:
        limit = LIFTED if prescribed else plan.options["velocity_limit"]
        port.call("changeDynamics", number, -1, maxJointVelocity=limit)
