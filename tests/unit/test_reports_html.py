"""The builder: what it writes, what it refuses, and that no string of a store becomes markup."""

import csv
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path
from time import sleep

import pandas as pd
import pytest

from plumbline import reports
from plumbline.harness.case.alteration import EVERYTHING
from plumbline.harness.findings.vendor_findings import shelf
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.seal import sealed_toml
from plumbline.harness.store.store import Store
from plumbline.reports.html import report as html
from plumbline.reports.html.policy import guarded
from plumbline.reports.html.report import write_report
from plumbline.reports.page import Page, Rendered, pages
from tests.links import texts_of
from tests.recorded_folder import Folder, record
from tests.run_folder import BAD_CASE, HOSTILE, write_run_folder

SOURCES = {source for finding in shelf() for source in finding.sources}
"""What findings cite; the only addresses of a report that are not from its store."""


class Markup(HTMLParser):
    """The elements and the attributes of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = write_run_folder(tmp_path_factory.mktemp("html") / "run", hostile=True, only=("joint_pendulum", BAD_CASE))
    return write_report(folder).index.parent


def test_the_report_has_a_page_for_each_case_and_every_asset_beside_it(report: Path) -> None:
    names = {path.relative_to(report).as_posix() for path in report.rglob("*") if path.is_file()}
    assert {"index.html", "method.html", "case-joint_pendulum.html", "trials/joint_pendulum.csv"} <= names
    assert {"style/report.css", "style/report.js", "style/vega.js", "style/vega-licences.txt"} <= names
    assert {"charts/overview-error.svg", "charts/case-joint_pendulum-step.svg"} <= names
    assert len([name for name in names if name.startswith("case-")]) == 2


def test_the_library_of_charts_is_loaded_by_the_pages_that_have_one(report: Path) -> None:
    for path in report.glob("*.html"):
        text = path.read_text(encoding="utf-8")
        assert ('src="style/vega.js"' in text) == ('class="spec"' in text), path.name


def test_no_string_of_a_store_becomes_an_element_an_attribute_or_a_script(report: Path) -> None:
    scripts, pages, charts = {None: 0, "application/json": 0}, 0, 0
    for path in sorted(report.glob("*.html")):
        pages += 1
        charts += 'class="spec"' in path.read_text(encoding="utf-8")
        for tag, attributes in Markup(path.read_text(encoding="utf-8")).elements:
            assert tag not in {"iframe", "object", "embed", "base", "form", "textarea"}, path.name
            assert not [name for name in attributes if name.startswith("on")], path.name
            assert "style" not in attributes, path.name
            if tag == "script":
                scripts[attributes.get("type")] += 1
                assert attributes.get("src") in {"style/vega.js", "style/frame.js", "style/report.js", "style/select.js", None}
                assert attributes.get("src") or attributes.get("type") == "application/json"
            if tag in {"img", "link"}:
                source = attributes.get("src") or attributes.get("href") or ""
                assert re.match(r"(charts|style|pictures)/[\w-]+\.\w+$|data:,$", source), source
            if (href := attributes.get("href")) is not None and ":" in href:
                cited = path.name == "findings.html" and href in SOURCES
                assert cited or href.startswith(("https://example.org", "data:,")), href
    assert 0 < charts < pages
    assert scripts[None] == 2 * pages + charts + 1  # two on each page, that of charts, and that of the page on selection
    assert scripts["application/json"] == 2 + 2 * 2 + 3 + 1  # overview, two cases, price, selection


def test_every_page_carries_a_policy_that_lets_nothing_inline_or_remote_run(report: Path) -> None:
    for path in report.glob("*.html"):
        metas = [a for tag, a in Markup(path.read_text(encoding="utf-8")).elements if tag == "meta"]
        (policy,) = [a["content"] for a in metas if a.get("http-equiv") == "Content-Security-Policy"]
        assert policy is not None
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert "http" not in policy


def test_no_address_of_a_network_stands_in_what_a_page_loads(report: Path) -> None:
    for name in ("report.css", "report.js"):
        text = (report / "style" / name).read_text(encoding="utf-8")
        assert not re.search(r"https?:|//[a-z]+\.|@import|url\(", text), name


def test_direction_marks_and_escapes_reach_no_page(report: Path) -> None:
    for path in report.rglob("*.*"):
        if path.suffix in (".html", ".svg"):
            text = path.read_text(encoding="utf-8")
            assert "\u202e" not in text, path.name
            assert "\x1b" not in text, path.name


def test_the_csv_holds_every_trial_and_no_formula(report: Path) -> None:
    (path,) = [path for path in (report / "trials").iterdir() if path.name.startswith("bad")]
    csv.field_size_limit(10_000_000)
    rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines(keepends=True)))
    assert len(rows) == 1 + len(HOSTILE)
    assert len({len(row) for row in rows}) == 1
    assert not [cell for row in rows for cell in row if cell.startswith(("=", "+", "@"))]


def test_a_metric_that_is_checked_twice_is_shown_twice(tmp_path: Path) -> None:
    folder = write_run_folder(tmp_path / "run", only=("joint_pendulum",))
    table = pd.read_parquet(folder / "measurements.parquet")
    early = table[table["metric"] == "energy_drift"].assign(value=0.125)
    pd.concat([table, early]).to_parquet(folder / "measurements.parquet", index=False)
    texts = texts_of(Store(folder), "case")
    assert texts["case-joint_pendulum.html"].count("0.125 J") == len(early)
    assert "energy_drift #2" in texts["trials/joint_pendulum.csv"].splitlines()[0]


FIRST = Page(name="index", title="First", order=0, render=lambda _: {"index.html": "<!doctype html><title>First</title>"})
"""In place of the first page of a report: what is done with its file is the same whatever it says."""


@pytest.fixture
def only_index(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports have their first page alone: what is done with the files of a report is the same for one as for many."""
    monkeypatch.setattr(html, "pages", lambda: tuple(one for one in pages() if one.name == "index"))


