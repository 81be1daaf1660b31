"""A run whose numbers are finite and mean nothing has diverged; one that a strong source moves has not."""

from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter import Diverged
from plumbline.harness.scene import Body, Drive, Prismatic, Revolute, Scene
from plumbline.harness.scene.joint import Limits
from plumbline.harness.trajectory import State
from plumbline.harness.trajectory.pace import Pace
from plumbline.harness.trial.simulate import TIMES, TIMES_UNLIMITED, EnergyLimit, simulate

BALL = Scene(bodies=(Body.ball("ball", 0.1, 2.0, touches=False, v_WB=(3.0, 0.0, 0.0)),))


def slide(**drive: Any) -> Scene:
    joint = Prismatic(
        name="slide", parent="world", child="ball", anchor_W=(0, 0, 0), axis_W=(1, 0, 0), limits=Limits(), drive=Drive(**drive)
    )
    return Scene(bodies=(Body.ball("ball", 0.1, 2.0, touches=False),), joints=(joint,), gravity=(0, 0, 0))


def moving(scene: Scene, speed: float) -> State:
    state = State.initial(scene)
    state.v_WB[:] = (speed, 0.0, 0.0)
    return state


def test_what_can_be_there_is_the_start_and_a_fall_for_all_of_the_run() -> None:
    """9 J at 3 m/s, and a fall of 1 s from there: 2 kg (3 + 9.81)^2 / 2."""
    limit = EnergyLimit.of(BALL, 1.0)
    assert limit.payable == pytest.approx(9.0 + 12.81**2)
    assert limit.most == pytest.approx(TIMES * limit.payable)
    edge = float(np.sqrt(limit.most))  # m v^2 / 2 with 2 kg
    limit.check(moving(BALL, 0.999 * edge))
    with pytest.raises(Diverged, match=r"kinetic energy .* J, more than 1e\+06 times the 173 J"):
        limit.check(moving(BALL, 1.001 * edge))


def test_what_turns_counts_by_its_moments_of_inertia() -> None:
    limit, state = EnergyLimit.of(BALL, 1.0), State.initial(BALL)
    state.w_WB[:] = (0.0, 0.0, np.sqrt(2 * limit.most / (0.4 * 2.0 * 0.1**2)) * 1.001)
    with pytest.raises(Diverged):
        limit.check(state)


def test_a_limited_drive_gives_its_limit_all_the_time() -> None:
    """5 N on 2 kg for 3 s: 7.5 m/s, 56.25 J. A constant force is its own limit."""
    for drive in ({"stiffness": 1e6, "limit": 5.0}, {"feedforward": -5.0}):
        limit = EnergyLimit.of(slide(**drive), 3.0)
        assert limit.payable == pytest.approx(56.25)
        assert limit.most == pytest.approx(TIMES * 56.25)


def test_where_a_source_has_no_limit_there_is_more_room() -> None:
    led = Scene(bodies=(Body(name="belt", motion="kinematic", v_WB=(1.0, 0.0, 0.0)), *BALL.bodies))
    for scene in (slide(stiffness=100.0, target=0.1), slide(damping=1.0, target_velocity=2.0), led):
        limit = EnergyLimit.of(scene, 1.0)
        assert limit.most == pytest.approx(TIMES_UNLIMITED * limit.payable)
    pushed = EnergyLimit.of(BALL, 1.0, pushed=True)
    assert pushed.most / EnergyLimit.of(BALL, 1.0).most == pytest.approx(TIMES_UNLIMITED / TIMES)


def test_where_nothing_is_in_play_nothing_is_said() -> None:
    hinge = Revolute(name="hinge", parent="world", child="ball", anchor_W=(0, 0, 0), axis_W=(0, 0, 1))
    still = Scene(bodies=(Body.ball("ball", 0.1, touches=False),), joints=(hinge,), gravity=(0, 0, 0))
    EnergyLimit.of(still, 1.0).check(moving(still, 1e300))


class Runaway:
    """A ball that each step makes ten times as fast: finite for three hundred steps."""

    def __init__(self) -> None:
        self.steps = 0

    def step(self, count: int = 1) -> None:
        self.steps += count

    def state(self, out: State) -> None:
        out.v_WB[:] = (3.0 * 10.0**self.steps, 0.0, 0.0)


def test_a_blow_up_of_finite_numbers_is_diverged_with_its_step() -> None:
    """1e6 times 173 J is 13 km/s: four steps of ten times from 3 m/s are 30 km/s."""
    pace = Pace.of(None, 0.01)
    told = {"duration": 1.0, "sample_interval": 0.0, "with_contacts": False, "seed": 0}
    run, broke = simulate(Runaway(), BALL, pace=pace, **told)  # type: ignore[arg-type]
    assert broke is not None
    assert broke.startswith("by step 5 of 100 (t = 0.04 s): kinetic energy 9e+08 J, more than 1e+06 times")
    assert len(run) == 4
    assert run.finite
