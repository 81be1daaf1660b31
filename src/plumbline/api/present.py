"""What people look at of a run: summary, recordings, report."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store
    from plumbline.reports.html.written import WrittenReport


def present(store: "Store", recordings: bool) -> "WrittenReport":
    """Write what people look at: summary, recordings, report."""
    from plumbline.harness.findings.summary import write_summary
    from plumbline.reports.html.report import write_report
    from plumbline.reports.recordings import write_recordings

    write_summary(store)
    if recordings:
        write_recordings(store.folder)
    return write_report(store)
