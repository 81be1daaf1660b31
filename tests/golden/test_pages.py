"""Are the pages of a fixed store still exactly these? Their words, element by element, against files kept beside this test.

After a wanted change, write them anew with `PLUMBLINE_GOLDEN=write pytest tests/golden/test_pages.py` and read the difference.
"""

import os
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from jsonschema import ValidationError

from plumbline.harness.store.store import Store
from plumbline.reports.html.report import rendered
from plumbline.reports.pages import sensors
from tests.charts import checked
from tests.run_folder import write_run_folder
from tests.sensor_folder import write_sensor_folder

KEPT = Path(__file__).parent / "pages"
BREAKS = {"p", "li", "tr", "h1", "h2", "h3", "h4", "dt", "summary", "figcaption", "section", "footer", "nav", "caption"}
CELLS = {"td", "th", "dd", "a", "b", "span"}


class Words(HTMLParser):
    """What a page says, one line a block; scripts are left out."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.parts: list[str] = []
        self.silent = 0
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.silent += tag == "script"
        self.parts.append("\n" if tag in BREAKS else " | " if tag in ("td", "th", "dd") else "")
        link = dict(attrs).get("href") if tag == "a" else dict(attrs).get("alt") if tag == "img" else None
        if link:
            self.parts.append(f"[{link}] ")

    def handle_endtag(self, tag: str) -> None:
        self.silent -= tag == "script"
        self.parts.append("\n" if tag in BREAKS else " " if tag in CELLS else "")

    def handle_data(self, text: str) -> None:
        if not self.silent:
            self.parts.append(re.sub(r"\s+", " ", text))

    @property
    def text(self) -> str:
        lines = (" ".join(line.split()) for line in "".join(self.parts).splitlines())
        return "\n".join(line for line in lines if line) + "\n"


@pytest.fixture(scope="module")
def texts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = write_run_folder(tmp_path_factory.mktemp("golden") / "run", only=("joint_chain", "stack_tower"))
    return {name: text.replace(str(folder), "RUN") for name, text in rendered(Store(folder)).items()}


@pytest.fixture(scope="module")
def sensing(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return dict(sensors.PAGE.render(Store(write_sensor_folder(tmp_path_factory.mktemp("sensing") / "run"))))


@pytest.mark.parametrize("name", ["index", "method", "case-joint_chain", "case-stack_tower"])
def test_a_page_of_a_fixed_store_says_exactly_what_it_said(texts: dict[str, str], name: str) -> None:
    words, path = Words(texts[f"{name}.html"]).text, KEPT / f"{name}.txt"
    if os.environ.get("PLUMBLINE_GOLDEN") == "write":
        path.parent.mkdir(exist_ok=True)
        path.write_text(words, encoding="utf-8")
    assert words == path.read_text(encoding="utf-8")


def test_the_page_on_sensors_of_planted_readings_says_exactly_what_it_said(sensing: dict[str, str]) -> None:
    words, path = Words(sensing["sensors.html"]).text, KEPT / "sensors.txt"
    if os.environ.get("PLUMBLINE_GOLDEN") == "write":
        path.write_text(words, encoding="utf-8")
    assert words == path.read_text(encoding="utf-8")


def test_the_trials_as_csv_are_exactly_what_they_were(texts: dict[str, str]) -> None:
    path = KEPT / "stack_tower.csv"
    if os.environ.get("PLUMBLINE_GOLDEN") == "write":
        path.write_text(texts["trials/stack_tower.csv"], encoding="utf-8")
    assert texts["trials/stack_tower.csv"] == path.read_text(encoding="utf-8")


def test_a_report_of_a_fixed_store_has_exactly_these_files(texts: dict[str, str]) -> None:
    cases = ("joint_chain", "stack_tower")
    assert set(texts) == {
        "index.html",
        "concepts.html",
        "findings.html",
        "glossary.html",
        "select.html",
        "evidence.csv",
        "method.html",
        "charts/overview-error.svg",
        "charts/overview-cost.svg",
        *(f"case-{case}.html" for case in cases),
        *(f"engine-{engine}.html" for engine in ("reference", "mujoco", "bullet", "dart", "newton")),
        *(f"trials/{case}.csv" for case in cases),
        *(f"charts/case-{case}-{kind}.svg" for case in cases for kind in ("step", "price")),
        "price.html",
        *(f"{table}.csv" for table in ("price", "profile", "steps")),
        *(f"charts/{name}.svg" for name in ("profile-factor", "profile-time", "largest-steps")),
    }


def test_charts_keep_the_schema_of_vega_lite(texts: dict[str, str], sensing: dict[str, str]) -> None:
    assert checked(text for name, text in (texts | sensing).items() if name.endswith(".html")) > 10
    broken = texts["case-joint_chain.html"].replace('"height":', '"height":"tall","was":')
    with pytest.raises(ValidationError, match="'tall' is not of type 'number'"):
        checked([broken])
