"""Threaded bodies: does what was put over a post stay on it?

A ring that a post goes through holds the post in the place of its own centre of mass. While neither breaks or passes through
the other, it can leave over the post's end alone.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Box, PlacedShape
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import rotate_back


def _outside(placed: PlacedShape, points_B: Floats) -> Floats:
    """The distance (t,) m of points (t, 3) in B from a box of the body; 0 within it."""
    assert isinstance(placed.shape, Box)
    points_S = rotate_back(np.array(placed.q_BS), points_B - np.array(placed.p_BS))
    away: Floats = np.linalg.norm(np.maximum(np.abs(points_S) - np.array(placed.shape.half_extents), 0.0), axis=-1)
    return away


@metric("m", verdict="a ring that a post goes through comes off it sideways, which no solid ring can")
def unthreaded(run: Run) -> float:
    """topology: greatest distance of a ring's centre of mass from the box that the ring was put over, 0 while within"""
    if len(run.actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    farthest, threaded = 0.0, 0
    for place, ring in enumerate(run.scene.bodies):
        for other, holder in enumerate(run.scene.bodies):
            if other == place or not ring.movable or not run.scene.collides(ring, holder):
                continue
            start = rotate_back(np.array(holder.q_WB), np.array(ring.p_WB) - np.array(holder.p_WB))
            for placed in holder.collision:
                if isinstance(placed.shape, Box) and _outside(placed, start[None])[0] == 0.0:
                    threaded += 1
                    path = rotate_back(run.actual.q_WB[:, other], run.actual.p_WB[:, place] - run.actual.p_WB[:, other])
                    farthest = max(farthest, float(np.max(_outside(placed, path))))
    if not threaded:
        raise NotMeasurable("no body is put over a box of another: no centre of mass lies in one at the start")
    return farthest
