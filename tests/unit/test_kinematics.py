"""Rotations of arrays against matrices, and joint coordinates against motions made by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plumbline.harness.scene import WORLD, Body, Distance, Prismatic, Revolute, Scene, axis_angle, multiply, rotation_matrix
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trajectory.kinematics import angle_between, joint_coordinate, product, rotate, rotate_back

unit = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(c * c for c in q) > 0.01)


@given(unit, unit)
def test_arrays_of_rotations_agree_with_single_ones(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    p, q = (np.array(x) / np.linalg.norm(x) for x in (a, b))
    v = np.array([0.3, -1.2, 2.0])
    np.testing.assert_allclose(product(p, q), multiply(tuple(p), tuple(q)), atol=1e-15)
    np.testing.assert_allclose(rotate(p, v), np.array(rotation_matrix(tuple(p))) @ v, atol=1e-14)
    np.testing.assert_allclose(rotate_back(p, rotate(p, v)), v, atol=1e-14)
    trace = np.trace(np.array(rotation_matrix(tuple(p))).T @ np.array(rotation_matrix(tuple(q))))
    # The arccosine loses half the digits near 0 and pi, which is why the library does not use it.
    assert angle_between(p, q) == pytest.approx(np.arccos(np.clip((trace - 1) / 2, -1, 1)), abs=1e-6)


def test_a_hinge_counts_whole_turns_in_a_parent_that_turns_itself() -> None:
    scene = Scene(
        bodies=(Body(name="a"), Body(name="b", q_WB=axis_angle((1, 0, 0), 0.4))),
        joints=(Revolute(name="j", parent="a", child="b", anchor_W=(0, 0, 0), axis_W=(0, 0, 1), position=0.5),),
    )
    made = Trajectory.of(np.linspace(0, 10, 101), 2)
    for k, t in enumerate(made.time):
        parent = axis_angle((0.3, 1, 0.2), 0.7 * t)
        made.q_WB[k, 0] = parent
        made.q_WB[k, 1] = multiply(multiply(parent, axis_angle((0, 0, 1), 2.0 * t)), scene.bodies[1].q_WB)
    np.testing.assert_allclose(joint_coordinate(scene, scene.joints[0], made), 0.5 + 2.0 * made.time, atol=1e-12)


def test_a_slide_and_a_rod_give_their_lengths() -> None:
    slide = Prismatic(name="s", parent=WORLD, child="a", anchor_W=(0, 0, 0), axis_W=(0, 1, 0), position=0.25)
    rod = Distance(name="d", parent=WORLD, child="a", anchor_W=(0, 0, 4), child_anchor_W=(0, 0, 0))
    scene = Scene(bodies=(Body(name="a"),), joints=(slide, rod))
    made = Trajectory.of(np.linspace(0, 1, 3), 1)
    made.p_WB[:, 0, 1] = 3.0 * made.time
    np.testing.assert_allclose(joint_coordinate(scene, slide, made), 0.25 + 3.0 * made.time)
    np.testing.assert_allclose(joint_coordinate(scene, rod, made), np.hypot(4.0, 3.0 * made.time))
