"""A contact problem in variables of order one, where every cone is |x_T| <= x_N.

x = scale r / unit with one number per contact times the friction on the normal, so that the blocks of W have a mean diagonal
of one and the free velocities a largest component of one. Frictionless contacts keep their normal alone.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.maths.types import Floats
from plumbline.engine.respond.exact.blocks import FineArray, positive_part
from plumbline.engine.respond.exact.law import Problem
from plumbline.engine.respond.exact.residual import relative_residual
from plumbline.engine.respond.exact.scaling import write_scaled


@dataclass(frozen=True)
class Scaled:
    """A problem and its scaled form.

    Terms:
        w (3k, 3k), q (k, 3): of order one; rubs (k,): contacts with friction; kept (k, 3): False for components held at zero;
        scale (k, 3), unit: x = scale r / unit.
    """

    problem: Problem
    w: Floats
    q: Floats
    rubs: NDArray[np.bool_]
    kept: NDArray[np.bool_]
    scale: Floats
    unit: float

    @cached_property
    def fine(self) -> FineArray:
        """W with more digits and without the negative eigenvalues of its round-off."""
        return positive_part(self.w)

    def impulse(self, x: Floats) -> Floats:
        """Impulses r (k, 3) N s of scaled ones."""
        return np.asarray(np.where(self.kept, x * self.unit / self.scale, 0.0))

    def residual(self, x: Floats) -> float:
        """The certificate of scaled impulses."""
        return relative_residual(self.problem, self.impulse(x))


def scale_problem(problem: Problem) -> Scaled:
    """The scaled form of a problem with at least one contact and a speed above zero."""
    k, rubs = problem.size, problem.friction > 0.0
    kept = np.ones((k, 3), np.bool_)
    kept[~rubs, 1:] = False
    w, q, scale = np.empty((3 * k, 3 * k)), np.empty((k, 3)), np.empty((k, 3))
    unit = float(write_scaled(problem.inverse_mass, problem.velocity, problem.friction, w, q, scale))
    return Scaled(problem, w, q, rubs, kept, scale, unit)
