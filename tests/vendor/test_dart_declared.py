"""What is declared that DART lacks or refuses, tried as its advocate would: by every word of dartpy that might say it."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.vendor.dart_world import UP, G, dartpy, make_ground, make_mover, make_pose, make_world

pytestmark = pytest.mark.dart


def pendulum(skeleton: Any, name: str, mass: float, arm: float) -> Any:
    """A hinge along y in the world, and a rod that starts level; 0.1 kg m2 about its centre."""
    joint, node = skeleton.createRevoluteJointAndBodyNodePair()
    joint.setName(name)
    joint.setAxis((0.0, 1.0, 0.0))
    node.setInertia(dartpy.dynamics.Inertia(mass, np.array([arm, 0.0, 0.0]), 0.1 * np.eye(3)))
    return joint


def coupled(ratio: float, dt: float, coupler: bool = True) -> tuple[float, float]:
    """Angles [rad] after 0.5 s of two pendulums, of which the second is told to follow the first by its properties."""
    skeleton = dartpy.dynamics.Skeleton("pair")
    leads, follows = pendulum(skeleton, "leads", 2.0, 0.5), pendulum(skeleton, "follows", 1.0, 0.3)
    told, law = follows.getRevoluteJointProperties(), dartpy.dynamics.MimicDofProperties()
    law.mReferenceJoint, law.mReferenceDofIndex, law.mMultiplier, law.mOffset = leads, 0, ratio, 0.0
    told.mMimicDofProps, told.mActuatorType = [law], dartpy.dynamics.ActuatorType.MIMIC
    follows.setProperties(told)
    follows.setUseCouplerConstraint(coupler)
    world = dartpy.simulation.World("w")
    world.setGravity((0.0, 0.0, -G))
    world.setTimeStep(dt)
    world.addSkeleton(skeleton)
    for _ in range(round(0.5 / dt)):
        world.step()
        if not abs(leads.getPosition(0)) < 1e3:
            return math.inf, math.inf
    return leads.getPosition(0), follows.getPosition(0)


def due(ratio: float) -> float:
    """The first one's angle [rad]: (I1 + r^2 I2) q'' = g (m1 a1 cos q + r m2 a2 cos r q)."""
    inertia = 0.1 + 2 * 0.25 + ratio**2 * (0.1 + 0.09)
    fall = solve_ivp(
        lambda _, y: (y[1], G * (math.cos(y[0]) + ratio * 0.3 * math.cos(ratio * y[0])) / inertia), (0, 0.5), (0, 0), rtol=1e-10
    )
    return float(fall.y[0, -1])


@pytest.mark.parametrize("ratio", [1.0, 0.5, -0.9])
def test_a_joint_is_told_by_its_properties_whom_it_mimics_and_the_coupler_answers_in_first_order(ratio: float) -> None:
    """A tenth of the step is a tenth of the error, that of the follower a step's way behind."""
    errors = []
    for dt in (1e-3, 1e-4):
        leads, follows = coupled(ratio, dt)
        errors.append(max(abs(leads - due(ratio)), abs(follows - ratio * due(ratio))))
    assert errors[0] < 0.01
    assert errors[1] == pytest.approx(errors[0] / 10, rel=0.2)


@pytest.mark.parametrize("dt", [1e-3, 1e-4])
@pytest.mark.parametrize("ratio", [2.0, -2.0])
def test_a_coupler_to_a_slower_joint_blows_up_at_any_step(ratio: float, dt: float) -> None:
    """Told the other way round, of the inverse ratio, it is one of the above."""
    assert coupled(ratio, dt)[0] == math.inf


def test_the_default_of_a_mimic_drives_the_follower_and_takes_nothing_of_the_leader() -> None:
    """The leader falls as if it were alone: 1.807 rad, where the two together fall by 1.275 at a ratio of 2."""
    assert coupled(2.0, 1e-4, coupler=False)[0] == pytest.approx(1.807, abs=1e-3)
    assert due(2.0) == pytest.approx(1.275, abs=1e-3)


