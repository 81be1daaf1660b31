"""The command line whose runs end with the summary: for what becomes of processes and of a store, without drawing a report.

Each process of a trial loads its parent's program: it loads no more here than the command line does.
"""

from typing import TYPE_CHECKING

import plumbline.harness.cli.main
import plumbline.harness.cli.run_study

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store
    from plumbline.reports.html.written import WrittenReport

__all__ = ["end_with_the_summary", "summarised"]


def summarised(store: "Store", _recordings: bool, *, anew: bool) -> "WrittenReport":
    """What stands beside the tables."""
    from plumbline.harness.findings.summary import write_summary  # late, as above
    from plumbline.reports.html.written import WrittenReport

    write_summary(store)
    return WrittenReport(store.folder / "summary.md", ())


def end_with_the_summary() -> None:
    """Let every run of this process end without a report."""
    plumbline.harness.cli.run_study.present = summarised


if __name__ == "__main__":
    end_with_the_summary()
    plumbline.harness.cli.main.main()
