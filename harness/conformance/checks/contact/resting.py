"""Checks of rest: the table of every pair of shapes of which one can lie on the other, each at its height for 3 s.

Which algorithm finds the contacts of a pair is an engine's own business, and each pair may have another: so that what holds a
box on a box says nothing of a capsule on a cylinder. Each pair is a scene of its own, since an engine may choose by the scene.

An ellipsoid that rocks takes the time that its curvature at the lowest point says.
"""

from itertools import product
from math import cos, pi, sin, sqrt

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, check, near, refusable
from plumbline.harness.conformance.checks.contract.features import SIDES
from plumbline.harness.conformance.engine import COARSE, FINE, Engine
from plumbline.harness.conformance.frames import UPRIGHT, X, Y, Z
from plumbline.harness.conformance.scenes import G, ground, on_ground, shaped, static
from plumbline.harness.scene.body import PlacedShape
from plumbline.harness.scene.motion import axis_angle, multiply
from plumbline.harness.scene.scene import Scene
from plumbline.harness.scene.shape import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    Plane,
    Shape,
    Sphere,
    TriangleMesh,
    box_inertia,
    capsule_inertia,
    cylinder_inertia,
    ellipsoid_inertia,
    principal_inertia,
    sphere_inertia,
)
from plumbline.harness.scene.values import Matrix3, Quaternion, Vector3

DURATION = 3.0
HEIGHT = 0.1
"""Of the centre of every mover above the top of its support [m]."""
REACH = 0.15
"""Half length of the long movers, and of the tripod's legs [m]."""
DEPTH = 0.1
GIVES = 3e-3
"""How far a contact may give way [m]: a soft one bears a weight on its first millimetres; who sinks goes on sinking."""
PLACE = (0.13, 0.07)
"""Off the middle of the support, and turned by `YAW` [rad]: corners, axes and edges of a mesh lie nowhere under the mover."""
YAW = 0.3

_LYING: Quaternion = axis_angle(X, pi / 2)


def _corners(half: Vector3) -> tuple[Vector3, ...]:
    return tuple((x, y, z) for x in (-half[0], half[0]) for y in (-half[1], half[1]) for z in (-half[2], half[2]))


_SLAB: Vector3 = (0.5, 0.5, DEPTH)
_CUBE: Vector3 = (HEIGHT, HEIGHT, HEIGHT)
_FLAT: Vector3 = (0.2, REACH, HEIGHT)
_TRIPOD = tuple((REACH * cos(2 * pi * k / 3), REACH * sin(2 * pi * k / 3), 0.0) for k in range(3))

SUPPORTS: dict[str, tuple[Feature, Shape, float]] = {
    "plane": (Feature.PLANE, Plane(), 0.0),
    "box": (Feature.BOX, Box(half_extents=_SLAB), DEPTH),
    "cylinder": (Feature.CYLINDER, Cylinder(radius=0.5, half_length=DEPTH), DEPTH),
    "hull": (Feature.CONVEX_HULL, ConvexHull(vertices=_corners(_SLAB)), DEPTH),
    "mesh": (Feature.TRIANGLE_MESH, TriangleMesh(vertices=_corners(_SLAB), faces=SIDES), DEPTH),
}
"""What bears, by name: the feature, the shape, and how far its top lies above its middle [m]."""

MOVERS: dict[str, tuple[Feature, tuple[Shape | PlacedShape, ...], Matrix3, Quaternion]] = {
    "sphere": (Feature.SPHERE, (Sphere(radius=HEIGHT),), sphere_inertia(1.0, HEIGHT), UPRIGHT),
    "box": (Feature.BOX, (Box(half_extents=_CUBE),), box_inertia(1.0, _CUBE), UPRIGHT),
    "lying_capsule": (
        Feature.CAPSULE, (Capsule(radius=HEIGHT, half_length=REACH),), capsule_inertia(1.0, HEIGHT, REACH), _LYING
    ),
    "lying_cylinder": (
        Feature.CYLINDER, (Cylinder(radius=HEIGHT, half_length=REACH),), cylinder_inertia(1.0, HEIGHT, REACH), _LYING
    ),
    "ellipsoid": (Feature.ELLIPSOID, (Ellipsoid(semi_axes=_FLAT),), ellipsoid_inertia(1.0, _FLAT), UPRIGHT),
    "hull": (Feature.CONVEX_HULL, (ConvexHull(vertices=_corners(_CUBE)),), box_inertia(1.0, _CUBE), UPRIGHT),
    "tripod": (
        Feature.COMPOUND | Feature.SPHERE, tuple(PlacedShape(shape=Sphere(radius=HEIGHT), p_BS=foot) for foot in _TRIPOD),
        principal_inertia(0.015, 0.015, 0.025), UPRIGHT,
    ),
}  # fmt: skip
"""What lies on it, by name: the features, the shapes, the inertia of 1 kg [kg m2], and how it is turned to lie."""