@pytest.mark.usefixtures("only_index")
def test_a_second_build_replaces_the_first_and_leaves_no_draft(tmp_path: Path) -> None:
    folder = write_run_folder(tmp_path / "run", only=("joint_pendulum",))
    report = write_report(folder).index.parent
    (report / "stale.html").write_text("old")
    before = (report / "index.html").read_bytes()
    write_report(folder)
    assert (report / "index.html").read_bytes() == before
    assert not (report / "stale.html").exists()
    assert not [path for path in folder.iterdir() if path.name.startswith(".report")]


NOT_MADE = re.compile(r'<section class="card" id="not-made">.*?</section>\n?', re.DOTALL)
"""Where the first page names the pages that could not be made."""


def written(text: str | bytes) -> bytes:
    """A page as it stands in a report."""
    assert isinstance(text, str)
    return guarded(text).encode("utf-8", errors="backslashreplace")


def test_a_page_that_fails_says_so_and_the_others_stand(report: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = {path.relative_to(report).as_posix(): path for path in report.rglob("*.*") if path.parent.name != "style"}

    def broken(_: Store) -> dict[str, str]:
        raise RuntimeError("no page")

    others = tuple(one for one in pages() if one.name in ("index", "method"))
    monkeypatch.setattr(html, "pages", lambda: (*others, Page(name="x", title="X", order=99, render=broken)))
    made = dict(html.rendered(Store(report.parent)))
    assert "RuntimeError: no page" in made.pop("x.html")
    assert {"index.html", "method.html"} <= made.keys() <= whole.keys()
    (named,) = NOT_MADE.findall(str(made["index.html"]))
    assert "<b>X</b>: RuntimeError: no page" in named
    made["index.html"] = NOT_MADE.sub("", str(made["index.html"]))
    assert all(written(made[name]) == whole[name].read_bytes() for name in made if name.endswith(".html"))


@dataclass(frozen=True)
class Drawn:
    """A picture of which a file says that it has been begun."""

    begun: Path

    def kept(self, _: Path) -> bytes:
        self.begun.touch()
        return b"drawn"


def test_a_picture_is_drawn_while_the_page_that_hands_it_on_is_still_made(
    report: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def render(_: Store) -> Iterator[tuple[str, Rendered]]:
        yield "charts/x.svg", Drawn(tmp_path / "begun")
        begun = any((tmp_path / "begun").exists() or sleep(0.01) for _ in range(6000))
        yield "x.html", "early" if begun else "late"

    monkeypatch.setattr(html, "pages", lambda: (Page(name="x", title="X", order=0, render=render),))
    assert html.rendered(Store(report.parent)) == {"charts/x.svg": b"drawn", "x.html": "early"}


def test_a_report_that_cannot_be_made_leaves_the_old_one_untouched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(html, "pages", lambda: (FIRST,))
    report = write_report(write_run_folder(tmp_path / "run", only=("joint_pendulum",))).index.parent
    before = (report / "index.html").read_bytes()

    def broken(_failures: object) -> str:
        raise RuntimeError("no bundle")

    monkeypatch.setattr(html, "script_file", broken)
    with pytest.raises(RuntimeError, match="no bundle"):
        write_report(report.parent)
    assert (report / "index.html").read_bytes() == before


def test_a_page_cannot_write_outside_the_report_nor_over_another(report: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = (FIRST,)
    monkeypatch.setattr(html, "pages", lambda: own)
    alone = html.rendered(Store(report.parent))
    names = ["../index.html", "/etc/passwd", "a/b/c.html", "x.exe", "index.html", ".hidden.html"]

    def page(k: int, name: str) -> Page:
        return Page(name=f"x{k}", title="X", order=-1, render=lambda _: {f"x{k}.html": "", name: ""})

    monkeypatch.setattr(html, "pages", lambda: (*(page(k, name) for k, name in enumerate(names)), *own))
    made = dict(html.rendered(Store(report.parent)))
    for k, name in enumerate(names):
        assert re.search("expected a plain name|another page", str(made.pop(f"x{k}.html"))), name
    assert made.keys() == alone.keys()
    assert NOT_MADE.sub("", str(made["index.html"])) == alone["index.html"]


def test_pages_are_found_by_walking_the_folder_and_stand_in_their_order() -> None:
    folder = Path(reports.__file__).parent / "pages"
    assert {page.name for page in pages()} >= {path.stem for path in folder.glob("[!_]*.py")}
    assert [page.order for page in pages()] == sorted(page.order for page in pages())


def test_a_folder_without_a_run_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match=re.escape(str(tmp_path))):
        write_report(tmp_path)


def test_a_run_that_was_stopped_before_its_first_trial_has_a_report(tmp_path: Path) -> None:
    (tmp_path / "journal.jsonl").write_bytes(b"")
    assert "holds no trial" in write_report(tmp_path).index.read_text(encoding="utf-8")


def test_importing_reports_loads_no_chart_library() -> None:
    code = (
        "import plumbline.reports, sys; sys.exit(any(m in sys.modules for m in ('altair', 'vl_convert', 'jinja2', 'pandas')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, cwd=Path(reports.__file__).parents[1]).returncode == 0


LIMITED = """
name = "small"
[[experiments]]
name = "walls"
cases = ["tunnel_sphere_wall"]
engines = ["mujoco"]
tracks = ["tuned"]
limit = { members = 2 }
"""


def test_pages_of_a_folder_without_its_catalogue_say_what_is_missing_and_what_to_do(tmp_path: Path) -> None:
    """What a limit's axis is and which effects a scene calls for stand there alone; the other pages do without."""
    folder = Folder(tmp_path / "run")
    folder.add(record("tunnel_sphere_wall", "mujoco", experiment="walls", parameters={"speed": 9.0}, members=2))
    folder.add(record("flight_box", "mujoco"))
    folder.add(record("flight_box", "mujoco", alteration={"name": EVERYTHING}))
    folder.journal.close()
    (folder.path / "study.toml").write_bytes(sealed_toml("study.toml", LIMITED))
    texts = html.rendered(Store(folder.path))
    for page in ("limits", "effects"):
        text = str(texts[f"{page}.html"])
        assert f"{folder.path / 'catalogue.json'}: missing" in text
        assert "--resume, which writes it anew" in text
    failed = {name for name, text in texts.items() if "A page that could not be made" in str(text)}
    assert failed == {"limits.html", "effects.html"}
    assert "This folder lacks <code>catalogue.json</code>" in str(texts["index.html"])
