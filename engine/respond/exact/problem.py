"""Assemble the contact problem of a step from the engine's own contacts, and write its solution back.

With the frame R = (normal, tangent, tangent) of a contact and the arms r_A, r_B its rows of J are R^T (v_B + w_B x r_B - v_A -
w_A x r_A), so that u = J v; with M^-1 = S S^T, W = (J S)(J S)^T is symmetric to the last bit. The law sees q = J v_free plus,
along the normal,

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
from plumbline.engine.respond.exact.assembly import (
    BROUGHT,
    COLUMNS,
    FRICTION,
    LIFT,
    VELOCITY,
    write_closing,
    write_frames,
    write_problem,
)
from plumbline.engine.respond.exact.law import Problem

TOUCHING = 1e-9
"""Gap [m] below which a point touches. Gaps of 1e-12 m, which round-off leaves between jammed bodies, would otherwise
close by motions of 1e-10 m/s beside others of 1 m/s, and who slips in them would be asked of the last digits."""


@dataclass(frozen=True, slots=True)
class ContactFrames:
    """Where a problem comes from: rows of the arena's points (k,), bodies (k, 2), frames (k, 3, 3), arms (k, 2, 3)."""

    rows: Ints
    bodies: Ints
    frame: Floats
    arm: Floats

    def of(self, which: NDArray[np.bool_]) -> "ContactFrames":
        """These (k,) contacts alone."""
        return ContactFrames(self.rows[which], self.bodies[which], self.frame[which], self.arm[which])


@dataclass(frozen=True, slots=True)
class Movers:
    """Dynamic bodies with M^-1 = S S^T.

    Terms: rows (n,) of the arena's bodies; place: of each of these among the movers, -1 for others; root (n,): of the inverse
        mass [kg^-1/2]; half (n, 3, 3): Cholesky factor of the inverse inertia in W.
    """

    rows: Ints
    place: Ints
    root: Floats
    half: Floats


def symmetric(six: Floats) -> Floats:
    """Matrices (n, 3, 3) of rows (xx, yy, zz, xy, xz, yz)."""
    return six[:, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3)


def cross_product(a: Floats, b: Floats) -> Floats:
    """a x b of vectors (..., 3), as NumPy rounds it, in a third of the time that `np.cross` takes for a few of them."""
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        product[..., k] = a[..., i] * b[..., j] - a[..., j] * b[..., i]
    return product


def contact_frames(floats: Floats, ints: Ints) -> ContactFrames:
    """Frames and arms of all present contacts."""
    most = 4 * int(at.int_table(ints, at.COUNT)[0, at.MANIFOLDS])
    rows, bodies = np.empty(most, np.int64), np.empty((most, 2), np.int64)
    frame, arm = np.empty((most, 3, 3)), np.empty((most, 2, 3))
    k = write_frames(floats, ints, rows, bodies, frame, arm)
    return ContactFrames(rows[:k], bodies[:k], frame[:k], arm[:k])


def closing(floats: Floats, ints: Ints, made: ContactFrames, h: float) -> Floats:
    """The velocities (k,) m/s at which gaps close in h seconds; 0 for what touches."""
    lift = np.empty(len(made.rows))
    write_closing(floats, ints, made.rows, TOUCHING, h, lift)
    return lift


def rebound(floats: Floats, ints: Ints, made: ContactFrames, struck: NDArray[np.bool_]) -> Floats:
    """e u_before (k,) m/s at the present velocities of the contacts that are struck (k,); 0 for the others."""
    u = relative_velocity(at.float_table(floats, ints, at.STATE), made)[:, 0]
    return np.where(struck, restitution_of(floats, ints, made) * np.minimum(u, 0.0), 0.0)


