"""The time that a run still takes, by sequences of durations: one that was recorded, and ladders whose truth is known."""

import json
from itertools import product
from pathlib import Path

import pytest

from harness.run.progress import in_words
from harness.run.remaining_time import Piece, RemainingTime

RECORD = json.loads((Path(__file__).parent / "recorded_progress.json").read_text(encoding="utf-8"))


def test_of_a_recorded_run_it_is_within_half_as_much_again_after_the_first_tenth() -> None:
    pieces = [
        Piece(name=str(number), case=case, engine=engine, steps=steps, samples=0.03, group=experiment + case)
        for number, (experiment, case, engine, steps, _) in enumerate(RECORD["answers"])
    ]
    remaining = RemainingTime(workers=2)
    remaining.expect(pieces)
    remaining.answers_begin(RECORD["order"], 0.0)
    whole = RECORD["groups"][-1][-1]
    ratios = []

    def look(now: float) -> None:
        left = remaining.left()
        if 0.1 * whole < now < 0.95 * whole:
            assert left is not None
            ratios.append(left / (whole - now))

    for piece, (*_, end) in zip(pieces, RECORD["answers"], strict=True):
        remaining.answered(piece.name, end, to_clock=True)
        look(end)
    remaining.clocks_begin([piece.name for piece in pieces], RECORD["clocks_begin"])
    for experiment, case, end in RECORD["groups"]:
        for piece in pieces:
            if piece.group == experiment + case:
                remaining.clocked(piece.name, end)
        look(end)
    assert len(ratios) > 50
    # One group of the record took thrice as long as any other: what is foreseen just behind it is too much, but not by twice.
    assert all(1 / 2 < ratio < 2 for ratio in ratios)
    assert sum(1 / 1.5 < ratio < 1.5 for ratio in ratios) >= 0.9 * len(ratios)
    assert remaining.left() == pytest.approx(0.0)


@pytest.mark.parametrize("workers", [1, 2])
def test_along_a_ladder_it_grows_with_the_number_of_steps(workers: int) -> None:
    """Three engines with rates of their own, coarse to fine: by the mean of the past the end would be a surprise."""
    rates = {"a": 1e-3, "b": 4e-3, "c": 2e-4}
    pieces = [Piece(name=f"{e}{k}", case="x", engine=e, steps=100 * 2**k) for k, e in product(range(8), rates)]
    seconds = {piece.name: 0.3 + rates[piece.engine] * piece.steps for piece in pieces}
    remaining = RemainingTime(workers)
    remaining.expect(pieces)
    remaining.answers_begin([piece.name for piece in pieces], 0.0)
    free, ends = [0.0] * workers, []
    for piece in pieces:
        begin = free.pop(free.index(min(free)))
        free.append(begin + seconds[piece.name])
        ends.append((begin + seconds[piece.name], piece.name))
    whole = max(free)
    for end, name in sorted(ends):
        remaining.answered(name, end, to_clock=False)
        if 0.1 * whole < end < 0.9 * whole:
            left = remaining.left()
            assert left is not None
            assert 1 / 1.5 < left / (whole - end) < 1.5


def test_the_first_answer_of_an_engine_is_not_taken_for_the_others() -> None:
    remaining = RemainingTime(workers=1)
    pieces = [Piece(name=str(k), case=f"case{k}", engine="e", steps=100) for k in range(42)]
    remaining.expect(pieces)
    remaining.answers_begin([piece.name for piece in pieces], 0.0)
    remaining.answered("0", 60.0, to_clock=False)  # it compiled
    remaining.answered("1", 61.0, to_clock=False)
    assert remaining.left() == pytest.approx(40.0)


def test_what_has_an_answer_or_is_not_clocked_is_not_counted() -> None:
    remaining = RemainingTime(workers=1)
    assert remaining.left() is None
    remaining.expect([Piece(name=str(k), case="x", engine="e", steps=100, samples=5.0) for k in range(4)])
    remaining.answers_begin(["0", "1", "2", "3"], 0.0)
    for number in (0, 1):
        remaining.answered(str(number), 1.0 + number, to_clock=False)
    remaining.forget(["2", "3"])
    remaining.clocks_begin([], 2.0)
    assert remaining.left() == 0.0


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.2, "0 s"), (47.3, "47 s"), (99.9, "1.7 min"), (130.0, "2.2 min"), (3025.0, "50 min"), (9000.0, "2.5 h")],
)
def test_an_estimate_has_two_digits(seconds: float, text: str) -> None:
    assert in_words(seconds) == text
