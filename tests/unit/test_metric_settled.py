"""In how many of several starts all bodies have come to rest."""

from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from plumbline.cases import stack_stirred
from plumbline.harness.adapter import Adapter
from plumbline.harness.case.symmetries import BUILT, started
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.settled import settled_share, settled_share_high, settled_share_low
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Trajectory

SCENE = Scene(bodies=(Body(name="a"), Body(name="b", p_WB=(1.0, 0.0, 0.0))))
DT = 0.01


def run(*speeds: float) -> Trajectory:
    """Starts whose second body moves at these speeds [m/s] all the time; .0981 m/s is what one step of gravity gives."""
    first = replace(Trajectory.of(np.arange(5) * DT, 2), dt=DT)
    first.v_WB[:, 1, 2] = speeds[0]
    streams = {}
    for number, speed in enumerate(speeds[1:], 1):
        v_WB = np.zeros((5, 2, 3))
        v_WB[:, 1, 0] = speed
        streams |= {f"start_{number}/time": first.time, f"start_{number}/v_WB": v_WB}
    return replace(first, streams=streams)


@pytest.mark.parametrize(
    ("speeds", "share"),
    [((0.0, 0.0), 1.0), ((0.0, 0.1), 0.5), ((0.1, 0.0), 0.5), ((0.099, 0.098, 0.2, 0.0), 0.5), ((1.0, float("nan")), 0.0)],
)
def test_the_share_counts_starts_in_which_no_body_is_faster_than_a_step_of_gravity(
    speeds: tuple[float, ...], share: float
) -> None:
    assert settled_share(SCENE, run(*speeds)) == share


def test_a_half_lies_in_the_interval_of_two_of_eight_and_not_of_one() -> None:
    """Wilson: 2 of 8 is .071 to .591, 1 of 8 is .022 to .471."""
    two, lone = run(0.0, 0.0, *[1.0] * 6), run(0.0, *[1.0] * 7)
    assert settled_share_high(SCENE, two) == pytest.approx(0.591, abs=1e-3)
    assert settled_share_low(SCENE, two) == pytest.approx(0.071, abs=1e-3)
    assert settled_share_high(SCENE, lone) == pytest.approx(0.471, abs=1e-3)
    check = next(check for check in stack_stirred.CASE.checks if check.metric is settled_share_high)
    assert check.passes(0.591, DT, stack_stirred.P())
    assert not check.passes(0.471, DT, stack_stirred.P())


def test_one_start_alone_says_nothing() -> None:
    with pytest.raises(NotMeasurable, match="one start alone"):
        settled_share(SCENE, run(0.0))


def test_eight_starts_are_stirred_alike_and_differ_by_less_than_anybody_can_build() -> None:
    p = stack_stirred.P()
    scene, others = stack_stirred.scene(p), stack_stirred.retellings(p)
    assert [other.name for other in others] == [f"start_{k}" for k in range(1, 8)]
    assert all(other.control is not None and other.control.wrench is not None for other in others)
    places = np.array([[body.p_WB for body in told.scene.bodies] for told in others])
    off = np.abs(places - np.array([body.p_WB for body in scene.bodies]))
    assert 0 < off.max() <= BUILT * (1 + 1e-6)
    assert len(np.unique(places[:, 5, 0])) == 7
    assert off[:, [not body.movable for body in scene.bodies]].max() == 0.0


def test_what_hangs_on_joints_stays_whole() -> None:
    from plumbline.harness.scene import WORLD, Ball

    hung = replace(SCENE, joints=(Ball(name="pin", parent=WORLD, child="a", anchor_W=(0.0, 0.0, 1.0)),))
    bodies = started(hung, 3).scene.bodies
    assert bodies[0] == hung.bodies[0]
    assert bodies[1] != hung.bodies[1]


def test_another_start_is_pushed_as_the_case_is() -> None:
    """A force along x on a ball in flight moves it in the other start too."""
    from plumbline.harness.case.forces import Control
    from plumbline.harness.study import plugins
    from plumbline.harness.trial.equivalent_runs import equivalent_streams

    engine = cast("Adapter", plugins.adapter("reference"))
    control = Control(wrench=lambda _time, _state: (np.full((2, 3), 2.0), np.zeros((2, 3))))
    streams, remarks = equivalent_streams(
        started(replace(SCENE, gravity=(0.0, 0.0, 0.0)), 1, control), engine, engine.tracks["tuned"].with_dt(DT), 0.5, 0.1
    )
    assert remarks == ()
    np.testing.assert_allclose(streams["start_1/v_WB"][-1], np.full((2, 3), 1.0), rtol=1e-9)
