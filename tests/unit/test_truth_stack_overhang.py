"""The truth of stack_overhang by limit analysis of its scene, and its checks against stacks that fall too early or never."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.cases.stack_overhang import CASE, FACTORS, P, scene
from plumbline.harness.metrics.statics import harmonic_overhang
from plumbline.harness.scene import Body, Box, Scene
from plumbline.harness.trajectory import Trajectory
from tests.limit_analysis import GROUND, Point, stands


def half(body: Body) -> tuple[float, float, float]:
    shape = body.collision[0].shape
    assert isinstance(shape, Box)
    return shape.half_extents


def stack_stands(stage: Scene, table: int, n: int) -> bool:
    """Of the n bricks after a table: each presses on both ends of the strip that it shares with what is below."""
    bodies = stage.bodies[table : table + n + 1]
    points = []
    for k in range(n):
        below, above = bodies[k], bodies[k + 1]
        left = max(below.p_WB[0] - half(below)[0], above.p_WB[0] - half(above)[0])
        right = min(below.p_WB[0] + half(below)[0], above.p_WB[0] + half(above)[0])
        assert below.p_WB[2] + half(below)[2] == pytest.approx(above.p_WB[2] - half(above)[2], abs=1e-12)
        z = above.p_WB[2] - half(above)[2]
        points += [Point(k - 1 if k else GROUND, k, (x, z), (0.0, 1.0), 0.5) for x in (left, right)]
    return stands([(b.p_WB[0], b.p_WB[2]) for b in bodies[1:]], [b.mass for b in bodies[1:]], points)


@pytest.mark.parametrize("n", [1, 2, 4, 10])
def test_stacks_within_the_harmonic_limit_stand_and_those_beyond_do_not(n: int) -> None:
    stage = scene(P(n=n, factors=(*FACTORS, 0.9999, 1.0001)))
    for i, factor in enumerate((*FACTORS, 0.9999, 1.0001)):
        table = i * (n + 1)
        assert not stage.bodies[table].movable
        reach = stage.bodies[table + n].p_WB[0] + half(stage.bodies[table + n])[0]
        assert reach == pytest.approx(factor * harmonic_overhang(n) * 2 * half(stage.bodies[table + 1])[0])
        assert stack_stands(stage, table, n) == (factor < 1)


def end(falls: set[float], sink: float = 0.0, dt: float = 1 / 240) -> Trajectory:
    """Stacks of these factors fall by a metre; the others sink by `sink` [m]."""
    stage = scene(P())
    run = replace(Trajectory.of(np.array([0.0, CASE.duration]), len(stage.bodies)), dt=dt)
    run.p_WB[:] = [b.p_WB for b in stage.bodies]
    for i, factor in enumerate(FACTORS):
        run.p_WB[-1, 5 * i + 1 : 5 * i + 5, 2] -= 1.0 if factor in falls else sink
    return run


def verdicts(run: Trajectory) -> dict[str, bool]:
    return {c.metric.name: c.passes(c.metric(scene(P()), run), run.dt, CASE.parameters) for c in CASE.checks}


@pytest.mark.parametrize("dt", CASE.ladder)
def test_an_engine_that_sinks_by_a_step_of_falling_passes(dt: float) -> None:
    assert all(verdicts(end({f for f in FACTORS if f > 1}, sink=9.81 * dt**2, dt=dt)).values())


@pytest.mark.parametrize("falls", [{f for f in FACTORS if f > 0.97}, {f for f in FACTORS if f > 1.03}, set(), set(FACTORS)])
def test_a_limit_that_is_one_bracket_off_fails(falls: set[float]) -> None:
    assert not verdicts(end(falls))["overhang_limit_error"]
