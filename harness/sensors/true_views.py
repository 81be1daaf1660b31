"""The truth of a case in whose scene nothing moves: what its range finders and cameras see, in closed form."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from plumbline.harness.scene import Camera, DepthCamera, Lidar, Scene
from plumbline.harness.sensors.camera import pixel_rays, view_of
from plumbline.harness.sensors.depth_camera import lost
from plumbline.harness.sensors.lidar import ideal, in_world
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.sensors.reader import pose_of, row_of
from plumbline.harness.sensors.sight import Sight, sight_by_rays
from plumbline.harness.trajectory import Floats, Hits, State, Trajectory

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


def true_scans(scene: Scene, lidar: Lidar, end: float) -> dict[str, Floats]:
    """Streams '<name>/time' (k,), '<name>/range_ideal' and '<name>/intensity_ideal' (k, channels, columns) up to `end` [s].

    Raises:
        TypeError: a shape without a closed form.
    """
    start = State.initial(scene)
    row = row_of(scene, lidar.body, start)
    origins, directions = in_world(lidar, row[:3], row[3:7])
    hits = first_hits(scene, start, origins, directions, lidar.max_range)
    count = int(np.floor(end * lidar.rate + 1e-6)) + 1
    streams: dict[str, Floats] = {f"{lidar.name}/time": np.arange(count) / lidar.rate}
    for name, signal in zip(("range", "intensity"), ideal(lidar, scene, directions, hits), strict=True):
        streams[f"{lidar.name}/{name}_ideal"] = np.broadcast_to(signal, (count, *signal.shape))
    return streams


def seen(scene: Callable[[Any], Scene]) -> Callable[[Floats, Any], Trajectory]:
    """The truth of a case: all bodies at rest, with the streams of the scene's cameras and range finders."""

    def expected(time: Floats, parameters: Any) -> Trajectory:
        stage = scene(parameters)
        truth, streams = Trajectory.at_rest(stage, time), dict[str, Floats]()
        for sensor in stage.sensors:
            if isinstance(sensor, Camera | DepthCamera):
                stamps = stamps_up_to(float(truth.time[-1]), sensor.rate) if len(truth) else truth.time
                streams |= true_frames(stage, sensor, stamps)
            elif isinstance(sensor, Lidar) and len(truth):
                streams |= true_scans(stage, sensor, float(truth.time[-1]))
        return replace(truth, streams=streams)

    return expected
