"""The contact solvers: the one that suits a scene, how a world is given it, what it then uses."""

import math
from dataclasses import dataclass
from typing import Any, assert_never

import numpy as np

from adapters.dart.surfaces import touching_bodies
from harness.adapter import Settings
from harness.scene import Box, Capsule, ConvexHull, Cylinder, Effect, Ellipsoid, Plane, Scene, Shape, Sphere, TriangleMesh

__all__ = ["SOLVERS", "SolverInUse", "choose_solver", "set_solver"]

SOLVERS = ("dantzig", "pgs", "matrix_free", "nsgs", "fbf")
CONE_TOLERANCE = 1e-6
"""Where the conic solver of 'auto' stops. By the vendor's 1e-5 the case friction_wall_pinch errs by 21 mm at 1/240 s, by this
one by 8.2 mm, as the exact Dantzig does."""
MANY_BODIES = 16
"""Above this number of movable bodies 'auto' leaves the conic solver, whose cost grows fastest."""


@dataclass(frozen=True, slots=True)
class SolverInUse:
    """A world's solver, read back from it.

    Terms: cone: the solver of the exact friction cone, which counts its solves; None where there is none.
    """

    name: str
    iterations: int | None
    tolerance: float | None
    cone: Any = None


def set_solver(dart: Any, world: Any, scene: Scene, settings: Settings) -> SolverInUse:
    """Give a world the solver that the settings ask for."""
    constraint, solver = dart.constraint, world.getConstraintSolver()
    name = choose_solver(scene, settings.solver)
    iterations, tolerance, cone = settings.iterations, settings.tolerance, None
    if settings.solver == "auto" and tolerance is None:
        tolerance = CONE_TOLERANCE
    if name in ("nsgs", "fbf"):
        cone = constraint.NsgsFrictionSolver() if name == "nsgs" else constraint.FbfFrictionSolver()
        most = "maxSweeps" if name == "nsgs" else "maxOuterIterations"
        choice = cone.getOptions()
        if iterations is not None:
            setattr(choice, most, iterations)
        if tolerance is not None:
            choice.tolerance = tolerance
        cone.setOptions(choice)
        solver.setBoxedLcpSolver(cone)
        choice = cone.getOptions()
        iterations, tolerance = int(getattr(choice, most)), float(choice.tolerance)
    elif name == "pgs":
        pgs, choice = solver.getSecondaryBoxedLcpSolver(), constraint.PgsBoxedLcpSolverOption()
        if iterations is not None:
            choice.mMaxIteration = iterations
        if tolerance is not None:
            # Of these two the relative one, 1e-3 by default, ends the sweeps whatever the other says.
            choice.mDeltaXThreshold = choice.mRelativeDeltaXTolerance = tolerance
        pgs.setOption(choice)
        solver.setBoxedLcpSolver(pgs)
        iterations, tolerance = int(choice.mMaxIteration), float(choice.mDeltaXThreshold)
    elif name == "matrix_free":
        swept = solver.getMatrixFreeContactSolverOptions()
        swept.mEnabled, swept.mMinRows = True, 1
        if iterations is not None:
            swept.mMaxIterations = iterations
        if tolerance is not None:
            swept.mDeltaTolerance = swept.mRelativeDeltaTolerance = tolerance
        solver.setMatrixFreeContactSolverOptions(swept)
        swept = solver.getMatrixFreeContactSolverOptions()
        iterations, tolerance = int(swept.mMaxIterations), float(swept.mDeltaTolerance)
    else:
        iterations = tolerance = None
    if solver.getMatrixFreeContactSolverOptions().mEnabled:
        return SolverInUse("matrix_free", iterations, tolerance, cone)
    kinds = {
        "DantzigBoxedLcpSolver": "dantzig",
        "PgsBoxedLcpSolver": "pgs",
        "NsgsFrictionSolver": "nsgs",
        "FbfFrictionSolver": "fbf",
    }
    return SolverInUse(kinds[solver.getBoxedLcpSolver().getType()], iterations, tolerance, cone)


def choose_solver(scene: Scene, asked: str | None) -> str:
    """'auto': the exact cone where bodies slide on their own, Dantzig where they lean on each other or are many.

    On stacks the conic solvers cost some hundred times as much and stop at their iteration cap; stacks hardly slide.
    """
    if asked != "auto":
        return asked or "dantzig"
    bodies = [b for b in touching_bodies(scene) if b.movable]
    if Effect.FRICTION not in scene.effects or not bodies or len(bodies) > MANY_BODIES:
        return "dantzig"
    p_WB = np.array([b.p_WB for b in bodies])
    reach = np.array([max(math.hypot(*p.p_BS) + _reach(p.shape) for p in b.collision) for b in bodies])
    gap = np.linalg.norm(p_WB[:, None] - p_WB[None], axis=2) - 1.01 * (reach[:, None] + reach[None])
    np.fill_diagonal(gap, np.inf)
    return "dantzig" if (gap <= 0).any() else "nsgs"


def _reach(shape: Shape) -> float:
    """Radius [m] of the ball about the origin of S that holds the shape."""
    match shape:
        case Sphere(radius=r):
            return r
        case Box(half_extents=half):
            return math.hypot(*half)
        case Capsule(radius=r, half_length=h):
            return r + h
        case Cylinder(radius=r, half_length=h):
            return math.hypot(r, h)
        case Ellipsoid(semi_axes=semi_axes):
            return max(semi_axes)
        case Plane():
            return math.inf
        case ConvexHull(vertices=vertices) | TriangleMesh(vertices=vertices):
            return float(np.linalg.norm(np.asarray(vertices), axis=1).max())
        case _:
            assert_never(shape)
