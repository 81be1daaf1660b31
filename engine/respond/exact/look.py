"""The compiled look at a point of the traced path, in doubles: what `trace.look` writes as arrays, contact by contact."""

import math

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.elementary import exp, hypot, log
from plumbline.engine.maths.rows import Floats, Ints

MISS, RATE, SIZE, ENDS, ROOM, COLUMNS = 0, 3, 6, 7, 10, 13
"""Of what is said of a contact: F (3), dF / d log w (3), the size of its impulse, F on the ends of its frame (3), and what room
each has to the boundary of the cone (3)."""
ROUND_OFF = 2.0 * 2.0**-52


@kernel
def root_of(value: float, width: float) -> tuple[float, float]:
    """As `cone.root`, of one number."""
    length = 0.5 * (abs(value) + math.sqrt(value * value + 4.0 * width * width))
    other = width * width / max(length, 1e-300)
    return (length, other) if value >= 0.0 else (other, length)


@entry
def look_at(w: Floats, q: Floats, rubs: Ints, x: Floats, widths: tuple[float, float], slope: Floats, out: Floats) -> float:
    """Write -dF/dx into `slope` (3k, 3k), and what there is of each contact into `out` (k, COLUMNS).

    Args: w (3k, 3k), q (k, 3), x (k, 3): as `trace.look`; rubs (k,): 1 with friction; widths: w, and the power of it that is
        the width of sliding.
    Returns: how far the point is from the path.
    """
    k = len(x)
    n, width, power = 3 * k, widths[0], widths[1]
    soft, dim = width * width, exp(power * log(width))
    largest = 0.0
    for i in range(k):
        y0, y1, y2 = q[i, 0] + soft * x[i, 0], q[i, 1] + soft * x[i, 1], q[i, 2] + soft * x[i, 2]
        for j in range(k):
            for c in range(3):
                a = x[j, c]
                y0 += w[3 * j + c, 3 * i] * a
                y1 += w[3 * j + c, 3 * i + 1] * a
                y2 += w[3 * j + c, 3 * i + 2] * a
        if rubs[i] == 0:
            y1, y2 = 0.0, 0.0
        square = y1 * y1 + y2 * y2
        size = math.sqrt(square + dim * dim)
        blur = (dim / size) ** 2
        lift1, lift2 = y1 / size * (1.0 + blur), y2 / size * (1.0 + blur)
        if rubs[i] == 1:
            y0 += square / size
        z0, z1, z2 = x[i, 0] - y0, x[i, 1] - y1, x[i, 2] - y2
        largest = max(largest, abs(z0), abs(z1), abs(z2))
        length = hypot(z1, z2)
        t1, t2 = (z1 / length, z2 / length) if length > 0.0 else (1.0, 0.0)
        low, high = z0 - length, z0 + length
        p_low, c_low = root_of(low, width)
        p_high, c_high = root_of(high, width)
        if x[i, 0] < y0:
            half = 0.5 * (p_high - p_low)
            m0, m1, m2 = 0.5 * (p_low + p_high) - x[i, 0], half * t1 - x[i, 1], half * t2 - x[i, 2]
        else:
            half = 0.5 * (c_high - c_low)
            m0, m1, m2 = 0.5 * (c_low + c_high) - y0, half * t1 - y1, half * t2 - y2
        # The eigenvalues of dp/dz on the ends (1, -t), (1, t) of the frame and across it.
        p_across, c_across = p_low + p_high, c_low + c_high
        at_low, at_high, at_across = p_low / (p_low + c_low), p_high / (p_high + c_high), p_across / (p_across + c_across)
        mean, half = 0.5 * (at_low + at_high), 0.5 * (at_high - at_low)
        b01, b02 = half * t1, half * t2
        b11, b22 = mean * t1 * t1 + at_across * t2 * t2, mean * t2 * t2 + at_across * t1 * t1
        b12 = (mean - at_across) * t1 * t2
        for c in range(n):
            r1, r2 = w[3 * i + 1, c], w[3 * i + 2, c]
            if c == 3 * i + 1:
                r1 += soft
            if c == 3 * i + 2:
                r2 += soft
            r0 = w[3 * i, c] + lift1 * r1 + lift2 * r2
            if c == 3 * i:
                r0 += soft
            slope[3 * i, c] = mean * r0 + b01 * r1 + b02 * r2
            slope[3 * i + 1, c] = b01 * r0 + b11 * r1 + b12 * r2
            slope[3 * i + 2, c] = b02 * r0 + b12 * r1 + b22 * r2
        # 1 - dp/dz from its own eigenvalues, which would cancel in the difference.
        un_low, un_high, un_across = c_low / (p_low + c_low), c_high / (p_high + c_high), c_across / (p_across + c_across)
        un_mean, un_half = 0.5 * (un_low + un_high), 0.5 * (un_high - un_low)
        u11, u22 = un_mean * t1 * t1 + un_across * t2 * t2, un_mean * t2 * t2 + un_across * t1 * t1
        u12 = (un_mean - un_across) * t1 * t2
        slope[3 * i, 3 * i] += un_mean
        slope[3 * i, 3 * i + 1] += un_half * t1
        slope[3 * i, 3 * i + 2] += un_half * t2
        slope[3 * i + 1, 3 * i] += un_half * t1
        slope[3 * i + 1, 3 * i + 1] += u11
        slope[3 * i + 1, 3 * i + 2] += u12
        slope[3 * i + 2, 3 * i] += un_half * t2
        slope[3 * i + 2, 3 * i + 1] += u12
        slope[3 * i + 2, 3 * i + 2] += u22
        s0, s1, s2 = 2.0 * soft * x[i, 0], 2.0 * soft * x[i, 1], 2.0 * soft * x[i, 2]
        if rubs[i] == 1:
            s0 += lift1 * s1 + lift2 * s2 - power * square / size * blur
        r_low, r_high = 2.0 * soft / hypot(low, 2.0 * width), 2.0 * soft / hypot(high, 2.0 * width)
        half = 0.5 * (r_high - r_low)
        out[i, RATE] = 0.5 * (r_low + r_high) - (mean * s0 + b01 * s1 + b02 * s2)
        out[i, RATE + 1] = half * t1 - (b01 * s0 + b11 * s1 + b12 * s2)
        out[i, RATE + 2] = half * t2 - (b02 * s0 + b12 * s1 + b22 * s2)
        out[i, MISS], out[i, MISS + 1], out[i, MISS + 2] = m0, m1, m2
        out[i, SIZE] = p_high
        along = m1 * t1 + m2 * t2
        out[i, ENDS], out[i, ENDS + 1], out[i, ENDS + 2] = m0 - along, m0 + along, m2 * t1 - m1 * t2
        out[i, ROOM], out[i, ROOM + 1], out[i, ROOM + 2] = min(p_low, c_low), min(p_high, c_high), min(p_across, c_across)
    off = 0.0
    for i in range(k):
        for c in range(3):
            share = abs(out[i, ENDS + c]) / (out[i, ROOM + c] + ROUND_OFF * (0.2 + largest))
            if math.isnan(share):
                return math.nan
            off = max(off, share)
    return off
