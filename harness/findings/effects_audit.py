"""Whether scenes call for exactly the effects that they need, and what leaving the others out saves.

Who says whether a scene needs an effect: the truth of its case, else engines that agree, our own without a vote.

Each engine is a witness on its tuned track: of what leaving an effect out, or taking it in, does to its motion. Where the case
has a motion as its truth, a witness is one that passes as it is and says by how much more it is off the truth then; one is
enough, and ours is asked where nobody else can say. Elsewhere a witness is one that has converged, and at least two that are
not ours have to say the same, and more of them than say the opposite. Where fewer than two such engines were asked, each
speaks for itself, and nobody fails by that.

No witness is an engine that cannot switch the effect. One whose own error hides what another sees does not deny it.
"""

import json
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np

from plumbline.harness.case.alteration import EVERYTHING
from plumbline.harness.case.undropped import called
from plumbline.harness.findings.columns import Cell
from plumbline.harness.search.needless_effects import (
    TWICE,
    Consequence,
    Scale,
    departure,
    matters,
    scale_by_truth,
    scale_in,
    weighed,
)
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store

TRUTH, ALONE = "the truth", "alone"
ENOUGH = 2
"""Engines that have to agree where there is no truth."""
Effects = tuple[str, ...]
Scaled = Callable[[Store, Mapping[str, Any]], Scale | None]


@dataclass(frozen=True, slots=True)
class Matters:
    """Whether an effect matters.

    Terms: matters: None where that is not known. doubt: why it is not. judge: the truth, the names of those that agree, or
    nobody. against: the names of those that say the opposite.
    """

    matters: bool | None
    doubt: str = ""
    judge: str = ""
    against: tuple[str, ...] = ()


NOBODY = Matters(None)


@dataclass(frozen=True, slots=True)
class Word:
    """What one engine says of an effect."""

    consequence: Consequence
    scale: Scale

    @property
    def doubt(self) -> str:
        """Why it does not say whether the effect matters; nothing where it does."""
        return self.consequence.doubt(self.scale)


Words = Mapping[str, Word]


def own_word(store: Store, runs: Mapping[str, Any], run: Any, scale: Scale | None, declared: Collection[str]) -> Word | None:
    """What an engine says of a departure; None where it gave no answer, or cannot switch what the departure is about."""
    departed = departure(run)
    consequence = weighed(departed, matters(store, runs.get(""), run, scale), runs.get(""), run, declared)
    if consequence is None or scale is None:
        return None
    ignored = {notice.effect for trial in (run.trial, runs[""].trial) for notice in store.notices[trial]}
    return None if ignored.intersection(departed.single.names) else Word(consequence, scale)


def heard(
    store: Store, sides: Mapping[str, Mapping[str, Any]], declared: Collection[str], scaled: Scaled
) -> Mapping[Effects, Words]:
    """The words of engines by the effects that they are about.

    Args: sides: an engine's runs by the name of their departure."""
    words: dict[Effects, dict[str, Word]] = {}
    for engine, runs in sides.items():
        scale = scaled(store, runs)
        for run in runs.values() if scale is not None else ():
            if (effects := departure(run).single.names) and (word := own_word(store, runs, run, scale, declared)):
                words.setdefault(effects, {})[engine] = word
    return words


def needs(store: Store, sides: Mapping[str, Mapping[str, Any]], declared: Collection[str]) -> dict[Effects, Matters]:
    """By effects, whether they matter; without those of which each engine speaks for itself."""
    ours = {engine for engine in sides if store.described("engines", engine)["ours"]}
    by_truth, by_steps = (heard(store, sides, declared, scaled) for scaled in (scale_by_truth, scale_in))
    verdicts = {}
    for effects in dict.fromkeys((*by_truth, *by_steps)):
        need = judged(by_truth.get(effects, {}), by_steps.get(effects, {}), ours)
        if need.matters is not None or len(sides.keys() - ours) >= ENOUGH:
            verdicts[effects] = need
    return verdicts


