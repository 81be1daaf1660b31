"""Which rotors are fast: the rate of their wobble by hand, and what has none."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.adapter.fast_rotors import WOBBLE, fast_rotors, rotor_notices
from plumbline.harness.scene import WORLD, Ball, Body, Drive, Joint, Prismatic, Revolute, Scene, principal_inertia
from tests.gimbals import WHEEL, gimbal, wobble


def test_a_gimbal_that_does_not_turn_nods_at_the_wheels_momentum_over_the_mean_inertia_across() -> None:
    rotors = fast_rotors(gimbal(150.0, tilt=0.0, turning=0.0))
    assert rotors.hinges == {"c"}
    assert rotors.wobble == pytest.approx(wobble(150.0), rel=1e-12)
    assert rotors.growth(1e-3) == pytest.approx(wobble(150.0) ** 2 * 1e-3 / 2)


def test_a_rotor_is_fast_from_one_rate_on() -> None:
    slowest = 150.0 * WOBBLE / wobble(150.0)
    for sign in (1, -1):
        assert not fast_rotors(gimbal(sign * 0.99 * slowest, tilt=0.0, turning=0.0))
        assert fast_rotors(gimbal(sign * 1.01 * slowest, tilt=0.0, turning=0.0))


def test_what_a_drive_is_to_reach_counts_as_much() -> None:
    drive = Drive(damping=1e-3, target_velocity=150.0)
    assert fast_rotors(gimbal(0.0, tilt=0.0, turning=0.0, drive=drive)).wobble == pytest.approx(wobble(150.0))
    # A drive without a damper asks for no rate.
    assert not fast_rotors(gimbal(0.0, drive=replace(drive, damping=0.0, stiffness=1.0)))


def rotor(motion: str) -> Scene:
    """A disc of 200 rad/s about z on a hinge to a body of 1000 times its inertia that is free, or stands still."""
    base = Body(name="base", mass=100.0, inertia=principal_inertia(1.0, 1.0, 1.0), motion=motion)  # type: ignore[arg-type]
    disc = Body(name="disc", mass=0.3, inertia=principal_inertia(*WHEEL), w_WB=(0.0, 0.0, 200.0))
    hinge = Revolute(name="hinge", parent="base", child="disc", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 0.0, 1.0))
    return Scene(bodies=(base, disc), joints=(hinge,), gravity=(0.0, 0.0, 0.0))


@pytest.mark.parametrize("motion", ["static", "kinematic", "dynamic"])
def test_a_rotor_on_what_stands_or_is_heavy_is_none_whatever_its_speed(motion: str) -> None:
    assert not fast_rotors(rotor(motion))


def test_a_rotor_on_a_free_body_nods_by_the_inertia_of_both() -> None:
    scene = rotor("dynamic")
    light = replace(scene, bodies=(replace(scene.bodies[0], mass=0.3, inertia=principal_inertia(*WHEEL)), scene.bodies[1]))
    # One across the axis is like the other: H/(2 I1), the nutation of a free body of both.
    assert fast_rotors(light).wobble == pytest.approx(WHEEL[2] * 200.0 / (2 * WHEEL[0]), rel=1e-12)
    # Which of the two the scene calls the parent is nothing to it, nor where in the list they stand.
    turned = replace(light.joints[0], parent="disc", child="base")
    assert fast_rotors(replace(light, bodies=light.bodies[::-1], joints=(turned,))).wobble == pytest.approx(200.0)


def test_a_mass_that_slides_along_a_rod_that_turns_has_coriolis_and_centrifugal_forces() -> None:
    arm, sliding = 0.3, 3.0
    # M = I + m r^2, c = (2 m r r' w, -m r w^2), whose derivatives by (w, r') are (2 m r r', 2 m r w) and (-2 m r w, 0).
    rod = Body(name="rod", mass=1.0, inertia=principal_inertia(0.01, 0.01, 0.02), w_WB=(0.0, 0.0, 40.0))
    mass = Body(
        name="mass", mass=0.5, inertia=principal_inertia(1e-3, 1e-3, 1e-3), p_WB=(arm, 0.0, 0.0),
        v_WB=(sliding, arm * 40.0, 0.0), w_WB=(0.0, 0.0, 40.0),
    )  # fmt: skip
    joints: tuple[Joint, ...] = (
        Revolute(name="hinge", parent=WORLD, child="rod", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 0.0, 1.0)),
        Prismatic(name="slide", parent="rod", child="mass", anchor_W=(0.0, 0.0, 0.0), axis_W=(1.0, 0.0, 0.0)),
    )
    inertia = 0.02 + 1e-3 + 0.5 * arm**2
    slope = np.array([[2 * 0.5 * arm * sliding / inertia, 2 * 0.5 * arm * 40.0 / inertia], [-2 * arm * 40.0, 0.0]])
    rate = float(np.abs(np.linalg.eigvals(slope).imag).max())
    assert fast_rotors(Scene(bodies=(rod, mass), joints=joints)).wobble == pytest.approx(rate, rel=1e-12)


def test_a_ball_joint_alone_holds_no_rotor() -> None:
    body = Body(name="top", inertia=principal_inertia(0.01, 0.01, 0.02), p_WB=(0.0, 0.0, 0.1), w_WB=(0.0, 0.0, 500.0))
    joint = Ball(name="tip", parent=WORLD, child="top", anchor_W=(0.0, 0.0, 0.0))
    assert not fast_rotors(Scene(bodies=(body,), joints=(joint,)))


def test_what_is_told_is_where_a_rotor_is_no_constraint_or_that_does_not_suffice() -> None:
    scene = gimbal()
    growth = fast_rotors(scene).growth(1e-3)
    (told,) = rotor_notices(scene, scene.joints, (), 1e-3)
    assert "joint 'c'" in told.text
    assert f"grow by e^{growth:.2g} a second" in told.text
    assert not rotor_notices(scene, scene.joints, {"c"}, 1e-3)
    # A wobble of 147 rad/s turns by 0.2 rad in 1.4 ms.
    (told,) = rotor_notices(scene, scene.joints, {"c"}, 1 / 240)
    assert "too fast" in told.text
    uneven = gimbal(wheel=(0.2e-3, 0.8e-3, 0.9e-3))
    (told,) = rotor_notices(uneven, uneven.joints, {"c"}, 1e-4)
    assert "uneven" in told.text
    assert not rotor_notices(gimbal(0.0), gimbal(0.0).joints, (), 1 / 240)
    assert math.isclose(fast_rotors(scene).wobble, 147.3, abs_tol=0.1)
