"""What a store holds: its cases by family, its engines and its tracks, also where the catalogue lacks one."""

import re
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from plumbline.harness.store.store import Store
from plumbline.harness.study.engine_versions import engine_of
from plumbline.reports.words.called import WORDS
from plumbline.reports.words.text import knobs, powers, settings_text, slug, visible

FAMILIES: dict[str, str] = WORDS["families"]
"""Titles of the families, in the order from the simple to the composed."""

TRACK_ORDER = {"default": 0, "tuned": 1}

CASE: dict[str, Any] = {
    "title": "",
    "question": "This case is not in the catalogue of the run.",
    "truth": "",
    "effects": [],
    "source": "",
    "parameters": {},
    "duration": None,
    "dt": None,
    "ladder": [],
    "headline": "",
    "scale": None,
    "hard": None,
    "checks": [],
    "bodies": None,
    "features": [],
}
ENGINE: dict[str, Any] = {
    "title": "",
    "distribution": "",
    "version": None,
    "unavailable": None,
    "ours": False,
    "features": [],
    "tracks": {},
    "known_failures": {},
    "deviations": [],
    "emulated": [],
    "batch": False,
    "advantages": {},
}


@lru_cache(maxsize=2)
def cases(store: Store) -> dict[str, dict[str, Any]]:
    """All cases that have a trial, in the catalogue's order; the whole catalogue where there is no trial at all."""
    return {
        name: {"family": re.split("[_:]", str(name), maxsplit=1)[0]} | about
        for name, about in _met(store, "case", CASE).items()
    }


def _met(store: Store, kind: str, blank: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """What the catalogue says of what has a trial, of all that it has where there is none. Args: blank: what else it says."""
    catalogue, tried = store.catalogue.get(f"{kind}s", {}), list(store.trials[kind].unique())
    names = [name for name in catalogue if name in tried or not tried] + [name for name in tried if name not in catalogue]
    listed = {name: {**blank, "name": name, **catalogue.get(name, {})} for name in names}
    return {name: about | {"title": about["title"] or name} for name, about in listed.items()}


def families(store: Store) -> list[tuple[str, list[dict[str, Any]]]]:
    """Titles of families with their cases, families from the simple to the composed and then by name."""
    groups: dict[str, list[dict[str, Any]]] = {}
    for case in cases(store).values():
        groups.setdefault(case["family"], []).append(case)
    order = list(FAMILIES)
    ranked = sorted(groups, key=lambda name: (order.index(name) if name in FAMILIES else len(order), name))
    return [(FAMILIES.get(name, name), groups[name]) for name in ranked]


@lru_cache(maxsize=2)
def engines(store: Store) -> dict[str, dict[str, Any]]:
    """All engines that have a trial, as the catalogue has them; ours last: on a narrow screen the first columns are read."""
    return dict(sorted(_met(store, "engine", ENGINE).items(), key=lambda pair: bool(pair[1]["ours"])))


def engine_title(store: Store, name: str) -> str:
    """What an engine is called, one that has no trial too."""
    return str(store.catalogue.get("engines", {}).get(name, {}).get("title") or name)


def titles(store: Store) -> dict[str, str]:
    """What cases and engines are called, by name."""
    return {name: str(about["title"]) for name, about in (*cases(store).items(), *engines(store).items())}


@lru_cache(maxsize=2)
def labels(store: Store) -> Mapping[str, str]:
    """What an engine is called in charts: its title, with its name where two share one, and a mark where it is ours."""
    known = engines(store)
    titles = [engine["title"] for engine in known.values()]
    return {
        name: visible(engine["title"] if titles.count(engine["title"]) == 1 else f"{engine['title']} ({name})")[:60]
        + (" (ours)" if engine["ours"] else "")
        for name, engine in known.items()
    }


def titled(store: Store, case: str, where: str) -> str:
    """A scene in words: the case's title and what sets it apart."""
    title = cases(store).get(case, {}).get("title", case)
    return visible(f"{title}, {where}" if where else str(title))[:70]


def case_file(name: str) -> str:
    """The page of a case."""
    return f"case-{slug(name)}.html"


def engine_file(name: str) -> str:
    """The page of an engine."""
    return f"engine-{slug(name)}.html"


def ours(store: Store) -> list[str]:
    """The engines that are ours, which no ranking contains."""
    return [name for name, engine in engines(store).items() if engine["ours"]]


def more_is_better(case: Mapping[str, Any]) -> bool:
    """Is the headline of a case a share or the like, of which more is better?"""
    return any(check["metric"] == case["headline"] and check.get("better") == "higher" for check in case["checks"])


@lru_cache(maxsize=2)
def tracks(store: Store) -> list[str]:
    """The tracks that were run, 'default' before 'tuned' before others."""
    return sorted(store.trials["track"].unique(), key=lambda track: (TRACK_ORDER.get(track, 2), track))


@lru_cache(maxsize=2)
def named_tracks(store: Store) -> list[str]:
    """The tracks that the study names, in the same order; not the settings that a search went on to."""
    trials = store.trials
    return sorted(trials["track"][trials["round"] == 0].unique(), key=lambda track: (TRACK_ORDER.get(track, 2), track))


def compared_tracks(store: Store) -> list[str]:
    """Of these the two that every engine has: a setting that a study names beside them is one engine's own."""
    return [track for track in named_tracks(store) if track in TRACK_ORDER]


@lru_cache(maxsize=2)
def _variants(store: Store) -> Mapping[tuple[str, str], Mapping[str, Any]]:
    """What the study says of its settings beside the two tracks, by engine and name."""
    listed = store.study.get("variants", {})
    groups = listed.items() if isinstance(listed, dict) else ()
    return {
        (engine, name): variant
        for engine, group in groups
        if isinstance(group, dict)
        for name, variant in group.items()
        if isinstance(variant, dict)
    }


@lru_cache(maxsize=1024)
def setting_words(store: Store, engine: str, track: str) -> str:
    """A track or a group of settings as a sentence names it: 'tuned', 'tuned, split impulse on'.

    Of a setting that the study names, the track it is laid over and what it changes there: 'default with solver cg'.
    """
    variant = _variants(store).get((engine_of(engine), track))
    if track in TRACK_ORDER or variant is None:
        return knobs(track)
    changed = {name: value for name, value in variant.items() if name not in ("on", "beside", "changes", "source")}
    words = settings_text(changed).replace("_", " ")
    return powers(f"{variant.get('on', 'tuned')}{f' with {words}' if words else ''}")
