"""Robots of reinforcement learning's beginnings go in on every engine, and accelerate on each as MuJoCo's own model does."""

from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.intake.error import RobotError
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import Floats, State
from tests import gym_robots
from tests.robot_files import imported

pytestmark = pytest.mark.usefixtures("mjcf_here")
STEP = 1e-5
"""Seconds; the fastest rates of these robots are dampers of 4 N m s/rad on .1 kg m2: engines that take them at the end of a
step are off by a part of STEP x 40/s."""
PUSH = Companion(keyframe="push")


def own_velocities(text: str) -> dict[str, Floats]:
    """By body, what MuJoCo's own model has of linear velocity of the centre of mass after a step from rest [m/s]."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep, model.opt.density, model.opt.viscosity = STEP, 0.0, 0.0
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    velocities = {}
    for k in range(1, model.nbody):
        jacobian = np.zeros((3, model.nv))
        mujoco.mj_jacBodyCom(model, data, jacobian, None, k)
        velocities[model.body(k).name] = jacobian @ data.qacc * STEP
    return velocities


@pytest.mark.parametrize("engine", ["bullet", "dart", "mujoco", "reference"])
@pytest.mark.parametrize("name", gym_robots.__all__)
def test_each_robot_begins_to_move_as_its_file_says_on_each_engine(name: str, engine: str, tmp_path: Path) -> None:
    pytest.importorskip({"bullet": "pybullet", "dart": "dartpy", "reference": "numba"}.get(engine, engine))
    text = getattr(gym_robots, name)
    scene = imported(tmp_path, text, PUSH, drop=frozenset(("fluid",))).scene
    adapter = plugins.adapter(engine)
    simulation = adapter.build(scene, adapter.tracks["tuned"].with_dt(STEP))
    simulation.step()
    state = State.initial(scene)
    simulation.state(state)
    simulation.close()
    own = own_velocities(text)
    moved = {body.name: v for body, v in zip(scene.bodies, state.v_WB, strict=True) if body.name in own}
    assert len(moved) == len(own)
    largest = max(float(np.linalg.norm(v)) for v in own.values())
    assert max(float(np.linalg.norm(moved[body] - own[body])) for body in own) < 1e-3 * largest


def test_the_roots_of_planar_robots_are_bodies_without_mass_and_a_fluid_is_refused_by_name(tmp_path: Path) -> None:
    got = imported(tmp_path, gym_robots.CHEETAH)
    assert [body.name for body in got.scene.bodies if body.massless] == ["arm.x", "arm.z"]
    with pytest.raises(RobotError, match=r"fluid of density 4000 kg/m3.*--drop fluid"):
        imported(tmp_path, gym_robots.SWIMMER)
