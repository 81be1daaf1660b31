"""Records in; HTML pages, charts and recordings out. Reports never run physics and never call a metric."""

from pathlib import Path

__all__ = ["build"]


def build(folder: Path) -> Path:
    """Write `folder/report/` from the store in a run folder.

    Returns:
        The path of the first page, which opens from file:// without a network.

    Raises:
        OSError: the store cannot be read, or the report cannot be written.
    """
    from reports.html import write_report  # late: importing `reports` must stay cheap for the command line

    return write_report(folder)
