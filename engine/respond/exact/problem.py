"""The contact problem of a step, from the engine's own contacts.

With the frame R = (normal, tangent, tangent) of a contact and the arms r_A, r_B its rows of J are R^T (v_B + w_B x r_B - v_A -
w_A x r_A), so that u = J v, and W = J M^-1 J^T. The law sees q = J v_free plus, along the normal,

    max(gap - TOUCHING, 0) / h
                      a gap may close and a depth may not grow; rest then always satisfies the law, so that a solution exists,
    e u_before        at the instant of a blow, for the points that strike: Newton's restitution.

A depth is not worked off: pushes from both sides of a jammed body could not be satisfied at once.

Source: Stewart, Trinkle, Int. J. Numer. Methods Eng. 39, 1996 (gap over step); Moreau, Comput. Methods Appl. Mech. Eng. 177,
1999 (restitution); Acary, Cadoux, Applications of an existence result for the Coulomb friction problem, 2013.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.respond.exact.kernels import APART, COLUMNS, FRICTION, RESTITUTION, write_contacts, write_problem
from plumbline.engine.respond.exact.law import Problem

TOUCHING = 1e-9
"""Gap [m] below which a point touches. Gaps of 1e-12 m, which round-off leaves between jammed bodies, would otherwise
close by motions of 1e-10 m/s beside others of 1 m/s, and who slips in them would be asked of the last digits."""


@dataclass(frozen=True, slots=True)
class ContactRows:
    """The contacts of a problem.

    Terms: points (k,): rows of the arena's points; body (3k, 2), row (3k, 18): three rows each, along the normal and two
        tangents; values (k, COLUMNS): what else there is of each.
    """

    points: Ints
    body: Ints
    row: Floats
    values: Floats

    def of(self, which: NDArray[np.bool_]) -> "ContactRows":
        """These (k,) contacts alone."""
        each = np.repeat(which, 3)
        return ContactRows(self.points[which], self.body[each], self.row[each], self.values[which])


def contact_rows(floats: Floats, ints: Ints) -> ContactRows:
    """All present contacts."""
    most = 4 * int(at.int_table(ints, at.COUNT)[0, at.MANIFOLDS])
    points, body = np.empty(most, np.int64), np.empty((3 * most, 2), np.int64)
    row, values = np.zeros((3 * most, at.HIGH + 1)), np.empty((most, COLUMNS))
    k = write_contacts(floats, ints, points, body, row, values)
    return ContactRows(points[:k], body[: 3 * k], row[: 3 * k], values[:k])


def rates(state: Floats, row: Floats, body: Ints) -> Floats:
    """J v (m,) of rows."""
    velocity = state[body[:, :2], at.V : at.V + 6]
    return np.asarray((row[:, at.JACOBIAN : at.JACOBIAN + 12].reshape(-1, 2, 6) * velocity).sum(axis=(1, 2)))


def pace_of(u: Floats) -> float:
    """The largest of velocities (k, 3) [m/s]."""
    return float(np.sqrt((u * u).sum(axis=1)).max(initial=0.0))


def closing(made: ContactRows, h: float) -> Floats:
    """The velocities (k,) m/s at which gaps close in h seconds; 0 for what touches."""
    return np.maximum(made.values[:, APART] - TOUCHING, 0.0) / h


def rebound(state: Floats, made: ContactRows, struck: NDArray[np.bool_]) -> Floats:
    """e u_before (k,) m/s at the present velocities of the contacts that are struck (k,); 0 for the others."""
    u = rates(state, made.row[::3], made.body[::3])
    return np.where(struck, made.values[:, RESTITUTION] * np.minimum(u, 0.0), 0.0)


def time_to_blow(state: Floats, made: ContactRows, left: float, slow: float) -> Floats:
    """When (k,) s the present velocities close the gaps of contacts with restitution; inf beyond `left`, or below `slow`."""
    # A gap of TOUCHING is left by what is not told from touching; it would end the approach before the blow.
    gap, u = np.maximum(made.values[:, APART] - 2.0 * TOUCHING, 0.0), rates(state, made.row[::3], made.body[::3])
    strikes = (made.values[:, RESTITUTION] > 0.0) & (u < -slow) & (gap < -u * left)
    return np.where(strikes, gap / np.where(strikes, -u, 1.0), np.inf)


def assemble_problem(floats: Floats, ints: Ints, made: ContactRows, lift: Floats) -> Problem:
    """The problem of these contacts, with velocities already kicked, and what is added to them along the normals, (k,) m/s."""
    k = len(lift)
    w, q = np.empty((3 * k, 3 * k)), np.empty((k, 3))
    speed = write_problem(floats, ints, made.body, made.row, lift, w, q)
    return Problem(w, q, made.values[:, FRICTION].copy(), speed)
