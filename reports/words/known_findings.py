"""Which findings about engines a run is concerned with: those of its engines, and of a case those that show in it.

Which claims are disputed, from the table `disputed.toml`: an objection is marked before anybody has looked into it.
"""

import tomllib
from datetime import date
from functools import lru_cache
from pathlib import Path

from pydantic import ConfigDict, Field, TypeAdapter
from pydantic.dataclasses import dataclass

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


TABLE = Path(__file__).parents[1] / "disputed.toml"


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid"))
class Dispute:
    """A claim that is disputed.

    Terms: axis: the parameter that the limits study makes harder, '' for all that is said of the case. study: the study that
    says it, '' for all. why: in a line, what the objection says. reference: where it stands.
    """

    engine: str = Field(min_length=1)
    case: str = Field(min_length=1)
    since: date
    why: str = Field(min_length=1)
    reference: str = Field(min_length=1)
    axis: str = ""
    study: str = ""


@lru_cache(maxsize=4)
def read(table: Path) -> tuple[Dispute, ...]:
    """The rows of a table. Raises: pydantic.ValidationError, with the row and the field."""
    rows = tomllib.loads(table.read_text(encoding="utf-8")).get("disputed", [])
    return TypeAdapter(tuple[Dispute, ...]).validate_python(rows)


def told(store: Store, case: str) -> list[Dispute]:
    """What is disputed of a case in the study of a run."""
    study = store.study.get("name", "")
    return [dispute for dispute in read(TABLE) if dispute.case == case and dispute.study in ("", study)]


def disputed(store: Store, engine: str, case: str, axis: str = "") -> str:
    """'disputed since 2026-11-23: why (reference)' of a claim on an engine in a case, or along an axis of it; else ''.

    A row about an axis alone marks nothing else of its case.
    """
    mine = [dispute for dispute in told(store, case) if dispute.engine == engine and dispute.axis in ("", axis)]
    return "; ".join(f"disputed since {dispute.since}: {dispute.why} ({dispute.reference})" for dispute in mine)
