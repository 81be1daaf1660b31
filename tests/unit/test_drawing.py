"""Pictures that processes draw are those that would have been drawn here, whatever becomes of a process."""

import os
import signal
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

import pytest

from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure
from plumbline.reports.html import report as html
from plumbline.reports.html.drawing import Drawing
from plumbline.reports.page import pages
from tests.run_folder import write_run_folder


def chart(name: str, height: int) -> Figure:
    bar = {"mark": "bar", "encoding": {"y": {"field": "y", "type": "quantitative"}}}
    return Figure(name, "Heights", "Drawn.", {"data": {"values": [{"y": height}]}, **bar}, (), ())


@dataclass(frozen=True)
class Fatal:
    """Ends a process other than this one."""

    here: int

    def kept(self, _: Path) -> str:
        if os.getpid() != self.here:
            os.kill(os.getpid(), signal.SIGKILL)
        return "drawn here"


@dataclass(frozen=True)
class Faulty:
    def kept(self, _: Path) -> str:
        raise ValueError("no such colour")


@dataclass(frozen=True)
class Where:
    def kept(self, _: Path) -> str:
        return str(os.getpid())


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where pictures lie that may be taken."""
    return tmp_path_factory.mktemp("report")


@pytest.fixture(scope="module")
def beside(report: Path) -> Iterator[Drawing]:
    """One process that draws."""
    with Drawing(report, processes=1) as drawing:
        yield drawing


def test_a_process_draws_what_is_drawn_here_and_takes_what_is_kept(report: Path, beside: Drawing) -> None:
    charts = [chart(f"c{k}", k) for k in range(4)]
    kept = charts[0].svg.replace("<svg", "<svg id='kept'")
    (report / "charts").mkdir()
    (report / charts[0].path).write_text(kept)
    drawn = [beside.ask(one).result() for one in charts]
    elsewhere = beside.ask(Where()).result()
    assert drawn == [kept, *(one.svg for one in charts[1:])]
    assert elsewhere != str(os.getpid())


def test_without_processes_all_is_drawn_in_this_one(tmp_path: Path) -> None:
    with Drawing(tmp_path) as drawing:
        assert drawing.ask(Where()).result() == str(os.getpid())


def test_a_process_that_dies_is_not_asked_again_and_its_pictures_are_drawn_here(tmp_path: Path) -> None:
    with Drawing(tmp_path, processes=1) as drawing:
        asked = [drawing.ask(picture) for picture in (Fatal(os.getpid()), Where(), chart("c", 1))]
    assert [one.result() for one in asked] == ["drawn here", str(os.getpid()), chart("c", 1).svg]


def test_what_cannot_be_handed_over_is_drawn_here_and_what_is_wrong_is_raised(beside: Drawing) -> None:
    class Local:
        def kept(self, _: Path) -> bytes:
            return b"of a class that no other process knows"

    assert beside.ask(Local()).result() == b"of a class that no other process knows"
    with pytest.raises(ValueError, match="no such colour"):
        beside.ask(Faulty()).result()
    assert beside.ask(Where()).result() != str(os.getpid())


@pytest.mark.parametrize("several", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_report_is_the_same_whoever_draws(
    several: int, beside: Drawing, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if several == 1:  # there is one
        monkeypatch.setattr(html, "Drawing", lambda into, count: nullcontext(beside) if count else Drawing(into))
    folder = write_run_folder(tmp_path / "run", only=("joint_pendulum",))
    # Pages of cases have all charts but a few, and that is where they are asked for: the others need not be made twice.
    monkeypatch.setattr(html, "pages", lambda: [page for page in pages() if page.name == "case"])
    reports = []
    for processes in (several, 0):
        monkeypatch.setattr(html, "_processes", lambda _, count=processes: count)
        report = html.write_report(folder).index.parent
        reports.append({path.relative_to(report): path.read_bytes() for path in report.rglob("*.*")})
        for path in (report / "charts").iterdir():
            path.unlink()
    assert reports[0] == reports[1]
    assert any(path.suffix == ".svg" for path in reports[0])


def test_the_size_of_a_journal_says_whether_processes_draw(tmp_path: Path) -> None:
    journal = tmp_path / "journal.jsonl"
    journal.write_bytes(b"")
    store = Store(tmp_path)
    assert html._processes(store) == 0
    os.truncate(journal, html.LARGE + 1)
    assert html._processes(store) == min(html.MOST, os.cpu_count() or 1)
