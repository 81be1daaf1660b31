"""Coordinates and rates of joints read off poses, and the reading of a running simulation, by the engine or by the poses."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.adapter.joints import joints_of
from plumbline.harness.adapter.what_comes_out import Answering, BrokenContract
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.scene import WORLD, Ball, Body, Distance, Prismatic, Revolute, Scene, Spring, axis_angle
from plumbline.harness.trajectory import State
from plumbline.harness.trajectory.joint_states import JointStates, joint_states
from tests.conformance.engines import adapter

PIN = Revolute(name="pin", parent=WORLD, child="a", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 0.0, 1.0), position=0.25)
SLIDE = Prismatic(name="slide", parent="a", child="b", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.6, 0.8, 0.0), position=-1.0)
ROD = Distance(
    name="rod", parent=WORLD, child="b", anchor_W=(0.0, 0.0, 2.0), child_anchor_W=(1.0, 0.0, 0.0), spring=Spring(stiffness=1.0)
)
SCENE = Scene(
    bodies=(
        Body(name="a", w_WB=(0.0, 0.0, 3.0)),
        Body(name="b", p_WB=(1.0, 0.0, 0.0), v_WB=(0.0, 3.0, 0.0), w_WB=(0.0, 0.0, 3.0)),
    ),
    joints=(PIN, SLIDE, ROD, Ball(name="ball", parent="a", child="b", anchor_W=(0.0, 0.0, 0.0))),
)


def test_the_start_has_the_positions_of_the_scene_and_rates_of_child_over_parent() -> None:
    found = joint_states(SCENE, State.initial(SCENE))
    # The carried slide rests on its turning parent; the end of the rod goes across it.
    assert found.coordinate[:3] == pytest.approx((0.25, -1.0, np.sqrt(5.0)), abs=1e-15)
    assert found.rate[:3] == pytest.approx((3.0, 0.0, 0.0), abs=1e-15)
    assert np.isnan([found.coordinate[3], found.rate[3], *found.reaction.ravel()]).all()


def test_rates_are_the_derivatives_of_coordinates_along_a_motion() -> None:
    """Both bodies turn by 3 rad/s, b slides out at .5 m/s along the axis that a carries: central differences over 2e-5 s."""
    times, out = (0.4 - 1e-5, 0.4, 0.4 + 1e-5), 0.5
    states = []
    for t in times:
        q = axis_angle((0.0, 0.0, 1.0), 3.0 * t)
        c, s = np.cos(3.0 * t), np.sin(3.0 * t)
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        p = R @ (np.array([1.0, 0.0, 0.0]) + out * t * np.array([0.6, 0.8, 0.0]))
        v = np.cross((0.0, 0.0, 3.0), p) + out * (R @ (0.6, 0.8, 0.0))
        states.append(
            State(np.array([np.zeros(3), p]), np.array([q, q]), np.array([np.zeros(3), v]), np.tile((0, 0, 3.0), (2, 1)))
        )
    before, now, after = (joint_states(SCENE, state) for state in states)
    slope = (after.coordinate - before.coordinate) / 2e-5
    # Second order: the third derivatives, below 100 /s3, times 1e-10 / 6; rounding 1e-16/1e-5.
    assert now.rate[:3] == pytest.approx(slope[:3], abs=1e-8)
    assert now.rate[:2] == pytest.approx((3.0, out), abs=1e-12)


def test_an_angle_is_told_on_the_branch_that_is_named() -> None:
    state = State.initial(SCENE)
    near = np.array([0.25 + 6 * np.pi + 0.1, 0.0, 0.0, np.nan])
    assert joint_states(SCENE, state, near).coordinate[0] == pytest.approx(0.25 + 6 * np.pi, abs=1e-12)
    assert joint_states(SCENE, state, near).coordinate[1] == -1.0


@pytest.mark.parametrize("engine", ["mujoco", "bullet", "dart"])
def test_the_harness_reads_what_the_engine_says_and_fills_in_the_rest_by_the_poses(engine: str) -> None:
    scene = replace(SCENE, joints=(PIN, replace(SLIDE, spring=Spring(stiffness=100.0, rest=-1.0)), ROD))
    one = adapter(engine)
    with Engine(one, one.tracks["tuned"]).built(scene, dt=1e-3) as simulation:
        simulation.step(50)
        answering = Answering(simulation, scene)
        read = joints_of(answering, scene)  # type: ignore[arg-type]
        state = State.empty(2)
        simulation.state(state)
        own = answering.joint_states()
    meant = joint_states(scene, state)
    np.testing.assert_array_equal(read.coordinate[:2], own.coordinate[:2])
    np.testing.assert_allclose(read.coordinate, meant.coordinate, atol=1e-12)
    np.testing.assert_allclose(read.rate, meant.rate, atol=1e-11)


@pytest.mark.parametrize("engine", ["mujoco", "bullet", "dart", "reference"])
def test_reading_the_joints_leaves_the_motion_as_it_is(engine: str) -> None:
    one = adapter(engine)
    scene = replace(SCENE, joints=(PIN, replace(SLIDE, spring=Spring(stiffness=100.0, rest=-1.0))))
    unread = Engine(one, one.tracks["tuned"]).record(scene, 0.05, dt=1e-3)
    with Engine(one, one.tracks["tuned"]).built(scene, dt=1e-3) as simulation:
        for _ in range(50):
            simulation.step()
            joints_of(simulation, scene)
        state = State.empty(2)
        simulation.state(state)
    np.testing.assert_array_equal(state.p_WB, unread.p_WB[-1])
    np.testing.assert_array_equal(state.w_WB, unread.w_WB[-1])


def test_what_an_engine_says_of_joints_is_checked() -> None:
    class Short:
        def joint_states(self) -> JointStates:
            return JointStates(np.zeros(2), np.zeros(2), np.zeros((2, 6)))

    with pytest.raises(BrokenContract, match=r"joint_states\(\)\.coordinate: got float64 \(2,\)"):
        Answering(Short(), SCENE).joint_states()  # type: ignore[arg-type]
