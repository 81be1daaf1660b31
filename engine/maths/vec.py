"""Arithmetic of vectors, quaternions and matrices, which are tuples of numbers as `rows` has them."""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.elementary import cos_sin
from plumbline.engine.maths.floats import fma
from plumbline.engine.maths.rows import Mat, Quat, Sym, Vec


@kernel
def add(a: Vec, b: Vec) -> Vec:
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@kernel
def sub(a: Vec, b: Vec) -> Vec:
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel
def neg(a: Vec) -> Vec:
    """-a."""
    return -a[0], -a[1], -a[2]


@kernel
def scale(s: float, a: Vec) -> Vec:
    """s a."""
    return s * a[0], s * a[1], s * a[2]


@kernel
def axpy(s: float, a: Vec, b: Vec) -> Vec:
    """s a + b."""
    return fma(s, a[0], b[0]), fma(s, a[1], b[1]), fma(s, a[2], b[2])


@kernel
def dot(a: Vec, b: Vec) -> float:
    """a . b."""
    return fma(a[2], b[2], fma(a[1], b[1], a[0] * b[0]))


@kernel
def cross(a: Vec, b: Vec) -> Vec:
    """a x b."""
    return fma(a[1], b[2], -a[2] * b[1]), fma(a[2], b[0], -a[0] * b[2]), fma(a[0], b[1], -a[1] * b[0])


@kernel
def norm(a: Vec) -> float:
    """|a|."""
    return math.sqrt(dot(a, a))


@kernel
def along(a: Vec, fallback: Vec) -> Vec:
    """a / |a|, or the fallback where a vanishes."""
    length = norm(a)
    if length > 1e-300:
        return scale(1.0 / length, a)
    return fallback


@kernel
def perpendicular(a: Vec) -> Vec:
    """A unit vector at right angles to the unit vector a."""
    x, y, z = abs(a[0]), abs(a[1]), abs(a[2])
    if x <= y and x <= z:
        return along((0.0, -a[2], a[1]), (1.0, 0.0, 0.0))
    if y <= z:
        return along((a[2], 0.0, -a[0]), (1.0, 0.0, 0.0))
    return along((-a[1], a[0], 0.0), (1.0, 0.0, 0.0))


@kernel
def quat_mul(a: Quat, b: Quat) -> Quat:
    """Hamilton product: first b, then a."""
    return (
        fma(-a[3], b[3], fma(-a[2], b[2], fma(-a[1], b[1], a[0] * b[0]))),
        fma(-a[3], b[2], fma(a[2], b[3], fma(a[1], b[0], a[0] * b[1]))),
        fma(a[3], b[1], fma(a[2], b[0], fma(-a[1], b[3], a[0] * b[2]))),
        fma(a[3], b[0], fma(-a[2], b[1], fma(a[1], b[2], a[0] * b[3]))),
    )


@kernel
def quat_conj(q: Quat) -> Quat:
    """The inverse rotation."""
    return q[0], -q[1], -q[2], -q[3]


@kernel
def quat_unit(q: Quat) -> Quat:
    """q / |q|."""
    s = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return s * q[0], s * q[1], s * q[2], s * q[3]


@kernel
def quat_spin(q: Quat, w: Vec, h: float) -> Quat:
    """exp(h w) q, as long as q to round-off: turned for h seconds at the constant angular velocity w [rad/s] in W.

    Small angles take the series of sine and cosine, a few terms of which give the last bit.

    Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, section VII.5.
    """
    square = 0.25 * h * h * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    if square < 0.01:
        # Power series whose first terms left out are below 1e-17.
        sine = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))
        cosine = 1.0 - square / 2.0 * (
            1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0 * (1.0 - square / 90.0)))
        )
    else:
        angle = math.sqrt(square)
        cosine, sine = cos_sin(angle)
        sine = sine / angle
    s = 0.5 * h * sine
    return quat_mul((cosine, s * w[0], s * w[1], s * w[2]), q)


@kernel
def quat_turn(q: Quat, w: Vec, h: float) -> Quat:
    """exp(h w) q / |q|: the orientation after turning for h seconds at the constant angular velocity w [rad/s] in W."""
    return quat_unit(quat_spin(q, w, h))


@kernel
def quat_mat(q: Quat) -> Mat:
    """The rotation matrix of a quaternion of any length but zero."""
    w, x, y, z = q
    s = 2.0 / (w * w + x * x + y * y + z * z)
    return (
        1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y),
        s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x),
        s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y),
    )  # fmt: skip


@kernel
def mat_vec(m: Mat, v: Vec) -> Vec:
    """M v."""
    return dot((m[0], m[1], m[2]), v), dot((m[3], m[4], m[5]), v), dot((m[6], m[7], m[8]), v)


@kernel
def tmat_vec(m: Mat, v: Vec) -> Vec:
    """M^T v."""
    return dot((m[0], m[3], m[6]), v), dot((m[1], m[4], m[7]), v), dot((m[2], m[5], m[8]), v)


@kernel
def sym_vec(s: Sym, v: Vec) -> Vec:
    """S v."""
    return dot((s[0], s[3], s[4]), v), dot((s[3], s[1], s[5]), v), dot((s[4], s[5], s[2]), v)


@kernel
def sym_scale(a: float, s: Sym) -> Sym:
    """a S."""
    return a * s[0], a * s[1], a * s[2], a * s[3], a * s[4], a * s[5]


@kernel
def sym_rotate(m: Mat, s: Sym) -> Sym:
    """M S M^T."""
    x, y, z = (m[0], m[1], m[2]), (m[3], m[4], m[5]), (m[6], m[7], m[8])
    a, b, c = sym_vec(s, x), sym_vec(s, y), sym_vec(s, z)
    return dot(a, x), dot(b, y), dot(c, z), dot(a, y), dot(a, z), dot(b, z)
