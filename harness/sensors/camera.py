"""Colour camera: the pictures that the engine's own renderer draws of the present state, frame by frame.

Frames of a camera kept in memory while its scene is simulated, within a bound.

Depths are kept in double precision, in which they are judged; colours in single precision, 24 bits a channel where an eye tells
eight, and bodies as 32-bit integers. A trajectory on disk keeps these types.

Pinhole geometry: points to pixels, and pixels to the directions that they look in.

Frame S of a camera looks along +z with x to the right and y down. Pixel coordinates (u, v) are continuous: pixel (column i,
row j) covers i <= u < i + 1, j <= v < j + 1, so that its centre is (i + 0.5, j + 0.5).

Source: Hartley and Zisserman, Multiple View Geometry, 2nd ed., section 6.1.

Brown's lens distortion of normalised image coordinates, and its inverse by Newton's method.

Newton starts from the distorted point itself and stops at a residual of RESIDUAL or of a few roundings of the point, whichever
is larger; for a lens of a few per cent that takes four or five steps. Only the branch on which the map keeps its handedness
belongs to the lens: beyond it a strong polynomial folds the picture back on itself, and no ray comes to such a point.

Source: Brown, Decentering Distortion of Lenses, Photogrammetric Engineering 32 (1966) 444.
"""

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import Camera, DepthCamera, Distortion
from plumbline.harness.sensors.reader import Setting
from plumbline.harness.trajectory import Floats, State

RESIDUAL = 1e-14
"""Greatest distance [1], beside rounding, between a point and the distorted image of what `undistort` gives for it."""
STEPS = 50


def distort(lens: Distortion, points: Floats) -> Floats:
    """Distorted coordinates (..., 2) [1] of normalised ones (..., 2) [1], x to the right and y down; see `Distortion`."""
    x, y = points[..., 0], points[..., 1]
    square = x * x + y * y
    radial = 1.0 + square * (lens.k1 + square * (lens.k2 + square * lens.k3))
    return np.stack(
        [
            x * radial + 2.0 * lens.p1 * x * y + lens.p2 * (square + 2.0 * x * x),
            y * radial + lens.p1 * (square + 2.0 * y * y) + 2.0 * lens.p2 * x * y,
        ],
        axis=-1,
    )


def _slopes(lens: Distortion, points: Floats) -> tuple[Floats, Floats, Floats]:
    """dx'/dx, dx'/dy = dy'/dx and dy'/dy of `distort`."""
    x, y = points[..., 0], points[..., 1]
    square = x * x + y * y
    radial = 1.0 + square * (lens.k1 + square * (lens.k2 + square * lens.k3))
    grows = 2.0 * (lens.k1 + square * (2.0 * lens.k2 + square * 3.0 * lens.k3))
    return (
        radial + x * x * grows + 2.0 * lens.p1 * y + 6.0 * lens.p2 * x,
        x * y * grows + 2.0 * lens.p1 * x + 2.0 * lens.p2 * y,
        radial + y * y * grows + 6.0 * lens.p1 * y + 2.0 * lens.p2 * x,
    )


def undistort(lens: Distortion, points: Floats) -> Floats:
    """The normalised coordinates (..., 2) [1] whose distorted image the given ones (..., 2) [1] are.

    Raises:
        ValueError: no ray that this lens lets through comes to one of the points.
    """
    wanted = np.asarray(points, dtype=np.float64)
    undistorted = wanted.copy()
    allowed = RESIDUAL + 16.0 * np.finfo(np.float64).eps * np.linalg.norm(wanted, axis=-1)
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            missed = distort(lens, undistorted) - wanted
            if (np.linalg.norm(missed, axis=-1) <= allowed).all():
                break
            xx, xy, yy = _slopes(lens, undistorted)
            step = np.stack([yy * missed[..., 0] - xy * missed[..., 1], xx * missed[..., 1] - xy * missed[..., 0]], axis=-1)
            undistorted = undistorted - step / (xx * yy - xy * xy)[..., None]
        missed = distort(lens, undistorted) - wanted
        xx, xy, yy = _slopes(lens, undistorted)
        good = (np.linalg.norm(missed, axis=-1) <= allowed) & (xx * yy - xy * xy > 0.0) & (xx + yy > 0.0)
    if not good.all():
        first = wanted.reshape(-1, 2)[int(np.flatnonzero(~good.ravel())[0])]
        raise ValueError(f"distortion {lens}: no ray comes to the normalised point ({first[0]:g}, {first[1]:g}), expected one")
    return undistorted


VIEW = ("name", "body", "rate", "p_BS", "q_BS", "width", "height", "focal_x", "focal_y", "centre_x", "centre_y")


def view_of(camera: Camera | DepthCamera) -> dict[str, Any]:
    """What both kinds of camera have alike, by field: mounting, rate, size and the lens but for its distortion."""
    return {name: getattr(camera, name) for name in VIEW}


