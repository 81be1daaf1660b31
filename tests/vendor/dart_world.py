"""A world of dartpy of one's own, for scripts in the vendor's words."""

from typing import Any

import numpy as np
import pytest

dartpy = pytest.importorskip("dartpy", reason="DART is not installed")

G = 9.81
UP = (0.0, 0.0, 0.0)
"""No turn, as a rotation vector [rad]."""


def make_pose(turn: tuple[float, float, float], z: float, x: float = 0.0, y: float = 0.0) -> Any:
    pose = dartpy.math.Isometry3()
    pose.set_rotation(dartpy.math.expMapRot(np.array(turn)))
    pose.set_translation(np.array([x, y, z]))
    return pose


def make_world(detector: str, dt: float, sleeping: bool = False) -> Any:
    world = dartpy.simulation.World("facts")
    world.setTimeStep(dt)
    world.setGravity((0.0, 0.0, -G))
    world.setCollisionDetector(getattr(dartpy.simulation.CollisionDetectorType, detector.upper()))
    options = world.getDeactivationOptions()
    options.mEnabled = sleeping
    world.setDeactivationOptions(options)
    return world


def touches(node: Any, shape: Any, friction: float = 0.8, restitution: float = 0.0, z: float = 0.0) -> None:
    """Give a body a shape that collides, this far [m] up in its frame."""
    placed = node.createShapeNode(shape)
    placed.setRelativeTranslation(np.array([0.0, 0.0, z]))
    placed.createCollisionAspect()
    placed.createDynamicsAspect()
    placed.getDynamicsAspect().setFrictionCoeff(friction)
    placed.getDynamicsAspect().setRestitutionCoeff(restitution)


def make_ground(world: Any, shape: Any, pose: Any, name: str = "ground", **surface: float) -> None:
    """Something that stands still."""
    ground = dartpy.dynamics.Skeleton(name)
    joint, node = ground.createWeldJointAndBodyNodePair()
    joint.setTransformFromParentBodyNode(pose)
    touches(node, shape, **surface)
    ground.setMobile(False)
    world.addSkeleton(ground)


def make_mover(
    world: Any, shape: Any, pose: Any, name: str = "mover", mass: float = 1.0, moments: Any = 1 / 150, **surface: float
) -> Any:
    """A free body. Args: moments: about its centre, as if it weighed 1 kg [m2]; those of a cube of 0.2 m unless said."""
    mover = dartpy.dynamics.Skeleton(name)
    joint, node = mover.createFreeJointAndBodyNodePair()
    node.setInertia(dartpy.dynamics.Inertia(mass, np.zeros(3), mass * np.eye(3) * moments))
    touches(node, shape, **surface)
    joint.setTransform(pose)
    world.addSkeleton(mover)
    return node


def moments_of_box(half: Any) -> Any:
    """Of a box of 1 kg of these half extents [m], about its axes (3,) [kg m2]."""
    squares = np.square(half)
    return (squares.sum() - squares) / 3
