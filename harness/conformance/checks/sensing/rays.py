"""Checks of rays against closed forms."""

from dataclasses import replace

import numpy as np

from plumbline.harness.adapter import Adapter, Feature, Settings, Unsupported
from plumbline.harness.conformance.check import CheckResult, NotApplicable, check, judge, near, that
from plumbline.harness.conformance.room import built, state_of
from plumbline.harness.conformance.scenes import TURNED, ball, first_hit, free, rotation, static
from plumbline.harness.scene import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    PlacedShape,
    Plane,
    Scene,
    Shape,
    Sphere,
    axis_angle,
)
from plumbline.harness.trajectory import Floats, Hits

_SHAPES: tuple[tuple[Feature, Shape], ...] = (
    (Feature.SPHERE, Sphere(radius=0.5)),
    (Feature.BOX, Box(half_extents=(0.3, 0.5, 0.8))),
    (Feature.CAPSULE, Capsule(radius=0.3, half_length=0.5)),
    (Feature.CYLINDER, Cylinder(radius=0.4, half_length=0.6)),
    (Feature.ELLIPSOID, Ellipsoid(semi_axes=(0.3, 0.5, 0.7))),
    (Feature.PLANE, Plane()),
)


def _rays(count: int, seed: int) -> tuple[Floats, Floats]:
    """Rays in the frame of a shape: from a sphere of 3 m towards points within 0.6 m of the centre."""
    draw = np.random.default_rng(seed)
    origins = draw.normal(size=(count, 3))
    origins *= 3.0 / np.linalg.norm(origins, axis=1)[:, None]
    directions = draw.uniform(-0.6, 0.6, (count, 3)) - origins
    return origins, directions / np.linalg.norm(directions, axis=1)[:, None]


def _cast(adapter: Adapter, settings: Settings, scene: Scene, origins: Floats, directions: Floats, reach: float) -> Hits:
    with built(adapter, scene, settings) as simulation:
        return simulation.cast(np.ascontiguousarray(origins), np.ascontiguousarray(directions), reach)


@check("Do rays on turned shapes return the closed-form range?", Feature.RAYS)
def rays_match_closed_forms(adapter: Adapter, settings: Settings) -> CheckResult:
    comparisons, p_WT = [], np.array([1.0, -2.0, 3.0])
    R = rotation(TURNED)
    for seed, (feature, shape) in enumerate(_SHAPES):
        if feature not in adapter.features:
            continue
        origins, directions = _rays(200, seed)
        if feature is Feature.PLANE:
            origins[:, 2] = np.abs(origins[:, 2]) + 0.1
        expected = np.array([first_hit(shape, o, d) for o, d in zip(origins, directions, strict=True)])
        expected[expected > 50.0] = np.inf
        scene = Scene(bodies=(static("target", shape, p=(1.0, -2.0, 3.0), q=TURNED),))
        try:
            hits = _cast(adapter, settings, scene, p_WT + origins @ R.T, directions @ R.T, 50.0)
        except Unsupported:
            continue
        same = np.isfinite(hits.distance) == np.isfinite(expected)
        both = np.isfinite(hits.distance) & np.isfinite(expected)
        worst = float(np.abs(hits.distance[both] - expected[both]).max()) if both.any() else np.inf
        comparisons.append(
            near(f"worst range error on a turned {shape.type} [m]", worst, 0.0, 1e-5, "rounding in single precision")
        )
        wrong = int((~same).sum())
        comparisons.append(
            that(wrong <= 1, f"{shape.type}: got {wrong} of 200 rays hitting or missing wrongly, expected 1 at most, grazing")
        )
    if not comparisons:
        raise NotApplicable("the engine claims rays but no shape with a closed form")
    return judge(*comparisons)


def _target(adapter: Adapter, x: float = 0.0) -> tuple[Scene, float]:
    """A wide target whose near face stands at x + 5 m, with rays along x in mind; the face's distance [m]."""
    if Feature.BOX in adapter.features:
        return Scene(
            bodies=(
                static("other", Box(half_extents=(0.1, 0.1, 0.1)), p=(0.0, 0.0, 90.0)),
                static("target", Box(half_extents=(20.0, 20.0, 20.0)), p=(x + 25.0, 0.0, 0.0)),
            )
        ), 5.0
    if Feature.SPHERE in adapter.features:
        return Scene(
            bodies=(
                static("other", Sphere(radius=0.1), p=(0.0, 0.0, 90.0)),
                static("target", Sphere(radius=20.0), p=(x + 25.0, 0.0, 0.0)),
            )
        ), 5.0
    raise NotApplicable("the engine claims neither a box nor a sphere to aim at")


