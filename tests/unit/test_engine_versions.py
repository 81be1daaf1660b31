"""Versions of an engine side by side: what they are called, and that each runs on its own interpreter and library."""

import base64
import hashlib
import os
import sys
import time
import zipfile
from collections.abc import Iterator
from importlib.metadata import distribution
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from plumbline.harness.conformance import CHECKS, gate
from plumbline.harness.conformance.apart import outcomes_in
from plumbline.harness.conformance.smoke import SMOKE
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.run.fork_servers import Origin, start
from plumbline.harness.run.make_environment import ensure
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.engine_versions import EngineVersion, VersionError, asked, engine_of, named_by, version_wanted
from plumbline.harness.study.environments import Environment, elsewhere, folder_of
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study
from tests.conftest import Command


def test_a_version_is_asked_for_by_two_equals_signs_and_named_by_a_blank() -> None:
    assert version_wanted("mujoco") is None
    version = version_wanted("mujoco==3.3.0")
    assert version == EngineVersion("mujoco", "3.3.0")
    assert version is not None
    assert version.name == "mujoco 3.3.0"
    assert asked(version.name) == "mujoco==3.3.0"
    assert engine_of(version.name) == engine_of("mujoco") == "mujoco"


@pytest.mark.parametrize("text", ["mujoco==", "==3.3.0", "mujoco==../x", "mujoco=no.whl", "mujoco=absent-1.0-py3-none-any.whl"])
def test_what_can_be_no_version_is_refused(text: str) -> None:
    with pytest.raises(VersionError, match="expected ENGINE"):
        version_wanted(text)


def test_two_builds_that_call_themselves_the_same_have_two_names(tmp_path: Path) -> None:
    names = []
    for number in range(2):
        wheel = tmp_path / str(number) / "mujoco-4.0.0-py3-none-any.whl"
        wheel.parent.mkdir()
        wheel.write_bytes(bytes([number]))
        version = version_wanted(f"mujoco={wheel}")
        assert version is not None
        names.append(version.name)
    assert names[0] != names[1]
    assert all(name.startswith("mujoco 4.0.0+") for name in names)


def test_a_pattern_over_engines_names_their_versions_too() -> None:
    assert named_by("mujoco 3.3.0", "mujoco")
    assert named_by("mujoco 3.3.0", "mujoco 3.*")
    assert not named_by("mujoco 3.3.0", "mujoco 4.*")
    assert not named_by("mujoco 3.3.0", "dart")


def test_a_version_has_the_adapter_of_its_engine_under_its_own_name() -> None:
    adapter = plugins.adapter("mujoco 3.3.0")
    assert adapter.name == "mujoco 3.3.0"
    assert adapter.title == "MuJoCo 3.3.0"
    assert adapter.tracks == plugins.adapter("mujoco").tracks


def test_a_version_without_an_environment_is_unavailable_and_says_what_makes_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLUMBLINE_ENVIRONMENTS", str(tmp_path))
    version, reason = plugins.version_of(plugins.adapter("mujoco 3.3.0"))
    assert version == "none"
    assert reason is not None
    assert "--engine mujoco==3.3.0" in reason


def test_the_smoke_checks_are_checks_of_the_kit() -> None:
    assert set(SMOKE) <= {check.name for check in CHECKS}


