"""Emulated features: what adapters compute in place of their engines, by case and track, from the catalogue."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

TOLD = 0.1
"""From this share of a price on it is told how much of it is the adapter's own work."""


@dataclass(frozen=True, slots=True)
class Made:
    """A feature that an adapter makes; the fields as in `harness.adapter.Emulation`, the feature by its name."""

    engine: str
    feature: str
    how: str
    where: str
    tracks: tuple[str, ...]


def made(catalogue: Mapping[str, Any], engine: str, case: str | None = None, track: str | None = None) -> list[Made]:
    """What an engine's adapter makes; only of what a case uses, or on one track, where these are given.

    A variant, which is no track of its own, has what the tuned settings have that it is built on.
    """
    about = catalogue.get("engines", {}).get(engine, {})
    used = None if case is None else catalogue.get("cases", {}).get(case, {}).get("features", ())
    named = track if track in about.get("tracks", {}) else "tuned"
    return [
        Made(engine, emulation["feature"], emulation["how"], emulation["where"], tuple(emulation["tracks"]))
        for emulation in about.get("emulated", ())
        if (used is None or emulation["feature"] in used) and (track is None or named in emulation["tracks"])
    ]


def whose(catalogue: Mapping[str, Any], engine: str, case: str, track: str) -> str:
    """'restitution emulated' or 'springs, drives emulated'; '' where every law that the case uses is the engine's own.

    Of what an adapter makes in some scenes only: 'springs in part emulated'.
    """
    emulations = made(catalogue, engine, case, track)
    names = dict.fromkeys(
        f"{emulation.feature.replace('_', ' ')}{' in part' if emulation.where else ''}" for emulation in emulations
    )
    return f"{', '.join(names)} emulated" if names else ""


def share_in_words(share: float | None) -> str:
    """'74 % is the adapter's own'; '' where it is a tenth at most, or was not measured."""
    return f"{100 * share:.0f} % is the adapter's own" if share is not None and share > TOLD else ""
