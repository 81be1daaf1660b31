"""The table of mutants still fits the tree, and what is said of a mutant is what became of it."""

import ast
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

from tests import mutants as kit
from tests.mutants import Mutant, judged, mutants, planted

ROOT = Path(__file__).parents[2]
ALL = mutants()


@cache
def _tests(file: str) -> set[str]:
    """The names of the functions of a test file."""
    return {node.name for node in ast.walk(ast.parse((ROOT / file).read_text())) if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("mutant", ALL, ids=lambda mutant: mutant.name)
def test_the_text_of_a_mutant_stands_once_in_its_file_and_its_tests_are_there(mutant: Mutant) -> None:
    ast.parse(planted(mutant))  # what is no Python would be killed by any test
    for test in mutant.tests:
        file, _, name = test.partition("::")
        assert (ROOT / file).is_file(), test
        assert not name or name.partition("[")[0] in _tests(file), test


def test_there_are_mutants_of_harness_adapters_and_engine_each_with_a_name_of_its_own() -> None:
    assert len(ALL) >= 40
    assert max(Counter(mutant.name for mutant in ALL).values()) == 1
    assert {"harness", "adapters", "engine"} <= {mutant.file.partition("/")[0] for mutant in ALL}


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A tree of one law and its tests."""
    (tmp_path / "law.py").write_text("def twice(x: float) -> float:\n    return 2 * x\n")
    (tmp_path / "test_law.py").write_text(
        "import pytest\nfrom law import twice\n\n"
        "def test_one() -> None:\n    assert twice(1.0) == 2.0\n\n"
        "def test_none() -> None:\n    assert twice(0.0) == 0.0\n\n"
        "def test_skipped() -> None:\n    pytest.skip('no reason')\n"
    )
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # the tests of one law need none of these
    monkeypatch.setattr(kit, "ROOT", tmp_path)
    monkeypatch.setattr(kit, "CARRIED", ("law.py", "test_law.py"))
    return tmp_path


@pytest.mark.parametrize(
    ("old", "test", "outcome"),
    [
        ("2 * x", "test_one", "killed"),
        ("2 * x", "test_none", "survived"),
        ("2 * x", "test_skipped", "no verdict"),
        pytest.param("2 * x", "test_nowhere", "no verdict", marks=pytest.mark.slow),
        ("4 * x", "test_one", "no verdict"),
    ],
)
def test_a_mutant_is_killed_by_a_test_that_sees_it_and_by_no_other(tree: Path, old: str, test: str, outcome: str) -> None:
    before = (tree / "law.py").read_text()
    found = judged(Mutant(name="made", file="law.py", old=old, new="3 * x", tests=(f"test_law.py::{test}",)))
    assert found.outcome == outcome, found.why
    assert (tree / "law.py").read_text() == before
