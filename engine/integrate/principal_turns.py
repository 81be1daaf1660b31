"""Exact turns of a rotor about one principal axis: the flows of which its splitting methods are composed.

For the energy k m_i^2 / 2 alone a body turns about axis i by k m_i h, and its momentum in the body's frame turns back as much.

Source: Dullweber, Leimkuhler, McLachlan, J. Chem. Phys. 107 (1997) 5840, section III.
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.elementary import cos_sin
from plumbline.engine.maths.rows import Quat, Vec


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
    """Turn by the angle [rad] about the second axis of the body."""
    c, s = cos_sin(0.5 * angle)
    cosine, sine = 1.0 - 2.0 * s * s, 2.0 * s * c
    return (
        (c * q[0] - s * q[2], c * q[1] - s * q[3], c * q[2] + s * q[0], c * q[3] + s * q[1]),
        (cosine * m[0] - sine * m[2], m[1], cosine * m[2] + sine * m[0]),
    )


@kernel
def turn_third(q: Quat, m: Vec, angle: float) -> tuple[Quat, Vec]:
    """Turn by the angle [rad] about the third axis of the body."""
    c, s = cos_sin(0.5 * angle)
    cosine, sine = 1.0 - 2.0 * s * s, 2.0 * s * c
    return (
        (c * q[0] - s * q[3], c * q[1] + s * q[2], c * q[2] - s * q[1], c * q[3] + s * q[0]),
        (cosine * m[0] + sine * m[1], cosine * m[1] - sine * m[0], m[2]),
    )
