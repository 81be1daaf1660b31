"""A stack under DART's PGS, and a tower at fine steps, in dartpy's own words."""

import numpy as np
import pytest

from tests.vendor.dart_world import UP, G, dartpy, make_ground, make_mover, make_pose, make_world

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


def _sag(rate: int, detector: str, ground: str) -> tuple[float, float]:
    """How far [m] the top of ten cubes built exactly touching comes down within 30 ms at steps of 1/rate s, and stays down."""
    world = make_world(detector, 1 / rate)
    if ground == "plane":
        make_ground(world, dartpy.dynamics.PlaneShape(np.array([0.0, 0.0, 1.0]), 0.0), make_pose(UP, 0.0))
    else:
        make_ground(world, dartpy.dynamics.BoxShape(np.array([4.0, 4.0, 0.2])), make_pose(UP, -0.1))
    cube = dartpy.dynamics.BoxShape(np.full(3, 2 * R))
    boxes = [make_mover(world, cube, make_pose(UP, R * (1 + 2 * i)), f"box {i}") for i in range(10)]
    sunk = []
    for _ in range(round(0.03 * rate)):
        world.step()
        sunk.append(19 * R - float(boxes[-1].getWorldTransform().translation()[2]))
    return max(sunk), sunk[-1]


def _falls(rate: int, steps: int) -> float:
    """How far [m] a body falls in so many steps of semi-implicit Euler."""
    return G / rate**2 * steps * (steps + 1) / 2


@pytest.mark.parametrize(("detector", "ground"), [("ode", "plane"), ("ode", "box"), ("bullet", "box"), ("fcl", "box")])
def test_a_tower_comes_down_by_the_steps_until_all_supports_show_at_any_detector(detector: str, ground: str) -> None:
    # Whether two that touch exactly overlap is a matter of rounding: here the last support shows after three steps.
    assert _sag(1920, detector, ground)[0] == pytest.approx(_falls(1920, 3), rel=1e-6)


@pytest.mark.parametrize("rate", [1920, 3840, 7680])
def test_what_a_tower_sags_by_is_of_second_order_and_is_taken_back_by_a_hundredth_a_step(rate: int) -> None:
    most, last = _sag(rate, "ode", "plane")
    assert any(most == pytest.approx(_falls(rate, steps), rel=1e-6) for steps in range(1, 11))
    # 0.01 of the depth of each of ten contacts: after n steps of 30 ms the share of 0.99^n is left.
    assert last < most * 0.99 ** (0.03 * rate / 2)


def test_the_share_that_contacts_take_back_has_no_name_in_dartpy() -> None:
    """In C++ it is ContactConstraint::setErrorReductionParameter."""
    assert not hasattr(dartpy.constraint, "ContactConstraint")
