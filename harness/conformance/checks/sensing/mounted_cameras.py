"""Checks of cameras as they are read on a body that flies and turns: two focal lengths, bounds, noise, by matrices alone."""

from typing import Any

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, firm, near, that, worst
from plumbline.harness.conformance.engine import COARSE, Engine
from plumbline.harness.conformance.room import MOUNT, SIGMAS, in_a_room, mounted, read_on, seen_from
from plumbline.harness.scene import Camera, DepthCamera, StereoNoise, TimeOfFlightNoise
from plumbline.harness.trajectory import Floats, State

_VIEW: dict[str, Any] = {
    "width": 24,
    "height": 18,
    "focal_x": 16.0,
    "focal_y": 11.0,
    "centre_x": 10.5,
    "centre_y": 8.0,
    **MOUNT,
}
"""Two focal lengths, and a centre off the middle."""


def _depths(state: State) -> tuple[Floats, Floats, Floats]:
    """z-depth [m], place in the scene, and share of the range that is depth, of the pixels of `_VIEW`, each (18, 24)."""
    u, v = np.meshgrid((np.arange(24) + 0.5 - 10.5) / 16.0, (np.arange(18) + 0.5 - 8.0) / 11.0)
    rays = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3)
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    origin, axes = mounted(state)
    met = seen_from(origin, rays @ axes.T)
    return (met.distance * rays[:, 2]).reshape(18, 24), met.body.reshape(18, 24), rays[:, 2].reshape(18, 24)


@firm("Do depth cameras read z-depth between their bounds, from where they are mounted?", Feature.RAYS | Feature.BOX)
def depth_camera_reads_between_its_bounds(engine: Engine) -> Comparisons:
    """Two focal lengths, on a body that flies and turns; then the noise of a stereo camera and of one by time of flight."""
    view = {"rate": 1 / (6 * COARSE), **_VIEW}
    wide = {"near": 0.01, "far": 50.0, **view}
    cameras = (
        DepthCamera(name="plain", near=1.5, far=4.5, **view),
        DepthCamera(name="stereo", noise=StereoNoise(baseline=0.1, disparity_sigma=0.05, occlusion=False), **wide),
        DepthCamera(name="flight", noise=TimeOfFlightNoise(range_sigma=0.01, range_sigma_slope=0.02, missing=0.1), **wide),
    )
    scene = in_a_room(*cameras, v_WB=(2.0, -1.5, 1.0), w_WB=(3.0, -4.0, 5.0))
    streams, states = read_on(engine, scene, 6)
    depth, body, ahead = _depths(states[6])
    expected = np.where(depth < 1.5, -np.inf, np.where(depth > 4.5, np.inf, depth))
    got, names = streams["plain/depth"][1], streams["plain/body"][1]
    cut = int((depth < 1.5).sum()), int((depth > 4.5).sum())
    odd = int((names != np.where(expected == np.inf, -1, body)).sum())
    stereo = (1 / streams["stereo/depth"][1] - 1 / depth) * 16.0 * 0.1 / 0.05
    flight = (streams["flight/depth"][1] - depth) / ahead / (0.01 + 0.02 * depth / ahead)
    valid = np.isfinite(flight)
    yield near("stamps [s]", streams["plain/time"], (0.0, 6 * COARSE), 1e-9)
    yield that(min(cut) > 1, f"scene: pixels that see something too near and too far: got {cut}, expected some of both")
    yield worst("z-depths [m]", got, expected, 1e-4, "rounding in single precision; -inf below the bounds, inf beyond")
    yield that(odd == 0, f"bodies: got {odd} pixels of others, expected none; -1 beyond the bounds")
    yield near("spread of disparities, as told 1", np.std(stereo), 1.0, SIGMAS / np.sqrt(2 * stereo.size), "5 sigma")
    yield near("spread by time of flight, as told 1", np.std(flight[valid]), 1.0, SIGMAS / np.sqrt(2 * valid.sum()), "5 sigma")
    yield near("share of pixels missing", 1 - valid.mean(), 0.1, SIGMAS * np.sqrt(0.09 / valid.size), "5 sigma")


@firm("Do pictures have two focal lengths, from where the camera is mounted?", Feature.RENDER | Feature.BOX)
def camera_is_mounted_on_what_turns(engine: Engine) -> Comparisons:
    """The same view as the engine draws it itself, before any step and after six."""
    scene = in_a_room(Camera(name="camera", rate=1 / (6 * COARSE), **_VIEW), v_WB=(2.0, -1.5, 1.0), w_WB=(3.0, -4.0, 5.0))
    streams, states = read_on(engine, scene, 6)
    yield near("stamps [s]", streams["camera/time"], (0.0, 6 * COARSE), 1e-9)
    for frame, state in enumerate((states[0], states[6])):
        depth, body, _ = _depths(state)
        yield worst(f"z-depths of frame {frame} [m]", streams["camera/depth"][frame], depth, 0.02, "depth buffers")
        odd = int((streams["camera/body"][frame] != body).sum())
        yield that(odd == 0, f"bodies of frame {frame}: got {odd} pixels of others, expected none")
