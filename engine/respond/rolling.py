"""Surfaces along which contact points roll, and do not turn with the body: round shapes, rims of cylinders, ellipsoids."""

import math
from typing import NamedTuple

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, Mat, Vec, load3, load4
from plumbline.engine.maths.vec import add, axpy, dot, mat_vec, norm, quat_mat, scale, sub, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.narrow.support import ellipsoid_support

UPRIGHT = 1e-3
"""Sine of a cylinder's tilt [1] below which it stands, and no point of its rim is the lowest; as in the narrow phase."""
ON_RIM = 1e-6
"""Share of its radius [1] by which a point may be off the lowest line of a cylinder."""


class Rim(NamedTuple):
    """Radius [m], centre [m], axis and lowest direction along a normal of a cylinder, in W; radius 0: no rim to roll on."""

    radius: float
    centre: Vec
    axis: Vec
    lowest: Vec


@kernel
def radius(shape: Floats, shape_kind: Ints, pose: Floats, s: int, n: Vec) -> float:
    """The radius [m] along the normal n that does not turn with a round shape; 0 for boxes and planes."""
    if shape_kind[s, at.TYPE] == at.SPHERE or shape_kind[s, at.TYPE] == at.CAPSULE:
        return float(shape[s, at.SIZE])
    if shape_kind[s, at.TYPE] == at.CYLINDER:
        along = n[0] * pose[s, 5] + n[1] * pose[s, 8] + n[2] * pose[s, 11]
        return float(shape[s, at.SIZE] * math.sqrt(max(1.0 - along * along, 0.0)))
    return 0.0


@kernel
def lowest_of(axis: Vec, n: Vec) -> Vec:
    """The unit vector from a cylinder's axis to what lies furthest along n; (0, 0, 0) where the rim is level."""
    fall = axpy(-dot(n, axis), axis, n)
    sine = norm(fall)
    return scale(1.0 / sine, fall) if sine > UPRIGHT else (0.0, 0.0, 0.0)


@kernel
def rim_of(shape: Floats, shape_kind: Ints, pose: Floats, s: int, n: Vec) -> Rim:
    """The rim of shape s that is lowest along the normal n."""
    if shape_kind[s, at.TYPE] != at.CYLINDER:
        return Rim(0.0, n, n, n)
    axis = (pose[s, 5], pose[s, 8], pose[s, 11])
    lowest = lowest_of(axis, n)
    return Rim(shape[s, at.SIZE] if dot(lowest, lowest) > 0.5 else 0.0, load3(pose, s, 0), axis, lowest)


@kernel
def rolls_on(rim: Rim, place: Vec) -> bool:
    """Whether a place on a cylinder is the lowest of its rim, or of its side."""
    way = sub(place, rim.centre)
    off = axpy(-rim.radius, rim.lowest, axpy(-dot(way, rim.axis), rim.axis, way))
    near = ON_RIM * rim.radius
    return rim.radius > 0.0 and dot(off, off) < near * near


ON_ELLIPSOID = 2.0
"""In the column of rims: at least one of the two shapes is an ellipsoid, and the manifold a single point."""


@kernel
def is_ellipsoid(shape_kind: Ints, a: int, b: int) -> bool:
    """Whether one of two shapes is an ellipsoid."""
    return bool(shape_kind[a, at.TYPE] == at.ELLIPSOID or shape_kind[b, at.TYPE] == at.ELLIPSOID)


@kernel
def farthest(shape: Floats, s: int, r_WB: Mat, n: Vec) -> Vec:
    """The point of ellipsoid s farthest along n, from its body's centre of mass, in W [m]."""
    m = quat_mat(load4(shape, s, at.TURN))
    spot = mat_vec(m, ellipsoid_support(load3(shape, s, at.SIZE), tmat_vec(m, tmat_vec(r_WB, n))))
    return mat_vec(r_WB, add(load3(shape, s, at.OFFSET), spot))
