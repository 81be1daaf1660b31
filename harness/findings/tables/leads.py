"""How many axes, and pairs of case and error, each engine leads at equal sub-step and at equal time, with ours and without."""

from collections.abc import Iterator, Sequence

from plumbline.harness.findings.columns import Column, Table, names, plain
from plumbline.harness.findings.limits_found import searches
from plumbline.harness.findings.prices import priced
from plumbline.harness.findings.standing import Lead, axis_leads, pair_leads, reaches
from plumbline.harness.store.store import Store


def _leads(store: Store) -> Iterator[Lead]:
    prices = priced(store)
    yield from axis_leads(reaches(searches(store)))
    yield from pair_leads(prices.prices, prices.points)


def _sentences(rows: Sequence[Lead]) -> list[str]:
    """Condition by condition, who leads how often."""
    lines = []
    for key in dict.fromkeys((row.what, row.at, row.condition, row.ours) for row in rows):
        mine = [row for row in rows if (row.what, row.at, row.condition, row.ours) == key]
        what, at, condition, ours = key
        counts = ", ".join(
            f"{row.engine} {row.alone} alone and {row.shared} with others of {row.of}"
            for row in sorted(mine, key=lambda row: -row.alone - row.shared)
        )
        lines.append(f"{what} led at {at}{f' ({condition})' if condition else ''}{'' if ours else ', without ours'}: {counts}.")
    return lines


TABLE = Table(
    holds=names(Lead),
    objects=_leads,
    shown=(
        *plain("of=what", "at", "condition"),
        Column("with ours", lambda row: "yes" if row.ours else "no"),
        *plain("engine", "alone", "with others=shared", "asked=of"),
    ),
    sentences=_sentences,
)
