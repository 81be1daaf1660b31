"""Which findings about engines a run is concerned with: those of its engines, and of a case those that show in it."""

from functools import lru_cache

from plumbline.harness.findings.vendor_findings import Finding, shelf
from plumbline.harness.store.store import Store
from plumbline.reports.words.catalogue import engines

_ORDER = {"bug": 0, "trap": 1, "limit": 2}


@lru_cache(maxsize=1)
def _every() -> tuple[Finding, ...]:
    return tuple(sorted(shelf(), key=lambda finding: (_ORDER[finding.kind], finding.name)))


def by_engine(store: Store) -> dict[str, list[Finding]]:
    """Engines of the run to what is known of each, bugs first; an engine of which nothing is known is left out."""
    groups = {name: [finding for finding in _every() if finding.engine == name] for name in engines(store)}
    return {name: group for name, group in groups.items() if group}


def of_case(store: Store, case: str) -> list[Finding]:
    """Those of the run's engines that show in a case."""
    return [finding for group in by_engine(store).values() for finding in group if case in finding.cases]
