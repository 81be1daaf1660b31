"""Closed-form rays against sphere tracing of signed distances, an independent route to the same hits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    PlacedShape,
    Plane,
    Scene,
    Shape,
    Sphere,
    TriangleMesh,
    axis_angle,
)
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.trajectory import Floats, State


def _distance(shape: Shape, p: Floats) -> Floats:
    """Signed distance of points (r, 3) in the frame of the shape, by folding space."""
    match shape:
        case Sphere():
            return np.linalg.norm(p, axis=1) - shape.radius
        case Plane():
            return p @ np.array(shape.normal)
        case Box():
            q = np.abs(p) - np.array(shape.half_extents)
            return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)
        case Ellipsoid():
            # No farther than the surface is, which the marching needs: the gradient of |p / D| is 1 / min D at most.
            return (np.linalg.norm(p / np.array(shape.semi_axes), axis=1) - 1) * min(shape.semi_axes)
        case Capsule():
            rest = p - np.clip(p[:, 2], -shape.half_length, shape.half_length)[:, None] * np.array([0, 0, 1.0])
            return np.linalg.norm(rest, axis=1) - shape.radius
        case Cylinder():
            q = np.stack([np.hypot(p[:, 0], p[:, 1]) - shape.radius, np.abs(p[:, 2]) - shape.half_length], axis=1)
            return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)
    raise AssertionError(shape)


def _traced(shape: Shape, origins: Floats, directions: Floats, max_range: float) -> tuple[Floats, Floats]:
    """Distance to the surface, and the smallest signed distance met on the way, by marching as far as is free.

    That of a ray which grazes for so long that it has not arrived is not a number.
    """
    travelled, closest = np.zeros(len(origins)), np.full(len(origins), np.inf)
    going = np.arange(len(origins))
    for _ in range(600):
        before = travelled[going]
        free = _distance(shape, origins[going] + before[:, None] * directions[going])
        closest[going] = np.minimum(closest[going], free)
        travelled[going] = np.minimum(before + np.maximum(free, 0.0), max_range)
        going = going[travelled[going] != before]
    closest[going] = np.nan
    return travelled, closest


SHAPES: list[Shape] = [
    Sphere(radius=0.7),
    Box(half_extents=(0.5, 0.8, 0.3)),
    Capsule(radius=0.3, half_length=0.6),
    Cylinder(radius=0.5, half_length=0.4),
    Ellipsoid(semi_axes=(0.5, 0.8, 0.3)),
    Plane(normal=(0.1, -0.2, 1.0)),
]


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s.type)
@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_rays_hit_where_the_signed_distance_vanishes(shape: Shape, seed: int) -> None:
    rng = np.random.default_rng(seed)
    q_WB, p_WB = axis_angle(tuple(rng.normal(size=3)), rng.uniform(0, 3)), tuple(rng.normal(size=3))
    scene = Scene(bodies=(Body(name="s", motion="static", collision=(PlacedShape(shape=shape),), p_WB=p_WB, q_WB=q_WB),))
    origin_S = rng.normal(size=(60, 3))
    origin_S *= 3.0 / np.linalg.norm(origin_S, axis=1, keepdims=True)
    origin_S = origin_S[_distance(shape, origin_S) > 0.1]
    aim_S = rng.uniform(-0.9, 0.9, size=origin_S.shape) - origin_S
    aim_S /= np.linalg.norm(aim_S, axis=1, keepdims=True)
    from plumbline.harness.trajectory.kinematics import rotate

    turn = np.broadcast_to(np.array(q_WB), (len(origin_S), 4))
    hits = first_hits(scene, State.initial(scene), rotate(turn, origin_S) + np.array(p_WB), rotate(turn, aim_S), 20.0)
    traced, closest = _traced(shape, origin_S, aim_S, 20.0)
    assert np.isnan(closest).mean() < 0.2
    # A ray that passes within 1e-4 of the surface converges too slowly when traced to be called a hit or a miss.
    hit, miss = closest < 1e-12, closest > 1e-4
    assert np.isfinite(hits.distance[hit]).all()
    assert np.isinf(hits.distance[miss]).all()
    # Tracing closes in on a surface met at cosine c by (1 - c) a step; grazing rays are left out by the condition above.
    np.testing.assert_allclose(hits.distance[hit], traced[hit], atol=1e-10)
    assert (hits.body[hit] == 0).all()
    assert (hits.body[miss] == -1).all()
    at = origin_S[hit] + hits.distance[hit][:, None] * aim_S[hit]
    slope = np.stack([(_distance(shape, at + e) - _distance(shape, at - e)) / 2e-6 for e in 1e-6 * np.eye(3)], axis=1)
    slope /= np.linalg.norm(slope, axis=1)[:, None]
    found = np.einsum("ij,ij->i", hits.normal_W[hit], rotate(turn[hit], slope))
    # The gradient of the signed distance points along the normal, except across an edge within a micrometre.
    assert np.mean(found > 1 - 1e-6) > 0.95


def test_the_nearest_of_several_bodies_is_hit_and_nothing_beyond_the_range() -> None:
    near, far = (
        Body(name=n, motion="static", collision=(PlacedShape(shape=Sphere(radius=1.0), p_BS=(0, 0, 0.5)),), p_WB=(x, 0, -0.5))
        for n, x in (("near", 5.0), ("far", 9.0))
    )
    scene = Scene(bodies=(far, near))
    ray = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]])
    hits = first_hits(scene, State.initial(scene), *ray, 20.0)
    assert hits.distance[0] == pytest.approx(4.0, abs=1e-15)
    assert hits.body[0] == 1
    np.testing.assert_allclose(hits.normal_W[0], [-1, 0, 0], atol=1e-15)
    assert np.isinf(first_hits(scene, State.initial(scene), *ray, 3.9).distance[0])


def test_axis_parallel_rays_along_and_beside_a_box_are_told_apart() -> None:
    scene = Scene(bodies=(Body(name="b", motion="static", collision=(PlacedShape(shape=Box(half_extents=(1, 1, 1))),)),))
    origins = np.array([[-5.0, 0.5, 0.5], [-5.0, 1.5, 0.0], [0.0, 0.0, 5.0]])
    directions = np.array([[1.0, 0, 0], [1.0, 0, 0], [0, 0, -1.0]])
    np.testing.assert_array_equal(
        first_hits(scene, State.initial(scene), origins, directions, 20.0).distance, [4.0, np.inf, 4.0]
    )


BOX_CORNERS = tuple((x, y, z) for x in (-0.5, 0.5) for y in (-0.8, 0.8) for z in (-0.3, 0.3))
BOX_FACES = (
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
)  # fmt: skip


@pytest.mark.parametrize(
    "shape", [ConvexHull(vertices=BOX_CORNERS), TriangleMesh(vertices=BOX_CORNERS, faces=BOX_FACES)], ids=lambda s: s.type
)
def test_a_box_told_as_hull_or_mesh_is_met_as_the_box_is(shape: Shape) -> None:
    rng = np.random.default_rng(4)
    origins = rng.normal(size=(400, 3))
    origins *= 3.0 / np.linalg.norm(origins, axis=1, keepdims=True)
    aims = rng.uniform(-0.9, 0.9, size=origins.shape) - origins
    aims /= np.linalg.norm(aims, axis=1, keepdims=True)
    found = []
    for one in (Box(half_extents=(0.5, 0.8, 0.3)), shape):
        scene = Scene(bodies=(Body(name="s", motion="static", collision=(PlacedShape(shape=one),), p_WB=(0.1, 0.2, 0.3)),))
        found.append(first_hits(scene, State.initial(scene), origins, aims, 20.0))
    assert 100 < np.isfinite(found[0].distance).sum() < 400
    np.testing.assert_allclose(found[1].distance, found[0].distance, atol=1e-13)
    np.testing.assert_allclose(found[1].normal_W, found[0].normal_W, atol=1e-13)
