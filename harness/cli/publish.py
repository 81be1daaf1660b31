"""What people look at of a run: summary, recordings, report."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from harness.store.store import Store
    from reports.html.report import WrittenReport


def publish(store: "Store", recordings: bool) -> "WrittenReport":
    """Write what people look at: summary, recordings, report."""
    from harness.findings.summary import write_summary
    from reports import build, write_recordings

    write_summary(store)
    if recordings:
        write_recordings(store.folder)
    return build(store.folder)
