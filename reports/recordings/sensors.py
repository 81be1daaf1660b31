"""Sensor signals of a case: which there are, and each logged by the file of its kind.

Inertial sensors: each channel as a plot of its three axes, the truth beside the engines.

Range finders: clouds of points in the world, brighter where more light came back.

Cameras: a frustum where each one is, its colour pictures, and depth that stands in space before it.

Colours are sRGB in PNG; depth is metres in single precision, 0 where nothing was measured or where it lies out of bounds (a
viewer leaves such pixels out). A lens is drawn as the pinhole that it distorts.
"""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbline.harness.trajectory.kinematics import rotate
from plumbline.reports.recordings.layout import SENSORS, Floats, Rgba, checked, columns, part
from plumbline.reports.recordings.pixels import srgb
from plumbline.reports.recordings.runs import Source, Stage, extremes, mounted, sources, stride_of

if TYPE_CHECKING:
    import rerun as rr


@dataclass(frozen=True, slots=True)
class CameraView:
    """The pictures of one camera and channel: a title, and by the name of who tells it the path of the picture."""

    title: str
    paths: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Sensed:
    """What a stage has signals for.

    Terms:
        channels, clouds, cameras: paths of inertial signals, scans and cameras, without engine and track. views: pictures.
        notes: what is not shown, in words.
    """

    channels: Sequence[str] = ()
    clouds: Sequence[str] = ()
    cameras: Sequence[str] = ()
    views: Sequence[CameraView] = ()
    notes: Sequence[str] = ()


def sensed(stage: Stage) -> Sensed:
    """The signals of all sensors of a stage."""
    channels, clouds, cameras, views, notes = [], [], [], [], []
    tellers = sources(stage)
    runs = [source for source in tellers if not source.truth]
    for sensor in stage.scene.get("sensors", []):
        name, root = sensor["name"], f"{SENSORS}/{part(sensor['name'])}"
        if sensor["type"] == "imu":
            channels += [f"{root}/{c}" for c in CHANNELS if any(run.signal(name, c) is not None for run in runs)]
        elif sensor["type"] == "lidar":
            clouds += [f"{root}/points"] if any(run.signal(name, "range") is not None for run in runs) else []
        elif sensor["type"] in TYPES:
            shown = _views(sensor, tellers)
            views += shown
            cameras += [camera_path(sensor, "").rstrip("/")] if shown else []
            notes += _notes(sensor, tellers)
    return Sensed(channels, clouds, cameras, views, notes)


def _views(sensor: Mapping[str, Any], tellers: Sequence[Source]) -> list[CameraView]:
    views = []
    for channel in ("colour", "depth"):
        showing = [source for source in tellers if channel in pictured(sensor, source)]
        if showing:
            paths = {source.name: f"{camera_path(sensor, source.path)}/{channel}" for source in showing}
            views.append(CameraView(f"{sensor['name']} {channel}", paths))
    return views


def _notes(sensor: Mapping[str, Any], tellers: Sequence[Source]) -> list[str]:
    counts = [len(source.stamps(sensor["name"])) for source in tellers if pictured(sensor, source)]
    most = max(counts, default=0)
    kept = len(shown_frames(sensor, most)) if most else 0
    return [f"{sensor['name']}: {kept} of {most} pictures are shown, evenly spaced in time."] if kept < most else []


def log_sensors(rec: "rr.RecordingStream", stage: Stage, size: float) -> None:
    """Log the signals of all sensors of a scene.

    Args: size: how far from a camera its picture is drawn [m].
    """
    for sensor in stage.scene.get("sensors", []):
        for source in sources(stage):
            if sensor["type"] == "imu":
                log_inertial(rec, sensor, source, stage.length)
            elif sensor["type"] == "lidar":
                log_scans(rec, stage, sensor, source)
            elif sensor["type"] in TYPES:
                log_camera(rec, stage, sensor, source, size)


CHANNELS = {"accelerometer": "m/s\u00b2", "gyroscope": "rad/s"}
"""Channels of an inertial sensor and their units."""

AXES = "xyz"


