"""SDF's sensors: inertial units, lidars and cameras without their noise; the others are left out.

A camera of SDF looks along +x with y left and z up; a scene's along +z with x right and y down.
Source: Open Robotics, SDFormat Specification, <sensor>.
"""

import math

import numpy as np

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import readable
from plumbline.harness.scene import Camera, DepthCamera, Imu, Lidar, Sensor
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.poses import Pose, quaternion, vector
from plumbline.harness.scene.importers.sdf_grammar import number, numbers
from plumbline.harness.scene.importers.xml_text import Element

RATE = 240.0
"""Readings a second of a sensor that is read at every step, as one without a rate is: one each coarsest step of a run."""
_LOOKS = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""The axes of a scene's camera in SDF's, as columns."""
_CAMERAS = ("camera", "depth_camera", "depth")
_LIDARS = ("gpu_lidar", "lidar", "ray", "gpu_ray")


class Sensors:
    """Reads one sensor after the other, and keeps what is to be said of them all."""

    def __init__(self) -> None:
        self._rows: dict[tuple[str, str], list[str]] = {}

    def of(self, element: Element, link: str, prefix: str, X_LS: Pose) -> Sensor | None:
        """The sensor on a link, or None. Raises: RobotError."""
        kind, name = element.attributes.get("type", ""), prefix + element.attributes.get("name", f"sensor line {element.line}")
        stated = number(element, "update_rate", 0.0)
        rate = stated if stated > 0 else RATE
        if kind not in ("imu", *_LIDARS, *_CAMERAS):
            self._rows.setdefault((kind, "left_out"), []).append(name)
            return None
        try:
            if kind == "imu":
                sensor: Sensor = Imu(name=name, body=link, rate=rate, p_BS=vector(X_LS.p), q_BS=quaternion(X_LS.R))
            elif kind in _LIDARS:
                sensor = self._lidar(element, kind, name, link, rate, X_LS)
            else:
                sensor = _camera(element, kind, name, link, rate, X_LS)
        except (ValueError, ArithmeticError) as error:
            if isinstance(error, RobotError):
                raise
            raise element.refuse(readable(f"is no sensor of a scene: {error}", 300)) from None
        self._rows.setdefault((kind, "without its noise"), []).append(name)
        if stated <= 0:
            self._rows.setdefault((kind, "its rate"), []).append(name)
        return sensor

    def _lidar(self, element: Element, kind: str, name: str, link: str, rate: float, X_LS: Pose) -> Lidar:
        stated = next((child for tag in ("lidar", "ray") if (child := element.first(tag)) is not None), None)
        scan = None if stated is None else stated.first("scan")
        across, up = (None if scan is None else scan.first(tag) for tag in ("horizontal", "vertical"))
        low, high = (number(across, tag, default) for tag, default in (("min_angle", -math.pi), ("max_angle", math.pi)))
        samples = max(1, round(number(across, "samples", 640)))
        # A scene's beams go all the way round: as many as keep the file's spacing.
        whole = high - low >= 2 * math.pi * (1 - 1 / max(2, samples)) - 1e-6
        columns = samples if whole or high <= low else max(1, round((samples - 1) * 2 * math.pi / (high - low)))
        if not whole:
            self._rows.setdefault((kind, "all the way round"), []).append(name)
        bounds = None if stated is None else stated.first("range")
        channels = max(1, round(number(up, "samples", 1)))
        return Lidar(
            name=name, body=link, rate=rate, p_BS=vector(X_LS.p), q_BS=quaternion(X_LS.R), channels=channels,
            columns=min(columns, 65536), elevation_low=number(up, "min_angle", 0.0),
            elevation_high=number(up, "max_angle", 0.0), min_range=max(0.0, number(bounds, "min", 0.0)),
            max_range=_finite(bounds, "max", 100.0),
        )  # fmt: skip

    def rows(self) -> list[Fidelity]:
        """What became of the sensors."""
        rows = []
        for (kind, fate), names in self._rows.items():
            element = f"sensor {kind}"
            if fate == "left_out":
                rows += Fidelity.left_out(element, names, "it measures, and moves nothing")
            elif fate == "its rate":
                words = "the file states no rate; it is read at one of"
                rows += Fidelity.approximated(element, names, "a rate", consequence=words, value=RATE, unit="Hz")
            elif fate == "all the way round":
                words = "the file's lidar looks one way; beams are as far apart, and go all the way round"
                rows += Fidelity.approximated(element, names, "more beams", consequence=words)
            else:
                words = "the file's noise is not read; [[sensors]] of the companion file states one"
                rows += Fidelity.approximated(element, names, "an ideal sensor", consequence=words)
        return rows


def _finite(element: Element | None, tag: str, default: float) -> float:
    """A number that may be infinite in the file."""
    value = None if element is None else numbers(element, tag, infinite=True)
    return default if value is None or not math.isfinite(value[0]) else value[0]


def _camera(element: Element, kind: str, name: str, link: str, rate: float, X_LS: Pose) -> Camera | DepthCamera:
    stated = element.first("camera")
    image, clip = (None if stated is None else stated.first(tag) for tag in ("image", "clip"))
    width, height = (max(1, round(number(image, tag, default))) for tag, default in (("width", 320), ("height", 240)))
    focal = width / 2 / math.tan(number(stated, "horizontal_fov", 1.047) / 2)
    of = {
        "name": name, "body": link, "rate": rate, "p_BS": vector(X_LS.p), "q_BS": quaternion(X_LS.R @ _LOOKS),
        "width": width, "height": height, "focal_x": focal, "focal_y": focal, "centre_x": width / 2, "centre_y": height / 2,
    }  # fmt: skip
    if kind == "camera":
        return Camera(**of)  # type: ignore[arg-type]
    return DepthCamera(**of, near=number(clip, "near", 0.1), far=_finite(clip, "far", 100.0))  # type: ignore[arg-type]
