"""The principal frame of a body's inertia, found once when a world is built."""

import numpy as np

from plumbline.engine.maths.arrays import det, eigen, unit
from plumbline.engine.maths.types import Floats


def principal_frame(inertia: Floats) -> tuple[Floats, Floats]:
    """The principal moments and axes of an inertia, I_B = R_BP diag(moments) R_BP^T.

    Args: inertia (3, 3) kg m2, symmetric, in B.
    Returns: moments (3,) kg m2 in ascending order, and q_BP (w, x, y, z).
    Source: Goldstein, Poole, Safko, Classical Mechanics, 3rd ed., section 5.4; Markley, J. Guid. Control Dyn. 31 (2008) 440
    (the quaternion of a matrix from its largest column).
    """
    if np.count_nonzero(inertia - np.diag(np.diag(inertia))) == 0:
        # The axes of a diagonal inertia are those of B: only their order may change, and nothing is rounded.
        order = np.argsort(np.diag(inertia), kind="stable")
        moments, axes = np.diag(inertia)[order], np.eye(3)[:, order]
    else:
        moments, axes = eigen(inertia)
    if det(axes) < 0:
        axes = axes * (1.0, 1.0, -1.0)
    (a, b, c), (d, e, f), (g, h, i) = axes
    columns = np.array(
        [
            [1 + a + e + i, h - f, c - g, d - b],
            [h - f, 1 + a - e - i, b + d, c + g],
            [c - g, b + d, 1 - a + e - i, f + h],
            [d - b, c + g, f + h, 1 - a - e + i],
        ]
    )
    q = columns[int(np.argmax(np.diag(columns)))]
    return moments, unit(q)
