"""How each outcome of a trial is shown: a symbol, a word and a colour, never a colour alone; and why it ended so, in words."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import pandas as pd

from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.store import Store
from plumbline.reports.words.called import WORDS
from plumbline.reports.words.text import amount, unit_text


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusWord:
    """An outcome as a reader meets it.

    Terms:
        name: as in the table `trials`. symbol: one character that differs in shape from all others. answered: is there a
        trajectory that a metric could judge? meaning: for the legend. rank: the higher, the worse.
    """

    name: str
    symbol: str
    meaning: str
    rank: int
    answered: bool = False

    @property
    def style(self) -> str:
        """The name as a class of the style sheet."""
        return self.name.replace(" ", "-")


STATUSES, VERDICTS, _OTHERS = (
    {name: StatusWord(name=name, **about) for name, about in WORDS[table].items()}
    for table in ("statuses", "verdicts", "others")
)
"""Outcomes of trials, and verdicts on engines in a scene without a truth."""
FINITE, UNKNOWN, NOT_RUN = _OTHERS.values()
"""What 'passed' means in a scene of one's own, whose trials are asked nothing else; a status of a newer store; of a robot."""


def outcome(name: str) -> StatusWord:
    """The outcome of that name; a name from a newer store is shown as unknown, not hidden."""
    return STATUSES.get(name, UNKNOWN)


def worst(names: Iterable[str]) -> StatusWord:
    """The one that a reader must not miss."""
    return max((outcome(name) for name in names), key=lambda candidate: candidate.rank)


@lru_cache(maxsize=2)
def reasons(store: Store) -> Mapping[str, str]:
    """By trial. One that was judged says which checks do not hold, by how much, or which could not be measured; others say
    what the run said."""
    ended = store.trials[["trial", "status", "reason"]].itertuples(index=False)
    return {str(trial): _reason(str(status), str(reason), store.measured.get(trial, ())) for trial, status, reason in ended}


def _reason(status: str, stored: str, measured: Sequence[Mapping[str, Any]]) -> str:
    """A metric that a case checks twice has a number from the second on."""
    seen: dict[str, int] = {}
    broken, blind = [], []
    for row in measured:
        name = str(row["metric"])
        seen[name] = seen.get(name, 0) + 1
        title = metric_title(f"{name} #{seen[name]}" if seen[name] > 1 else name)
        if pd.isna(row["passed"]):
            blind += [title] * (not pd.isna(row["at_most"]))
        elif not row["passed"]:
            broken.append(f"{title} {_with_bound(row)}")
    if status == "failed" and broken:
        return "; ".join(broken)
    if status == "passed" and blind:
        return f"every check holds; not measurable: {', '.join(blind)}"
    return stored


def _with_bound(measured: Mapping[str, Any]) -> str:
    """'0.25 m, bound 0.1 m'."""
    unit = "" if measured["unit"] in (None, "", "1") else f" {unit_text(str(measured['unit']))}"
    return f"{amount(measured['value'])}{unit}, bound {amount(measured['at_most'])}{unit}"


def notices(store: Store, trial: str) -> list[str]:
    """What an engine, its adapter or the harness had to say of a trial, in their words."""
    return list(map(str, store.notices.get(trial, ())))
