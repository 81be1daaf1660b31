"""Joints beside exact contacts: their rows are eliminated, and the contacts see the bodies as the joints leave them.

With M^-1 = S S^T, v = S s, the rows of all joints, J v + gamma lambda + beta = 0 (gamma = 0 where they are hard), are

    A (s, t) = -beta,    A = [J S, gamma^1/2],    lambda = -gamma^-1/2 t

of soft rows, one more coordinate t for each. Solved by the least (s, t), as mass times acceleration has it, they leave motions
in the null space of A alone: with its projector P the contacts have W = (C P)(C P)^T, symmetric and positive semi-definite to
the last bit, C = [J_contact S, 0]. A is decomposed into singular values, so that rows which depend on others, as in closed
loops, do no harm.

Limits are unilateral rows, contacts without friction; a stop takes what comes and gives nothing back.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, section 8.2 (loop constraints); Lacoursiere, Ghosts and Machines,
2007 (soft rows as coordinates of their own); Golub, Van Loan, Matrix Computations, section 5.5 (rank and least squares).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.respond.exact.kernels import BROUGHT, FRICTION, give_impulses, write_joint_rows
from plumbline.engine.respond.exact.law import Problem
from plumbline.engine.respond.exact.problem import TOUCHING, ContactRows, pace_of, rates

DEPENDENT = 1e-10
"""Singular values below this share of the largest belong to rows that depend on others; rows are of length one."""
IMMOVABLE = 1e-12
"""Share of its own motion [1] below which joints leave a contact none: what it carries decides nothing."""
LINEAR_B, ANGULAR_B = at.JACOBIAN + 6, at.JACOBIAN + 9


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

    def weighted(self, row: Floats, body: Ints) -> Floats:
        """J S (m, 6n) of rows."""
        reach = np.zeros((len(row), len(self.rows), 6))
        for side in range(2):
            hit = np.flatnonzero(self.place[body[:, side]] >= 0)
            n, start = self.place[body[hit, side]], at.JACOBIAN + 6 * side
            reach[hit, n, :3] += row[hit, start : start + 3] * self.root[n][:, None]
            reach[hit, n, 3:] += np.einsum("ri,rij->rj", row[hit, start + 3 : start + 6], self.half[n])
        return reach.reshape(len(row), 6 * len(self.rows))

    def move(self, state: Floats, motion: Floats) -> None:
        """v += S s for the motion s (6n,), as impulses r give it: s = (J S)^T r."""
        change = motion.reshape(-1, 6)
        state[self.rows, at.V : at.V + 3] += self.root[:, None] * change[:, :3]
        state[self.rows, at.W : at.W + 3] += (self.half @ change[:, 3:, None])[:, :, 0]


def movers_of(floats: Floats, ints: Ints, bodies: Ints) -> Movers:
    """The dynamic ones of some bodies."""
    mass, turned = at.float_table(floats, ints, at.BODY)[:, at.INV_MASS], at.float_table(floats, ints, at.TURNED)
    rows = np.unique(bodies[mass[bodies] > 0.0])
    place = np.full(len(mass), -1)
    place[rows] = np.arange(len(rows))
    inertia = turned[rows][:, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3)
    return Movers(rows, place, np.sqrt(mass[rows]), np.asarray(np.linalg.cholesky(inertia), np.float64))


@dataclass(frozen=True, slots=True)
class Held:
    """The joints of a world in one pose.

    Terms: movers: bodies in contact or held by joints; row (m, 18), body (m, 4): as of the arena, free rows first; free: how
        many these are, the rest being limits; gap (l,): to the stops [m or rad]; reach (m, 6n): J S; basis (6n + soft, r): of
        the row space of A; back (free, r): impulses from motions along the basis; rotors (m,): which
        rows are those of rotors.
    """

    movers: Movers
    row: Floats
    body: Ints
    free: int
    gap: Floats
    reach: Floats
    basis: Floats
    back: Floats
    rotors: NDArray[np.bool_]


def held_bodies(floats: Floats, ints: Ints, made: ContactRows, h: float) -> Held:
    """The joints in the present pose, with what they aim at in h seconds."""
    equalities, count = write_joint_rows(floats, ints, h)
    row, body = at.float_table(floats, ints, at.ROW)[:count].copy(), at.int_table(ints, at.ROW_BODY)[:count].copy()
    hard = (np.arange(count) < equalities) & (row[:, at.SOFTNESS] == 0.0)
    row[hard, at.BIAS] = row[hard, at.GAP] / h
    stops = (np.arange(count) >= equalities) & (row[:, at.SOFTNESS] == 0.0)
    order = np.concatenate([np.flatnonzero(~stops), np.flatnonzero(stops)])
    row, body, free = row[order], body[order], int((~stops).sum())
    rotors = (order < equalities) & (row[:, at.SOFTNESS] > 0.0)
    movers = movers_of(floats, ints, np.concatenate([made.body.ravel(), body[:, :2].ravel()]))
    reach = movers.weighted(row, body)
    soft = np.flatnonzero(row[:free, at.SOFTNESS] > 0.0)
    a = np.zeros((free, reach.shape[1] + len(soft)))
    a[:, : reach.shape[1]] = reach[:free]
    a[soft, reach.shape[1] + np.arange(len(soft))] = np.sqrt(row[soft, at.SOFTNESS])
    length = np.maximum(np.sqrt((a * a).sum(axis=1)), 1e-300)
    u, size, v = np.linalg.svd(a / length[:, None], full_matrices=False)
    real = size > DEPENDENT * size.max(initial=0.0)
    back = u[:, real] / size[real] / length[:, None]
    return Held(movers, row, body, free, row[free:, at.BIAS] * h, reach, v[real].T, back, rotors)


def hold(floats: Floats, ints: Ints, held: Held) -> None:
    """Let the joints alone act on the present velocities."""
    state, body = at.float_table(floats, ints, at.STATE), held.body[: held.free]
    asked = -rates(state, held.row[: held.free], body) - held.row[: held.free, at.BIAS]
    along = held.back.T @ asked
    held.movers.move(state, (held.basis @ along)[: held.reach.shape[1]])
    count_reactions(floats, ints, held, np.concatenate([held.back @ along, np.zeros(len(held.gap))]))


@dataclass(frozen=True, slots=True)
class Beside:
    """A problem beside joints, and where it comes from.

    Terms: problem; brought (k, 3) N s, lift (k,) m/s: as of `assemble_problem`; made: its contacts; stops: the rows of its
        stops, behind these; across (3k, 6n + soft): C P; taken (3k, r): C along the basis of the joints.
    """

    problem: Problem
    brought: Floats
    lift: Floats
    made: ContactRows
    stops: Ints
    across: Floats
    taken: Floats


def assemble_held(floats: Floats, ints: Ints, made: ContactRows, lift: Floats, held: Held, left: float) -> Beside:
    """The problem of contacts and stops, the latter last, in what the joints leave.

    Args: lift: as `assemble_problem`; left [s]: in which stops may be reached; 0: those alone that are.
    """
    state, width = at.float_table(floats, ints, at.STATE), held.reach.shape[1]
    stops = np.flatnonzero((held.gap <= TOUCHING) | (left > 0.0))
    k, rows = len(made.points), held.free + stops
    across = np.zeros((k + len(stops), 3, len(held.basis)))
    across[:k, :, :width] = held.movers.weighted(made.row, made.body).reshape(k, 3, width)
    across[k:, 0, :width] = held.reach[rows]
    q, brought, friction, lifts = (np.zeros((len(across), *more)) for more in ((3,), (3,), (), ()))
    q[:k], brought[:k] = rates(state, made.row, made.body).reshape(-1, 3), made.values[:, BROUGHT : BROUGHT + 3]
    friction[:k], lifts[:k] = made.values[:, FRICTION], lift
    q[k:, 0] = rates(state, held.row[rows], held.body[rows])
    if left > 0.0:
        lifts[k:] = np.maximum(held.gap[stops] - TOUCHING, 0.0) / left
    speed = max(pace_of(q), float((-lifts).max(initial=0.0)))
    q[:, 0] += lifts
    taken = across[:, :, :width] @ held.basis[:width]
    alone = (across * across).sum(axis=(1, 2))
    across = across - taken @ held.basis.T
    moves = (across * across).sum(axis=(1, 2)) > IMMOVABLE * alone
    across, taken = (m[moves].reshape(3 * int(moves.sum()), m.shape[2]) for m in (across, taken))
    problem = Problem(across @ across.T, q[moves], friction[moves], speed)
    return Beside(problem, brought[moves], lifts[moves], made.of(moves[:k]), rows[moves[k:]], across, taken)


def give(floats: Floats, ints: Ints, held: Held, beside: Beside, impulse: Floats) -> None:
    """Change velocities by impulses (k, 3) N s of contacts and stops, and by those of the joints that they call for."""
    flat, made, k = impulse.ravel(), beside.made, len(beside.made.points)
    held.movers.move(at.float_table(floats, ints, at.STATE), (beside.across.T @ flat)[: held.reach.shape[1]])
    total = np.zeros(len(held.row))
    total[: held.free] = -held.back @ (beside.taken.T @ flat)
    total[beside.stops] = impulse[k:, 0]
    count_reactions(floats, ints, held, total)
    give_impulses(floats, ints, made.points, made.body, made.row, np.ascontiguousarray(impulse[:k]), 0)


def count_reactions(floats: Floats, ints: Ints, held: Held, impulse: Floats) -> None:
    """Count impulses (m,) of all rows towards what their joints carry, as `constrain.reactions` does, and let rotors have the
    rates that they leave them with.
    """
    joint, of = at.float_table(floats, ints, at.JOINT), held.body[:, at.JOINT_OF]
    linear, angular = held.row[:, LINEAR_B : LINEAR_B + 3], held.row[:, ANGULAR_B : ANGULAR_B + 3]
    turns = (linear == 0.0).all(axis=1)[:, None]
    np.add.at(joint[:, at.REACTION : at.REACTION + 3], of, impulse[:, None] * linear)
    np.add.at(joint[:, at.REACTION + 3 : at.REACTION + 6], of, np.where(turns, impulse[:, None] * angular, 0.0))
    np.subtract.at(joint[:, at.ROTOR_RATE], of[held.rotors], (held.row[:, at.SOFTNESS] * impulse)[held.rotors])
