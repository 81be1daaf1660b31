"""What charts and summaries say, one by one: dashes, bars, units, columns, ends of intervals, counts of what tuning changes."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plumbline.harness.findings.tables.scaling import Cost
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.order import fit_order
from plumbline.harness.store.store import Store
from plumbline.reports.charts import errors, step_costs
from plumbline.reports.charts.marks import Marks
from plumbline.reports.tables.summary import more, tuning
from plumbline.reports.words.text import amount
from tests.run_folder import write_run_folder


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """A run of several engines on both tracks."""
    folder: Path = tmp_path_factory.mktemp("drawn") / "run"
    return Store(write_run_folder(folder))


def test_the_defaults_are_dashed_and_tuned_lines_are_whole(store: Store) -> None:
    style = Marks(store, [{"engine": "MuJoCo", "track": track} for track in ("tuned", "default")])
    assert style.dash()["scale"] == {"domain": ["default", "tuned"], "range": [[4, 3], [1, 0]]}


def test_two_seeds_of_a_setting_are_spanned_by_a_bar_and_one_is_not() -> None:
    rows = [{"series": "a", "dt": 0.1, "error": error} for error in (2.0, 3.0)] + [{"series": "b", "dt": 0.1, "error": 5.0}]
    assert [(row["series"], row["least"], row["most"]) for row in errors.spans(rows)] == [("a", 2.0, 3.0)]


def test_an_axis_has_its_unit_and_a_plain_number_has_none() -> None:
    assert errors.axis_title("position_error", "m").endswith(" [m]")
    assert "[" not in errors.axis_title("radius_error", "1")


def test_columns_come_in_the_order_of_the_engines() -> None:
    rows = [
        {"case": "a case", "track": "tuned", "engine": name, "error": error, "status": "passed"}
        for name, error in (("Alpha", 1.0), ("Zeta", 2.0))
    ]
    head, cells = errors.beside_each_other(rows, ["Zeta", "Alpha"], "error")
    assert list(head) == ["case", "track", "Zeta", "Alpha"]
    assert cells == [["a case", "tuned", "2", "1"]]


def test_a_cost_keeps_its_ends_and_its_penetration_is_in_micrometres(store: Store) -> None:
    cost: Any = dict.fromkeys(
        ("to_fastest", "reference", "residual", "error", "unstable"),
    ) | {"parameters": {}, "unit": "step", "reference_setting": "", "error_metric": "", "best": True, "reason": ""}
    row = Cost(
        case="stack_tower", where="", engine="mujoco", track="tuned", cpu=Interval(3e-6, 2e-6, 5e-6), penetration=7e-6,
        status="passed", dt=0.01, substeps=1, trial="t", **cost,
    )  # fmt: skip
    told = step_costs.drawn(store, row)
    assert [told[name] for name in ("cpu", "low", "high", "penetration")] == pytest.approx([3.0, 2.0, 5.0, 7.0])


@dataclass
class _Outcome:
    name: str


@dataclass
class _Cell:
    worst: _Outcome


def test_tuning_gains_what_passes_by_it_and_loses_what_it_breaks(store: Store) -> None:
    def cell(name: str) -> Any:
        return _Cell(_Outcome(name))

    names = list(store.catalogue["cases"])
    cells: dict[tuple[str, str, str], Any] = {}
    for case, default, tuned in (
        (names[0], "failed", "passed"),
        (names[1], "failed", "passed"),
        (names[2], "passed", "failed"),
    ):
        cells |= {(case, "mujoco", "default"): cell(default), (case, "mujoco", "tuned"): cell(tuned)}
    (sentence,) = tuning(store, cells)
    assert sentence.endswith("MuJoCo gains 2 and loses 1.")


def test_a_list_of_five_says_that_one_was_cut() -> None:
    assert more(["title"] * 4) == ""
    assert more(["title"] * 5) == " and 1 more"


def test_a_power_of_ten_below_zero_keeps_its_minus() -> None:
    assert amount(-1e-6) == "-10⁻⁶"


def test_the_slope_at_the_fine_end_is_that_of_the_three_finest_steps() -> None:
    """Fourth order where steps are coarse, first where they are fine."""
    dt = 0.1 / 2.0 ** np.arange(8)
    error = dt**4 + 1e-6 * dt
    fit = fit_order(dt.tolist(), error.tolist())
    assert fit is not None
    finest, coarsest = slice(fit.used - 3, fit.used), slice(0, 3)
    slopes = [float(np.polyfit(np.log(dt[of]), np.log(error[of]), 1)[0]) for of in (finest, coarsest)]
    assert fit.at_fine_end == pytest.approx(slopes[0], rel=1e-9)
    assert slopes[0] < slopes[1] - 0.5
