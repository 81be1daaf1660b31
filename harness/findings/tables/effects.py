"""What each effect costs, what its absence does, whether it was needed, and so whether scenes call for exactly the effects that
they need, and what leaving the others out saves."""

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np
import pandas as pd

from plumbline.harness.case.alteration import EVERYTHING, REFINED
from plumbline.harness.case.undropped import called
from plumbline.harness.findings.columns import Cell, Column, Table, bracketed, known, names, outcome, side
from plumbline.harness.findings.cost_point import BlockSample, SampledBlock, ratio_in_blocks, samples_by_block
from plumbline.harness.findings.once import all_once
from plumbline.harness.findings.parameter_words import differing, in_words
from plumbline.harness.search.needless_effects import Consequence, Scale, departure, matters, scale_in, weighed
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store

JUDGE = "reference"
"""The engine that can leave every effect out: what is needed is decided on it, where it was asked and has converged."""
NOT_JUDGED = "not judged"
AS_IT_IS = "as it is"
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
        together'; NOT_JUDGED where nothing could be compared or who judges has not converged in this scene; or the status of a
        run that gave no answer. reason: what the engine says to it, or why it is not judged. trial: of the departure.
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
    reason: str
    trial: str


def verdicts_if_described(store: Store) -> tuple[EffectVerdict, ...]:
    """The same for pages that are not about effects alone: none where the folder has lost the catalogue, which says what
    scenes call for."""
    return verdicts(store) if store.catalogue else ()


@all_once
def verdicts(store: Store) -> Iterator[EffectVerdict]:
    """All rows of a run."""
    trials = store.trials
    trials = trials.assign(departure=[json.loads(text).get("name", "") for text in trials["alteration"]])
    altered = set(trials.loc[trials["departure"] == EVERYTHING, "experiment"])
    chosen = trials[trials["experiment"].isin(altered) & (trials["members"] == 1)]
    samples = samples_by_block(store)
    for case, cells in chosen.groupby("case", sort=False):
        named = _where(cells["parameters"], store.described("cases", str(case))["parameters"])
        for parameters, scenes in cells.groupby("parameters", sort=False):
            needed = _needed(store, scenes)
            for (engine, track), group in scenes.groupby(["engine", "track"], sort=False):
                yield from _of_side(store, str(engine), str(track), named[str(parameters)], group, needed, samples)


Sampled = Mapping[str, Mapping[SampledBlock, BlockSample]]


def _where(parameters: Iterable[str], own: Mapping[str, Any]) -> dict[str, str]:
    """By parameters (JSON) of a case, what tells them apart and from the case as it is, in words."""
    read = {text: json.loads(text) for text in dict.fromkeys(parameters)}
    loose = sorted(differing(read.values(), own))
    return {text: in_words({name: values[name] for name in loose if name in values}) for text, values in read.items()}


def _runs(group: pd.DataFrame) -> dict[str, Any]:
    """A side's runs by the name of their departure."""
    return {row.departure: row for row in group.itertuples()}


@dataclass(frozen=True, slots=True)
class _Need:
    """Whether an effect matters, None where that is not known, and why it is not."""

    matters: bool | None
    doubt: str = ""


def _need(engine: str, consequence: Consequence | None, scale: Scale | None) -> _Need:
    if consequence is None or scale is None:
        return _Need(None)
    return _Need(consequence.matters, f"{engine}: {doubt}" if (doubt := consequence.doubt(scale)) else "")


def _needed(store: Store, scenes: pd.DataFrame) -> dict[str, _Need]:
    """By effect, whether it matters on the judge's tuned track; empty where the judge was not asked."""
    runs = _runs(scenes[(scenes["engine"] == JUDGE) & (scenes["track"] == "tuned")])
    declared = store.described("cases", scenes["case"].iloc[0])["effects"]
    scale, needs = scale_in(store, runs), {}
    for run in runs.values():
        departed = departure(run)
        effects = departed.single.names
        consequence = matters(store, runs.get(""), run, scale) if len(effects) == 1 else None
        consequence = weighed(departed, consequence, runs.get(""), run, declared)
        if consequence is not None and scale is not None:
            needs[effects[0]] = _need(JUDGE, consequence, scale)
    return needs


