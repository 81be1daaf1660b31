"""The page on sensors: there where a scene had some, every trial named, pictures inside, silent about what is not there."""

import base64
import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from plumbline.harness.store.store import Store
from plumbline.reports.charts.ideal_signals import _errors
from plumbline.reports.pages.sensors import PAGE
from plumbline.reports.recordings.pixels import BEYOND, INVALID, data_uri, shaded, srgb
from plumbline.reports.words.catalogue import labels
from tests.links import texts_of
from tests.run_folder import write_run_folder
from tests.sensor_folder import write_sensor_folder


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return Store(write_sensor_folder(tmp_path_factory.mktemp("sensors") / "run"))


@pytest.fixture(scope="module")
def files(store: Store) -> dict[str, Any]:
    return dict(PAGE.render(store))


def test_a_store_without_sensors_has_no_such_page_and_no_link_to_it(tmp_path: Path) -> None:
    texts = texts_of(Store(write_run_folder(tmp_path / "run", only=("stack_tower",))), "sensors", "index")
    assert "sensors.html" not in texts
    assert "sensors.html" not in texts["index.html"]


def test_the_page_stands_among_the_others_of_its_report(store: Store, files: dict[str, Any]) -> None:
    assert 'href="sensors.html"' in texts_of(store, "index")["index.html"]
    assert "sensors.csv" in files


def test_every_trial_is_named_with_its_outcome(store: Store, files: dict[str, str]) -> None:
    page = files["sensors.html"]
    for row in store.trials.to_dict("records"):
        if row["clocks"] != "casting":
            assert row["trial"] in page
    assert page.count("data-status=") == len(files["sensors.csv"].splitlines()) - 1
    for words in ("no renderer", "the state is not finite", "fails", "holds"):
        assert words in page


def test_there_is_a_chart_for_each_kind_of_error_and_each_law_of_noise(files: dict[str, Any]) -> None:
    charts = {name for name in files if name.startswith("charts/")}
    for start in ("ideal-m.", "ideal-rad-per-s.", "allan-sensor_planted", "ranges-sensor_planted", "depths-", "sensor-rays"):
        assert any(name.startswith(f"charts/{start}") for name in charts), start
    assert all(chart.svg.startswith("<svg") for name, chart in files.items() if name.startswith("charts/"))


def test_pictures_stand_in_the_page_and_open(files: dict[str, str]) -> None:
    found = re.findall(r'src="data:image/png;base64,([^"]+)"', files["sensors.html"])
    # Colour and depth of the camera and depth of the depth camera: the truth and two engines each.
    assert len(found) == 9
    for text in found:
        with Image.open(io.BytesIO(base64.b64decode(text))) as picture:
            assert picture.size == (32, 24)


def test_linear_light_becomes_srgb() -> None:
    """IEC 61966-2-1: half the light is 188 of 255; below 0.0031308 the curve is a line of slope 12.92."""
    grey = np.array([[[0.0] * 3, [0.5] * 3, [0.003] * 3, [1.0] * 3, [7.0] * 3, [np.nan, 0.0, 0.0]]])
    pixels = srgb(grey)
    assert pixels[0, :5, 0].tolist() == [0, 188, round(255 * 12.92 * 0.003), 255, 255]
    assert tuple(pixels[0, 5]) == INVALID


def test_bounds_are_drawn_in_the_order_of_their_signals_in_every_process(store: Store) -> None:
    """Not in that of a set, which is another with each start of Python: the same store has the same page."""
    same = {"engine": labels(store)["mujoco"], "track": "tuned", "error": 0.1, "verdict": "holds", "trial": "t"}
    rows = [same | {"signal": f"signal {k}", "bound": 1.0 + k} for k in (3, 1, 4, 1, 5, 9, 2, 6)]
    drawn = _errors(store, rows, "m", "Ranges").spec["datasets"].values()
    (bounds,) = (shown for shown in drawn if shown[0].keys() == {"signal", "bound"})
    assert [row["signal"] for row in bounds] == [f"signal {k}" for k in (3, 1, 4, 5, 9, 2, 6)]


def test_depths_are_shaded_from_near_to_far_and_what_is_none_stands_out() -> None:
    pixels = shaded(np.array([[1.0, 3.0, 2.0, np.nan, np.inf, -np.inf]]), 1.0, 3.0)
    assert tuple(pixels[0, 0]) == (253, 231, 37)
    assert tuple(pixels[0, 1]) == (68, 1, 84)
    assert tuple(pixels[0, 2]) == (33, 145, 140)
    assert [tuple(one) for one in pixels[0, 3:]] == [INVALID, BEYOND, BEYOND]


def test_a_picture_comes_back_from_its_address_bit_by_bit() -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    address = data_uri(pixels)
    with Image.open(io.BytesIO(base64.b64decode(address.partition(",")[2]))) as picture:
        assert np.array_equal(np.asarray(picture), pixels)
