"""Repetitions compared bit by bit: the first step that differs, and how fast a difference grows."""

import numpy as np
import pytest

from plumbline.harness.findings.tables.determinism import Repetition, broken, doubling, parting, sentences


def run(p: np.ndarray, start: int = 0) -> dict[str, np.ndarray]:
    """A body's way along x, sampled every tenth of a second from sample `start` on."""
    n = len(p)
    states = {"p_WB": np.zeros((n, 1, 3)), "q_WB": np.ones((n, 1, 4)), "v_WB": np.zeros((n, 1, 3)), "w_WB": np.zeros((n, 1, 3))}
    states["p_WB"][:, 0, 0] = p
    return {"time": 0.1 * (start + np.arange(n)), **states}


def test_one_bit_is_seen_where_it_first_differs() -> None:
    p = np.linspace(0.0, 1.0, 11)
    other = p.copy()
    other[4:] = np.nextafter(other[4:], 2.0)
    time, differs, distance = parting(run(p), run(other))
    assert np.flatnonzero(differs)[0] == 4
    assert time[4] == pytest.approx(0.4)
    assert 0 < distance.max() < 1e-15


def test_zeros_of_either_sign_are_different_bits() -> None:
    _, differs, distance = parting(run(np.zeros(3)), run(np.array([0.0, -0.0, 0.0])))
    assert differs.tolist() == [False, True, False]
    assert distance.max() == 0.0


def test_a_run_taken_up_half_way_is_compared_where_both_are() -> None:
    p = np.linspace(0.0, 1.0, 11)
    time, differs, _ = parting(run(p), run(p[5:], start=5))
    assert len(time) == 6
    assert not differs.any()


def test_the_doubling_time_of_a_planted_growth_is_found() -> None:
    time = np.linspace(0.0, 5.0, 200)
    assert doubling(time, 1e-13 * 2 ** (time / 0.25)) == pytest.approx(0.25, rel=1e-9)
    assert doubling(time, np.full(200, 1e-12)) is None
    assert doubling(time, np.zeros(200)) is None


def repetition(engine: str, way: str, must: bool, verdict: str, variables: str = "") -> Repetition:
    return Repetition(
        case="c", engine=engine, track="tuned", way=way, variables=variables, must=must, hash_first="a", hash="b", steps=9,
        first_step=4, farthest=1.0, doubles_in=None, verdict=verdict, reason="", trial="t", trial_first="f",
    )  # fmt: skip


def test_a_repetition_that_must_agree_and_does_not_fails_the_gate() -> None:
    found = [
        repetition("reference", "again", True, "differs"),
        repetition("reference", "restored", True, "bit-identical"),
        repetition("reference", "reordered", False, "differs"),
        repetition("bullet", "again", True, "differs"),
    ]
    assert broken(found, ["reference"]) == ["c on reference/tuned, again: differs from step 4 on (trial t)"]


def test_how_often_repetitions_agree_is_said_with_titles_and_in_words() -> None:
    found = [
        repetition("bullet", "2 threads", False, "differs"),
        repetition("bullet", "reordered", False, "differs"),
        repetition("bullet", "again", True, "bit-identical"),
        repetition("bullet", "again", True, "differs"),
        repetition("bullet", "restored", True, "unsupported"),
        repetition("bullet", "nudged", False, "parts"),
    ]
    said = "gives the same bits run again in 1 of 2, from a saved state: no answer, with bodies in another order in 0 of 1, "
    assert sentences(found) == [f"bullet {said}on 2 threads in 0 of 1."]
    assert sentences(found, {"bullet": "Bullet"}) == [f"Bullet {said}on 2 threads in 0 of 1."]


def test_what_survives_other_libraries_is_a_sentence_of_its_own() -> None:
    found = [
        repetition("bullet", "again", True, "bit-identical"),
        repetition("bullet", "NumPy", False, "unavailable", "C=1"),
        repetition("bullet", "C library", False, "crashed", "B=1"),
        repetition("bullet", "BLAS", False, "bit-identical", "A=1"),
        repetition("bullet", "BLAS", False, "differs", "A=1"),
    ]
    again, libraries = sentences(found, {"bullet": "Bullet"})
    assert again == "Bullet gives the same bits run again in 1 of 1."
    assert libraries == "Bullet and its adapter keep their bits with BLAS in 1 of 2, C library: no answer, NumPy: not tried."
