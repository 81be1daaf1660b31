"""What is said of scenes of one's own: an engine that agreed with the others, and does so no more."""

from collections.abc import Iterable, Iterator

from plumbline.harness.findings.agreement import Agreement, Side, Word, agreements
from plumbline.harness.findings.changes.matching import scene_of
from plumbline.harness.findings.changes.values import Change, Sense
from plumbline.harness.store.store import Store

_RANK: dict[Word, int] = {"agrees": 0, "converges elsewhere": 1, "does not converge": 2, "diverged": 3, "cannot": 4}
"""How far a word is from agreement. 'converges' alone is said where nothing is agreed: that is no fault of an engine."""


def own_verdict_changes(store_a: Store, store_b: Store) -> Iterator[Change]:
    """A row for each engine and track of whose limit another word is said. Raises: StoreError, where trajectories are gone."""
    return changed_words(agreements(store_a), agreements(store_b))


def changed_words(agreed: Iterable[Agreement], agreed_again: Iterable[Agreement]) -> Iterator[Change]:
    """The same of agreements."""
    before = {_key(one, side): side for one in agreed for side in one.sides}
    for one in agreed_again:
        for side in one.sides:
            earlier = before.get(_key(one, side))
            if earlier is not None and earlier.word != side.word:
                yield Change(
                    kind="verdict",
                    sense=_sense(earlier.word, side.word),
                    case=one.case,
                    engine=side.engine,
                    track=side.track,
                    metric="limit",
                    before=earlier.word,
                    after=side.word,
                    detail=side.why or "judged by the limits of all engines",
                )


def _key(one: Agreement, side: Side) -> tuple[str, str, str, str]:
    return scene_of(one.case), one.where, side.engine, side.track


def _sense(before: Word, after: Word) -> Sense:
    if before not in _RANK or after not in _RANK:
        return "neither"
    return "worse" if _RANK[after] > _RANK[before] else "better"
