"""What friction makes of a plate that is moved: of a mocap body, and of a free one that nothing can push."""

import numpy as np
import pytest

from tests.vendor.mujoco_world import mujoco

pytestmark = pytest.mark.mujoco

SPEED, STEPS, DT = 0.5, 500, 1e-3


def carried(mocap: bool) -> tuple[float, float]:
    """How far [m] a plate at .5 m/s takes a box of friction 1 in half a second, and how far it goes itself."""
    spec = mujoco.MjSpec()
    spec.option.timestep = DT
    plate = spec.worldbody.add_body(name="plate", pos=[0, 0, -0.1], mocap=mocap)
    plate.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[2, 1, 0.1])
    if not mocap:
        plate.explicitinertial, plate.mass, plate.inertia, plate.gravcomp = True, 1.0, [1.0] * 3, 1.0
        plate.ipos, plate.iquat = [0, 0, 0], [1, 0, 0, 0]
        plate.add_joint(name="led", type=mujoco.mjtJoint.mjJNT_FREE, armature=1e12)
    box = spec.worldbody.add_body(name="box", pos=[0, 0, 0.05])
    box.add_freejoint()
    box.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.2, 0.2, 0.05])
    model = spec.compile()
    data = mujoco.MjData(model)
    for step in range(STEPS):
        if mocap:
            data.mocap_pos[0, 0] = SPEED * DT * (step + 1)
        else:
            data.qvel[0] = SPEED
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    return float(data.body("box").xpos[0]), float(data.body("plate").xpos[0])


def test_a_mocap_body_has_no_velocity_in_contact() -> None:
    """It goes its way under the box, which stays where it was."""
    box, plate = carried(mocap=True)
    assert plate == pytest.approx(SPEED * STEPS * DT, abs=1e-12)
    assert abs(box) < 1e-6


def test_a_free_body_that_nothing_pushes_takes_along_what_lies_on_it() -> None:
    """Friction of 1 stops the slip in v / g; what is soft lags by v times its time constant of 20 ms."""
    box, plate = carried(mocap=False)
    assert plate == pytest.approx(SPEED * STEPS * DT, abs=1e-9)
    assert box == pytest.approx(SPEED * STEPS * DT - SPEED**2 / (2 * 9.81), abs=SPEED * 0.02)


def test_velocity_written_into_a_root_takes_along_what_hangs_on_it() -> None:
    """Joint rates stay, so that a slider which nothing holds along its slide gets the velocity of the frame too."""
    spec = mujoco.MjSpec()
    spec.option.gravity = [0, 0, 0]
    frame = spec.worldbody.add_body(name="frame")
    frame.explicitinertial, frame.mass, frame.inertia = True, 1.0, [1.0] * 3
    frame.ipos, frame.iquat = [0, 0, 0], [1, 0, 0, 0]
    frame.add_joint(type=mujoco.mjtJoint.mjJNT_FREE, armature=1e12)
    slider = frame.add_body(name="slider")
    slider.explicitinertial, slider.mass, slider.inertia = True, 1.0, [1.0] * 3
    slider.ipos, slider.iquat = [0, 0, 0], [1, 0, 0, 0]
    slider.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0])
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qvel[0] = SPEED
    mujoco.mj_forward(model, data)
    assert data.body("slider").cvel[3] == pytest.approx(SPEED)
    blow, answer = np.zeros((1, model.nv)), np.zeros((1, model.nv))
    data.qvel[:] = 0.0
    blow[0, 0] = 1e12 * SPEED
    mujoco.mj_solveM(model, data, answer, blow)
    data.qvel[:] = answer[0]
    mujoco.mj_forward(model, data)
    assert data.body("slider").cvel[3] == pytest.approx(0.0, abs=1e-3)
    assert data.body("frame").cvel[3] == pytest.approx(SPEED, abs=1e-9)


def welded() -> float:
    """How far [m] a free plate that is welded to a mocap body, of its own mass, takes the box in half a second."""
    spec = mujoco.MjSpec()
    spec.option.timestep = DT
    spec.worldbody.add_body(name="hand", pos=[0, 0, -0.1], mocap=True)
    plate = spec.worldbody.add_body(name="plate", pos=[0, 0, -0.1], gravcomp=1.0)
    plate.add_freejoint()
    plate.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[2, 1, 0.1], mass=1.0)
    held = spec.add_equality(type=mujoco.mjtEq.mjEQ_WELD, name1="hand", name2="plate", objtype=mujoco.mjtObj.mjOBJ_BODY)
    held.data[:11] = [0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1]
    box = spec.worldbody.add_body(name="box", pos=[0, 0, 0.05])
    box.add_freejoint()
    box.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.2, 0.2, 0.05])
    model = spec.compile()
    data = mujoco.MjData(model)
    for step in range(STEPS):
        data.mocap_pos[0, 0] = SPEED * DT * (step + 1)
        mujoco.mj_step(model, data)
    return float(data.body("box").xpos[0])


def test_a_plate_welded_to_a_mocap_body_takes_it_along_and_gives_way_to_what_it_bears() -> None:
    assert 0.15 < welded() < 0.26
