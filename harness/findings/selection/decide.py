"""What would decide between engines, and what would turn the answer: another weight of a criterion or of a family of cases, one
case less, or the case and engine of which a built-in study, run further, can move it most.

Speeds are read off the steps that were run. `accuracy` runs a case's ladder: at its largest step an engine that errs less than
asked may be faster by as much as that step is larger; one that errs more comes down to the error asked for at a smaller step,
by its first power or faster; one of which no run passes may pass at the smallest. Where the ladder has no such step, the study
can decide nothing there. `limits` halves brackets.
"""

import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import pandas as pd

from plumbline.harness.findings.prices import priced
from plumbline.harness.findings.selection.evidence import DECADES_OF_SPEED, Evidence
from plumbline.harness.findings.selection.rank import Floats, Resampled, first_shares, scores
from plumbline.harness.findings.selection.wish import CRITERIA, Wish
from plumbline.harness.findings.speed import Speed
from plumbline.harness.store.store import Store

LEAST = 0.02
"""Share of resamples below which a figure decides nothing: half of the resolution of the shares themselves is as much."""
STUDIES = {"speed": "accuracy", "limits": "limits"}
"""The built-in study that measures a criterion more closely: speeds over a ladder of steps, limits to a narrower bracket."""


@dataclass(frozen=True, kw_only=True)
class Decider:
    """criterion, case, engine: of the figure. low, high: between these the share of the first engine will lie once it is known.
    seconds: what this engine's runs of the case took in the folder, runs: how many they are. command: what measures it, into
    the same folder unless that is the one that ships with the package."""

    criterion: str
    case: str
    engine: str
    low: float
    high: float
    seconds: float
    runs: int
    command: str

    @property
    def moves(self) -> float:
        """The share of resamples that it moves at most to either side."""
        return (self.high - self.low) / 2


def decider(store: Store, evidence: Evidence, samples: Resampled, wish: Wish) -> Decider | None:
    """None where nothing that could be run moves the answer by `LEAST`."""
    leader = int(np.argmax(first_shares(samples.scores)))
    best: Decider | None = None
    for (criterion, case, engine), ends in _ends(store, evidence, samples, wish):
        shares = [float(first_shares(scores)[leader]) for scores in ends]
        low, high = min(shares), max(shares)
        if (high - low) / 2 >= max(LEAST, best.moves if best is not None else 0.0):
            seconds, runs = _spent(store, case, engine)
            command = f"plumbline run {STUDIES[criterion]} --engine {engine} --case {case}{into(store)}"
            best = Decider(
                criterion=criterion, case=case, engine=engine, low=low, high=high, seconds=seconds, runs=runs, command=command
            )
    return best


def _ends(
    store: Store, evidence: Evidence, samples: Resampled, wish: Wish
) -> Iterator[tuple[tuple[str, str, str], list[Floats]]]:
    """By criterion, case and engine, the scores of all resamples if the figure came out at one of its ends."""
    for (criterion, case, engine), datum in evidence.table.items():
        if criterion not in STUDIES or criterion not in samples.criteria:
            continue
        if criterion == "speed":
            ends = list(_speeds(store, evidence, wish, case, engine))
        else:
            ends = [{criterion: end} for end in (datum.low, datum.high) if datum.low < datum.high]
        if ends:
            cell = samples.cases.index(case), evidence.engines.index(engine)
            counted = [{name: end[name] for name in end if name in samples.criteria} for end in ends]
            yield (criterion, case, engine), [_moved(samples, *cell, end) for end in counted]


def _speeds(store: Store, evidence: Evidence, wish: Wish, case: str, engine: str) -> Iterator[Mapping[str, float]]:
    """What the steps of the case's ladder can make of an engine there, by criterion, at the ends."""
    ladder = [float(dt) for dt in store.catalogue.get("cases", {}).get(case, {}).get("ladder") or ()]
    unit = max((other.times.value for (of, _), other in evidence.speeds.items() if of == case), default=0.0)
    speed = evidence.speeds.get((case, engine))
    if speed is None:
        points = [p for p in priced(store).points if (p.case, p.engine, p.track) == (case, engine, evidence.tracks[engine])]
        finest = min(points, key=lambda point: point.dt, default=None)
        if finest is not None and unit and min(ladder, default=finest.dt) < finest.dt:
            yield {}
            yield {"speed": _score(min(ladder) / finest.dt / finest.cost.value, unit), "accuracy": 1.0}
        return
    slow, fast = prospect(speed, ladder, wish.max_error)
    # An engine that takes smaller steps for it errs as little as was asked.
    exact = {"accuracy": 1.0} if slow < speed.times.ends[0] else {}
    yield {"speed": _score(slow, unit)} | exact
    yield {"speed": _score(fast, unit)} | exact
    if exact:
        yield {}