@pytest.mark.parametrize(("friction", "acts"), [(0.9e-3, 0.0), (1e-3, 0.0), (1.001e-3, 1.0), (2e-3, 1.0)])
def test_friction_of_a_thousandth_and_less_is_none(friction: float, acts: float) -> None:
    world = make_world("ode", 1e-3)
    make_ground(world, dartpy.dynamics.BoxShape((40.0, 40.0, 1.0)), make_pose(UP, -0.5), friction=friction)
    node = make_mover(world, dartpy.dynamics.BoxShape((0.2, 0.2, 0.2)), make_pose(UP, 0.1), friction=friction)
    node.getParentJoint().setLinearVelocity((1.0, 0.0, 0.0))
    for _ in range(1000):
        world.step()
    assert 1 - node.getLinearVelocity()[0] == pytest.approx(acts * friction * G, rel=2e-3, abs=1e-9)


@pytest.mark.parametrize("limit", [math.inf, 2.0])
def test_a_servo_takes_no_force_beside(limit: float) -> None:
    """A slide of 2 kg that is told to stand and 3 N beside: within its limit it stands, by whatever way the force is told."""
    world, skeleton = dartpy.simulation.World("w"), dartpy.dynamics.Skeleton("s")
    world.setTimeStep(1e-3)
    world.setGravity((0.0, 0.0, 0.0))
    joint, node = skeleton.createPrismaticJointAndBodyNodePair()
    joint.setAxis((1.0, 0.0, 0.0))
    node.setInertia(dartpy.dynamics.Inertia(2.0, np.zeros(3), np.eye(3)))
    world.addSkeleton(skeleton)
    joint.setActuatorType(dartpy.dynamics.ActuatorType.SERVO)
    joint.setForceLowerLimit(0, -limit)
    joint.setForceUpperLimit(0, limit)
    for _ in range(500):
        joint.setCommand(0, 0.0)
        joint.setForce(0, 3.0)
        world.step()
    assert joint.getVelocity(0) == 0.0


ROOMS = ("constraint", "dynamics", "collision", "simulation", "utils")


@pytest.mark.parametrize(
    "word",
    [
        "continuous",
        "sweep",
        "rolling",
        "torsion",
        "armature",
        "rotor",
        "staticfriction",
        "distancejoint",
        "springdamper",
        "tendon",
    ],
)
def test_nothing_in_dartpy_has_such_a_name(word: str) -> None:
    """Neither a class, nor a method of a joint, a surface, a body, a world or a solver."""
    names = [name for room in ROOMS for name in dir(getattr(dartpy, room))]
    d = dartpy.dynamics
    for kind in (
        d.Joint,
        d.RevoluteJoint,
        d.DynamicsAspect,
        d.BodyNode,
        dartpy.simulation.World,
        dartpy.constraint.ConstraintSolver,
    ):
        names += dir(kind)
    assert not [name for name in names if word in name.lower()]


def test_a_surface_is_one_friction_and_one_restitution_and_a_pair_has_no_word_of_its_own() -> None:
    told = [name for name in dir(dartpy.dynamics.DynamicsAspect) if name.startswith("set")]
    assert told == ["setFrictionCoeff", "setRestitutionCoeff"]
    assert not [name for name in dir(dartpy.constraint) if "Surface" in name or ("Contact" in name and "Options" not in name)]


def test_loops_are_closed_by_balls_hinges_welds_and_cylinders_alone() -> None:
    kinds = {name for name in dir(dartpy.constraint) if name.endswith("JointConstraint")}
    assert kinds == {f"{kind}JointConstraint" for kind in ("Ball", "Cylindrical", "Dynamic", "Revolute", "Weld")} | {
        "JointConstraint"
    }


def test_a_world_has_no_word_for_many_steps_nor_for_its_state() -> None:
    told = dir(dartpy.simulation.World)
    assert not [name for name in told if "steps" in name.lower() or "save" in name.lower() or "restore" in name.lower()]


def test_joints_have_a_damping_and_bodies_have_none() -> None:
    assert "setDampingCoefficient" in dir(dartpy.dynamics.RevoluteJoint)
    for kind in (dartpy.dynamics.BodyNode, dartpy.dynamics.DynamicsAspect, dartpy.dynamics.Inertia, dartpy.simulation.World):
        assert not [name for name in dir(kind) if "damp" in name.lower() or "drag" in name.lower()]


