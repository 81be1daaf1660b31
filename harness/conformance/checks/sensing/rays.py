"""Checks of rays against closed forms."""

from dataclasses import replace

import numpy as np

from plumbline.harness.adapter import Feature, Unsupported
from plumbline.harness.conformance.check import Comparisons, NotApplicable, check, firm, near, that
from plumbline.harness.conformance.closed_forms import first_hit
from plumbline.harness.conformance.engine import Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN, TURNED, X, Z, rotation
from plumbline.harness.conformance.scenes import ball, free, static, static_cube, without_gravity
from plumbline.harness.scene.body import PlacedShape
from plumbline.harness.scene.motion import axis_angle
from plumbline.harness.scene.scene import Scene
from plumbline.harness.scene.shape import Box, Capsule, Cylinder, Ellipsoid, Plane, Shape, Sphere
from plumbline.harness.scene.values import Vector3
from plumbline.harness.trajectory import Floats, Hits

_SHAPES: tuple[tuple[Feature, Shape, Vector3], ...] = (
    (Feature.SPHERE, Sphere(radius=0.5), (0.5, 0.5, 0.5)),
    (Feature.BOX, Box(half_extents=(0.3, 0.5, 0.8)), (0.3, 0.5, 0.8)),
    (Feature.CAPSULE, Capsule(radius=0.3, half_length=0.5), (0.3, 0.3, 0.8)),
    (Feature.CYLINDER, Cylinder(radius=0.4, half_length=0.6), (0.4, 0.4, 0.6)),
    (Feature.ELLIPSOID, Ellipsoid(semi_axes=(0.3, 0.5, 0.7)), (0.3, 0.5, 0.7)),
    (Feature.PLANE, Plane(), (0.0, 0.0, 0.0)),
)
"""Each with how far it reaches along its axes [m]."""


def _rays(count: int, seed: int) -> tuple[Floats, Floats]:
    """Rays in the frame of a shape: from a sphere of 3 m towards points within 0.6 m of the centre."""
    draw = np.random.default_rng(seed)
    origins = draw.normal(size=(count, 3))
    origins *= 3.0 / np.linalg.norm(origins, axis=1)[:, None]
    directions = draw.uniform(-0.6, 0.6, (count, 3)) - origins
    return origins, directions / np.linalg.norm(directions, axis=1)[:, None]


def _cast(engine: Engine, scene: Scene, origins: Floats, directions: Floats, reach: float) -> Hits:
    with engine.built(scene, None) as simulation:
        return simulation.cast(np.ascontiguousarray(origins), np.ascontiguousarray(directions), reach)


@check(
    "Do rays on turned shapes return the closed-form range?",
    Feature.RAYS,
    nothing="the engine claims rays but no shape with a closed form",
)
def rays_match_closed_forms(engine: Engine) -> Comparisons:
    for seed, (feature, shape, _) in enumerate(_SHAPES):
        if feature not in engine.features:
            continue
        origins, directions = _rays(200, seed)
        if feature is Feature.PLANE:
            origins[:, 2] = np.abs(origins[:, 2]) + 0.1
        expected = np.array([first_hit(shape, o, d) for o, d in zip(origins, directions, strict=True)])
        expected[expected > 50.0] = np.inf
        hits = _on_turned(engine, shape, origins, directions)
        if hits is None:
            continue
        same = np.isfinite(hits.distance) == np.isfinite(expected)
        both = np.isfinite(hits.distance) & np.isfinite(expected)
        greatest = float(np.abs(hits.distance[both] - expected[both]).max()) if both.any() else np.inf
        yield near(f"worst range error on a turned {shape.type} [m]", greatest, 0.0, 1e-5, "rounding in single precision")
        wrong = int((~same).sum())
        yield that(wrong <= 1, f"{shape.type}: got {wrong} of 200 rays hitting or missing wrongly, expected 1 at most, grazing")


def _on_turned(engine: Engine, shape: Shape, origins: Floats, directions: Floats) -> Hits | None:
    """What rays in the frame of a shape hit that stands turned elsewhere; None where the engine refuses the shape."""
    p_WT, R = (1.0, -2.0, 3.0), rotation(TURNED)
    scene = Scene(bodies=(static("target", shape, p=p_WT, q=TURNED),))
    try:
        return _cast(engine, scene, p_WT + origins @ R.T, directions @ R.T, 50.0)
    except Unsupported:
        return None


def _target(engine: Engine, x: float = 0.0) -> tuple[Scene, float]:
    """A wide target whose near face stands at x + 5 m, with rays along x in mind; the face's distance [m]."""
    if not engine.features & (Feature.BOX | Feature.SPHERE):
        raise NotApplicable("the engine claims neither a box nor a sphere to aim at")
    small, large = (
        Box(half_extents=(size, size, size)) if Feature.BOX in engine.features else Sphere(radius=size) for size in (0.1, 20.0)
    )
    return Scene(bodies=(static("other", small, p=(0.0, 0.0, 90.0)), static("target", large, p=(x + 25.0, 0.0, 0.0)))), 5.0


