"""What DART's collision detectors and its rays make of an ellipsoid, in dartpy's own words."""

from typing import Any

import numpy as np
import pytest

from tests.vendor.dart_world import UP, dartpy, make_ground, make_mover, make_pose, make_world

pytestmark = pytest.mark.dart

AXES = np.array([0.1, 0.2, 0.3])
DEEP = 1e-3
"""Overlap [m] with what lies below."""


def _below(name: str) -> tuple[Any, Any]:
    dynamics = dartpy.dynamics
    shape, z = {
        "plane": (lambda: dynamics.PlaneShape(np.array([0.0, 0.0, 1.0]), 0.0), 0.0),
        "box": (lambda: dynamics.BoxShape(np.array([10.0, 10.0, 2.0])), -1.0),
        "cylinder": (lambda: dynamics.CylinderShape(2.0, 2.0), -1.0),
        "sphere": (lambda: dynamics.SphereShape(1.0), -1.0),
    }[name]
    return shape(), make_pose(UP, z)


def _worst(detector: str, below: str) -> tuple[int, float, float]:
    """Of twenty attitudes, the lowest point 1 mm deep at the origin: missed; errors of the depth [m] and the normal [rad]."""
    draw = np.random.default_rng(1)
    missed, depth, lean = 0, 0.0, 0.0
    for _ in range(20):
        turn = tuple(draw.normal(size=3))
        world = make_world(detector, 1e-6)
        make_ground(world, *_below(below))
        pose = make_pose(turn, 0.0)
        down = -pose.rotation()[2]
        reach = float(np.linalg.norm(AXES * down))
        lowest = pose.rotation() @ (AXES * AXES * down) / reach
        pose.set_translation(np.array([-lowest[0], -lowest[1], reach - DEEP]))
        make_mover(world, dartpy.dynamics.EllipsoidShape(2 * AXES), pose)
        world.step()
        contacts = world.getLastCollisionResult().getContacts()
        if not contacts:
            missed += 1
            continue
        deepest = max(contacts, key=lambda contact: contact.penetrationDepth)
        depth = max(depth, abs(deepest.penetrationDepth - DEEP))
        lean = max(lean, float(np.arccos(min(1.0, abs(deepest.normal[2])))))
    return missed, depth, lean


@pytest.mark.parametrize(("below", "lean"), [("plane", 1e-3), ("box", 0.05), ("cylinder", 1e-3)])
def test_fcl_finds_the_depth_of_an_ellipsoid_on_what_is_flat(below: str, lean: float) -> None:
    """To a micrometre; on a box its normal leans by up to .022 rad, else by rounding."""
    missed, depth, leans = _worst("fcl", below)
    assert missed == 0
    assert depth < 1e-6
    assert leans < lean


def test_fcl_leans_on_a_ball() -> None:
    """By more than .05 rad, at a depth of a millimetre."""
    missed, _, leans = _worst("fcl", "sphere")
    assert missed == 0
    assert leans > 0.05


def test_darts_own_detector_misses_an_ellipsoid() -> None:
    """At more than half of the attitudes: facets of a polyhedron in its place lie more than a millimetre inside."""
    assert _worst("dart", "plane")[0] > 10


def test_bullet_in_dart_makes_a_polyhedron_of_it() -> None:
    """Depths are off by up to a centimetre."""
    _, depth, _ = _worst("bullet", "plane")
    assert depth > 5e-3


def test_ode_in_dart_makes_a_ball_of_a_centimetre_of_it() -> None:
    """Laid on the end of its axis of 30 cm, it falls through 29 cm of itself as if nothing were below."""
    world = make_world("ode", 1e-3)
    make_ground(world, *_below("box"))
    node = make_mover(world, dartpy.dynamics.EllipsoidShape(2 * AXES), make_pose(UP, 0.3))
    for _ in range(150):
        world.step()
    assert float(node.getTransform().translation()[2]) - 0.3 < -0.1


def test_rays_of_darts_own_detector_meet_a_polyhedron_in_its_place() -> None:
    """Towards its centre they end right along the axes, and a millimetre and more too deep in between."""
    world = make_world("fcl", 1e-3)
    node = make_mover(world, dartpy.dynamics.EllipsoidShape(2 * AXES), make_pose(UP, 0.0))
    group = dartpy.collision.DARTCollisionDetector().createCollisionGroup()
    group.addShapeFrame(node.getShapeNode(0))
    option = dartpy.collision.RaycastOption(False, True)
    draw = np.random.default_rng(0)
    ways = np.concatenate([np.eye(3), draw.normal(size=(6, 3))])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    inside = []
    for way in ways:
        result = dartpy.collision.RaycastResult()
        assert group.raycast(2 * way, np.zeros(3), option, result)
        inside.append(1 / np.linalg.norm(way / AXES) - 2.0 * (1.0 - result.mRayHits[0].mFraction))
    assert inside[:3] == pytest.approx([0.0] * 3, abs=1e-9)
    assert min(inside[3:]) > 1e-3
