"""Sines, exponentials and the like by additions and multiplications alone, in the order in which they stand here.

The C library's own differ by library and by processor in the last bit, and a pendulum keeps that bit. Errors are of the exact
value, in units of the last place, the largest that 1e5 arguments and the ends of each range showed (tested).

Source: Cody, Waite, Software Manual for the Elementary Functions, 1980 (reduction by a constant in parts); Payne, Hanek, ACM
SIGNUM Newsletter 18, 1983 (of huge angles); Muller, Elementary Functions, 3rd ed., 2016. Polynomials are Taylor's, cut where
the next term is below 1e-17 of the sum.
"""

import math

import numpy as np

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.floats import fma, from_word, word

PI_HALF = (1.5707963267948966, 6.123233995736766e-17)
PI = (3.141592653589793, 1.2246467991473532e-16)
PI_HALF_PARTS = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21)
"""pi / 2 in parts of which the first two have 33 bits: whole multiples below 2^20 of them are exact."""
EIGHTH = 0.7853981633974483
FAR = 8e5
"""Angles from here on are reduced by as many digits of 2 / pi as they need."""
ROUNDING = 6755399441055744.0
"""1.5 2^52: added and taken away again it leaves the nearest whole number."""
ONE_OVER_LOG_2 = 1.4426950408889634
LOG_2 = (0.6931471803691238, 1.9082149292705877e-10)
"""The first part has 32 bits: its multiples by an exponent are exact."""
BIAS, FRACTION_BITS = 1023, 52
FRACTION = (1 << FRACTION_BITS) - 1
TINY = 1.0 / (1 << 400)
DIGIT = 24
"""Bits of a digit of 2 / pi: products of two digits, and sums of three of those, are whole numbers below 2^63."""
TWO_OVER_PI = np.array([
    10680707, 7228996, 1387004, 2578385, 16069853, 12639074, 9804092, 4427841, 16666979, 11263675, 12935607, 2387514, 4345298,
    14681673, 3074569, 13734428, 16653803, 1880361, 10960616, 8533493, 3062596, 8710556, 7349940, 6258241, 3772886, 3769171,
    3798172, 8675211, 12450088, 3874808, 9961438, 366607, 15675153, 9132554, 7151469, 3571407, 2607881, 12013382, 4155038,
    6285869, 7677882, 13102053, 15825725, 473591, 9065106, 15363067, 6271263, 9264392, 5636912, 4652155,
])  # fmt: skip
ANGLES = np.array([
    (0.0, 0.0), (0.06241880999595735, -1.5490756308295046e-18), (0.12435499454676144, -3.1253241424539383e-18),
    (0.18534794999569476, 4.180692268843079e-18), (0.24497866312686414, 1.0698755618734451e-17),
    (0.3028848683749714, -1.1010827903001369e-17), (0.35877067027057225, -2.4623815582638635e-17),
    (0.4124104415973873, -1.587652227770689e-17), (0.4636476090008061, 2.2698777452961687e-17),
    (0.5123894603107377, -2.5462781472855804e-17), (0.5585993153435624, -5.4556305485916264e-18),
    (0.6022873461349642, 2.950430737228402e-17), (0.6435011087932844, 1.5834785051444286e-17),
    (0.6823165548747481, 6.943223671560008e-18), (0.7188299996216245, -2.1478388444456983e-17),
    (0.7531512809621944, -2.4256934659182068e-17), (0.7853981633974483, 3.061616997868383e-17),
])  # fmt: skip
"""The angles whose tangents are k / 16, high and low."""


@kernel
def cos_sin(x: float) -> tuple[float, float]:
    """The cosine and the sine of an angle [rad]. Errors: below 1 unit in the last place."""
    size = abs(x)
    if size < 1e-8:
        return 1.0, x
    if not size < math.inf:
        return math.nan, math.nan
    quarters, high, low = 0, size, 0.0
    if size >= EIGHTH:
        quarters, high, low = _reduced(size) if size < FAR else _reduced_far(size)
    z = high * high
    zz = z * z
    s = fma(zz, fma(zz, 1 / 355687428096000, fma(z, -1 / 1307674368000, 1 / 6227020800)), fma(z, -1 / 39916800, 1 / 362880))
    s = fma(zz, s, fma(z, -1 / 5040, 1 / 120))
    sine = high + fma(high * z, fma(z, s, -1 / 6), low * fma(-0.5, z, 1.0))
    c = fma(zz, fma(z, 1 / 20922789888000, -1 / 87178291200), fma(z, 1 / 479001600, -1 / 3628800))
    even = fma(-high, low, zz * fma(z, fma(z, fma(z, c, 1 / 40320), -1 / 720), 1 / 24))
    rest = fma(-0.5, z, 1.0)
    cosine = rest + (fma(-0.5, z, 1.0 - rest) + even)
    if quarters & 1:
        cosine, sine = -sine, cosine
    if quarters & 2:
        cosine, sine = -cosine, -sine
    return cosine, sine if x > 0.0 else -sine


