"""Long runs as the table of drifts reads them: what rests by its place, what moves by its energy."""

import json
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.findings.tables.drift import TABLE, _series
from plumbline.harness.scene import Body, Box, PlacedShape, Scene, box_inertia
from plumbline.harness.scene.file import dump_json
from plumbline.harness.statistics.order import fit_slope
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.store import Store
from tests.run_folder import write_run_folder

HALF = (0.1, 0.1, 0.1)
CREEP = 1e-6


def kept(speed: float) -> dict[str, object]:
    """A box that goes along x at `speed` [m/s] for a thousand seconds, sampled every second."""
    body = Body(name="box", mass=1.0, inertia=box_inertia(1.0, HALF), collision=(PlacedShape(shape=Box(half_extents=HALF)),))
    time = np.arange(1001.0)
    p_WB, q_WB, v_WB = np.zeros((1001, 1, 3)), np.zeros((1001, 1, 4)), np.zeros((1001, 1, 3))
    p_WB[:, 0, 0], q_WB[:, 0, 0], v_WB[:, 0, 0] = speed * time, 1.0, speed
    return {
        "scene": dump_json(Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0))),
        "dt": 0.01,
        "time": time,
        "p_WB": p_WB,
        "q_WB": q_WB,
        "v_WB": v_WB,
        "w_WB": np.zeros((1001, 1, 3)),
    }


def test_a_planted_creep_is_found_as_a_secular_trend() -> None:
    quantity, time, series = _series(kept(CREEP), rests=True)
    fit = fit_slope(time.tolist(), series.tolist())
    assert quantity == "place"
    assert fit is not None
    assert fit.secular
    assert abs(fit.slope - CREEP) < 1e-3 * CREEP


def test_a_body_that_keeps_its_speed_keeps_its_energy() -> None:
    quantity, _, series = _series(kept(1.0), rests=False)
    assert quantity == "energy"
    assert np.abs(series).max() == 0.0


def test_a_folder_whose_catalogue_has_no_durations_is_told_to_write_it_anew(tmp_path: Path) -> None:
    folder = write_run_folder(tmp_path / "run")
    catalogue = json.loads((folder / "catalogue.json").read_text(encoding="utf-8"))
    for case in catalogue["cases"].values():
        del case["duration"]
    (folder / "catalogue.json").write_text(json.dumps(catalogue), encoding="utf-8")
    with pytest.raises(StoreError, match=r"catalogue\.json: cases: '\w+' lacks 'duration'; run the study again with --resume"):
        TABLE.objects(Store(folder))
