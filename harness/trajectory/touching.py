"""How far bodies reach where a scene puts them, and which of them touch there, along which normals.

Two convex shapes touch where the greatest of their separations along the axes of the separating axis theorem is nought: the
normals of their faces, the products of their edges, and the line of their centres for what is round.
Source: Ericson, Real-Time Collision Detection (2005), section 5.2.1; Gottschalk, Separating Axis Theorem (1996).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import product as pairs_of

import numpy as np

from plumbline.harness.scene import Body, Box, Capsule, ConvexHull, Cylinder, Plane, Scene, outer_radius, width
from plumbline.harness.scene.shape import Shape, support
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import product, rotate

CLOSE = 1e-9
"""Of the thinner body's width: separations below are rounding of a scene that means to touch."""


@dataclass(frozen=True, slots=True)
class Touch:
    """Two bodies that touch.

    Terms: first, second: their places. normal: unit (3,) in W, from the first to the second. width [m]: of the thinner.
    """

    first: int
    second: int
    normal: Floats
    width: float


@dataclass(frozen=True, slots=True)
class _Solid:
    """A shape in W. Terms: centre: (3,) m. axes: of its frame, as rows (3, 3). normals, edges: unit, (k, 3)."""

    shape: Shape
    centre: Floats
    axes: Floats
    normals: Floats
    edges: Floats

    def reach(self, way: Floats) -> float:
        """How far [m] the shape reaches along a unit vector (3,)."""
        if isinstance(self.shape, Plane):
            beyond = 0.0 if way @ self.normals[0] > 1 - 1e-12 else np.inf
        else:
            beyond = float(support(self.shape, self.axes @ way))
        return float(self.centre @ way) + beyond


@lru_cache(maxsize=4096)
def _solids(body: Body) -> tuple[_Solid, ...]:
    """Where a body's shapes are at the start; asked again for each way and for each start of an ensemble."""
    return tuple(_placed(body))


def _placed(body: Body) -> Iterator[_Solid]:
    q_WB, none = np.array(body.q_WB), np.zeros((0, 3))
    for placed in body.collision:
        q_WS = product(q_WB, np.array(placed.q_BS))
        axes = rotate(q_WS, np.eye(3))
        normals = edges = none
        match placed.shape:
            case Box():
                normals = edges = axes
            case Capsule():
                edges = axes[2:]
            case Cylinder():
                normals = edges = axes[2:]
            case Plane(normal=normal):
                normals = rotate(q_WS, np.array(normal))[None]
            case ConvexHull(vertices=vertices):
                from scipy.spatial import ConvexHull as Hull  # late: a listing must not pay for it

                normals = np.unique(Hull(np.array(vertices)).equations[:, :3].round(12), axis=0) @ axes
            case _:
                pass
        yield _Solid(placed.shape, np.array(body.p_WB) + rotate(q_WB, np.array(placed.p_BS)), axes, normals, edges)


def reach(body: Body, way: Floats) -> float:
    """How far [m], from the origin of W, a body reaches along a unit vector (3,) where it stands at the start."""
    return max(solid.reach(way) for solid in _solids(body))


def _met(a: _Solid, b: _Solid, close: float) -> Iterator[Floats]:
    """Normals from a to b along which the two touch; none where they are apart or overlap by more than `close` [m]."""
    met = list[Floats]()
    for way in _ways(a, b):
        length = float(np.linalg.norm(way))
        for side in (1.0, -1.0) if length > CLOSE else ():
            unit = side * way / length
            gap = -a.reach(unit) - b.reach(-unit)
            if gap > close:
                return
            if gap >= -close:
                met.append(unit)
    # Faces and edges of bodies that stand square to each other name one way several times.
    yield from (unit for k, unit in enumerate(met) if not any(other @ unit > 1 - CLOSE for other in met[:k]))


def _ways(a: _Solid, b: _Solid) -> Iterator[Floats]:
    """The axes along which two convex solids that are apart may be parted; the first that parts them ends the search."""
    yield from a.normals
    yield from b.normals
    yield from (np.cross(edge, other) for edge, other in pairs_of(a.edges, b.edges))
    yield b.centre - a.centre


def touches(scene: Scene) -> list[Touch]:
    """All touches of bodies that can collide, at least one of which can move; meshes touch as their convex hulls do."""
    solid = [(place, body) for place, body in enumerate(scene.bodies) if body.collision]
    centres = np.array([body.p_WB for _, body in solid]).reshape(-1, 3)
    reaches = np.array(
        [max(float(np.linalg.norm(s.p_BS)) + outer_radius(s.shape) for s in body.collision) for _, body in solid]
    )
    thin = np.array([min(width(placed.shape) for placed in body.collision) for _, body in solid])
    touching = []
    for i, (first, a) in enumerate(solid):
        thinner = np.minimum(thin[i], thin[i + 1 :])
        apart = np.linalg.norm(centres[i + 1 :] - centres[i], axis=1)
        for k in np.flatnonzero(apart <= reaches[i] + reaches[i + 1 :] + CLOSE * thinner).tolist():
            second, b = solid[i + 1 + k]
            if (a.movable or b.movable) and scene.collides(a, b):
                thickness = float(thinner[k])
                for piece, other in pairs_of(_solids(a), _solids(b)):
                    met = _met(piece, other, CLOSE * thickness)
                    touching += [Touch(first, second, normal, thickness) for normal in met]
    return touching
