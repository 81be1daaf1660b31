"""The closed forms of rays against one shape, over many rays at once.

Each loop reads the rays from six arrays, one for each coordinate, writes a single array and has no branch, so that the compiler
turns it into vector instructions. An invalid root is NaN, which loses every comparison. A ray that starts inside hits its exit.

Source: Ericson, Real-Time Collision Detection, sections 5.3.1 (plane), 5.3.2 (sphere, and ellipsoid by scaling), 5.3.3 (box),
5.3.7 (cylinder); Wald, Slusallek, Benthin, Wagner, Interactive Rendering with Coherent Ray Tracing, 2001
(one instruction for several rays).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from plumbline.engine.compile.jit import kernel, stream
from plumbline.engine.maths.rows import Floats, Ints, Mat, Vec
from plumbline.engine.maths.vec import axpy, dot, mat_vec, norm, scale, tmat_vec
from plumbline.engine.memory import arena as at

MISS = math.inf
PARALLEL = 1e-30
"""Squared sine of the angle to the axis [1] below which a ray runs along it."""

Rays = tuple[Floats, Floats, Floats, Floats, Floats, Floats]
"""Origins x, y, z [m] and unit directions x, y, z of rays, in W."""
Triple = tuple[Floats, Floats, Floats]
"""Vectors in W: x, y, z."""
Form = Callable[[Vec, Vec, Vec], float]
"""How far [lengths of d] a ray goes to a shape, inf for a miss: from o [m] along d, of sizes [m], in the frame of the shape."""


class Primitive(NamedTuple):
    """One shape with a closed form.

    Terms: number: among all with closed forms; owner, part: whose it is, and which of that body's shapes; centre [m], axes: its
    pose in W; size, ball [m]: its sizes and the radius of its bounding ball.
    """

    number: int
    kind: int
    owner: int
    part: int
    centre: Vec
    axes: Mat
    size: Vec
    ball: float


@kernel
def root_of(x: float) -> float:
    """The square root, NaN below zero."""
    return math.sqrt(x) if x >= 0.0 else math.nan


@kernel
def ray_in(rays: Rays, i: int, c: Vec, m: Mat) -> tuple[Vec, Vec]:
    """Origin and direction of ray i in the frame with origin c and axes m."""
    ox, oy, oz, dx, dy, dz = rays
    return tmat_vec(m, (ox[i] - c[0], oy[i] - c[1], oz[i] - c[2])), tmat_vec(m, (dx[i], dy[i], dz[i]))


@stream
def near_ball(n: int, rays: Rays, c: Vec, radius: float, best: Floats, near: Ints) -> None:
    """near[i] = 1 where ray i may meet the ball of `radius` about c before best[i]."""
    ox, oy, oz, dx, dy, dz = rays
    square = radius * radius * (1.0 + 1e-9)
    for i in range(n):
        x, y, z = ox[i] - c[0], oy[i] - c[1], oz[i] - c[2]
        along = x * dx[i] + y * dy[i] + z * dz[i]
        away2 = x * x + y * y + z * z
        # The last term covers the rounding of the difference.
        meets = away2 - along * along <= square + 1e-12 * away2
        near[i] = meets & (along <= radius) & (-along - radius <= best[i])


@stream
def meet_sphere(n: int, rays: Rays, c: Vec, radius: float, t: Floats) -> None:
    """|o + t d - c| = radius, with the discriminant taken from the ray's distance to the centre, which does not cancel."""
    ox, oy, oz, dx, dy, dz = rays
    for i in range(n):
        x, y, z = ox[i] - c[0], oy[i] - c[1], oz[i] - c[2]
        b = x * dx[i] + y * dy[i] + z * dz[i]
        x, y, z = x - b * dx[i], y - b * dy[i], z - b * dz[i]
        root = root_of(radius * radius - (x * x + y * y + z * z))
        first, last = -b - root, -b + root
        found = first if first >= 0.0 else last
        t[i] = found if found >= 0.0 else MISS


