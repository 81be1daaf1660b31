"""Range finders: clouds of points in the world, brighter where more light came back."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbline.reports.recordings.colour import Rgba
from plumbline.reports.recordings.layout import SENSORS, part
from plumbline.reports.recordings.mounting import mounted
from plumbline.reports.recordings.rotation import Floats, rotate
from plumbline.reports.recordings.runs import Stage
from plumbline.reports.recordings.source import Source
from plumbline.reports.recordings.timeline import checked, columns

if TYPE_CHECKING:
    import rerun as rr

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
