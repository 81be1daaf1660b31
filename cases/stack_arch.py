"""A semicircular arch of voussoirs, without mortar: does it stand?

Blocks that cannot pull stand iff a line of thrust fits inside of the ring. For a semicircle of centre-line radius R under its
own weight the thinnest ring of many blocks is t = 0.1075 R thick (Milankovitch, 1907: 0.1075; Heyman, 1969: 0.106); one of few
blocks, whose joints alone can open, may be a little thinner.
Source: Milankovitch, Theorie der Druckkurven, Z. Math. Phys. 55 (1907) 1; Heyman, The safety of masonry arches, Int. J. Mech.
Sci. 11 (1969) 363; Cocchetti, Colasante, Rizzi, Appl. Mech. Rev. 64 (2011) 050802 (the three solutions compared).
"""

import math
from typing import Annotated

import numpy as np
from annotated_types import Ge

from plumbline.harness.case import Axis, Case, NotNegative, Parameters, Positive
from plumbline.harness.case.bounds import settled_speed, stands, supported
from plumbline.harness.metrics import contacts, jitter, stack
from plumbline.harness.scene import (
    Body,
    ConvexHull,
    Effect,
    PlacedShape,
    Scene,
    Surface,
    axis_angle,
    principal_inertia,
)
from plumbline.harness.scene.values import Matrix3
from plumbline.harness.trajectory import Floats
from plumbline.harness.truths.friction import resting

THICKNESS, RADIUS, DEPTH, DENSITY, FRICTION = 0.2, 1.0, 0.4, 2000.0, 0.8
SETTLED, DURATION = 1.0, 2.0


class P(Parameters):
    thickness: Positive = THICKNESS
    blocks: Annotated[float, Ge(2)] = 9
    friction: NotNegative = FRICTION


def voussoir(thickness: float, blocks: int) -> tuple[Floats, float]:
    """The cross-section of a block, corners (4, 2) m about its centroid along the chord and outwards, and that centroid's
    distance [m] from the centre of the arch.

    Args: thickness [m], in units of RADIUS = 1 m as well; blocks: of the semicircle.
    """
    half = math.pi / (2 * blocks)
    inner, outer = RADIUS - thickness / 2, RADIUS + thickness / 2
    low, high = inner * math.cos(half), outer * math.cos(half)
    a, b = inner * math.sin(half), outer * math.sin(half)
    away = low + (high - low) * (a + 2 * b) / (3 * (a + b))
    return np.array([(-a, low - away), (a, low - away), (b, high - away), (-b, high - away)]), away


def _moments(corners: Floats) -> tuple[float, float, float]:
    """Area [m2] and second moments [m4] of x and of z of a polygon about the origin (Green's theorem)."""
    x, z = corners[:, 0], corners[:, 1]
    u, w = np.roll(x, -1), np.roll(z, -1)
    turn = x * w - u * z
    return (
        float(np.sum(turn) / 2),
        float(np.sum(turn * (x * x + x * u + u * u)) / 12),
        float(np.sum(turn * (z * z + z * w + w * w)) / 12),
    )


def _inertia(corners: Floats) -> tuple[float, Matrix3]:
    """Mass [kg] and inertia [kg m2] of the prism of depth DEPTH along y."""
    area, xx, zz = _moments(corners)
    mass = DENSITY * DEPTH * area
    along = mass * DEPTH**2 / 12
    x, z = DENSITY * DEPTH * xx, DENSITY * DEPTH * zz
    return mass, principal_inertia(z + along, x + z, x + along)


def scene(p: P) -> Scene:
    """A semicircle of equal blocks on level ground, in the plane y = 0, exactly touching; `thickness` in units of RADIUS."""
    count = round(p.blocks)
    corners, away = voussoir(p.thickness * RADIUS, count)
    mass, inertia = _inertia(corners)
    hull = ConvexHull(vertices=tuple((float(x), y, float(z)) for x, z in corners for y in (-DEPTH / 2, DEPTH / 2)))
    bodies = [Body.ground("default")]
    for i in range(count):
        # From the springing at -x over the crown to that at +x; a turn about y by t takes z to (sin t, 0, cos t).
        turn = math.pi * ((i + 0.5) / count - 0.5)
        bodies.append(
            Body(
                name=f"voussoir_{i}",
                mass=mass,
                inertia=inertia,
                collision=(PlacedShape(shape=hull),),
                p_WB=(away * math.sin(turn), 0.0, away * math.cos(turn)),
                q_WB=axis_angle((0.0, 1.0, 0.0), turn),
            )
        )
    return Scene(bodies=tuple(bodies), surfaces=(Surface.rough(p.friction),), narrow=Effect.GYROSCOPIC)


expected = resting(scene)
"""Rest, as it is above the least thickness."""

CASE = Case.of(
    globals(),
    title="An arch of voussoirs",
    question="Does a semicircular arch of loose blocks stand, whose ring is twice as thick as the least that statics allows?",
    source="Milankovitch, Z. Math. Phys. 55 (1907) 1; Heyman, Int. J. Mech. Sci. 11 (1969) 363",
    truth="rest",
    with_contacts=True,
    steady=SETTLED,
    hard=Axis(parameter="thickness", unit="1", easy=0.3, extreme=0.1),
    checks=(stands(DURATION, "the arch stands"), settled_speed(SETTLED, "a block"), supported(SETTLED, DURATION)),
    observe=(stack.stack_height_error, contacts.penetration, jitter.rest_drift),
    headline="stack_height_error",
)
