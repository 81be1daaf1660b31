"""Which setting makes an engine's track end elsewhere in a scene without a truth: one row for each that was turned alone."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.setting_causes import Turned, cause_words, settings_turned
from plumbline.harness.findings.columns import Column, Table, names, plain
from plumbline.harness.store.store import Store


class _Cause(NamedTuple):
    turned: Turned
    summary: str


def _causes(store: Store) -> Iterator[_Cause]:
    for agreement in agreements(store):
        turned = settings_turned(store, agreement)
        summary = " ".join(cause_words(turned, agreement, store.titles))
        yield from (_Cause(each, summary) for each in turned)


def _sentences(causes: Sequence[_Cause]) -> list[str]:
    return list(dict.fromkeys(cause.summary for cause in causes)) or ["No setting was turned: no engine's tracks end apart."]


TABLE = Table(
    holds=names(Turned, path="turned") + " summary",
    objects=_causes,
    shown=(
        Column("scene", lambda row: row.turned.case.rsplit("/", 1)[-1]),
        *(Column(name, f"turned.{name}") for name in ("engine", "track", "setting", "value", "towards")),
        *plain("before=turned.before:.2g", "after=turned.after:.2g"),
        Column("closes", lambda row: "" if row.turned.closes is None else f"{100 * row.turned.closes:.0f} %"),
        Column("cause", lambda row: "yes" if row.turned.cause else ""),
    ),
    sentences=_sentences,
)
