"""What the integrators of untouched bodies share: the principal frame, the rates of motion, and kicks by loads and damping.

In the principal frame P the inertia is diagonal. A body's rotation is (q_WP, m) with its angular momentum m in P:
q' = q (0, w) / 2,  m' = m x w + R^T tau - d m,  w = m / I. Without the gyroscopic effect the term m x w is left out, which
keeps the angular velocity of a body that nothing turns.

Source: Goldstein, Poole, Safko, Classical Mechanics, 3rd ed., section 5.5 (Euler's equations).
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.elementary import cos_sin, exp, expm1
from plumbline.engine.maths.rows import Floats, Ints, Quat, Vec, load3, load4, store3, store4
from plumbline.engine.maths.vec import (
    add,
    axpy,
    cross,
    dot,
    mat_vec,
    quat_conj,
    quat_mat,
    quat_mul,
    quat_turn,
    quat_unit,
    scale,
    tmat_vec,
)
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE, UNSOLVED
from plumbline.engine.memory.tables import Bodies, bodies_of
from plumbline.engine.steps.count_step import count_step


class Law(NamedTuple):
    """What moves a body.

    Terms: a [m/s2], c [1/s]: acceleration and damping; moments [kg m2], tau [N m], d [1/s]: of inertia, torque and damping of
    its spin; gyroscopic: 1 where the gyroscopic effect is on.
    """

    a: Vec
    c: float
    moments: Vec
    tau: Vec
    d: float
    gyroscopic: int


@kernel
def law_of(bodies: Bodies, principal: Floats, setting: Floats, b: int, gyroscopic: int) -> Law:
    """The law of body b."""
    a = axpy(bodies.body[b, at.INV_MASS], load3(bodies.load, b, 0), load3(setting, 0, at.GRAVITY))
    c, d = bodies.body[b, at.LINEAR_DAMPING], bodies.body[b, at.ANGULAR_DAMPING]
    return Law(a, c, load3(principal, b, at.MOMENTS), load3(bodies.load, b, 3), d, gyroscopic)


@kernel
def is_pushed(state: Floats, kind: Ints, b: int, h: float) -> bool:
    """Whether forces move body b; where it is kinematic, it is carried on for h seconds by its velocities."""
    if kind[b, at.MOTION] == at.KINEMATIC:
        store3(state, b, at.P, axpy(h, load3(state, b, at.V), load3(state, b, at.P)))
        store4(state, b, at.Q, quat_turn(load4(state, b, at.Q), load3(state, b, at.W), h))
    return bool(kind[b, at.MOTION] == at.DYNAMIC)


@kernel
def as_long(turned: Vec, v: Vec) -> Vec:
    """The turned vector with the length of v, which rounding changed.

    |q|^2 lies about one, where numbers are twice as dense below as above, so that a matrix made from q lengthens on average,
    by up to half a rounding: 5e-12 of the energy in 1e5 steps, far more than the exact methods err otherwise.
    """
    have = dot(turned, turned)
    return axpy(0.5 * (dot(v, v) - have) / have, turned, turned) if have > 0.0 else turned


@kernel
def to_principal(state: Floats, principal: Floats, b: int) -> tuple[Quat, Vec]:
    """q_WP and the angular momentum [kg m2/s] of body b in P."""
    q = quat_mul(load4(state, b, at.Q), load4(principal, b, at.AXES))
    w_W, moments = load3(state, b, at.W), load3(principal, b, at.MOMENTS)
    w = as_long(tmat_vec(quat_mat(q), w_W), w_W)
    return q, (moments[0] * w[0], moments[1] * w[1], moments[2] * w[2])


@kernel
def from_principal(state: Floats, principal: Floats, b: int, q: Quat, m: Vec) -> None:
    """Write the rotation (q_WP, m) of body b as q_WB and w_WB."""
    store4(state, b, at.Q, quat_unit(quat_mul(q, quat_conj(load4(principal, b, at.AXES)))))
    w = velocities_of(m, load3(principal, b, at.MOMENTS))
    store3(state, b, at.W, as_long(mat_vec(quat_mat(q), w), w))


@kernel
def velocities_of(m: Vec, moments: Vec) -> Vec:
    """w = m / I [rad/s] in P."""
    return m[0] / moments[0], m[1] / moments[1], m[2] / moments[2]


@kernel
def turned_by(q: Quat, w: Vec, h: float) -> Quat:
    """q exp(h w): the orientation after h seconds at the constant angular velocity w [rad/s] in the body's own frame."""
    angle = 0.5 * h * math.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    cosine, sine = cos_sin(angle)
    s = 0.5 * h * (1.0 - angle * angle / 6.0 if abs(angle) < 1e-4 else sine / angle)
    return quat_mul(q, (cosine, s * w[0], s * w[1], s * w[2]))


@kernel
def spin_rates(q: Quat, m: Vec, law: Law) -> tuple[Quat, Vec]:
    """q' and m'."""
    w = velocities_of(m, law.moments)
    slope = axpy(-law.d, m, tmat_vec(quat_mat(q), law.tau))
    if law.gyroscopic == 1:
        slope = add(slope, cross(m, w))
    return quat_mul(q, (0.0, 0.5 * w[0], 0.5 * w[1], 0.5 * w[2])), slope


@kernel
def damped_time(c: float, h: float) -> float:
    """The integral of exp(-c t) over h seconds [s]."""
    return h if c == 0.0 else -expm1(-c * h) / c


@kernel
def kicked_velocity(v: Vec, a: Vec, c: float, h: float) -> Vec:
    """The exact solution of v' = a - c v after h seconds."""
    return axpy(damped_time(c, h), a, scale(exp(-c * h), v))


@kernel
def kicked_spin(q: Quat, m: Vec, law: Law, h: float) -> Vec:
    """The exact solution of m' = R^T tau - d m after h seconds at a fixed orientation."""
    return axpy(damped_time(law.d, h), tmat_vec(quat_mat(q), law.tau), scale(exp(-law.d * h), m))


@kernel
def advance_free(floats: Floats, ints: Ints, steps: int, advance: Callable[..., bool], *room: Any) -> tuple[int, int]:
    """Advance all bodies by `steps` steps, sub-step by sub-step.

    Args: advance: (bodies, principal, setting, b, h [s], gyroscopic, *room) -> whether body b was advanced by h.
    Returns: steps done, and DONE, or DIVERGED, or UNSOLVED if a body was not advanced.
    """
    bodies, principal = bodies_of(floats, ints), floats_of(floats, ints, at.PRINCIPAL)
    setting = floats_of(floats, ints, at.SETTING)
    count = ints_of(ints, at.COUNT)
    h, gyroscopic = setting[0, at.DT] / count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC]
    for step in range(steps):
        advanced = True
        for _ in range(count[0, at.SUBSTEPS]):
            for b in range(count[0, at.BODIES]):
                if not advance(bodies, principal, setting, b, h, gyroscopic, *room):
                    advanced = False
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
        if not advanced:
            return step + 1, UNSOLVED
    return steps, DONE
