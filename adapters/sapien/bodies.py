"""Bodies with their mass and shapes, in SAPIEN's words."""

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.adapters.sapien.vendor import pose
from plumbline.harness.adapter import Settings, Unsupported
from plumbline.harness.adapter.rotations import IDENTITY, principal_frame
from plumbline.harness.adapter.touching_kinds import Kind
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
    Scene,
    Shape,
    Sphere,
    TriangleMesh,
    Vector3,
    axis_angle,
    multiply,
    outer_radius,
    rotate,
)

_Z_FROM_X: Quaternion = (math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0)
"""Turns x, along which capsules, cylinders and normals of planes lie in PhysX, to z."""
_UNCAPPED = 1e16
"""A rate [rad/s, 1/s] that nothing reaches."""
MOST_CORNERS = 255
"""Of a convex hull; with more PhysX cooks another one."""
REACH = 100.0
"""How far [m] the box that stands for a plane goes on beyond all that moves at the start: further, single precision shows."""


@dataclass(frozen=True, slots=True)
class Bodies:
    """Makes the components of bodies.

    Terms: materials, patches: by kind. groups: by material, type and affinity. slab: half the edge [m] of the box that stands
    for each plane, 0 where planes are planes.
    """

    sapien: Any
    effects: Effect
    used: Settings
    materials: Mapping[Kind, Any]
    groups: Mapping[str, tuple[int, int]]
    patches: Mapping[Kind, float]
    slab: float = 0.0

    def entity(self, body: Body, component: Any, number: int, ignored: tuple[int, int] = (0, 0)) -> Any:
        """An entity of this component with the body's shapes, named by its number.

        Args: ignored: bits of ignored contact and the group in which they count.
        """
        entity = self.sapien.Entity()
        entity.name = str(number)
        if Effect.CONTACT in self.effects:
            kind = (body.material, body.movable)
            for shape in self._shapes(body, self.materials.get(kind)):
                shape.patch_radius = shape.min_patch_radius = self.patches.get(kind, 0.0)
                shape.set_collision_groups([*self.groups[body.material], *ignored])
                component.attach(shape)
        entity.add_component(component)
        entity.pose = pose(self.sapien, body.p_WB, body.q_WB)
        return entity

    def tell_mass(self, body: Body, component: Any) -> None:
        """Mass, principal moments and their frame, damping and caps of what moves."""
        moments, q_BP = principal_frame(body)
        component.mass, component.inertia = body.mass, list(moments)
        component.cmass_local_pose = pose(self.sapien, (0.0, 0.0, 0.0), q_BP)
        linear = body.linear_damping if Effect.LINEAR_DAMPING in self.effects else 0.0
        angular = body.angular_damping if Effect.ANGULAR_DAMPING in self.effects else 0.0
        if linear or self.used.options["damping"] == "scene":
            component.linear_damping = linear
        if angular or self.used.options["damping"] == "scene":
            component.angular_damping = angular
        component.max_depenetration_velocity = self.used.options["max_depenetration_velocity"]
        if not self.used.options["capped"]:
            component.max_angular_velocity = component.max_linear_velocity = _UNCAPPED

    def shape_for_rays(self, scene: Scene, components: Mapping[int, Any]) -> None:
        """Give bodies shapes that touch nothing."""
        material = self.sapien.physx.get_default_material()
        for number, component in components.items():
            for shape in self._shapes(scene.bodies[number], material):
                shape.set_collision_groups([0, 0, 0, 0])
                component.attach(shape)

    def _shapes(self, body: Body, material: Any) -> Iterator[Any]:
        """The shapes of a body, weightless."""
        for placed in body.collision:
            shape, q_SC = self._shape(placed.shape, material)
            p_BS = placed.p_BS
            if isinstance(placed.shape, Plane) and self.slab:
                x, y, z = rotate(placed.q_BS, placed.shape.normal)
                p_BS = p_BS[0] - self.slab * x, p_BS[1] - self.slab * y, p_BS[2] - self.slab * z
            shape.local_pose = pose(self.sapien, p_BS, multiply(placed.q_BS, q_SC))
            shape.density = 0.0
            yield shape

    def _shape(self, shape: Shape, material: Any) -> tuple[Any, Quaternion]:
        """A shape, and how it is turned in S."""
        physx, whole = self.sapien.physx, [1.0, 1.0, 1.0]
        match shape:
            case Sphere():
                return physx.PhysxCollisionShapeSphere(shape.radius, material), IDENTITY
            case Box():
                return physx.PhysxCollisionShapeBox(list(shape.half_extents), material), IDENTITY
            case Capsule():
                return physx.PhysxCollisionShapeCapsule(shape.radius, shape.half_length, material), _Z_FROM_X
            case Cylinder():
                return physx.PhysxCollisionShapeCylinder(shape.radius, shape.half_length, material), _Z_FROM_X
            case Plane() if self.slab:
                return physx.PhysxCollisionShapeBox([self.slab] * 3, material), _from_x(shape.normal)
            case Plane():
                return physx.PhysxCollisionShapePlane(material), _from_x(shape.normal)
            case ConvexHull():
                points = np.array(shape.vertices, dtype=np.float32)
                return physx.PhysxCollisionShapeConvexMesh(points, whole, material), IDENTITY
            case TriangleMesh():
                points, faces = np.array(shape.vertices, dtype=np.float32), np.array(shape.faces, dtype=np.uint32)
                return physx.PhysxCollisionShapeTriangleMesh(points, faces, whole, material), IDENTITY
        raise AssertionError(f"{shape.type} passed the door")