def _wheel(folder: Path, name: str, content: dict[str, bytes]) -> Path:
    """A wheel of these files. Source: Python Packaging User Guide, 'Binary distribution format' and 'Recording installed'."""
    package, version = name.split("-")[:2]
    about = f"{package}-{version}.dist-info"
    files = {
        **content,
        f"{about}/METADATA": f"Metadata-Version: 2.1\nName: {package}\nVersion: {version}\n".encode(),
        f"{about}/WHEEL": b"Wheel-Version: 1.0\nGenerator: a test\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    path = folder / name
    with zipfile.ZipFile(path, "w") as wheel:
        record = []
        for file, written in files.items():
            digest = base64.urlsafe_b64encode(hashlib.sha256(written).digest()).rstrip(b"=").decode()
            record.append(f"{file},sha256={digest},{len(written)}")
            wheel.writestr(file, written)
        wheel.writestr(f"{about}/RECORD", "\n".join([*record, f"{about}/RECORD,,"]) + "\n")
    return path


@pytest.fixture(scope="module")
def scratch(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder of environments of its own, in which nothing is asked of an index."""
    folder = tmp_path_factory.mktemp("environments")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLUMBLINE_ENVIRONMENTS", str(folder))
        patch.setenv("PIP_NO_INDEX", "1")
        patch.setenv("UV_OFFLINE", "1")
        yield folder


@pytest.fixture(scope="module")
def packed(scratch: Path, tmp_path_factory: pytest.TempPathFactory) -> EngineVersion:
    """The installed MuJoCo as a wheel of its own."""
    files = [
        file for file in distribution("mujoco").files or () if file.parts[0] == "mujoco" and "__pycache__" not in file.parts
    ]
    content = {file.as_posix(): Path(str(file.locate())).read_bytes() for file in files}
    wheel = _wheel(tmp_path_factory.mktemp("wheel"), f"mujoco-{distribution('mujoco').version}-py3-none-any.whl", content)
    version = version_wanted(f"mujoco={wheel}")
    assert version is not None
    return version


@pytest.fixture(scope="module")
def made(packed: EngineVersion) -> Environment:
    return ensure(packed, "mujoco")


def _tell(_pipe: Connection, out: Path) -> None:
    import mujoco

    out.write_text(f"{sys.executable}\n{mujoco.__file__}\n{mujoco.__version__}")


@pytest.mark.slow
def test_processes_of_a_version_run_on_its_interpreter_and_load_its_library(
    packed: EngineVersion, made: Environment, scratch: Path, tmp_path: Path
) -> None:
    assert made.reason == ""
    assert elsewhere(packed.name) == made
    start(Origin(environment=made), _tell, tmp_path / "told").join(60)
    interpreter, library, version = (tmp_path / "told").read_text().splitlines()
    assert interpreter == made.executable
    assert Path(library).is_relative_to(scratch)
    assert version == made.version == distribution("mujoco").version


@pytest.mark.slow
def test_a_version_answers_beside_the_installed_engine_and_as_it_does_where_they_are_the_same(
    packed: EngineVersion, made: Environment, tmp_path: Path
) -> None:
    study = Study(
        name="two", recordings=False, experiments=(Experiment(name="two", tracks=("tuned",), samples=1, sample_seconds=0.001),)
    )
    adapters = {name: plugins.adapter(name) for name in ("mujoco", packed.name)}
    cases = {"flight_box": plugins.case("flight_box")}
    store: Store = carry_out(study, tmp_path / "run", cases, adapters, workers=1, resume=False)
    table = store.trials.set_index("engine")
    assert set(table.index) == {"mujoco", packed.name}
    assert (table["status"] == "passed").all()
    assert table["trajectory_hash"].nunique() == 1
    assert (table["cpu_per_sim_s"] > 0).all()
    assert store.catalogue["engines"][packed.name]["title"] == f"MuJoCo {packed.version}"


@pytest.mark.slow
def test_a_library_that_does_not_carry_the_adapter_is_unavailable_with_the_reason(scratch: Path, tmp_path: Path) -> None:
    wheel = _wheel(tmp_path, "mujoco-0.1-py3-none-any.whl", {"mujoco/__init__.py": b"__version__ = '0.1'\n"})
    version = version_wanted(f"mujoco={wheel}")
    assert version is not None
    environment = ensure(version, "mujoco")
    assert environment.version == "0.1"
    assert "does not carry 0.1" in environment.reason
    assert "AttributeError" in environment.reason
    assert plugins.version_of(plugins.adapter(version.name)) == ("none", environment.reason)


@pytest.mark.slow
def test_a_version_that_is_nowhere_is_unavailable_in_the_words_of_the_installer(scratch: Path) -> None:
    environment = ensure(EngineVersion("mujoco", "0.0.1"), "mujoco")
    assert "mujoco==0.0.1" in environment.reason
    assert environment.executable == ""


@pytest.mark.slow
def test_the_whole_kit_is_put_to_a_version_on_its_own_interpreter(
    packed: EngineVersion, made: Environment, scratch: Path, printed: Command
) -> None:
    outcomes = outcomes_in(made, packed.name, ("tuned",))
    assert [outcome.check for outcome in outcomes] == [check.name for check in CHECKS]
    assert {outcome.engine for outcome in outcomes} == {packed.name}
    assert gate(outcomes)
    done = printed("check", f"mujoco={packed.wheel}", "--track", "tuned")
    assert done.returncode == 0
    assert f"MuJoCo {packed.version}: {len(CHECKS)} checks" in done.stdout


def test_checks_that_end_their_process_have_failed_and_after_three_in_a_row_the_others_are_not_asked(tmp_path: Path) -> None:
    interpreter = tmp_path / "python"
    interpreter.write_text("#!/bin/sh\nkill -SEGV $$\n")
    interpreter.chmod(0o755)
    outcomes = outcomes_in(Environment(str(interpreter)), "mujoco 0.0.1", ("tuned",))
    assert [outcome.check for outcome in outcomes] == [check.name for check in CHECKS]
    assert {outcome.status for outcome in outcomes} == {"failed"}
    assert [outcome.message for outcome in outcomes[:3]] == ["the process of the check was killed by SIGSEGV"] * 3
    assert {outcome.message for outcome in outcomes[3:]} == {"not asked: 3 checks in a row had no outcome"}


def test_environments_of_another_lock_go_after_a_while_and_those_of_this_one_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, printed: Command
) -> None:
    monkeypatch.setenv("PLUMBLINE_ENVIRONMENTS", str(tmp_path))
    ours = folder_of("mujoco 3.3.0")
    old, late = tmp_path / "mujoco-3.3.0-0123456789abcdef", tmp_path / "my-engine-1.0-0123456789abcdef"
    for folder, days in ((ours, 90), (old, 90), (late, 10)):
        folder.mkdir()
        lock = folder.with_name(f"{folder.name}.lock")
        lock.touch()
        asked_for = time.time() - 86400 * days
        os.utime(lock, (asked_for, asked_for))
    done = printed("engines", "--prune", "--dry-run")
    assert done.stdout.splitlines()[0] == f"would go: {old.name}, unasked for 90 days"
    assert old.is_dir()
    assert f"went: {old.name}" in printed("engines", "--prune").stdout
    assert sorted(path for path in tmp_path.iterdir() if path.is_dir()) == sorted([ours, late])
