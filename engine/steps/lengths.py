"""Steps of uneven lengths: the impulses at hand, from which a step starts its sweeps, are made to fit its length.

A force that holds gives an impulse in proportion to the step. Source: Catto, Iterative Dynamics with Temporal Coherence, GDC
2005.
"""

from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at

MOST_GROWTH = 8.0
"""Largest factor [1] on impulses from a short part of a step to a longer one: beyond, their rounding would grow as well."""


def fit_impulses(floats: Floats, ints: Ints, span: float) -> None:
    """Scale the impulses of the contacts from the time that they belong to to `span` [s]."""
    setting = at.float_table(floats, ints, at.SETTING)[0]
    if span == setting[at.LAST_SPAN]:
        return
    share = min(span / setting[at.LAST_SPAN], MOST_GROWTH)
    manifolds = int(at.int_table(ints, at.COUNT)[0, at.MANIFOLDS])
    at.float_table(floats, ints, at.POINT)[: 4 * manifolds, at.NORMAL_IMPULSE : at.TANGENT_IMPULSE + 3] *= share
    at.float_table(floats, ints, at.MANIFOLD)[:manifolds, at.SPIN_IMPULSE : at.SPIN_IMPULSE + 3] *= share
    setting[at.LAST_SPAN] = span
