"""The farthest point of a shape's core along a direction.

The core of a ball is its centre, that of a capsule its axis; around it lies the radius. Other shapes are their own core.

Source: van den Bergen, Collision Detection in Interactive 3D Environments, 2003, section 4.3.4.
"""

import math
from typing import Annotated, NamedTuple

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, load9
from plumbline.engine.maths.vec import dot, mat_vec, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import carved


class Solids(NamedTuple):
    """The tables that describe shapes: sizes, poses in W, corners and faces of polyhedra."""

    shape: Annotated[Floats, at.SHAPE]
    pose: Annotated[Floats, at.POSE]
    vertex: Annotated[Floats, at.VERTEX]
    face: Annotated[Floats, at.FACE]
    shape_kind: Annotated[Ints, at.SHAPE_KIND]
    polyhedron: Annotated[Ints, at.POLYHEDRON]
    span: Annotated[Ints, at.SPAN]
    loop: Annotated[Ints, at.LOOP]


solids_of = carved(Solids)


@kernel
def core_radius(t: Solids, s: int) -> float:
    """How far [m] the surface lies around the core."""
    if t.shape_kind[s, at.TYPE] == at.SPHERE or t.shape_kind[s, at.TYPE] == at.CAPSULE:
        return float(t.shape[s, at.SIZE])
    return 0.0


@kernel
def ellipsoid_support(semi_axes: Vec, u: Vec) -> Vec:
    """The point of an ellipsoid farthest along u, in its own frame: D^2 u / |D u| with the semi-axes D [m]."""
    x, y, z = semi_axes[0] * u[0], semi_axes[1] * u[1], semi_axes[2] * u[2]
    reach = math.sqrt(x * x + y * y + z * z)
    share = 1.0 / reach if reach > 1e-300 else 0.0
    return share * semi_axes[0] * x, share * semi_axes[1] * y, share * semi_axes[2] * z


@kernel
def core_support(t: Solids, s: int, n: Vec) -> Vec:
    """The point of the core farthest along n, from the shape's centre, along the axes of W."""
    kind = t.shape_kind[s, at.TYPE]
    if kind == at.SPHERE:
        return 0.0, 0.0, 0.0
    m = load9(t.pose, s, 3)
    u = tmat_vec(m, n)
    if kind == at.CAPSULE:
        x, y, z = 0.0, 0.0, math.copysign(t.shape[s, at.SIZE + 1], u[2])
    elif kind == at.BOX:
        x, y, z = math.copysign(t.shape[s, at.SIZE], u[0]), math.copysign(t.shape[s, at.SIZE + 1], u[1]), 0.0
        z = math.copysign(t.shape[s, at.SIZE + 2], u[2])
    elif kind == at.CYLINDER:
        across = math.sqrt(u[0] * u[0] + u[1] * u[1])
        share = t.shape[s, at.SIZE] / across if across > 1e-300 else 0.0
        x, y, z = share * u[0], share * u[1], math.copysign(t.shape[s, at.SIZE + 1], u[2])
    elif kind == at.ELLIPSOID:
        x, y, z = ellipsoid_support(load3(t.shape, s, at.SIZE), u)
    else:
        first = t.polyhedron[s, at.FIRST_VERTEX]
        best, most = first, -math.inf
        for k in range(first, first + t.polyhedron[s, at.VERTICES]):
            reach = dot(u, load3(t.vertex, k, 0))
            if reach > most:
                best, most = k, reach
        x, y, z = load3(t.vertex, best, 0)
    return mat_vec(m, (x, y, z))


@kernel
def separation_along(t: Solids, a: int, b: int, d: Vec, n: Vec) -> float:
    """The gap [m] between the cores of a and b along the unit vector n, d being the way from centre a to centre b."""
    minus = (-n[0], -n[1], -n[2])
    return dot(n, d) + dot(n, core_support(t, b, minus)) - dot(n, core_support(t, a, n))
