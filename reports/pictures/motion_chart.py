"""Series of a case as drawings of a page: the quantity of all runs with the truth and its band, then each engine apart."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.reports.charts.marks import EngineLook
from plumbline.reports.pictures.motion import MotionPicture, RunLine
from plumbline.reports.recordings.layout import Floats
from plumbline.reports.words.text import amount, power

POINTS = 160
"""Most points of a line; of each stretch its smallest and largest value stay."""
MOST_DIGITS = 9
"""Of a label, beyond which it would leave the frame."""
DECADES = 9
"""Most powers of ten of one axis: what lies below is drawn on its lower edge."""


@dataclass(frozen=True, slots=True)
class Stroke:
    """A line. Terms: path: of SVG. colour: '' for the truth's. dashed: the vendor's defaults."""

    path: str
    colour: str
    dashed: bool


@dataclass(frozen=True, slots=True)
class Panel:
    """A frame with its lines, in its own units of length.

    Terms: title: in words. box: left, top, right, bottom of the frame. across, up: (place, label) of ticks. band: a path that
    is filled, '' for none. limit: the place of the bound, or None. alt: in words.
    """

    title: str
    width: int
    height: int
    box: tuple[float, float, float, float]
    across: tuple[tuple[float, str], ...]
    up: tuple[tuple[float, str], ...]
    strokes: tuple[Stroke, ...]
    band: str
    limit: float | None
    alt: str


def overview(motion: MotionPicture, looks: dict[str, EngineLook]) -> Panel:
    """All runs over one another, behind them the truth with the band that its check allows."""
    series = [(line.time, line.values) for line in motion.lines] + ([motion.truth] if len(motion.truth[0]) else [])
    told = motion.truth[1] if len(motion.truth[0]) else None
    low, high = _range([values for _, values in series], told, motion.band)
    scale = _Axes(_end(series), low, high, False, 480, 220, 50)
    strokes = [Stroke(scale.path(*motion.truth), "", False)] if told is not None else []
    strokes += [_stroke(scale, line, line.time, line.values, looks) for line in motion.lines]
    band = scale.band(*motion.truth, motion.band) if told is not None and motion.band else ""
    alt = (
        f"{motion.title} [{motion.unit}] over time [s], {len(motion.lines)} runs{' and the truth' if told is not None else ''}"
    )
    return scale.panel(f"{motion.title} [{motion.unit}]", tuple(strokes), band, None, alt)


@dataclass(frozen=True, slots=True)
class ChartSeries:
    """Values (t,) over times (t,) s, in the colour of an engine. Terms: dashed: the vendor's defaults."""

    time: Floats
    values: Floats
    colour: str
    dashed: bool


def over_time(series: Sequence[ChartSeries], limit: float | None, alt: str, *, width: int, height: int) -> Panel | None:
    """Series on a logarithmic axis, with a bound; None where nothing is above zero. Args: width, height: of the panel."""
    bound = limit if limit is not None and limit > 0 else None
    if not any((line.values > 0).any() for line in series):
        return None
    low, high = _decades([*(line.values for line in series), np.array([bound or 0.0])])
    scale = _Axes(max(float(line.time[-1]) for line in series), low, high, True, width, height, 44)
    strokes = [Stroke(scale.path(line.time, line.values), line.colour, line.dashed) for line in series]
    return scale.panel(alt, tuple(strokes), "", None if bound is None else scale.y(bound), alt)


def apart(motion: MotionPicture, looks: dict[str, EngineLook], titles: dict[str, str]) -> tuple[Panel, ...]:
    """A panel for each engine, on common axes: its distance from the truth, or the quantity itself where none is told."""
    off = bool(motion.off_title)
    values = [line.off if off else line.values for line in motion.lines]
    if off:
        bounds = [line.bound for line in motion.lines if line.bound]
        low, high = _decades([*values, np.array(bounds)])
        if not high:
            return ()
    else:
        low, high = _range(values, None, None)
    end = _end([(line.time, line.values) for line in motion.lines])
    panels = []
    for engine in dict.fromkeys(line.engine for line in motion.lines):
        scale = _Axes(end, low, high, off, 240, 130, 44)
        mine = [line for line in motion.lines if line.engine == engine]
        strokes = [
            _stroke(scale, line, *((line.off_time, line.off) if off else (line.time, line.values)), looks) for line in mine
        ]
        bound = next((line.bound for line in mine if line.bound), None) if off else None
        place = scale.y(bound) if bound is not None and low < bound <= high else None
        told = motion.off_title if off else motion.title
        alt = f"{titles[engine]}: {told[0].lower() + told[1:]} over time"
        panels.append(scale.panel(titles[engine], tuple(strokes), "", place, alt))
    return tuple(panels)


