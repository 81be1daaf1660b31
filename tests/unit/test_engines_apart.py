"""Engines that plumbline does not bring along: what is said of them, how they are installed, and that they cost there what they
cost here."""

import sys
from dataclasses import replace
from importlib.metadata import distribution
from pathlib import Path

import pytest

from plumbline.harness.adapter import Adapter, Extra
from plumbline.harness.findings.cost_point import ratio_in_blocks, samples_by_block
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.run.fork_servers import Origin, start
from plumbline.harness.run.make_environment import ensure
from plumbline.harness.study import environments, plugins
from plumbline.harness.study.engine_versions import EngineVersion
from plumbline.harness.study.environments import Environment, elsewhere, folder_of, home_of, keep, lock_of
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study
from tests.conftest import Command
from tests.light_servers import light_servers
from tests.told_by_processes import show_where

EXTRAS = [name for name, adapter in plugins.adapters().items() if adapter.extra is not None]


@pytest.fixture
def nowhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of environments without any, beside which no extra is installed."""
    monkeypatch.setenv("PLUMBLINE_ENVIRONMENTS", str(tmp_path))
    packages = {plugins.adapter(name).distribution for name in EXTRAS}
    here = environments.installed
    monkeypatch.setattr(environments, "installed", lambda name: name not in packages and here(name))
    return tmp_path


@pytest.mark.parametrize("name", EXTRAS)
def test_what_is_not_installed_says_what_it_takes_and_how_and_ends_as_wrong_usage(
    name: str, nowhere: Path, printed: Command
) -> None:
    extra = plugins.adapter(name).extra
    assert extra is not None
    done = printed("run", "quick", "--engine", name, "--out", nowhere / "run")
    assert done.returncode == 2
    assert extra.price in done.stderr
    assert "--yes" in done.stderr
    assert f"plumbline[{name}]" in done.stderr
    assert not (nowhere / "run").exists()
    version, reason = plugins.version_of(plugins.adapter(name))
    assert (version, reason) == ("none", f"not installed: --engine {name} --yes does so ({extra.price})")


def test_a_run_of_all_engines_asks_none_that_is_not_installed(nowhere: Path) -> None:
    from plumbline.api.engines import chosen_engines

    keep(EXTRAS[0], Environment("python", version="1", distribution=plugins.adapter(EXTRAS[0]).distribution))
    assert home_of(EXTRAS[0]) is not None
    assert set(chosen_engines(())) == set(plugins.names("adapters")) - set(EXTRAS)


@pytest.mark.parametrize("name", EXTRAS)
def test_the_lock_of_an_engine_pins_its_package(name: str) -> None:
    lock = lock_of(name)
    assert lock is not None
    assert f"\n{plugins.adapter(name).distribution}==" in f"\n{lock.read_text(encoding='utf-8')}"


def test_another_lock_is_another_environment(nowhere: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    before = folder_of(EXTRAS[0])
    other = tmp_path / "requirements.lock"
    other.write_text("another==1\n")
    monkeypatch.setattr("plumbline.harness.study.environments.lock_of", lambda _name: other)
    assert folder_of(EXTRAS[0]) != before


def test_an_engine_for_another_python_says_so(monkeypatch: pytest.MonkeyPatch, nowhere: Path) -> None:
    later = replace(plugins.adapter(EXTRAS[0]), extra=Extra(megabytes=1, seconds=1, pythons=("2.7",)))
    assert plugins.version_of(later)[1] is not None
    assert "needs Python 2.7" in str(plugins.version_of(later)[1])


def test_an_engine_that_is_installed_here_runs_here_whatever_lies_elsewhere(nowhere: Path) -> None:
    keep("mujoco", Environment("python", version="1", distribution="mujoco"))
    assert elsewhere("mujoco") is None
    keep("mujoco", Environment("python", version="1", distribution="not-installed-anywhere"))
    found = elsewhere("mujoco")
    assert found is not None
    assert found.version == "1"


@pytest.mark.parametrize("named", ["only_there", "colorsys"])
def test_a_process_of_an_environment_finds_what_lies_there_before_what_lies_here(named: str, tmp_path: Path) -> None:
    """A module that is there alone, and one of a name that is here too, as another version of an engine is."""
    (tmp_path / f"{named}.py").touch()
    with light_servers():
        process = start(Origin(environment=Environment(sys.executable, (str(tmp_path),))), show_where, named)
        try:
            assert process.pipe.recv() == str(tmp_path / f"{named}.py")
        finally:
            process.end()


@pytest.mark.slow
@pytest.mark.clock
def test_a_step_costs_in_an_environment_what_it_costs_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same MuJoCo both ways, in blocks that take turns: 1 lies within the interval of the ratio, or 5 % beside it.

    Two processes of one interpreter have been seen 2 % apart (`harness.run.fork_servers`).
    """
    monkeypatch.setenv("PLUMBLINE_ENVIRONMENTS", str(tmp_path))
    there = EngineVersion("mujoco", distribution("mujoco").version)
    environment = ensure(there, "mujoco")
    if environment.reason:
        pytest.skip(f"no package index: {environment.reason}")
    case, experiment = "stack_tower", Experiment(name="both", tracks=("tuned",), samples=15, sample_seconds=0.05)
    adapters: dict[str, Adapter] = {name: plugins.adapter(name) for name in ("mujoco", there.name)}
    store = carry_out(
        Study(name="both", recordings=False, experiments=(experiment,)),
        tmp_path / "run",
        {case: plugins.case(case)},
        adapters,
        workers=1,
        resume=False,
    )
    table = store.trials.set_index("engine")
    assert table["trajectory_hash"].nunique() == 1
    blocks = samples_by_block(store)
    found = ratio_in_blocks(blocks[table.loc[there.name, "trial"]], blocks[table.loc["mujoco", "trial"]])
    assert found is not None
    assert found.low / 1.05 <= 1.0 <= found.high * 1.05, found
