"""Overlap of inscribed balls: bodies that pass through each other betray themselves by their places alone.

The ball inscribed in a convex shape about its centre lies inside it however it turns, so that two of them that overlap, or one
that reaches into a half space at rest, prove that the bodies do. It is less than the true depth, and needs no word from the
engine's own contacts.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Body, Box, Capsule, Cylinder, Ellipsoid, Plane, Sphere
from plumbline.harness.trajectory.kinematics import rotate


def _inscribed(body: Body) -> float | None:
    """Radius [m] of the ball about the centre of mass that the body's only shape holds; None for other bodies."""
    if len(body.collision) != 1 or any(body.collision[0].p_BS):
        return None
    match body.collision[0].shape:
        case Sphere(radius=radius) | Capsule(radius=radius):
            return radius
        case Box(half_extents=half) | Ellipsoid(semi_axes=half):
            return min(half)
        case Cylinder(radius=radius, half_length=half_length):
            return min(radius, half_length)
        case _:
            return None


@metric("m")
def inscribed_overlap(run: Run) -> float:
    """definition: greatest overlap, at any sample, of the balls inscribed in two bodies that can touch; 0 where none"""
    if len(run.actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    radii = [_inscribed(body) for body in run.scene.bodies]
    deepest, pairs = -np.inf, 0
    for a, r_a in enumerate(radii):
        for b in range(a + 1, len(radii)):
            r_b = radii[b]
            if r_a is None or r_b is None or not run.scene.collides(run.scene.bodies[a], run.scene.bodies[b]):
                continue
            pairs += 1
            distance = np.linalg.norm(run.actual.p_WB[:, a] - run.actual.p_WB[:, b], axis=-1)
            deepest = np.maximum(deepest, np.max(r_a + r_b - distance))
        for b, other in enumerate(run.scene.bodies):
            if r_a is None or other.motion != "static" or not run.scene.collides(run.scene.bodies[a], other):
                continue
            for placed in other.collision:
                if isinstance(placed.shape, Plane):
                    normal = rotate(np.array(other.q_WB), rotate(np.array(placed.q_BS), np.array(placed.shape.normal)))
                    within = run.actual.p_WB[:, b] + rotate(np.array(other.q_WB), np.array(placed.p_BS))
                    pairs += 1
                    deepest = np.maximum(deepest, np.max(r_a - (run.actual.p_WB[:, a] - within) @ normal))
    if pairs == 0:
        raise NotMeasurable("no two bodies of one convex shape can touch")
    return float(np.maximum(deepest, 0.0))