@check("Is a hit beyond max_range a miss, and the next one within it a hit?", Feature.RAYS, firm=True)
def ray_beyond_max_range_misses(adapter: Adapter, settings: Settings) -> CheckResult:
    """The target's bounding volume lies within reach, its face beyond: culling bodies is not culling hits."""
    scene, face = _target(adapter)
    o, d = np.zeros((2, 3)), np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    short = _cast(adapter, settings, scene, o, d, face - 0.1)
    long = _cast(adapter, settings, scene, o, d, face + 0.1)
    return judge(
        that(
            bool(np.isinf(short.distance).all()),
            f"distances at a range of 4.9 m: got {short.distance}, expected inf: the face is at 5 m",
        ),
        that(bool((short.body == -1).all()), f"bodies at a range of 4.9 m: got {short.body}, expected -1"),
        near("normals of misses", short.normal_W, np.zeros((2, 3)), 0.0, "zero where nothing is hit"),
        near("distance at a range of 5.1 m [m]", long.distance[0], face, 1e-5),
        that(bool(np.isinf(long.distance[1])), f"distance the other way: got {long.distance[1]}, expected inf"),
    )


@check("Does a ray that starts inside a solid meet its far side?", Feature.RAYS)
def ray_from_inside_meets_the_far_side(adapter: Adapter, settings: Settings) -> CheckResult:
    """Along each axis of a turned solid from a point within it; a sensor in the housing of its carrier sees that housing."""
    exits: dict[Feature, tuple[Shape, Floats]] = {
        Feature.SPHERE: (Sphere(radius=0.5), np.array([0.5, 0.5, 0.5])),
        Feature.BOX: (Box(half_extents=(0.3, 0.5, 0.8)), np.array([0.3, 0.5, 0.8])),
        Feature.CAPSULE: (Capsule(radius=0.3, half_length=0.5), np.array([0.3, 0.3, 0.8])),
        Feature.CYLINDER: (Cylinder(radius=0.4, half_length=0.6), np.array([0.4, 0.4, 0.6])),
        Feature.ELLIPSOID: (Ellipsoid(semi_axes=(0.3, 0.5, 0.7)), np.array([0.3, 0.5, 0.7])),
    }
    comparisons, p_WT, R = [], np.array([1.0, -2.0, 3.0]), rotation(TURNED)
    for feature, (shape, far) in exits.items():
        if feature not in adapter.features:
            continue
        scene = Scene(bodies=(static("target", shape, p=(1.0, -2.0, 3.0), q=TURNED),))
        # Off the centre by a fifth along the ray itself, so that both ends of an axis are told apart.
        directions = np.concatenate([np.eye(3), -np.eye(3)])
        origins = 0.2 * np.tile(far, 2)[:, None] * np.abs(directions)
        expected = np.concatenate([0.8 * far, 1.2 * far])
        try:
            hits = _cast(adapter, settings, scene, p_WT + origins @ R.T, directions @ R.T, 50.0)
        except Unsupported:
            continue
        comparisons.append(
            near(f"ranges from inside a {shape.type} [m]", hits.distance, expected, 1e-5, "rounding in single precision")
        )
        comparisons.append(
            near(f"normals from inside a {shape.type}", hits.normal_W, directions @ R.T, 1e-4, "outwards, along the ray")
        )
    if not comparisons:
        raise NotApplicable("the engine claims no solid with a closed form")
    return judge(*comparisons)


@check("Do hits name the body's place in the scene and the outward normal?", Feature.RAYS, firm=True)
def ray_names_body_and_normal(adapter: Adapter, settings: Settings) -> CheckResult:
    scene, face = _target(adapter)
    hits = _cast(
        adapter,
        settings,
        scene,
        np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 80.0]]),
        np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        50.0,
    )
    return judge(
        that(hits.body.tolist() == [1, 0], f"bodies hit: got {hits.body.tolist()}, expected [1, 0], places in the scene"),
        near("distances [m]", hits.distance, (face, 9.9), 1e-5),
        near("normals against the rays", hits.normal_W, [(-1, 0, 0), (0, 0, -1)], 1e-4, "unit, outwards"),
    )


@check("Do rays meet what collides, not what is drawn?", Feature.RAYS | Feature.BOX, firm=True)
def rays_meet_what_collides(adapter: Adapter, settings: Settings) -> CheckResult:
    """Boxes of half a metre that are drawn smaller, larger, and not at all."""
    shown = {"smaller": (0.2,), "larger": (0.9,), "unseen": ()}
    scene = Scene(
        bodies=tuple(
            replace(
                static(name, Box(half_extents=(0.5, 0.5, 0.5)), p=(5.0, 10.0 * k, 0.0)),
                visual=tuple(PlacedShape(shape=Box(half_extents=(half, half, half))) for half in halves),
            )
            for k, (name, halves) in enumerate(shown.items())
        )
    )
    o = np.array([[0.0, 10.0 * k, 0.0] for k in range(3)])
    hits = _cast(adapter, settings, scene, o, np.tile((1.0, 0.0, 0.0), (3, 1)), 50.0)
    return judge(
        near("ranges to boxes drawn smaller, larger and not at all [m]", hits.distance, (4.5, 4.5, 4.5), 1e-5),
        that(hits.body.tolist() == [0, 1, 2], f"bodies: got {hits.body.tolist()}, expected [0, 1, 2]"),
    )


