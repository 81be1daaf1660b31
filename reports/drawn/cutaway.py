"""A container that moves is drawn without the walls towards the eye, so that what is in it can be seen."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from plumbline.reports.recordings.rotation import Floats, rotate
from plumbline.reports.recordings.shapes import placed_shapes

WALLS = 4
"""A body of fewer shapes encloses nothing."""
NEAR = 0.15
"""Of the distance of the farthest wall from the middle: a wall nearer to the eye than this stands in the way."""
CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


def opened(bodies: Sequence[Mapping[str, Any]], p_WB: Floats, q_WB: Floats, towards: Floats) -> list[Mapping[str, Any]]:
    """The bodies at poses (n, 3) m and (n, 4); one that holds most of what else moves has its far walls alone.

    Args: towards (3,): the direction from the scene to the eye, of unit length.
    """
    moving = [k for k, body in enumerate(bodies) if body["motion"] != "static"]
    shown = list(bodies)
    for k in moving:
        shapes, others = placed_shapes(bodies[k]), [other for other in moving if other != k]
        if len(shapes) < WALLS or not others:
            continue
        walls = np.array([shape.get("p_BS", (0.0, 0.0, 0.0)) for shape in shapes], dtype=np.float64)
        back = q_WB[k] * CONJUGATE
        held = rotate(np.broadcast_to(back, (len(others), 4)), p_WB[others] - p_WB[k])
        if np.mean(((held > walls.min(axis=0)) & (held < walls.max(axis=0))).all(axis=1)) <= 0.5:
            continue
        out = walls - walls.mean(axis=0)
        near = out @ rotate(back, towards) > NEAR * np.linalg.norm(out, axis=1).max()
        shown[k] = {**bodies[k], "visual": [shape for shape, hides in zip(shapes, near, strict=True) if not hides]}
    return shown
