"""Which robots of a zoo go in, into which engine, and what becomes of them there: one row a robot and engine.

A robot that does not go in has a row without an engine, with its reason. Robots that were run come first, then those that go in
and were not run, then those that do not go in.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

from plumbline.harness.case.undropped import OWN
from plumbline.harness.findings.agreement.costs import WITHIN
from plumbline.harness.findings.agreement.found import agreements, errors_of
from plumbline.harness.findings.agreement.omissions import omissions
from plumbline.harness.findings.agreement.setting_causes import settings_turned
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.findings.columns import Column, Table, names, plain
from plumbline.harness.findings.once import once
from plumbline.harness.store.store import Store
from plumbline.harness.store.zoo_record import InEngine, Stage, ZooEntry, entries

RUNS = ("agrees", "converges elsewhere", "converges", "does not converge")
"""Verdicts of what ran to its end."""
NOT_RUN = "not run: the budget ended first, or the run was stopped"
"""Why an engine that takes a robot has no verdict on it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InZoo:
    """One robot and engine, on the track that says most for the engine: tuned unless that gives no answer.

    Terms:
        robot, title, package, version, licence: see `harness.store.zoo_record.Entry`. stage: how far the robot came. case: of
        its runs, '' without. bodies, joints. needed: kinds of elements that no scene has words for and that are left out;
        drops: what this engine would have to have left out beyond that; dropped: all that is left out of what is run;
        separated by blanks. engine: '' where the robot does not go in. enters: does the engine take it? reason: why not, or
        why it was not run. track, verdict: of what was run, '' where nothing was. away: of its limit from the agreed one, a
        share of the size; bar: how well its own is known. cost: CPU seconds for a simulated second at an error of a hundredth
        of the size or less, None where no run comes so near. cause: the setting that sets it apart. omission [m]: how far what
        was dropped moves any body, by this engine's runs with and without; omission_until [s].
    """

    robot: str
    title: str
    package: str
    version: str
    licence: str
    stage: Stage
    case: str = ""
    bodies: int = 0
    joints: int = 0
    needed: str = ""
    drops: str = ""
    dropped: str = ""
    engine: str = ""
    enters: bool = False
    reason: str = ""
    track: str = ""
    verdict: str = ""
    away: float | None = None
    bar: float | None = None
    cost: float | None = None
    cause: str = ""
    omission: float | None = None
    omission_until: float | None = None


@once
def in_zoo(store: Store) -> list[InZoo]:
    """All robots of a zoo with all engines; nothing of a folder that is none's."""
    taken_in = list(entries(store.folder))
    if not taken_in:
        return []
    judged = {case_key(each.case): each for each in agreements(store)}
    rows: list[InZoo] = []
    for entry in taken_in:
        agreement = judged.get(case_key(entry.scene)) if entry.scene else None
        rows += [_row(store, entry, each, agreement) for each in entry.engines] or [InZoo(**_about(entry), reason=entry.reason)]
    ran = {row.robot for row in rows if row.verdict}
    return sorted(rows, key=lambda row: (row.stage != "in", row.robot not in ran))


def case_key(name: str) -> str:
    """What a scene file and the case made of it share, wherever the folder lies."""
    path = PurePath(name.removeprefix(OWN))
    return f"{path.parent.name}/{path.name}"


def _about(entry: ZooEntry) -> dict[str, Any]:
    return {
        "robot": entry.name, "title": entry.title, "package": entry.package, "version": entry.version,
        "licence": entry.licence, "stage": entry.stage, "bodies": entry.bodies, "joints": entry.joints,
        "needed": " ".join(entry.needed), "dropped": " ".join(entry.dropped),
    }  # fmt: skip