class _Axes:
    """Where values lie in a frame of so many units."""

    def __init__(self, end: float, low: float, high: float, logarithmic: bool, width: int, height: int, left: int) -> None:
        self.end, self.low, self.high, self.logarithmic = end or 1.0, low, high, logarithmic
        self.width, self.height = width, height
        self.box = (float(left), 8.0, width - 8.0, height - 22.0)

    def x(self, time: float) -> float:
        return self.box[0] + (self.box[2] - self.box[0]) * time / self.end

    def y(self, value: float) -> float:
        low, high = self.low, self.high
        if self.logarithmic:
            value, low, high = math.log10(max(value, low)), math.log10(low), math.log10(high)
        share = min(max((value - low) / (high - low), -0.02), 1.02)
        return self.box[3] - (self.box[3] - self.box[1]) * share

    def path(self, time: Floats, values: Floats) -> str:
        """'M..L..' through what is finite of a line, thinned."""
        points = [(self.x(t), self.y(v)) for t, v in zip(*_thinned(time, values), strict=True)]
        return "M" + "L".join(f"{x:.1f},{y:.1f}" for x, y in points) if points else ""

    def band(self, time: Floats, values: Floats, half: float) -> str:
        """The outline of what lies within `half` of a line."""
        t, v = _thinned(time, values)
        if not len(t):
            return ""
        top = [f"{self.x(a):.1f},{self.y(b + half):.1f}" for a, b in zip(t, v, strict=True)]
        low = [f"{self.x(a):.1f},{self.y(b - half):.1f}" for a, b in zip(t[::-1], v[::-1], strict=True)]
        return "M" + "L".join([*top, *low]) + "Z"

    def panel(self, title: str, strokes: tuple[Stroke, ...], band: str, limit: float | None, alt: str) -> Panel:
        """The frame around what was drawn."""
        across = tuple((self.x(t), label) for t, label in labelled(_round_steps(0.0, self.end, 4 if self.width > 300 else 2)))
        if self.logarithmic:
            powers = range(round(math.log10(self.low)), round(math.log10(self.high)) + 1)
            every = max(1, math.ceil(len(powers) / 4))
            up = tuple((self.y(10.0**k), power(k)) for k in powers if (powers[-1] - k) % every == 0)
        else:
            steps = _round_steps(self.low, self.high, 4 if self.height > 150 else 3)
            up = tuple((self.y(v), label) for v, label in labelled(steps))
        return Panel(title, self.width, self.height, self.box, across, up, strokes, band, limit, alt)


def _stroke(scale: _Axes, line: RunLine, time: Floats, values: Floats, looks: dict[str, EngineLook]) -> Stroke:
    return Stroke(scale.path(time, values), looks[line.engine].colour, line.track == "default")


def _thinned(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    kept = np.isfinite(values)
    time, values = time[kept], values[kept]
    if len(time) <= POINTS:
        return time, values
    chosen: set[int] = {0, len(time) - 1}
    for stretch in np.array_split(np.arange(len(time)), POINTS // 2):
        chosen |= {int(stretch[values[stretch].argmin()]), int(stretch[values[stretch].argmax()])}
    places = sorted(chosen)
    return time[places], values[places]


def _end(series: Sequence[tuple[Floats, Floats]]) -> float:
    return max(float(time[-1]) for time, _ in series)


def _range(values: Sequence[Floats], told: Floats | None, band: float | None) -> tuple[float, float]:
    """What the axis holds: the truth and its band where they are told, and of runs what does not dwarf it."""
    finite = [v[np.isfinite(v)] for v in values]
    finite = [v for v in finite if len(v)]
    if not finite:
        return 0.0, 1.0
    low, high = float(min(v.min() for v in finite)), float(max(v.max() for v in finite))
    if told is not None:
        strayed = [max(float(told.min() - v.min()), float(v.max() - told.max())) for v in finite]
        room = max(float(np.ptp(told)), 4 * (band or 0.0), float(np.median(strayed)), 1e-12)
        low, high = max(low, float(told.min()) - 2 * room), min(high, float(told.max()) + 2 * room)
        if band is not None and band < 3 * (high - low):
            low, high = min(low, float(told.min()) - band), max(high, float(told.max()) + band)
    least = 1e-9 + 1e-6 * max(abs(low), abs(high))
    if high - low < least:
        low, high = (low + high - least) / 2, (low + high + least) / 2
    return low - 0.04 * (high - low), high + 0.04 * (high - low)


def _decades(values: Sequence[Floats]) -> tuple[float, float]:
    """Powers of ten around all positive values; (0, 0) where there is none."""
    positive = np.concatenate([v[np.isfinite(v) & (v > 0)] for v in values] or [np.zeros(0)])
    if not len(positive):
        return 0.0, 0.0
    high = math.ceil(math.log10(float(positive.max())) + 1e-9)
    low = max(math.floor(math.log10(float(np.percentile(positive, 2)))), high - DECADES)
    return 10.0 ** min(low, high - 1), 10.0**high


def _round_steps(low: float, high: float, count: int) -> list[float]:
    """Round numbers between two, about so many."""
    rough = (high - low) / count
    decade = 10.0 ** math.floor(math.log10(rough))
    step = next(step * decade for step in (1.0, 2.0, 2.5, 5.0, 10.0) if step * decade >= rough * 0.999)
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


def labelled(steps: Sequence[float]) -> list[tuple[float, str]]:
    """Steps with as many digits as tell them apart and in their place: of 1.38, 1.385 and 1.39 four, three where those do."""
    apart = 1e-3 * (steps[1] - steps[0]) if len(steps) > 1 else math.inf
    digits = next(
        (n for n in range(3, MOST_DIGITS) if all(abs(float(f"{v:.{n - 1}e}") - v) <= apart for v in steps)), MOST_DIGITS
    )
    return [(v, amount(v, digits)) for v in steps]
