"""Checks of contacts pair by pair of shapes: the normal from A to B, and the gap that the bodies' places say."""

from itertools import combinations_with_replacement

import numpy as np

from harness.adapter import Adapter, Feature, Settings, Unsupported
from harness.conformance.check import Comparison, Finding, NotApplicable, check, judge, near, that
from harness.conformance.runs import FINE, built, state_of
from harness.conformance.scenes import block, ground, static
from harness.scene import Body, Box, Capsule, Cylinder, Ellipsoid, PlacedShape, Plane, Scene, Shape, Sphere, Vector3

_SHAPES: tuple[tuple[Feature, Shape, float], ...] = (
    (Feature.PLANE, Plane(), 0.0),
    (Feature.BOX, Box(half_extents=(0.2, 0.2, 0.2)), 0.2),
    (Feature.SPHERE, Sphere(radius=0.2), 0.2),
    (Feature.CAPSULE, Capsule(radius=0.1, half_length=0.1), 0.2),
    (Feature.CYLINDER, Cylinder(radius=0.2, half_length=0.2), 0.2),
    (Feature.ELLIPSOID, Ellipsoid(semi_axes=(0.15, 0.18, 0.2)), 0.2),
)
"""Shapes that can stand upright on each other, each with the height of its centre [m]."""
_DEEP = 0.004
"""By how much they overlap [m]: more than any engine's slop, less than a fiftieth of their size."""


def _upright(name: str, shape: Shape, p_WB: Vector3, material: str) -> Body:
    """A body of 1 kg of that shape, its axis upwards."""
    return Body(name=name, inertia=block().inertia, collision=(PlacedShape(shape=shape),), material=material, p_WB=p_WB)


@check(
    "Do the contacts of every pair of shapes have their normal from A to B and the gap that the places say?",
    Feature.CONTACTS,
    firm=True,
)
def contacts_of_every_pair_of_shapes(adapter: Adapter, settings: Settings) -> Finding:
    """Each shape stands in the middle of each other one, sunk in by 4 mm, without gravity; in the scene above and below.

    One step lies between the places before and after; the gap is one of theirs or between, whenever it was read.
    """
    claimed = [(shape, height) for feature, shape, height in _SHAPES if feature in adapter.features]
    comparisons: list[Comparison] = []
    for (below, low), (above, high) in combinations_with_replacement(claimed, 2):
        if isinstance(above, Plane):
            continue
        for first in (True, False):
            pair = f"{above.type} on {below.type}, {'lower' if first else 'upper'} one first"
            base = static("base", below) if isinstance(below, Plane) else _upright("base", below, (0.0, 0.0, 0.0), "ground")
            # Round on round touches at one point above the other's centre; a face does not mind where.
            aside = (0.0, 0.0) if {below.type, above.type} <= {"sphere", "capsule", "ellipsoid"} else (0.01, 0.02)
            top = _upright("top", above, (*aside, low + high - _DEEP), "block")
            scene = Scene(bodies=(base, top) if first else (top, base), surfaces=(ground(),), gravity=(0.0, 0.0, 0.0))
            try:
                with built(adapter, scene, settings.with_dt(FINE)) as simulation:
                    simulation.step()
                    got, after = simulation.contacts(), state_of(simulation, scene)
            except Unsupported:
                continue
            place_base, place_top = (0, 1) if first else (1, 0)
            opened = float(after.p_WB[place_top, 2] - after.p_WB[place_base, 2]) - (low + high)
            lower, upper = min(-_DEEP, opened), max(-_DEEP, opened)
            up = 1.0 if first else -1.0
            comparisons.append(that(len(got) > 0, f"{pair}: got no contact, expected at least one"))
            comparisons.append(near(f"{pair}: upward part of the normals", got.normal_W[:, 2], np.full(len(got), up), 0.05))
            if len(got):
                deepest = float(got.gap.min())
                margin = 0.1 * _DEEP
                comparisons.append(
                    that(
                        lower - margin <= deepest <= upper + margin,
                        f"{pair}: gap of the deepest point: got {deepest:.5g} m, expected {lower:.5g}..{upper:.5g} m, "
                        "a tenth of the depth granted",
                    )
                )
    if not comparisons:
        raise NotApplicable("the engine supports no pair of shapes that could touch")
    return judge(*comparisons)