@firm("Is a hit beyond max_range a miss, and the next one within it a hit?", Feature.RAYS)
def ray_beyond_max_range_misses(engine: Engine) -> Comparisons:
    """The target's bounding volume lies within reach, its face beyond: culling bodies is not culling hits."""
    scene, face = _target(engine)
    o, d = np.zeros((2, 3)), np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    short = _cast(engine, scene, o, d, face - 0.1)
    long = _cast(engine, scene, o, d, face + 0.1)
    missed = bool(np.isinf(short.distance).all())
    yield that(missed, f"distances at a range of 4.9 m: got {short.distance}, expected inf: the face is at 5 m")
    yield that(bool((short.body == -1).all()), f"bodies at a range of 4.9 m: got {short.body}, expected -1")
    yield near("normals of misses", short.normal_W, np.zeros((2, 3)), 0.0, "zero where nothing is hit")
    yield near("distance at a range of 5.1 m [m]", long.distance[0], face, 1e-5)
    yield that(bool(np.isinf(long.distance[1])), f"distance the other way: got {long.distance[1]}, expected inf")


@check(
    "Does a ray that starts inside a solid meet its far side?",
    Feature.RAYS,
    nothing="the engine claims no solid with a closed form",
)
def ray_from_inside_meets_the_far_side(engine: Engine) -> Comparisons:
    """Along each axis of a turned solid from a point within it; a sensor in the housing of its carrier sees that housing."""
    for feature, shape, end in _SHAPES:
        if feature not in engine.features or feature is Feature.PLANE:
            continue
        far = np.array(end)
        # Off the centre by a fifth along the ray itself, so that both ends of an axis are told apart.
        directions = np.concatenate([np.eye(3), -np.eye(3)])
        origins = 0.2 * np.tile(far, 2)[:, None] * np.abs(directions)
        expected = np.concatenate([0.8 * far, 1.2 * far])
        hits = _on_turned(engine, shape, origins, directions)
        if hits is None:
            continue
        yield near(f"ranges from inside a {shape.type} [m]", hits.distance, expected, 1e-5, "rounding in single precision")
        outwards = directions @ rotation(TURNED).T
        yield near(f"normals from inside a {shape.type}", hits.normal_W, outwards, 1e-4, "outwards, along the ray")


@firm("Do hits name the body's place in the scene and the outward normal?", Feature.RAYS)
def ray_names_body_and_normal(engine: Engine) -> Comparisons:
    scene, face = _target(engine)
    hits = _cast(engine, scene, np.array([ORIGIN, (0.0, 0.0, 80.0)]), np.array([X, Z]), 50.0)
    yield that(hits.body.tolist() == [1, 0], f"bodies hit: got {hits.body.tolist()}, expected [1, 0], places in the scene")
    yield near("distances [m]", hits.distance, (face, 9.9), 1e-5)
    yield near("normals against the rays", hits.normal_W, [(-1, 0, 0), (0, 0, -1)], 1e-4, "unit, outwards")


@firm("Do rays meet what collides, not what is drawn?", Feature.RAYS | Feature.BOX)
def rays_meet_what_collides(engine: Engine) -> Comparisons:
    """Boxes of half a metre that are drawn smaller, larger, and not at all."""
    shown = {"smaller": (0.2,), "larger": (0.9,), "unseen": ()}
    bodies = []
    for k, (name, halves) in enumerate(shown.items()):
        drawn = tuple(PlacedShape(shape=Box(half_extents=(half, half, half))) for half in halves)
        bodies.append(replace(static_cube(name, 0.5, (5.0, 10.0 * k, 0.0)), visual=drawn))
    scene = Scene(bodies=tuple(bodies))
    o = np.array([[0.0, 10.0 * k, 0.0] for k in range(3)])
    hits = _cast(engine, scene, o, np.tile((1.0, 0.0, 0.0), (3, 1)), 50.0)
    yield near("ranges to boxes drawn smaller, larger and not at all [m]", hits.distance, (4.5, 4.5, 4.5), 1e-5)
    yield that(hits.body.tolist() == [0, 1, 2], f"bodies: got {hits.body.tolist()}, expected [0, 1, 2]")


