"""Cameras: a frustum where each one is, its colour pictures, and depth that stands in space before it.

Colours are sRGB in PNG; depth is metres in single precision, 0 where nothing was measured or where it lies out of bounds (a
viewer leaves such pixels out). A lens is drawn as the pinhole that it distorts.
"""

import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbline.reports.recordings.layout import SENSORS, part
from plumbline.reports.recordings.mounting import mounted
from plumbline.reports.recordings.pixels import srgb
from plumbline.reports.recordings.rotation import Floats
from plumbline.reports.recordings.runs import Stage
from plumbline.reports.recordings.source import Source
from plumbline.reports.recordings.timeline import checked, columns

if TYPE_CHECKING:
    import rerun as rr

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