@stream
def meet_plane(n: int, rays: Rays, c: Vec, normal: Vec, t: Floats) -> None:
    """The plane through c, from either side."""
    ox, oy, oz, dx, dy, dz = rays
    for i in range(n):
        height = normal[0] * (ox[i] - c[0]) + normal[1] * (oy[i] - c[1]) + normal[2] * (oz[i] - c[2])
        slope = normal[0] * dx[i] + normal[1] * dy[i] + normal[2] * dz[i]
        found = -height / (slope if slope != 0.0 else math.nan)
        t[i] = found if found >= 0.0 else MISS


@kernel
def slab(o: float, d: float, half: float) -> tuple[float, float]:
    """Entry and exit of |o + t d| <= half; all of t or none of it where d = 0."""
    inverse = 1.0 / (d if d != 0.0 else math.nan)
    one, two = (-half - o) * inverse, (half - o) * inverse
    near, far = (one, two) if d > 0.0 else (two, one)
    flat = MISS if abs(o) > half else -MISS
    return (flat if d == 0.0 else near), (-flat if d == 0.0 else far)


@kernel
def through(enter: float, leave: float) -> float:
    """The entry, or the exit from inside, or a miss."""
    found = enter if enter >= 0.0 else leave
    return found if (enter <= leave) & (leave >= 0.0) else MISS


@kernel
def to_box(o: Vec, d: Vec, size: Vec) -> float:
    """Slabs: the last entry, or the first exit from inside."""
    near, far = slab(o[0], d[0], size[0])
    enter, leave = slab(o[1], d[1], size[1])
    near, far = (near if near > enter else enter), (far if far < leave else leave)
    enter, leave = slab(o[2], d[2], size[2])
    return through(near if near > enter else enter, far if far < leave else leave)


@kernel
def tube(o: Vec, d: Vec, radius: float) -> tuple[float, float]:
    """Entry and exit of the endless cylinder about z; NaN for a miss and for a ray along z."""
    a = d[0] * d[0] + d[1] * d[1]
    inverse = 1.0 / (a if a >= PARALLEL else math.nan)
    b = (o[0] * d[0] + o[1] * d[1]) * inverse
    x, y = o[0] - b * d[0], o[1] - b * d[1]
    root = root_of((radius * radius - x * x - y * y) * inverse)
    return -b - root, -b + root


@kernel
def to_cylinder(o: Vec, d: Vec, size: Vec) -> float:
    """The tube cut by the two caps."""
    radius, half = size[0], size[1]
    near, far = tube(o, d, radius)
    within = (d[0] * d[0] + d[1] * d[1] < PARALLEL) & (o[0] * o[0] + o[1] * o[1] <= radius * radius)
    near, far = (-MISS if within else near), (MISS if within else far)
    enter, leave = slab(o[2], d[2], half)
    # A miss of the tube stays NaN and fails in `through`.
    return through(enter if enter > near else near, leave if leave < far else far)


@kernel
def end_sphere(o: Vec, d: Vec, inverse: float, end: float, square: float, sign: float) -> float:
    """Entry (sign 1) of the sphere about (0, 0, end), or its exit (-1) with its sign changed."""
    z = o[2] - end
    b = (o[0] * d[0] + o[1] * d[1] + z * d[2]) * inverse
    x, y, z = o[0] - b * d[0], o[1] - b * d[1], z - b * d[2]
    found = -b - sign * root_of((square - (x * x + y * y + z * z)) * inverse)
    return sign * found if found >= 0.0 else MISS


@kernel
def to_capsule(o: Vec, d: Vec, size: Vec) -> float:
    """The union of the tube between the caps and the two end spheres: first entry, or last exit from inside."""
    radius, half = size[0], size[1]
    square, inverse = radius * radius, 1.0 / dot(d, d)
    beyond = abs(o[2]) - half
    beyond = beyond if beyond > 0.0 else 0.0
    inside = o[0] * o[0] + o[1] * o[1] + beyond * beyond < square
    sign = -1.0 if inside else 1.0
    enter, leave = tube(o, d, radius)
    found = leave if inside else enter
    best = sign * found if (found >= 0.0) & (abs(o[2] + found * d[2]) <= half) else MISS
    low = end_sphere(o, d, inverse, -half, square, sign)
    best = low if low < best else best
    high = end_sphere(o, d, inverse, half, square, sign)
    best = high if high < best else best
    return sign * best if best < MISS else MISS


