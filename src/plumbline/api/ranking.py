"""Which engine, for what is needed, and how surely: the ranking of a run folder."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING

import pandas as pd

from plumbline.api.arguments import checked, within
from plumbline.api.frames import described
from plumbline.api.results import Results, open_results
from plumbline.harness.findings.selection import CRITERIA, PresetError, Wish, choose, read_preset
from plumbline.harness.findings.selection.listing import ranking
from plumbline.harness.findings.selection.wish import merged, unmatched
from plumbline.harness.intake.safe_text import quoted

if TYPE_CHECKING:
    from plumbline.harness.findings.selection import Selection


@dataclass(frozen=True, repr=False)
class Ranking:
    """Engines in order, with the doubt about it. Terms: sentence: the answer in words. answer: all of it, which may change."""

    sentence: str
    answer: "Selection"

    def __repr__(self) -> str:
        """The answer in words."""
        return self.sentence

    def frame(self) -> pd.DataFrame:
        """A row an engine, the first one first; those that are left out have no place."""
        names = ["engine", "place", "first", "score", "low", "high", "track", "left_out"]
        return described("ranking", pd.DataFrame(ranking(self.answer), columns=names))


@checked
def select(
    results: Results | str | PathLike[str],
    need: Sequence[str] = (),
    *,
    error: float | None = None,
    strict: bool = False,
    realtime: float | None = None,
    features: Sequence[str] = (),
    weights: Mapping[str, float] | None = None,
    preset: str = "",
    licences: Sequence[str] = (),
    platform: str = "",
    with_reference: bool = False,
) -> Ranking:
    """Rank the engines of a run for what is needed: what `plumbline select` does.

    Args:
        results: of `compare`, `open` or `published`, or the path of a run folder.
        need: families or patterns of cases that count, like "friction"; all if empty.
        error: asked for, a share of a case's scale; 0.01 if None. strict: leave out engines that do not reach it in each
            case.
        realtime: how many times faster than real time at that error.
        features: that an engine has to have. licences: SPDX identifiers, of which it has one. platform: like "linux-x86_64".
        weights: of criteria, 0 or more; 1 if not given. preset: weights and cases of a purpose: games, legged, manipulation,
            rl-throughput, sensors, teaching, vehicles, or the path of a file.
        with_reference: rank the reference engine too.
    Raises: PlumblineError, with what was given and what was expected.
    """
    store = (results if isinstance(results, Results) else open_results(results)).store
    base = read_preset(preset).wish() if preset else Wish()
    for name, weight in (weights or {}).items():
        if name not in CRITERIA or not 0 <= weight <= 1000:
            raise PresetError(f"weights: {quoted(name)}: {weight}, expected 0..1000 for some of {', '.join(CRITERIA)}")
    for name, there in unmatched(store, need):
        raise PresetError(f"need: {quoted(name)} is no family or case of this run, expected some of {there}")
    within("error", error, 1e-12, 1.0)
    within("realtime", realtime, 1e-12, 1e12)
    wish = merged(
        base,
        cases=dict.fromkeys(need, 1.0),
        features=tuple(features),
        max_error=error,
        strict=strict,
        realtime=realtime,
        weights={**base.weights, **(weights or {})},
        licences=tuple(licences),
        platform=platform,
        with_reference=with_reference,
    )
    from plumbline.harness.findings.selection.words import headline

    answer = choose(store, wish)
    titles = store.titles
    return Ranking(headline(answer, lambda name: titles.get(name, name)), answer)