def log_inertial(rec: "rr.RecordingStream", sensor: Mapping[str, Any], source: Source, length: float) -> None:
    """Log x, y and z of each channel: the engine's signal, or the ideal one of the truth.

    As other curves, they keep every peak and dip between two frames of the viewer, of a case of this length [s].
    """
    import rerun as rr

    for channel in CHANNELS:
        signal = source.signal(sensor["name"], channel)
        if signal is None:
            continue
        time = source.stamps(sensor["name"])
        known = np.flatnonzero(np.isfinite(signal).all(axis=1) & np.isfinite(time))
        stride = stride_of(time[known], length)
        kept = known[np.unique(np.concatenate([extremes(axis, stride) for axis in signal[known].T]))]
        where = f"{SENSORS}/{part(sensor['name'])}/{channel}/{source.path}"
        checked(where, time[kept])
        names, width = [f"{source.name} {axis}" for axis in AXES], 2.0 if source.truth else 1.0
        rec.log(where, rr.SeriesLines(colors=[source.colour] * 3, names=names, widths=[width] * 3), static=True)
        values = rr.Scalars.columns(scalars=signal[kept].reshape(-1)).partition(np.full(len(kept), 3))
        rec.send_columns(where, columns(time[kept]), values)


DARKEST = 0.25
"""Share of a run's colour that a point without any light keeps."""


def beams(sensor: Mapping[str, Any]) -> Floats:
    """Unit directions of a scan in S, (channels, columns, 3): elevations as given or between the bounds, azimuths over 2 pi."""
    even = np.linspace(sensor["elevation_low"], sensor["elevation_high"], sensor["channels"])
    elevation = np.asarray(sensor.get("elevations") or even)[:, None]
    azimuth = 2.0 * np.pi * np.arange(sensor["columns"])[None, :] / sensor["columns"]
    up = np.broadcast_to(np.sin(elevation), (sensor["channels"], sensor["columns"]))
    return np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), up], axis=-1)


def lit(colour: Rgba, intensity: Floats, brightest: float) -> Floats:
    """Colours (n, 4) uint8 from intensities (n,): dark without light, the run's own at half of the brightest, white at it."""
    share = np.clip(np.nan_to_num(intensity) / brightest if brightest > 0 else np.full(len(intensity), 0.5), 0.0, 1.0)[:, None]
    own = np.asarray(colour[:3], dtype=np.float64)
    below, above = own * (DARKEST + (1 - DARKEST) * 2 * share), own + (255.0 - own) * (2 * share - 1)
    shades = np.rint(np.where(share < 0.5, below, above)).astype(np.uint8)
    return np.concatenate([shades, np.full((len(shades), 1), 255, dtype=np.uint8)], axis=1)


def log_scans(rec: "rr.RecordingStream", stage: Stage, sensor: Mapping[str, Any], source: Source) -> None:
    """Log the points that each scan hit, in W; beams without a return leave none."""
    import rerun as rr

    name = sensor["name"]
    ranges, bright = source.signal(name, "range"), source.signal(name, "intensity")
    if ranges is None:
        return
    time = source.stamps(name)
    points_S = None if source.truth else source.signal(name, "points")
    if points_S is None:
        points_S = np.where(np.isfinite(ranges), ranges, np.nan)[..., None] * beams(sensor)
    known = bright is not None and bright.shape == ranges.shape
    light = bright if bright is not None and known else np.zeros_like(ranges)
    seen = light[np.isfinite(ranges) & np.isfinite(light)]
    brightest = float(np.percentile(seen, 99.0)) if len(seen) else 0.0
    clouds, shades = [], []
    for p, q, cloud, glow in zip(*mounted(stage, sensor, source.arrays, time), points_S, light, strict=True):
        flat = cloud.reshape(-1, 3)
        hit = np.isfinite(flat).all(axis=1)
        clouds.append((p + rotate(np.broadcast_to(q, (int(hit.sum()), 4)), flat[hit])).astype(np.float32))
        shades.append(lit(source.colour, glow.reshape(-1)[hit], brightest))
    where = f"{SENSORS}/{part(name)}/points/{source.path}"
    points, lengths = np.concatenate(clouds), [len(cloud) for cloud in clouds]
    checked(where, time, points)
    rec.log(where, rr.Points3D.from_fields(radii=rr.Radius.ui_points(1.2)), static=True)
    rows = rr.Points3D.columns(positions=points, colors=np.concatenate(shades)).partition(lengths)
    rec.send_columns(where, columns(time), rows)


