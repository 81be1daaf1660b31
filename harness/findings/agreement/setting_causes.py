"""Which setting of an engine makes its track end elsewhere: the one that closes most of the distance when it is turned alone.

The distance is that of a run under the track from where it should end, at the same step: from the engine's own `tuned` run
where `default` was asked about, from the agreed limit where `tuned` was. A side that agrees with the limit after all, at finer
steps than it was asked about, needs no cause. An effect that is merely there is no cause.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from plumbline.harness.case.alteration import TURNED
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.findings.agreement.words import length, listed
from plumbline.harness.findings.columns import Cell
from plumbline.harness.search.own_limits import ANSWERED, read_run
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trajectory.parting import apart, common

CLOSES = 0.8
"""Of the distance: a setting that closes as much is named as the cause; what is left is of the step and of others."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Turned(Cell):
    """One setting turned alone.

    Terms: setting, value: which, and to what. towards: the track or 'limit' that is to be met. dt [s]. before, after: the
    distance from there without and with the turn, as shares of the size; after is None where there is no answer, why says so.
    closes: the share of the distance that is gone; negative where it grows. cause: is it enough, and the most of all?
    """

    setting: str
    value: str
    towards: str
    dt: float
    before: float
    after: float | None
    why: str
    closes: float | None
    cause: bool
    trial: str


def settings_turned(store: Store, agreement: Agreement) -> list[Turned]:
    """All settings that were turned in a scene, engine by engine, the one that closes most first."""
    trials = store.trials
    mine = trials[(trials["case"] == agreement.case) & trials["alteration"].str.contains(f'"name": "{TURNED}"', regex=False)]
    mine = mine[mine["parameters"] == (agreement.where or "{}")]
    listed_turns: list[Turned] = []
    for side in agreement.sides:
        rows = [row for row in mine.itertuples() if (row.engine, store.bases[row.trial]) == (side.engine, side.track)]
        if rows:
            listed_turns += _of_side(store, agreement, side, rows)
    return listed_turns


def _of_side(store: Store, agreement: Agreement, side: Side, rows: Sequence[Any]) -> list[Turned]:
    dt = float(rows[0].dt)
    towards, target = _target(agreement, side, dt)
    base = _at(side, dt)
    if base is None or target is None or (towards == "limit" and side.word == "agrees"):
        return []
    before = _distance(base, target, agreement)
    turned = []
    for row in rows:
        setting, _, value = str(row.track).partition(", ")[2].rpartition(" ")
        answered = row.status in ANSWERED and isinstance(row.trajectory_hash, str)
        after = _distance(read_run(store, str(row.trajectory_hash), dt), target, agreement) if answered else None
        turned.append(
            Turned(
                case=agreement.case, where=agreement.where, engine=side.engine, track=side.track, setting=setting, value=value,
                towards=towards, dt=dt, before=before, after=after, why="" if answered else f"{row.status}: {row.reason}",
                closes=None if after is None or before == 0 else 1 - after / before, cause=False, trial=str(row.trial),
            )
        )  # fmt: skip
    turned.sort(key=lambda each: -(each.closes if each.closes is not None else -float("inf")))
    return [replace(each, cause=k == 0 and each.closes is not None and each.closes >= CLOSES) for k, each in enumerate(turned)]


def _target(agreement: Agreement, side: Side, dt: float) -> tuple[str, Trajectory | None]:
    tuned = next((each for each in agreement.sides if (each.engine, each.track) == (side.engine, "tuned")), None)
    if side.track != "tuned" and tuned is not None:
        return "tuned", _at(tuned, dt)
    return "limit", agreement.limit


def _at(side: Side, dt: float) -> Trajectory | None:
    return next((rung.run for rung in side.limit.rungs if rung.run is not None and abs(rung.dt / dt - 1) < 1e-9), None)


def _distance(run: Trajectory, target: Trajectory, agreement: Agreement) -> float:
    first, second = common([run, target])
    return float(apart(first, second, agreement.scale).max(initial=0.0))


def cause_words(turned: Sequence[Turned], agreement: Agreement, titles: Mapping[str, str]) -> list[str]:
    """A sentence for each engine and track that was asked about: the setting that does it, or that no single one does."""
    lines = []
    for engine, track in dict.fromkeys((each.engine, each.track) for each in turned):
        mine = [each for each in turned if (each.engine, each.track) == (engine, track)]
        where = "the agreed limit" if mine[0].towards == "limit" else "its tuned track"
        who = f"{titles.get(engine, engine)}, {track}, ends {length(mine[0].before, agreement)} from {where}"
        best = mine[0]
        if best.cause and best.closes is not None:
            lines.append(f"{who}: '{best.setting}' turned to {best.value} alone closes {100 * best.closes:.0f} % of that.")
        else:
            tried = listed(list(dict.fromkeys(each.setting for each in mine)))
            share = best.closes or 0.0
            most = f"; '{best.setting}' closes most, {math.floor(100 * share)} %" if share > 0 else ""
            none = f"no single setting closes {100 * CLOSES:.0f} % of that, of {len(mine)} turns tried"
            lines.append(f"{who}: {none} ({tried}){most}.")
    return lines
