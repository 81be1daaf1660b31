"""What cameras saw: the first picture of each, engine beside engine and beside the truth where it is told."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from harness.findings.sensor_readings.findings import Finding
from harness.findings.sensor_readings.picture import Picture
from reports.costs import titled
from reports.pixels import data_uri, shaded, srgb
from reports.text import amount

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["Shot", "Tile", "shots"]

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
    """All pictures of one camera's channel; height, width: of the camera's own, in pixels; scale: what shades mean."""

    case: str
    title: str
    sensor: str
    channel: str
    height: int
    width: int
    scale: str
    tiles: Sequence[Tile]


def shots(store: "Store", found: Iterable[Finding]) -> list[Shot]:
    """One for each camera and channel that was seen."""
    groups: dict[tuple[str, str, str, str], list[Finding]] = {}
    for one in found:
        if one.picture is not None:
            groups.setdefault((one.case, one.where, one.sensor, one.channel), []).append(one)
    return [_shot(store, group) for group in groups.values()]


def _shot(store: "Store", group: Sequence[Finding]) -> Shot:
    first = group[0]
    pictures = [one.picture for one in group if one.picture is not None]
    truth = next((picture.truth for picture in pictures if picture.truth is not None), None)
    low, high = _bounds(pictures, truth) if first.channel == "depth" else (0.0, 1.0)

    def address(pixels: Floats) -> Markup:
        return Markup(data_uri(shaded(pixels, low, high) if first.channel == "depth" else srgb(pixels)))

    tiles = [] if truth is None else [Tile(engine="", tracks=(), what="truth", address=address(truth), trial="")]
    for one, tracks in _alike(group):
        assert one.picture is not None
        same: dict[str, Any] = {"engine": one.engine, "tracks": tracks, "trial": one.trial}
        tiles.append(Tile(**same, what="seen", address=address(one.picture.seen)))
        if truth is None and one.picture.ideal is not None:
            tiles.append(Tile(**same, what="without noise", address=address(one.picture.ideal)))
    return Shot(
        case=first.case,
        title=titled(store, first.case, first.where),
        sensor=first.sensor,
        channel=first.channel,
        height=pictures[0].height,
        width=pictures[0].width,
        scale=f"{amount(low)} m (yellow) to {amount(high)} m (violet)" if first.channel == "depth" else "",
        tiles=tiles,
    )


def _bounds(pictures: Sequence[Picture], truth: Floats | None) -> tuple[float, float]:
    """Nearest and farthest depth [m] of the truth or, without one, of all that was seen without noise; outliers left out."""
    told = [truth] if truth is not None else [p.seen if p.ideal is None else p.ideal for p in pictures]
    finite = np.concatenate([one[np.isfinite(one)].ravel() for one in told])
    if len(finite) == 0:
        return 0.0, 1.0
    low, high = np.percentile(finite, (1.0, 99.0))
    return float(low), float(high)


def _alike(group: Sequence[Finding]) -> list[tuple[Finding, Sequence[str]]]:
    """Engine by engine the pictures that differ, each with the settings under which it was seen."""
    made: list[tuple[Finding, list[str]]] = []
    for one in group:
        twin = next(
            (tracks for other, tracks in made if other.engine == one.engine and _same(other.picture, one.picture)), None
        )
        if twin is None:
            made.append((one, [one.track]))
        else:
            twin.append(one.track)
    return [(one, tuple(tracks)) for one, tracks in made]


def _same(a: Picture | None, b: Picture | None) -> bool:
    return a is not None and b is not None and np.array_equal(a.seen, b.seen, equal_nan=True)
