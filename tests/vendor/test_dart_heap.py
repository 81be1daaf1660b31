"""What bounds friction between bodies that move each other, and what a heap costs which solver, in dartpy's own words.

A block slides down a wedge that slides on the level without friction (Meriam and Kraige, Engineering Mechanics: Dynamics, 7th
ed., section 3/4): N (1 + r s^2) = m g c + r s c T with r = m/M, s and c the sine and cosine of the slope, T the friction.
"""

import math
from typing import Any

import numpy as np
import pytest

from tests.vendor.dart_world import UP, dartpy, make_ground, make_mover, make_pose, make_world, moments_of_box, touches

pytestmark = pytest.mark.dart

DT, MU, SLOPE = 1 / 240, 0.2, math.radians(30.0)
HALF = np.array([0.05, 0.05, 0.05])
RATIOS = pytest.mark.parametrize("ratio", [0.25, 1.0, 4.0])


def _sweep(world: Any, most: int = 200) -> None:
    """Sweep contacts of free bodies without a matrix, however few, at most so often in a step; one sweep never ends them."""
    constraints = world.getConstraintSolver()
    options = constraints.getMatrixFreeContactSolverOptions()
    options.mEnabled, options.mMinRows, options.mMaxIterations = True, 1, most
    if most == 1:
        options.mDeltaTolerance = options.mRelativeDeltaTolerance = 0.0
    constraints.setMatrixFreeContactSolverOptions(options)


def _rubbed(ratio: float, solver: Any = None) -> float:
    """T/N of a block on a wedge, the mean from 0.05 to 0.2 s. Args: ratio: its mass over the wedge's."""
    world = make_world("ode", DT)
    if solver is not None:
        world.getConstraintSolver().setBoxedLcpSolver(solver)
    wedge = dartpy.dynamics.Skeleton("wedge")
    joint, node = wedge.createPrismaticJointAndBodyNodePair()
    joint.setAxis((1.0, 0.0, 0.0))
    node.setInertia(dartpy.dynamics.Inertia(1 / ratio, np.zeros(3), np.eye(3)))
    touches(node, dartpy.dynamics.BoxShape(np.array([2.0, 1.0, 0.2])), friction=MU)
    node.getShapeNode(0).setRelativeTransform(make_pose((0.0, SLOPE, 0.0), 0.0))
    world.addSkeleton(wedge)
    away = 0.1 + HALF[2]
    pose = make_pose((0.0, SLOPE, 0.0), away * math.cos(SLOPE), away * math.sin(SLOPE))
    make_mover(world, dartpy.dynamics.BoxShape(2 * HALF), pose, "block", moments=moments_of_box(HALF), friction=MU)
    shares = []
    for k in range(48):
        world.step()
        force = sum(np.array(contact.force) for contact in world.getLastCollisionResult().getContacts())
        if k >= 12:
            across = abs(force[0] * math.sin(SLOPE) + force[2] * math.cos(SLOPE))
            shares.append(math.sqrt(float(force @ force) - across**2) / across)
    return float(np.mean(shares))


@RATIOS
def test_dantzig_bounds_friction_by_the_normal_force_that_there_would_be_without_it(ratio: float) -> None:
    s, c = math.sin(SLOPE), math.cos(SLOPE)
    # T = mu m g c/(1 + r s^2); the normal force that it then presses out is larger. Contacts are soft by 1e-5.
    assert _rubbed(ratio) == pytest.approx(MU / (1 + ratio * MU * s * c / (1 + ratio * s * s)), rel=1e-4)


@RATIOS
def test_the_conic_solver_bounds_it_by_the_normal_force_that_there_is(ratio: float) -> None:
    assert _rubbed(ratio, dartpy.constraint.NsgsFrictionSolver()) == pytest.approx(MU, rel=1e-4)


R, DENSITY = 0.05, 1000.0


