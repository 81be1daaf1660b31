"""Robots whose links several joints move, from their files to every engine: as Lagrange's equations of the coordinates say."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.harness.scene import Scene
from plumbline.harness.study.plugins import adapter
from plumbline.harness.trajectory import State
from tests.joint_space import JointSpace
from tests.robot_files import imported, mjcf, urdf

pytestmark = pytest.mark.usefixtures("mjcf_here")
HOPPER = (
    '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" ref="1"/>'
    '<joint name="y" axis="0 1 0" pos="0 0 .05"/><geom type="capsule" fromto="0 0 .2 .03 0 -.2" size=".05"/>'
    '<body name="thigh" pos="0 0 -.2"><joint name="hip" axis="0 -1 0" damping=".3"/>'
    '<geom type="capsule" fromto="0 0 0 0 0 -.45" size=".05"/>'
    '<body name="leg" pos="0 0 -.45"><joint name="knee" axis="0 -1 0" stiffness="20" springref=".4"/>'
    '<geom type="capsule" fromto="0 0 0 0 0 -.5" size=".04"/></body></body>'
)
FILES = {"hopper": mjcf(HOPPER, '<option><flag contact="disable"/></option>'), "puck": urdf(kind="planar", joint="")}
DT, DURATION = 1e-3, 0.25


def moving(scene: Scene, rates: np.ndarray) -> Scene:
    """The scene with rates of its joints at the start."""
    _, _, jacobians = (space := JointSpace(scene)).at(np.array([j.position for j in space.joints]), rates)
    bodies = []
    for body in scene.bodies:
        if body.movable:
            v = jacobians[body.name][0] @ rates
            body = replace(body, v_WB=tuple(v[3:].tolist()), w_WB=tuple(v[:3].tolist()))
        bodies.append(body)
    return replace(scene, bodies=tuple(bodies))


def expected(scene: Scene, rates: np.ndarray) -> tuple[dict[str, np.ndarray], float]:
    """Where every body is after `DURATION` [m], and the greatest acceleration of a coordinate on the way."""
    space, n = JointSpace(scene), len(scene.joints)
    springs = [getattr(joint, "spring", None) for joint in space.joints]

    def change(_: float, y: np.ndarray) -> np.ndarray:
        M, h, _ = space.at(y[:n], y[n:])
        x, v = y[:n], y[n:]
        force = [0.0 if s is None else -s.stiffness * (x[k] - s.rest) - s.damping * v[k] for k, s in enumerate(springs)]
        return np.concatenate((v, np.linalg.solve(M, np.array(force) - h)))

    start = np.concatenate(([joint.position for joint in space.joints], rates))
    way = solve_ivp(change, (0.0, DURATION), start, method="DOP853", rtol=1e-11, atol=1e-11)
    places = {name: centre for name, (_, centre, *_) in space.at(way.y[:n, -1], way.y[n:, -1])[2].items()}
    return places, max(float(np.abs(change(0.0, y)[n:]).max()) for y in way.y.T)


@pytest.mark.parametrize("name", list(FILES))
@pytest.mark.parametrize("engine", ["mujoco", "bullet", "dart", "reference"])
def test_every_engine_moves_a_link_of_several_joints_as_its_coordinates_do(engine: str, name: str, tmp_path: Path) -> None:
    """Of first order at worst: half a step of the velocity gained, on bodies within a metre of what turns them, twice over."""
    scene = imported(tmp_path, FILES[name]).scene
    assert any(body.massless for body in scene.bodies)
    rates = np.linspace(1.0, -1.5, len(scene.joints))
    scene = moving(scene, rates)
    places, sharpest = expected(scene, rates)
    chosen = adapter(engine)
    simulation, out = chosen.build(scene, chosen.tracks["tuned"].with_dt(DT)), State.empty(len(scene.bodies))
    simulation.step(round(DURATION / DT))
    simulation.state(out)
    simulation.close()
    for k, body in enumerate(scene.bodies):
        if body.movable:
            assert out.p_WB[k] == pytest.approx(places[body.name], abs=DT * sharpest * DURATION), body.name
    assert max(np.abs(places[body.name] - body.p_WB).max() for body in scene.bodies if body.movable) > 50 * DT
