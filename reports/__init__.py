"""Records in; HTML pages, charts and recordings out. Reports never run physics and never call a metric."""

from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plumbline.harness.findings.changes import Changes
    from plumbline.harness.history.regressions import Trends
    from plumbline.reports.html.written import WrittenReport


def build(folder: Path) -> "WrittenReport":
    """Write `folder/report/` from the store in a run folder.

    Returns:
        The path of the first page, which opens from file:// without a network, and which pages could not be made.

    Raises:
        OSError: the store cannot be read, or the report cannot be written.
    """
    from plumbline.reports.html.report import write_report  # late: importing `reports` must stay cheap for the command line

    return write_report(folder)


def print_report(folder: Path) -> Path:
    """Print the pages of `folder/report/` into `folder/report/report.pdf`; returns its path.

    Raises:
        NotPrinted: there is no browser on this machine that does so, or it failed.
        OSError: the report cannot be read, or the file cannot be written.
    """
    from plumbline.harness.store.store import Store
    from plumbline.reports.paper.printing import print_report as put_on_paper

    return put_on_paper(Store(folder), folder / "report", folder / "report" / "report.pdf")


def parity_page(folder: Path) -> Path:
    """Write the page of a comparison of robot files beside the record `folder/parity.json`; returns its path.

    Raises:
        OSError: the record cannot be read, or the page cannot be written.
        DamagedFile: the record is not what was written.
    """
    from plumbline.reports.standalone.parity import write_page

    return write_page(folder)


def write_recordings(folder: Path, cases: Collection[str] | None = None) -> tuple[Path, ...]:
    """Write `folder/recordings/<case>.rrd` for each of these cases of a run folder, all for None; returns their paths."""
    from plumbline.reports.recordings import write_recordings as write

    return write(folder, cases)


def recording_of(folder: Path, case: str) -> Path:
    """The recording of a case in a run folder.

    Raises:
        NoRun: no run folder, or no such recording; the message names those that exist.
    """
    from plumbline.reports.recordings import recording_of as find

    return find(folder, case)


def open_viewer(path: Path) -> int:
    """Show a recording in the rerun viewer until it is closed; returns its exit code."""
    from plumbline.reports.recordings.viewer import open_viewer as show

    return show(path)


def serve(folder: Path, port: int, announce: Callable[[str], None]) -> None:
    """Serve report, recordings and web viewer on 127.0.0.1 until interrupted; port 0 takes a free one."""
    from plumbline.reports.server import serve as run

    run(folder, port, announce)


def changes_page(changes: "Changes", folder: Path, gated: Collection[str] = ()) -> Path:
    """Write the page What changed into a folder; returns its path."""
    from plumbline.reports.standalone.what_changed import write_what_changed

    return write_what_changed(changes, folder, gated)


def trends_page(trends: "Trends", folder: Path) -> "WrittenReport":
    """Write the page Trends of a history into a folder.

    Returns:
        Its path, and which pictures could not be drawn.
    """
    from plumbline.reports.standalone.trends import write_trends

    return write_trends(trends, folder)