def _row(store: Store, entry: ZooEntry, engine: InEngine, agreement: Agreement | None) -> InZoo:
    about = _about(entry) | {"engine": engine.engine, "drops": " ".join(engine.drops)}
    if agreement is not None:
        about["case"] = agreement.case
    if engine.verdict != "can":
        return InZoo(**about, reason=f"{engine.verdict}: {engine.reason}")
    side = None if agreement is None else _counted(engine.engine, agreement)
    if agreement is None or side is None:
        return InZoo(**about, enters=True, reason=NOT_RUN)
    lost = next((each for each in omissions(store, agreement) if each.engine == engine.engine), None)
    mine = (side.engine, side.track)
    causes = (each for each in settings_turned(store, agreement) if each.cause and (each.engine, each.track) == mine)
    return InZoo(
        **about,
        enters=True,
        reason=side.why,
        track=side.track,
        verdict=side.word,
        away=side.distance,
        bar=side.limit.bar_at(side.limit.until) if side.limit.bar is not None and side.limit.until > 0 else None,
        cost=_price(store, side),
        cause=next((f"{each.setting} = {each.value}" for each in causes), ""),
        omission=None if lost is None else lost.position,
        omission_until=None if lost is None or lost.position is None else lost.until,
    )


def _counted(engine: str, agreement: Agreement) -> Side | None:
    """The tuned track of an engine; another one where that gave no answer."""
    mine = [side for side in agreement.sides if side.engine == engine]
    return min(mine, key=lambda side: (side.word not in RUNS, side.track != "tuned"), default=None)


def _price(store: Store, side: Side) -> float | None:
    """The least that a run costs that errs by a hundredth of the size or less."""
    errors = errors_of(store)
    costs = dict(zip(store.trials["trial"], store.trials["cpu_per_sim_s"], strict=True))
    near = [rung.trial for rung in side.limit.rungs if (each := errors.get(rung.trial)) is not None and each.error <= WITHIN]
    return min((float(cost) for trial in near if not math.isnan(cost := float(costs.get(trial) or math.nan))), default=None)


def _sentences(rows: Sequence[InZoo]) -> list[str]:
    return list(_words(rows))


def _words(rows: Sequence[InZoo]) -> Iterator[str]:
    """How many robots go in, into which engines, and how many agree."""
    robots = dict.fromkeys(row.robot for row in rows)
    if not robots:
        yield "No robot of this folder was taken in by a zoo."
        return
    inside = {row.robot for row in rows if row.enters}
    engines = list(dict.fromkeys(row.engine for row in rows if row.engine))
    ran = {engine: {row.robot for row in rows if row.engine == engine and row.verdict in RUNS} for engine in engines}
    everywhere = len(set.intersection(*ran.values())) if ran else 0
    yield f"{len(inside)} of {len(robots)} robots go in; {everywhere} run on all of {', '.join(engines) or 'no engine'}."
    if waiting := len(inside - {row.robot for row in rows if row.verdict}):
        yield f"Of those that go in, {waiting} {'was' if waiting == 1 else 'were'} {NOT_RUN}; --resume goes on."
    for engine in engines:
        words = [row.verdict for row in rows if row.engine == engine and row.verdict]
        counted = ", ".join(f"{word} {words.count(word)}" for word in dict.fromkeys((*RUNS, *words)) if word in words)
        yield f"{engine}: {counted or 'nothing was run'}."
    outside = [row.stage for row in rows if not row.engine]
    if outside:
        counted = ", ".join(f"{stage} {outside.count(stage)}" for stage in dict.fromkeys(outside))
        yield f"Of those that do not go in: {counted}."


def _verdict(row: InZoo) -> str:
    """What became of a robot, in the room that a terminal has."""
    return row.verdict or (row.reason if row.enters else f"{row.stage}: {row.reason[:90]}")


TABLE = Table(
    holds=names(InZoo),
    objects=in_zoo,
    shown=(
        *plain("robot", "engine"),
        Column("dropped", lambda row: row.dropped or row.needed),
        Column("verdict", _verdict),
        *plain("away=away:.2g", "cost=cost:.2g", "cause", "omission=omission:.2g m"),
    ),
    sentences=_sentences,
)
