"""One step's contacts as a complementarity problem in impulses, u = W r + q between relative velocity and impulse; and its
certificate: how far impulses are from Signorini's and Coulomb's law, whoever found them.

Every contact alpha has the frame (normal, tangent, tangent) and the law of Signorini and Coulomb, in De Saxce's form one cone
complementarity with the velocity v = u + (mu |u_T|, 0, 0):

    r in K,  v in K*,  r . v = 0,  K = {|r_T| <= mu r_N}

The natural map of each contact, F = r - P_K(r - m v), with P_K the projection onto Coulomb's cone and m an effective mass of
the contact, vanishes exactly at the solutions. As a velocity, |F| / m, and relative to the speed that the step starts from, it
judges light and heavy bodies alike: where the ratio of masses is R, an error that is seen only relative to the largest impulse
could be R times larger.

Source: De Saxce, Feng, The bipotential method, Math. Comput. Modelling 28, 1998; Acary, Cadoux, Applications of an existence
result for the Coulomb friction problem, 2013; Alart, Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991; Acary, Bremond, Huber,
On solving contact problems with Coulomb friction, 2018 (section 3.2).
"""

import math
from dataclasses import dataclass

import numpy as np

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
