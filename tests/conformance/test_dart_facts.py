"""What DART does by itself, asked through dartpy alone: the facts that the adapter's deviations and choices stand on."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.trajectory import Floats

dartpy = pytest.importorskip("dartpy", reason="DART is not installed")

G, DT, R = 9.81, 1 / 240, 0.1
SUNK = G * DT**2
"""What a body falls in the step before a contact is found [m]: who rests gives way by less, who sinks by more."""
SIDE = (np.pi / 2, 0.0, 0.0)
UP = (0.0, 0.0, 0.0)


def _pose(turn: tuple[float, float, float], z: float) -> Any:
    pose = dartpy.math.Isometry3()
    pose.set_rotation(dartpy.math.expMapRot(np.array(turn)))
    pose.set_translation(np.array([0.0, 0.0, z]))
    return pose


def _world(detector: str) -> Any:
    world = dartpy.simulation.World("facts")
    world.setTimeStep(DT)
    world.setGravity((0.0, 0.0, -G))
    world.setCollisionDetector(getattr(dartpy.simulation.CollisionDetectorType, detector.upper()))
    sleeping = world.getDeactivationOptions()
    sleeping.mEnabled = False
    world.setDeactivationOptions(sleeping)
    return world


def _touches(node: Any, shape: Any, friction: float = 0.8) -> None:
    placed = node.createShapeNode(shape)
    placed.createCollisionAspect()
    placed.createDynamicsAspect()
    placed.getDynamicsAspect().setFrictionCoeff(friction)


def _ground(world: Any, shape: Any, pose: Any) -> None:
    ground = dartpy.dynamics.Skeleton("ground")
    joint, node = ground.createWeldJointAndBodyNodePair()
    joint.setTransformFromParentBodyNode(pose)
    _touches(node, shape)
    ground.setMobile(False)
    world.addSkeleton(ground)


def _mover(world: Any, shape: Any, pose: Any) -> Any:
    mover = dartpy.dynamics.Skeleton("mover")
    joint, node = mover.createFreeJointAndBodyNodePair()
    node.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 150))
    _touches(node, shape)
    joint.setTransform(pose)
    world.addSkeleton(mover)
    return node


def _mesh(folder: Path, half: tuple[float, float, float]) -> Any:
    """A box as a triangle mesh; dartpy makes one from a file only."""
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = ["1 2 4", "1 4 3", "5 7 8", "5 8 6", "1 5 6", "1 6 2", "3 4 8", "3 8 7", "1 3 7", "1 7 5", "2 6 8", "2 8 4"]
    lines = ["v {} {} {}".format(*(a * b for a, b in zip(corner, half, strict=True))) for corner in corners]
    path = folder / "box.obj"
    path.write_text("\n".join(lines + [f"f {face}" for face in faces]) + "\n", encoding="ascii")
    geometry = f'<geometry><mesh filename="{path.as_uri()}"/></geometry>'
    urdf = f'<robot name="m"><link name="m"><collision>{geometry}</collision></link></robot>'
    reader, files = dartpy.utils.DartLoader(), dartpy.common.LocalResourceRetriever()
    return reader.parseSkeletonString(urdf, dartpy.common.Uri("file:///"), files).getBodyNode(0).getShapeNode(0).getShape()


def _shapes(folder: Path) -> dict[str, tuple[Any, Any]]:
    """Supports by name: shape, and its pose with the top at z = 0."""
    dynamics = dartpy.dynamics
    return {
        "plane": (dynamics.PlaneShape(np.array([0.0, 0.0, 1.0]), 0.0), _pose(UP, 0.0)),
        "box": (dynamics.BoxShape(np.array([1.0, 1.0, 0.2])), _pose(UP, -0.1)),
        "end of a cylinder": (dynamics.CylinderShape(0.5, 0.2), _pose(UP, -0.1)),
        "lying cylinder": (dynamics.CylinderShape(0.5, 0.6), _pose((0.0, np.pi / 2, 0.0), -0.5)),
        "lying capsule": (dynamics.CapsuleShape(0.5, 0.6), _pose((0.0, np.pi / 2, 0.0), -0.5)),
        "mesh": (_mesh(folder, (0.5, 0.5, 0.1)), _pose(UP, -0.1)),
    }


def _movers() -> dict[str, tuple[Any, Any]]:
    """Movers by name: shape, and its pose above z = 0, which it touches with its centre at R."""
    dynamics = dartpy.dynamics
    return {
        "box": (dynamics.BoxShape(np.full(3, 2 * R)), _pose(UP, R)),
        "capsule": (dynamics.CapsuleShape(R, 0.3), _pose(SIDE, R)),
        "lying cylinder": (dynamics.CylinderShape(R, 0.3), _pose(SIDE, R)),
        "standing cylinder": (dynamics.CylinderShape(R, 2 * R), _pose(UP, R)),
    }


def _lost(folder: Path, detector: str, support: str, mover: str, askew: bool = False) -> float:
    """The height [m] that a body has lost 3 s after it was laid down, in the middle or turned beside it."""
    world = _world(detector)
    _ground(world, *_shapes(folder)[support])
    shape, pose = _movers()[mover]
    if askew:
        pose.set_rotation(dartpy.math.expMapRot(np.array([0.0, 0.0, 0.3])) @ pose.rotation())
        pose.set_translation(np.array([0.13, 0.07, R]))
    node = _mover(world, shape, pose)
    for _ in range(720):
        world.step()
    return R - float(node.getWorldTransform().translation()[2])


@pytest.mark.parametrize(
    ("detector", "support", "mover"),
    [
        ("ode", "box", "capsule"),
        ("ode", "lying capsule", "box"),
        ("ode", "end of a cylinder", "capsule"),
        ("ode", "lying capsule", "standing cylinder"),
        ("ode", "end of a cylinder", "lying cylinder"),
        ("ode", "lying cylinder", "standing cylinder"),
        ("fcl", "box", "capsule"),
        ("fcl", "box", "standing cylinder"),
        ("fcl", "box", "lying cylinder"),
        ("fcl", "lying cylinder", "box"),
        ("fcl", "end of a cylinder", "lying cylinder"),
        ("dart", "box", "lying cylinder"),
        ("dart", "end of a cylinder", "capsule"),
        ("dart", "end of a cylinder", "lying cylinder"),
        ("dart", "lying capsule", "box"),
        ("bullet", "mesh", "lying cylinder"),
        ("bullet", "mesh", "standing cylinder"),
        ("bullet", "mesh", "box"),
    ],
)
def test_pairs_that_a_detector_has_wrong_sink(tmp_path: Path, detector: str, support: str, mover: str) -> None:
    assert _lost(tmp_path, detector, support, mover, askew=support == "mesh") > SUNK


@pytest.mark.parametrize("mover", ["box", "capsule", "lying cylinder", "standing cylinder"])
@pytest.mark.parametrize("support", ["box", "end of a cylinder", "lying cylinder", "lying capsule"])
def test_the_bullet_detector_holds_every_pair_of_round_and_flat_shapes(tmp_path: Path, support: str, mover: str) -> None:
    assert abs(_lost(tmp_path, "bullet", support, mover)) < SUNK


@pytest.mark.parametrize("detector", ["fcl", "dart", "bullet"])
def test_a_box_on_a_plane_has_one_contact_by_every_detector_but_ode(tmp_path: Path, detector: str) -> None:
    counts = []
    for name in (detector, "ode"):
        world = _world(name)
        _ground(world, *_shapes(tmp_path)["plane"])
        _mover(world, _movers()["box"][0], _pose(UP, R - 1e-4))
        world.step()
        counts.append(world.getLastCollisionResult().getNumContacts())
    assert counts == [1, 4]


def _wedge(spring: bool) -> Floats:
    """Coordinates of a slider that stands on a box and carries a hinged weight, 1 s after it was set down in equilibrium.

    Along z a slider of 2 kg; on it a hinge about y with a bar of 1 kg and 0.3 m, level, held by k = 200, d = 20: by a joint
    spring, or by the same law as a torque of the start of each step.
    """
    world = _world("ode")
    _ground(world, dartpy.dynamics.BoxShape(np.array([1.0, 1.0, 0.2])), _pose(UP, -0.1))
    skeleton = dartpy.dynamics.Skeleton("wedge")
    slider, foot = skeleton.createPrismaticJointAndBodyNodePair()
    slider.setAxis(np.array([0.0, 0.0, 1.0]))
    foot.setInertia(dartpy.dynamics.Inertia(2.0, np.zeros(3), np.eye(3) / 10))
    _touches(foot, dartpy.dynamics.BoxShape(np.full(3, 2 * R)))
    slider.setPosition(0, R - 1e-6)
    hinge, bar = skeleton.createRevoluteJointAndBodyNodePair(foot)
    hinge.setAxis(np.array([0.0, 1.0, 0.0]))
    bar.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.eye(3) / 10))
    lever = dartpy.math.Isometry3()
    lever.set_translation(np.array([-0.3, 0.0, 0.0]))
    hinge.setTransformFromChildBodyNode(lever)
    stiffness, damping = 200.0, 20.0
    # About +y the weight at +x turns the bar down by m g l; the spring's rest lies as far above.
    rest = -G * 0.3 / stiffness
    if spring:
        hinge.setSpringStiffness(0, stiffness)
        hinge.setRestPosition(0, rest)
        hinge.setDampingCoefficient(0, damping)
    world.addSkeleton(skeleton)
    for _ in range(240):
        if not spring:
            hinge.setForce(0, stiffness * (rest - hinge.getPosition(0)) - damping * hinge.getVelocity(0))
        world.step()
    return np.array([slider.getPosition(0) - R, hinge.getPosition(0)])


def test_a_joint_spring_in_equilibrium_sags_where_a_contact_bears_it_and_a_torque_does_not() -> None:
    sprung, pushed = abs(_wedge(spring=True)[1]), abs(_wedge(spring=False)[1])
    # Statics leaves the bar level. In the first step the foot falls by g dt^2, which the bar feels over its lever.
    assert pushed < SUNK / 0.3
    assert sprung > 10 * SUNK / 0.3
