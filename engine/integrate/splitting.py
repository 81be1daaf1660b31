"""High-order splitting for bodies that nothing touches: a symmetric second-order step, composed to order four or eight.

With moments I1 <= I2 <= I3 a free rotor's energy is |m|^2 / (2 I2) + (1/I1 - 1/I2) m1^2 / 2 + (1/I3 - 1/I2) m3^2 / 2: a turn C
about L, which commutes with the rest, and turns A about axis 1 and B about axis 3. Each is exact, so is every kick K by loads
and damping at rest and every drift D without them:

    S(h) = K(h/2) A(h/2) B(h) A(h/2) C(h) D(h) K(h/2),    step(h) = S(g_s h) ... S(g_2 h) S(g_1 h)

Source: Fasso, J. Comput. Phys. 189 (2003) 527 (the splitting); Suzuki, Phys. Lett. A 146 (1990) 319 (order four); Kahan, Li,
Math. Comput. 66 (1997) 1089 (order eight, 17 stages); Hairer, Lubich, Wanner, Geometric Numerical Integration, section V.3.2.
"""

from typing import Final

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.integrate.free_body import (
    from_principal,
    is_pushed,
    kicked_spin,
    kicked_velocity,
    to_principal,
    turned_by,
    velocities_of,
)
from plumbline.engine.integrate.free_steps import advance_free
from plumbline.engine.integrate.principal_turns import turn_first, turn_third
from plumbline.engine.maths.rows import Floats, Ints, Quat, Vec, load3, store3
from plumbline.engine.maths.vec import axpy, scale
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies

ROOT_OF_FOUR = 1.5874010519681994748  # the third
SUZUKI_4: Final = np.array([1.0, 1.0, -ROOT_OF_FOUR, 1.0, 1.0]) / (4.0 - ROOT_OF_FOUR)
KAHAN_LI_HALF = (
    0.13020248308889008087881763, 0.56116298177510838456196441, -0.38947496264484728640807860, 0.15884190655515560089621075,
    -0.39590389413323757733623154, 0.18453964097831570709183254, 0.25837438768632204729397911, 0.29501172360931029887096624,
)  # fmt: skip
KAHAN_LI_8: Final = np.array([*KAHAN_LI_HALF, -0.60550853383003451169892108, *KAHAN_LI_HALF[::-1]])


@kernel
def free_rotor(q: Quat, m: Vec, moments: Vec, weights: Floats, h: float) -> tuple[Quat, Vec]:
    """The composition without kicks: neighbouring turns A are one, and C, which commutes with both, comes once at the end."""
    first, third = h * (1.0 / moments[0] - 1.0 / moments[1]), h * (1.0 / moments[2] - 1.0 / moments[1])
    before = 0.0
    for k in range(len(weights)):
        weight = weights[k]
        q, m = turn_first(q, m, 0.5 * (before + weight) * first * m[0])
        q, m = turn_third(q, m, weight * third * m[2])
        before = weight
    q, m = turn_first(q, m, 0.5 * before * first * m[0])
    return turned_by(q, scale(1.0 / moments[1], m), h), m


@kernel
def kicked_rotor(
    q: Quat, m: Vec, moments: Vec, tau: Vec, d: float, weights: Floats, h: float, gyroscopic: int
) -> tuple[Quat, Vec]:
    """The composition under a torque [N m] in W and angular damping [1/s]."""
    for k in range(len(weights)):
        weight = weights[k]
        g = weight * h
        m = kicked_spin(q, m, tau, d, 0.5 * g)
        if gyroscopic == 1:
            first, third = g * (1.0 / moments[0] - 1.0 / moments[1]), g * (1.0 / moments[2] - 1.0 / moments[1])
            q, m = turn_first(q, m, 0.5 * first * m[0])
            q, m = turn_third(q, m, third * m[2])
            q, m = turn_first(q, m, 0.5 * first * m[0])
            q = turned_by(q, scale(1.0 / moments[1], m), g)
        else:
            q = turned_by(q, velocities_of(m, moments), g)
        m = kicked_spin(q, m, tau, d, 0.5 * g)
    return q, m


@kernel
def splitting(bodies: Bodies, principal: Floats, setting: Floats, b: int, h: float, gyroscopic: int, weights: Floats) -> bool:
    """Advance body b by h by the composition with these weights. Returns: True."""
    state, body, load = bodies.state, bodies.body, bodies.load
    if not is_pushed(state, bodies.kind, b, h):
        return True
    a, c = axpy(body[b, at.INV_MASS], load3(load, b, 0), load3(setting, 0, at.GRAVITY)), body[b, at.LINEAR_DAMPING]
    p, v = load3(state, b, at.P), load3(state, b, at.V)
    if c == 0.0:
        # A constant acceleration is kicked and drifted exactly, whatever the composition.
        p, v = axpy(0.5 * h * h, a, axpy(h, v, p)), axpy(h, a, v)
    else:
        for k in range(len(weights)):
            weight = weights[k]
            v = kicked_velocity(v, a, c, 0.5 * weight * h)
            p = axpy(weight * h, v, p)
            v = kicked_velocity(v, a, c, 0.5 * weight * h)
    store3(state, b, at.P, p)
    store3(state, b, at.V, v)

    tau, d, moments = load3(load, b, 3), body[b, at.ANGULAR_DAMPING], load3(principal, b, at.MOMENTS)
    q, m = to_principal(state, principal, b)
    if gyroscopic == 1 and d == 0.0 and tau == (0.0, 0.0, 0.0):
        q, m = free_rotor(q, m, moments, weights, h)
    else:
        q, m = kicked_rotor(q, m, moments, tau, d, weights, h, gyroscopic)
    from_principal(state, principal, b, q, m)
    return True


@entry
def step_splitting_4(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Suzuki's composition for bodies that nothing touches. Returns: as `advance_free`."""
    return advance_free(floats, ints, steps, splitting, SUZUKI_4)


@entry
def step_splitting_8(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Kahan and Li's composition for bodies that nothing touches. Returns: as `advance_free`."""
    return advance_free(floats, ints, steps, splitting, KAHAN_LI_8)
