"""Cams with facets: their closed form by another route, polyhedra by counting, what they cost by sampling, planted faults."""

import math
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases.system_level_of_detail import (
    CASE,
    ECCENTRICITY,
    HALF,
    RADIUS,
    P,
    expected,
    inner,
    polyhedron,
    scene,
)
from plumbline.harness.metrics.overlaps import cam_follower_gap
from plumbline.harness.scene import EARTH_GRAVITY, ConvexHull
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import rotate

G, RATE = -EARTH_GRAVITY[2], P().rate
TIME = np.arange(round(CASE.duration * 240) + 1) / 240
PARTS = (1, 2, 4, 8, 16)


def ride(facets: float = 320, told: float | None = None) -> Trajectory:
    """An engine that keeps each follower on the highest corner of its cam. Args: told: facets of the cams, where others."""
    parameters: dict[str, Any] = {"facets": facets if told is None else told}
    run = expected(TIME, P())
    for place, cam in enumerate(scene(P(**parameters)).bodies[::2]):
        placed = cam.collision[0]
        assert isinstance(placed.shape, ConvexHull)
        corners = np.array(placed.p_BS) + rotate(np.array(placed.q_BS), np.array(placed.shape.vertices))
        path = rotate(run.q_WB[:, 2 * place, None], corners[None])
        highest = np.argmax(path[:, :, 2], axis=1)
        at = path[np.arange(len(TIME)), highest]
        run.p_WB[:, 2 * place + 1, 2] = at[:, 2] + HALF[2]
        run.v_WB[:, 2 * place + 1, 2] = RATE * at[:, 0]
    return replace(run, dt=CASE.dt)


def errors(run: Trajectory) -> Floats:
    """Of the heights of followers, (t, n) m."""
    off: Floats = (run.p_WB - expected(run.time, P()).p_WB)[:, 1::2, 2]
    return off


def verdicts(run: Trajectory, **parameters: Any) -> dict[str, bool]:
    chosen = dict(CASE.parameters) | parameters
    stage, truth = scene(P(**chosen)), expected(run.time, P(**chosen))
    return {c.metric.name: c.passes(c.metric(stage, run, truth), run.dt, CASE.at(**chosen)) for c in CASE.checks}


@pytest.mark.parametrize("parts", [*PARTS, 3])
def test_a_polyhedron_is_closed_with_its_corners_on_the_ball_and_its_faces_outward(parts: int) -> None:
    """By Euler's formula 10 parts^2 + 2 corners go with 20 parts^2 triangles; each edge is run through once in each way."""
    corners, faces = polyhedron(parts)
    assert (len(corners), len(faces)) == (10 * parts**2 + 2, 20 * parts**2)
    np.testing.assert_allclose(np.linalg.norm(corners, axis=1), 1.0, atol=1e-15)
    edges = Counter((int(f[k]), int(f[(k + 1) % 3])) for f in faces for k in range(3))
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    assert (np.linalg.det(corners[faces]) > 0).all()


def test_the_inner_ball_is_the_least_that_a_face_rests_at_and_its_gap_falls_fourfold() -> None:
    """Resting places of a face are the support function's values; the least of many is the radius of the inner ball.

    20000 directions lie .02 rad or less from any other, within which the height changes by sin(c) of that at most.
    """
    drawn = np.random.default_rng(0).normal(size=(20_000, 3))
    drawn /= np.linalg.norm(drawn, axis=1, keepdims=True)
    lost = []
    for parts in PARTS:
        least = (drawn @ polyhedron(parts)[0].T).max(axis=1).min()
        assert inner(parts) <= least <= inner(parts) + 0.02 * math.sqrt(1 - inner(parts) ** 2)
        lost.append(1 - inner(parts))
    falls = np.array(lost[:-1]) / lost[1:]
    assert (np.diff(falls) > 0).all()
    assert falls[-1] == pytest.approx(4.0, rel=0.01)
    # The icosahedron's, by hand: inradius over circumradius.
    assert inner(1) == pytest.approx(math.sqrt((5 + 2 * math.sqrt(5)) / 15), rel=1e-12)


