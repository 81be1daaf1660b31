"""The name of a group of settings that a search went on to: the track that it descends from, and the knobs that it turned."""

from collections.abc import Iterable

_BETWEEN = ", "


def label_of(track: str, turned: Iterable[tuple[str, object]]) -> str:
    """'tuned, iterations 40': what trials, tables and pages call the settings. Args: turned: knobs with where they stand."""
    return _BETWEEN.join((track, *(f"{knob} {value}" for knob, value in turned)))
