"""Depth camera: the ideal z-depth of each frame, and what the principle of its noise makes of it.

Ideal depths outside near..far read -inf and +inf and stay so; the noise of a depth inside is not cut off at the bounds.
Invalid pixels, lost by the principle or at random, read NaN (ROS REP 118). Deviates are drawn for all pixels of a frame, frame
by frame, so that a longer run begins with the shorter one's noise, and what is seen has no part in what is drawn.
"""

from dataclasses import replace

import numpy as np

from plumbline.harness.scene import Camera, DepthCamera, DepthNoise, TimeOfFlightNoise
from plumbline.harness.sensors import time_of_flight, triangulation
from plumbline.harness.sensors.camera import Pictures, pixel_rays, view_of
from plumbline.harness.sensors.reader import Setting, generator, pose_of, row_of
from plumbline.harness.sensors.sight import Mask, Sight, bounded, sight_by_rays
from plumbline.harness.trajectory import Floats, State
from plumbline.harness.trajectory.kinematics import rotate


def lost(noise: DepthNoise, sight: Sight) -> Mask:
    """Which measurable pixels the principle cannot measure, whatever the dice say, (r,). Raises: Unsupported."""
    return time_of_flight.lost(noise, sight) if isinstance(noise, TimeOfFlightNoise) else triangulation.lost(noise, sight)


def answer(noise: DepthNoise, sight: Sight, normal: Floats) -> Floats:
    """z-depth [m] with the principle's errors as if all pixels were valid, (r,), from standard normal deviates (r,).

    Raises: Unsupported.
    """
    if isinstance(noise, TimeOfFlightNoise):
        return time_of_flight.answer(noise, sight, normal)
    return triangulation.answer(noise, sight, normal)


def picture_camera(camera: DepthCamera) -> Camera:
    """The colour camera of the same view, by whose picture the depth is seen. Raises: ValueError where rays see it."""
    if camera.seen_by == "rays":
        raise ValueError(f"sensor '{camera.name}': seen_by 'rays', expected a renderer")
    return Camera(**view_of(camera), renderer=camera.seen_by)


class DepthReader:
    """Frames of z-depth '<name>/depth_ideal' and '<name>/depth' (k, height, width) m, and of '<name>/body' (k, height, width):
    the place in the scene of what is seen, -1 for nothing up to `far`.
    """

    def __init__(self, camera: DepthCamera, setting: Setting, start: State) -> None:  # noqa: ARG002 -- a frame needs no past
        self._camera, self._setting = camera, setting
        self._pictures, self._rays_S = Pictures(camera.name), pixel_rays(camera)
        self._normal = generator(setting.seed, camera.name, "depth")
        self._uniform = generator(setting.seed, camera.name, "missing")

    def _sight(self, state: State) -> Sight:
        camera, setting = self._camera, self._setting
        simulation = setting.simulation
        p_WS, q_WS = pose_of(row_of(setting.scene, camera.body, state), camera.p_BS, camera.q_BS)
        if camera.seen_by == "rays":
            return sight_by_rays(camera, setting.scene, simulation.cast, p_WS, q_WS, self._rays_S)
        image = simulation.render(picture_camera(camera), colour=False)
        depth = bounded(camera, image.depth.ravel())
        body = np.where(depth == np.inf, -1, image.body.ravel())
        if camera.noise is None:
            unknown = np.zeros((len(depth), 3))
            ahead, directions_W = self._rays_S[:, 2], rotate(q_WS, self._rays_S)
            return Sight(camera, setting.scene, simulation.cast, p_WS, q_WS, ahead, directions_W, depth, body, unknown)
        # A picture has no normals, which noise may need: they are those that rays meet. At an edge a ray may meet another body
        # than the picture shows, or none; such a pixel counts as seen head-on.
        met = sight_by_rays(camera, setting.scene, simulation.cast, p_WS, q_WS, self._rays_S)
        normal_W = np.where((met.body == body)[:, None], met.normal_W, -met.directions_W)
        return replace(met, depth=depth, body=body, normal_W=normal_W)

    def read(self, time: float, state: State) -> None:
        """Take a frame. Raises: Unsupported."""
        noise = self._camera.noise
        sight, shape = self._sight(state), (self._camera.height, self._camera.width)
        depth = sight.depth
        if noise is not None:
            normal, uniform = self._normal.standard_normal(len(depth)), self._uniform.random(len(depth))
            invalid = lost(noise, sight) | (sight.measurable & (uniform < noise.missing))
            depth = np.where(invalid, np.nan, answer(noise, sight, normal))
        self._pictures.keep(
            time,
            depth_ideal=sight.depth.reshape(shape),
            depth=depth.reshape(shape),
            body=sight.body.astype(np.int32).reshape(shape),
        )

    def streams(self) -> dict[str, Floats]:
        """All frames so far."""
        return self._pictures.streams()