def test_a_follower_pressed_by_a_spring_goes_as_the_closed_form_says() -> None:
    """The centre's way c' = w x c, and the face of 1 kg on a damped contact of 1e7 N/m over it, by a stiff method.

    The contact gives way by (g + e W^2)/k, 1e-6 m, and as much again while it takes up the load.
    """
    stiffness, damping = 1e7, 6e3

    def rates(_time: float, y: Floats) -> list[float]:
        along, up, face, speed = y
        deep, closing = up + RADIUS - face, RATE * along - speed
        push = max(stiffness * deep + damping * closing, 0.0) if deep > 0 else 0.0
        return [-RATE * up, RATE * along, speed, push - G]

    truth = expected(TIME, P())
    start = [ECCENTRICITY, 0.0, truth.p_WB[0, 1, 2] - HALF[2], truth.v_WB[0, 1, 2]]
    found = solve_ivp(rates, (0.0, TIME[-1]), start, method="LSODA", t_eval=TIME, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.y[2], truth.p_WB[:, 1, 2] - HALF[2], atol=2e-6)


@pytest.mark.parametrize("parts", [32, pytest.param(64, marks=pytest.mark.slow)])
def test_the_highest_of_a_finely_cut_ball_is_where_the_closed_form_says(parts: int) -> None:
    """Every turn of every cam: the top of 20 parts^2 facets, no further below the face than told: 7e-6 m at 64."""
    truth = expected(TIME[::60], P())
    corners = np.array([ECCENTRICITY, 0.0, 0.0]) + RADIUS * polyhedron(parts)[0]
    for place in range(0, len(truth.p_WB[0]), 2):
        tops = [rotate(q, corners)[:, 2].max() + HALF[2] for q in truth.q_WB[:, place]]
        low = truth.p_WB[:, place + 1, 2] - tops
        assert (low > -1e-12).all()
        assert (low < RADIUS * (1 - inner(parts)) + 1e-12).all()


@pytest.mark.parametrize("parameters", [{}, {"facets": 20}, {"geometry": "ball"}, {"geometry": "mesh", "n": 3, "rate": -1.0}])
def test_followers_start_in_touch(parameters: dict[str, Any]) -> None:
    stage = scene(P(**parameters))
    start = Trajectory.of(np.zeros(1), len(stage.bodies))
    start.p_WB[:], start.q_WB[:] = [b.p_WB for b in stage.bodies], [b.q_WB for b in stage.bodies]
    assert cam_follower_gap(stage, start, None) < 1e-12


def test_no_follower_ever_leaves_its_cam() -> None:
    """A corner goes down by less than gravity would take the face: (e + r) W^2 < g."""
    assert (ECCENTRICITY + RADIUS) * RATE**2 < 0.1 * G


def test_an_engine_that_adds_nothing_passes_and_errs_by_what_is_derived() -> None:
    """On great circles that cross facets anyhow most of r (1 - cos(c)) is reached, and the mean falls fourfold too."""
    spread = []
    for parts in PARTS[:4]:
        run = ride(20 * parts**2)
        assert all(verdicts(run, facets=20 * parts**2).values())
        off = errors(run)
        assert off.max() < 1e-12
        assert 0.7 < -off.min() / (RADIUS * (1 - inner(parts))) <= 1.0
        spread.append(math.sqrt(float(np.mean(off**2))))
    np.testing.assert_allclose(np.array(spread[:-1]) / spread[1:], 4.0, rtol=0.15)


def test_cams_coarser_than_told_fail() -> None:
    found = verdicts(ride(320, told=80))
    assert found == {"divergence": True, "cam_follower_gap": False, "position_error_max": False}


@pytest.mark.parametrize("off", [-3e-3, 3e-3])
def test_a_follower_that_stands_off_or_sinks_in_fails(off: float) -> None:
    run = ride()
    run.p_WB[100, 3, 2] += off
    assert not verdicts(run)["cam_follower_gap"]


def test_a_number_that_is_not_finite_is_not_swallowed() -> None:
    run = ride()
    run.p_WB[5, 1, 2] = math.nan
    assert not any(verdicts(run).values())


def test_an_unknown_geometry_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="geometry 'egg', expected ball, hull or mesh"):
        scene(P(geometry="egg"))
