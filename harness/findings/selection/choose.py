"""The answer: who is left out and why, who is ranked where, with which settings, and what would turn it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from plumbline.harness.findings.prices import priced
from plumbline.harness.findings.selection.decide import Decider, WhatTurns, decider, turns
from plumbline.harness.findings.selection.evidence import Evidence, gather
from plumbline.harness.findings.selection.rank import DRAWS, Rank, rank, resampled
from plumbline.harness.findings.selection.wish import Dropped, Wish
from plumbline.harness.store.store import Store

EXPRESSED = "a scene that it can express"
"""What is asked of every engine, whatever else is: of the others in a run there is no answer that could be compared."""
Alone = Literal["", "expresses", "left", "single"]
"""Why an engine has nobody beside it: the others express none of the scenes, or lack something else, or there are none."""


@dataclass(frozen=True, kw_only=True)
class Selection:
    """wish: what was asked. evidence: it leans on. rank: of the engines left, None where none is. dropped: the others.
    undecided: requirements of which a bound leaves open whether an engine that is left meets them. turns: what would turn who
    leads. decider: what would decide it, None where no single figure would. asked: how many engines could have been ranked.
    noisy: how many timings of the run are, and how many there are."""

    wish: Wish
    evidence: Evidence
    rank: Rank | None
    dropped: tuple[Dropped, ...]
    undecided: tuple[Dropped, ...]
    turns: tuple[WhatTurns, ...]
    decider: Decider | None = None
    asked: int
    noisy: tuple[int, int] = (0, 0)

    @property
    def alone(self) -> Alone:
        """Why one engine is ranked beside nobody, so that it leads nothing; '' where there are more, or none."""
        if self.rank is None or len(self.rank.places) != 1:
            return ""
        if self.asked == 1:
            return "single"
        return "expresses" if all(drop.requirement == EXPRESSED for drop in self.dropped) else "left"


def _of_the_engine(name: str, about: Mapping[str, Any], wish: Wish) -> Dropped | None:
    """The first requirement that an engine does not meet by what it is."""
    if about.get("unavailable"):
        return Dropped(engine=name, requirement="installed", value=str(about["unavailable"]))
    for feature in wish.features:
        if feature not in about.get("features", ()):
            return Dropped(engine=name, requirement=f"feature {feature}", value="not claimed")
    licence, platforms = str(about.get("licence") or ""), list(about.get("platforms") or ())
    if wish.licences and licence not in wish.licences:
        return Dropped(engine=name, requirement=f"licence {' or '.join(wish.licences)}", value=licence or "not known")
    if wish.platform and wish.platform not in platforms:
        value = ", ".join(platforms) or "not known"
        return Dropped(engine=name, requirement=f"platform {wish.platform}", value=value)
    return None


CAPABILITY = "capability"
"""The criterion that says what an engine can express."""
LEAST_COVERED = 0.5
"""Share of the pairs of criterion and case below which an engine is left out: with it hardly anything could be compared."""


def _by_expression(engine: str, evidence: Evidence) -> Dropped | None:
    """An engine that can express none of the scenes that count: its zeros would make a contest of what is none."""
    table, key = evidence.table, (CAPABILITY, engine)
    mine = {case: datum for (criterion, case, name), datum in table.items() if (criterion, name) == key}
    if not mine or any(datum.value > 0 for datum in mine.values()):
        return None
    case, datum = next(iter(mine.items()))
    return Dropped(engine=engine, requirement=EXPRESSED, value=datum.says, case=case, trial=datum.trial)


def _by_evidence(engine: str, evidence: Evidence) -> Dropped | None:
    covered = evidence.covered[engine]
    if covered >= LEAST_COVERED:
        return None
    return Dropped(engine=engine, requirement="evidence of half of what is compared", value=f"{100 * covered:.0f} %")


def _by_error(store: Store, engine: str, evidence: Evidence, wish: Wish) -> Dropped | None:
    """The first case in which an engine does not come to the error asked for, at whatever speed."""
    if not wish.strict:
        return None
    for case in evidence.cases:
        datum, speed = evidence.table.get(("accuracy", case, engine)), evidence.speeds.get((case, engine))
        if datum is None or datum.value >= 1 or (speed is not None and speed.error <= wish.max_error):
            continue
        errors = [point.error for point in priced(store).points if (point.case, point.engine) == (case, engine)]
        best = f"best {min(errors):.2g}" if errors else datum.says
        if not errors or min(errors) > wish.max_error:
            asked = f"error {wish.max_error:g} of the scale"
            return Dropped(engine=engine, requirement=asked, value=best, case=case, trial=datum.trial)
    return None


def _by_speed(engine: str, evidence: Evidence, wish: Wish) -> Dropped | None:
    """The first case in which an engine is not fast enough."""
    for case in evidence.cases if wish.realtime is not None else ():
        datum, speed = evidence.table.get(("speed", case, engine)), evidence.speeds.get((case, engine))
        slow = speed is not None and wish.realtime is not None and speed.times.value < wish.realtime and not speed.bound
        if datum is not None and (speed is None or slow):
            asked = f"{wish.realtime:g} times real time"
            return Dropped(engine=engine, requirement=asked, value=datum.says, case=case, trial=datum.trial)
    return None


def _left_open(evidence: Evidence, wish: Wish, left: Sequence[str]) -> Iterator[Dropped]:
    """Of each engine the first case in which it may be fast enough at the error asked for, at a larger step than were run."""
    for engine in left:
        for (case, name), speed in evidence.speeds.items():
            if name == engine and wish.realtime is not None and speed.bound and speed.times.value < wish.realtime:
                asked = f"{wish.realtime:g} times real time"
                value = f"{speed.words}, and no larger step was run"
                yield Dropped(engine=engine, requirement=asked, value=value, case=case, trial=speed.at.trial)
                break


def choose(store: Store, wish: Wish, draws: int = DRAWS) -> Selection:
    """Args: draws: resamples of cases, timings and weights."""
    if store.trials.empty:
        return Selection(wish=wish, evidence=Evidence(), rank=None, dropped=(), undecided=(), turns=(), asked=0)
    known = store.catalogue.get("engines", {})
    present = [str(engine) for engine in dict.fromkeys(store.trials["engine"])]
    ranked = [name for name in present if wish.with_reference or not known.get(name, {}).get("ours")]
    dropped = [drop for name in ranked if (drop := _of_the_engine(name, known.get(name, {}), wish)) is not None]
    left = _without(ranked, dropped)
    evidence = gather(store, wish, left)
    dropped += [drop for name in left if (drop := _by_what_it_did(store, name, evidence, wish)) is not None]
    if len(_without(left, dropped)) < len(left):
        left = _without(left, dropped)
        evidence = gather(store, wish, left)
    counts = any(wish.weight(criterion) > 0 for criterion, _, _ in evidence.table)
    samples = resampled(evidence, wish, draws) if left and counts else None
    order = None if samples is None else rank(evidence, samples)
    several = samples is not None and len(left) > 1
    return Selection(
        wish=wish,
        evidence=evidence,
        rank=order,
        dropped=tuple(dropped),
        undecided=tuple(_left_open(evidence, wish, left)),
        turns=tuple(t for t in turns(evidence, wish) if t.first != order.places[0].engine) if order is not None else (),
        decider=decider(store, evidence, samples, wish) if samples is not None and several else None,
        asked=len(ranked),
        noisy=_noisy(store),
    )


def _noisy(store: Store) -> tuple[int, int]:
    timed = store.trials["unstable_timing"].dropna().astype(bool)
    return int(timed.sum()), len(timed)


def _by_what_it_did(store: Store, engine: str, evidence: Evidence, wish: Wish) -> Dropped | None:
    """The first requirement that an engine does not meet by what it did in the cases that count."""
    return (
        _by_expression(engine, evidence)
        or _by_evidence(engine, evidence)
        or _by_error(store, engine, evidence, wish)
        or _by_speed(engine, evidence, wish)
    )


def _without(engines: Sequence[str], dropped: Sequence[Dropped]) -> list[str]:
    gone = {drop.engine for drop in dropped}
    return [engine for engine in engines if engine not in gone]
