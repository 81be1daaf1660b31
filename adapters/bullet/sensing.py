"""Rays and pictures, taken in a second world that holds the same shapes at the present poses."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.adapters.bullet.frames import plus, xyzw
from plumbline.adapters.bullet.shapes import single_shape, unseen_shape, visual_shape
from plumbline.adapters.bullet.vendor import Port, connected, silenced
from plumbline.harness.adapter.rotations import IDENTITY
from plumbline.harness.scene import WORLD, Camera, ConvexHull, Quaternion, Scene, TriangleMesh, Vector3, multiply, rotate
from plumbline.harness.trajectory import Floats, Hits, Image, State

RAY_BATCH = 16_000
"""Rays in one call; beyond 16383 the binding drops rays in silence."""
RAY_MARGIN = 1e-6
"""Least collision margin [m] of the hulls that rays are cast at: four of five rays miss a hull that has none."""
NEAR, FAR = 0.05, 100.0
"""The range [m] of depth images: TinyRenderer's buffer is single precision, so a wider one would cost resolution."""
LIGHT_DISTANCE = 1e6
"""Of the light in images, in units of the direction to it."""


@dataclass(slots=True)
class Twin:
    """A second world, never stepped, of all shapes: each part of a body is a static body of its own, moved to where it is.

    Terms:
        parts: (number in Bullet, place in the scene, shape's pose in B). owners: number -> place.
    """

    port: Port
    parts: tuple[tuple[int, int, Vector3, Quaternion], ...]
    owners: Mapping[int, int]
    poses: dict[int, tuple[Vector3, Quaternion]]

    @classmethod
    def of(cls, bullet: Any, scene: Scene, margin: float) -> "Twin":
        """All bodies of the scene at their initial poses."""
        port = connected(bullet)
        parts: list[tuple[int, int, Vector3, Quaternion]] = []
        unseen = unseen_shape(port)
        for place, body in enumerate(scene.bodies):
            solids = [
                (placed, single_shape(port, placed.shape, (0.0, 0.0, 0.0), IDENTITY), unseen) for placed in body.collision
            ]
            drawn = body.collision if body.visual is None else body.visual
            red, green, blue = (body.appearance.scatters * share for share in body.appearance.colour)
            looks = [(placed, -1, visual_shape(port, placed.shape, (red, green, blue))) for placed in drawn]
            for placed, solid, look in solids + looks:
                p_WS, q_WS = plus(body.p_WB, rotate(body.q_WB, placed.p_BS)), multiply(body.q_WB, placed.q_BS)
                number = port.call(
                    "createMultiBody",
                    baseMass=0.0,
                    baseCollisionShapeIndex=solid,
                    baseVisualShapeIndex=look,
                    basePosition=p_WS,
                    baseOrientation=xyzw(q_WS),
                    useMaximalCoordinates=0 if solid < 0 else 1,
                )
                if solid >= 0 and isinstance(placed.shape, ConvexHull | TriangleMesh):
                    port.call("changeDynamics", number, -1, collisionMargin=max(margin, RAY_MARGIN))
                parts.append((number, place, placed.p_BS, placed.q_BS))
        poses = {place: (body.p_WB, body.q_WB) for place, body in enumerate(scene.bodies)}
        return cls(port, tuple(parts), {number: place for number, place, _, _ in parts}, poses)

    def place(self, state: State, moving: Iterable[int]) -> None:
        """Move the shapes of the moving bodies to where these are."""
        moved = {int(place) for place in moving}
        for place in moved:
            (x, y, z), (w, i, j, k) = state.p_WB[place].tolist(), state.q_WB[place].tolist()
            self.poses[place] = (x, y, z), (w, i, j, k)
        for number, place, p_BS, q_BS in self.parts:
            if place in moved:
                p, q = self.poses[place]
                self.port.call("resetBasePositionAndOrientation", number, plus(p, rotate(q, p_BS)), xyzw(multiply(q, q_BS)))

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hits, see `Simulation.cast`."""
        fraction, owner, normal = np.ones(len(origins)), np.full(len(origins), -1), np.zeros((len(origins), 3))
        for number, hits in enumerate(self.caster(origins, directions, max_range)()):
            rays = slice(number * RAY_BATCH, (number + 1) * RAY_BATCH)
            fraction[rays] = [hit[2] for hit in hits]
            owner[rays] = [self.owners.get(hit[0], -1) for hit in hits]
            normal[rays] = [hit[4] for hit in hits]
        normal[owner < 0] = 0.0
        return Hits(np.where(owner < 0, np.inf, fraction * max_range), owner.astype(np.int64), normal)

    def caster(self, origins: Floats, directions: Floats, max_range: float) -> Callable[[], list[Any]]:
        """A function that casts these rays, RAY_BATCH of them in one native call, and gives the binding's own tuples."""
        ends = origins + directions * max_range
        starts = range(0, len(origins), RAY_BATCH)
        batches = [(origins[k : k + RAY_BATCH].tolist(), ends[k : k + RAY_BATCH].tolist()) for k in starts]
        return lambda: [self.port.call("rayTestBatch", *batch) for batch in batches]

    def render(self, camera: Camera, scene: Scene, colour: bool) -> Image:
        """The picture of TinyRenderer, see `Simulation.render`; z = f n / (f - (f - n) d) of its depth buffer d.

        Linear colours under the scene's sun and sky, without shadows; what does not scatter shows the sky. The light is scaled
        to the 8 bits of the colours.
        """
        p_WB, q_WB = (0.0, 0.0, 0.0), IDENTITY
        if camera.body != WORLD:
            p_WB, q_WB = self.poses[scene.index(camera.body)]
        p_WS, q_WS = plus(p_WB, rotate(q_WB, camera.p_BS)), multiply(q_WB, camera.q_BS)
        ahead, down = rotate(q_WS, (0.0, 0.0, 1.0)), rotate(q_WS, (0.0, 1.0, 0.0))
        width, height, near, far = camera.width, camera.height, NEAR, FAR
        # TinyRenderer samples the lower left corner of a pixel: the picture is moved so that this is the pixel's centre.
        centre_x, centre_y = camera.centre_x - 0.5, camera.centre_y + 0.5
        left, right = -centre_x / camera.focal_x, (width - centre_x) / camera.focal_x
        bottom, top = -(height - centre_y) / camera.focal_y, centre_y / camera.focal_y
        view = self.port.call("computeViewMatrix", p_WS, plus(p_WS, ahead), [-c for c in down])
        frustum = [edge * near for edge in (left, right, bottom, top)]
        projection = self.port.call("computeProjectionMatrix", *frustum, near, far)
        sun, looks = scene.sun, [body.appearance for body in scene.bodies]
        direct = sun.irradiance / math.pi
        scale = max(direct + sun.sky, 1e-300)
        with silenced():
            image = self.port.call(
                "getCameraImage",
                width,
                height,
                view,
                projection,
                lightDirection=[LIGHT_DISTANCE * c for c in sun.towards_W],
                lightColor=(1.0, 1.0, 1.0),
                lightAmbientCoeff=sun.sky / scale,
                lightDiffuseCoeff=direct / scale,
                lightSpecularCoeff=0.0,
                shadow=0,
                renderer=self.port.bullet.ER_TINY_RENDERER,
            )
        depth = np.asarray(image[3], dtype=np.float64).reshape(height, width)
        number = np.asarray(image[4]).reshape(height, width)
        owner = np.full(max(self.owners, default=0) + 2, -1, dtype=np.int64)
        owner[list(self.owners)] = list(self.owners.values())
        body = np.where(number >= 0, owner[number], -1)
        with np.errstate(divide="ignore"):
            depth = np.where(body >= 0, far * near / (far - (far - near) * depth), np.inf)
        if not colour:
            return Image(depth, body)
        shades = np.asarray(image[2], dtype=np.float64).reshape(height, width, 4)[..., :3] * (scale / 255.0)
        through = np.array([*(1.0 - look.scatters for look in looks), 1.0])[body]
        return Image(depth, body, np.where((body >= 0)[..., None], shades, 0.0) + (sun.sky * through)[..., None])

    def close(self) -> None:
        """Free the second world."""
        self.port.call("disconnect")
