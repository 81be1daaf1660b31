"""Runs again with other code of the libraries: whether the variables act, what each row says, and what is not tried."""

import os
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path

import psutil
import pytest

from plumbline.harness.findings.tables.determinism import Repetition, broken, repetitions
from plumbline.harness.run import campaign, fork_servers
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.run.fork_servers import Origin, end_servers, start
from plumbline.harness.run.isolated import run_isolated
from plumbline.harness.store.store import Store
from plumbline.harness.study import expansion, library_variants, plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.library_variants import LIBRARY_VARIANTS, LibraryVariant, obstacle
from plumbline.harness.study.study import Study, load_study
from tests.conftest import PLUGINS
from tests.light_servers import light_servers
from tests.told_by_processes import show_libraries

KERNELS = {"BLAS for Prescott": {"Prescott", "Katmai"}, "BLAS for Haswell": {"Haswell"}, "BLAS for SkylakeX": {"SkylakeX"}}
"""What OpenBLAS calls them, which has two names for the first."""
WAIT = 60.0


@pytest.fixture
def light() -> Iterator[None]:
    with light_servers():
        yield


def shown(variables: library_variants.Variables) -> tuple[set[str], str, list[float]]:
    process = start(Origin(variables=variables), show_libraries)
    assert process.pipe.poll(WAIT)
    found: tuple[set[str], str, list[float]] = process.pipe.recv()
    process.join(WAIT)
    return found


def test_each_variable_acts_on_processes_that_are_born_with_it(light: None) -> None:
    """All that this machine can run; that NumPy and the C library answer otherwise without it shows that they need it."""
    _, code, sines = shown(())
    possible = [variant for variant in LIBRARY_VARIANTS if not obstacle(variant.variables)]
    if not possible:
        pytest.skip("; ".join(dict.fromkeys(obstacle(variant.variables) for variant in LIBRARY_VARIANTS)))
    for variant in possible:
        kernels, narrow, others = shown(variant.variables)
        if variant.name in KERNELS:
            assert kernels, variant.name
            assert kernels <= KERNELS[variant.name]
        assert ("baseline" in narrow) == ("baseline" in code or variant.name == "NumPy without AVX2")
        assert (others != sines) == (variant.name == "C library without FMA")
    assert not {name for variant in possible for name, _ in variant.variables} & os.environ.keys()


def test_servers_that_are_named_are_ended_and_no_others(light: None) -> None:
    varied = start(Origin(variables=(("SWAYED", "1"),)), id)
    other = start(Origin(number=1), id)
    assert varied.join(WAIT)
    assert other.join(WAIT)
    end_servers([Origin(variables=(("SWAYED", "1"),)), Origin(number=2)])
    assert not psutil.pid_exists(varied.server)
    assert psutil.pid_exists(other.server)
    assert list(fork_servers._servers) == [Origin(number=1)]


def test_what_the_machine_lacks_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in {name for variant in LIBRARY_VARIANTS for name, _ in variant.variables}:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(library_variants, "_processor_flags", lambda: frozenset({"pni", "avx2"}))
    haswell = next(variant for variant in LIBRARY_VARIANTS if variant.name == "BLAS for Haswell")
    assert obstacle(haswell.variables) == "/proc/cpuinfo names no fma"
    missing = LibraryVariant("another", (("ANOTHER", "1"),), ("avx2",), lambda: "the library is another")
    monkeypatch.setattr(library_variants, "LIBRARY_VARIANTS", (missing,))
    assert obstacle(missing.variables) == "the library is another"
    assert obstacle((("UNKNOWN", "1"),)) == obstacle(()) == ""


def test_libraries_are_varied_where_runs_are_repeated_alone() -> None:
    with pytest.raises(ValueError, match=r"libraries: joint_\*, stack_tower without determinism"):
        Experiment(name="one", libraries=("joint_*", "stack_tower"))


