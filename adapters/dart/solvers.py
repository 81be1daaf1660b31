"""The contact solvers: the one that suits a scene, how a world is given it, what it then uses."""

import math
from dataclasses import dataclass
from typing import Any

from plumbline.adapters.dart.arrangement import Arrangement
from plumbline.harness.adapter import Settings
from plumbline.harness.scene import Effect, Scene, Sphere

SOLVERS = ("dantzig", "pgs", "matrix_free", "nsgs", "fbf")
FAST, FINE_TOLERANCE = 0.08, 1e-6
"""Where gravity gives a body more speed [m/s] in a step than the first the conic solver of 'auto' stops at the second, else at
the vendor's 1e-5: it starts anew in each step, from contacts that bear nothing.

Cubes pressed on a wall by twice their weight creep by .12 mm/s at 1e-5 and are 21 mm off after a second at 1/240 s (.091 m/s a
step), at 1e-6 8.2 mm, as by Dantzig; a box on an incline at 1/60 s (.16 m/s) creeps by .5 mm/s at 1e-5 and 1.3e-3 mm/s at 1e-6.
At .077 m/s and less both err alike, and at 1/240 s tall boxes on inclines cost three times as much at the finer.
"""
MANY_BODIES = 16
"""Above this number of bodies 'auto' leaves the conic solver, whose cost grows fastest: an arch of 9 blocks takes 4.5 ms a step
by it and 1.0 by Dantzig, one of 15 takes 11 ms and 3. Sweeps without a matrix pay for boxes from there on: 1.2 ms become 0.5
for 20 that are pushed about, 12 become 1.8 for 64."""
HEAP_OF_BALLS = 5
"""From so many balls that are near each other on 'auto' sweeps without a matrix: 4 cost alike by all solvers, 6 take 0.10 ms a
step for Dantzig's 0.19 and the conic solver's 1.5, 20 take 0.3 ms for 4 and 12."""
HEAP_SWEEPS = 200
"""Greatest number of sweeps without a matrix; a step that has not come to rest by then is Dantzig's, of 2 and 4 s for 150 and
200 balls, which the vendor's 30 leave to it."""


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
    if settings.solver == "auto":
        if name == "nsgs" and tolerance is None and math.hypot(*scene.gravity) * world.getTimeStep() > FAST:
            tolerance = FINE_TOLERANCE
        if name == "matrix_free" and iterations is None:
            iterations = HEAP_SWEEPS
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
    """'auto': the exact cone where friction can bear a load, swept without a matrix in heaps, else Dantzig.

    Dantzig bounds friction by the normal force that there would be without friction: a block that slides down a loose wedge
    is rubbed by .187 N where mu N is .2 N, an arch falls at a friction of .5 that stands at .4 by the conic solver, and so does
    a house of cards with a tenth more than it needs. The conic solver starts anew in each step and stops at its cap where
    boxes are stacked, on which it costs five to twenty times as much and errs by .9 % in what bears a load of 10 : 1; stacks
    stand without friction.
    """
    if asked != "auto":
        return asked or "dantzig"
    start = Arrangement(scene)
    if Effect.FRICTION not in scene.effects or not start.bodies:
        return "dantzig"
    if not start.near:
        return "nsgs" if len(start.bodies) <= MANY_BODIES else "dantzig"
    if start.jointed or start.stacked:
        return "dantzig"
    balls = [b for b in start.crowd if all(isinstance(placed.shape, Sphere) for placed in b.collision)]
    if len(balls) >= HEAP_OF_BALLS or len(start.crowd) > MANY_BODIES:
        return "matrix_free"
    return "nsgs" if start.touching else "dantzig"
