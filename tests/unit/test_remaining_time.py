"""The time that a run still takes: runs that were recorded are played back, and ladders and clocks whose truth is known."""

from itertools import product
from pathlib import Path

import pytest

from harness.run.pieces import Awaited, Piece
from harness.run.progress import in_words
from harness.run.remaining_time import LEAP, WIDEST, Estimate, RemainingTime
from tests.replay_progress import Recording, held, played, read_recordings

RECORDINGS = read_recordings(Path(__file__).parent / "recorded_progress.json")


@pytest.mark.parametrize("recording", RECORDINGS, ids=lambda recording: recording.name)
def test_of_a_recorded_run_no_range_is_wide_and_no_leap_unexplained(recording: Recording) -> None:
    looks = played(recording)
    of = held(looks)
    assert of.looks > 0
    assert of.widest <= WIDEST * (1 + 1e-12)
    assert of.leaps == 0
    assert of.within >= 0.6 * of.told
    last = looks[-1].said
    assert last is not None
    assert last.high <= 0.1 * recording.whole


def test_of_ten_looks_at_recorded_runs_nine_hold() -> None:
    """Behind the first tenth of each run: most looks tell something, and the truth lies within nine of ten told ranges."""
    each = [held(played(recording)) for recording in RECORDINGS]
    looks, told, within, near = (sum(getattr(of, name) for of in each) for name in ("looks", "told", "within", "near"))
    assert told >= 0.8 * looks
    assert within >= 0.9 * told
    assert near >= 0.75 * told


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
    whole, told = max(free), 0
    for end, name in sorted(ends):
        remaining.answered(name, end, to_clock=False)
        left = remaining.left()
        if left is not None and 0.1 * whole < end < 0.9 * whole:
            told += 1
            assert 1 / 1.5 < left.middle / (whole - end) < 1.5
            assert left.low < whole - end < left.high
    assert told >= 5


def test_the_first_answer_of_an_engine_is_not_taken_for_the_others() -> None:
    remaining = RemainingTime(workers=1)
    pieces = [Piece(name=str(k), case=f"case{k}", engine="e", steps=100) for k in range(42)]
    remaining.expect(pieces)
    remaining.answers_begin([piece.name for piece in pieces], 0.0)
    remaining.answered("0", 60.0, to_clock=False)  # it compiled
    remaining.answered("1", 61.0, to_clock=False)
    left = remaining.left()
    assert left is not None
    assert left.middle == pytest.approx(40.0)


def test_what_has_an_answer_or_is_not_clocked_is_not_counted() -> None:
    remaining = RemainingTime(workers=1)
    assert remaining.left() is None
    remaining.expect([Piece(name=str(k), case="x", engine="e", steps=100, count=3, sample=1.0) for k in range(4)])
    remaining.answers_begin(["0", "1", "2", "3"], 0.0)
    for number in (0, 1):
        remaining.answered(str(number), 1.0 + number, to_clock=False)
    remaining.forget(["2", "3"])
    remaining.clocks_begin([], 2.0)
    assert remaining.left() == Estimate(0.0, 0.0)


def test_with_the_first_timing_of_a_group_all_of_it_is_done() -> None:
    """Timings of a group come at one instant: what is told behind the first of them counts the others no more."""
    remaining = RemainingTime(workers=1)
    pieces = [
        Piece(name=f"{case}{k}", case=case, engine="e", steps=100, count=3, sample=1.0, group=case)
        for case in ("x", "y")
        for k in range(3)
    ]
    names = [piece.name for piece in pieces]
    remaining.expect(pieces)
    remaining.answers_begin(names, 0.0)
    for number, name in enumerate(names):
        remaining.answered(name, 0.3 * (number + 1), to_clock=True)
    remaining.clocks_begin(names, 2.0)
    remaining.clocked("x0", 16.0)
    first = remaining.left()
    remaining.clocked("x1", 16.0)
    remaining.clocked("x2", 16.0)
    assert first is not None
    assert remaining.left() == Estimate(first.low, first.high)
    # The group had three trials, each calibrated over a sample and then sampled thrice: twelve seconds, and what starts take.
    assert first.low < 14.0 < first.high
    remaining.clocked("y0", 30.0)
    assert remaining.left() == Estimate(0.0, 0.0)