def judged(by_truth: Words, by_steps: Words, ours: Collection[str]) -> Matters:
    """The verdict on one effect. Args: by_truth, by_steps: what engines say by the truth, and by finer steps."""
    others = {engine: word for engine, word in by_truth.items() if engine not in ours}
    witnesses = others if any(word.consequence.matters is not None for word in others.values()) else by_truth
    need = _majority(witnesses, by_truth, 1)
    if need.matters is not None:
        return Matters(need.matters, "", TRUTH, need.against)
    others = {engine: word for engine, word in by_steps.items() if engine not in ours}
    return _majority(others, by_steps, ENOUGH)


def _majority(witnesses: Words, everybody: Words, enough: int) -> Matters:
    """What more of the witnesses say, if they are enough. Args: everybody: with those that have no vote."""
    say = {
        what: {engine: word.consequence for engine, word in everybody.items() if word.consequence.matters is what}
        for what in (True, False)
    }
    # What is smaller than twice an engine's own error, that engine does not see.
    seen = min((c.moved for c in say[True].values()), default=float("inf"))
    say[False] = {engine: c for engine, c in say[False].items() if TWICE * c.own < seen}
    votes = {what: [engine for engine in engines if engine in witnesses] for what, engines in say.items()}
    verdict = len(votes[True]) > len(votes[False])
    if len(votes[verdict]) > len(votes[not verdict]) and len(votes[verdict]) >= enough:
        return Matters(verdict, "", ", ".join(votes[verdict]), tuple(say[not verdict]))
    words = [f"{engine} says that it {'matters' if what else 'does not matter'}" for what in say for engine in votes[what]]
    words += [f"{engine}: {word.doubt}" for engine, word in witnesses.items() if word.doubt]
    few = f"fewer than {enough} engines beside ours can say" if len(votes[verdict]) < enough else "engines disagree"
    return Matters(None, ": ".join([few, "; ".join(words)] if words else [few]))


