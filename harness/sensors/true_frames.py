"""Frames of a camera in closed form: what an engine's frames are measured against."""

from collections.abc import Callable

import numpy as np

from plumbline.harness.scene import Camera, DepthCamera, Scene
from plumbline.harness.sensors.depth_camera import lost
from plumbline.harness.sensors.pinhole import pixel_rays, view_of
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.sensors.reader import pose_of, row_of
from plumbline.harness.sensors.sight import Sight, sight_by_rays
from plumbline.harness.trajectory import Floats, Hits, State

NEAREST, FARTHEST = 1e-6, 1e6
"""Bounds [m] of what a colour camera sees, which has none of its own."""


def stamps_up_to(end: float, rate: float) -> Floats:
    """The times [s] of all frames at `rate` [Hz] from 0 to `end` [s], (k,)."""
    return np.arange(int(np.floor(end * rate + 1e-6)) + 1) / rate


def _as_depth_camera(camera: Camera | DepthCamera) -> DepthCamera:
    if isinstance(camera, DepthCamera):
        return camera
    return DepthCamera(**view_of(camera), near=NEAREST, far=FARTHEST)


def true_sight(scene: Scene, camera: Camera | DepthCamera, state: State) -> Sight:
    """What a camera sees of a state by closed-form rays. Raises: TypeError, as `first_hits`."""

    def cast(origins: Floats, directions: Floats, max_range: float) -> Hits:
        return first_hits(scene, state, origins, directions, max_range)

    p_WS, q_WS = pose_of(row_of(scene, camera.body, state), camera.p_BS, camera.q_BS)
    return sight_by_rays(_as_depth_camera(camera), scene, cast, p_WS, q_WS, pixel_rays(camera))


def true_frames(
    scene: Scene, camera: Camera | DepthCamera, stamps: Floats, state_at: Callable[[float], State] | None = None
) -> dict[str, Floats]:
    """Streams '<name>/time' (k,), '<name>/body', '<name>/depth' of a camera or '<name>/depth_ideal' of a depth camera, and of a
    noisy one '<name>/lost': 1 where geometry and optics take the pixel away; all (k, height, width).

    Args:
        stamps: times [s] of the frames, (k,). state_at: the state at a time [s]; without it nothing moves.

    Raises:
        TypeError: a shape without a closed form.
    """
    noise = camera.noise if isinstance(camera, DepthCamera) else None

    def frame(state: State) -> tuple[Floats, ...]:
        sight = true_sight(scene, camera, state)
        taken = () if noise is None else (lost(noise, sight).astype(np.float64),)
        return (sight.depth, sight.body.astype(np.float64), *taken)

    if state_at is None:
        still = frame(State.initial(scene))
        views = [still] * len(stamps)
    else:
        views = [frame(state_at(float(time))) for time in stamps]
    depth = "depth_ideal" if isinstance(camera, DepthCamera) else "depth"
    streams: dict[str, Floats] = {f"{camera.name}/time": stamps}
    for k, channel in enumerate((depth, "body", "lost")[: 2 if noise is None else 3]):
        shape = (len(stamps), camera.height, camera.width)
        streams[f"{camera.name}/{channel}"] = np.array([view[k] for view in views], dtype=np.float64).reshape(shape)
    return streams
