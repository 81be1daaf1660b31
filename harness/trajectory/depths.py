"""How deep the bodies of a scene stand in one another along a trajectory, pair by pair, from their poses and shapes."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from harness.scene import PlacedShape, Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.convex_depth import Solid, Unmeasured, depth, reach, solid
from harness.trajectory.kinematics import product, rotate

__all__ = ["pair_depths"]


def _shapes(scene: Scene) -> list[tuple[int, PlacedShape]]:
    return [(place, placed) for place, body in enumerate(scene.bodies) for placed in body.collision]


def _poses(run: Trajectory, place: int, placed: PlacedShape) -> tuple[Floats, Floats]:
    """Position (t, 3) m and attitude (t, 4) of a shape in W."""
    q_WB = run.q_WB[:, place]
    return run.p_WB[:, place] + rotate(q_WB, np.array(placed.p_BS)), product(q_WB, np.array(placed.q_BS))


def pair_depths(scene: Scene, run: Trajectory) -> Iterator[tuple[int, int, Floats | None]]:
    """Of each two shapes that come near: their bodies' places, and how deep the shapes stand in one another, (t,) m.

    -inf where they are far apart; None of a pair of shapes whose depth is not known exactly.
    """
    shapes = _shapes(scene)
    if not shapes or len(run) == 0:
        return
    p, q = (np.stack(parts, axis=1) for parts in zip(*(_poses(run, place, placed) for place, placed in shapes), strict=True))
    solids = [_solid(placed) for _, placed in shapes]
    reaches = np.array([math.inf if hull is None else reach(hull) for hull in solids])
    for a, (place_a, _) in enumerate(shapes):
        near = np.sum((p[:, :a] - p[:, a : a + 1]) ** 2, axis=2) <= (reaches[:a] + reaches[a]) ** 2
        for b in np.flatnonzero(near.any(axis=0)).tolist():
            place_b, at = shapes[b][0], near[:, b]
            if scene.collides(scene.bodies[place_a], scene.bodies[place_b]):
                yield place_a, place_b, _deep(solids[a], solids[b], p[:, [a, b]], q[:, [a, b]], at)


def _solid(placed: PlacedShape) -> Solid | None:
    try:
        return solid(placed.shape)
    except Unmeasured:
        return None


def _deep(a: Solid | None, b: Solid | None, p: Floats, q: Floats, at: NDArray[np.bool_]) -> Floats | None:
    """The depth of two solids at those samples, -inf elsewhere; None where it is not known exactly."""
    if a is None or b is None:
        return None
    deep = np.full(len(p), -np.inf)
    try:
        deep[at] = depth(a, p[at, 0], q[at, 0], b, p[at, 1], q[at, 1])
    except Unmeasured:
        return None
    return deep