def test_the_study_of_determinism_varies_them_in_two_cases() -> None:
    cases = {name: plugins.case(name) for name in ("joint_chain", "stack_tower", "stack_pile")}
    trials = [*load_study("determinism").trials(cases, {"mujoco": plugins.adapter("mujoco")}, {"mujoco": "4.0.0"})]
    varied = [trial for trial in trials if trial.alteration.variables]
    asked = {(trial.case, trial.alteration.name, trial.track) for trial in varied}
    names = [variant.name for variant in LIBRARY_VARIANTS]
    assert asked == set(product(("joint_chain", "stack_tower"), names, ("default", "tuned")))
    assert len({trial.trial for trial in trials}) == len(trials)
    assert not any(trial.alteration.clocked for trial in varied)


STAND_INS = {
    "heeds nothing": ("SWAYED", ""),
    "rounds": ("SWAYED", "round"),
    "dies": ("SWAYED", "segfault"),
    "is set": ("SWAYED_TOO", "of the study"),
    "starts nothing": ("PYTHONHOME", "/nowhere"),
}
"""Variables of an engine of the test's own, one that is set already, and one with which no interpreter starts."""
STUDY = Study(
    name="swayed",
    recordings=False,
    experiments=(
        Experiment(
            name="bits", cases=("stress_fall",), tracks=("tuned",), timing=False, determinism=True, libraries=("stress_*",)
        ),
    ),
)


def carried_out(folder: Path) -> dict[str, Repetition]:
    """The repetitions of the stand-in by how they were made."""
    case, engine = plugins.case("stress_fall"), plugins.adapter("swayed")
    store = carry_out(STUDY, folder, {case.name: case}, {engine.name: engine}, workers=2, resume=True)
    return {each.way: each for each in repetitions(store)}


def test_a_row_says_whether_bits_survive_a_variable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The engine reads a variable of its own; what the user has set stays as it is, until a run that finds it unset."""
    from plumbline.reports.pages.determinism import PAGE

    monkeypatch.syspath_prepend(str(PLUGINS))
    for name in ("SWAYED", "PYTHONHOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("SWAYED_TOO", "of the user")
    variants = tuple(LibraryVariant(name, (variable,), (), str) for name, variable in STAND_INS.items())
    monkeypatch.setattr(expansion, "LIBRARY_VARIANTS", variants)
    monkeypatch.setattr(campaign, "run_isolated", run_isolated)  # other tests of this process may have it run in place
    rows = carried_out(tmp_path)
    assert not [origin for origin in fork_servers._servers if origin.variables or origin.only]
    assert {way: rows[way].verdict for way in STAND_INS} == {
        "heeds nothing": "bit-identical",
        "rounds": "differs",
        "dies": "crashed",
        "is set": "unavailable",
        "starts nothing": "crashed",
    }
    assert rows["again"].verdict == "bit-identical"
    assert (rows["rounds"].variables, rows["rounds"].first_step) == ("SWAYED=round", 20)
    assert rows["dies"].reason == "killed by SIGSEGV"
    assert rows["is set"].reason == "SWAYED_TOO is 'of the user' in the environment already, and is left so"
    assert rows["starts nothing"].reason.startswith("with PYTHONHOME=/nowhere: a process could not be started")
    assert os.environ["SWAYED_TOO"] == "of the user"
    assert not any(rows[way].must for way in STAND_INS)
    assert broken(rows.values(), ["swayed"]) == []
    assert broken([replace(rows["rounds"], must=True)], ["swayed"]) != []
    monkeypatch.delenv("SWAYED_TOO")
    resumed = carried_out(tmp_path)
    assert resumed.pop("is set").verdict == "bit-identical"
    assert resumed == {way: row for way, row in rows.items() if way != "is set"}
    page = PAGE.render(Store(tmp_path))["determinism.html"]
    assert page.count("<code>SWAYED=round</code>") == 1
    assert "Which bits survive other libraries" in page