def _of_side(
    store: Store,
    engine: str,
    track: str,
    where: str,
    group: pd.DataFrame,
    needed: Mapping[str, _Need],
    samples: Sampled,
) -> Iterator[EffectVerdict]:
    runs = _runs(group)
    plain = runs.get("")
    if plain is None:
        return
    cell = {"case": plain.case, "where": where, "engine": engine, "track": track}
    about = store.described("cases", plain.case)
    declared, insists = set(about["effects"]), about.get("insists", {})
    scale = scale_in(store, runs)
    notices = [notice for notice in store.notices[plain.trial] if notice.effect]

    def row(
        subject: str | tuple[str, ...],
        run: Any,
        consequence: Consequence | None,
        verdict: str,
        price: Interval | None,
        reason: str = "",
    ) -> EffectVerdict:
        effects = () if isinstance(subject, str) else subject
        return EffectVerdict(
            **cell,
            effect=subject if isinstance(subject, str) else ", ".join(subject),
            effects=effects,
            declared=declared.issuperset(effects) and bool(effects),
            insists=str(insists.get(effects[0], "")) if len(effects) == 1 else "",
            cost=price,
            cpu_as_it_is=None if pd.isna(plain.cpu_per_sim_s) else float(plain.cpu_per_sim_s),
            verdict=verdict,
            reason=reason,
            trial=str(run.trial),
            **known(consequence, "moved", "own", "matters"),
        )

    if plain.status not in ("passed", "failed"):
        yield row(AS_IT_IS, plain, None, plain.status, None, plain.reason)
        return
    surplus, missing = (
        {notice.effect: notice.text for notice in notices if notice.kind == kind} for kind in ("surplus", "missing")
    )
    for name, run in runs.items():
        departed = departure(run)
        effects = departed.single.names
        if name in ("", *REFINED) or (departed.widen and effects[0] in surplus):
            continue  # what cannot be switched off is told by its notice, below
        if run.status in ("unsupported", "unavailable", "timeout", "oom", "crashed"):
            yield row(effects or name, run, None, run.status, None, run.reason)
            continue
        consequence = weighed(departed, matters(store, plain, run, scale), plain, run, declared)
        if name == EVERYTHING:
            yield row(name, run, consequence, name, _price(run, plain, samples))
            continue
        taken_in = bool(departed.widen)
        price = _price(run, plain, samples) if taken_in else _price(plain, run, samples)
        own = _need(engine, consequence, scale)
        if len(effects) > 1:
            verdict = NOT_JUDGED if own.matters is None else "needed together" if own.matters else "left out together"
            yield row(effects, run, consequence, verdict, price, own.doubt)
            continue
        (effect,) = effects
        need = needed.get(effect, own)
        if effect in insists and not taken_in and effect not in missing:
            verdict, reason = "insisted on", str(insists[effect])
        elif need.matters is None:
            verdict, reason = NOT_JUDGED, need.doubt
        elif effect in missing:
            verdict, reason = ("needed but missing" if need.matters else "missing without need"), missing[effect]
        elif taken_in:
            verdict, reason = ("needed but missing" if need.matters else "left out"), ""
        else:
            verdict, reason = ("needed and on" if need.matters else "paid for without need"), ""
        yield row(effects, run, consequence, verdict, price, reason)
    for effect, text in surplus.items():
        if effect not in declared:
            yield row((effect,), plain, None, "cannot be switched off", None, text)


def _price(cost: Any, base: Any, samples: Sampled) -> Interval | None:
    """CPU time of a unit of one run over that of another, in the blocks that both were sampled in."""
    return ratio_in_blocks(samples.get(cost.trial, {}), samples.get(base.trial, {}))


