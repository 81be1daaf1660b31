"""MJCF's cameras: those that ride on a body as pinhole cameras where the user asks for their pictures; others are left out.

A camera of MJCF looks along -z with y up and x right, and states a vertical angle of view; a rate it has none.
Source: MuJoCo, "XML reference", body/camera.
"""

import math
from collections.abc import Sequence

import numpy as np

from plumbline.harness.scene import Camera, axis_angle, multiply
from plumbline.harness.scene.importers.companion import Cameras
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.mjcf_model import Model
from plumbline.harness.scene.importers.poses import matrix, quaternion, vector

_FORWARD = axis_angle((1.0, 0.0, 0.0), np.pi)
"""Turns a camera that looks along z with y down into MuJoCo's."""
_NOT_CARRIED = (
    "it shows, and moves nothing; [cameras] of the companion file carries over those that ride on a body, as pinholes"
)


def read(model: Model, names: Sequence[str], asked: Cameras | None) -> tuple[tuple[Camera, ...], list[Fidelity]]:
    """The cameras with their link for a body, and what became of all of them. Args: names: of the links."""
    made: list[Camera] = []
    left: list[str] = []
    for k in range(len(model.cam_mode)):
        name = model.name("camera", k)
        rides = model.word("CamLight", int(model.cam_mode[k])) == "fixed"
        if asked is None or not rides or model.cam_projection[k] != 0 or model.cam_sensorsize[k].any():
            left.append(name)
            continue
        stated = [int(pixels) for pixels in model.cam_resolution[k]]
        width, height = stated if min(stated) > 1 else (asked.width, asked.height)
        focal = height / 2 / math.tan(math.radians(float(model.cam_fovy[k])) / 2)
        made.append(
            Camera(
                name=name,
                body=names[int(model.cam_bodyid[k])],
                rate=asked.rate,
                p_BS=vector(np.array(model.cam_pos[k], dtype=np.float64)),
                q_BS=multiply(quaternion(matrix(model.cam_quat[k])), _FORWARD),
                width=width,
                height=height,
                focal_x=focal,
                focal_y=focal,
                centre_x=width / 2,
                centre_y=height / 2,
            )
        )
    return tuple(made), _rows([camera.name for camera in made], left, asked)


def _rows(made: list[str], left: list[str], asked: Cameras | None) -> list[Fidelity]:
    rows = []
    if made:
        assert asked is not None
        rows += Fidelity.approximated(
            "camera",
            made,
            "a pinhole camera",
            consequence="the file states no rate, and a camera without a resolution has the companion's; read at",
            value=asked.rate,
            unit="Hz",
        )
    if left:
        why = "it follows or aims at a body, or is no plain pinhole; it moves nothing" if asked is not None else _NOT_CARRIED
        rows += Fidelity.left_out("camera", left, why)
    return rows