@kernel
def _reduced(x: float) -> tuple[int, float, float]:
    """How many quarter turns an angle is, and what is left, high and low, at most an eighth of a turn."""
    n = (x * (2.0 / math.pi) + ROUNDING) - ROUNDING
    first, second = x - n * PI_HALF_PARTS[0], n * PI_HALF_PARTS[1]
    rest = first - second
    part = rest - first
    low = ((first - (rest - part)) - (second + part)) - n * PI_HALF_PARTS[2]
    high = rest + low
    return int(n) & 3, high, (rest - high) + low


@kernel
def _reduced_far(x: float) -> tuple[int, float, float]:
    """The same by the digits of 2 / pi that are worth less than a whole turn, the product in whole numbers."""
    mantissa = (word(x) & FRACTION) | (1 << FRACTION_BITS)
    exponent = (word(x) >> FRACTION_BITS) - BIAS - FRACTION_BITS
    first = max(0, (exponent - 2) // DIGIT)
    lowest = exponent - DIGIT * (first + 9)
    mask = (1 << DIGIT) - 1
    digits = np.zeros(13, np.int64)
    for k in range(9):
        for i in range(3):
            digits[k + i] += TWO_OVER_PI[first + 8 - k] * ((mantissa >> (DIGIT * i)) & mask)
    for k in range(12):
        digits[k + 1] += digits[k] >> DIGIT
        digits[k] &= mask
    unit, shift = -lowest // DIGIT, -lowest % DIGIT
    quarters = (digits[unit] >> shift) | (digits[unit + 1] << (DIGIT - shift))
    digits[unit] &= (1 << shift) - 1
    # What a digit is worth, in exact pairs from the highest on.
    scale = from_word((BIAS - DIGIT) << FRACTION_BITS)
    worth = from_word((BIAS - shift) << FRACTION_BITS)
    top = digits[unit] * worth
    worth *= scale
    top += digits[unit - 1] * worth
    if top >= 0.5:
        top -= 1.0
        quarters += 1
    middle = (digits[unit - 2] * scale + digits[unit - 3] * scale * scale) * worth
    bottom = (digits[unit - 4] * scale + digits[unit - 5] * scale * scale) * worth * scale * scale
    total = top + middle
    rest = (middle - (total - top)) + bottom
    share, low = total + rest, rest - ((total + rest) - total)
    high = share * PI_HALF[0]
    low = fma(share, PI_HALF[0], -high) + (share * PI_HALF[1] + low * PI_HALF[0])
    return quarters & 3, high + low, low - ((high + low) - high)


@kernel
def exp(x: float) -> float:
    """e^x. Errors: below 1 unit in the last place."""
    if x == 0.0:
        return 1.0
    if not -746.0 < x < 710.0:
        return x if x != x else (math.inf if x > 0.0 else 0.0)
    n, rest = _less_ones(x)
    half = n >> 1
    return ((1.0 + rest) * from_word((half + BIAS) << FRACTION_BITS)) * from_word((n - half + BIAS) << FRACTION_BITS)


@kernel
def expm1(x: float) -> float:
    """e^x - 1. Errors: below 2 units in the last place."""
    if abs(x) < 1e-16:
        return x
    if not -40.0 < x < 40.0:
        return x if x != x else (exp(x) if x > 0.0 else -1.0)
    n, rest = _less_ones(x)
    power = from_word((n + BIAS) << FRACTION_BITS)
    return (power - 1.0) + power * rest


@kernel
def _less_ones(x: float) -> tuple[int, float]:
    """n and e^r - 1, where x = n log 2 + r and r is at most half of log 2 in size."""
    n = (x * (ONE_OVER_LOG_2) + ROUNDING) - ROUNDING
    high, low = x - n * LOG_2[0], n * LOG_2[1]
    r = high - low
    left = (high - r) - low
    rr = r * r
    top = fma(rr, fma(rr, 1 / 6227020800, fma(r, 1 / 479001600, 1 / 39916800)), fma(r, 1 / 3628800, 1 / 362880))
    p = fma(rr, fma(rr, top, fma(r, 1 / 40320, 1 / 5040)), fma(r, 1 / 720, 1 / 120))
    p = fma(rr, p, fma(r, 1 / 24, 1 / 6))
    return int(n), r + fma(rr, fma(r, p, 0.5), left)


@kernel
def log(x: float) -> float:
    """The natural logarithm. Errors: below 1 unit in the last place."""
    if not 0.0 < x < math.inf:
        return -math.inf if x == 0.0 else (math.nan if x < 0.0 else x)
    lifted = 54 if x < 2.3e-308 else 0
    bits = word(x * 18014398509481984.0) if lifted else word(x)
    n = (bits >> FRACTION_BITS) - BIAS - lifted
    share = from_word((bits & FRACTION) | (BIAS << FRACTION_BITS))
    if share > 1.4142135623730951:
        share, n = 0.5 * share, n + 1
    f = share - 1.0
    s = f / (2.0 + f)
    z = s * s
    p = 2 / 13 + z * (2 / 15 + z * (2 / 17 + z * (2 / 19 + z * (2 / 21 + z * (2 / 23)))))
    p = z * (2 / 3 + z * (2 / 5 + z * (2 / 7 + z * (2 / 9 + z * (2 / 11 + z * p)))))
    square = 0.5 * f * f
    return n * LOG_2[0] - ((square - (s * (square + p) + n * LOG_2[1])) - f)


@kernel
def fifth_root(x: float) -> float:
    """The fifth root of a number that is not negative. Errors: below 1 unit in the last place."""
    if not 0.0 < x < math.inf:
        return x if x >= 0.0 else math.nan
    y = exp(0.2 * log(x))
    return y - 0.2 * (y - x / (y * y * y * y))


@kernel
def hypot(a: float, b: float) -> float:
    """The length of (a, b). Errors: below 2 units in the last place."""
    large, small = max(abs(a), abs(b)), min(abs(a), abs(b))
    if not 0.0 < large < math.inf:
        return math.inf if large == math.inf or small == math.inf else a * a + b * b
    share = small / large
    return large * math.sqrt(1.0 + share * share)


@kernel
def atan2(y: float, x: float) -> float:
    """The angle [rad] of the direction (x, y). Errors: below 1 unit in the last place."""
    across, ahead = abs(y), abs(x)
    if not (across < math.inf and ahead < math.inf):
        if x != x or y != y:
            return math.nan
        across, ahead = (1.0 if across == math.inf else 0.0), (1.0 if ahead == math.inf else 0.0)
    large, small = max(across, ahead), min(across, ahead)
    if large > 1e300:
        large, small = large * TINY, small * TINY
    elif large < 1e-200:
        large, small = large / TINY, small / TINY
    high, low = _arc(small, large) if small > 0.0 else (0.0, 0.0)
    if across > ahead:
        high, low = _from(PI_HALF, high, low)
    if word(x) < 0:
        high, low = _from(PI, high, low)
    angle = high + low
    return -angle if word(y) < 0 else angle


@kernel
def _arc(y: float, x: float) -> tuple[float, float]:
    """The angle of a direction at most half a right angle from x, high and low."""
    share = y / x
    k = int((16.0 * share + ROUNDING) - ROUNDING) if share > 0.09 else 0
    tangent = k / 16
    u = fma(-tangent, x, y) / (x + tangent * y) if k > 0 else share
    z = u * u
    zz = z * z
    p = fma(zz, fma(zz, 1 / 17, fma(z, -1 / 15, 1 / 13)), fma(z, -1 / 11, 1 / 9))
    p = fma(zz, p, fma(z, -1 / 7, 1 / 5))
    p = u * z * fma(z, p, -1 / 3)
    if k == 0:
        return u, p
    return ANGLES[k, 0], ANGLES[k, 1] + (u + p)


@kernel
def _from(whole: tuple[float, float], high: float, low: float) -> tuple[float, float]:
    """An angle from a larger one back."""
    rest = whole[0] - high
    return rest, ((whole[0] - rest) - high) + (whole[1] - low)
