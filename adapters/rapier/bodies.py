"""Bodies with their mass and colliders, in Rapier's words."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from plumbline.adapters.rapier.vendor import pose
from plumbline.harness.adapter import Settings, Unsupported
from plumbline.harness.adapter.rotations import principal_frame
from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Effect,
    Ellipsoid,
    Plane,
    Quaternion,
    Shape,
    Sphere,
    TriangleMesh,
    multiply,
)

_UPRIGHT: Quaternion = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
"""Turns y, the axis of Rapier's cylinders, to z."""


def builder_of(rapier: Any, body: Body, effects: Effect, used: Settings) -> Any:
    """A body without shapes, at its start."""
    build = rapier.RigidBody
    if body.motion == "static":
        return build.fixed().position(pose(rapier, body.p_WB, body.q_WB))
    moments, q_BP = principal_frame(body)
    mass = rapier.MassProperties((0.0, 0.0, 0.0), body.mass, moments, rapier.Rotation3(*q_BP))
    if body.motion == "kinematic":
        # Untold, it turns about the middle of its shapes, weightless as they are, and its velocity is of that point.
        builder = build.kinematic_velocity_based().additional_mass_properties(mass)
    else:
        # A body whose moments are alike feels no gyroscopic torque, and with one it gains energy by rounding.
        uneven = Effect.GYROSCOPIC in effects and len(set(moments)) > 1
        builder = build.dynamic().additional_mass_properties(mass).gyroscopic_forces(uneven)
    v, w = body.velocity_at_start
    builder = builder.position(pose(rapier, body.p_WB, body.q_WB)).linvel(v).angvel(w).can_sleep(used.options["sleeping"])
    if Effect.LINEAR_DAMPING in effects:
        builder = builder.linear_damping(body.linear_damping)
    if Effect.ANGULAR_DAMPING in effects:
        builder = builder.angular_damping(body.angular_damping)
    if not used.options["capped"]:
        builder = builder.allow_fast_rotation(True)
    if Effect.CONTINUOUS_COLLISION in effects and body.movable and body.collision:
        builder = builder.ccd_enabled(True)
        if used.options["soft_ccd"]:
            builder = builder.soft_ccd_prediction(_reach(body, used.dt))
    return builder


def _reach(body: Body, dt: float) -> float:
    """How far [m] a body moves in a step at most: at twice its speed at the start, and at least at 10 m/s."""
    return 2.0 * dt * max(float(np.linalg.norm(body.v_WB)), 10.0)


def check_body(body: Body) -> None:
    """Raises: Unsupported, for shapes that Rapier has not."""
    for placed in body.collision:
        if isinstance(placed.shape, Ellipsoid):
            raise Unsupported(f"ellipsoid of body '{body.name}'", "Rapier has no such shape")


def colliders_of(rapier: Any, body: Body, inner_edges: bool) -> Iterator[Any]:
    """The shapes of a body, weightless."""
    for placed in body.collision:
        builder, q_SC = _collider(rapier, placed.shape, inner_edges)
        yield builder.position(pose(rapier, placed.p_BS, multiply(placed.q_BS, q_SC))).density(0.0)


def _collider(rapier: Any, shape: Shape, inner_edges: bool) -> tuple[Any, Quaternion]:
    """A collider, and how it is turned in S."""
    build, straight = rapier.Collider, (1.0, 0.0, 0.0, 0.0)
    match shape:
        case Sphere():
            return build.ball(shape.radius), straight
        case Box():
            return build.cuboid(*shape.half_extents), straight
        case Capsule():
            return build.capsule_z(shape.half_length, shape.radius), straight
        case Cylinder():
            return build.cylinder(shape.half_length, shape.radius), _UPRIGHT
        case Plane():
            return build.halfspace(shape.normal), straight
        case ConvexHull():
            return build.convex_hull(np.array(shape.vertices, dtype=np.float32)), straight
        case TriangleMesh():
            flags = None if inner_edges else rapier.TriMeshFlags.FIX_INTERNAL_EDGES
            points, faces = np.array(shape.vertices, dtype=np.float32), np.array(shape.faces, dtype=np.uint32)
            return build.trimesh(points, faces, flags), straight
    raise AssertionError(f"{shape.type} passed the door")
