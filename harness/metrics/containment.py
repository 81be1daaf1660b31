"""Containment: how many of the spheres in a hollow box of walls got out of it."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Box, Scene, Sphere, rotation_matrix
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import rotate_back


def _container(scene: Scene) -> tuple[int, Floats]:
    """Place of the body of at least six boxes, and the half extents (3,) m of the box that bounds them all, in B."""
    for place, body in enumerate(scene.bodies):
        if len(body.collision) >= 6 and all(isinstance(placed.shape, Box) for placed in body.collision):
            reach = np.zeros(3)
            for placed in body.collision:
                assert isinstance(placed.shape, Box)
                turned = np.abs(np.array(rotation_matrix(placed.q_BS)))
                reach = np.maximum(reach, np.abs(np.array(placed.p_BS)) + turned @ np.array(placed.shape.half_extents))
            return place, reach
    raise NotMeasurable("no container: a body of at least six boxes")


@metric("1", verdict="a centre ends outside the outer faces of the walls")
def escaped_share(run: Run) -> float:
    """definition: share of spheres whose centre ends outside the box that bounds the container's walls"""
    place, reach = _container(run.scene)
    kept = [
        i
        for i in run.movable
        if i != place
        and run.scene.bodies[i].collision
        and all(isinstance(p.shape, Sphere) for p in run.scene.bodies[i].collision)
    ]
    if not kept or len(run.actual) == 0:
        raise NotMeasurable("no sphere is contained, or no sample lies in the time that is judged")
    away = run.actual.p_WB[-1, kept] - run.actual.p_WB[-1, place]
    inside = rotate_back(np.broadcast_to(run.actual.q_WB[-1, place], (len(kept), 4)), away)
    return float(np.mean((np.abs(inside) > reach).any(axis=1)))
