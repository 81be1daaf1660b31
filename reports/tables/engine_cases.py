"""What stands on an engine's own page: which versions ran, whose laws are its own, and its cases from worst to best."""

from collections.abc import Mapping, Sequence
from typing import Any

from plumbline.harness.store.store import Store
from plumbline.reports.tables.own_scenes import by_case
from plumbline.reports.tables.verdicts import Verdict, verdicts
from plumbline.reports.words.catalogue import cases, named_tracks
from plumbline.reports.words.emulated_features import Law, every_law


def cases_of(store: Store, engine: str) -> list[tuple[Mapping[str, Any], Mapping[str, Verdict]]]:
    """The cases that were put to an engine, each with its verdicts by track: the worst outcome on any track first, and among
    equals the larger margin."""
    cells = verdicts(store)
    listed = [
        (case, mine)
        for name, case in cases(store).items()
        if name not in by_case(store)
        and (mine := {track: cells[name, engine, track] for track in named_tracks(store) if (name, engine, track) in cells})
    ]
    return sorted(listed, key=lambda listed_case: max(map(_weight, listed_case[1].values())), reverse=True)


def tracks_of(store: Store, engine: str) -> list[str]:
    """The tracks and settings that the study names on which an engine has a verdict."""
    judged = {track for _, name, track in verdicts(store) if name == engine}
    return [track for track in named_tracks(store) if track in judged]


def _weight(cell: Verdict) -> tuple[int, float]:
    return cell.own.rank, cell.margin.times if cell.margin is not None else 0.0


def by_reason(known_failures: Mapping[str, str]) -> list[tuple[str, list[str]]]:
    """Checks that fail for one reason stand together under it."""
    checks: dict[str, list[str]] = {}
    for check, reason in known_failures.items():
        checks.setdefault(reason, []).append(check)
    return list(checks.items())


def versions_of(store: Store, engine: str) -> list[str]:
    """Those that the trials say."""
    mine = store.trials["engine_version"][store.trials["engine"] == engine]
    return [str(version) for version in mine.unique() if version]


def laws_of(store: Store, engine: str) -> Sequence[tuple[str, Law]]:
    """Every feature that some engine of the run claims, and whose it is on this one; what it lacks first."""
    rows = [(feature, row[engine]) for feature, row in every_law(store) if engine in row]
    order = ("not offered", "emulated", "in part emulated", "own")
    return sorted(rows, key=lambda row: order.index(row[1].word))