def let_down(world: Any, shape: Any, z: float, mobile: bool = True) -> Any:
    """A body of 1 kg with this shape at a height [m] in a world."""
    skeleton = dartpy.dynamics.Skeleton(f"body at {z}")
    _, node = skeleton.createFreeJointAndBodyNodePair()
    node.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 150))
    seen = node.createShapeNode(shape)
    seen.createCollisionAspect()
    seen.createDynamicsAspect().setFrictionCoeff(0.5)
    skeleton.setPositions([0, 0, 0, 0, 0, z])
    skeleton.setMobile(mobile)
    world.addSkeleton(skeleton)
    return skeleton


@pytest.mark.parametrize(("detector", "exact"), [("ode", True), ("dart", True), ("fcl", False), ("bullet", False)])
def test_a_clone_of_a_world_goes_on_bit_for_bit_on_two_detectors_and_by_rounding_on_two(detector: str, exact: bool) -> None:
    """Three boxes, the uppermost let fall askew, cloned in contact: what FCL and Bullet remember stays behind."""
    world = make_world(detector, 1 / 240)
    let_down(world, dartpy.dynamics.BoxShape(np.array([4.0, 4.0, 1.0])), -0.5, mobile=False)
    boxes = [let_down(world, dartpy.dynamics.BoxShape(np.full(3, 0.2)), 0.1 + 0.2 * k) for k in range(3)]
    boxes[2].setVelocities([1.0, 2.0, 3.0, 0.3, 0.0, 0.0])
    for _ in range(60):
        world.step()
    clone = world.clone()
    for _ in range(60):
        world.step()
        clone.step()
    ends = [[w.getSkeleton(k).getPositions() for k in range(w.getNumSkeletons())] for w in (world, clone)]
    off = float(np.abs(np.subtract(*ends)).max())
    assert (off == 0.0) == exact
    assert off < 1e-12


def test_a_mesh_comes_from_a_file_alone_and_a_hull_of_points_is_held_by_bullet_s_detector_alone_with_a_margin() -> None:
    """Eight points without a radius, 1.7 mm above what bears them and turned; FCL and ODE put a ball there, DART nothing."""
    assert "aiScene" in str(dartpy.dynamics.MeshShape.__init__.__doc__)
    assert not [name for name in dir(dartpy.dynamics) if "TriMesh" in name or "ConvexMesh" in name]
    corners = [(0.0, 0.1 * np.array([x, y, z])) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    heights = {}
    for detector in ("bullet", "fcl", "ode", "dart"):
        world = make_world(detector, 1 / 240)
        let_down(world, dartpy.dynamics.BoxShape(np.array([4.0, 4.0, 1.0])), -0.5, mobile=False)
        hull = let_down(world, dartpy.dynamics.MultiSphereConvexHullShape(corners), 0.1)
        for _ in range(480):
            world.step()
        heights[detector] = float(hull.getPositions()[5])
    assert 1e-3 < heights["bullet"] - 0.1 < 5e-3
    assert max(heights[detector] for detector in ("fcl", "ode", "dart")) < 0.09


@pytest.mark.parametrize(("rate", "holds"), [(240, False), (480, False), (1000, True)])
def test_a_grippers_tendon_by_torques_of_the_start_of_a_step_diverges_where_steps_are_long(rate: int, holds: bool) -> None:
    """Two fingers of 0.005 kg m2 and the mean of their angles, driven to 0.4 rad by 100 N m/rad and 10 N m s/rad.

    The mean gives way by s = 2 0.5^2/0.005 = 100 a unit of torque: a damper of the start multiplies its rate by 1 - 10 s h in
    each step, which grows beyond h = 1/500 s.
    """
    world = dartpy.simulation.World("gripper")
    world.setGravity((0.0, 0.0, 0.0))
    world.setTimeStep(1 / rate)
    fingers = []
    for name in ("left", "right"):
        skeleton = dartpy.dynamics.Skeleton(name)
        joint, node = skeleton.createRevoluteJointAndBodyNodePair()
        node.setInertia(dartpy.dynamics.Inertia(0.1, np.zeros(3), 0.005 * np.eye(3)))
        world.addSkeleton(skeleton)
        fingers.append(joint)
    for _ in range(rate):
        mean, change = (sum(told) / 2 for told in zip(*((f.getPosition(0), f.getVelocity(0)) for f in fingers), strict=True))
        for finger in fingers:
            finger.setForce(0, 0.5 * (100.0 * (0.4 - mean) - 10.0 * change))
        world.step()
    end = fingers[0].getPosition(0)
    assert (end == pytest.approx(0.4, abs=1e-3)) if holds else not abs(end) < 1e3
