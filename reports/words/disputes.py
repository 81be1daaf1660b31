"""Which claims are disputed, from the table `disputed.toml`: an objection is marked before anybody has looked into it."""

import tomllib
from datetime import date
from functools import lru_cache
from pathlib import Path

from pydantic import ConfigDict, Field, TypeAdapter
from pydantic.dataclasses import dataclass

from plumbline.harness.store.store import Store

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
