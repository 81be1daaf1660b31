"""What joints carry, beyond the conformance checks: drives, dry friction, limits, turned trees, and what is left open."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.adapter.joints import turned_back
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.scene import WORLD, Body, Drive, Limits, Prismatic, Revolute, Scene, axis_angle
from plumbline.harness.trajectory import Floats, State
from plumbline.harness.trajectory.joint_states import JointStates
from plumbline.harness.trajectory.kinematics import angle_between
from tests.conformance.engines import adapter

ENGINES = ["mujoco", "bullet", "dart", "reference"]
ARM = Revolute(name="arm", parent=WORLD, child="a", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0))
BOB = Body(name="a", p_WB=(0.4, 0.0, 0.0), q_WB=axis_angle((1.0, 2.0, 3.0), 0.8))
MOMENT = 9.81 * 0.4


def told(engine: str, scene: Scene, steps: int = 20) -> Floats:
    """The reactions after some steps of a millisecond, of which the engine knew that it will be asked."""
    one = adapter(engine)
    with Engine(one, one.tracks["tuned"]).built(scene, dt=1e-3) as simulation:
        simulation.joint_states()  # type: ignore[attr-defined]
        simulation.step(steps)
        states: JointStates = simulation.joint_states()  # type: ignore[attr-defined]
    return states.reaction


@pytest.mark.parametrize("engine", ENGINES)
def test_a_motor_is_in_the_torque_along_its_axis(engine: str) -> None:
    arm = replace(ARM, drive=Drive(feedforward=-MOMENT))
    np.testing.assert_allclose(told(engine, Scene(bodies=(BOB,), joints=(arm,)))[0], (0, 0, 9.81, 0, -MOMENT, 0), atol=1e-2)


@pytest.mark.parametrize("engine", ENGINES)
def test_dry_friction_that_holds_is_in_the_torque_along_its_axis(engine: str) -> None:
    arm = replace(ARM, friction_loss=2 * MOMENT)
    # MuJoCo's dry friction creeps under load, within the softness of its constraints.
    reaction = told(engine, Scene(bodies=(BOB,), joints=(arm,)))[0]
    np.testing.assert_allclose(reaction, (0, 0, 9.81, 0, -MOMENT, 0), atol=0.03 * MOMENT)


@pytest.mark.parametrize("engine", ["mujoco", "dart", "reference"])
def test_a_limit_that_holds_is_in_the_torque_along_its_axis(engine: str) -> None:
    arm = replace(ARM, limits=Limits(lower=-1.0, upper=0.0))
    np.testing.assert_allclose(
        told(engine, Scene(bodies=(BOB,), joints=(arm,)), 500)[0], (0, 0, 9.81, 0, -MOMENT, 0), atol=0.02
    )


def test_bullet_leaves_open_what_a_limited_joint_carries() -> None:
    """pybullet tells no torque of a limit, and a reaction without it would be wrong where it holds."""
    arm = replace(ARM, limits=Limits(lower=-1.0, upper=0.0))
    assert np.isnan(told("bullet", Scene(bodies=(BOB,), joints=(arm,)))).all()


@pytest.mark.parametrize("engine", ENGINES)
def test_a_joint_whose_child_carries_its_parent_tells_of_the_child_about_its_anchor(engine: str) -> None:
    """The tree hangs on the child, which is welded by a drive without play: the parent pulls it down by its weight."""
    hinge = Revolute(name="hinge", parent="b", child="a", anchor_W=(0.7, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0))
    lower = Body(name="b", mass=3.0, p_WB=(0.7, 0.0, -0.5), q_WB=axis_angle((3.0, 1.0, 2.0), 1.1))
    held = replace(ARM, drive=Drive(stiffness=1e5, damping=1e3))
    reaction = told(engine, Scene(bodies=(BOB, lower), joints=(held, hinge)), 1000)
    np.testing.assert_allclose(reaction[1], (0, 0, -3 * 9.81, 0, 0, 0), atol=0.05)
    np.testing.assert_allclose(reaction[0], (0, 0, 4 * 9.81, 0, -(MOMENT + 3 * 9.81 * 0.7), 0), atol=0.1)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_slide_across_gravity_carries_weight_and_moment_about_the_child(engine: str) -> None:
    slide = Prismatic(name="slide", parent=WORLD, child="a", anchor_W=(0.1, 0.0, 0.0), axis_W=(1.0, 0.0, 0.0))
    reaction = told(engine, Scene(bodies=(BOB,), joints=(slide,)))[0]
    np.testing.assert_allclose(reaction, (0, 0, 9.81, 0, -9.81 * 0.3, 0), atol=1e-2)


@pytest.mark.parametrize("engine", ["bullet", "dart", "reference"])
def test_before_the_first_step_nothing_is_told_of_a_step(engine: str) -> None:
    one, scene = adapter(engine), Scene(bodies=(BOB,), joints=(ARM,))
    with Engine(one, one.tracks["tuned"]).built(scene, dt=1e-3) as simulation:
        assert np.isnan(simulation.joint_states().reaction).all()  # type: ignore[attr-defined]


def test_a_state_turned_back_is_where_a_uniform_motion_came_from() -> None:
    now = State(
        np.array([[1.0, 0.0, 0.0]]), np.array([axis_angle((0, 0, 1), 0.6)]), np.array([[2.0, 0, 0]]), np.array([[0, 0, 3.0]])
    )
    past = turned_back(now, 0.1)
    np.testing.assert_allclose(past.p_WB, [[0.8, 0.0, 0.0]], atol=1e-15)
    assert angle_between(past.q_WB[0], np.array(axis_angle((0, 0, 1), 0.3))) < 1e-7
