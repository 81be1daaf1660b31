"""Where Euler bears a drive's damping as an actuator's (kv) in MuJoCo, in its own words, and where it needs that of joints.

Source: MuJoCo, "Computation", numerical integration: Euler is implicit in the damping of joints, and explicit in actuators.
"""

import pytest

from tests.vendor.mujoco_world import load, mujoco

pytestmark = pytest.mark.mujoco

DT, MASS = 1 / 240, 1.0


def left(z: float, y: float, of_joint: bool = False, held: bool = False) -> float:
    """How far a mass of 1 kg is from its target after 400 steps, of .01 m at first.

    Args: z: damping times step over mass. y: stiffness times step squared over mass. of_joint: is the damping the joint's, or
    the actuator's? held: is a mass ten times as heavy tied to it by a tendon?
    """
    k, c = y * MASS / DT**2, z * MASS / DT
    damping, gains = (f'damping="{c!r}"', f'kp="{k!r}"') if of_joint else ("", f'kp="{k!r}" kv="{c!r}"')
    inertial = '<inertial pos="0 0 0" mass="{}" diaginertia="1 1 1"/>'
    world = f'<body><joint name="x" type="slide" {damping}/>{inertial.format(MASS)}</body>'
    world += f'<body><joint name="y" type="slide"/>{inertial.format(10 * MASS)}</body>'
    tie = '<equality><joint joint1="x" joint2="y" solref=".0084 1" solimp=".999 .999 .001"/></equality>' if held else ""
    model, data = load(world, DT, gravity=0.0, more=f'<actuator><position joint="x" {gains}/></actuator>{tie}')
    data.qpos[:] = 0.01
    mujoco.mj_step(model, data, 400)
    return float(abs(data.qpos[0])) if data.time > 399 * DT else float("inf")


@pytest.mark.parametrize(("z", "y"), [(1.9, 0.15), (1.0, 1.9), (0.3, 3.3)])
def test_an_actuators_damping_is_stable_below_z_plus_half_y_of_two(z: float, y: float) -> None:
    assert z + y / 2 < 2
    assert left(z, y) < 1e-3
    assert left(z, 2 * (2.05 - z)) > 1.0


@pytest.mark.parametrize("z", [2.1, 10.0, 300.0])
def test_a_joints_damping_is_stable_at_any_step(z: float) -> None:
    assert left(z, 0.1) > 1.0
    assert left(z, 0.1, of_joint=True) < 0.01


def test_what_counts_is_the_inertia_that_constraints_leave() -> None:
    """Alone z is 5; with ten times the mass tied on it is 5/11."""
    assert left(5.0, 0.1) > 1.0
    assert left(5.0, 0.1, held=True) < 1e-3
