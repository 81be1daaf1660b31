"""What the first three steps of a run tell: who lies together at them and who apart. It is no verdict: smaller steps follow."""

from collections.abc import Mapping

from plumbline.harness.findings.agreement.happened import happened_words, happenings
from plumbline.harness.findings.agreement.values import Agreement, Side, Word
from plumbline.harness.findings.agreement.words import called, length, up_to
from plumbline.harness.store.store import Store

SO_FAR: Mapping[Word, str] = {
    "agrees": "together",
    "converges elsewhere": "apart",
    "converges": "settling, each by itself",
    "does not converge": "not settled yet",
    "diverged": "diverged",
    "cannot": "without an answer",
}
COLUMNS = ("scene", "engine", "track", "so far", "up to", "moved by the last halving", "away")


def rows_so_far(agreement: Agreement) -> list[tuple[str, ...]]:
    """One row for each engine and track, as `COLUMNS`."""
    return [(agreement.case.rsplit("/", 1)[-1], side.engine, side.track, *_cells(side, agreement)) for side in agreement.sides]


def _cells(side: Side, agreement: Agreement) -> tuple[str, ...]:
    limit = side.limit
    until = f"{limit.seen_until:.3g} s" if limit.seen_until else ""
    moved = "" if limit.moved is None else length(float(limit.moved[-1]), agreement)
    return SO_FAR[side.word], until, moved, "" if side.distance is None else length(side.distance, agreement)


def words_so_far(store: Store, agreement: Agreement, titles: Mapping[str, str]) -> list[str]:
    """Who lies together and who does not, then what happens at the finest of the steps."""
    by_word = {word: [side for side in agreement.sides if side.word == word] for word in SO_FAR}
    parts = [
        f"{SO_FAR[word]}{_how(word, sides, agreement)}: {called([(s.engine, s.track) for s in sides], agreement, titles)}"
        for word, sides in by_word.items()
        if sides
    ]
    first, *others = happened_words(happenings(store, agreement), agreement, titles) or [""]
    at_finest = [f"At the finest of these steps: {first}", *others] if first else []
    return [f"So far {'; '.join(parts)}. Smaller steps may change that.", *at_finest]


def _how(word: Word, sides: list[Side], agreement: Agreement) -> str:
    if word == "agrees":
        return f" {up_to(agreement, agreement.until)}"
    away = max((side.distance or 0.0 for side in sides), default=0.0)
    return f", by {length(away, agreement)} at most" if word == "converges elsewhere" else ""