def restitution_of(floats: Floats, ints: Ints, made: ContactFrames) -> Floats:
    """Newton's e (k,) of the contacts."""
    return np.asarray(at.float_table(floats, ints, at.MANIFOLD)[made.rows // 4, at.LAW + 2])


def time_to_blow(floats: Floats, ints: Ints, made: ContactFrames, left: float, slow: float) -> Floats:
    """When (k,) s the present velocities close the gaps of contacts with restitution; inf beyond `left`, or below `slow`."""
    # A gap of TOUCHING is left by what is not told from touching; it would end the approach before the blow.
    gap = np.maximum(at.float_table(floats, ints, at.POINT)[made.rows, at.SEPARATION] - 2.0 * TOUCHING, 0.0)
    u = relative_velocity(at.float_table(floats, ints, at.STATE), made)[:, 0]
    strikes = (restitution_of(floats, ints, made) > 0.0) & (u < -slow) & (gap < -u * left)
    return np.where(strikes, gap / np.where(strikes, -u, 1.0), np.inf)


def assemble_problem(floats: Floats, ints: Ints, made: ContactFrames, lift: Floats) -> tuple[Problem, Floats]:
    """The problem of these contacts, with velocities already kicked, and what is added to them along the normals, (k,) m/s.

    Returns: the problem, and the impulses (k, 3) N s that the contacts bring from the last solve.
    """
    k = len(made.rows)
    w, out = np.empty((3 * k, 3 * k)), np.empty((k, COLUMNS))
    out[:, LIFT] = lift
    speed = write_problem(floats, ints, made.rows, made.bodies, made.frame, made.arm, w, out)
    problem = Problem(w, out[:, VELOCITY : VELOCITY + 3].copy(), out[:, FRICTION].copy(), speed)
    return problem, out[:, BROUGHT : BROUGHT + 3]


def pace_of(u: Floats) -> float:
    """The largest of velocities (k, 3) [m/s]."""
    return float(np.sqrt((u * u).sum(axis=1)).max(initial=0.0))


def friction_of(floats: Floats, ints: Ints, made: ContactFrames) -> Floats:
    """Coulomb's coefficients (k,) of the contacts."""
    return np.array(at.float_table(floats, ints, at.MANIFOLD)[made.rows // 4, at.LAW + 1])


def brought_impulse(floats: Floats, ints: Ints, made: ContactFrames) -> Floats:
    """The impulses (k, 3) N s that the contacts bring from the last solve, in their frames."""
    point = at.float_table(floats, ints, at.POINT)[made.rows]
    impulse = point[:, at.TANGENT_IMPULSE : at.TANGENT_IMPULSE + 3] + point[:, at.NORMAL_IMPULSE, None] * made.frame[:, :, 0]
    return np.asarray(np.einsum("kji,kj->ki", made.frame, impulse))


def relative_velocity(state: Floats, made: ContactFrames) -> Floats:
    """J v (k, 3) m/s: of B against A at each contact, in its frame."""
    end = state[made.bodies, at.V : at.V + 3] + cross_product(state[made.bodies, at.W : at.W + 3], made.arm)
    return np.asarray(np.einsum("kji,kj->ki", made.frame, end[:, 1] - end[:, 0]), np.float64)


def movers_of(floats: Floats, ints: Ints, bodies: Ints) -> Movers:
    """The dynamic ones of some bodies."""
    mass, turned = at.float_table(floats, ints, at.BODY)[:, at.INV_MASS], at.float_table(floats, ints, at.TURNED)
    rows = np.unique(bodies[mass[bodies] > 0.0])
    place = np.full(len(mass), -1)
    place[rows] = np.arange(len(rows))
    half = np.asarray(np.linalg.cholesky(symmetric(turned[rows])), np.float64)
    return Movers(rows, place, np.sqrt(mass[rows]), half)


def weighted_rows(made: ContactFrames, movers: Movers) -> Floats:
    """J S (3k, 6n) of the contacts."""
    k = len(made.rows)
    reach = np.zeros((k, 3, len(movers.rows), 6))
    for end, sign in ((0, -1.0), (1, 1.0)):
        hit = np.flatnonzero(movers.place[made.bodies[:, end]] >= 0)
        n = movers.place[made.bodies[hit, end]]
        rows = sign * np.swapaxes(made.frame[hit], 1, 2)
        turn = cross_product(made.arm[hit, end, None, :], rows)
        reach[hit, :, n, :3] = rows * movers.root[n][:, None, None]
        reach[hit, :, n, 3:] = turn @ movers.half[n]
    return reach.reshape(3 * k, 6 * len(movers.rows))


def apply_impulse(state: Floats, movers: Movers, motion: Floats) -> None:
    """v += S s for the motion s (6n,) of the movers, as impulses r give it: s = (J S)^T r."""
    change = motion.reshape(-1, 6)
    state[movers.rows, at.V : at.V + 3] += movers.root[:, None] * change[:, :3]
    state[movers.rows, at.W : at.W + 3] += (movers.half @ change[:, 3:, None])[:, :, 0]


def keep_impulse(floats: Floats, ints: Ints, made: ContactFrames, impulse: Floats) -> None:
    """Keep impulses (k, 3) N s with the contact points."""
    in_world = np.einsum("kij,kj->ki", made.frame, impulse)
    point = at.float_table(floats, ints, at.POINT)
    point[:, at.NORMAL_IMPULSE : at.TANGENT_IMPULSE + 3] = 0.0  # contacts left out of the problem give none
    point[made.rows, at.NORMAL_IMPULSE] = impulse[:, 0]
    point[made.rows, at.TANGENT_IMPULSE : at.TANGENT_IMPULSE + 3] = in_world - impulse[:, :1] * made.frame[:, :, 0]