def _packing(n: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Centres (n, 3) m of balls that touch in layers of edge^2 and (edge - 1)^2, each in the hollow of four."""
    edge, centres = math.ceil((n / math.sqrt(2)) ** (1 / 3)), []
    for layer in range(n):
        line = np.arange(edge - layer % 2) * 2.0 - (edge - layer % 2 - 1)
        centres += [(x, y, 1 + layer * math.sqrt(2)) for y in line for x in line]
    return R * np.array(centres[:n])


def _heap(n: int, detector: str, most: int | None = None, solver: Any = None) -> tuple[Any, list[Any]]:
    """n balls in a box that just holds them. Args: most: sweeps without a matrix, None of none."""
    world = make_world(detector, DT)
    if solver is not None:
        world.getConstraintSolver().setBoxedLcpSolver(solver)
    if most is not None:
        _sweep(world, most)
    centres = _packing(n)
    half = float(np.abs(centres[:, :2]).max()) + R
    make_ground(world, dartpy.dynamics.BoxShape(np.array([8 * half, 8 * half, 1.0])), make_pose(UP, -0.5), friction=0.5)
    for k, (x, y) in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1))):
        size = np.array([1.0 if x else 8 * half, 1.0 if y else 8 * half, 4.0])
        make_ground(
            world,
            dartpy.dynamics.BoxShape(size),
            make_pose(UP, 2.0, x * (half + 0.5), y * (half + 0.5)),
            f"wall {k}",
            friction=0.5,
        )
    ball, mass = dartpy.dynamics.SphereShape(R), DENSITY * 4 / 3 * math.pi * R**3
    return world, [
        make_mover(world, ball, make_pose(UP, z, x, y), f"ball {k}", mass, 0.4 * R * R, friction=0.5)
        for k, (x, y, z) in enumerate(centres)
    ]


def _places(balls: list[Any]) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array([ball.getWorldTransform().translation() for ball in balls])


def _overlap(balls: list[Any]) -> float:
    """How far [m] two of the balls, or one and the floor, are in each other."""
    p = _places(balls)
    apart = np.linalg.norm(p[:, None] - p[None], axis=2) + np.diag(np.full(len(p), np.inf))
    return max(2 * R - float(apart.min()), R - float(p[:, 2].min()))


@pytest.mark.parametrize("n", [10, 30])
def test_a_heap_swept_without_a_matrix_by_darts_own_detector_holds_and_lies_still(n: int) -> None:
    world, balls = _heap(n, "dart", most=200)
    for _ in range(240):
        world.step()
    # A hundredth of a radius; what falls freely for a step reaches 41 mm/s.
    assert _overlap(balls) < R / 100
    assert np.sqrt(np.mean([np.square(ball.getLinearVelocity()).sum() for ball in balls])) < 9.81 * DT


def test_by_odes_contacts_the_same_sweeps_leave_more() -> None:
    left = {}
    for detector in ("dart", "ode"):
        world, balls = _heap(10, detector, most=200)
        for _ in range(240):
            world.step()
        left[detector] = _overlap(balls)
    assert left["ode"] > 3 * left["dart"]


def test_sweeps_that_do_not_end_leave_a_step_to_dantzig() -> None:
    """Where no change is small enough every number is Dantzig's."""
    places = []
    for most in (None, 1, 200):
        world, balls = _heap(10, "dart", most)
        for _ in range(20):
            world.step()
        places.append(_places(balls))
    assert (places[0] == places[1]).all()
    assert not (places[0] == places[2]).all()


def test_beside_a_conic_solver_nothing_is_swept_without_a_matrix() -> None:
    solver = dartpy.constraint.NsgsFrictionSolver()
    world, _ = _heap(10, "dart", 200, solver)
    for _ in range(5):
        world.step()
    assert solver.getStats().numSolves >= 5


@pytest.mark.parametrize(("count", "reported"), [(240, 960), (260, 1000)])
def test_a_thousand_contacts_of_a_step_are_the_most_and_the_bound_cannot_be_raised(count: int, reported: int) -> None:
    """Boxes at rest with four contacts each; the option that is handed out is a copy."""
    world = make_world("ode", DT)
    make_ground(world, dartpy.dynamics.BoxShape(np.array([20.0, 20.0, 1.0])), make_pose(UP, -0.5))
    for k in range(count):
        pose = make_pose(UP, HALF[2] - 1e-4, 0.3 * (k % 17), 0.3 * (k // 17))
        make_mover(world, dartpy.dynamics.BoxShape(2 * HALF), pose, f"box {k}", moments=moments_of_box(HALF))
    world.getConstraintSolver().getCollisionOption().maxNumContacts = 10_000
    assert world.getConstraintSolver().getCollisionOption().maxNumContacts == 1000
    world.step()
    assert world.getLastCollisionResult().getNumContacts() == reported
