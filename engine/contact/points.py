"""The contact points of a step, read off an arena."""

from dataclasses import dataclass, fields

import numpy as np

from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at


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
    point = point[rows]
    near = point[:, at.FIRST_GAP] <= margin
    hit = near | (np.abs(point[:, at.SUM : at.SUM + 3]).max(axis=1, initial=0.0) > 0.0)
    rows, point = rows[hit], point[hit]
    return Contacts(
        bodies=key[rows // 4][:, [at.BODY_A, at.BODY_B]],
        point=point[:, at.PLACE : at.PLACE + 3],
        normal=manifold[rows // 4, at.NORMAL : at.NORMAL + 3],
        gap=point[:, at.FIRST_GAP],
        force=point[:, at.SUM : at.SUM + 3] / dt,
    )


def sphere_points(floats: Floats, ints: Ints, count: int, margin: float, dt: float) -> Contacts:
    """As `manifold_points`, of a world of spheres."""
    rest, key = at.float_table(floats, ints, at.TOUCH_REST)[:count], at.int_table(ints, at.TOUCH_KEY)[:count]
    touch = at.float_table(floats, ints, at.TOUCH)[:count]
    # The impulses of the last sub-step still stand, and are not in the sum yet.
    last = touch[:, [at.T_NORMAL]] * touch[:, :3] + touch[:, at.T_TANGENT : at.T_TANGENT + 3]
    total = touch[:, at.T_SUM : at.T_SUM + 3] + last
    near = rest[:, at.R_FIRST_GAP] <= margin
    hit = near | (np.abs(total).max(axis=1, initial=0.0) > 0.0)
    rest = rest[hit]
    return Contacts(
        bodies=key[hit][:, [at.K_BODY_A, at.K_BODY_B]],
        point=rest[:, at.R_PLACE : at.R_PLACE + 3],
        normal=rest[:, at.R_NORMAL : at.R_NORMAL + 3],
        gap=rest[:, at.R_FIRST_GAP],
        force=total[hit] / dt,
    )


def joined(*parts: Contacts) -> Contacts:
    """The points of all, one after the other."""
    return Contacts(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Contacts)))