@firm("Does every ray of a large batch get its answer?", Feature.RAYS)
def many_rays_all_answer(engine: Engine) -> Comparisons:
    """More rays than fit in a 16-bit count: a batch that is cut off drops the last ones without a word."""
    scene, face = _target(engine)
    count = 16_500
    o = np.zeros((count, 3))
    o[:, 1] = np.linspace(-0.05, 0.05, count)
    hits = _cast(engine, scene, o, np.tile((1.0, 0.0, 0.0), (count, 1)), 50.0)
    missed = int((~np.isfinite(hits.distance)).sum())
    yield that(len(hits.distance) == count, f"answers: got {len(hits.distance)}, expected {count}")
    yield that(missed == 0, f"rays without a hit: got {missed} of {count}, expected none")
    yield near("range of the first and the last ray [m]", hits.distance[[0, -1]], (face, face), 1e-3)


@firm("Do rays meet bodies where the state says they are?", Feature.RAYS | Feature.SPHERE)
def rays_see_the_present_state(engine: Engine) -> Comparisons:
    """A ball at 10 m/s is met where the state says it is, right after build and after a step, not one step behind."""
    dt, v, r = 0.01, 10.0, 0.1
    scene = without_gravity(ball(p=ORIGIN, v=(v, 0.0, 0.0), radius=r))
    o, d = np.array([[10.0, 0.0, 0.0]]), np.array([[-1.0, 0.0, 0.0]])
    with engine.built(scene, dt) as simulation:
        first = float(simulation.cast(o, d, 50.0).distance[0])
        simulation.step(3)
        later = float(simulation.cast(o, d, 50.0).distance[0])
    yield near("range before any step [m]", first, 10.0 - r, 1e-3)
    yield near("range after 3 steps [m]", later, 10.0 - r - 3 * v * dt, 5e-3, "one step behind would be .1 m off")


@firm("Do rays meet a shape that is turned on its body where the body has turned to?", Feature.RAYS | Feature.BOX)
def rays_meet_turned_shapes_of_a_body_that_turns(engine: Engine) -> Comparisons:
    """A box placed and turned on a body that flies and turns, before any step and after five, against its closed form.

    A cast that advances until it is within a millimetre of a convex shape (Bullet's: btGjkConvexCast.cpp, `radius`) ends up to
    that short of the surface along its normal, and short of the hit by that over the cosine of incidence. A step takes a
    surface by 10 mm and more.
    """
    shape, p_BS, q_BS = Box(half_extents=(0.3, 0.5, 0.8)), (0.2, -0.1, 0.3), axis_angle((1.0, 2.0, -2.0), 1.3)
    placed = PlacedShape(shape=shape, p_BS=p_BS, q_BS=q_BS)
    scene = without_gravity(replace(free(q=TURNED, v=(1.0, -2.0, 0.5), w=(3.0, -4.0, 5.0)), collision=(placed,)))
    origins, directions = _rays(100, 7)
    because = "what a convex cast stops short by, and rounding in single precision"
    with engine.built(scene, 0.01) as simulation:
        for count in (0, 5):
            simulation.step(count)
            state = state_of(simulation, scene)
            R_WB = rotation(state.q_WB[0])
            R_WS, p_WS = R_WB @ rotation(q_BS), state.p_WB[0] + R_WB @ p_BS
            hits = simulation.cast(np.ascontiguousarray(p_WS + origins), directions, 50.0)
            o_S, d_S = origins @ R_WS, directions @ R_WS
            expected = np.array([first_hit(shape, o, d) for o, d in zip(o_S, d_S, strict=True)])
            both = np.isfinite(expected) & np.isfinite(hits.distance)
            where_S = (o_S[both] + expected[both, None] * d_S[both]) / np.array(shape.half_extents)
            cosine = np.abs(np.take_along_axis(d_S[both], np.argmax(np.abs(where_S), axis=1)[:, None], axis=1)[:, 0])
            odd = int((np.isfinite(expected) != np.isfinite(hits.distance)).sum())
            greatest = float((np.abs(hits.distance[both] - expected[both]) * cosine).max(initial=0.0))
            text = f"after {count} steps: got {odd} of 100 rays that hit or miss wrongly"
            yield that(odd <= 1, f"{text}, expected 1 at most, grazing")
            yield near(f"worst error after {count} steps, along the normal [m]", greatest, 0.0, 1e-3 + 1e-5, because)


@firm("With two simulations open, do rays meet the bodies of their own?", Feature.RAYS)
def rays_ask_their_own_simulation(engine: Engine) -> Comparisons:
    """Two simulations are open at once, the target at 5 m in one and at 8 m in the other."""
    near_by, face = _target(engine)
    far_off, _ = _target(engine, 3.0)
    o, d = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]])
    with engine.built(near_by, None) as a, engine.built(far_off, None) as b:
        got = [float(simulation.cast(o, d, 50.0).distance[0]) for simulation in (a, b, a)]
    yield near("ranges in the one, the other and the one again [m]", got, (face, face + 3.0, face), 1e-4)
