"""The order in which files go to the processes that run the tests: the dearest first, so that none is left idle at the end.

pytest-xdist hands out the files with most tests first, and those that take minutes have few: the last of them would run alone.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from xdist.scheduler import LoadFileScheduling

__all__ = ["DEAREST", "SHARED", "order", "unit_of"]

DEAREST = (
    "tests/conformance/test_tracks.py",
    "tests/browser/test_report.py",
    "tests/browser/test_serve.py",
    "tests/conformance/test_price_run.py",
    "tests/unit/test_engine_broad.py",
    "tests/conformance/test_conformance.py",
    "tests/conformance/test_limits_run.py",
    "tests/unit/test_tremble.py",
    "tests/unit/test_agreement.py",
    "tests/conformance/test_clocked_loop.py",
    "tests/stress/test_planted.py",
    "tests/golden/test_contract.py",
    "tests/unit/test_own_scene.py",
    "tests/unit/test_engine_batch.py",
    "tests/conformance/test_negative_controls.py",
    "tests/property/test_scene_files.py",
    "tests/unit/test_engine_images.py",
    "tests/unit/test_engine_cache.py",
    "tests/stress/test_input.py",
    "tests/unit/test_importers_mjcf.py",
    "tests/conformance/test_limit_verdicts.py",
    "tests/unit/test_converge.py",
    "tests/unit/test_engine_islands.py",
    "tests/conformance/test_equal_knobs.py",
    "tests/stress/test_damaged_store.py",
    "tests/conformance/test_scaling_run.py",
    "tests/conformance/test_robot_loaders.py",
    "tests/conformance/test_fault_matrix.py",
    "tests/unit/test_parity.py",
    "tests/unit/test_reports_price.py",
    "tests/unit/test_reports_html.py",
    "tests/unit/test_known_prices.py",
)
"""By what a process spends on each; the others, of a few seconds each, follow by the number of their tests."""

SHARED = {
    "tests/unit/test_price_self_test.py": "tests/unit/test_known_prices.py",
    "tests/conformance/test_negative_controls.py": "tests/conformance/test_conformance.py",
    "tests/browser/test_parity_page.py": "tests/browser/test_report.py",
    "tests/browser/test_sensors_page.py": "tests/browser/test_report.py",
    "tests/browser/test_what_changed.py": "tests/browser/test_report.py",
}
"""Files that go where another one goes, since both read what is worked out once in a process."""


def unit_of(test: str) -> str:
    """What goes to one process along with a test: its file, or that which its file goes with. Args: test: its node id."""
    file = test.partition("::")[0]
    return SHARED.get(file, file)


def order(units: Mapping[str, Mapping[str, bool]]) -> list[str]:
    """The units, the dearest first. Args: units: to the tests of each."""
    rank = {file: number for number, file in enumerate(DEAREST)}
    return sorted(units, key=lambda unit: (rank.get(unit, len(rank)), -len(units[unit])))


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
