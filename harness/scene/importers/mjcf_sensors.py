"""MJCF's sensors and cameras: inertial units, range finders as single beams, pinholes if asked for; the others are left out.

MuJoCo reads its sensors at every step, whatever the step is; here they are read RATE times a second. The noise that a file
states is left out by MuJoCo itself, and here. A camera of MJCF looks along -z with y up and x right, and states a vertical
angle of view; a rate it has none. Source: MuJoCo, "XML reference", body/camera.
"""

import math
from collections.abc import Sequence

import numpy as np

from plumbline.harness.scene import Camera, Imu, Lidar, Sensor, axis_angle, multiply
from plumbline.harness.scene.importers.companion import Cameras
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.mjcf_model import Model
from plumbline.harness.scene.importers.poses import matrix, quaternion, vector

RATE = 240.0
"""Readings a second: one each coarsest step of a run of one's own scene."""
FARTHEST = 100.0
"""How far a range finder reaches whose file does not say [m]."""
_INERTIAL = ("accelerometer", "gyro")
_ALONG_Z = axis_angle((0.0, 1.0, 0.0), -np.pi / 2)
"""Turns the first beam of a range finder, x, into MuJoCo's, the site's z."""


def read(model: Model, names: Sequence[str]) -> tuple[tuple[Sensor, ...], list[Fidelity]]:
    """The sensors with the link of their site for a body, and what became of all of them. Args: names: of the links."""
    sensors: list[Sensor] = []
    units: dict[int, str] = {}
    beams: list[str] = []
    others: dict[str, list[str]] = {}
    for k, raw in enumerate(model.sensor_type):
        word, name, site = model.word("Sensor", int(raw)), model.name("sensor", k), int(model.sensor_objid[k])
        at_site = model.word("Obj", int(model.sensor_objtype[k])) == "site" and site >= 0
        if word in _INERTIAL and at_site:
            units.setdefault(site, name)
        elif word == "rangefinder" and at_site:
            beams.append(name)
            reach = float(model.sensor_cutoff[k]) or FARTHEST
            link, p, q = _mount(model, site, names)
            turned = multiply(q, _ALONG_Z)
            sensors.append(
                Lidar(
                    name=name,
                    body=link,
                    rate=RATE,
                    p_BS=p,
                    q_BS=turned,
                    channels=1,
                    columns=1,
                    elevation_low=0.0,
                    elevation_high=0.0,
                    max_range=reach,
                )
            )
        else:
            others.setdefault(word, []).append(name)
    for site, name in units.items():
        link, p, q = _mount(model, site, names)
        sensors.append(Imu(name=name, body=link, rate=RATE, p_BS=p, q_BS=q))
    return tuple(sensors), _rows(list(units.values()), beams, others)


def _mount(
    model: Model, site: int, names: Sequence[str]
) -> tuple[str, tuple[float, float, float], tuple[float, float, float, float]]:
    return (
        names[int(model.site_bodyid[site])],
        vector(np.array(model.site_pos[site], dtype=np.float64)),
        quaternion(matrix(model.site_quat[site])),
    )


def _rows(units: list[str], beams: list[str], others: dict[str, list[str]]) -> list[Fidelity]:
    rows = []
    for names, becomes in ((units, "an inertial unit without noise"), (beams, "a range finder of one beam")):
        if names:
            rows += Fidelity.approximated(
                "sensor",
                names,
                becomes,
                consequence="MuJoCo reads it at every step; here it is read at a rate of",
                value=RATE,
                unit="Hz",
            )
    for word, names in others.items():
        rows += Fidelity.left_out(f"sensor {word}", names, "it measures, and moves nothing")
    return rows


_FORWARD = axis_angle((1.0, 0.0, 0.0), np.pi)
"""Turns a camera that looks along z with y down into MuJoCo's."""
_NOT_CARRIED = (
    "it shows, and moves nothing; [cameras] of the companion file carries over those that ride on a body, as pinholes"
)


def cameras(model: Model, names: Sequence[str], asked: Cameras | None) -> tuple[tuple[Camera, ...], list[Fidelity]]:
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
    return tuple(made), _camera_rows([camera.name for camera in made], left, asked)


def _camera_rows(made: list[str], left: list[str], asked: Cameras | None) -> list[Fidelity]:
    rows = []
    if made:
        assert asked is not None
        rows += Fidelity.told("camera", made, asked.rate)
    if left:
        why = "it follows or aims at a body, or is no plain pinhole; it moves nothing" if asked is not None else _NOT_CARRIED
        rows += Fidelity.left_out("camera", left, why)
    return rows
