"""An engine's own accelerometer and gyroscope: closed forms, and that asking changes nothing in the run, bit for bit."""

from typing import Any

import numpy as np
import pytest

from plumbline.harness.scene import (
    WORLD,
    Body,
    Box,
    Imu,
    PlacedShape,
    Plane,
    Scene,
    Surface,
    Vector3,
    axis_angle,
    rotation_matrix,
)
from plumbline.harness.study.plugins import adapter
from plumbline.harness.trajectory import State

pytest.importorskip("mujoco")

TURNED = axis_angle((0.3, -1.0, 0.5), 0.9)
MOUNT = axis_angle((1.0, 2.0, -0.5), 0.7)
ARM = (0.3, -0.1, 0.2)
SKEW = ((2.0, 0.2, 0.1), (0.2, 3.0, -0.3), (0.1, -0.3, 4.0))
"""An inertia whose principal axes are not those of B [kg m2]."""


def _built(scene: Scene, track: str = "tuned", dt: float = 1 / 240) -> Any:
    mujoco = adapter("mujoco")
    return mujoco.build(scene, mujoco.tracks[track].with_dt(dt))


def _imu(body: str, p_BS: Vector3 = ARM) -> Imu:
    return Imu(name="imu", body=body, rate=10.0, p_BS=p_BS, q_BS=MOUNT)


def test_a_free_tumbling_body_reads_eulers_equations_at_its_lever() -> None:
    """f = w' x r + w x (w x r) with I w' = -w x I w, in B; gravity is not felt."""
    w_W = np.array([1.0, 2.0, -0.7])
    body = Body(name="b", mass=2.0, inertia=SKEW, q_WB=TURNED, w_WB=w_W.tolist(), v_WB=(1.0, 0.0, 3.0))
    simulation = _built(Scene(bodies=(body,), sensors=(_imu("b"),)))
    force, rate = simulation.inertial("imu")
    R_WB, R_BS = np.array(rotation_matrix(TURNED)), np.array(rotation_matrix(MOUNT))
    w, tensor, arm = R_WB.T @ w_W, np.array(SKEW), np.array(ARM)
    turning = np.linalg.solve(tensor, -np.cross(w, tensor @ w))
    felt = np.cross(turning, arm) + np.cross(w, np.cross(w, arm))
    np.testing.assert_allclose(force, R_BS.T @ felt, atol=1e-12)
    np.testing.assert_allclose(rate, R_BS.T @ w, atol=1e-13)
    simulation.close()


def test_a_wrench_is_felt_as_soon_as_it_is_told() -> None:
    simulation = _built(Scene(bodies=(Body(name="b", mass=2.0),), sensors=(_imu("b", (0.0, 0.0, 0.0)),), gravity=(0, 0, 0)))
    simulation.step(5)
    simulation.wrench(np.array([[4.0, 0.0, -6.0]]), np.zeros((1, 3)))
    force, _ = simulation.inertial("imu")
    np.testing.assert_allclose(force, np.array(rotation_matrix(MOUNT)).T @ [2.0, 0.0, -3.0], atol=1e-13)
    simulation.close()


@pytest.mark.parametrize("motion", ["dynamic", "static"])
def test_what_stands_on_the_world_reads_gravity_upwards_whether_or_not_something_can_fall(motion: str) -> None:
    body = Body(name="b", motion=motion)  # type: ignore[arg-type]
    simulation = _built(Scene(bodies=(body,), sensors=(_imu(WORLD),)))
    force, rate = simulation.inertial("imu")
    np.testing.assert_allclose(force, np.array(rotation_matrix(MOUNT)).T @ [0.0, 0.0, 9.81], atol=1e-13)
    np.testing.assert_array_equal(rate, np.zeros(3))
    simulation.close()


@pytest.mark.parametrize("track", ["default", "tuned"])
def test_asking_between_steps_leaves_states_contacts_and_warnings_as_they_are_bit_for_bit(track: str) -> None:
    boxes = tuple(
        Body(
            name=f"b{k}", collision=(PlacedShape(shape=Box(half_extents=(0.2, 0.2, 0.2))),), p_WB=(0.03 * k, 0, 0.2 + 0.41 * k)
        )
        for k in range(4)
    )
    ground = Body(name="g", motion="static", material="ground", collision=(PlacedShape(shape=Plane()),))
    laws = tuple(
        Surface(between=pair, static_friction=0.5, kinetic_friction=0.5)
        for pair in (("default", "default"), ("default", "ground"))
    )
    scene = Scene(bodies=(ground, *boxes), surfaces=laws, sensors=(_imu("b2"),))
    asked, left = _built(scene, track), _built(scene, track)
    one, other = State.empty(5), State.empty(5)
    for step in range(300):
        force, rate = asked.inertial("imu")
        assert np.isfinite(force).all(), step
        assert np.isfinite(rate).all(), step
        asked.step()
        left.step()
        asked.state(one)
        left.state(other)
        for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    np.testing.assert_array_equal(asked.contacts().force_W, left.contacts().force_W)
    assert asked.warnings() == left.warnings()
    asked.close()
    left.close()


def test_a_sensor_that_takes_states_or_is_not_there_is_refused_by_name() -> None:
    sensor = Imu(name="imu", body="b", rate=10.0, reading="states")
    simulation = _built(Scene(bodies=(Body(name="b"),), sensors=(sensor,)))
    with pytest.raises(ValueError, match="'imu', expected one of none"):
        simulation.inertial("imu")
    simulation.close()
