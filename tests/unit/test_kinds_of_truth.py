"""Which truth a case has: no case of the catalogue is judged by an engine, the reference engine included."""

import inspect
import re
from collections import Counter
from pathlib import Path

import pytest

from plumbline.harness.study import plugins
from plumbline.reports.pages.method import TRUTHS
from tests.links import texts_of
from tests.run_folder import write_run_folder

CASES = [*plugins.cases().values()]
PAGE = Path(__file__).parents[2] / "docs" / "method.md"


def test_no_case_takes_its_truth_from_the_reference_engine() -> None:
    assert [case.name for case in CASES if case.coarsest is not None] == []


@pytest.mark.parametrize("case", [case for case in CASES if case.truth == "converged reference"], ids=lambda case: case.name)
def test_a_converged_reference_is_integrated_by_scipy(case: object) -> None:
    source = inspect.getsource(inspect.getmodule(case.expected))  # type: ignore[attr-defined]
    assert re.search(r"true_motion|solve_ivp|double_pendulum|lagrange", source)


def test_the_document_counts_the_truths_as_they_are() -> None:
    counts = Counter(case.truth for case in CASES)
    assert counts.keys() <= TRUTHS.keys()
    told = re.search(
        r"of the (\d+) cases (\d+) have a closed form, (\d+) are at rest, (\d+) conserve, (\d+) are drawn by a known law, "
        r"and (\d+)",
        PAGE.read_text(encoding="utf-8"),
    )
    assert told is not None
    kinds = ("closed form", "rest", "conservation", "statistics", "converged reference")
    assert [int(number) for number in told.groups()] == [len(CASES), *(counts[kind] for kind in kinds)]


def test_the_page_on_method_names_what_judges_each_case(tmp_path: Path) -> None:
    from plumbline.harness.store.store import Store

    page = texts_of(Store(write_run_folder(tmp_path / "run")), "method")["method.html"]
    assert "is no truth: it is judged as the others are" in page
    assert "closed form" in page