def _score(times: float, unit: float) -> float:
    """Of a speed over the highest of its case, as it counts; above 1 for one that is higher still."""
    return 1 + math.log10(times / unit) / DECADES_OF_SPEED


def prospect(speed: Speed, ladder: Sequence[float], error: float) -> tuple[float, float]:
    """Times real time at the least and at the most, once the steps of the ladder are run as well."""
    low, high = speed.times.ends
    if speed.bound:
        high *= max(1.0, max(ladder, default=speed.at.dt) / speed.at.dt)
    elif not speed.at_error and min(ladder, default=speed.at.dt) < speed.at.dt:
        low *= max(min(ladder) / speed.at.dt, error / speed.error)
    return low, high


def _moved(samples: Resampled, c: int, e: int, values: Mapping[str, float]) -> Floats:
    """The scores if an engine had these values by criterion in a case; what is above 1 is the unit of the others, who fall."""
    scores = samples.scores.copy()
    for criterion, value in values.items():
        k = samples.criteria.index(criterion)
        then = np.maximum(samples.drawn[:, k, c, :] - max(value - 1.0, 0.0), 0.0)
        then[:, e] = min(max(value, 0.0), 1.0)
        scores += samples.share[:, k, c, None] * (then - samples.drawn[:, k, c, :])
    return scores


def into(store: Store) -> str:
    """The options that add runs to a folder, which has to have a journal for it."""
    return f" --out {shlex.quote(str(store.folder))} --resume=merge" if (store.folder / "journal.jsonl").is_file() else ""


def _spent(store: Store, case: str, engine: str) -> tuple[float, int]:
    """Seconds of all runs of an engine in a case, clocked ones with their samples, and how many runs these are."""
    trials = store.asked[(store.asked["case"] == case) & (store.asked["engine"] == engine)]
    once = (pd.to_numeric(trials["cpu_per_sim_s"]).fillna(pd.to_numeric(trials["rough_cost"])) * trials["sim_seconds"]).sum()
    clocked = store.samples.loc[store.samples["trial"].isin(trials["trial"]), "wall"].sum()
    return float(once + clocked), len(trials)


TIMES = 2.0


@dataclass(frozen=True, kw_only=True)
class WhatTurns:
    """What would put another engine first. kind: 'criterion' or 'family', weighed double; 'case', left out. name: of it. first:
    who leads then."""

    kind: Literal["criterion", "family", "case"]
    name: str
    first: str


def _leader(evidence: Evidence, wish: Wish) -> str:
    found = scores(evidence, wish)
    return max(found, key=lambda engine: found[engine])


def turns(evidence: Evidence, wish: Wish) -> tuple[WhatTurns, ...]:
    """Each change that by itself turns the leader."""
    return tuple(_turns(evidence, wish)) if len(evidence.engines) > 1 else ()


def _turns(evidence: Evidence, wish: Wish) -> Iterator[WhatTurns]:
    today = _leader(evidence, wish)
    for criterion in CRITERIA:
        heavier = replace(wish, weights={**wish.weights, criterion: TIMES * wish.weight(criterion)})
        if (then := _leader(evidence, heavier)) != today:
            yield WhatTurns(kind="criterion", name=criterion, first=then)
    for family in dict.fromkeys(evidence.families[case] for case in evidence.cases):
        cases = {case: weight * (TIMES if evidence.families[case] == family else 1) for case, weight in evidence.cases.items()}
        if (then := _leader(replace(evidence, cases=cases), wish)) != today:
            yield WhatTurns(kind="family", name=family, first=then)
    for case in evidence.cases if len(evidence.cases) > 1 else ():
        fewer = {name: weight for name, weight in evidence.cases.items() if name != case}
        if (then := _leader(replace(evidence, cases=fewer), wish)) != today:
            yield WhatTurns(kind="case", name=case, first=then)
