"""Overlap: how deep balls stand in one another and in the planes that hold them, from poses alone.

An engine's own report of contacts may be cut short or hold margins; positions cannot.
"""

from collections.abc import Iterator

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Plane, Scene, Sphere
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import rotate


def _balls(scene: Scene) -> tuple[list[int], Floats]:
    """Places and radii [m] of the movable bodies, each a single ball about its centre of mass."""
    places = [place for place, body in enumerate(scene.bodies) if body.movable]
    radii: list[float] = []
    for place in places:
        shapes = scene.bodies[place].collision
        if len(shapes) != 1 or not isinstance(shapes[0].shape, Sphere) or any(shapes[0].p_BS):
            raise NotMeasurable(f"body '{scene.bodies[place].name}' is no single ball about its centre of mass")
        radii.append(shapes[0].shape.radius)
    if not places:
        raise NotMeasurable("no body can move")
    return places, np.array(radii)


def _planes(scene: Scene) -> Iterator[tuple[Floats, Floats]]:
    """A point [m] and the outward normal of each plane that stands still."""
    for body in scene.bodies:
        for placed in () if body.movable else body.collision:
            if body.motion != "static" or not isinstance(placed.shape, Plane):
                raise NotMeasurable(f"body '{body.name}' is no plane that stands still")
            q_WB = np.array(body.q_WB)
            normal = rotate(q_WB, rotate(np.array(placed.q_BS), np.array(placed.shape.normal)))
            yield np.array(body.p_WB) + rotate(q_WB, np.array(placed.p_BS)), normal


@metric("m")
def overlap(run: Run) -> float:
    """impenetrability: greatest r_i + r_j - |p_i - p_j| of two balls, and r - n . (p - p_plane) of a ball and a plane"""
    from scipy.spatial import cKDTree  # late: a listing must not pay for it

    places, radii = _balls(run.scene)
    planes = list(_planes(run.scene))
    if len(run.actual) == 0:
        raise NotMeasurable("no samples")
    deepest, reach = 0.0, 2.0 * float(radii.max())
    for centres in run.actual.p_WB[:, places]:
        pairs = cKDTree(centres).query_pairs(reach, output_type="ndarray")
        if len(pairs):
            apart = np.linalg.norm(centres[pairs[:, 0]] - centres[pairs[:, 1]], axis=1)
            deepest = max(deepest, float(np.max(radii[pairs[:, 0]] + radii[pairs[:, 1]] - apart)))
        for point, normal in planes:
            deepest = max(deepest, float(np.max(radii - (centres - point) @ normal)))
    return deepest
