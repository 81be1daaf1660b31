"""The ledger of planted faults: every fault once, and none is survived whose test failed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
QUIET = ("-q", "-p", "no:cacheprovider", "-p", "tests.stress.ledger")
TESTS = """
import pytest

@pytest.mark.parametrize("fault", ["nan", "inf"])
def test_of_each(ledger, fault):
    ledger.survived("engine", fault, "lost 0")

def test_of_one_again(ledger):
    ledger.survived("engine", "nan", "lost 0")

def test_that_fails_after_it_told(ledger):
    ledger.survived("store", "torn", "lost 0")
    assert not "torn after all"

def test_that_fails_before(ledger):
    assert not "nothing told"

@pytest.fixture
def broken():
    raise OSError("no room")

def test_that_has_nothing_to_stand_on(broken, ledger):
    ledger.survived("store", "full", "lost 0")

def test_that_is_left_out(ledger):
    pytest.skip("no kernel")

def test_of_a_line_that_is_none(ledger):
    with pytest.raises(ValueError, match="expected a line"):
        ledger.survived("engine", "two\\nlines", "lost 0")
"""
EXPECTED = [
    "engine | inf | survived | lost 0",
    "engine | nan | survived | lost 0",
    "planted | test_that_fails_before | NOT survived | assert not 'nothing told'",
    "planted | test_that_has_nothing_to_stand_on | NOT survived | no room",
    "store | torn | NOT survived | assert not 'torn after all'",
    "5 different faults, 2 survived, 3 not survived",
]


@pytest.mark.parametrize(
    "more",
    [
        pytest.param([], id="in this process", marks=pytest.mark.slow),
        pytest.param(["-p", "xdist", "-n", "2"], id="in two others"),
    ],
)
def test_every_fault_has_one_line_and_none_is_survived_whose_test_failed(more: list[str], tmp_path: Path) -> None:
    (tmp_path / "conftest.py").write_text((HERE / "conftest.py").read_text())
    (tmp_path / "test_planted.py").write_text(TESTS)
    command = [sys.executable, "-m", "pytest", *QUIET, *more, "--rootdir", tmp_path, tmp_path]
    done = subprocess.run(
        [*map(str, command)],
        cwd=HERE.parents[1],
        env=os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    lines = done.stdout.splitlines()
    first = next(place for place, line in enumerate(lines) if "planted faults" in line) + 1
    assert lines[first : first + len(EXPECTED)] == EXPECTED, done.stdout
