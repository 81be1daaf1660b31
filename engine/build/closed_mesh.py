"""Whether the triangles of a mesh enclose a solid, and of what volume."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.maths.types import Floats


def closed_volume(vertices: Floats, faces: NDArray[Any]) -> float:
    """The volume [m3] within a mesh. Raises: ValueError where an edge lacks its neighbour, or faces look inwards."""
    edges = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    there, back = ({tuple(edge) for edge in way.tolist()} for way in (edges, edges[:, ::-1]))
    if there != back:
        raise ValueError(f"triangle mesh: edge {min(there ^ back)} has one face, expected a closed surface")
    a, b, c = (vertices[faces[:, k]] - vertices.mean(axis=0) for k in range(3))
    volume = float(np.sum(a * np.cross(b, c))) / 6
    if volume <= 0:
        raise ValueError(f"triangle mesh: volume {volume:g} m3, expected faces counter-clockwise seen from outside")
    return volume
