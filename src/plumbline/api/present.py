"""What people look at of a run: summary, recordings, report."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store
    from plumbline.reports.html.written import WrittenReport


def present(store: "Store", recordings: bool, anew: bool = True) -> "WrittenReport":
    """Write what people look at: summary, recordings, report.

    Args: anew: also where recordings and a whole report were made of just these tables.
    """
    from plumbline.harness.findings.summary import write_summary
    from plumbline.reports.html.report import standing_report, write_report
    from plumbline.reports.recordings import write_recordings

    write_summary(store)
    standing = None if anew or (recordings and not (store.folder / "recordings").is_dir()) else standing_report(store)
    if standing is not None:
        return standing
    if recordings:
        write_recordings(store.folder)
    return write_report(store)