def intrinsics(camera: Camera | DepthCamera) -> Floats:
    """The matrix K with (u, v, 1) ~ K (x, y, z) for points in S, shape (3, 3) [px]."""
    return np.array([[camera.focal_x, 0.0, camera.centre_x], [0.0, camera.focal_y, camera.centre_y], [0.0, 0.0, 1.0]])


def project(camera: Camera | DepthCamera, p_S: Floats) -> Floats:
    """Pixel coordinates (..., 2) [px] of points (..., 3) [m] in S; NaN for what does not lie in front of the camera."""
    p_S = np.asarray(p_S, dtype=np.float64)
    ahead = p_S[..., 2:] > 0
    normalised = np.where(ahead, p_S[..., :2], np.nan) / np.where(ahead, p_S[..., 2:], 1.0)
    if isinstance(camera, Camera) and camera.distortion is not None:
        normalised = distort(camera.distortion, normalised)
    pixels: Floats = normalised * (camera.focal_x, camera.focal_y) + (camera.centre_x, camera.centre_y)
    return pixels


def unproject(camera: Camera | DepthCamera, pixels: Floats) -> Floats:
    """Unit directions (..., 3) in S that pixel coordinates (..., 2) [px] look in.

    Raises:
        ValueError: the lens lets no ray through to one of the pixels.
    """
    normalised = (np.asarray(pixels, dtype=np.float64) - (camera.centre_x, camera.centre_y)) / (camera.focal_x, camera.focal_y)
    if isinstance(camera, Camera) and camera.distortion is not None:
        normalised = undistort(camera.distortion, normalised)
    ahead = np.concatenate([normalised, np.ones_like(normalised[..., :1])], axis=-1)
    directions: Floats = ahead / np.linalg.norm(ahead, axis=-1, keepdims=True)
    return directions


def pixel_centres(camera: Camera | DepthCamera) -> Floats:
    """Pixel coordinates [px] of all pixels' centres, row by row from the top left, (height * width, 2)."""
    u, v = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    return np.stack([u.ravel(), v.ravel()], axis=-1)


def pixel_rays(camera: Camera | DepthCamera) -> Floats:
    """Unit directions in S through all pixels' centres, in the order of `pixel_centres`, (height * width, 3).

    Raises:
        ValueError: as `unproject`.
    """
    return unproject(camera, pixel_centres(camera))


LARGEST = 2**30
"""Bytes that the frames of one camera may take."""


class Pictures:
    """Frames by channel, all frames of a channel alike in shape."""

    def __init__(self, sensor: str) -> None:
        self._sensor, self._bytes = sensor, 0
        self._times: list[float] = []
        self._frames: dict[str, list[NDArray[Any]]] = {}

    def keep(self, time: float, **channels: NDArray[Any]) -> None:
        """Add one frame, taken at `time` [s]; the same channels every time.

        Raises:
            Unsupported: the frames would take more than LARGEST bytes.
        """
        self._bytes += sum(frame.nbytes for frame in channels.values())
        if self._bytes > LARGEST:
            raise Unsupported(
                f"sensor '{self._sensor}': frame {len(self._times) + 1}",
                f"all frames so far take {self._bytes} bytes, expected at most {LARGEST}: fewer pixels, a lower rate",
            )
        self._times.append(time)
        for channel, frame in channels.items():
            self._frames.setdefault(channel, []).append(frame)

    def streams(self) -> dict[str, Floats]:
        """'<sensor>/time' (k,) and '<sensor>/<channel>' (k, ...) of all frames."""
        streams = {f"{self._sensor}/time": np.array(self._times)}
        for channel, frames in self._frames.items():
            # Streams are typed as doubles, which most are; whatever reads these two channels lets NumPy promote them.
            streams[f"{self._sensor}/{channel}"] = cast(Floats, np.array(frames))
        return streams


class CameraReader:
    """Frames '<name>/colour' (k, height, width, 3) linear [1], '<name>/depth' (k, height, width) m along the optical axis, inf
    where nothing is seen, '<name>/body' (k, height, width) place in the scene, -1 for nothing.
    """

    def __init__(self, camera: Camera, setting: Setting, start: State) -> None:  # noqa: ARG002 -- a frame needs no past
        self._camera, self._setting = camera, setting
        self._pictures = Pictures(camera.name)

    def read(self, time: float, state: State) -> None:  # noqa: ARG002 -- the renderer sees the simulation's own state
        """Draw a frame. Raises: Unsupported."""
        image = self._setting.simulation.render(self._camera)
        channels: dict[str, NDArray[Any]] = {"depth": image.depth, "body": image.body.astype(np.int32)}
        if image.colour is not None:
            channels["colour"] = image.colour.astype(np.float32)
        self._pictures.keep(time, **channels)

    def streams(self) -> dict[str, Floats]:
        """All frames so far."""
        return self._pictures.streams()
