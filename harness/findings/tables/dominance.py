"""Is 'tuned' beaten by a change of one of its knobs? Every change that was tried, and what became of it.

A change that beats the track stands alone, with how it fared at drawn parameters; the others are folded, one row for each thing
that became of them.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any

import pandas as pd

from plumbline.harness.findings.columns import Column, Table, at, bracketed, names, scene
from plumbline.harness.findings.cost_point import BlockSample, SampledBlock, ratio_in_blocks, samples_by_block
from plumbline.harness.findings.once import once
from plumbline.harness.findings.parameter_words import in_words, other_values, where_of
from plumbline.harness.search.dominance import ANSWERED, MAYBE, UNDER, Comparison, Question, compared, kept_parameters, run_of
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.rows import grouped, records
from plumbline.harness.store.store import Store
from plumbline.harness.study.experiment import experiments_of
from plumbline.harness.study.one_knob import OPTION, KnobTurn, turn_between

DOMINATED, EXCUSED = "dominated", "excused"
"""The verdicts of a change that beats the track, without and with a reason of the adapter's."""
IDLE, SAME, NO_BETTER, DEARER = "changes nothing", "same answer", "no better", "dearer"
NOT_CLOCKED, REFUSED = "not clocked", "refused"
STALE = "reason not needed"


@dataclass(frozen=True, slots=True, kw_only=True)
class TriedChange:
    """One change of 'tuned', or several that the same became of.

    Terms:
        ours: is it the engine of this project? change: the knob and its value, or the track 'default'; several are parted by
        semicolons, `count` says how many. checks: how many the case has; held_tuned, held_change: how many of them hold, at the
        looser of both bounds. error_ratio: the change's over the track's, above the floor that `harness.search.dominance` says.
        cost: CPU time over the track's, clocked in the same blocks; a rough one has no interval. verdict: DOMINATED or EXCUSED
        if the change is better; 'no better'; 'same answer', to the last bit; 'changes nothing', so that it was not run: the
        engine resolves its settings as before; 'dearer', broken off since it could win by its cost alone; 'not clocked', if it
        may win by its cost and the clock did not say; 'refused', or the status of a run without an answer; 'reason not needed',
        of no change that was run, if the adapter names one that is not better here. by: 'checks', 'price' or 'error', what it
        is better by. drawn, won: parameters that were drawn and answered, and at how many of them it is better too; draws:
        which. reason: the adapter's, or why there is no answer. trial: of the change, of the track for what was not run.
    """

    case: str
    where: str
    engine: str
    ours: bool
    change: str = ""
    count: int = 1
    verdict: str
    by: str = ""
    held_tuned: int | None = None
    held_change: int | None = None
    checks: int | None = None
    error_ratio: float | None = None
    cost: Interval | None = None
    drawn: int = 0
    won: int = 0
    draws: str = ""
    reason: str = ""
    trial: str


Sampled = Mapping[str, Mapping[SampledBlock, BlockSample]]
Facts = Mapping[str, Any]
"""What the table of trials holds of one."""


@dataclass(frozen=True, slots=True)
class _Beside:
    """A change beside the track at one set of parameters. Terms: by: what it is better by, '' for nothing. cost: clocked;
    rough: as a share of the track's."""

    compared: Comparison | None
    by: str
    cost: Interval | None
    rough: float


@once
def changes(store: Store) -> tuple[TriedChange, ...]:
    """All rows of a run, those that beat the track first; worked out once for a store."""
    asked = {experiment.name: experiment for experiment in experiments_of(store) if experiment.dominance}
    samples = samples_by_block(store) if asked else {}

    def scene_of(row: Facts) -> str:
        kept = kept_parameters(asked[row["experiment"]], json.loads(row["parameters"]))
        return repr((row["experiment"], row["case"], kept, row["dt"], row["engine"]))

    scenes = grouped(records(store.trials[store.trials["experiment"].isin(asked)]), scene_of)
    found = [change for scene in scenes.values() for change in _of_scene(store, scene, samples)]
    order = {DOMINATED: 0, EXCUSED: 1}
    return tuple(sorted(found, key=lambda change: order.get(change.verdict, 2)))


