"""Meshes that are their own hulls, for engines that collide a mesh as its hull."""

import numpy as np

from plumbline.harness.trajectory import Floats, Integers


def is_convex(vertices: Floats, faces: Integers) -> bool:
    """Is a mesh closed, with no vertex above any face by more than rounding of single precision?

    Args: vertices (n, 3) m. faces (m, 3): places of corners, counter-clockwise from outside.
    """
    edges = {(int(f[i]), int(f[(i + 1) % 3])) for f in faces for i in range(3)}
    if any((b, a) not in edges for a, b in edges):
        return False
    size = float(np.ptp(vertices, axis=0).max())
    for face in faces:
        a, b, c = vertices[face]
        normal = np.cross(b - a, c - a)
        if float(((vertices - a) @ normal).max()) > 1e-6 * size * float(np.linalg.norm(normal)):
            return False
    return True
