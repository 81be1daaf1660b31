"""The page on findings: what is wrong, or a trap, in the engines of a run, each with the script that shows it."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.store.store import Store
from plumbline.reports.html.template import filled_page
from plumbline.reports.words.known_findings import by_engine


def told(store: Store) -> Mapping[str, Any]:
    """Findings by engine, with the versions that were run."""
    versions = store.trials.groupby("engine")["engine_version"].first().astype(str).to_dict()
    return {"groups": by_engine(store), "versions": versions}


PAGE = filled_page("findings", "Findings", 80, told, concerns=lambda store: bool(by_engine(store)))
