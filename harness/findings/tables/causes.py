"""Which setting makes an engine's track end elsewhere in a scene without a truth: one row for each that was turned alone."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, fields
from typing import Any

from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.setting_causes import Turned, cause_words, settings_turned
from plumbline.harness.findings.columns import Column, Row, Table, plain
from plumbline.harness.store.store import Store


def _rows(store: Store) -> Iterator[dict[str, Any]]:
    for agreement in agreements(store):
        turned = settings_turned(store, agreement)
        summary = " ".join(cause_words(turned, agreement, store.titles))
        for each in turned:
            yield asdict(each) | {"summary": summary}


def _sentences(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(row["summary"] for row in rows)) or ["No setting was turned: no engine's tracks end apart."]


TABLE = Table(
    columns=(*(field.name for field in fields(Turned)), "summary"),
    objects=_rows,
    row=dict,
    shown=(
        Column("scene", lambda row: row["case"].rsplit("/", 1)[-1]),
        *plain("engine", "track", "setting", "value", "towards"),
        Column("before", "before", ".2g"),
        Column("after", "after", ".2g"),
        Column("closes", lambda row: "" if row["closes"] is None else f"{100 * row['closes']:.0f} %"),
        Column("cause", lambda row: "yes" if row["cause"] else ""),
    ),
    sentences=_sentences,
)
"""The rows."""
