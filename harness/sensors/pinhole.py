"""Pinhole geometry: points to pixels, and pixels to the directions that they look in.

Frame S of a camera looks along +z with x to the right and y down. Pixel coordinates (u, v) are continuous: pixel (column i,
row j) covers i <= u < i + 1, j <= v < j + 1, so that its centre is (i + 0.5, j + 0.5).

Source: Hartley and Zisserman, Multiple View Geometry, 2nd ed., section 6.1.
"""

from typing import Any

import numpy as np

from plumbline.harness.scene import Camera, DepthCamera
from plumbline.harness.sensors.lens import distort, undistort
from plumbline.harness.trajectory import Floats

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
