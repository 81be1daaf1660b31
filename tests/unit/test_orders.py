"""The orders table on run folders made by formula and on a real engine that loses its order: promises kept and broken."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from plumbline.harness.adapter import Adapter, Settings
from plumbline.harness.cli.main import main
from plumbline.harness.findings.tables.orders import TABLE, convergences, verdict
from plumbline.harness.store.journal import Journal
from plumbline.harness.store.record import Measurement, Record
from plumbline.harness.store.store import Store, write_json
from plumbline.harness.study import plugins
from plumbline.harness.study.catalogue import describe_case, describe_engine
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study
from plumbline.harness.trial.accuracy import run_trial
from tests.links import texts_of, without_word_links
from tests.planted_faults.planting import Wrapped, plant
from tests.run_folder import write_run_folder

LADDER = [1 / 60 / 2**k for k in range(6)]


def folder(
    path: Path,
    errors: dict[str, list[float]],
    case: dict[str, Any],
    orders: dict[str, int],
    substeps: Callable[[float], int] = lambda _: 1,
    **more: Any,
) -> Store:
    """A run folder with a ladder for each engine, which takes `substeps` of a time step."""
    path.mkdir(exist_ok=True)
    journal = Journal(path)
    for engine, ladder in errors.items():
        for k, (dt, error) in enumerate(zip(LADDER, ladder, strict=False)):
            journal.append(
                Record(
                    trial=f"{engine}-{k}", study="s", experiment="a" if k < 2 else "b", case="flight_x", parameters={"n": 1},
                    engine=engine, engine_version="1", track="tuned", dt=dt, settings={"dt": dt},
                    resolved={"integrator": "rk4", "dt": dt, "substeps": substeps(dt)},
                    measurements=(Measurement(metric="e", value=error, unit="m"),), **{"status": "passed", "reason": ""} | more,
                )
            )  # fmt: skip
    journal.close()
    case = {"headline": "e", "title": "X", "scale": 1.0, "duration": 1.0, "parameters": {"n": 1}} | case
    engines = {name: {"name": name, "title": name.upper(), "orders": orders} for name in errors}
    write_json(path / "catalogue.json", {"cases": {"flight_x": case}, "engines": engines})
    return Store(path)


def test_promises_are_read_off_the_engine_and_the_case_and_broken_ones_are_sentences(tmp_path: Path) -> None:
    errors = {"sound": [dt**4 for dt in LADDER], "slow": list(LADDER)}
    rows = {row.engine: row for row in convergences(folder(tmp_path, errors, {"converges": "smoothly"}, {"rk4": 4}))}
    assert (rows["sound"].verdict, rows["sound"].promised, rows["sound"].finding) == ("kept", 4, "")
    assert rows["slow"].verdict == "broken"
    for word in ("X", "SLOW", "tuned", "Runge-Kutta of order 4", "order 1.00 (1.00 to 1.00)", "promised is 4"):
        assert word in rows["slow"].finding
    assert tuple(TABLE.flat(rows["slow"])) == TABLE.columns
    assert TABLE.brief(rows["slow"])[:4] == ["flight_x", "slow", "tuned", "rk4"]


@pytest.mark.parametrize(
    ("converges", "orders", "promised"),
    [("smoothly", {"rk4": 4}, 4), ("once", {"rk4": 4}, 1), ("", {"rk4": 4}, None), ("smoothly", {"euler": 1}, None)],
)
def test_contacts_leave_the_first_order_and_what_is_not_declared_is_not_promised(
    tmp_path: Path, converges: str, orders: dict[str, int], promised: int | None
) -> None:
    (row,) = convergences(folder(tmp_path, {"one": list(LADDER)}, {"converges": converges}, orders))
    assert row.promised == promised
    assert row.verdict == ("none" if promised is None else "broken" if promised == 4 else "kept")


def test_runs_without_an_answer_and_ladders_of_two_steps_have_no_row(tmp_path: Path) -> None:
    smooth = {"converges": "smoothly"}
    failed = folder(tmp_path / "a", {"one": list(LADDER)}, smooth, {"rk4": 4}, status="diverged", reason="NaN")
    assert convergences(failed) == ()
    assert convergences(folder(tmp_path / "b", {"one": [1.0, 0.5]}, smooth, {"rk4": 4})) == ()


def test_a_ladder_whose_coarse_rungs_are_cut_into_sub_steps_is_judged_by_the_steps_that_were_taken(tmp_path: Path) -> None:
    def cut(dt: float) -> int:
        return max(1, math.ceil(dt * 240 - 1e-9))

    def row(name: str, errors: list[float], substeps: Callable[[float], int]) -> Any:
        (one,) = convergences(folder(tmp_path / name, {"one": errors}, {"converges": "smoothly"}, {"rk4": 1}, substeps))
        return one

    taken = [dt / cut(dt) for dt in LADDER]
    # First order in the step taken: 1/240 s on three rungs, one point of four; told by the rungs it would lie below one.
    sound = row("cut", taken, cut)
    assert (sound.verdict, sound.fit.used, sound.fit.coarse) == ("kept", 4, pytest.approx(1 / 240))
    assert sound.fit.order == pytest.approx(1.0, abs=1e-9)
    # The same number of sub-steps on all rungs moves nothing: steps are told as those of the finest rung.
    assert row("even", list(LADDER), lambda _: 4).fit.coarse == pytest.approx(1 / 60)
    # Errors that do not shrink with the step that is taken are no less broken.
    assert row("stuck", [1.0] * 6, cut).verdict == "broken"


def test_rounding_alone_is_exact_and_two_steps_above_it_leave_the_question_open() -> None:
    assert verdict(LADDER, [1e-15] * 6, 4, 1.0, 1.0) == (None, "exact")
    assert verdict(LADDER, [1e-5, 1e-9, *[1e-15] * 4], 4, 1.0, 1.0) == (None, "open")
    assert verdict(LADDER, [1e-9] * 6, 4, 1e3, 1.0)[1] == "exact"


def test_the_command_line_shows_the_table_in_every_form_and_says_what_is_broken(tmp_path: Path) -> None:
    folder(tmp_path, {"slow": list(LADDER)}, {"converges": "smoothly"}, {"rk4": 4})

    def shown(form: str) -> str:
        done = CliRunner().invoke(main, ["show", str(tmp_path), "--table", "orders", "--format", form])
        assert done.exit_code == 0, done.output
        return done.stdout

    (row,) = json.loads(shown("json"))
    assert tuple(row) == TABLE.columns
    assert row["verdict"] == "broken"
    assert row["finding"] in shown("text")
    assert shown("csv").splitlines()[0] == ",".join(TABLE.columns)
    assert len(shown("markdown").splitlines()) == 3


def test_the_report_says_so_on_the_first_page_and_on_that_of_the_case(tmp_path: Path) -> None:
    store = write_run_folder(tmp_path / "run", only=("joint_chain",))
    texts = texts_of(Store(store), "index", "case")
    broken = [row for row in convergences(Store(store)) if row.verdict == "broken"]
    assert {row.engine for row in broken} == {"mujoco", "dart"}
    for row in broken:
        assert row.finding in texts["case-joint_chain.html"]
    assert "Errors shrink less with the time step than the integrator promises on 4 of 8 ladders" in without_word_links(
        texts["index.html"]
    )


class _Claims(Wrapped):
    """An engine that says rk4, whatever it does."""

    @property
    def resolved(self) -> Settings:
        """The integrator that was asked for."""
        return replace(self.inner.resolved, integrator="rk4")


def _slower(adapter: Adapter) -> Adapter:
    """Runge and Kutta are asked for, Euler answers."""
    return plant(adapter, settings=lambda asked: replace(asked, integrator="semi_implicit_euler"), simulation=_Claims)


@pytest.mark.parametrize(("kind", "told"), [(lambda adapter: adapter, "kept"), (_slower, "broken")])
@pytest.mark.parametrize("name", ["joint_pendulum", pytest.param("spin_symmetric_top", marks=pytest.mark.slow)])
def test_a_real_engine_that_loses_its_order_is_found_out(tmp_path: Path, name: str, kind: Any, told: str) -> None:
    case, sound = plugins.case(name), plugins.adapter("reference")
    adapter = kind(sound)
    study = Study(name="s", experiments=(Experiment(name="e", tracks=("tuned",), dt="ladder"),))
    journal = Journal(tmp_path)
    for trial in study.trials({name: case}, {"reference": sound}, {"reference": "1"}):
        journal.append(run_trial(trial, case, adapter, None))
    journal.close()
    catalogue = {"cases": {name: describe_case(case)}, "engines": {"reference": describe_engine(sound)}}
    write_json(tmp_path / "catalogue.json", catalogue)
    (row,) = convergences(Store(tmp_path))
    assert (row.promised, row.verdict) == (4, told)


def test_every_track_of_a_built_in_engine_has_a_promise_for_the_integrator_that_it_resolves_to() -> None:
    case = plugins.case("spin_symmetric_top")
    for adapter in plugins.adapters().values():
        if plugins.version_of(adapter)[1] is None:
            for settings in adapter.tracks.values():
                simulation = adapter.build(case.scene(case.parameters), settings)
                assert simulation.resolved.integrator in adapter.orders, adapter.name
                simulation.close()
