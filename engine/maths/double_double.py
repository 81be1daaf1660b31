"""Numbers as unevaluated sums of two floats, high and low, with 106 bits between them.

Source: Dekker, A Floating-Point Technique for Extending the Available Precision, Numer. Math. 18, 1971; Hida, Li, Bailey,
Library for Double-Double and Quad-Double Arithmetic, 2007.
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Vec

Double = tuple[float, float]

SPLIT = 134217729.0
"""2^27 + 1: halves of a float have 26 bits each, whose products are exact (Veltkamp)."""


@kernel
def two_sum(a: float, b: float) -> Double:
    """a + b without error."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@kernel
def product(a: float, b: float) -> Double:
    """a b without error, for factors below 1e292."""
    whole = a * b
    t = SPLIT * a
    a_high = t - (t - a)
    a_low = a - a_high
    t = SPLIT * b
    b_high = t - (t - b)
    b_low = b - b_high
    return whole, ((a_high * b_high - whole) + a_high * b_low + a_low * b_high) + a_low * b_low


@kernel
def add2(x: Double, y: Double) -> Double:
    """x + y."""
    high, error = two_sum(x[0], y[0])
    low, rest = two_sum(x[1], y[1])
    high, error = two_sum(high, error + low)
    return two_sum(high, error + rest)


@kernel
def less2(x: Double, y: Double) -> Double:
    """x - y."""
    return add2(x, (-y[0], -y[1]))


@kernel
def mul2(x: Double, y: Double) -> Double:
    """x y."""
    high, error = product(x[0], y[0])
    return two_sum(high, error + (x[0] * y[1] + x[1] * y[0]))


@kernel
def div2(x: Double, y: Double) -> Double:
    """x / y, by three steps of long division."""
    first = x[0] / y[0]
    rest = less2(x, mul2((first, 0.0), y))
    second = rest[0] / y[0]
    rest = less2(rest, mul2((second, 0.0), y))
    return add2(two_sum(first, second), (rest[0] / y[0], 0.0))


@kernel
def dot2(a: Vec, x: Double, y: Double, z: Double) -> Double:
    """a . (x, y, z)."""
    return add2(add2(mul2((a[0], 0.0), x), mul2((a[1], 0.0), y)), mul2((a[2], 0.0), z))