def _of_scene(store: Store, scene: Sequence[Facts], samples: Sampled) -> list[TriedChange]:
    """The rows of one scene on one engine."""
    track = next((row for row in scene if row["track"] == "tuned" and row["round"] == 0), None)
    if track is None:
        return []
    case, engine = store.described("cases", track["case"]), store.described("engines", track["engine"])
    given = json.loads(track["parameters"])
    blank = TriedChange(
        case=track["case"],
        where=where_of(store.catalogue, track["case"], track["parameters"]),
        engine=track["engine"],
        ours=bool(engine["ours"]),
        verdict=str(track["status"]),
        trial=str(track["trial"]),
    )
    tried = [row for row in scene if row["round"] == 1]
    if not tried:
        # Nothing of it can be expressed, or the run was broken off: what became of the track itself.
        return [replace(blank, change="tuned", reason=str(track["reason"]))] if track["status"] not in ANSWERED else []
    tuned = {row["parameters"]: row for row in reversed(scene) if row["track"] == "tuned"}
    question, settings = Question.described(case), json.loads(track["settings"])
    beside = {
        row["trial"]: _beside(store, question, tuned.get(row["parameters"]), row, samples)
        for row in scene
        if row["track"] != "tuned"
    }
    turns = {
        row["trial"]: None if row["track"] == "default" else turn_between(settings, json.loads(row["settings"]))
        for row in tried
    }
    single = [_judged(row, blank, turns[row["trial"]], beside, scene, given, track, engine["trade_offs"]) for row in tried]
    idle = [replace(blank, change=str(KnobTurn(*turn)), verdict=IDLE) for turn in store.idle.get(track["trial"], ())]
    used = {change.reason for change in single if change.verdict == EXCUSED}
    stale = [
        replace(blank, change=one["knob"].removeprefix(OPTION) or "default", count=0, verdict=STALE, reason=one["why"])
        for one in engine["trade_offs"]
        if track["case"] in one["cases"] and list(one["at"]) != ["ladder"] and not blank.where and one["why"] not in used
    ]
    return [*_folded([*single, *idle]), *stale]


def _beside(store: Store, question: Question, track: Facts | None, row: Facts, samples: Sampled) -> _Beside:
    if track is None:
        return _Beside(None, "", None, math.nan)
    sides = [run_of(question, str(one["status"]), store.measured.get(one["trial"], ())) for one in (track, row)]
    both = compared(question, *sides)
    cost = ratio_in_blocks(samples.get(row["trial"], {}), samples.get(track["trial"], {}))
    by = ""
    if both is not None and both.more:
        by = "checks"
    elif both is not None and row["track"] == "default" and both.errs_less:
        by = "error"
    elif both is not None and both.as_good and cost is not None and cost.ends[1] < UNDER:
        by = "price"
    return _Beside(both, by, cost, _rough(track, row))


def _rough(track: Facts, row: Facts) -> float:
    """What a change costs over the track, roughly; nan if nothing is known."""
    values = (row["rough_ratio"], row["rough_cost"], track["rough_cost"])
    ratio, *costs = (math.nan if pd.isna(value) else float(value) for value in values)
    return costs[0] / costs[1] if math.isnan(ratio) and min(costs) > 0 else ratio


def _judged(
    row: Facts,
    blank: TriedChange,
    turn: KnobTurn | None,
    beside: Mapping[str, _Beside],
    scene: Sequence[Facts],
    given: Mapping[str, Any],
    track: Facts,
    trade_offs: Sequence[Mapping[str, Any]],
) -> TriedChange:
    """A change that was run at the scene's own parameters."""
    own = beside[row["trial"]]
    change = replace(blank, change="default" if turn is None else str(turn), trial=str(row["trial"]))
    if own.compared is None:
        return replace(change, verdict=_unanswered(row, track), reason=str(row["reason"]))
    drawn = [other for other in scene if other["round"] == 2 and other["track"] == row["track"]]
    answered = [other for other in drawn if beside[other["trial"]].compared is not None]
    why = next((str(one["why"]) for one in trade_offs if blank.case in one["cases"] and _names(one, turn)), "")
    verdict = (EXCUSED if why else DOMINATED) if own.by else NO_BETTER
    if not own.by and row["trajectory_hash"] == track["trajectory_hash"]:
        verdict = SAME
    if not own.by and own.compared.as_good and own.cost is None and own.rough < MAYBE:
        verdict = NOT_CLOCKED
    return replace(
        change,
        verdict=verdict,
        by=own.by,
        held_tuned=own.compared.held[0],
        held_change=own.compared.held[1],
        checks=own.compared.checks,
        error_ratio=own.compared.ratio,
        cost=own.cost or Interval(own.rough),
        drawn=len(answered),
        won=sum(bool(beside[other["trial"]].by) for other in answered),
        draws="; ".join(_told(other, beside[other["trial"]], given) for other in drawn),
        reason=why if own.by else str(row["timing_note"] or "") if verdict == NOT_CLOCKED else "",
    )


def _unanswered(row: Facts, track: Facts) -> str:
    if row["status"] == "timeout" and track["status"] == "passed":
        return DEARER
    return REFUSED if row["status"] in ANSWERED else str(row["status"])


