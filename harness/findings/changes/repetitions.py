"""Determinism lost or won: repetitions that must give the same bits, and did on one side only."""

from collections.abc import Iterator, Mapping
from typing import Any

from plumbline.harness.findings.changes.values import Change
from plumbline.harness.findings.tables.determinism import Agreement, agreements
from plumbline.harness.store.store import Store

_SAME, _DIFFERS = "bit-identical", "differs"


def repetition_changes(store_a: Store, store_b: Store) -> Iterator[Change]:
    """A row for each. Raises: StoreError, where a trajectory is not kept any more."""
    return lost_and_won(*(agreements_by_cell(store) for store in (store_a, store_b)))


def lost_and_won(before: Mapping[Any, Agreement], after: Mapping[Any, Agreement]) -> Iterator[Change]:
    """The same of repetitions by what was repeated."""
    for cell, now in after.items():
        then = before.get(cell)
        if then is not None and now.must and {then.verdict, now.verdict} == {_SAME, _DIFFERS}:
            yield Change(
                kind="determinism",
                sense="worse" if now.verdict == _DIFFERS else "better",
                case=now.case,
                engine=now.engine,
                track=now.track,
                metric=now.way,
                trial_a=then.trial,
                trial_b=now.trial,
                before=then.verdict,
                after=now.verdict,
                detail="" if now.first_step is None else f"from step {now.first_step} on",
            )


def agreements_by_cell(store: Store) -> dict[tuple[Any, ...], Agreement]:
    """What repetitions gave, by what was repeated and how. Raises: StoreError."""
    parameters = dict(zip(store.trials["trial"], store.trials["parameters"], strict=True))
    return {
        (agreement.case, parameters.get(agreement.trial), agreement.engine, agreement.track, agreement.way): agreement
        for agreement in agreements(store)
    }
