"""Times of impact against closed forms, and between all pairs of shapes that turn."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbline import engine
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.arena import float_table
from tests.engine_entries import measure_convex
from tests.swept_worlds import DT, SHAPES, bullet_of, world_of


def _impact(bodies: Sequence[engine.Body], span: float = DT) -> float:
    """The time of impact [s] of two bodies that go on with their velocities, by the engine's own search."""
    from plumbline.engine.swept.earliest import earliest_impact

    floats, ints = world_of(bodies).save()
    state = float_table(floats, ints, at.STATE)
    start = state.copy()
    for row in state:
        row[:3] += span * row[7:10]
        turn = Rotation.from_rotvec(span * row[10:]) * Rotation.from_quat(row[3:7], scalar_first=True)
        row[3:7] = turn.as_quat(scalar_first=True)
    shapes = len(float_table(floats, ints, at.SHAPE))
    path, bounds = np.zeros((len(start), 16)), np.zeros((shapes, 6))
    return float(earliest_impact(floats, ints, start, span, path, bounds, np.arange(shapes)))


@pytest.mark.parametrize("speed", [1.0, 20.0, 500.0])
def test_a_sphere_meets_a_plane_when_the_closed_form_says(speed: float) -> None:
    """t = (n . p - r) / (-n . v): the last steps are Newton's on a linear gap, exact to rounding of a length of 1 m."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        v = rng.normal(size=3)
        v *= -math.copysign(speed, float(v @ n)) / np.linalg.norm(v)
        height = rng.uniform(0.1, 0.9) * DT * -float(v @ n)
        p = (0.05 + height) * n
        plane = engine.Body(name="plane", motion="static", shapes=[engine.Placed(engine.Plane(n))])
        found = _impact([plane, bullet_of(engine.Sphere(0.05), p_WB=p, v_WB=v, w_WB=rng.normal(size=3) * 30)])
        assert found == pytest.approx(height / -float(v @ n), abs=1e-15 / -float(v @ n) + 1e-14)


@pytest.mark.parametrize("speed", [1.0, 20.0, 500.0])
def test_two_spheres_meet_at_the_root_of_their_quadratic(speed: float) -> None:
    """|p + v t| = r_A + r_B. A gap of rounding, 1e-15 m of way, is a time of that over the speed along the normal; the second
    root, where they would part, is no impact.
    """
    for seed in range(30):
        rng = np.random.default_rng(seed)
        ra, rb = rng.uniform(0.01, 0.1, 2)
        v = rng.normal(size=3)
        v *= speed / np.linalg.norm(v)
        n = np.cross(v, rng.normal(size=3))
        cosine = rng.uniform(0.05, 1.0)
        n = math.sqrt(1 - cosine**2) * n / np.linalg.norm(n) - cosine * v / speed
        p = (ra + rb) * n - rng.uniform(0.1, 0.9) * DT * v
        truth = float(np.roots([v @ v, 2 * p @ v, p @ p - (ra + rb) ** 2]).real.min())
        assert 0 < truth < DT
        for sign in (1, -1):
            one = bullet_of(engine.Sphere(ra), name="one", v_WB=-0.3 * sign * v)
            two = bullet_of(engine.Sphere(rb), name="two", p_WB=p, v_WB=0.7 * sign * v)
            found = _impact([one, two])
            if sign == 1:
                assert found == pytest.approx(truth, abs=1e-14 / (cosine * speed) + 1e-14)
            else:
                assert found == math.inf


@pytest.mark.parametrize("spin", [10.0, 100.0, 400.0])
def test_a_turning_rod_meets_a_post_when_its_angle_says(spin: float) -> None:
    """A capsule of radius r that turns about its middle meets a sphere of radius c at distance d when the distance of the
    sphere's centre from its axis, d sin(angle), is r + c. The gap is known to 1e-15 m at a speed of d w.
    """
    r, c, d, angle = 0.01, 0.004, 0.3, 0.9 * spin * DT
    rod = bullet_of(engine.Capsule(r, 0.5), q_WB=(math.sqrt(0.5), 0, math.sqrt(0.5), 0), w_WB=(0, 0, spin))
    place = (d * math.cos(angle), d * math.sin(angle), 0)
    post = engine.Body(name="post", motion="static", shapes=[engine.Placed(engine.Sphere(c))], p_WB=place)
    truth = (angle - math.asin((r + c) / d)) / spin
    if truth > 0:
        assert _impact([post, rod]) == pytest.approx(truth, abs=1e-13 / (d * spin) + 1e-13)


@pytest.mark.parametrize("draws", [4, pytest.param(8, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("one", "two"), list(itertools.combinations_with_replacement(SHAPES, 2)))
def test_every_pair_that_turns_touches_at_its_time_of_impact_and_not_before(one: str, two: str, draws: int) -> None:
    """The gap is zero at the time found and positive on the way there, sampled; where none is found it stays positive.

    The gap is measured apart from the search, and known to 2e-6 m for round shapes (the polytope of EPA), 1e-8 m otherwise.
    """
    slack = 2e-6
    hits = 0
    for seed in range(draws):
        rng = np.random.default_rng(100 + seed)
        v = rng.normal(size=3)
        v *= rng.uniform(20, 200) / np.linalg.norm(v)
        w = rng.normal(size=(2, 3)) * 60
        q = Rotation.random(2, random_state=rng)
        p = -v * rng.uniform(0.3, 0.9) * DT - 0.12 * v / np.linalg.norm(v) + rng.uniform(-0.05, 0.05, 3)
        bodies = [
            bullet_of(SHAPES[one], name="one", q_WB=q[0].as_quat(scalar_first=True), w_WB=w[0]),
            bullet_of(SHAPES[two], name="two", q_WB=q[1].as_quat(scalar_first=True), w_WB=w[1], p_WB=p, v_WB=v),
            engine.Body(name="far", p_WB=(9, 0, 0), shapes=[engine.Placed(engine.Cylinder(0.1, 0.1))]),
        ]
        found = _impact(bodies)
        times = np.linspace(0, min(found, DT), 60)
        floats, ints = engine.World(bodies).save()
        offset = float_table(floats, ints, at.SHAPE)[:, at.OFFSET : at.OFFSET + 3]
        poses = []
        for k, (place, speed) in enumerate(((np.zeros(3), np.zeros(3)), (p, v))):
            turns = [(Rotation.from_rotvec(t * w[k]) * q[k]).as_matrix() for t in times]
            poses.append(
                np.array([[*(place + t * speed + r @ offset[k]), *r.ravel()] for t, r in zip(times, turns, strict=True)])
            )
        out = np.empty((len(times), 10))
        measure_convex(floats, ints, 0, 1, poses[0], poses[1], out)
        if out[0, 0] <= 1e-6:
            continue
        assert out[:-1, 0].min() > -slack
        if found < DT:
            hits += 1
            assert abs(out[-1, 0]) < slack
    assert hits >= draws // 4
