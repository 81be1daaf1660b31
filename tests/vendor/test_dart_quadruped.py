"""A quadruped on DART's joint springs and dampers, on its servos, and on torques of one's own, in dartpy's own words."""

import math
import time
from typing import Any

import numpy as np
import pytest

from tests.vendor import quadruped
from tests.vendor.dart_world import UP, G, dartpy, make_ground, make_pose, make_world, moments_of_box, touches

pytestmark = pytest.mark.dart

PRESSED = 1e-6
"""How deep the feet start in the ground [m]: what just touches might be found a step late."""


def build(dt: float, drive: str, up: float = 0.0) -> tuple[Any, Any]:
    """A world and the machine in it, in the pose in which its springs bear its weight. Args: up: so far in the air [m]."""
    world = make_world("fcl", dt, sleeping=True)
    make_ground(world, dartpy.dynamics.BoxShape(np.array([10.0, 10.0, 1.0])), make_pose(UP, PRESSED - 0.5))
    machine = dartpy.dynamics.Skeleton("machine")
    free, trunk = machine.createFreeJointAndBodyNodePair()
    moments = np.diag(moments_of_box(quadruped.TRUNK_HALF)) * quadruped.TRUNK_MASS
    trunk.setInertia(dartpy.dynamics.Inertia(quadruped.TRUNK_MASS, np.zeros(3), moments))
    touches(trunk, dartpy.dynamics.BoxShape(2 * np.array(quadruped.TRUNK_HALF)))
    nodes = {"": trunk}
    for hinge in quadruped.hinges():
        joint, node = machine.createRevoluteJointAndBodyNodePair(nodes[hinge.above])
        nodes[hinge.name] = node
        joint.setName(hinge.name)
        joint.setAxis(np.array(hinge.axis))
        x, y, z = hinge.at
        joint.setTransformFromParentBodyNode(make_pose(UP, z, x, y))
        node.setInertia(dartpy.dynamics.Inertia(hinge.mass, np.array(hinge.centre), np.diag(hinge.inertia)))
        joint.setPosition(0, hinge.angle)
        if drive == "springs":
            joint.setSpringStiffness(0, quadruped.STIFFNESS)
            joint.setDampingCoefficient(0, quadruped.DAMPING)
            joint.setRestPosition(0, hinge.target)
        if drive == "servos":
            joint.setActuatorType(dartpy.dynamics.ActuatorType.SERVO)
            joint.setForceLowerLimit(0, -100.0)
            joint.setForceUpperLimit(0, 100.0)
        if hinge.foot:
            touches(node, dartpy.dynamics.SphereShape(quadruped.FOOT), z=-quadruped.LEG)
    free.setTransform(make_pose(UP, quadruped.HEIGHT + up))
    world.addSkeleton(machine)
    return world, machine


def stand(dt: float, drive: str, seconds: float = 3.0, up: float = 0.0) -> tuple[float, float]:
    """The least height of trunk and hips as a share of their start, and the greatest angle [rad] of a hinge off its place.

    Args: drive: "springs" and dampers of DART's joints, its "servos" that turn a hinge back as spring and damper alone would,
        k/d of the way a second, "torques" of spring and damper from the step's start, or "stable" ones from its end.
    """
    world, machine = build(dt, drive, up)
    start, targets = np.array(machine.getPositions())[6:], np.array([hinge.target for hinge in quadruped.hinges()])
    nodes = [machine.getBodyNode(k) for k in range(machine.getNumBodyNodes())]
    high, lowest, off = [node for node in nodes if node.getCOM()[2] > quadruped.HEIGHT - 1e-9], 1.0, 0.0
    for _ in range(round(seconds / dt)):
        angles, rates = np.array(machine.getPositions())[6:], np.array(machine.getVelocities())[6:]
        if drive == "servos":
            wanted = quadruped.STIFFNESS / quadruped.DAMPING * (start - angles)
            machine.setCommands(np.concatenate([np.zeros(6), wanted]))
        elif drive == "stable":
            machine.setForces(_foreseen(machine, targets, dt))
        elif drive == "torques":
            torques = quadruped.STIFFNESS * (targets - angles) - quadruped.DAMPING * rates
            machine.setForces(np.concatenate([np.zeros(6), torques]))
        world.step()
        lowest = min(lowest, *(float(node.getCOM()[2]) / quadruped.HEIGHT for node in high))
        off = max(off, float(np.abs(np.array(machine.getPositions())[6:] - start).max()))
        # Left at once where it is thrown: a detector aborts the process for what is far enough away.
        if not off < 10.0:
            return lowest, math.inf
    return lowest, off


