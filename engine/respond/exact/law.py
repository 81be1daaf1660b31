"""One step's contacts as a complementarity problem in impulses, u = W r + q between relative velocity and impulse; and its
certificate: how far impulses are from Signorini's and Coulomb's law, whoever found them; and its form in units of its own.

Every contact alpha has the frame (normal, tangent, tangent) and the law of Signorini and Coulomb, in De Saxce's form one cone
complementarity with the velocity v = u + (mu |u_T|, 0, 0):

    r in K,  v in K*,  r . v = 0,  K = {|r_T| <= mu r_N}

The natural map of each contact, F = r - P_K(r - m v), with P_K the projection onto Coulomb's cone and m an effective mass of
the contact, vanishes exactly at the solutions. As a velocity, |F| / m, and relative to the speed that the step starts from, it
judges light and heavy bodies alike: where the ratio of masses is R, an error that is seen only relative to the largest impulse
could be R times larger.

The methods work on variables of order one, where every cone is |x_T| <= x_N: x = scale r / unit with one number per contact
times the friction on the normal, so that the blocks of W have a mean diagonal of one and the free velocities a largest
component of one. Frictionless contacts keep their normal alone.

Source: De Saxce, Feng, The bipotential method, Math. Comput. Modelling 28, 1998; Acary, Cadoux, Applications of an existence
result for the Coulomb friction problem, 2013; Alart, Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991; Acary, Bremond, Huber,
On solving contact problems with Coulomb friction, 2018 (section 3.2).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.elementary import hypot
from plumbline.engine.maths.rows import Floats


@dataclass(frozen=True, slots=True)
class Problem:
    """Contacts of one step.

    Terms:
        inverse_mass (3k, 3k) 1/kg: W = J M^-1 J^T, symmetric, positive semi-definite; velocity (k, 3) m/s: q, what the law sees
        at no impulse; friction (k,); speed [m/s]: the largest relative velocity the step starts from, the unit of residuals.
    """

    inverse_mass: Floats
    velocity: Floats
    friction: Floats
    speed: float

    @property
    def tables(self) -> tuple[Floats, Floats, Floats, float]:
        """All of it, as compiled code takes it."""
        return self.inverse_mass, self.velocity, self.friction, self.speed

    @property
    def size(self) -> int:
        """How many contacts there are."""
        return len(self.friction)

    def after(self, impulse: Floats) -> Floats:
        """Relative velocities u (k, 3) m/s after impulses (k, 3) N s."""
        return self.velocity + (self.inverse_mass @ impulse.ravel()).reshape(-1, 3)


@kernel
def after(w: Floats, q: Floats, r: Floats) -> Floats:
    """W r + q, (k, 3): W is symmetric, and its rows are added one after the other."""
    moved = np.zeros(q.size)
    for j in range(len(q)):
        for c in range(3):
            a = r[j, c]
            if a != 0.0:
                for i in range(q.size):
                    moved[i] += w[3 * j + c, i] * a
    u = np.empty((len(q), 3))
    for i in range(len(q)):
        for c in range(3):
            u[i, c] = q[i, c] + moved[3 * i + c]
    return u


@kernel
def breach(w: Floats, q: Floats, friction: Floats, r: Floats) -> float:
    """The largest |F| / m [m/s] of a contact; NaN where anything is none.

    Args: w (3k, 3k) 1/kg, q (k, 3) m/s, friction (k,): of the problem; r (k, 3) N s.
    """
    worst, u = 0.0, after(w, q, r)
    for i in range(len(q)):
        u0, u1, u2 = u[i, 0], u[i, 1], u[i, 2]
        mu = friction[i]
        m = 3.0 / (w[3 * i, 3 * i] + w[3 * i + 1, 3 * i + 1] + w[3 * i + 2, 3 * i + 2])
        t0, t1, t2 = r[i, 0] - m * (u0 + mu * hypot(u1, u2)), r[i, 1] - m * u1, r[i, 2] - m * u2
        size = hypot(t1, t2)
        # The point of the cone nearest to t; without friction 0 <= 0 would hold for a pull as well.
        if not (size <= mu * t0 and t0 >= 0.0):
            normal = max((t0 + mu * size) / (1.0 + mu * mu), 0.0)
            share = mu * normal / max(size, 1e-300)
            t0, t1, t2 = normal, share * t1, share * t2
        d0, d1, d2 = r[i, 0] - t0, r[i, 1] - t1, r[i, 2] - t2
        off = math.sqrt(d0 * d0 + d1 * d1 + d2 * d2) / m
        if not math.isfinite(off):
            return math.nan
        worst = max(worst, off)
    return worst


@entry
def largest_breach(w: Floats, q: Floats, friction: Floats, r: Floats) -> float:
    """As `breach`, from Python."""
    return breach(w, q, friction, r)


def relative_residual(problem: Problem, impulse: Floats) -> float:
    """The largest |F| / m of a contact over the speed that the step starts from [1]; NaN impulses give inf.

    Args: impulse: (k, 3) N s in the frames of the contacts.
    """
    if problem.size == 0:
        return 0.0
    worst = float(largest_breach(problem.inverse_mass, problem.velocity, problem.friction, np.ascontiguousarray(impulse)))
    if not math.isfinite(worst):
        return math.inf
    if worst == 0.0:
        return 0.0
    return worst / problem.speed if problem.speed > 0.0 else math.inf


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
