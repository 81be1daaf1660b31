"""Tunnelling: which of the spheres shot at a wall got through it, their centre beyond its middle?"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import proportion
from plumbline.harness.scene import Body, Box, Scene, Sphere, rotate

SOURCE = "share of spheres whose centre ends beyond the middle of the wall"


def _wall(scene: Scene) -> tuple[Body, Box]:
    for body in scene.bodies:
        if not body.movable and len(body.collision) == 1 and isinstance(body.collision[0].shape, Box):
            return body, body.collision[0].shape
    raise NotMeasurable("no wall: a fixed body of one box")


def _ends(run: Run) -> list[tuple[float, float]]:
    """Of each sphere that is shot: how far [m] its centre ends past the wall's middle, and where it is if it touches the face.

    The wall's extent along the shot is that of its box, which lies across the shot.
    """
    wall, box = _wall(run.scene)
    ends = []
    if len(run.actual) == 0:
        raise NotMeasurable("no samples")
    axes = [np.array(rotate(wall.q_WB, axis)) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
    for place, body in enumerate(run.scene.bodies):
        shapes = [placed.shape for placed in body.collision]
        if body.movable and any(body.v_WB) and len(shapes) == 1 and isinstance(shapes[0], Sphere):
            way = np.array(body.v_WB) / np.linalg.norm(body.v_WB)
            half = float(sum(abs(way @ axis) * extent for axis, extent in zip(axes, box.half_extents, strict=True)))
            ends.append((float((run.actual.p_WB[-1, place] - np.array(wall.p_WB)) @ way), -half - shapes[0].radius))
    if not ends:
        raise NotMeasurable("no sphere is shot")
    return ends


def _count(run: Run) -> tuple[int, int]:
    """How many passed, of how many."""
    ends = _ends(run)
    return sum(distance > 0 for distance, _ in ends), len(ends)


@metric("m", empty="no sphere is stopped")
def stop_gap(run: Run) -> list[float]:
    """greatest distance from the wall's face at which a stopped sphere ends; 0 without restitution, more after a rebound"""
    return [max(0.0, face - distance) for distance, face in _ends(run) if distance <= 0]


tunnel_probability, tunnel_probability_low, tunnel_probability_high = proportion(
    "tunnel_probability", SOURCE, "a centre ends beyond the middle of the wall", _count
)
