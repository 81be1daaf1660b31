"""Integrators of bodies that nothing touches, composed of kicks by loads and damping, drifts and turns, each of them exact.

    S(h) = K(h/2) D(h) R(h) K(h/2),    step(h) = S(g_s h) ... S(g_2 h) S(g_1 h)

K changes velocities at rest, D moves the centre of mass, and R turns a body without load: a symmetric step of second order,
composed to order four or eight. For the energy k m_i^2 / 2 alone a body turns about principal axis i by k m_i h, and its
momentum in its own frame turns back as much. Of such turns X, Y and Z velocity Verlet (leapfrog) makes

    R(h) = X(h/2) Y(h/2) Z(h) Y(h/2) X(h/2)

Splitting makes far better ones: with moments I1 <= I2 <= I3 a free rotor's energy is |m|^2 / (2 I2) + (1/I1 - 1/I2) m1^2 / 2 +
(1/I3 - 1/I2) m3^2 / 2, a turn C about L, which commutes with the rest, and turns A about axis 1 and B about axis 3:

    R(h) = A(h/2) B(h) A(h/2) C(h)

Source: Verlet, Phys. Rev. 159 (1967) 98; Dullweber, Leimkuhler, McLachlan, J. Chem. Phys. 107 (1997) 5840 (turns); Fasso, J.
Comput. Phys. 189 (2003) 527 (the splitting); Suzuki, Phys. Lett. A 146 (1990) 319 (order four); Kahan, Li, Math. Comput. 66
(1997) 1089 (order eight, 17 stages); Hairer, Lubich, Wanner, Geometric Numerical Integration, section V.3.2.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.integrate.free_body import (
    advance_free,
    from_principal,
    is_pushed,
    kicked_spin,
    kicked_velocity,
    law_of,
    to_principal,
    turned_by,
    velocities_of,
)
from plumbline.engine.maths.elementary import cos_sin
from plumbline.engine.maths.rows import Floats, Ints, Quat, Vec, load3, store3
from plumbline.engine.maths.vec import axpy, scale
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies

ROOT_OF_FOUR = 1.5874010519681994748  # the third
SUZUKI_4: Final = np.array([1.0, 1.0, -ROOT_OF_FOUR, 1.0, 1.0]) / (4.0 - ROOT_OF_FOUR)
KAHAN_LI_HALF = (
    0.13020248308889008087881763, 0.56116298177510838456196441, -0.38947496264484728640807860, 0.15884190655515560089621075,
    -0.39590389413323757733623154, 0.18453964097831570709183254, 0.25837438768632204729397911, 0.29501172360931029087096624,
)  # fmt: skip
KAHAN_LI_8: Final = np.array([*KAHAN_LI_HALF, -0.60550853383003451169892108, *KAHAN_LI_HALF[::-1]])
ONE_STEP: Final = np.array([1.0])

Rotor = Callable[[Quat, Vec, Vec, Floats, float], tuple[Quat, Vec, bool]]
"""R(g_s h) ... R(g_1 h): (q, m, moments, weights g, h) -> q, m, and whether they were found."""


@kernel
def turn_first(q: Quat, m: Vec, angle: float) -> tuple[Quat, Vec]:
    """Turn by the angle [rad] about the first axis of the body."""
    c, s = cos_sin(0.5 * angle)
    cosine, sine = 1.0 - 2.0 * s * s, 2.0 * s * c
    return (
        (c * q[0] - s * q[1], c * q[1] + s * q[0], c * q[2] + s * q[3], c * q[3] - s * q[2]),
        (m[0], cosine * m[1] + sine * m[2], cosine * m[2] - sine * m[1]),
    )


@kernel
def turn_second(q: Quat, m: Vec, angle: float) -> tuple[Quat, Vec]:
    """Turn by the angle [rad] about the second axis of the body: the first of axes that are named the other way round."""
    (w, y, z, x), (n, o, p) = turn_first((q[0], q[2], q[3], q[1]), (m[1], m[2], m[0]), angle)
    return (w, x, y, z), (p, n, o)


@kernel
def turn_third(q: Quat, m: Vec, angle: float) -> tuple[Quat, Vec]:
    """Turn by the angle [rad] about the third axis of the body."""
    (w, z, x, y), (o, p, n) = turn_first((q[0], q[3], q[1], q[2]), (m[2], m[0], m[1]), angle)
    return (w, x, y, z), (p, n, o)


@kernel
def verlet_rotor(q: Quat, m: Vec, moments: Vec, weights: Floats, h: float) -> tuple[Quat, Vec, bool]:
    """Turns about all three axes, there and back. Args: as of `Rotor`, here and below."""
    for k in range(len(weights)):
        half = 0.5 * weights[k] * h
        q, m = turn_first(q, m, half * m[0] / moments[0])
        q, m = turn_second(q, m, half * m[1] / moments[1])
        q, m = turn_third(q, m, 2.0 * half * m[2] / moments[2])
        q, m = turn_second(q, m, half * m[1] / moments[1])
        q, m = turn_first(q, m, half * m[0] / moments[0])
    return q, m, True


@kernel
def split_rotor(q: Quat, m: Vec, moments: Vec, weights: Floats, h: float) -> tuple[Quat, Vec, bool]:
    """Neighbouring turns A are one, and C, which commutes with both, comes once at the end."""
    first, third = h * (1.0 / moments[0] - 1.0 / moments[1]), h * (1.0 / moments[2] - 1.0 / moments[1])
    before, total = 0.0, 0.0
    for k in range(len(weights)):
        q, m = turn_first(q, m, 0.5 * (before + weights[k]) * first * m[0])
        q, m = turn_third(q, m, weights[k] * third * m[2])
        before = weights[k]
        total += weights[k]
    q, m = turn_first(q, m, 0.5 * before * first * m[0])
    return turned_by(q, scale(1.0 / moments[1], m), total * h), m, True


@kernel
def compose(
    bodies: Bodies, principal: Floats, setting: Floats, b: int, h: float, gyroscopic: int, weights: Floats, rotor: Rotor
) -> bool:
    """Advance body b by h in steps of these weights, whose sum is one. Returns: whether all turns were found."""
    state = bodies.state
    if not is_pushed(state, bodies.kind, b, h):
        return True
    law, p, v = law_of(bodies, principal, setting, b, gyroscopic), load3(state, b, at.P), load3(state, b, at.V)
    if law.c == 0.0:
        # A constant acceleration is kicked and drifted exactly, whatever the composition.
        p, v = axpy(0.5 * h * h, law.a, axpy(h, v, p)), axpy(h, law.a, v)
    q, m = to_principal(state, principal, b)
    free, solved = law.d == 0.0 and law.tau == (0.0, 0.0, 0.0), True
    if free and gyroscopic == 1:
        q, m, solved = rotor(q, m, law.moments, weights, h)
    elif free:
        q = turned_by(q, velocities_of(m, law.moments), h)
    for k in range(len(weights)):
        g = weights[k] * h
        if law.c != 0.0:
            v = kicked_velocity(v, law.a, law.c, 0.5 * g)
            p = axpy(g, v, p)
            v = kicked_velocity(v, law.a, law.c, 0.5 * g)
        if not free:
            m = kicked_spin(q, m, law, 0.5 * g)
            if gyroscopic == 1:
                q, m, turned = rotor(q, m, law.moments, weights[k : k + 1], h)
                solved = solved and turned
            else:
                q = turned_by(q, velocities_of(m, law.moments), g)
            m = kicked_spin(q, m, law, 0.5 * g)
    store3(state, b, at.P, p)
    store3(state, b, at.V, v)
    from_principal(state, principal, b, q, m)
    return solved


@entry
def step_velocity_verlet(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Velocity Verlet for bodies that nothing touches. Returns: as `advance_free`."""
    return advance_free(floats, ints, steps, compose, ONE_STEP, verlet_rotor)


@entry
def step_splitting_4(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Suzuki's composition for bodies that nothing touches. Returns: as `advance_free`."""
    return advance_free(floats, ints, steps, compose, SUZUKI_4, split_rotor)


@entry
def step_splitting_8(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Kahan and Li's composition for bodies that nothing touches. Returns: as `advance_free`."""
    return advance_free(floats, ints, steps, compose, KAHAN_LI_8, split_rotor)
