"""A fast top in DART, on a ball joint and on a constraint, in dartpy's own words.

A tenth of the stem counts as lost; a top that lies down is two stems away.
"""

from collections.abc import Iterator

import numpy as np
import pytest

from tests.vendor import spinning
from tests.vendor.dart_world import dartpy, make_pose, make_world

pytestmark = pytest.mark.dart

CONSTRAINT = dartpy.constraint.DynamicJointConstraint


@pytest.fixture(autouse=True)
def _error_reduction_as_it_was() -> Iterator[None]:
    """It is one number for all of the process."""
    before = CONSTRAINT.getErrorReductionParameter()
    yield
    CONSTRAINT.setErrorReductionParameter(before)


def lean(joint: str, speed: float, dt: float) -> tuple[float, float]:
    """How far [m] a top of this speed [rad/s] gets from its way within 2 s, and its tip from where it is held.

    Args: joint: "coordinates" is a BallJoint, "constraint" a BallJointConstraint that holds a body under a FreeJoint.
    """
    world = make_world("fcl", dt)
    skeleton = dartpy.dynamics.Skeleton("top")
    at, w = spinning.centre(speed, 0.0), spinning.top_rate(speed)
    pose = make_pose((0.0, spinning.TILT, 0.0), at[2], at[0], at[1])
    if joint == "coordinates":
        held, node = skeleton.createBallJointAndBodyNodePair()
        held.setTransformFromChildBodyNode(pose.inverse())
    else:
        held, node = skeleton.createFreeJointAndBodyNodePair()
        held.setTransform(pose)
    node.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.diag(spinning.TOP)))
    wanted = np.concatenate((w, np.cross(w, at)))
    skeleton.setVelocities(np.linalg.lstsq(np.asarray(skeleton.getWorldJacobian(node)), wanted, rcond=None)[0])
    world.addSkeleton(skeleton)
    if joint == "constraint":
        world.getConstraintSolver().addConstraint(dartpy.constraint.BallJointConstraint(node, np.zeros(3)))
    off, gap = 0.0, 0.0
    for n in range(1, round(2 / dt) + 1):
        world.step()
        pose = node.getTransform()
        off = max(off, float(np.linalg.norm(pose.translation() - spinning.centre(speed, n * dt))))
        gap = max(gap, float(np.linalg.norm(pose.translation() - spinning.STEM * pose.rotation()[:, 2])))
    return off, gap


@pytest.mark.parametrize("joint", ["coordinates", "constraint"])
def test_a_top_of_100_rad_per_s_is_lost_at_1_240_s(joint: str) -> None:
    assert lean(joint, 100.0, 1 / 240)[0] > spinning.STEM / 10


SPINS = pytest.mark.parametrize("speed", [100.0, 400.0, 1600.0])


@SPINS
def test_a_top_on_a_ball_joint_falls_over_where_one_on_a_ball_joint_constraint_stays_on_its_way(speed: float) -> None:
    assert lean("coordinates", speed, 1 / 960)[0] > spinning.STEM / 10
    assert lean("constraint", speed, 1 / 960)[0] < spinning.STEM / 10


@SPINS
def test_a_top_on_a_constraint_converges_in_first_order(speed: float) -> None:
    coarse, fine = (lean("constraint", speed, dt)[0] for dt in (1 / 960, 1 / 1920))
    # Half the step, half the error, which a gap of second order makes smaller: a tenth of the error at the coarser step.
    assert 0.4 < fine / coarse < 0.6


def test_the_gap_of_a_constraint_is_what_its_error_reduction_leaves() -> None:
    """A step leaves the circle by a constant way and heals a share of the gap, so that way over share is left of it."""
    gaps = {}
    for share in (0.1, 0.2, 0.4):
        CONSTRAINT.setErrorReductionParameter(share)
        gaps[share] = lean("constraint", 200.0, 1 / 960)[1]
    # Nutation makes the way a tenth longer here and shorter there.
    assert gaps[0.1] == pytest.approx(2 * gaps[0.2], rel=0.1)
    assert gaps[0.2] == pytest.approx(2 * gaps[0.4], rel=0.1)
