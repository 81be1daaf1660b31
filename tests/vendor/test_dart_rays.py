"""What DART's two detectors that know rays say of solids, in dartpy's own words."""

import time
from typing import Any

import numpy as np
import pytest

from tests.vendor.dart_world import UP, dartpy, make_pose

pytestmark = pytest.mark.dart

RADIUS, HALF, REACH = 0.3, 0.5, 10.0
RAYS = 2000
NO_TURN = make_pose(UP, 0.0)


def _shapes() -> dict[str, Any]:
    dynamics = dartpy.dynamics
    return {
        "ball": dynamics.SphereShape(RADIUS),
        "capsule": dynamics.CapsuleShape(RADIUS, 2 * HALF),
        "cylinder": dynamics.CylinderShape(RADIUS, 2 * HALF),
    }


def _hits(detector: str, shape: Any, starts: Any, ends: Any) -> Any:
    """The first hit of each ray as a share of its length, inf for none: one loop that reads what a scanner needs."""
    frame = dartpy.dynamics.SimpleFrame(dartpy.dynamics.Frame.World(), "solid", NO_TURN)
    frame.setShape(shape)
    group = getattr(dartpy.collision, f"{detector}CollisionDetector")().createCollisionGroup()
    group.addShapeFrame(frame)
    option, shares = dartpy.collision.RaycastOption(False, True), []
    begun = time.process_time()
    for start, end in zip(starts, ends, strict=True):
        result = dartpy.collision.RaycastResult()
        if group.raycast(start, end, option, result):
            hit = result.mRayHits[0]
            shares.append((hit.mFraction, hit.mNormal, hit.mCollisionObject)[0])
        else:
            shares.append(np.inf)
    print(f"{detector}: {1e6 * (time.process_time() - begun) / len(starts):.1f} us a ray")
    return np.array(shares)


def _rays() -> tuple[Any, Any]:
    """From 3 m around, aimed at places within 0.4 m of the middle."""
    draw = np.random.default_rng(1)
    out = draw.normal(size=(RAYS, 3))
    starts = 3 * out / np.linalg.norm(out, axis=1)[:, None]
    aims = draw.uniform(-0.4, 0.4, (RAYS, 3)) - starts
    return starts, starts + REACH * aims / np.linalg.norm(aims, axis=1)[:, None]


def _outside(name: str, points: Any) -> Any:
    """How far points are from the surface of the solid about the origin [m], negative inside."""
    across, along = np.hypot(points[:, 0], points[:, 1]), np.abs(points[:, 2])
    if name == "ball":
        return np.linalg.norm(points, axis=1) - RADIUS
    if name == "capsule":
        return np.hypot(across, np.maximum(along - HALF, 0.0)) - RADIUS
    return np.maximum(across - RADIUS, along - HALF)


def _off(name: str, detector: str) -> float:
    """The greatest distance [m] of a hit from the surface."""
    starts, ends = _rays()
    shares = _hits(detector, _shapes()[name], starts, ends)
    met = np.isfinite(shares)
    assert met.sum() > RAYS / 4
    hits = starts[met] + shares[met, None] * (ends - starts)[met]
    return float(np.abs(_outside(name, hits)).max())


@pytest.mark.parametrize("name", ["ball", "capsule", "cylinder"])
def test_dart_s_own_detector_meets_solids_to_rounding(name: str) -> None:
    # A few hundred roundings over REACH, grown at grazing rays.
    assert _off(name, "DART") < 1e-12


@pytest.mark.parametrize(("name", "least"), [("ball", 1e-6), ("capsule", 1e-2), ("cylinder", 1e-4)])
def test_bullet_s_detector_does_not(name: str, least: float) -> None:
    """It closes in on a solid step by step and stops early; a capsule it has wrong."""
    assert _off(name, "Bullet") > least


@pytest.mark.parametrize("name", ["ball", "capsule", "cylinder"])
def test_a_ray_from_inside_meets_the_far_side_by_dart_s_own_detector_and_nothing_by_bullet_s(name: str) -> None:
    """From 0.1 m above the middle straight up: the exit is at RADIUS, HALF + RADIUS or HALF."""
    far = {"ball": RADIUS, "capsule": HALF + RADIUS, "cylinder": HALF}[name] - 0.1
    ray = np.array([[0.0, 0.0, 0.1]]), np.array([[0.0, 0.0, 0.1 + REACH]])
    assert _hits("DART", _shapes()[name], *ray)[0] * REACH == pytest.approx(far, abs=1e-9)
    assert np.isinf(_hits("Bullet", _shapes()[name], *ray)[0])