def test_what_runs_already_has_had_its_time() -> None:
    remaining = RemainingTime(workers=2)
    remaining.expect([Piece(name=str(k), case="x", engine="e", steps=1) for k in range(5)])
    remaining.answers_begin([str(k) for k in range(5)], 0.0)
    remaining.answered("0", 10.0, to_clock=False)
    remaining.answered("1", 10.0, to_clock=False)
    remaining.answered("2", 20.0, to_clock=False)
    remaining.answered("3", 20.0, to_clock=False)
    left = remaining.left()
    assert left is not None
    assert left.middle == pytest.approx(10.0)


def test_a_search_waits_for_each_answer_before_it_asks_for_the_next() -> None:
    """Four answers one after the other take four times as long as one, whatever the number of workers."""

    def told(at_once: int) -> float:
        remaining = RemainingTime(workers=4)
        pieces = [Piece(name=str(k), case="x", engine="e", steps=1) for k in range(40)]
        remaining.expect(pieces)
        remaining.answers_begin([piece.name for piece in pieces], 0.0)
        for k in range(40):
            remaining.answered(str(k), 10.0 * (k // 4 + 1), to_clock=False)
        remaining.foresee(lambda: [Awaited(pieces[0], 4.0, 0.0, at_once)])
        left = remaining.left()
        assert left is not None
        return left.middle

    assert told(1) == pytest.approx(4 * told(4))
    assert told(4) == pytest.approx(10.0)


def test_nothing_is_told_while_nearly_all_is_of_a_kind_that_nobody_has_seen() -> None:
    remaining = RemainingTime(workers=1)
    remaining.expect([Piece(name="a", case="x", engine="e", steps=1), Piece(name="b", case="x", engine="e", steps=1)])
    remaining.expect([Piece(name=str(k), case="y", engine="e", steps=1) for k in range(9)])
    remaining.answers_begin(["a", "b", *map(str, range(9))], 0.0)
    remaining.answered("a", 1.0, to_clock=False)
    remaining.answered("b", 2.0, to_clock=False)
    assert remaining.left() is None
    remaining.answered("0", 3.0, to_clock=False)
    assert remaining.left() is not None


def test_where_nothing_was_learned_it_grows_by_half_at_most() -> None:
    """An answer takes thirty times as long as those before it of its kind: that alone is no news, and is taken in bit by bit.

    Two new trials are; they are told of in words.
    """
    remaining = RemainingTime(workers=1)
    remaining.expect([Piece(name=str(k), case="x", engine="e", steps=1) for k in range(12)])
    remaining.answers_begin([str(k) for k in range(12)], 0.0)
    for k in range(6):
        remaining.answered(str(k), 1.0 + k, to_clock=False)
    before = remaining.left()
    remaining.answered("6", 36.0, to_clock=False)
    after = remaining.left()
    assert before is not None
    assert after is not None
    assert after.middle <= LEAP * before.middle
    assert not after.news
    remaining.expect([Piece(name=f"more{k}", case="x", engine="e", steps=1) for k in range(50)])
    more = remaining.left()
    assert more is not None
    assert more.middle > LEAP * after.middle
    assert more.news == "searches ask for more"


@pytest.mark.parametrize(
    ("left", "text"),
    [
        (Estimate(0.0, 0.0), "about 0 s left"),
        (Estimate(20.2, 47.3), "about 20 to 47 s left"),
        (Estimate(47.1, 47.3), "about 47 s left"),
        (Estimate(40.0, 119.6), "about 40 to 120 s left"),
        (Estimate(63.0, 130.0), "about 1.1 to 2.2 min left"),
        (Estimate(1500.0, 3025.0), "about 25 to 50 min left"),
        (Estimate(4000.0, 9000.0, "the clock began"), "about 1.1 to 2.5 h left, as the clock began"),
    ],
)
def test_an_estimate_has_two_digits(left: Estimate, text: str) -> None:
    assert in_words(left) == text
