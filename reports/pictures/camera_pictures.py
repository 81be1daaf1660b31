"""What cameras saw: the first picture of each, engine beside engine and beside the truth where it is told."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from plumbline.harness.findings.sensor_readings.findings import SensorFinding
from plumbline.harness.findings.sensor_readings.ideal import CameraPicture
from plumbline.harness.store.store import Store
from plumbline.reports.charts.ideal_signals import reading
from plumbline.reports.recordings.pixels import data_uri, shaded, srgb
from plumbline.reports.words.catalogue import titled
from plumbline.reports.words.text import amount

Floats = NDArray[np.floating]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tile:
    """One picture: of an engine under these settings, or of the truth where engine is ''. what: 'truth', 'seen', or 'without
    noise', which stands in for a truth that is not told. address: of a PNG that holds itself, safe as it is."""

    engine: str
    tracks: Sequence[str]
    what: str
    address: Markup
    trial: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """All pictures of one camera's channel; height, width: of the camera's own, in pixels; scale: what shades mean;
    reading: what the camera reads, in words."""

    case: str
    title: str
    reading: str
    height: int
    width: int
    scale: str
    tiles: Sequence[Tile]


def shots(store: Store, findings: Iterable[SensorFinding]) -> list[Shot]:
    """One for each camera and channel that was seen."""
    groups: dict[tuple[str, str, str, str], list[SensorFinding]] = {}
    for finding in findings:
        if finding.picture is not None:
            groups.setdefault((finding.case, finding.where, finding.sensor, finding.channel), []).append(finding)
    return [_shot(store, group) for group in groups.values()]


def _shot(store: Store, group: Sequence[SensorFinding]) -> Shot:
    first = group[0]
    pictures = [finding.picture for finding in group if finding.picture is not None]
    truth = next((picture.truth for picture in pictures if picture.truth is not None), None)
    low, high = _bounds(pictures, truth) if first.channel == "depth" else (0.0, 1.0)

    def address(pixels: Floats) -> Markup:
        return Markup(data_uri(shaded(pixels, low, high) if first.channel == "depth" else srgb(pixels)))

    tiles = [] if truth is None else [Tile(engine="", tracks=(), what="truth", address=address(truth), trial="")]
    for finding, tracks in _alike(group):
        assert finding.picture is not None
        same: dict[str, Any] = {"engine": finding.engine, "tracks": tracks, "trial": finding.trial}
        tiles.append(Tile(**same, what="seen", address=address(finding.picture.seen)))
        if truth is None and finding.picture.ideal is not None:
            tiles.append(Tile(**same, what="without noise", address=address(finding.picture.ideal)))
    return Shot(
        case=first.case,
        title=titled(store, first.case, first.where),
        reading=reading(first),
        height=pictures[0].height,
        width=pictures[0].width,
        scale=f"{amount(low)} m (yellow) to {amount(high)} m (violet)" if first.channel == "depth" else "",
        tiles=tiles,
    )


def _bounds(pictures: Sequence[CameraPicture], truth: Floats | None) -> tuple[float, float]:
    """Nearest and farthest depth [m] of the truth or, without one, of all that was seen without noise; outliers left out."""
    depths = [truth] if truth is not None else [p.seen if p.ideal is None else p.ideal for p in pictures]
    finite = np.concatenate([depth[np.isfinite(depth)].ravel() for depth in depths])
    if len(finite) == 0:
        return 0.0, 1.0
    low, high = np.percentile(finite, (1.0, 99.0))
    return float(low), float(high)


def _alike(group: Sequence[SensorFinding]) -> list[tuple[SensorFinding, Sequence[str]]]:
    """Engine by engine the pictures that differ, each with the settings under which it was seen."""
    made: list[tuple[SensorFinding, list[str]]] = []
    for finding in group:
        twin = next(
            (tracks for other, tracks in made if other.engine == finding.engine and _same(other.picture, finding.picture)), None
        )
        if twin is None:
            made.append((finding, [finding.track]))
        else:
            twin.append(finding.track)
    return [(finding, tuple(tracks)) for finding, tracks in made]


def _same(a: CameraPicture | None, b: CameraPicture | None) -> bool:
    return a is not None and b is not None and np.array_equal(a.seen, b.seen, equal_nan=True)
