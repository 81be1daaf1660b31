"""Does every link of a report lead somewhere, also where a run holds a part of what pages speak of?"""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from plumbline.harness.scene import Body, Scene, Sphere
from tests.links import dangling, files_of
from tests.recorded_folder import Folder, placed, record, rising
from tests.run_folder import row, write_run_folder
from tests.sensor_folder import write_sensor_folder

CASES = ("flight_projectile", "stack_tower")
Kept = Callable[[pd.DataFrame], pd.DataFrame]


def one(column: str, value: str) -> Kept:
    return lambda trials: trials[trials[column] == value]


def without_prices(trials: pd.DataFrame) -> pd.DataFrame:
    clocked = [name for name in trials if name.startswith("cpu") or name in ("wall_per_sim_s", "realtime_factor", "rough_cost")]
    return trials.assign(**dict.fromkeys(clocked, np.nan))


def crashed(trials: pd.DataFrame) -> pd.DataFrame:
    return without_prices(trials).assign(status="crashed", reason="planted")


PARTS: dict[str, Kept] = {
    "one case": one("case", "stack_tower"),
    "one engine": one("engine", "mujoco"),
    "the yardstick alone": one("engine", "reference"),
    "an engine that is not there": one("engine", "newton"),
    "one step": lambda trials: trials[trials["dt"] == trials["dt"].max()],
    "no trial": lambda trials: trials.iloc[:0],
    "no price": without_prices,
    "no answer": crashed,
}
"""What is left of a run of two cases."""
LONG_ONES = ("one case", "one engine", "no price")
"""Of one case there are pages in other tests here too; the yardstick alone is one engine too; no answer, no price."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run_folder(tmp_path_factory.mktemp("links") / "run", only=CASES)


def partly(whole: Path, folder: Path, kept: Kept, *, measured: bool = True) -> Path:
    """A copy of a run folder with a part of its trials."""
    folder.mkdir()
    for path in whole.iterdir():
        if path.suffix != ".parquet":
            (folder / path.name).symlink_to(path)
    trials = kept(pd.read_parquet(whole / "trials.parquet"))
    trials.to_parquet(folder / "trials.parquet", index=False)
    for name in ("measurements", "samples"):
        rows = pd.read_parquet(whole / f"{name}.parquet")
        rows[rows["trial"].isin(trials["trial"]) & measured].to_parquet(folder / f"{name}.parquet", index=False)
    return folder


@pytest.mark.parametrize("part", [pytest.param(part, marks=pytest.mark.slow if part in LONG_ONES else ()) for part in PARTS])
def test_every_link_of_a_part_of_a_run_leads_somewhere(whole: Path, tmp_path: Path, part: str) -> None:
    measured = part != "no answer"
    assert dangling(partly(whole, tmp_path / "run", PARTS[part], measured=measured)) == []


def test_every_link_of_a_whole_run_leads_somewhere(whole: Path) -> None:
    assert dangling(whole) == []


def test_every_link_of_a_run_of_sensors_alone_leads_somewhere(tmp_path: Path) -> None:
    assert dangling(write_sensor_folder(tmp_path / "run")) == []


def repeated(folder: Path, ways: tuple[str, ...]) -> Path:
    """A ball that rises, and again in these ways, each with the same bits."""
    scene = Scene(bodies=(Body(name="ball", collision=placed(Sphere(radius=0.1))),))
    made = Folder(folder)
    for way in ("", *ways):
        alteration = {"every_step": True} | ({"name": way} if way else {})
        answered = way != "restored"
        trial = record(
            "system_determinism",
            "mujoco",
            alteration=alteration,
            measurements=(),
            status="passed" if answered else "unsupported",
        )
        made.add(trial, *((scene, rising(scene)) if answered else ()))
    made.write(system_determinism={"title": "Again", "headline": "position_error_max", "dt": 0.01, "parameters": {}})
    return folder


@pytest.mark.parametrize("ways", [(), ("again", "restored", "nudged"), pytest.param(("restored",), marks=pytest.mark.slow)])
def test_every_link_of_a_run_on_determinism_alone_leads_somewhere(tmp_path: Path, ways: tuple[str, ...]) -> None:
    folder = repeated(tmp_path / "run", ways)
    files = files_of(folder)
    assert "determinism.html" in files
    assert dangling(folder, files) == []


def altered(folder: Path, **changes: object) -> Path:
    """One trial of a case without an answer, and one more beside it with these changes."""
    write_run_folder(folder, only=("flight_projectile",))
    plain = row("flight_projectile", "mujoco", "tuned", 1 / 240, status="timeout") | {"alteration": "{}", "members": 1}
    trials = pd.DataFrame([plain, plain | {"trial": "f" * 16} | changes])
    trials.astype({"unstable_timing": "boolean"}).to_parquet(folder / "trials.parquet", index=False)
    return folder


@pytest.mark.parametrize(
    ("changes", "page"),
    [
        ({"alteration": json.dumps({"name": "everything on", "present": ["friction"]})}, "effects.html"),
        ({"members": 2}, "limits.html"),
    ],
)
def test_every_link_of_a_run_with_hardly_an_effect_or_a_limit_leads_somewhere(
    tmp_path: Path, changes: dict[str, object], page: str
) -> None:
    folder = altered(tmp_path / "run", **changes)
    files = files_of(folder)
    assert page in files
    assert dangling(folder, files) == []


def test_a_link_to_no_file_and_one_to_no_place_are_told(whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = '<a href="#here" id="here"><a href="#gone"><a href="other.html#there"><img src="x.svg">'
    other = (
        '<p id="there"><a href="index.html#there"><a href="https://a.org/#any"><a href="../none.csv"><a href="../machine.json">'
    )
    monkeypatch.setattr("tests.links.files_of", lambda _: {"index.html": first, "other.html": other})
    wrong = ["index.html: #gone", "index.html: x.svg", "other.html: ../none.csv", "other.html: index.html#there"]
    assert dangling(whole) == wrong
