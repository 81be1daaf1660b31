"""The contact points of a step, read off an arena; their impulses made to fit a step of another length."""

from dataclasses import dataclass, fields

import numpy as np

from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at

MOST_GROWTH = 8.0
"""Largest factor [1] on impulses from a short part of a step to a longer one: beyond, their rounding would grow as well."""


@dataclass(frozen=True, slots=True)
class Contacts:
    """The contact points of the last step.

    Terms:
        bodies (k, 2): indices of A and B; point (k, 3) m in W; normal (k, 3) from A to B; gap (k,) m at the start of the step;
        force (k, 3) N on B: impulse of the step over dt.
    """

    bodies: Ints
    point: Floats
    normal: Floats
    gap: Floats
    force: Floats


def manifold_points(floats: Floats, ints: Ints, count: int, margin: float, dt: float) -> Contacts:
    """The points of the first `count` manifolds, and of islands asleep, that are within the margin [m] or gave an impulse."""
    key = at.int_table(ints, at.MANIFOLD_KEY)[:count]
    manifold = at.float_table(floats, ints, at.MANIFOLD)[:count]
    point = at.float_table(floats, ints, at.POINT)[: 4 * count]
    resting = int(at.int_table(ints, at.TALLY)[0, at.RESTING])
    if resting > 0:
        key = np.vstack((key, at.int_table(ints, at.RESTING_KEY)[:resting]))
        manifold = np.vstack((manifold, at.float_table(floats, ints, at.RESTING_MANIFOLD)[:resting]))
        point = np.vstack((point, at.float_table(floats, ints, at.RESTING_POINT)[: 4 * resting]))
    rows = np.array([4 * m + k for m in range(count + resting) for k in range(key[m, at.POINTS])], np.int64)
    key, manifold, point = key[rows // 4], manifold[rows // 4], point[rows]
    bodies, total = key[:, [at.BODY_A, at.BODY_B]], point[:, at.SUM : at.SUM + 3]
    spot, normal = point[:, at.PLACE : at.PLACE + 3], manifold[:, at.NORMAL : at.NORMAL + 3]
    return _told(Contacts(bodies, spot, normal, point[:, at.FIRST_GAP], total / dt), margin)


def sphere_points(floats: Floats, ints: Ints, count: int, margin: float, dt: float) -> Contacts:
    """As `manifold_points`, of a world of spheres."""
    rest, key = at.float_table(floats, ints, at.TOUCH_REST)[:count], at.int_table(ints, at.TOUCH_KEY)[:count]
    touch = at.float_table(floats, ints, at.TOUCH)[:count]
    # The impulses of the last sub-step still stand, and are not in the sum yet.
    last = touch[:, [at.T_NORMAL]] * touch[:, :3] + touch[:, at.T_TANGENT : at.T_TANGENT + 3]
    bodies, total = key[:, [at.K_BODY_A, at.K_BODY_B]], touch[:, at.T_SUM : at.T_SUM + 3] + last
    spot, normal = rest[:, at.R_PLACE : at.R_PLACE + 3], rest[:, at.R_NORMAL : at.R_NORMAL + 3]
    return _told(Contacts(bodies, spot, normal, rest[:, at.R_FIRST_GAP], total / dt), margin)


def _told(points: Contacts, margin: float) -> Contacts:
    """Those of the points that are within the margin [m] or gave an impulse."""
    hit = (points.gap <= margin) | (np.abs(points.force).max(axis=1, initial=0.0) > 0.0)
    return Contacts(*(getattr(points, f.name)[hit] for f in fields(Contacts)))


def joined(*parts: Contacts) -> Contacts:
    """The points of all, one after the other."""
    return Contacts(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Contacts)))


def fit_impulses(floats: Floats, ints: Ints, span: float) -> None:
    """Scale the impulses of the contacts, from which a step starts its sweeps, from the time that they belong to to `span` [s].

    A force that holds gives an impulse in proportion to the step. Source: Catto, Iterative Dynamics with Temporal Coherence,
    GDC 2005.
    """
    setting = at.float_table(floats, ints, at.SETTING)[0]
    if span == setting[at.LAST_SPAN]:
        return
    share = min(span / setting[at.LAST_SPAN], MOST_GROWTH)
    manifolds = int(at.int_table(ints, at.COUNT)[0, at.MANIFOLDS])
    at.float_table(floats, ints, at.POINT)[: 4 * manifolds, at.NORMAL_IMPULSE : at.TANGENT_IMPULSE + 3] *= share
    at.float_table(floats, ints, at.MANIFOLD)[:manifolds, at.SPIN_IMPULSE : at.SPIN_IMPULSE + 3] *= share
    setting[at.LAST_SPAN] = span
