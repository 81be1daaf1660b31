"""What differs between two run folders, as typed rows, and how much each weighs: sentences are made of them in
`harness.findings.changes.words`.
"""

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Literal

ChangeKind = Literal[
    "verdict",
    "error",
    "price",
    "limit",
    "determinism",
    "digest",
    "warning",
    "trials",
    "version",
    "sources",
    "settings",
    "machine",
]
"""What changed: a verdict (the status of a trial); an answer, by its error; a price; a limit; whether repetitions give the same
bits; whether the same digest gives the same answer on another night; what was warned of; which trials there are; an engine's
version; the texts that an answer rests on; what an engine was set to; the machine."""
ANSWERS: tuple[ChangeKind, ...] = ("verdict", "error", "price", "limit", "determinism", "digest")
"""Kinds that say what an engine does: of these a regression can be."""

Sense = Literal["worse", "better", "within tolerance", "neither", "unconfirmed"]
"""Which way: worse and better beyond doubt; an answer of other bits that is as good; a fact that is neither good nor bad; a
price that is dearer beyond its own interval, by timings too unstable to judge by."""

Beside = Literal["", "canary", "other engines"]
"""What a price was divided by, clocked in the same run: '' for no price; a fixed kernel; engines that did not change."""

Value = float | str | None
"""A number in the row's unit, a word (a status, a version, a digest), or None where there was nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """One thing that differs from A to B.

    Terms:
        case, engine, track: '' where it is about all of them. where: parameters that differ from the case's own, in words.
        dt [s]: 0 where it is about several steps. substeps: that B took it in. metric, unit: of before and after.
        trial_a, trial_b: the trials it is read off, '' for none. before, after: in A, in B. ratio: after over before, with its
        95 % interval low..high, None where there is none. beside: what both prices were divided by. count: trials that it
        stands for. detail: what else has to be known of it (a reason, the text of a warning, names of files).
        weight: what rows are sorted by, heaviest first: the whole part says how grave the kind and sense are, the fraction how
        much it is.
    """

    kind: ChangeKind
    sense: Sense
    case: str = ""
    engine: str = ""
    track: str = ""
    where: str = ""
    dt: float = 0.0
    substeps: int = 1
    metric: str = ""
    unit: str = ""
    trial_a: str = ""
    trial_b: str = ""
    before: Value = None
    after: Value = None
    ratio: float | None = None
    low: float | None = None
    high: float | None = None
    beside: Beside = ""
    count: int = 1
    detail: str = ""
    weight: float = 0.0

    @property
    def regression(self) -> bool:
        """Does an engine do worse than before?"""
        return self.sense == "worse" and self.kind in ANSWERS


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedRun:
    """One of the two run folders. Terms: folder: as it was given. study: its name. started: when, as its machine.json says.
    machine: its digest. trials: how many. versions: of engines, by name."""

    folder: str
    study: str
    started: str
    machine: str
    trials: int
    versions: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """How much of what an engine was asked could be judged.

    Terms: answers: with an answer before, so that another or a lost one is told; of all that were asked on both sides. prices:
    of whole runs, stable on both sides; of all that were clocked on both.
    """

    answers: int = 0
    all_answers: int = 0
    prices: int = 0
    all_prices: int = 0

    def __add__(self, other: "Judged") -> "Judged":
        return Judged(**{each.name: getattr(self, each.name) + getattr(other, each.name) for each in fields(Judged)})

    @property
    def share(self) -> float:
        """The lower of the two shares, of those that were asked for; 0 where nothing was."""
        shares = [
            judged / whole for judged, whole in ((self.answers, self.all_answers), (self.prices, self.all_prices)) if whole
        ]
        return min(shares, default=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Changes:
    """All that differs, heaviest first.

    Terms: same: trials of the same bits on both sides; matched: trials on both sides; clocked: prices on both sides. unread:
    what could not be compared, and why. titles: of cases and engines, by name. judged: by engine, how much could be.
    regained, new: trials of B with an answer, whose like in A had lost it; that A was not asked, and no search went on to.
    """

    a: ComparedRun
    b: ComparedRun
    rows: tuple[Change, ...]
    matched: int
    same: int
    clocked: int
    unread: tuple[str, ...] = ()
    titles: Mapping[str, str] = field(default_factory=dict)
    judged: Mapping[str, Judged] = field(default_factory=dict)
    regained: tuple[str, ...] = ()
    new: tuple[str, ...] = ()

    def judged_of(self, engines: Collection[str] = ()) -> Judged:
        """How much could be judged of these engines, or of all."""
        return sum((each for engine, each in self.judged.items() if not engines or engine in engines), Judged())

    def regressions(self, engines: Iterable[str]) -> tuple[Change, ...]:
        """What of these engines is worse than before."""
        gated = set(engines)
        return tuple(row for row in self.rows if row.regression and row.engine in gated)


_GRAVITY: tuple[tuple[ChangeKind, Sense], ...] = (
    ("verdict", "worse"), ("digest", "worse"), ("determinism", "worse"), ("limit", "worse"), ("error", "worse"),
    ("price", "worse"),
    ("verdict", "better"), ("limit", "better"), ("error", "better"), ("price", "better"), ("determinism", "better"),
    ("price", "unconfirmed"),
    ("version", "neither"), ("warning", "worse"), ("warning", "better"), ("warning", "neither"), ("verdict", "neither"),
    ("settings", "neither"), ("error", "neither"), ("sources", "neither"), ("machine", "neither"), ("trials", "neither"),
    ("limit", "within tolerance"), ("error", "within tolerance"), ("limit", "neither"), ("determinism", "neither"),
)  # fmt: skip
"""The gravest first: what is wrong before what is dear, what got worse before what got better, facts about engines before facts
about the run, and what makes no difference last."""


def heaviest_first(rows: Iterable[Change]) -> tuple[Change, ...]:
    """The same rows with their weights, sorted."""
    weighed = (replace(row, weight=len(_GRAVITY) - _GRAVITY.index((row.kind, row.sense)) + _size(row)) for row in rows)
    return tuple(sorted(weighed, key=lambda row: (-row.weight, row.case, row.engine, row.track, row.dt, row.metric)))


def _size(row: Change) -> float:
    """Below 1 and growing with the ratio; 1/2 for a factor of two, and more for what is said of an engine as a whole."""
    by_ratio = abs(math.log2(row.ratio)) if row.ratio is not None and 0 < row.ratio < math.inf else 0.0
    by_count = (math.log2(row.count) / 100 if row.case else 1.0) if row.count > 1 else 0.0
    size = by_ratio + by_count
    return size / (1 + size) * (1 - 1e-9)
