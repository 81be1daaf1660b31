"""The command line whose runs end with the summary: for what becomes of processes and of a store, without drawing a report."""

from pathlib import Path

import harness.cli.main
import harness.cli.run_study
from harness.findings.summary import write_summary
from harness.store.store import Store

__all__ = ["end_with_the_summary"]


def _publish(store: Store, _recordings: bool) -> Path:
    """What stands beside the tables."""
    write_summary(store)
    return store.folder / "summary.md"


def end_with_the_summary() -> None:
    """Let every run of this process end without a report."""
    harness.cli.run_study.publish = _publish


if __name__ == "__main__":
    end_with_the_summary()
    harness.cli.main.main()