def check_body(body: Body) -> None:
    """Raises: Unsupported, for shapes that PhysX has not, and for no mass."""
    if body.massless:
        raise Unsupported(f"body '{body.name}' without mass", "PhysX takes a link without mass for one of a kilogram")
    for placed in body.collision:
        match placed.shape:
            case Ellipsoid():
                raise Unsupported(f"ellipsoid of body '{body.name}'", "PhysX has no such shape")
            case ConvexHull(vertices=corners) if len(corners) > MOST_CORNERS:
                raise Unsupported(
                    f"hull of {len(corners)} corners of body '{body.name}'", f"PhysX cooks hulls of {MOST_CORNERS} at most"
                )


def has_mesh(body: Body) -> bool:
    """Is one of its shapes a mesh of triangles?"""
    return any(isinstance(placed.shape, TriangleMesh) for placed in body.collision)


def slab_of(scene: Scene) -> float:
    """Half the edge [m] of the box that stands for a plane where a mesh moves; 0 where none does.

    Raises: Unsupported, of two meshes of which one moves, that may meet.
    """
    if Effect.CONTACT not in scene.effects:
        return 0.0
    meshes = [body for body in scene.bodies if has_mesh(body)]
    for body, other in itertools.combinations(meshes, 2):
        if (body.motion != "static" or other.motion != "static") and scene.collides(body, other):
            raise Unsupported(
                f"meshes of bodies '{body.name}' and '{other.name}'", "PhysX lets two meshes pass through each other on a CPU"
            )
    if all(body.motion == "static" for body in meshes):
        return 0.0
    far = (
        math.hypot(*body.p_WB) + math.hypot(*placed.p_BS) + outer_radius(placed.shape)
        for body in scene.bodies
        for placed in body.collision
        if not isinstance(placed.shape, Plane)
    )
    return REACH + max(far)


def _from_x(normal: Vector3) -> Quaternion:
    """A rotation that turns x to a normal."""
    x, y, z = normal
    across = math.hypot(y, z)
    if across == 0.0:
        return IDENTITY if x > 0 else (0.0, 0.0, 0.0, 1.0)
    return axis_angle((0.0, -z / across, y / across), math.atan2(across, x))