def _foreseen(machine: Any, targets: Any, dt: float) -> Any:
    """Stable PD control as in DART's tutorial of a biped: the velocity at the end of the step, contacts as they bore last."""
    x, v = np.array(machine.getPositions()), np.array(machine.getVelocities())
    stiff, damp = (np.repeat((0.0, gain), (6, 12)) for gain in (quadruped.STIFFNESS, quadruped.DAMPING))
    push = stiff * (np.concatenate((np.zeros(6), targets)) - x - dt * v) - damp * v
    loads = machine.getConstraintForces() - machine.getCoriolisAndGravityForces()
    rates = np.linalg.solve(machine.getMassMatrix() + np.diag(dt * damp), push + loads)
    return push - dt * damp * rates


def test_on_joint_springs_it_lies_on_its_belly_within_three_seconds() -> None:
    """DART answers contacts with a mass matrix that knows no spring: what the springs would hold gives way with each step."""
    assert stand(1 / 240, "springs") == pytest.approx((0.05561, 0.7547), rel=5e-4)


def test_on_joint_springs_it_sags_less_by_the_step() -> None:
    # First order: from 1/960 to 1/1920 s a half.
    coarse, fine = (1 - stand(dt, "springs", seconds=1.0)[0] for dt in (1 / 960, 1 / 1920))
    assert fine / coarse == pytest.approx(0.5, abs=0.1)


def test_on_torques_of_its_own_it_stands() -> None:
    """The same stiffness and damping, worked out at the start of each step: it gives way by less than a step of free fall."""
    height, off = stand(1 / 240, "torques")
    assert 1 - height < G / 240**2 / quadruped.HEIGHT
    assert off < G / 240**2 / quadruped.LEG


def test_on_servos_it_stands_at_a_sixtieth_of_a_second_where_explicit_torques_throw_it() -> None:
    height, off = stand(1 / 60, "servos")
    # What a body falls in the step before contacts bear it: who stands gives way by less.
    assert (1 - height) * quadruped.HEIGHT < G / 60**2
    assert off < G / 60**2 / quadruped.LEG
    assert stand(1 / 60, "torques")[1] > 0.5


def test_on_the_tutorial_s_stable_control_it_gives_way_where_it_stands_on_plain_torques() -> None:
    """Contacts count with what they bore in the step before, while torques of the step's end follow what they bear now: the
    machine sinks until the two agree, at a quarter of the step 55 times less deep. So what foresees a step has to know the
    contacts themselves."""
    lost = {}
    for drive in ("stable", "torques", "servos"):
        begun = time.process_time()
        height, _ = stand(1 / 240, drive, seconds=1.0)
        print(f"{drive}: {1e6 * (time.process_time() - begun) / 240:.0f} us a step, reading included")
        lost[drive] = (1 - height) * quadruped.HEIGHT
    assert lost["stable"] == pytest.approx(7.76e-3, rel=0.01)
    assert max(lost["torques"], lost["servos"]) < G / 240**2
    assert (1 - stand(1 / 960, "stable", seconds=1.0)[0]) * quadruped.HEIGHT < lost["stable"] / 16


def test_a_leg_in_the_air_is_thrown_by_plain_torques_and_held_by_stable_ones() -> None:
    """Why torques of the step's start do not do for a machine that lifts its feet: 2 N m s/rad on a shank of 3e-3 kg m2."""
    assert stand(1 / 240, "torques", seconds=0.3, up=1.0)[1] == math.inf
    # Without a weight on its feet each hinge goes to its target.
    farthest = max(abs(hinge.target - hinge.angle) for hinge in quadruped.hinges())
    assert stand(1 / 240, "stable", seconds=0.3, up=1.0)[1] < 1.1 * farthest