TYPES = ("camera", "depth_camera")
MOST_PIXELS = 8_000_000
"""Pixels of a channel of one run that a recording keeps: 26 pictures of 640 x 480."""


def camera_path(sensor: Mapping[str, Any], source: str) -> str:
    """Where a camera of an engine and track, or of the truth, is logged; its pictures stand below."""
    return f"{SENSORS}/{part(sensor['name'])}/camera/{source}"


def pictured(sensor: Mapping[str, Any], source: Source) -> list[str]:
    """The channels of a camera that a source has pictures of."""
    return [channel for channel in ("colour", "depth") if source.signal(sensor["name"], channel) is not None]


def shown_frames(sensor: Mapping[str, Any], count: int) -> Floats:
    """The places of the pictures that are kept: all, or evenly spaced ones where they are many or large."""
    most = max(2, MOST_PIXELS // (sensor["width"] * sensor["height"]))
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))


def log_camera(rec: "rr.RecordingStream", stage: Stage, sensor: Mapping[str, Any], source: Source, size: float) -> None:
    """Log a camera and its pictures.

    Args: size: how far from the camera its picture is drawn [m].
    """
    import rerun as rr

    channels, where = pictured(sensor, source), camera_path(sensor, source.path)
    if not channels:
        return
    time = source.stamps(sensor["name"])
    kept = shown_frames(sensor, len(time))
    at = time[kept]
    p_WS, q_WS = mounted(stage, sensor, source.arrays, at)
    checked(where, at, p_WS, q_WS)
    pinhole = rr.Pinhole(
        focal_length=[sensor["focal_x"], sensor["focal_y"]],
        principal_point=[sensor["centre_x"], sensor["centre_y"]],
        resolution=[sensor["width"], sensor["height"]],
        camera_xyz=rr.ViewCoordinates.RDF,
        image_plane_distance=size,
        color=source.colour,
    )
    rec.log(where, pinhole, static=True)
    pose = rr.Transform3D.columns(translation=p_WS.astype(np.float32), quaternion=q_WS[:, [1, 2, 3, 0]].astype(np.float32))
    rec.send_columns(where, columns(at), pose)
    for channel in channels:
        signal = source.signal(sensor["name"], channel)
        assert signal is not None
        log = log_colour if channel == "colour" else log_depth
        log(rec, f"{where}/{channel}", signal[kept], columns(at))


def log_colour(rec: "rr.RecordingStream", where: str, frames: Floats, times: "Sequence[rr.TimeColumn]") -> None:
    """Log linear colours (k, h, w, 3)."""
    import rerun as rr

    rows = rr.EncodedImage.columns(blob=[png(frame) for frame in frames], media_type=["image/png"] * len(frames))
    rec.send_columns(where, times, rows)


def log_depth(rec: "rr.RecordingStream", where: str, frames: Floats, times: "Sequence[rr.TimeColumn]") -> None:
    """Log depth (k, h, w) m."""
    import rerun as rr

    metres = np.where(np.isfinite(frames), frames, 0.0).astype(np.float32)
    seen = metres[metres > 0]
    near, far = np.percentile(seen, (1.0, 99.0)) if len(seen) else (0.0, 1.0)
    look = rr.DepthImage.from_fields(
        meter=1.0, colormap=rr.components.Colormap.Viridis, depth_range=[near, max(far, near + 1e-3)]
    )
    rec.log(where, look, static=True)
    height, width = metres.shape[1:]
    form = rr.components.ImageFormat(width=width, height=height, channel_datatype=rr.ChannelDatatype.F32)
    rows = rr.DepthImage.columns(
        buffer=[np.frombuffer(frame.tobytes(), dtype=np.uint8) for frame in metres], format=[form] * len(metres)
    )
    rec.send_columns(where, times, rows)


def png(linear: Floats) -> bytes:
    """A picture (h, w, 3) of linear light as a PNG in sRGB."""
    from PIL import Image  # late: only recordings with pictures need it

    buffer = io.BytesIO()
    Image.fromarray(srgb(linear)).save(buffer, format="PNG")
    return buffer.getvalue()
