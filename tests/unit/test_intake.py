"""What is read from outside: limits that are set, work that grows no faster than a scene, and tables of strangers."""

import json
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from plumbline.harness.case.scene_file import own_case
from plumbline.harness.intake.allowance import VARIABLE, Allowance, AllowanceError, allowance, allowing, beyond
from plumbline.harness.intake.safe_text import quoted, readable
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.store import Store
from plumbline.harness.study.catalogue import describe_case
from plumbline.harness.study.experiment import experiments_of
from tests.run_folder import write_run_folder


def test_limits_hold_within_and_for_children_and_are_gone_afterwards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "joints=7")
    with allowing(["bodies=5", "bytes=1e8"], "--limit"):
        assert (allowance().bodies, allowance().bytes, allowance().joints) == (5, 100_000_000, 7)
        assert "bodies=5" in os.environ[VARIABLE]
        assert beyond("bodies", 6).startswith("6 bodies, expected at most 5; --limit bodies=VALUE")
        assert not beyond("bodies", 5)
    assert os.environ[VARIABLE] == "joints=7"
    assert allowance() == Allowance(joints=7)


@pytest.mark.parametrize(
    "told", ["bodies", "bodies=", "bodies=-1", "bodies=1.5", "bodies=inf", "bodies=1e16", "colours=5", "=5"]
)
def test_a_limit_that_is_none_is_refused(told: str) -> None:
    with pytest.raises(AllowanceError, match="--limit"), allowing([told], "--limit"):
        pass


@pytest.mark.parametrize(
    ("value", "shown"),
    [(True, "true"), (None, "nothing"), ("a\x1b[31m", r"'a\x1b[31m'")],
)
def test_a_value_is_quoted_on_one_line_of_plain_signs(value: object, shown: str) -> None:
    assert quoted(value) == shown
    assert len(quoted(["x" * 10**6] * 10**4)) <= 120
    assert quoted(10**5000) == "a whole number too long to write out"


def test_text_is_readable_and_short() -> None:
    assert readable("app\ufeffear\u200bance") == "app\\ufeffear\\u200bance"
    assert readable("a\x1b[2J\u202e\ud800\nb") == "a\\u001b[2J\\u202e\\ud800\nb"
    assert len(readable("x" * 10**7, 100)) == 100


def chain(count: int, path: Path) -> Path:
    """So many bodies, each fixed to the one before."""
    bodies = [{"name": f"b{number}"} for number in range(count)]
    joints = [
        {"type": "fixed", "name": f"j{number}", "parent": f"b{number - 1}" if number else "world", "child": f"b{number}"}
        for number in range(count)
    ]
    path.write_text(json.dumps({"bodies": bodies, "joints": joints}))
    return path


def calls_of(work: Callable[[], object]) -> int:
    """How many functions are called, in Python and in C."""
    count = 0

    def counted(_frame: object, event: str, _argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(counted)
    try:
        work()
    finally:
        sys.setprofile(None)
    return count


def test_twice_the_jointed_bodies_are_read_and_described_in_twice_the_work(tmp_path: Path) -> None:
    """Three sizes: what each needs once falls out, and the second doubling may cost at most 2.2 times what the first did."""
    describe_case(own_case(chain(2, tmp_path / "first.json"), "scene:"))  # imports what the process needs once
    counts = []
    for count in (500, 1000, 2000):
        path = chain(count, tmp_path / f"{count}.json")
        counts.append(calls_of(lambda path=path: describe_case(own_case(path, "scene:"))))  # type: ignore[misc]
    assert counts[2] - counts[1] < 2.2 * (counts[1] - counts[0])


BROKEN = {
    "a missing column": (lambda frame: frame.drop(columns="status"), "has no column status"),
    "no JSON": (lambda frame: frame.assign(parameters="{'mass': 1}"), "column parameters: got \"{'mass': 1}\", expected JSON"),
    "JSON too deep": (lambda frame: frame.assign(settings="[" * 100_000), "column settings"),
    "numbers for JSON": (lambda frame: frame.assign(resolved=5), "column resolved: got '5'"),
}


@pytest.mark.parametrize("fault", BROKEN)
def test_tables_of_strangers_are_looked_at_before_they_are_used(fault: str, tmp_path: Path) -> None:
    change, words = BROKEN[fault]
    folder = write_run_folder(tmp_path / "run")
    path = folder / "trials.parquet"
    change(pd.read_parquet(path)).to_parquet(path)
    with pytest.raises(StoreError, match=re.escape(words)):
        Store(folder).trials  # noqa: B018  # reading is what is tested


@pytest.mark.parametrize("content", [None, b"", b"PAR1", b"PAR1" + bytes(100) + b"PAR1"])
def test_a_table_that_is_none_is_named(content: bytes | None, tmp_path: Path) -> None:
    folder = write_run_folder(tmp_path / "run")
    path = folder / "samples.parquet"
    path.unlink()
    if content is None:
        os.mkfifo(path)
    else:
        path.write_bytes(content)
    with pytest.raises(StoreError, match=re.escape(str(path))):
        Store(folder).trials  # noqa: B018  # reading is what is tested


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ("experiments = 5", "experiments: Input should be a valid list"),
        ("[[experiments]]\nname = 'e'\nsweep = 'x'", "sweep"),
        ("experiments = [5]", "5"),
    ],
)
def test_a_stored_study_that_is_none_is_the_folder_s_fault(told: str, words: str, tmp_path: Path) -> None:
    folder = write_run_folder(tmp_path / "run")
    (folder / "study.toml").write_text(told)
    with pytest.raises(StoreError, match=words) as caught:
        experiments_of(Store(folder))
    assert "study.toml" in str(caught.value)
