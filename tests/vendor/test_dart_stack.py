"""A stack under DART's PGS, in dartpy's own words."""

import numpy as np
import pytest

from tests.vendor.dart_world import UP, dartpy, make_ground, make_mover, make_pose, make_world

pytestmark = pytest.mark.dart

DT, R = 1 / 240, 0.1


def _stack(absolute: float | None = None, relative: float | None = None) -> float:
    """How far [m] the worst of three boxes of a stack has moved after 0.5 s, by DART's PGS of at most 1000 sweeps."""
    world = make_world("ode", DT)
    solver = world.getConstraintSolver()
    make_ground(world, dartpy.dynamics.BoxShape(np.array([4.0, 4.0, 0.2])), make_pose(UP, -0.1))
    cube, heights = dartpy.dynamics.BoxShape(np.full(3, 2 * R)), [R * (1 + 2 * i) for i in range(3)]
    boxes = [make_mover(world, cube, make_pose(UP, height), f"box at {height}") for height in heights]
    option = dartpy.constraint.PgsBoxedLcpSolverOption()
    option.mMaxIteration = 1000
    if absolute is not None:
        option.mDeltaXThreshold = absolute
    if relative is not None:
        option.mRelativeDeltaXTolerance = relative
    pgs = solver.getSecondaryBoxedLcpSolver()
    pgs.setOption(option)
    solver.setBoxedLcpSolver(pgs)
    for _ in range(120):
        world.step()
    places = np.array([node.getWorldTransform().translation() for node in boxes])
    return float(np.abs(places - np.array([(0.0, 0.0, height) for height in heights])).max())


def test_the_sweeps_of_pgs_end_at_its_relative_tolerance_and_not_at_its_absolute_one() -> None:
    usual = _stack()
    assert _stack(absolute=1e-7) == usual
    # 0.12 mm; 0.05 are left by the softness of contacts, and by any other solver.
    assert _stack(relative=1e-7) < usual / 2
