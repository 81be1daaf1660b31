"""A claim that is disputed is marked wherever a report tells it; nothing else is."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from plumbline.harness.store.store import Store
from plumbline.reports.tables.limit_table import lines
from plumbline.reports.tables.price_list import price_list
from plumbline.reports.tables.summary import sentences
from plumbline.reports.words import known_findings
from tests.links import texts_of
from tests.run_folder import write_run_folder
from tests.unit.test_prices import Priced, ladder
from tests.unit.test_reports_reach import BROKEN

ROW = """
[[disputed]]
engine = "{engine}"
case = "{case}"
since = 2026-11-23
why = "its <b>manual</b> names another setting"
reference = "https://example.org/issue/1"
"""


@pytest.fixture
def plant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Puts a row, and more lines of it, into the place of the table."""

    def put(engine: str, case: str, more: str = "") -> None:
        table = tmp_path / f"disputed-{engine}-{case}.toml"
        table.write_text(ROW.format(engine=engine, case=case) + more)
        monkeypatch.setattr(known_findings, "TABLE", table)

    return put


@pytest.fixture
def told() -> Priced:
    return Priced([*ladder("a", "bullet", 1e-3), *ladder("a", "dart", 3e-3), *ladder("b", "dart", 3e-3)])


def test_a_disputed_price_is_marked_and_no_other(plant: Any, told: Priced) -> None:
    assert "disputed since" not in texts_of(told, "price")["price.html"]
    plant("dart", "a")
    marked = {(line.case, name) for line in price_list(told) for name, one in line.entries.items() if one.disputed}
    assert marked == {("a", "dart")}
    pages = texts_of(told, "price", "case")
    assert '<small class="disputed">disputed</small>' in pages["price.html"]
    assert "disputed since 2026-11-23: its &lt;b&gt;manual&lt;/b&gt; names another setting" in pages["price.html"]
    assert "Disputed since 2026-11-23: what is said of dart" in pages["case-a.html"]
    assert "isputed since" not in pages["case-b.html"]


def test_a_dispute_of_one_study_is_none_of_another(plant: Any, told: Priced) -> None:
    plant("dart", "a", 'study = "price"\n')
    assert known_findings.disputed(told, "dart", "a") == ""
    told.__dict__["study"] = {"name": "price"}
    assert known_findings.disputed(told, "dart", "a").startswith("disputed since 2026-11-23: ")


def test_a_disputed_axis_is_marked_in_its_cells_alone(plant: Any, told: Priced) -> None:
    plant("dart", "a", 'axis = "speed"\n')
    searches = [replace(BROKEN, case="a", engine=name, axis=axis, where=axis) for name in ("dart", "bullet") for axis in AXES]
    found = {
        (line.axis.partition(" ")[0], name)
        for line in lines(told, searches)
        for (name, _), one in line.cells.items()
        if "disputed" in one.why and "disputed since" in one.hint
    }
    assert found == {("speed", "dart")}
    # Nothing else that is said of the case is disputed.
    assert not any(one.disputed for line in price_list(told) for one in line.entries.values())


AXES = ("speed", "mass")


def test_a_disputed_finding_is_marked_in_the_summary_and_on_its_page(plant: Any, tmp_path: Path) -> None:
    """By the folder's formulas MuJoCo and DART err by the first order where the second is promised."""
    store = Store(write_run_folder(tmp_path / "run", only=("joint_pendulum",)))
    plant("dart", "joint_pendulum")
    (broken,) = [one for one in sentences(store) if "than the integrator promises" in one]
    assert "DART (tuned) in “Pendulum from 90 degrees” (disputed)" in broken
    assert "MuJoCo (tuned) in “Pendulum from 90 degrees” (" not in broken
    assert '<small class="disputed">disputed since 2026-11-23' in texts_of(store, "case")["case-joint_pendulum.html"]


@pytest.mark.parametrize("more", ['sinse = "2026"\n', "axis = 3\n"])
def test_a_row_that_says_something_else_is_refused(plant: Any, told: Priced, more: str) -> None:
    plant("dart", "a", more)
    with pytest.raises(ValidationError):
        known_findings.disputed(told, "dart", "a")
