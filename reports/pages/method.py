"""The page on method: how answers are judged and timed, what the outcomes mean, and how to run anything again."""

from collections.abc import Mapping
from operator import itemgetter
from typing import Any

from pandas import Series

from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store
from plumbline.reports.html.template import filled_page
from plumbline.reports.words.called import WORDS
from plumbline.reports.words.catalogue import cases
from plumbline.reports.words.citation import citation
from plumbline.reports.words.emulated_features import own_everywhere, told_apart
from plumbline.reports.words.glossary import indexed

TRUTHS = WORDS["truths"]
"""By kind, what judges; the reference engine is none of them."""


def told(store: Store) -> Mapping[str, Any]:
    """What the template is told."""
    samples = store.samples
    timing = {
        "samples": len(samples),
        "trials": samples["trial"].nunique() if len(samples) else 0,
        "processes": int(samples.groupby("trial")["process"].nunique().max()) if len(samples) else 0,
        "blocks": int(samples.groupby("trial")["block"].nunique().max()) if len(samples) else 0,
        "canary": spread(samples["canary"]) if len(samples) else None,
    }
    by_truth = grouped(cases(store).values(), itemgetter("truth"))
    return {
        "machine": store.machine,
        "timing": timing,
        "laws": told_apart(store),
        "own": own_everywhere(store),
        "truths": [(kind, TRUTHS.get(kind, ""), rows) for kind, rows in by_truth.items()],
        "folder": str(store.folder),
        "citation": citation(store),
        "concepts": indexed(store),
    }


def spread(canary: Series) -> float | None:
    """Middle half of the canary's readings over their median [1]: how steady the machine was."""
    middle = float(canary.median())
    return None if not middle > 0 else float(canary.quantile(0.75) - canary.quantile(0.25)) / middle


PAGE = filled_page("method", "Method", 90, told)
