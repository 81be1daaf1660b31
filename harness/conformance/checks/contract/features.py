"""One probe for each feature: a scene or a call that an engine without the feature cannot honour."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import reduce
from operator import or_
from typing import Any

import numpy as np

from plumbline.harness.adapter import Feature, Simulation, Unsupported
from plumbline.harness.adapter.notice import as_notices
from plumbline.harness.conformance.check import Comparisons, NotApplicable, firm, said, that
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.conformance.frames import ORIGIN, X, Y, Z
from plumbline.harness.conformance.scenes import ball, block, damped, free, ground, prismatic, revolute, shaped, static, tie
from plumbline.harness.scene.body import Body, PlacedShape
from plumbline.harness.scene.joint import WORLD, Ball, Coupling, Drive, Fixed, Joint, Limits, MomentArm, Spring, Tendon
from plumbline.harness.scene.motion import Prescribed, Shift, Sinusoid
from plumbline.harness.scene.scene import Effect, Scene, Surface
from plumbline.harness.scene.sensor import Camera, Distortion
from plumbline.harness.scene.shape import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Plane, Shape, Sphere, TriangleMesh
from plumbline.harness.scene.values import Vector3

CORNERS = tuple((x, y, z) for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (-0.3, 0.3))
"""The corners of a box of half extents (.1, .2, .3) m."""

SIDES = (
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
)  # fmt: skip
"""The twelve triangles of a box on `CORNERS`, counter-clockwise seen from outside."""

TWO_BLOCKS = (
    tuple((x + shift, y, z) for shift in (-0.5, 0.5) for x, y, z in CORNERS),
    tuple((a + first, b + first, c + first) for first in (0, 8) for a, b, c in SIDES),
)
"""Vertices [m] and faces of two such boxes, 1 m apart along x, as one mesh that is not convex."""


def box_mesh(half_extents: Vector3, centre: Vector3) -> tuple[tuple[Vector3, ...], tuple[tuple[int, int, int], ...]]:
    """Vertices [m] and faces of a box about a centre, with faces as `SIDES`."""
    (a, b, c), (x, y, z) = half_extents, centre
    return tuple((x + i * a, y + j * b, z + k * c) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)), SIDES


def _shape(shape: Shape) -> Scene:
    """The shape on a moving body where it may move, above a sphere-free ground of its own kind."""
    if shape.type in {"plane", "triangle_mesh"}:
        return Scene(bodies=(static("ground", shape), free(p=Z)))
    return Scene(bodies=(shaped("body", shape, p_WB=Z),))


def _joint(joint: Joint) -> Scene:
    return Scene(bodies=(free("body", p=_BELOW),), joints=(joint,))


def _slide(**laws: Any) -> Scene:
    return _joint(prismatic("j", "body", _BELOW, X, **laws))


_BELOW: Vector3 = (0.0, 0.0, -1.0)
_RAIL = prismatic("j", "body", _BELOW, X)


def _loop() -> Scene:
    """Four bars, four hinges about y: two cranks on the world and a coupler."""
    bars = (free("left", p=(0.0, 0.0, 0.5)), free("top", p=(0.5, 0.0, 1.0)), free("right", p=(1.0, 0.0, 0.5)))
    pins = (("world", "left", ORIGIN), ("left", "top", Z), ("top", "right", (1, 0, 1)), ("world", "right", X))
    return Scene(bodies=bars, joints=tuple(revolute(f"{a}-{b}", b, p, Y, parent=a) for a, b, p in pins))


def _surface(**law: float) -> Scene:
    base = static("ground", Box(half_extents=(2.0, 2.0, 0.5)), p=(0.0, 0.0, -0.5))
    return Scene(bodies=(base, block()), surfaces=(Surface(between=("ground", "block"), **law),))


def _led(name: str, **fields: Any) -> Scene:
    """A plate that is moved, and a body above it."""
    plate = shaped(name, Box(half_extents=(1.0, 1.0, 0.1)), motion="kinematic", material="ground", **fields)
    return Scene(bodies=(plate, free(p=Z)))


def _no_rule() -> Scene:
    """Pair values 0, .4 and .8 that no rule of one number per material gives: not product, mean, least or greatest."""
    pairs = {("ground", "slab"): 0.0, ("ground", "block"): 0.8, ("slab", "block"): 0.4}
    return Scene(
        bodies=(
            static("ground", Box(half_extents=(5.0, 5.0, 0.5)), p=(0.0, 0.0, -0.5)),
            block("slab", half=(0.5, 0.5, 0.05), material="slab"),
            block("block", p=(0.0, 0.0, 0.15)),
        ),
        surfaces=tuple(Surface(between=p, static_friction=mu, kinetic_friction=mu) for p, mu in pairs.items()),
    )


_SCENES: Mapping[Feature, Callable[[], Scene]] = {
    Feature.SPHERE: lambda: _shape(Sphere(radius=0.1)),
    Feature.BOX: lambda: _shape(Box(half_extents=(0.1, 0.2, 0.3))),
    Feature.CAPSULE: lambda: _shape(Capsule(radius=0.1, half_length=0.2)),
    Feature.CYLINDER: lambda: _shape(Cylinder(radius=0.1, half_length=0.2)),
    Feature.ELLIPSOID: lambda: _shape(Ellipsoid(semi_axes=(0.1, 0.2, 0.3))),
    Feature.PLANE: lambda: _shape(Plane()),
    Feature.CONVEX_HULL: lambda: _shape(ConvexHull(vertices=CORNERS)),
    Feature.TRIANGLE_MESH: lambda: _shape(TriangleMesh(vertices=CORNERS, faces=SIDES)),
    Feature.MOVING_MESH: lambda: Scene(
        bodies=(static("ground", Plane()), shaped("body", TriangleMesh(vertices=TWO_BLOCKS[0], faces=TWO_BLOCKS[1]), p_WB=Z)),
        surfaces=(ground(),),
    ),
    Feature.COMPOUND: lambda: Scene(
        bodies=(shaped("body", *(PlacedShape(shape=Sphere(radius=0.1), p_BS=(x, 0.0, 0.0)) for x in (-0.2, 0.2))),)
    ),
    Feature.FULL_INERTIA: lambda: Scene(
        bodies=(Body(name="body", inertia=((0.3, 0.05, 0.02), (0.05, 0.4, 0.03), (0.02, 0.03, 0.5))),)
    ),
    Feature.KINEMATIC: lambda: _led("belt", v_WB=X),
    Feature.PRESCRIBED_MOTION: lambda: _led(
        "shaker", prescribed=Prescribed(shifts=(Shift(axis_W=X, motion=Sinusoid(amplitude=0.1, frequency=2.0)),))
    ),
    Feature.MASSLESS: lambda: Scene(
        bodies=(Body.between("between"), free("body", p=(0.0, 0.0, -1.0))),
        joints=(prismatic("first", "between", ORIGIN, X), replace(_RAIL, parent="between", axis_W=Y)),
    ),
    Feature.MASS_POINT: lambda: Scene(bodies=(free(moments=ORIGIN),)),
    Feature.FIXED: lambda: _joint(Fixed(name="j", parent=WORLD, child="body")),
    Feature.BALL: lambda: _joint(Ball(name="j", parent=WORLD, child="body", anchor_W=ORIGIN)),
    Feature.REVOLUTE: lambda: _joint(revolute("j", "body", ORIGIN, Y)),
    Feature.PRISMATIC: lambda: _slide(),
    Feature.DISTANCE: lambda: _joint(tie("j", "body", ORIGIN, (0.0, 0.0, -1.0))),
    Feature.DISTANCE_SPRING: lambda: _joint(
        tie("j", "body", ORIGIN, _BELOW, spring=Spring(stiffness=10.0, damping=1.0, rest=1.0))
    ),
    Feature.CLOSED_LOOP: _loop,
    Feature.LIMITS: lambda: _slide(limits=Limits(lower=-0.1, upper=0.1)),
    Feature.SPRINGS: lambda: _slide(spring=Spring(stiffness=10.0, damping=1.0)),
    Feature.DRIVES: lambda: _slide(drive=Drive(stiffness=10.0, damping=1.0, target=0.5)),
    Feature.ARMATURE: lambda: _joint(replace(_RAIL, armature=0.5)),
    Feature.FRICTION_LOSS: lambda: _joint(replace(_RAIL, friction_loss=0.5)),
    Feature.SPEED_LIMIT: lambda: _joint(replace(_RAIL, speed_limit=0.5)),
    Feature.COUPLING: lambda: Scene(
        bodies=(free("body", p=(0.0, 0.0, -1.0)), free("other", p=(0.0, 3.0, -1.0))),
        joints=(
            replace(_RAIL, coupling=Coupling(joint="other", ratio=2.0)),
            replace(_RAIL, name="other", child="other", anchor_W=(0.0, 3.0, -1.0)),
        ),
    ),
    Feature.FEEDFORWARD: lambda: _slide(drive=Drive(feedforward=1.0)),
    Feature.TENDON: lambda: replace(_slide(), tendons=(Tendon(name="t", arms=(MomentArm(joint="j", arm=2.0),)),)),
    Feature.PAIR_FRICTION: _no_rule,
    Feature.STATIC_FRICTION: lambda: _surface(static_friction=0.6, kinetic_friction=0.4),
    Feature.ROLLING_FRICTION: lambda: _surface(static_friction=0.5, kinetic_friction=0.5, rolling_friction=0.01),
    Feature.TORSIONAL_FRICTION: lambda: _surface(static_friction=0.5, kinetic_friction=0.5, torsional_friction=0.01),
    Feature.RESTITUTION: lambda: _surface(restitution=0.5),
    Feature.LINEAR_DAMPING: lambda: Scene(bodies=(damped(free(), linear=0.5),)),
    Feature.ANGULAR_DAMPING: lambda: Scene(bodies=(damped(free(), angular=0.5),)),
    Feature.CONTINUOUS_COLLISION: lambda: Scene(
        bodies=(static("ground", Box(half_extents=(2.0, 2.0, 0.01))), ball(p=(0.0, 0.0, 1.0), v=(0.0, 0.0, -300.0))),
        surfaces=(ground(),),
        widen=Effect.CONTINUOUS_COLLISION,
    ),
}
"""What each feature lets a scene say. CONTACT_FORCES and NATIVE_STEPS have no scene or call that could be refused."""


_CAMERA = Camera(name="camera", body=WORLD, rate=1.0, width=16, height=12, focal_x=10, focal_y=10, centre_x=8, centre_y=6)


def _ray(simulation: Simulation) -> None:
    simulation.cast(np.array([[0.0, 0.0, 5.0]]), np.array([[0.0, 0.0, -1.0]]), 10.0)


def _retimed(simulation: Simulation) -> None:
    """Raises: Unsupported, also of a simulation that has no such call."""
    if not hasattr(simulation, "retime"):
        raise Unsupported("retime", "the simulation offers none")
    simulation.retime(0.01)
    simulation.step()


_CALLS: Mapping[Feature, Callable[[Simulation], object]] = {
    Feature.CONTACTS: lambda simulation: simulation.contacts(),
    Feature.RAYS: _ray,
    Feature.RENDER: lambda simulation: simulation.render(_CAMERA),
    Feature.RAY_TRACING: lambda simulation: simulation.render(
        replace(_CAMERA, renderer="ray_traced", distortion=Distortion(k1=-0.01))
    ),
    Feature.WRENCH: lambda simulation: simulation.wrench(np.zeros((1, 3)), np.zeros((1, 3))),
    Feature.SAVE: lambda simulation: simulation.restore(simulation.save()),
    Feature.STEP_LENGTHS: _retimed,
}


PROBED = reduce(or_, (*_SCENES, *_CALLS))
"""The features that can be probed."""


class NotRefused(Exception):
    """Features that are not claimed and yet are not refused."""

    def __str__(self) -> str:
        return f"not claimed and yet not refused: {self.args[0]}; expected Unsupported"


class _Missing(Unsupported):
    """Not refused, but run without and said so: as good as a refusal for a means that is no law of the scene."""


def _runs_without_sweeping(simulation: Simulation) -> bool:
    """Does the engine say that it leaves out continuous collision?"""
    notices = as_notices(simulation.warnings())
    return any(notice.kind == "missing" and notice.effect is Effect.CONTINUOUS_COLLISION for notice in notices)


def _probe(engine: Engine, feature: Feature) -> None:
    """Use the feature; raises Unsupported where the engine refuses it."""
    if feature in _SCENES:
        with engine.built(_SCENES[feature](), None) as simulation:
            simulation.step()
            if feature is Feature.CONTINUOUS_COLLISION and _runs_without_sweeping(simulation):
                raise _Missing("continuous collision", "the engine runs without and says so")
    elif feature in _CALLS:
        bare = Scene(bodies=(free(),))
        with engine.built(bare, None) as simulation:
            simulation.step()
            _CALLS[feature](simulation)


def refused(engine: Engine, missing: Feature) -> str:
    """In words that the engine refuses each of these features, which it does not claim. Raises: NotRefused."""
    silent = []
    for feature in missing & PROBED:
        try:
            _probe(engine, feature)
        except Unsupported:
            continue
        silent.append(feature)
    if silent:
        raise NotRefused(", ".join(name for feature in silent for name in feature.names))
    return f"the engine does not claim {', '.join(missing.names)} and refuses it"


@firm("Does every claimed feature build and step?")
def claimed_features_build(engine: Engine) -> Comparisons:
    """Each claimed feature builds and steps."""
    for feature in engine.features:
        name = feature.names[0]
        try:
            _probe(engine, feature)
        except _Missing:
            continue  # whether it has to be there is the question of continuous_collision_stops_a_fast_ball
        except Exception as error:
            yield that(False, f"{name}: claimed, but {type(error).__name__}: {error}")
    yield said(f"{len(engine.features.names)} claimed features build and step")


@firm("Is every feature that is not claimed refused by Unsupported, never approximated in silence?")
def unclaimed_features_raise_unsupported(engine: Engine) -> Comparisons:
    """Each feature that is not claimed raises Unsupported where a scene or a call asks for it."""
    missing = ~engine.features
    if not missing.names:
        raise NotApplicable("the engine claims every feature")
    try:
        yield said(refused(engine, missing))
    except NotRefused as error:
        yield that(False, str(error))
