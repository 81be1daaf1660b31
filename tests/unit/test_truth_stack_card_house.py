"""The truth of stack_card_house by limit analysis of its scene, its geometry, its checks against houses that fall or stand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.cases.stack_card_house import CASE, GRIP, HALF, P, scene
from plumbline.harness.metrics.statics import critical_friction
from plumbline.harness.scene import Body, Scene, rotate
from plumbline.harness.trajectory import Floats, Trajectory
from tests.limit_analysis import GROUND, Point, stands


def corners(card: Body) -> Floats:
    """Of a card in the plane y = 0, (4, 2) m in W."""
    ends = [(x, 0.0, z) for x in (-HALF[0], HALF[0]) for z in (-HALF[2], HALF[2])]
    return np.array([np.array(card.p_WB)[[0, 2]] + np.array(rotate(card.q_WB, end))[[0, 2]] for end in ends])


def house_stands(stage: Scene, left: Body, right: Body, friction: float) -> bool:
    """On the lowest corner of each card, and where they meet at the top: on the face of either."""
    foot = [corners(card)[np.argmin(corners(card)[:, 1])] for card in (left, right)]
    top = corners(left)[np.argmax(corners(left)[:, 0])]
    np.testing.assert_allclose(top, corners(right)[np.argmin(corners(right)[:, 0])], atol=1e-12)
    points = [Point(GROUND, k, (float(foot[k][0]), float(foot[k][1])), (0.0, 1.0), friction) for k in (0, 1)]
    face = rotate(left.q_WB, (1.0, 0.0, 0.0))
    points.append(Point(0, 1, (float(top[0]), float(top[1])), (face[0], face[2]), GRIP))
    return stands([(c.p_WB[0], c.p_WB[2]) for c in (left, right)], [left.mass, right.mass], points)


@pytest.mark.parametrize("angle", [10.0, 20.0, 35.0])
@pytest.mark.parametrize("margin", [0.5, 0.1, 1e-4])
def test_the_firm_house_has_forces_to_stand_on_and_the_loose_one_has_none(angle: float, margin: float) -> None:
    stage = scene(P(margin, angle))
    for k, name in enumerate(("firm", "loose")):
        plate, left, right = stage.bodies[3 * k : 3 * k + 3]
        assert left.material == right.material == name
        friction = stage.surface(plate, left).static_friction
        assert house_stands(stage, left, right, friction) == (name == "firm")


def test_the_least_friction_by_bisection_is_the_closed_form_and_half_the_tangent_for_thin_cards() -> None:
    stage, angle = scene(P(angle=20.0)), math.radians(20.0)
    low, high = 0.0, 1.0
    while high - low > 1e-7:
        middle = (low + high) / 2
        low, high = (low, middle) if house_stands(stage, stage.bodies[1], stage.bodies[2], middle) else (middle, high)
    assert high == pytest.approx(critical_friction(angle, HALF[2], HALF[0]), abs=1e-6)
    assert critical_friction(angle, 1.0, 1e-9) == pytest.approx(math.tan(angle) / 2)


@pytest.mark.parametrize("angle", [10.0, 20.0, 35.0])
def test_cards_stand_on_their_plates_and_lean_on_each_other_alone(angle: float) -> None:
    stage = scene(P(angle=angle))
    for left, right in (stage.bodies[1:3], stage.bodies[4:6]):
        for card in (left, right):
            assert corners(card)[:, 1].min() == pytest.approx(0.0, abs=1e-14)
        assert corners(left)[:, 0].max() == pytest.approx(corners(right)[:, 0].min(), abs=1e-14)
        assert stage.collides(left, right)
    assert not stage.collides(stage.bodies[1], stage.bodies[4])
    assert not stage.collides(stage.bodies[1], stage.bodies[3])


def end(firm: bool, loose: bool) -> Trajectory:
    """Houses that fall flat half-way, or do not."""
    stage = scene(P())
    run = replace(Trajectory.of(np.linspace(0.0, CASE.duration, 9), len(stage.bodies)), dt=1 / 240)
    run.p_WB[:] = [b.p_WB for b in stage.bodies]
    for falls, cards in ((firm, (1, 2)), (loose, (4, 5))):
        if falls:
            run.p_WB[5:, cards, 2] = HALF[0]
    return run


def verdicts(run: Trajectory) -> dict[str, bool]:
    # The first check, that every state is finite, is every case's.
    return {c.metric.name: c.passes(c.metric(scene(P()), run), run.dt, CASE.parameters) for c in CASE.checks[1:]}


def test_the_loose_house_has_to_fall_and_the_firm_one_to_stand() -> None:
    assert verdicts(end(firm=False, loose=True)) == {"frame_friction_error": True, "frame_standing_time": True}
    assert verdicts(end(firm=False, loose=False)) == {"frame_friction_error": False, "frame_standing_time": True}
    assert verdicts(end(firm=True, loose=True)) == {"frame_friction_error": False, "frame_standing_time": False}