def _define(support: str, mover: str) -> None:
    bears, bearing, top = SUPPORTS[support]
    lies, shapes, inertia, q_WB = MOVERS[mover]

    @check(
        f"Does a {mover.replace('_', ' ')} rest on a {support} at its height, or is the pair refused?",
        bears | lies,
        name=f"{mover}_rests_on_{support}",
    )
    def rests(engine: Engine) -> Comparisons:
        """Laid down on its support without a gap, a body of 1 kg stays at its height; or the engine refuses the pair."""
        turned = multiply(axis_angle(Z, YAW), q_WB)
        body = shaped("mover", *shapes, inertia=inertia, p_WB=(*PLACE, HEIGHT), q_WB=turned)
        scene = Scene(bodies=(static("ground", bearing, p=(0.0, 0.0, -top)), body), surfaces=(ground(0.8),))
        with refusable():
            end = engine.final(scene, DURATION, COARSE)
        away = float(np.hypot(*(end.p_WB[1, :2] - PLACE)))
        because = f"contacts give way by less than 3 mm; it moved aside by {1e3 * away:.3g} mm"
        yield near(f"height of its centre after {DURATION:g} s [m]", end.p_WB[1, 2], HEIGHT, GIVES, because)


for _support, _mover in product(SUPPORTS, MOVERS):
    _define(_support, _mover)


_AXES = (0.2, 0.15, 0.1)
"""Semi-axes [m]: along the way that it rocks, across, and up."""
_TILT = 0.05
"""Largest tilt [rad]; it changes the period by less than its square."""


def rocking_period(a: float, c: float) -> float:
    """The period [s] of small rocking without slip of a solid ellipsoid with semi-axes a along and c up [m].

    The height sqrt(a^2 sin^2 t + c^2 cos^2 t) of its centre is a spring m g (a^2 - c^2)/c, and its inertia about the ground
    m (a^2 + c^2)/5 + m c^2. Source: Goldstein, Classical Mechanics, 3rd ed., section 6.2 (small oscillations).
    """
    return 2 * pi * sqrt(c * (a**2 + 6 * c**2) / (5 * G * (a**2 - c**2)))


@check("Does an ellipsoid that rocks have the period that its curvature gives it?", Feature.ELLIPSOID)
def ellipsoid_rocks_by_its_curvature(engine: Engine) -> Comparisons:
    """Let go at a tilt, it is level four times within two periods, at a quarter and every half of one later."""
    a, _, c = _AXES
    height = sqrt((a * sin(_TILT)) ** 2 + (c * cos(_TILT)) ** 2)
    shape, inertia = Ellipsoid(semi_axes=_AXES), ellipsoid_inertia(1.0, _AXES)
    body = shaped("rocker", shape, inertia=inertia, p_WB=(0.0, 0.0, height), q_WB=axis_angle(Y, _TILT))
    period = rocking_period(a, c)
    with refusable():
        run = engine.record(on_ground(engine, body, friction=1.0), 2 * period)
    w, y = run.q_WB[:, 1, 0], run.q_WB[:, 1, 2]
    tilt = 2 * np.arctan2(y * np.sign(w), np.abs(w))
    falls = np.flatnonzero(tilt[:-1] * tilt[1:] < 0)
    level = run.time[falls] + FINE * tilt[falls] / (tilt[falls] - tilt[falls + 1])
    because = "its tilt and soft contacts change the period by less than a hundredth; facets or another curvature by tenths"
    expected = period * (0.25 + 0.5 * np.arange(4))
    yield near("times at which it is level [s]", level[:4], expected, 0.02 * period, because)
