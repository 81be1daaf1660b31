"""Every page is made of every kind of store: cases at several values of a parameter, altered scenes, scenes of one's own, an
engine that is missing, one engine alone; and a page that fails is named where a command ends."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner

from plumbline.harness.case.alteration import EVERYTHING
from plumbline.harness.cli.main import main
from plumbline.harness.findings import tables
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.scene import Body, Scene, sphere_inertia
from plumbline.harness.scene.file import dump_toml
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Refinement
from plumbline.harness.study.study import load_study, study_of
from plumbline.reports.html import report as html
from plumbline.reports.page import Page, pages
from tests.in_process import clocked_by, in_this_process
from tests.known_prices import LAWS, PLUGINS
from tests.run_folder import write_run_folder

CASES = ("flight_projectile", "joint_pendulum", "stack_tower")
ALTERED = """
name = "altered"
recordings = false
[[experiments]]
name = "effects"
cases = ["flight_projectile"]
engines = ["mujoco", "bullet"]
tracks = ["tuned"]
effects = true
[[experiments]]
name = "again"
cases = ["flight_projectile"]
engines = ["mujoco", "bullet"]
tracks = ["tuned"]
determinism = true
timing = false
"""


def changed(folder: Path, change: Callable[[pd.DataFrame], pd.DataFrame]) -> Path:
    """A run folder whose table of trials is another."""
    write_run_folder(folder, only=CASES)
    trials = pd.read_parquet(folder / "trials.parquet")
    change(trials).to_parquet(folder / "trials.parquet", index=False)
    return folder


def again(trials: pd.DataFrame, mark: str, folder: Path, **columns: str) -> pd.DataFrame:
    """The trials once more under other names with some columns changed; what was measured of them is measured of these too."""
    measurements = pd.read_parquet(folder / "measurements.parquet")
    theirs = measurements[measurements["trial"].isin(trials["trial"])]
    more = theirs.assign(trial=mark + theirs["trial"].str[1:])
    pd.concat([measurements, more]).to_parquet(folder / "measurements.parquet", index=False)
    return trials.assign(trial=mark + trials["trial"].str[1:], **columns)


def with_parameters(folder: Path) -> Path:
    """Each trial at two values of a parameter."""
    return changed(folder, lambda trials: pd.concat([trials, again(trials, "p", folder, parameters=json.dumps({"mass": 2.0}))]))


def with_alterations(folder: Path) -> Path:
    """A scene with effects switched on and off, and run again in other ways."""
    path = folder.with_suffix(".toml")
    path.write_text(ALTERED, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        in_this_process(patch)
        clocked_by(patch, lambda trial: [1e-6 + 1e-7 * (trial.alteration.name == EVERYTHING)] * 3)
        cases = {"flight_projectile": plugins.case("flight_projectile")}
        adapters = {name: plugins.adapter(name) for name in ("mujoco", "bullet")}
        return carry_out(load_study(str(path)), folder, cases, adapters, workers=1, resume=False).folder


def without_an_engine(folder: Path) -> Path:
    """One engine is in the catalogue and on no machine: its trials are unavailable."""

    def missing(trials: pd.DataFrame) -> pd.DataFrame:
        nothing = dict.fromkeys(("cpu_per_sim_s", "cpu_low", "cpu_high", "rough_cost"), float("nan"))
        lost = trials[trials["engine"] == "dart"].assign(status="unavailable", reason="not installed", **nothing)
        return pd.concat([trials[trials["engine"] != "dart"], lost])

    return changed(folder, missing)


def of_one_engine(folder: Path) -> Path:
    """MuJoCo alone was run."""
    return changed(folder, lambda trials: trials[trials["engine"] == "mujoco"])


def of_ours_alone(folder: Path) -> Path:
    """The reference engine alone was run."""
    return changed(folder, lambda trials: trials[trials["engine"] == "reference"])


def own_scene(folder: Path) -> Path:
    """A ball thrown by a file of the user's own, on two engines that err by a law."""
    ball = Body(name="ball", inertia=sphere_inertia(1.0, 0.1), p_WB=(0, 0, 1), v_WB=(3, 0, 4))
    path = folder.with_suffix(".toml")
    path.write_text(dump_toml(Scene(bodies=(ball,))), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(PLUGINS)
        in_this_process(patch)
        clocked_by(patch, lambda trial: [LAWS[trial.engine, trial.track].spin] * 3)
        path.with_suffix(".plumb.toml").write_text("duration = 0.5\n", encoding="utf-8")
        case = plugins.case(f"{plugins.SCENE_PREFIX}{path}")
        study = study_of(case)
        ladder = replace(study.experiments[0], samples=3, sample_seconds=0.001, refine=Refinement(finest=1 / 960))
        adapters = {name: plugins.adapter(name) for name in ("spinner", "laggard")}
        return carry_out(
            replace(study, experiments=(ladder,)), folder, {case.name: case}, adapters, workers=1, resume=False
        ).folder


STORES = (with_parameters, with_alterations, without_an_engine, of_one_engine, of_ours_alone, own_scene)
SHOWS = {  # pages beyond those of every store, and what stands on them
    with_parameters: {"price": "Thrown body, mass 2"},
    with_alterations: {"effects": "gravity", "determinism": "restored"},
    own_scene: {"case-": "", "index": "scene"},
}


@pytest.fixture(scope="module", params=STORES, ids=lambda write: write.__name__)
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Callable[[Path], Path], Path]:
    return request.param, request.param(tmp_path_factory.mktemp("store") / "run")


def test_every_page_is_made(made: tuple[Callable[[Path], Path], Path]) -> None:
    write, folder = made
    report = html.write_report(folder)
    assert report.failed == ()
    written = {path.stem: path.read_text(encoding="utf-8") for path in report.index.parent.glob("*.html")}
    for start, words in SHOWS.get(write, {}).items():
        assert any(name.startswith(start) and words in text for name, text in written.items()), start


def test_every_table_is_made(made: tuple[Callable[[Path], Path], Path]) -> None:
    store = Store(made[1])
    for name in tables.names():
        table = tables.table(name)
        rows = table.rows(store)
        assert all(row.keys() >= set(table.columns) for row in rows), name
        assert all(len(table.brief(each)) == len(table.shown) for each in table.objects(store)), name
        table.said(store)


def test_a_page_that_fails_is_named_at_the_end_and_the_command_ends_with_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_run_folder(tmp_path / "run", only=CASES[:1])

    def broken(_: Store) -> dict[str, str]:
        raise RuntimeError("no page")

    few = tuple(page for page in pages() if page.name in ("index", "method"))
    monkeypatch.setattr(html, "pages", lambda: (*few, Page(name="x", title="Broken", order=99, render=broken)))
    done = CliRunner().invoke(main, ["report", str(folder)])
    assert done.exit_code == 1
    assert done.stderr.splitlines()[-1] == "page 'Broken' could not be made: RuntimeError: no page"
    front = (folder / "report" / "index.html").read_text(encoding="utf-8")
    assert "<b>Broken</b>: RuntimeError: no page" in front
    assert (folder / "report" / "method.html").is_file()
    monkeypatch.setattr(html, "pages", lambda: few)
    assert CliRunner().invoke(main, ["report", str(folder)]).exit_code == 0
    assert "could not be made" not in (folder / "report" / "index.html").read_text(encoding="utf-8")
