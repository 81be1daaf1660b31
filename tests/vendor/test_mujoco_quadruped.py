"""A quadruped on MuJoCo's position actuators, asked through mujoco alone: how far does it give way as it is put down?"""

import math

import numpy as np
import pytest

from tests.vendor import quadruped
from tests.vendor.mujoco_world import G, blew_up, load, mujoco

pytestmark = pytest.mark.mujoco

DT, PRESSED = 1 / 240, 1e-6
"""How deep the feet start in the ground [m]: what just touches might be found a step late."""


def numbers(values: tuple[float, ...]) -> str:
    return " ".join(map(repr, values))


def sag(contact: str, of_joints: bool = False, dt: float = DT) -> float:
    """The greatest angle [rad] of a hinge off its place within 3 s.

    Args: of_joints: is the damping theirs, or the actuators'?
    """
    parts = list(quadruped.hinges())
    damped = f'damping="{quadruped.DAMPING}"' if of_joints else ""

    def part(hinge: quadruped.Hinge) -> str:
        turn = numbers((0.0, math.degrees(hinge.angle), 0.0)) if hinge.axis[1] else "0 0 0"
        inertial = f'pos="{numbers(hinge.centre)}" mass="{hinge.mass}" diaginertia="{numbers(hinge.inertia)}"'
        foot = f'<geom type="sphere" size="{quadruped.FOOT}" pos="0 0 -{quadruped.LEG}" friction=".8 0 0" {contact}/>'
        return (
            f'<body pos="{numbers(hinge.at)}" euler="{turn}"><joint name="{hinge.name}" axis="{numbers(hinge.axis)}" {damped}/>'
            f"<inertial {inertial}/>{foot * hinge.foot}{below(hinge.name)}</body>"
        )

    def below(name: str) -> str:
        return "".join(part(hinge) for hinge in parts if hinge.above == name)

    x, y, z = (half**2 for half in quadruped.TRUNK_HALF)
    moments = tuple(quadruped.TRUNK_MASS / 3 * s for s in (y + z, x + z, x + y))
    trunk = f'<inertial pos="0 0 0" mass="{quadruped.TRUNK_MASS}" diaginertia="{numbers(moments)}"/>{below("")}'
    gains = f'kp="{quadruped.STIFFNESS}"' + ("" if of_joints else f' kv="{quadruped.DAMPING}"')
    floor = f'<geom type="box" size="5 5 .5" pos="0 0 {PRESSED - 0.5!r}" friction=".8 0 0" {contact}/>'
    servos = "".join(f'<position joint="{hinge.name}" {gains}/>' for hinge in parts)
    machine = f'<body pos="0 0 {quadruped.HEIGHT!r}"><freejoint/>{trunk}</body>'
    model, data = load(floor + machine, dt, more=f"<actuator>{servos}</actuator>")
    # A hinge's zero is the pose in which it is described.
    data.ctrl[:] = [hinge.target - hinge.angle for hinge in parts]
    greatest = 0.0
    for _ in range(round(3 / dt)):
        mujoco.mj_step(model, data)
        if blew_up(data):
            return math.inf
        greatest = max(greatest, float(np.abs(data.qpos[7:]).max()))
    return greatest


def test_on_default_contacts_it_gives_way_by_three_thousandths_of_a_radian() -> None:
    assert sag("") == pytest.approx(0.003086, rel=5e-4)


def test_on_contacts_of_a_quarter_of_the_time_constant_it_gives_way_by_a_third() -> None:
    """A foot sinks until its contact bears, after a time constant: 0.02 s by default. A step of free fall, g dt^2/leg, and a
    thousandth of a radian are 1.9e-3."""
    assert sag('solref=".005 1"') < G * DT**2 / quadruped.LEG + 1e-3


def test_as_damping_of_joints_that_of_its_drives_gives_way_thirteen_times_as_far_at_a_step_that_bears_both() -> None:
    """Euler takes damping of joints implicitly, but finds contact forces without it."""
    assert sag("", of_joints=True) == pytest.approx(0.0403, rel=2e-2)


def test_at_twice_the_step_damping_of_actuators_blows_up_and_that_of_joints_does_not() -> None:
    assert sag("", dt=2 * DT) == math.inf
    assert sag("", of_joints=True, dt=2 * DT) < 0.15
