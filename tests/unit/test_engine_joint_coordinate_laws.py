"""What acts on joint coordinates of the reference engine: laws along them, damping, and bases that are told how to move."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbline import engine
from plumbline.engine.articulated import tables as to
from tests.random_trees import GRAVITY, LINKS, Tree, pin, random_tree, table, world_of

LAWS: tuple[dict[str, Any], ...] = (
    {"limits": engine.Limits(lower=0.69, upper=0.72), "friction_loss": 3.0},
    {"drive": engine.Drive(stiffness=300.0, damping=5.0, target=0.2, limit=4.0), "armature": 0.3},
    {"spring": engine.Spring(stiffness=500.0, damping=2.0, rest=0.1), "friction_loss": 1.0, "speed_limit": 1.5},
    {"friction_loss": 20.0, "drive": engine.Drive(damping=3.0, target_velocity=2.0, limit=1.0)},
    {"speed_limit": 0.5, "limits": engine.Limits(lower=-1.0, upper=0.71)},
)


def allowed(joint: Any, v: float, h: float) -> tuple[float, float]:
    """The least and the largest force along a joint that its laws allow at the rate v at the end of a step, from x = .7."""
    x, low, high = 0.7, 0.0, 0.0
    if joint.spring is not None:
        low -= joint.spring.stiffness * (x + h * v - joint.spring.rest) + joint.spring.damping * v
    if joint.drive is not None:
        drive = joint.drive
        force = drive.stiffness * (drive.target - x - h * v) + drive.damping * (drive.target_velocity - v)
        low += np.clip(force, -drive.limit, drive.limit)
    high = low
    still = abs(v) < 1e-9
    low -= joint.friction_loss if still or v > 0 else -joint.friction_loss
    high += joint.friction_loss if still or v < 0 else -joint.friction_loss
    bounds = [(-joint.speed_limit, joint.speed_limit)]
    if joint.limits is not None:
        bounds.append(((joint.limits.lower - x) / h, (joint.limits.upper - x) / h))
    for least, most in bounds:
        assert least - 1e-9 <= v <= most + 1e-9
        high = np.inf if abs(v - least) < 1e-9 else high
        low = -np.inf if abs(v - most) < 1e-9 else low
    return low, high


def needed_forces(tree: Tree, before: np.ndarray, after: np.ndarray, h: float) -> np.ndarray:
    """What has to act along each coordinate (n,) for bodies to go from one state (n, 13) to the poses of another in h.

    By d'Alembert's principle along Pinocchio's Jacobians of the start: of what momenta gain, with the velocities from pose to
    pose and inertia as at the start, what gravity does not give.
    """
    data, forces = tree.model.createData(), np.zeros(tree.model.nv)
    pin.computeJointJacobians(tree.model, data, tree.q)
    for k, body in enumerate(tree.bodies):
        number = tree.model.getJointId(f"joint{k}")
        jacobian = pin.getJointJacobian(tree.model, data, number, pin.LOCAL_WORLD_ALIGNED)
        start, end = (Rotation.from_quat(state[k, 3:7], scalar_first=True) for state in (before, after))
        inertia = start.as_matrix() @ np.array(body.inertia) @ start.as_matrix().T
        gain = body.mass * ((after[k, :3] - before[k, :3]) / h - before[k, 7:10] - h * np.array(GRAVITY))
        spin = inertia @ ((end * start.inv()).as_rotvec() / h - before[k, 10:])
        arm = before[k, :3] - data.oMi[number].translation
        forces += (jacobian[:3].T @ gain + jacobian[3:].T @ (spin + np.cross(arm, gain))) / h
    return forces


@pytest.mark.parametrize("seeds", [range(12), pytest.param(range(12, 120), marks=pytest.mark.slow)], ids=["few", "many"])
def test_laws_along_coordinates_hold_at_the_end_of_every_step(seeds: range) -> None:
    """The forces that the step needs by d'Alembert's principle are such as all joints' laws allow at the rates that it took:
    limits, friction, drives at their limit, springs and rotors at once. Forces of 1e3 N; poses' round-off of 1e-15 m over
    the square of 1e-2 s is 1e-10 N a kilogramme, and the rounds leave 1e-12 of forces of 1e3 N/1e-2 s.

    The seeds are those from 0 on, none left out. In some of these trees (10, 15, 16, 29, 43, 45, 87 and 95) the rounds that
    bend the way take a joint past a corner of its law, so that it has to change sides after them.
    """
    held, seen = set(), 0
    for seed in seeds:
        tree = random_tree(seed, floating=False, kinds=("revolute", "prismatic"), backwards=False)
        fields = [LAWS[(k + seed) % len(LAWS)] for k in range(LINKS)]
        tree.joints = [
            type(j)(name=j.name, parent=j.parent, child=j.child, anchor_W=j.anchor_W, axis_W=j.axis_W, position=0.7, **field)
            for j, field in zip(tree.joints, fields, strict=True)
            if isinstance(j, engine.Revolute | engine.Prismatic)
        ]
        h = 1e-2
        world = world_of(tree, dt=h)
        start = world.state().copy()
        kinds = to.int_view(world.save()[1], to.KIND)
        world.step(1)
        rates = np.zeros(LINKS)
        for link in kinds:
            at = tree.model.idx_vs[tree.model.getJointId(f"joint{link[to.ROW]}")]
            rates[at] = table(world, to.COLUMN)[link[to.FIRST], to.RATE]
        change = (rates - tree.v) / h
        forces = needed_forces(tree, start, world.state(), h)
        for joint in tree.joints:
            assert isinstance(joint, engine.Revolute | engine.Prismatic)
            at = tree.model.idx_vs[tree.model.getJointId(joint.name)]
            force = forces[at] + joint.armature * change[at]
            low, high = allowed(joint, rates[at], h)
            assert low - 1e-6 <= force <= high + 1e-6
            seen += 1
            held.add((low < high, abs(rates[at]) < 1e-9))
    assert seen == len(seeds) * LINKS
    assert held == {(True, True), (True, False), (False, False)}


TURNED = (0.0, 0.2, 0.0), (0.0, 0.0, 3.0)
"""Velocities that a base is told on the way."""


def carried_rod(coordinates: str, integrator: str, told: bool) -> np.ndarray:
    """Where a hinged rod with damping ends on a base that turns, and a body beside it, after .3 s."""
    rod: dict[str, Any] = {"mass": 2.0, "inertia": 0.2 * np.eye(3), "linear_damping": 0.5, "angular_damping": 0.3}
    bodies = [
        engine.Body(name="base", motion="kinematic", w_WB=(0.0, 0.0, 2.0), v_WB=(0.1, 0.0, 0.0)),
        engine.Body(name="rod", p_WB=(1.0, 0.0, 0.0), v_WB=(0.1, 2.0, 0.0), w_WB=(0.0, 0.0, 2.0), **rod),
        engine.Body(name="flies", p_WB=(5.0, 0.0, 0.0), v_WB=(0.0, 1.0, 0.0), w_WB=(1.0, 2.0, 0.5), **rod),
    ]
    bodies.append(engine.Body(name="slides", p_WB=(0.0, 1.0, 0.0), v_WB=(-1.9, 0.0, 0.0), w_WB=(0.0, 0.0, 2.0), **rod))
    joints: list[engine.Joint] = [
        engine.Revolute(name="pin", parent="base", child="rod", anchor_W=(0.5, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0)),
        engine.Prismatic(name="rail", parent="base", child="slides", anchor_W=(0.0, 1.0, 0.0), axis_W=(0.0, 1.0, 0.0)),
    ]
    options = engine.Options(dt=1e-3, integrator=integrator, coordinates=coordinates, substeps=1)
    world = engine.World(bodies, joints, options=options)
    world.step(150)
    if told:
        world.prescribe(0, *TURNED)
    world.step(150)
    return world.state().copy()


def test_damping_and_free_bodies_beside_trees_are_as_in_their_own_coordinates() -> None:
    """By rk4 the two ways agree to its error, by Euler to round-off, and Dormand-Prince agrees with rk4."""
    truth = carried_rod("maximal", "rk4", told=False)
    for integrator in ("rk4", "dormand_prince"):
        assert carried_rod("joint", integrator, told=False) == pytest.approx(truth, abs=1e-9)
    euler = (carried_rod(coordinates, "semi_implicit_euler", told=False) for coordinates in ("joint", "maximal"))
    assert next(euler) == pytest.approx(next(euler), abs=1e-12)


def test_a_base_that_is_told_another_velocity_is_one_under_every_integrator() -> None:
    """Against rk4: Dormand-Prince to the error of rk4; midpoint to (w dt)^2 / 12 of a radian a radian, and the damping of a
    free body, 1e-6 in all; Euler to 2 w dt of a radian, .012."""
    truth = carried_rod("joint", "rk4", told=True)
    assert np.abs(truth - carried_rod("joint", "rk4", told=False)).max() > 0.1
    for integrator, error in (("dormand_prince", 1e-9), ("implicit_midpoint", 5e-6), ("semi_implicit_euler", 1.2e-2)):
        assert carried_rod("joint", integrator, told=True) == pytest.approx(truth, abs=error)