@dataclass(frozen=True, slots=True)
class Audit:
    """Whether each scene calls for exactly what it needs.

    Terms:
        judge: the engine that was asked, '' where no engine left effects out on its tuned track. judged: its rows that say
        something. failed: those of them that are against the scene: an effect that does not matter is on, or one that matters
        is off. open: its rows that say nothing, since it gave no answer or has not converged: for these nothing is proposed.
    """

    judge: str
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

    def doubts(self, titles: Mapping[str, str] | None = None) -> list[str]:
        """What could not be judged and why, a sentence for each scene and reason. Args: titles: of cases and engines."""
        known = titles or {}
        effects: dict[tuple[str, str], list[str]] = {}
        for row in self.open:
            why = row.reason or "no answer to compare"
            why = why if row.verdict == NOT_JUDGED else f"{known.get(row.engine, row.engine)}: {row.verdict}: {why}"
            what = "any effect" if row.effect == AS_IT_IS else _spelled(row.effect)
            effects.setdefault((named_scene(row, known), why), []).append(what)
        return [f"{scene}: nothing is said of {', '.join(names)}: {reason}" for (scene, reason), names in effects.items()]


def audit(rows: Sequence[EffectVerdict]) -> Audit:
    """Of the rows of the table of effects; where the judge was not asked, the first engine that was stands in for it."""
    asked = dict.fromkeys(row.engine for row in rows if row.track == "tuned" and row.verdict != EVERYTHING)
    judge = JUDGE if JUDGE in asked else next(iter(asked), "")
    asked_of = tuple(row for row in rows if row.engine == judge and row.track == "tuned" and row.verdict != EVERYTHING)
    judged = tuple(row for row in asked_of if row.verdict not in (NOT_JUDGED, *UNANSWERED))
    failed = tuple(row for row in judged if row.verdict in ("paid for without need", "needed but missing"))
    return Audit(judge, judged, failed, tuple(row for row in asked_of if row not in judged))


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
    if row.verdict == "needed but missing":
        return f"{name}: leaves out {effect}, which matters: with it a body is moved by {_metres(row.moved)}"
    return (
        f"{name}: declares {effect}, which does not matter: without it no body is moved by more than "
        f"{_metres(row.moved)}, half the step moves one by {_metres(row.own)}"
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


def sentences(rows: Sequence[EffectVerdict], *, accusing: bool = True, titles: Mapping[str, str] | None = None) -> list[str]:
    """What leaving effects out saves, engine by engine, and what the audit says.

    Args: accusing: of each scene that fails it too. titles: what engines and cases are called, by name.
    """
    lines = []
    for saving in savings(rows):
        added = "" if saving.summed is None else f"; a simulated second of each, added up, {saving.summed:.3g} times"
        several = f" (geometric mean over {saving.scenes} scenes, {saving.low:.3g} to {saving.high:.3g}{added})"
        lines.append(
            f"{(titles or {}).get(saving.engine, saving.engine)}: a step with everything on costs {saving.mean:.3g} times that "
            f"of the scene as it is{several if saving.scenes > 1 else ''}."
        )
    audited = audit(rows)
    if audited.scenes:
        beside = f"; {audited.in_doubt} more are not judged in full" if audited.in_doubt else ""
        judge = (titles or {}).get(audited.judge, audited.judge)
        call = f"{audited.clean} of {audited.scenes} scenes call for exactly what they need"
        if audited.clean == audited.scenes == 1 and not audited.in_doubt:
            call = "the scene calls for exactly what it needs"
        lines.append(f"Audit: {call}, judged on {judge}{beside}.")
    lines += [f"Audit: {sentence}." for sentence in (*(audited.sentences(titles) if accusing else ()), *audited.doubts(titles))]
    return lines + [proposal for scene in scenes_of(audited.failed) if (proposal := proposed(scene, audited.judged))]


TABLE = Table(
    # the cell `effect` holds the names of `effects`
    holds=names(EffectVerdict, "effects").replace("cost..", "cost(low,high)"),
    beside="effects",
    objects=verdicts,
    shown=(
        Column("case", named_scene),
        Column("engine", side),
        Column("effect", "effect"),
        Column("cost", lambda row: "" if row.cost is None else f"x {row.cost.value:.3g} ({bracketed(row.cost, '.3g', '..')})"),
        Column("moves", "moved", ".2g"),
        Column("own error", "own", ".2g"),
        Column("verdict", lambda row: row.verdict if row.verdict == "insisted on" else outcome(row, 70)),
    ),
    sentences=sentences,
)
