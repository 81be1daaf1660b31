"""The certificate of a contact solution: how far impulses are from Signorini's and Coulomb's law, whoever found them.

The natural map of each contact,

    F = r - P_K(r - m (u + (mu |u_T|, 0, 0))),

with P_K the projection onto Coulomb's cone and m an effective mass of the contact, vanishes exactly at the solutions. As a
velocity, |F| / m, and relative to the speed that the step starts from, it judges light and heavy bodies alike: where the ratio
of masses is R, an error that is seen only relative to the largest impulse could be R times larger.

Source: Alart, Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991; Acary, Bremond, Huber, On solving contact problems with
Coulomb friction, 2018 (section 3.2).
"""

import math

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.elementary import hypot
from plumbline.engine.maths.rows import Floats
from plumbline.engine.respond.exact.law import Problem


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
