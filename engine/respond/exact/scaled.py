"""A contact problem in variables of order one, where every cone is |x_T| <= x_N.

x = scale r / unit with one number per contact times the friction on the normal, so that the blocks of W have a mean diagonal
of one and the free velocities a largest component of one. Frictionless contacts keep their normal alone.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.types import Floats
from plumbline.engine.respond.exact.blocks import FineArray, positive_part
from plumbline.engine.respond.exact.law import Problem, relative_residual


@kernel
def write_scale(w: Floats, q: Floats, friction: Floats, scaled_w: Floats, scaled_q: Floats, scale: Floats) -> float:
    """Write the scaled form of a problem. Args: as of `Problem` and `Scaled`. Returns: the unit of the free velocities."""
    k, unit = len(q), 0.0
    per = np.zeros((k, 3))  # 1/scale; zero where a component is held at zero
    for i in range(k):
        mu, sizes = friction[i], w[3 * i, 3 * i]
        if mu > 0.0:
            sizes = (sizes / (mu * mu) + w[3 * i + 1, 3 * i + 1] + w[3 * i + 2, 3 * i + 2]) / 3.0
        scale[i, 0] = math.sqrt(sizes) * (mu if mu > 0.0 else 1.0)
        scale[i, 1] = scale[i, 2] = math.sqrt(sizes)
        for c in range(3 if mu > 0.0 else 1):
            per[i, c] = 1.0 / scale[i, c]
        for c in range(3):
            scaled_q[i, c] = q[i, c] * per[i, c]
            unit = max(unit, abs(scaled_q[i, c]))
    unit = unit if unit > 0.0 else 1.0
    for i in range(k):
        for c in range(3):
            scaled_q[i, c] /= unit
            for j in range(k):
                for d in range(3):
                    scaled_w[3 * i + c, 3 * j + d] = w[3 * i + c, 3 * j + d] * (per[i, c] * per[j, d])
    return unit


@entry
def write_scaled(w: Floats, q: Floats, friction: Floats, scaled_w: Floats, scaled_q: Floats, scale: Floats) -> float:
    """As `write_scale`, from Python."""
    return write_scale(w, q, friction, scaled_w, scaled_q, scale)


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
