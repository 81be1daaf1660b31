"""The truth of stack_tip_or_slide by limit analysis of each box, and its checks against wrong friction and wrong geometry."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.cases.stack_tip_or_slide import CASE, HALF, P, scene
from plumbline.harness.scene import Box, rotate, rotation_matrix
from plumbline.harness.trajectory import Trajectory
from tests.limit_analysis import GROUND, Point, stands

G = 9.81


@pytest.mark.parametrize(("rough", "slippery"), [(0.8, 0.3), (0.6, 0.45)])
def test_boxes_stand_below_their_threshold_and_not_above(rough: float, slippery: float) -> None:
    stage = scene(P(rough=rough, slippery=slippery))
    for incline, box in zip(stage.bodies[::2], stage.bodies[1::2], strict=True):
        assert stage.collides(incline, box)
        mu = stage.surface(incline, box).static_friction
        feet = [np.array(box.p_WB) + np.array(rotate(box.q_WB, (x, 0.0, -HALF[2]))) for x in (-HALF[0], HALF[0])]
        normal = rotate(box.q_WB, (0.0, 0.0, 1.0))
        points = [Point(GROUND, 0, (float(p[0]), float(p[2])), (normal[0], normal[2]), mu) for p in feet]
        held = stands([(box.p_WB[0], box.p_WB[2])], [box.mass], points)
        slope = math.tan(math.acos(normal[2]))
        assert held == (slope < min(mu, HALF[0] / HALF[2]))
        # With all the friction in the world only tipping is left; with feet as wide as a table, only sliding.
        glued = [replace(p, friction=100.0) for p in points]
        assert stands([(box.p_WB[0], box.p_WB[2])], [box.mass], glued) == (slope < HALF[0] / HALF[2])


def test_boxes_touch_their_own_incline_alone_and_have_room_to_slide() -> None:
    stage = scene(P())
    for place, box in enumerate(stage.bodies):
        if box.movable:
            incline = stage.bodies[place - 1]
            shape = incline.collision[0].shape
            assert isinstance(shape, Box)
            local = np.array(rotation_matrix(incline.q_WB)).T @ (np.array(box.p_WB) - np.array(incline.p_WB))
            assert local[2] == pytest.approx(shape.half_extents[2] + HALF[2], abs=1e-12)
            way = G * math.tan(0.5) * CASE.duration**2 / 2
            assert abs(local[0]) + HALF[0] + 0.1 * way < shape.half_extents[0]
            assert [b.name for b in stage.bodies if stage.collides(box, b) and abs(b.p_WB[1] - box.p_WB[1]) < 0.9] == [
                incline.name
            ]


def engine(rough: float = 0.8, slippery: float = 0.3, tips_at: float = 0.5) -> Trajectory:
    """Each box at rest, sliding by Coulomb's law, or fallen over, under these frictions and this threshold of tipping."""
    stage, time = scene(P()), np.linspace(0.0, CASE.duration, 7)
    run = replace(Trajectory.of(time, len(stage.bodies)), dt=1 / 240)
    for place, body in enumerate(stage.bodies):
        run.p_WB[:, place], run.q_WB[:, place] = body.p_WB, body.q_WB
        if not body.movable:
            continue
        mu = rough if "rough" in body.name else slippery
        along = np.array(rotate(body.q_WB, (1.0, 0.0, 0.0)))
        angle = math.asin(-along[2])
        if math.tan(angle) > tips_at and tips_at <= mu:
            run.q_WB[-1, place] = (0.0, 1.0, 0.0, 0.0)
        elif math.tan(angle) > mu:
            run.p_WB[:, place] += np.outer(G * (math.sin(angle) - mu * math.cos(angle)) * time**2 / 2, along)
    return run


def verdicts(run: Trajectory) -> dict[str, bool]:
    # The first check, that every state is finite, is every case's.
    return {c.metric.name: c.passes(c.metric(scene(P()), run), run.dt, CASE.parameters) for c in CASE.checks[1:]}


def test_an_engine_that_does_as_statics_says_passes() -> None:
    assert all(verdicts(engine()).values())


@pytest.mark.parametrize("tips_at", [0.485, 0.515])
def test_boxes_that_tip_too_early_or_too_late_fail(tips_at: float) -> None:
    assert verdicts(engine(tips_at=tips_at)) == {"tipping_angle_error": False, "wrong_fates": False}


@pytest.mark.parametrize(("rough", "slippery"), [(0.4, 0.3), (0.8, 0.28), (0.8, 0.32), (0.8, 0.6)])
def test_wrong_friction_gives_wrong_fates(rough: float, slippery: float) -> None:
    assert not verdicts(engine(rough=rough, slippery=slippery))["wrong_fates"]
