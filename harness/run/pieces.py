"""A run as pieces of work: what of each trial its time depends on."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from harness.case import Case
from harness.search.to_come import ToCome, seconds_of_run
from harness.store.record import Record
from harness.study.trial import Trial

__all__ = ["Awaited", "Piece", "awaited", "clocked_pieces", "pieces_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """A trial as work.

    Terms: steps: that its engine takes. count, sample [s]: samples of its timing run in all processes, and how long each has to
    be at least; none without one. processes: of it; group: those that are clocked together, in one process an engine. run [s]:
    of its steps, once that was clocked roughly; else 0.
    """

    name: str
    case: str
    engine: str
    steps: float
    count: int = 0
    sample: float = 0.0
    processes: int = 1
    group: str = ""
    run: float = 0.0


@dataclass(frozen=True, slots=True)
class Awaited:
    """Pieces like this one that a search will ask for.

    Terms: answers, clocks: how many, in expectation. at_once: how many of them at a time; the next follow from their answers.
    """

    like: Piece
    answers: float
    clocks: float
    at_once: int = 1


def pieces_of(trials: Iterable[Trial], cases: Mapping[str, Case]) -> list[Piece]:
    """These trials as work; which settings of a sweep are clocked is not known before they are tried."""
    pieces = []
    for trial in trials:
        asked = trial.experiment
        clocked = asked.timing and not (asked.sweep or asked.dominance) and asked.limit is None and trial.alteration.clocked
        piece = _piece(trial, cases[trial.case])
        pieces.append(piece if clocked else replace(piece, count=0))
    return pieces


def clocked_pieces(trials: Iterable[Trial], records: Mapping[str, Record], cases: Mapping[str, Case]) -> list[Piece]:
    """These trials as work, all of them clocked. Args: records: theirs, by which a whole run is known to take so long."""
    return [
        _piece(trial, cases[trial.case], seconds_of_run(trial, records[trial.trial], cases[trial.case])) for trial in trials
    ]


def awaited(expected: Iterable[ToCome], cases: Mapping[str, Case]) -> list[Awaited]:
    """What searches will ask for, as work."""
    return [
        Awaited(_piece(each.like, cases[each.like.case], each.run), each.answers, each.clocks, each.at_once)
        for each in expected
    ]


def _piece(trial: Trial, case: Case, run: float = 0.0) -> Piece:
    asked, settings = trial.experiment, trial.settings
    return Piece(
        name=trial.trial,
        case=trial.case,
        engine=trial.engine,
        steps=case.duration / settings.dt * (settings.substeps or 1) * trial.members,
        count=asked.processes * asked.samples,
        sample=asked.sample_seconds,
        processes=asked.processes,
        group=repr((asked.name, trial.case, trial.parameters)),
        run=run,
    )
