"""The page on scaling: there where a parameter was swept under the clock, absent elsewhere, and safe with hostile names."""

import json
from pathlib import Path

import pytest

from plumbline.harness.store.store import Store, write_json
from plumbline.reports.charts.step_costs import growths
from plumbline.reports.pages.scaling import PAGE
from tests.charts import checked
from tests.links import texts_of
from tests.run_folder import write_run_folder
from tests.unit.test_scaling import Scaling, at, beside, scaling, scattered  # noqa: F401 -- the fixtures


def test_a_store_without_a_sweep_has_no_such_page_and_no_link_to_it(tmp_path: Path) -> None:
    texts = texts_of(Store(write_run_folder(tmp_path / "run", only=("stack_tower",))), "scaling", "index")
    assert "scaling.html" not in texts
    assert "scaling.html" not in texts["index.html"]


def test_a_store_with_a_sweep_has_the_page_with_every_row(scaling: Scaling) -> None:  # noqa: F811
    texts = texts_of(scaling._store, "scaling", "index")
    page = texts["scaling.html"]
    assert 'href="scaling.html"' in texts["index.html"]
    assert page.count("data-status=") == len(scaling.costs)
    assert "it took too long" in page
    assert "1.25" in texts["charts/growth-0.svg"].svg
    assert checked([page]) > 0
    assert len(texts["scaling.csv"].splitlines()) == 1 + len(scaling.rows)


def test_the_chart_and_the_table_state_the_same_exponents_and_leave_out_the_same_one(scattered: Scaling) -> None:  # noqa: F811
    """One rule for both: of three engines the one whose interval is too wide has no number in either."""
    (chart,) = growths(scattered._store, scattered)
    texts = [row["label"] for rows in chart.spec["datasets"].values() for row in rows if "exponent" in str(row.get("label"))]
    assert {text.split(":")[0] for text in dict.fromkeys(texts)} == {"ours (ours)", "near"}
    table = str(PAGE.render(scattered._store)["scaling.html"]).split('id="exponents"')[1].split("</section>")[0]
    rows = [row for row in table.split("<tr>")[2:] if "</tr>" in row]
    assert [("not known" in row, ">theirs<" in row) for row in rows] == [(False, False), (False, False), (True, True)]


def test_the_axis_of_a_sweep_says_what_the_parameter_counts(scaling: Scaling) -> None:  # noqa: F811
    (chart,) = growths(scaling._store, scaling)
    titles = {layer["encoding"]["x"].get("title") for layer in chart.spec["layer"] if "title" in layer["encoding"]["x"]}
    assert titles == {"number of balls"}
    assert chart.columns[0] == "number of balls"
    assert "over the number of balls from 10 to" in str(PAGE.render(scaling._store)["scaling.html"])


def test_reading_calling_and_sharing_have_tables_of_their_own(beside: Scaling) -> None:  # noqa: F811
    write_json(beside._store.folder / "machine.json", {"cores": 2})
    page = PAGE.render(beside._store)["scaling.html"]
    for words in ('id="beside"', 'id="shared"', "step whose state is read", "call that takes no step", "this machine lent 2"):
        assert words in page
    assert "1.2" in page.split('id="beside"')[1]
    assert "0.5" in page.split('id="shared"')[1]


def test_without_such_rows_there_are_no_such_tables(scaling: Scaling) -> None:  # noqa: F811
    page = PAGE.render(scaling._store)["scaling.html"]
    assert 'id="beside"' not in page
    assert 'id="shared"' not in page


def test_a_hostile_name_stays_text(scaling: Scaling, monkeypatch: pytest.MonkeyPatch) -> None:  # noqa: F811
    attack = "<script>window.attacked=1</script>"
    catalogue = json.loads(json.dumps(scaling._store.catalogue))
    catalogue["cases"]["stack_pile"]["title"] = attack
    monkeypatch.setattr(type(scaling._store), "catalogue", catalogue)
    texts = texts_of(Store(scaling._store.folder), "scaling")
    assert attack not in texts["scaling.html"]
    assert at(scaling, 10, "ours", "fine").cpu is not None
