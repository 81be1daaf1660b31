"""Steps of worlds with contact under the exact solver: find contacts, then in each sub-step kick, solve, certify, drift."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine import arena as at
from engine.arena import int_table
from engine.bodies import Surface
from engine.errors import NotSupported
from engine.exact.kernels import begin_step, drift_touched, kick_touched
from engine.exact.problem import apply_impulse, assemble_problem
from engine.exact.solver import solve
from engine.options import Options

__all__ = ["Certificate", "ExactSteps"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Certificate:
    """What was certified so far.

    Terms:
        residual: the largest relative residual of a solve [1]; solves: how many there were; missed: how many ended above the
        tolerance.
    """

    residual: float = 0.0
    solves: int = 0
    missed: int = 0


class ExactSteps:
    """The step of one world, with the record of its residuals.

    Args: options: time step, sub-steps and tolerance; surfaces: all laws of the world; jointed: whether it has joints.
    Raises: NotSupported for joints, for static friction above kinetic, for rolling and for torsional friction.
    """

    def __init__(self, options: Options, surfaces: Iterable[Surface], jointed: bool) -> None:
        if jointed:
            raise NotSupported("joints beside contacts", "the exact solver knows contacts only")
        for law in surfaces:
            if law.static_friction > law.kinetic_friction:
                raise NotSupported("static friction above kinetic", "the exact solver has Coulomb's law with one coefficient")
            if law.rolling_friction > 0.0 or law.torsional_friction > 0.0:
                raise NotSupported("rolling or torsional friction", "the exact solver has forces at points only")
        self._h, self._substeps, self._tolerance = options.dt / options.substeps, options.substeps, options.tolerance
        self.certificate = Certificate()

    def __call__(self, floats: FloatArray, ints: IntArray, steps: int) -> tuple[int, int]:
        """Advance bodies in contact. Returns: steps done and a status, as `step_contact`."""
        for step in range(steps):
            status = int(begin_step(floats, ints))
            if status != 0:
                return step, status
            for substep in range(self._substeps):
                kick_touched(floats, ints, self._h)
                if int_table(ints, at.COUNT)[0, at.MANIFOLDS] > 0:
                    self._respond(floats, ints)
                if drift_touched(floats, ints, self._h, int(substep == self._substeps - 1)):
                    return step + 1, 1
        return steps, 0

    def _respond(self, floats: FloatArray, ints: IntArray) -> None:
        """Solve the contacts of one sub-step, apply the impulses, and record how exact they are."""
        problem, frames, brought = assemble_problem(floats, ints, self._h)
        if not np.isfinite(problem.velocity).all():
            return
        solution = solve(problem, self._tolerance, guess=brought if brought.any() else None)
        apply_impulse(floats, ints, frames, solution.impulse)
        past = self.certificate
        self.certificate = Certificate(
            residual=max(past.residual, solution.residual),
            solves=past.solves + 1,
            missed=past.missed + int(solution.residual > self._tolerance),
        )