def _told(row: Facts, there: _Beside, given: Mapping[str, Any]) -> str:
    """A drawn scene in words: 'speed 1.0 wins by price'."""
    fared = str(row["status"]) if there.compared is None else f"wins by {there.by}" if there.by else "does not win"
    return f"{in_words(other_values(json.loads(row['parameters']), given))} {fared}"


def _names(trade_off: Mapping[str, Any], turn: KnobTurn | None) -> bool:
    if turn is None:
        return not trade_off["knob"] and list(trade_off["at"]) != ["ladder"]
    return trade_off["knob"] == turn.knob and (not trade_off["values"] or turn.value in trade_off["values"])


def _folded(single: Sequence[TriedChange]) -> Iterator[TriedChange]:
    """Changes that beat the track alone; of the others one row for each thing that became of them."""
    alone = [change for change in single if change.verdict in (DOMINATED, EXCUSED, NOT_CLOCKED)]
    yield from alone
    for some in grouped((each for each in single if each not in alone), attrgetter("verdict", "reason")).values():
        whole = replace(some[0], change="; ".join(change.change for change in some), count=len(some))
        if len(some) > 1:
            whole = replace(whole, held_tuned=None, held_change=None, error_ratio=None, cost=None)
        yield whole


def unexcused(store: Store) -> list[str]:
    """The changes that beat a track without a reason of its adapter's, each in a sentence."""
    return [_sentence(change) for change in changes(store) if change.verdict == DOMINATED]


def _sentence(row: TriedChange) -> str:
    better = {
        "checks": f"keeps {row.held_change} of {row.checks} checks, where tuned keeps {row.held_tuned}",
        "price": f"costs {at(row, 'cost.value'):.2g} times as much at an error no larger",
        "error": f"errs {row.error_ratio:.2g} times as much",
    }[row.by]
    drawn = f"; so it is at {row.won} of {row.drawn} drawn parameters" if row.drawn else ""
    return f"{scene(row)}: {row.engine}/tuned with {row.change} {better}{drawn}"


def _cost(row: TriedChange) -> str:
    if row.cost is None or math.isnan(row.cost.value):
        return ""
    return f"x {row.cost.value:.2g}" + ("" if row.cost.low is None else f" ({bracketed(row.cost, '.2g', '..')})")


def _error(row: TriedChange) -> str:
    error = row.error_ratio
    return "" if error is None or math.isnan(error) else f"x {error:.3g}"


def _changed(row: TriedChange) -> str:
    named = row.change if len(row.change) <= 60 else f"{row.change[:57]}..."
    return named if row.count <= 1 else f"{row.count}: {named}"


def _held(row: TriedChange) -> str:
    return "" if row.held_change is None else f"{row.held_tuned} -> {row.held_change} of {row.checks}"


def _verdict(row: TriedChange) -> str:
    verdict = f"{row.verdict} by {row.by}" if row.by else row.verdict
    return f"{verdict}: {row.reason[:70]}" if row.reason else str(verdict)


def _count(rows: Sequence[TriedChange], verdict: str) -> int:
    return sum(row.count for row in rows if row.verdict == verdict)


def _sentences(rows: Sequence[TriedChange]) -> list[str]:
    """How many changes were tried of each engine, and those that beat its track without a reason."""
    lines = []
    for engine in dict.fromkeys(row.engine for row in rows):
        mine = [row for row in rows if row.engine == engine]
        scenes = len({(row.case, row.where) for row in mine})
        beaten, excused, idle = (_count(mine, verdict) for verdict in (DOMINATED, EXCUSED, IDLE))
        tried = sum(row.count for row in mine) - idle
        named = f"{engine} (ours)" if mine[0].ours else engine
        lines.append(
            f"{named}: {tried} changes tried in {scenes} scenes, {idle} that change nothing left out; {beaten} beat "
            f"tuned without a reason, {excused} with one."
        )
    lines += [f"{_sentence(row)}." for row in rows if row.verdict == DOMINATED]
    return lines + [
        f"{row.case}: {row.engine} gives a reason for {row.change}, which is not better here."
        for row in rows
        if row.verdict == STALE
    ]


TABLE = Table(
    holds=names(TriedChange).replace("cost..", "cost(low,high)"),
    objects=changes,
    shown=(
        Column("scene", scene),
        Column("engine", lambda row: row.engine + (" (ours)" if row.ours else "")),
        Column("change of tuned", _changed),
        Column("checks", _held),
        Column("error", _error),
        Column("cost", _cost),
        Column("drawn", lambda row: f"{row.won} of {row.drawn}" if row.drawn else ""),
        Column("verdict", _verdict),
    ),
    sentences=_sentences,
)
