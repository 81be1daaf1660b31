"""Pictures that processes draw are those that would have been drawn here; one that ends its process is missing, with why."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing.connection import Pipe
from pathlib import Path

import pytest
from click.testing import CliRunner

from plumbline.harness.cli.main import main
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure
from plumbline.reports.html import report as html
from plumbline.reports.html import written
from plumbline.reports.html.drawing import Drawing, NotDrawn, _Process
from plumbline.reports.page import Picture, pages
from tests.run_folder import write_run_folder
from tests.synthetic_history import write_history
from tests.unit.test_trends import planted


def chart(name: str, height: int) -> Figure:
    bar = {"mark": "bar", "encoding": {"y": {"field": "y", "type": "quantitative"}}}
    return Figure(name, "Heights", "Drawn.", {"data": {"values": [{"y": height}]}, **bar}, (), ())


@dataclass(frozen=True)
class Fatal(Picture):
    """Ends a process other than this one."""

    here: int

    def kept(self, _: Path) -> str:
        if os.getpid() != self.here:
            os.kill(os.getpid(), signal.SIGKILL)
        return "drawn here"


@dataclass(frozen=True)
class Faulty(Picture):
    def kept(self, _: Path) -> str:
        raise ValueError("no such colour")


@dataclass(frozen=True)
class Where(Picture):
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


def test_a_picture_that_ends_its_process_is_missing_with_its_reason_and_the_others_are_drawn(tmp_path: Path) -> None:
    with Drawing(tmp_path) as drawing:
        asked = [drawing.ask(picture) for picture in (Fatal(os.getpid()), Where(), chart("c", 1))]
    with pytest.raises(NotDrawn, match=r"^what draws it was killed by SIGKILL$"):
        asked[0].result()
    assert asked[1].result() != str(os.getpid())
    assert asked[2].result() == chart("c", 1).svg


def test_what_is_wrong_with_a_picture_is_raised_here(beside: Drawing) -> None:
    with pytest.raises(NotDrawn, match=r"^ValueError: no such colour$"):
        beside.ask(Faulty()).result()
    assert beside.ask(Where()).result() != str(os.getpid())


def _let_drawing_die(patch: pytest.MonkeyPatch) -> None:
    def dying(self: _Process) -> None:
        self._connection, theirs = Pipe()
        with theirs:
            self._process = subprocess.Popen(["/bin/sh", "-c", "kill -TRAP $$"])

    patch.setattr(_Process, "start", dying)


def test_a_report_whose_charts_cannot_be_drawn_stands_with_their_reason_in_their_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As under `ulimit -v`, where what draws them takes its process down as it starts."""
    folder = write_run_folder(tmp_path / "run", only=("joint_pendulum",))
    monkeypatch.setattr(html, "pages", lambda: [page for page in pages() if page.name in ("case", "index")])

    _let_drawing_die(monkeypatch)
    written = html.write_report(folder)
    pictures = list((written.index.parent / "charts").iterdir())
    assert pictures
    assert all("This chart could not be drawn:" in path.read_text() for path in pictures)
    assert all("what draws it was killed by SIGTRAP" in path.read_text() for path in pictures)
    assert {kind for kind, _, _ in written.failed} == {"picture"}
    assert "Pages and pictures that could not be made" in written.index.read_text()
    assert all(sentence.startswith("picture 'charts/") or ".webp' could" in sentence for sentence in written.sentences())


def test_trends_whose_charts_cannot_be_drawn_stand_with_their_reason_in_their_place_and_exit_code_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is drawn in the process of the command, and no script is made there."""
    history = write_history(tmp_path / "h", 8, planted).root
    _let_drawing_die(monkeypatch)
    monkeypatch.setitem(sys.modules, "vl_convert", None)
    monkeypatch.setattr(written, "read_kept", lambda _: None)
    written.vega_bundle.cache_clear()
    done = CliRunner().invoke(main, ["history", "trends", str(history)])
    written.vega_bundle.cache_clear()
    assert done.exit_code == 1, done.output
    assert "script 'style/vega.js' could not be made: what draws it was killed by SIGTRAP" in done.stderr
    pictures = list((history / "report" / "charts").iterdir())
    assert pictures
    for path in pictures:
        assert "what draws it was killed by SIGTRAP" in path.read_text()
        assert f"picture 'charts/{path.name}' could not be made: what draws it was killed by SIGTRAP" in done.stderr
    assert (history / "report" / "index.html").is_file()


def test_a_figure_that_cannot_be_drawn_is_named_the_others_are_written_and_the_exit_code_is_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_run_folder(tmp_path / "run", only=("joint_pendulum",))
    monkeypatch.setitem(sys.modules, "vl_convert", None)  # none is drawn here
    command = ["figure", str(folder), "--case", "joint_pendulum", "--format", "svg", "--out", str(tmp_path / "out")]
    whole = CliRunner().invoke(main, command)
    assert whole.exit_code == 0, whole.output
    files = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    assert len(files) > 1
    shutil.rmtree(tmp_path / "out")
    usual, deaths = _Process.drawn, list[str]()

    def dying_once(self: _Process, picture: Picture, report: Path) -> str | bytes:
        if not deaths or deaths[0] == picture.figure.name:  # type: ignore[attr-defined]
            deaths.append(picture.figure.name)  # type: ignore[attr-defined]
            if self._connection is None:
                self.start()
            assert self._process is not None
            self._process.kill()
        return usual(self, picture, report)

    monkeypatch.setattr(_Process, "drawn", dying_once)
    done = CliRunner().invoke(main, command)
    assert done.exit_code == 1, done.output
    assert done.stderr == f"picture '{deaths[0]}.svg' could not be made: what draws it was killed by SIGKILL\n"
    del files[f"{deaths[0]}.svg"]
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == files


@pytest.mark.slow
def test_a_report_is_the_same_however_many_draw(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = write_run_folder(tmp_path / "run", only=("joint_pendulum",))
    # Pages of cases have all charts but a few, and that is where they are asked for: the others need not be made twice.
    monkeypatch.setattr(html, "pages", lambda: [page for page in pages() if page.name == "case"])
    reports = []
    for processes in (2, 1):
        monkeypatch.setattr(html, "_processes", lambda _, count=processes: count)
        report = html.write_report(folder).index.parent
        reports.append({path.relative_to(report): path.read_bytes() for path in report.rglob("*.*")})
        for path in (report / "charts").iterdir():
            path.unlink()
    assert reports[0] == reports[1]
    assert any(path.suffix == ".svg" for path in reports[0])


def test_the_size_of_a_journal_says_how_many_processes_draw(tmp_path: Path) -> None:
    journal = tmp_path / "journal.jsonl"
    journal.write_bytes(b"")
    store = Store(tmp_path)
    assert html._processes(store) == 1
    os.truncate(journal, html.LARGE + 1)
    assert html._processes(store) == min(html.MOST, os.cpu_count() or 1)