NOT_JUDGED = "not judged"
AS_IT_IS = "as it is"
AGAINST = ("paid for without need", "needed but missing")
_MATTERS = {True: "matters", False: "does not matter"}
UNANSWERED = ("diverged", "unsupported", "unavailable", "timeout", "oom", "crashed", "interrupted")
"""Statuses that stand as verdicts where a run gave no answer."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectVerdict(Cell):
    """One effect of one scene on one engine, or everything on.

    Terms:
        effects: those that the row is about, several where they were left out together, none for everything on and for the
        scene as it is. effect: what they are called in a table, or what else the row is about. declared: does the scene call
        for it? insists: why it does although its motion does not show it. moved, own: see
        `harness.search.needless_effects.Consequence`; None where nothing could be compared. matters: on this engine. cost: CPU
        time of a step with it over that without it (everything on over as it is), with the 95 % interval of the median over
        blocks; None where one of both was not clocked. cpu_as_it_is: CPU seconds of a simulated second of the scene as it is;
        None where that was not clocked. verdict: 'needed and on', 'needed but missing', 'missing without need', 'paid for
        without need', 'insisted on', 'cannot be switched off', 'left out', 'everything on', 'left out together', 'needed
        together'; NOT_JUDGED where nothing could be compared or nobody can judge; or the status of a run that gave no answer.
        judge: who says so: the truth, engines that agree, or the row's own 'alone'; '' where nobody does. against: the engines
        that say the opposite. reason: what the engine says to it, or why it is not judged. trial: of the departure.
    """

    effect: str
    effects: tuple[str, ...]
    declared: bool
    insists: str
    moved: float | None
    own: float | None
    matters: bool | None
    cost: Interval | None
    cpu_as_it_is: float | None
    verdict: str
    judge: str
    against: str
    reason: str
    trial: str


@dataclass(frozen=True, slots=True)
class Audit:
    """Whether each scene calls for exactly what it needs.

    Terms:
        judged: a row for each effect of each scene of which something is said. failed: those of them that are against the
        scene: an effect that does not matter is on, or one that matters is off. open: rows of effects of which nothing is
        said: for these nothing is proposed.
    """

    judged: tuple[EffectVerdict, ...]
    failed: tuple[EffectVerdict, ...]
    open: tuple[EffectVerdict, ...] = ()

    @property
    def scenes(self) -> int:
        """How many were judged, each of their effects."""
        return len(scenes_of(self.judged).keys() - scenes_of(self.open).keys())

    @property
    def clean(self) -> int:
        """How many of these have nothing against them."""
        return len(scenes_of(self.judged).keys() - scenes_of(self.open).keys() - scenes_of(self.failed).keys())

    @property
    def in_doubt(self) -> int:
        """How many were asked about and not judged in full."""
        return len(scenes_of(self.open))

    def sentences(self, titles: Mapping[str, str] | None = None) -> list[str]:
        """What is against the scenes, a sentence each. Args: titles: of cases, by name; without them names stand."""
        return [_accusation(row, titles or {}) for row in self.failed]

    def judges(self, titles: Mapping[str, str] | None = None) -> str:
        """How many effects the truth judged, how many engines that agree, and how many one engine alone."""
        spoken, by = titles or {}, dict[str, int]()
        for row in self.judged:
            alone = row.judge.endswith(f" {ALONE}")
            name = row.judge.removesuffix(f" {ALONE}")
            who = f"{spoken.get(name, name)} {ALONE}" if alone else TRUTH if name == TRUTH else "engines that agree"
            by[who] = by.get(who, 0) + 1
        counts = ", ".join(f"{count} by {who}" for who, count in by.items())
        return f"Effects are judged: {counts}" if len(by) > 1 else f"Judged by {next(iter(by), 'nobody')}"

    def dissent(self, titles: Mapping[str, str] | None = None) -> list[str]:
        """Where engines say the opposite of what is judged, a sentence each. Args: titles: of cases and engines, by name."""
        spoken = titles or {}

        def named(engines: str) -> str:
            return ", ".join(spoken.get(name, name) for name in engines.split(", "))

        return [
            f"{named_scene(row, spoken)}: {_spelled(row.effect)} {_MATTERS['needed' in row.verdict]} by "
            f"{named(row.judge)}; {named(row.against)} would have it otherwise"
            for row in self.judged
            if row.against
        ]

    @property
    def gating(self) -> "Audit":
        """What nobody says alone: another engine that speaks for itself may see worse than several, and gates nothing."""
        return Audit(self.judged, tuple(row for row in self.failed if not row.judge.endswith(f" {ALONE}")), self.open)

    def doubts(self, titles: Mapping[str, str] | None = None) -> list[str]:
        """What could not be judged and why, a sentence for each scene and reason.

        Args: titles: of cases and engines, by name; without them names stand."""
        known = titles or {}
        effects: dict[tuple[str, str], list[str]] = {}
        for row in self.open:
            why = row.reason or "no answer to compare"
            why = why if row.verdict == NOT_JUDGED else f"{known.get(row.engine, row.engine)}: {row.verdict}: {why}"
            what = "any effect" if row.effect == AS_IT_IS else _spelled(row.effect)
            effects.setdefault((named_scene(row, known), why), []).append(what)
        return [f"{scene}: nothing is said of {', '.join(names)}: {reason}" for (scene, reason), names in effects.items()]


def audit(rows: Sequence[EffectVerdict]) -> Audit:
    """Of the rows of the table of effects: of each effect of a scene that of one that judges it, where there is one."""
    asked = [row for row in rows if row.track == "tuned" and row.effect != EVERYTHING and not _lacked(row)]
    chosen: dict[tuple[str, str, str], EffectVerdict] = {}
    for row in sorted(asked, key=_far_from_judging):
        chosen.setdefault((row.case, row.where, row.effect), row)
    taken = {id(row) for row in chosen.values()}
    judged = tuple(row for row in asked if id(row) in taken and not _silent(row))
    answered = scenes_of(judged)
    silent = (row for row in asked if id(row) in taken and _silent(row))
    # That one engine gives no answer at all is nothing where others do.
    unknown = tuple(row for row in silent if row.effect != AS_IT_IS or (row.case, row.where) not in answered)
    return Audit(judged, tuple(row for row in judged if row.verdict in AGAINST), unknown)


def _silent(row: EffectVerdict) -> bool:
    return row.verdict in (NOT_JUDGED, *UNANSWERED)


def _lacked(row: EffectVerdict) -> bool:
    """Is it about an effect that the scene calls for and the engine has not? That is nothing against the scene."""
    return (bool(row.declared) and "missing" in row.verdict) or row.verdict == "cannot be switched off"


def _far_from_judging(row: EffectVerdict) -> int:
    """0 for a row whose engine is among those that judge, 1 where the truth does or another one, 2 where nobody does."""
    return 2 if _silent(row) else int(row.engine not in row.judge.removesuffix(f" {ALONE}").split(", "))


def scenes_of(rows: Iterable[EffectVerdict]) -> dict[tuple[str, str], None]:
    """The scenes of some rows, in their order."""
    return dict.fromkeys((row.case, row.where) for row in rows)


def named_scene(row: EffectVerdict, titles: Mapping[str, str] | None = None) -> str:
    """The scene of a row: its case, and where it stands beside it. Args: titles: of cases, by name."""
    return f"{(titles or {}).get(row.case) or called(row.case)} {row.where}".strip()


def _spelled(effect: str) -> str:
    return effect.replace("_", " ")


def _accusation(row: EffectVerdict, titles: Mapping[str, str]) -> str:
    name, effect = named_scene(row, titles), _spelled(row.effect)
    alone = f", by {titles.get(row.engine, row.engine)} {ALONE}" if row.judge.endswith(f" {ALONE}") else ""
    if row.verdict == "needed but missing":
        return f"{name}: leaves out {effect}, which matters: with it a body is moved by {_metres(row.moved)}{alone}"
    return (
        f"{name}: declares {effect}, which does not matter: without it no body is moved by more than "
        f"{_metres(row.moved)}, half the step moves one by {_metres(row.own)}{alone}"
    )


def _metres(value: float | None) -> str:
    return "nothing" if value is None else f"{value:.2g} m or rad"


@dataclass(frozen=True, slots=True)
class Saving:
    """What everything on costs over the scene as it is, on one engine.

    Terms:
        mean, low, high: geometric mean, smallest and largest over so many scenes. summed: the time of a simulated second of
        each of these scenes, added up, with everything on over as it is; None where no step was clocked.
    """

    engine: str
    mean: float
    low: float
    high: float
    scenes: int
    summed: float | None


def savings(rows: Iterable[EffectVerdict]) -> list[Saving]:
    """One an engine."""
    made = []
    everything = (row for row in rows if row.verdict == EVERYTHING and row.cost is not None)
    for engine, mine in grouped(everything, attrgetter("engine")).items():
        costs = [row.cost.value for row in mine if row.cost is not None]
        mean = math.exp(float(np.mean(np.log(costs))))
        both = [(cost, row.cpu_as_it_is) for cost, row in zip(costs, mine, strict=True) if row.cpu_as_it_is]
        whole = sum(second for _, second in both)
        summed = sum(cost * second for cost, second in both) / whole if whole else None
        made.append(Saving(engine, mean, min(costs), max(costs), len(costs), summed))
    return made


def idle(scene: tuple[str, str], rows: Sequence[EffectVerdict]) -> list[str]:
    """The effects that a scene can do without, all together; none where nothing is known to be idle."""
    mine = [row for row in rows if (row.case, row.where) == scene]
    without = (row.effects for row in mine if row.verdict in ("left out together", "paid for without need"))
    return [*max(without, key=len, default=())]


def proposed(scene: tuple[str, str], rows: Sequence[EffectVerdict]) -> str:
    """The minimal set of a scene that declares too much, as the line that its file needs; '' where nothing is known to be."""
    without = idle(scene, rows)
    name = " ".join((called(scene[0]), scene[1])).strip()
    return f"Proposed for {name}: narrow = {json.dumps(without)}." if without else ""
