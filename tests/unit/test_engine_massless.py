"""Bodies without mass between joints of the reference engine: against equations of the coordinates, and what refuses them."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline import engine
from plumbline.harness.scene import Body, Prismatic, Revolute, Scene
from tests.joint_space import JointSpace

AXES: tuple[tuple[str, tuple[float, float, float], tuple[float, float, float]], ...] = (
    ("slide", (0.6, 0.0, 0.8), (0.0, 0.0, 0.0)),
    ("hinge", (0.0, 0.6, 0.8), (0.1, 0.0, 0.2)),
    ("hinge", (1.0, 0.0, 0.0), (0.1, 0.3, 0.0)),
)
"""Of three joints in a row: axes that do not meet, with the points that they pass through."""
RATES = (0.7, -1.1, 1.6)


def made() -> tuple[list[engine.Body], list[engine.Joint], JointSpace]:
    """Two bodies without mass, a lopsided third, and a pendulum on it, all moving; and the equations of their coordinates."""
    heavy = {"arm": (1.5, (0.05, 0.07, 0.09), (0.4, 0.2, -0.1)), "bob": (0.8, (0.02, 0.03, 0.025), (0.7, 0.1, -0.4))}
    names, w, v = ("ahead", "above", "arm", "bob"), np.zeros(3), np.zeros(3)
    told: list[engine.Body] = []
    bodies, joints, of_scene = list[Body](), list[engine.Joint](), list[Any]()
    lines = (*AXES, ("hinge", (0.0, 1.0, 0.0), (0.6, 0.1, -0.1)))
    for name, parent, (kind, axis, anchor), rate in zip(names, ("world", *names), lines, (*RATES, 0.9), strict=False):
        # w and v are those at the world's origin.
        w = w + rate * np.array(axis) * (kind == "hinge")
        v = v + rate * (np.array(axis) if kind == "slide" else np.cross(anchor, axis))
        mass, moments, p = heavy.get(name, (0.0, (0.0, 0.0, 0.0), anchor))
        state = {"p_WB": p, "v_WB": tuple((v + np.cross(w, p)).tolist()), "w_WB": tuple(w.tolist())}
        told.append(engine.Body(name=name, mass=mass, inertia=np.diag(moments), **state))
        bodies.append(Body(name=name, mass=mass, inertia=np.diag(moments).tolist(), **state))
        ends: Any = {"name": f"to {name}", "parent": parent, "child": name, "anchor_W": anchor, "axis_W": axis}
        joints.append(engine.Prismatic(**ends) if kind == "slide" else engine.Revolute(**ends))
        of_scene.append(Prismatic(**ends) if kind == "slide" else Revolute(**ends))
    return told, joints, JointSpace(Scene(bodies=tuple(bodies), joints=tuple(of_scene)))


def truth(space: JointSpace, t: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Coordinates after t [s] by Lagrange's equations, and where each body then is, (3,) m."""

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        M, h, _ = space.at(y[:4], y[4:])
        return np.concatenate((y[4:], np.linalg.solve(M, -h)))

    end = solve_ivp(rate, (0.0, t), (0.0,) * 4 + (*RATES, 0.9), method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    return end[:4], {name: centre for name, (_, centre, *_) in space.at(end[:4], end[4:])[2].items()}


@pytest.mark.parametrize(
    ("integrator", "order"), [("semi_implicit_euler", 1), ("implicit_midpoint", 2), ("rk4", 4), ("dormand_prince", 0)]
)
def test_joints_in_a_row_move_one_body_as_the_equations_of_their_coordinates_say(integrator: str, order: int) -> None:
    """Errors of a half, a fourth and a sixteenth at half the step, to a third of that; Dormand and Prince's at 1e-11 of rates
    below 10: 1e-9 over .1 s. Bodies without mass are where the joints before them say, to as much."""
    bodies, joints, space = made()
    coordinates, places = truth(space, 0.1)
    errors = []
    for dt in (1e-2, 5e-3):
        options = engine.Options(dt=dt, substeps=1, integrator=integrator, tolerance=1e-11)
        world = engine.World(bodies, joints, options=options)
        world.step(round(0.1 / dt))
        got = np.array([world.joint_motion(joint.name)[0] for joint in joints])
        apart = [np.abs(world.state()[k, :3] - places[body.name]).max() for k, body in enumerate(bodies)]
        errors.append(max(float(np.abs(got - coordinates).max()), *apart))
    if order == 0:
        assert max(errors) < 1e-9
    else:
        assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=order / 3)


def test_velocities_of_what_has_no_mass_are_those_of_its_joints() -> None:
    """Semi-implicit Euler hands momenta on, of which these bodies have none: their rates are those from pose to pose, which
    differ from those at the end of a step by the step times accelerations below 1e2."""
    bodies, joints, _ = made()
    world = engine.World(bodies, joints, options=engine.Options(dt=1e-4, substeps=1))
    before = world.state()[:, :3].copy()
    world.step()
    after = world.state()
    assert after[:2, 7:10] == pytest.approx((after[:2, :3] - before[:2]) / 1e-4, abs=1e-2)
    assert after[1, 10:] == pytest.approx(np.array(RATES[1]) * np.array(AXES[1][1]), abs=1e-2)
    assert after[0, 10:] == pytest.approx(np.zeros(3), abs=1e-12)


def test_what_has_no_mass_and_stands_between_no_joints_is_refused_by_name() -> None:
    bodies, joints, _ = made()
    with pytest.raises(engine.NotSupported, match="body 'ahead' without mass with bodies' own coordinates"):
        engine.World(bodies, joints, options=engine.Options(coordinates="maximal"))
    with pytest.raises(engine.NotSupported, match=r"body 'above' without mass with body 'above'.*stands between no two joints"):
        engine.World(bodies[1:2])
    with pytest.raises(engine.NotSupported, match=r"body 'above'.*stands between no two joints"):
        engine.World(bodies[:2], joints[:2])
    rope = engine.Distance(name="rope", parent="world", child="ahead", anchor_W=(1.0, 1.0, 1.0), child_anchor_W=(0.0, 0.0, 0.0))
    with pytest.raises(engine.NotSupported, match=r"body 'ahead'.*stands between no two joints"):
        engine.World(bodies, [*joints, rope])
    with pytest.raises(ValueError, match="mass 0 kg and shapes or damping"):
        engine.Body(name="a", mass=0.0, inertia=np.zeros((3, 3)), linear_damping=0.1)
    with pytest.raises(ValueError, match="mass 0"):
        engine.Body(name="a", mass=0.0)
