"""The order in which files go to the processes that run the tests: the dearest first, so that none is left idle at the end.

pytest-xdist hands out the files with most tests first, and those that take minutes have few: the last of them would run alone.
It sends five messages a test, which take longer than most tests: here those are sent that say something.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import pytest
from _pytest.runner import runtestprotocol

if TYPE_CHECKING:
    from xdist.scheduler import LoadFileScheduling

__all__ = ["APART", "CLOCK", "DEAREST", "SHARED", "WAITING", "file_of", "order", "telling", "unit_of"]

DEAREST = (
    "tests/unit/test_known_prices.py",
    "tests/conformance/test_conformance.py",
    "tests/conformance/test_limits_run.py",
    "tests/unit/test_history.py",
    "tests/unit/test_engine_loop_limits.py",
    "tests/conformance/test_tracks.py",
    "tests/property/test_scene_files.py",
    "tests/conformance/test_fault_matrix.py",
    "tests/unit/test_selection.py",
    "tests/stress/test_input.py",
    "tests/unit/test_changes.py",
    "tests/conformance/test_bullet_contact.py",
    "tests/unit/test_reports_html.py",
    "tests/golden/test_contract.py",
    "tests/unit/test_agreement.py",
    "tests/conformance/test_limit_verdicts.py",
    "tests/unit/test_truth_chaos_and_painleve.py",
    "tests/conformance/test_equal_knobs.py",
    "tests/unit/test_trends.py",
    "tests/unit/test_report_links.py",
    "tests/unit/test_engine_joint_hold.py",
    "tests/unit/test_drawing.py",
    "tests/conformance/test_bullet_drives.py",
)
"""By the CPU seconds of each with those that go with it, and of all processes that they start, or by half of the time that it
takes where that is more; the others, which take some four seconds at most, follow by the number of their tests."""

SHARED = {
    "tests/conformance/test_negative_controls.py": "tests/conformance/test_conformance.py",
    "tests/browser/test_parity_page.py": "tests/browser/test_report.py",
    "tests/browser/test_every_page.py": "tests/browser/test_report.py",
    "tests/browser/test_selection_page.py": "tests/browser/test_report.py",
    "tests/browser/test_sensors_page.py": "tests/browser/test_report.py",
    "tests/browser/test_trends_page.py": "tests/browser/test_report.py",
    "tests/browser/test_what_changed.py": "tests/browser/test_report.py",
    "tests/unit/test_history_news.py": "tests/unit/test_history.py",
}
"""Files that go where another one goes, since both read what is worked out, or use what is started, once in a process."""

CLOCK = (
    "tests/unit/test_known_prices.py",
    "tests/unit/test_price_self_test.py",
    "tests/conformance/test_price_run.py",
    "tests/conformance/test_scaling_run.py",
    "tests/conformance/test_harness_overhead.py",
    "tests/conformance/test_clocked_loop.py",
    "tests/conformance/test_dominance.py",
    "tests/stress/test_planted_nights.py",
)
"""Files that run with a clock on: their tests are marked `clock`, and are one unit, so that no two of them run side by side."""

WAITING = (
    "tests/browser/test_report.py",
    "tests/browser/test_serve.py",
    "tests/stress/test_interruption.py",
    "tests/stress/test_planted.py",
    "tests/stress/test_server.py",
    "tests/unit/test_merge_folders.py",
)
"""Files that wait for others, a browser or processes that they start, longer than they compute. They go with those of a clock,
which wait too, and with these they come first, so that no two processes wait side by side."""


APART = (
    "tests/conformance/test_tracks.py::test_over_the_ladder_tuned_is_no_worse_on_the_whole_but_where_the_adapter_says_why",
)
"""Tests that take minutes for each of their parameters, and share nothing: each of these is a unit of its own."""


def file_of(test: str) -> str:
    """The file of a test. Args: test: its node id."""
    return test.partition("::")[0]


def unit_of(test: str) -> str:
    """What goes to one process along with a test: its file, or that which its file goes with. Args: test: its node id."""
    if test.partition("[")[0] in APART:
        return test
    file = SHARED.get(file_of(test), file_of(test))
    return CLOCK[0] if file in CLOCK or file in WAITING else file


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what runs with a clock on, before anything is chosen by its marks."""
    for item in items:
        if file_of(item.nodeid) in CLOCK:
            item.add_marker("clock")


def order(units: Mapping[str, Mapping[str, bool]]) -> list[str]:
    """The units, the dearest first. Args: units: to the tests of each."""
    rank = {file: number for number, file in enumerate(DEAREST)}
    return sorted(units, key=lambda unit: (file_of(unit) == unit, rank.get(unit, len(rank)), -len(units[unit])))


def telling(reports: Sequence[pytest.TestReport]) -> list[pytest.TestReport]:
    """The reports of a test but for those of a setup and a teardown that went well, whose time the first one left has too."""
    told = [report for report in reports if report.when == "call" or not report.passed or report.user_properties]
    told[0].duration += sum(report.duration for report in reports if report not in told)
    return told


def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Run a test as pytest does, in a process of pytest-xdist: what it has to say follows when it is over."""
    if not hasattr(item.config, "workerinput"):
        return None
    for report in telling(runtestprotocol(item, log=False, nextitem=nextitem)):
        item.ihook.pytest_runtest_logreport(report=report)
    return True


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> "LoadFileScheduling | None":
    """Take the place of what `--dist loadfile` would give."""
    if config.getoption("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class DearestFirst(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return unit_of(nodeid)

        def _assign_work_unit(self, node: Any) -> None:
            if not any(self.assigned_work.values()):
                for unit in order(self.workqueue):
                    self.workqueue.move_to_end(unit)
            super()._assign_work_unit(node)

    return DearestFirst(config, log)
