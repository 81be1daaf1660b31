"""Why a trial ended as it did, in words: made of what was measured, with metrics and effects by their titles."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import pandas as pd

from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.store import Store
from plumbline.reports.words.text import amount, unit_text


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