@check("Does every ray of a large batch get its answer?", Feature.RAYS, firm=True)
def many_rays_all_answer(adapter: Adapter, settings: Settings) -> CheckResult:
    """More rays than fit in a 16-bit count: a batch that is cut off drops the last ones without a word."""
    scene, face = _target(adapter)
    count = 16_500
    o = np.zeros((count, 3))
    o[:, 1] = np.linspace(-0.05, 0.05, count)
    hits = _cast(adapter, settings, scene, o, np.tile((1.0, 0.0, 0.0), (count, 1)), 50.0)
    missed = int((~np.isfinite(hits.distance)).sum())
    return judge(
        that(len(hits.distance) == count, f"answers: got {len(hits.distance)}, expected {count}"),
        that(missed == 0, f"rays without a hit: got {missed} of {count}, expected none"),
        near("range of the first and the last ray [m]", hits.distance[[0, -1]], (face, face), 1e-3),
    )


@check("Do rays meet bodies where the state says they are?", Feature.RAYS | Feature.SPHERE, firm=True)
def rays_see_the_present_state(adapter: Adapter, settings: Settings) -> CheckResult:
    """A ball at 10 m/s is met where the state says it is, right after build and after a step, not one step behind."""
    dt, v, r = 0.01, 10.0, 0.1
    scene = Scene(bodies=(ball(p=(0.0, 0.0, 0.0), v=(v, 0.0, 0.0), radius=r),), gravity=(0.0, 0.0, 0.0))
    o, d = np.array([[10.0, 0.0, 0.0]]), np.array([[-1.0, 0.0, 0.0]])
    with built(adapter, scene, settings.with_dt(dt)) as simulation:
        first = float(simulation.cast(o, d, 50.0).distance[0])
        simulation.step(3)
        later = float(simulation.cast(o, d, 50.0).distance[0])
    return judge(
        near("range before any step [m]", first, 10.0 - r, 1e-3),
        near("range after 3 steps [m]", later, 10.0 - r - 3 * v * dt, 5e-3, "one step behind would be .1 m off"),
    )


@check("Do rays meet a shape that is turned on its body where the body has turned to?", Feature.RAYS | Feature.BOX, firm=True)
def rays_meet_turned_shapes_of_a_body_that_turns(adapter: Adapter, settings: Settings) -> CheckResult:
    """A box placed and turned on a body that flies and turns, before any step and after five, against its closed form.

    A cast that advances until it is within a millimetre of a convex shape (Bullet's: btGjkConvexCast.cpp, `radius`) ends up to
    that short of the surface along its normal, and short of the hit by that over the cosine of incidence. A step takes a
    surface by 10 mm and more.
    """
    shape, p_BS, q_BS = Box(half_extents=(0.3, 0.5, 0.8)), (0.2, -0.1, 0.3), axis_angle((1.0, 2.0, -2.0), 1.3)
    body = replace(
        free(q=TURNED, v=(1.0, -2.0, 0.5), w=(3.0, -4.0, 5.0)),
        collision=(PlacedShape(shape=shape, p_BS=p_BS, q_BS=q_BS),),
    )
    scene = Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0))
    comparisons, (origins, directions) = [], _rays(100, 7)
    with built(adapter, scene, settings.with_dt(0.01)) as simulation:
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
            worst = float((np.abs(hits.distance[both] - expected[both]) * cosine).max(initial=0.0))
            comparisons += [
                that(
                    odd <= 1,
                    f"after {count} steps: got {odd} of 100 rays that hit or miss wrongly, expected 1 at most, grazing",
                ),
                near(
                    f"worst error after {count} steps, along the normal [m]",
                    worst,
                    0.0,
                    1e-3 + 1e-5,
                    "what a convex cast stops short by, and rounding in single precision",
                ),
            ]
    return judge(*comparisons)


@check("With two simulations open, do rays meet the bodies of their own?", Feature.RAYS, firm=True)
def rays_ask_their_own_simulation(adapter: Adapter, settings: Settings) -> CheckResult:
    """Two simulations are open at once, the target at 5 m in one and at 8 m in the other."""
    near_by, face = _target(adapter)
    far_off, _ = _target(adapter, 3.0)
    o, d = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]])
    with built(adapter, near_by, settings) as near_simulation, built(adapter, far_off, settings) as far_simulation:
        got = [
            float(simulation.cast(o, d, 50.0).distance[0]) for simulation in (near_simulation, far_simulation, near_simulation)
        ]
    return judge(near("ranges in the one, the other and the one again [m]", got, (face, face + 3.0, face), 1e-4))
