"""Bodies with their mass and shapes, in Newton's words."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plumbline.adapters.newton.surfaces import Numbers
from plumbline.adapters.newton.vendor import Vendor
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.convex_meshes import is_convex
from plumbline.harness.adapter.rotations import IDENTITY
from plumbline.harness.scene import (
    WORLD,
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
    multiply,
    rotate,
)

WORLD_BODY = -1
"""Newton's number of the world."""

SOFT_AS_ITS_CONTACT = -1.0
"""Newton's kf, a gain of friction [N s/m], below 0: friction gives way by the time constant of its contact. At the vendor's
1000 it is held at 2 ms for 1 kg under elliptic cones and Newton's own collisions, and what slides at 3 m/s hops by 36 mm."""


@dataclass(slots=True)
class Bodies:
    """Puts bodies into a model that is being made.

    Terms:
        solver: which will step the model. softness: (ke, kd) of contacts. attributes: what else
        MuJoCo-Warp is told of each shape. links: Newton's numbers by the names of bodies.
        shapes: numbers of a body's shapes. owners: by Newton's numbers of shapes, the places of their bodies in the scene.
    """

    vendor: Vendor
    builder: Any
    scene: Scene
    solver: str
    numbers: Numbers
    softness: tuple[float, float]
    attributes: Mapping[str, Any]
    links: dict[str, int] = field(default_factory=lambda: {WORLD: WORLD_BODY})
    shapes: dict[str, list[int]] = field(default_factory=dict)
    owners: list[int] = field(default_factory=list)

    def put(self) -> None:
        """All bodies and their shapes; what stands still hangs on the world. Raises: Unsupported."""
        for row, body in enumerate(self.scene.bodies):
            still = body.motion == "static"
            self.links[body.name] = WORLD_BODY if still else self._link(body)
            for placed in body.collision:
                p, q = placed.p_BS, placed.q_BS
                if still:
                    p, q = within(body, p, q)
                self.shapes.setdefault(body.name, []).append(self._shape(body, placed.shape, p, q))
                self.owners.append(row)

    def _link(self, body: Body) -> int:
        if body.massless:
            raise Unsupported(f"body '{body.name}' without mass", "Newton's adapter tells each body that moves its mass")
        led = body.motion == "kinematic"
        # A body that is led is held by what MuJoCo-Warp makes of its inertia; any will do, and the scene's is as good.
        mass, inertia = (body.mass, body.inertia) if body.mass > 0 and any(map(any, body.inertia)) else (1.0, _UNIT)
        number: int = self.builder.add_link(
            xform=self.vendor.transform(body.p_WB, body.q_WB),
            mass=mass,
            inertia=self.vendor.warp.mat33(*np.asarray(inertia, dtype=np.float32).ravel().tolist()),
            lock_inertia=True,
            is_kinematic=led,
        )
        return number

    def _shape(self, body: Body, shape: Shape, p: Vector3, q: Quaternion) -> int:
        touches, kind = Effect.CONTACT in self.scene.effects, (body.material, body.movable)
        (ke, kd), mu = self.softness, self.numbers.friction.get(kind, 0.0)
        config = self.vendor.newton.ModelBuilder.ShapeConfig(
            density=0.0,
            mu=mu,
            restitution=self.numbers.restitution.get(kind, 0.0),
            mu_torsional=0.0,
            mu_rolling=0.0,
            ke=ke,
            kd=kd,
            kf=SOFT_AS_ITS_CONTACT,
            has_shape_collision=touches,
            has_particle_collision=False,
            collision_filter_parent=False,
        )
        link, at, builder = self.links[body.name], self.vendor.transform(p, q), self.builder
        # A pyramid of friction 0 ends in NaN; a contact of one dimension has none.
        attributes = {**self.attributes, **({"mujoco:condim": 1} if mu == 0.0 else {})}
        arguments = {"xform": at, "cfg": config, "custom_attributes": attributes or None}
        match shape:
            case Sphere():
                number = builder.add_shape_sphere(link, radius=shape.radius, **arguments)
            case Box():
                x, y, z = shape.half_extents
                number = builder.add_shape_box(link, hx=x, hy=y, hz=z, **arguments)
            case Capsule():
                number = builder.add_shape_capsule(link, radius=shape.radius, half_height=shape.half_length, **arguments)
            case Cylinder():
                number = builder.add_shape_cylinder(link, radius=shape.radius, half_height=shape.half_length, **arguments)
            case Ellipsoid():
                a, b, c = shape.semi_axes
                number = builder.add_shape_ellipsoid(link, rx=a, ry=b, rz=c, **arguments)
            case Plane():
                if body.motion != "static":
                    raise Unsupported(f"body '{body.name}': a plane that moves", "MuJoCo-Warp's planes stand still")
                arguments["xform"] = self.vendor.transform(p, multiply(q, _from_z(shape.normal)))
                number = builder.add_shape_plane(None, width=0.0, length=0.0, body=link, **arguments)
            case ConvexHull() | TriangleMesh():
                number = self._polyhedron(body, shape, link, arguments)
            case _:
                raise AssertionError(f"{shape.type} passed the door")
        return int(number)

    def _polyhedron(self, body: Body, shape: ConvexHull | TriangleMesh, link: int, arguments: dict[str, Any]) -> int:
        points = np.array(shape.vertices, dtype=np.float32)
        if isinstance(shape, ConvexHull):
            from scipy.spatial import ConvexHull as Hull

            faces = Hull(np.array(shape.vertices)).simplices
            mesh = self.vendor.newton.Mesh(points, faces.astype(np.int32).ravel(), compute_inertia=False)
            return int(self.builder.add_shape_convex_hull(link, mesh=mesh, **arguments))
        if body.movable:
            raise Unsupported(f"mesh of body '{body.name}'", "MuJoCo-Warp collides a mesh as its hull")
        faces, touches = np.array(shape.faces, dtype=np.int32), Effect.CONTACT in self.scene.effects
        if touches and self.solver == "mujoco" and not is_convex(np.array(shape.vertices), faces):
            raise Unsupported(
                f"body '{body.name}': a mesh that is not convex and closed", "MuJoCo-Warp collides a mesh as its hull"
            )
        mesh = self.vendor.newton.Mesh(points, faces.ravel(), compute_inertia=False)
        return int(self.builder.add_shape_mesh(link, mesh=mesh, **arguments))

    def keep_apart(self) -> None:
        """No contact between those that stand apart, that a joint holds, or neither of which a force moves."""
        bodies = [body for body in self.scene.bodies if body.collision]
        apart = {frozenset(pair) for pair in self.scene.apart}
        joined = self.scene.joined() if Effect.JOINTS in self.scene.effects else frozenset()
        for k, a in enumerate(bodies):
            for b in bodies[:k]:
                still = not (a.movable or b.movable)
                both = a.motion == b.motion == "static"
                held = frozenset((a.name, b.name)) in joined or frozenset((a.material, b.material)) in apart
                if not both and (still or held):
                    for one in self.shapes[a.name]:
                        for other in self.shapes[b.name]:
                            self.builder.add_shape_collision_filter_pair(one, other)


_UNIT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def within(body: Body, p: Vector3, q: Quaternion) -> tuple[Vector3, Quaternion]:
    """A pose in a body as one in W."""
    x, y, z = (a + b for a, b in zip(body.p_WB, rotate(body.q_WB, p), strict=True))
    return (x, y, z), multiply(body.q_WB, q)


def _from_z(normal: Vector3) -> Quaternion:
    """A rotation that turns z to the normal."""
    x, y, z = normal
    if z < -0.999999:
        return (0.0, 1.0, 0.0, 0.0)
    w, turn = 1.0 + z, (-y, x, 0.0)
    long = float(np.sqrt(w * w + turn[0] ** 2 + turn[1] ** 2))
    return (w / long, turn[0] / long, turn[1] / long, 0.0) if long > 0 else IDENTITY
