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

from plumbline.engine.maths.types import Floats
from plumbline.engine.respond.exact.certificate import largest_breach
from plumbline.engine.respond.exact.law import Problem


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