@kernel
def to_ellipsoid(o: Vec, d: Vec, size: Vec) -> float:
    """The unit sphere, met in coordinates that are divided by the semi-axes."""
    a, b, c = 1.0 / size[0], 1.0 / size[1], 1.0 / size[2]
    x, y, z, u, v, w = a * o[0], b * o[1], c * o[2], a * d[0], b * d[1], c * d[2]
    inverse = 1.0 / (u * u + v * v + w * w)
    middle = (x * u + y * v + z * w) * inverse
    x, y, z = x - middle * u, y - middle * v, z - middle * w
    root = root_of((1.0 - (x * x + y * y + z * z)) * inverse)
    first, last = -middle - root, -middle + root
    found = first if first >= 0.0 else last
    return found if found >= 0.0 else MISS


def _over_rays(form: Form) -> Callable[[int, Rays, Primitive, Floats], None]:
    """The stream that writes t (n,) m of a closed form."""

    def meet_form(n: int, rays: Rays, shape: Primitive, t: Floats) -> None:
        for i in range(n):
            o, d = ray_in(rays, i, shape.centre, shape.axes)
            t[i] = form(o, d, shape.size)

    return stream(meet_form)


meet_box, meet_cylinder, meet_capsule, meet_ellipsoid = map(_over_rays, (to_box, to_cylinder, to_capsule, to_ellipsoid))


@kernel
def meet(n: int, rays: Rays, shape: Primitive, t: Floats) -> None:
    """Write how far [m] the first n rays go to a shape, infinity for a miss."""
    if shape.kind == at.PLANE:
        meet_plane(n, rays, shape.centre, (shape.axes[2], shape.axes[5], shape.axes[8]), t)
    elif shape.kind == at.SPHERE:
        meet_sphere(n, rays, shape.centre, shape.size[0], t)
    elif shape.kind == at.BOX:
        meet_box(n, rays, shape, t)
    elif shape.kind == at.CAPSULE:
        meet_capsule(n, rays, shape, t)
    elif shape.kind == at.ELLIPSOID:
        meet_ellipsoid(n, rays, shape, t)
    else:
        meet_cylinder(n, rays, shape, t)


@kernel
def normal_at(kind: int, size: Vec, x: Vec) -> Vec:
    """The outward unit normal of a shape at x [m] on it, both in its own frame: where its distance grows fastest."""
    if kind == at.PLANE:
        return 0.0, 0.0, 1.0
    if kind == at.BOX:
        u, v, w = abs(x[0]) - size[0], abs(x[1]) - size[1], abs(x[2]) - size[2]
        first = (u >= v) & (u >= w)
        second = (v >= w) & (not first)
        third = not (first | second)
        signs = (math.copysign(1.0, x[0]), math.copysign(1.0, x[1]), math.copysign(1.0, x[2]))
        return signs[0] if first else 0.0, signs[1] if second else 0.0, signs[2] if third else 0.0
    if kind == at.CYLINDER:
        away = math.sqrt(x[0] * x[0] + x[1] * x[1])
        cap = abs(x[2]) - size[1] > away - size[0]
        share = 0.0 if cap else 1.0 / away
        return share * x[0], share * x[1], math.copysign(1.0, x[2]) if cap else 0.0
    if kind == at.ELLIPSOID:
        x = (x[0] / (size[0] * size[0]), x[1] / (size[1] * size[1]), x[2] / (size[2] * size[2]))
    elif kind == at.CAPSULE:
        beyond = abs(x[2]) - size[1]
        x = (x[0], x[1], math.copysign(beyond if beyond > 0.0 else 0.0, x[2]))
    return scale(1.0 / norm(x), x)


@stream
def normals_of(n: int, rays: Rays, t: Floats, shape: Primitive, normal: Triple) -> None:
    """Outward unit normals in W where rays end on a shape."""
    nx, ny, nz = normal
    kind, size = shape.kind, shape.size
    for i in range(n):
        o, d = ray_in(rays, i, shape.centre, shape.axes)
        nx[i], ny[i], nz[i] = mat_vec(shape.axes, normal_at(kind, size, axpy(t[i], d, o)))
