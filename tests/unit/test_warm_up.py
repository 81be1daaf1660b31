"""What is compiled ahead: what studies call, with a bar, and before tests every entry of the engine but those of long tests."""

import os
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from plumbline import engine
from plumbline.adapters.reference.kernels import kernels as of_studies
from plumbline.engine.compile.jit import cache_directory
from plumbline.engine.options import BROAD_PHASES, FREE_INTEGRATORS
from plumbline.harness.adapter import Adapter
from plumbline.harness.adapter.kernels import KernelGroup
from plumbline.harness.run.warm_up import following
from plumbline.harness.study import plugins
from tests.conftest import Command
from tests.kernels_called import called, entries
from tests.kernels_on_disk import NAMES, kernels_in, needed_first
from tests.warm_up import kernels

ENGINE = Path(engine.__file__).resolve().parent
LONG = {"steps.islands_jointed.step_islands_jointed_parallel"}
"""Called by tests marked `slow` alone."""


@pytest.mark.compiler
def test_before_tests_each_entry_is_compiled_in_one_group() -> None:
    named = Counter(entry for group in kernels().groups for entry in group.names)
    assert set(named) == entries() - LONG
    assert set(named.values()) == {1}
    assert len(named) > len(BROAD_PHASES) + len(FREE_INTEGRATORS)


@pytest.mark.compiler
def test_what_comes_first_is_what_the_quick_study_calls() -> None:
    first = {name for group in of_studies().groups if group.first for name in group.names}
    assert called("quick") == first


@pytest.mark.compiler
@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_no_study_calls_what_is_not_compiled_ahead() -> None:
    names = {name for group in of_studies().groups for name in group.names}
    studies = [path.stem for path in (ENGINE.parent / "harness" / "study" / "built_in").glob("*.toml")]
    asked = called("--knobs", *studies)
    assert len(asked) > len(names) / 2
    assert not asked - names


def test_a_process_takes_what_comes_first_then_of_its_own_family_then_of_a_fresh_one_and_helps_with_others_last() -> None:
    def group(family: str, first: bool = False) -> KernelGroup:
        return KernelGroup(names=("f",), compile=lambda: None, is_stored=lambda: False, family=family, first=first)

    groups = [group("a"), group("b"), group("b", first=True), group("c"), group("a")]
    every = range(len(groups))
    assert following(every, groups, set(), set()) == 2
    assert following([0, 1, 3, 4], groups, {"b"}, {"b"}) == 1
    assert following([0, 3, 4], groups, {"b"}, {"a", "b"}) == 3
    assert following([0, 4], groups, {"b"}, {"a", "b", "c"}) == 0


def signatures(entry: str) -> int:
    """For how many sets of types of arguments this process has an entry compiled or loaded."""
    module, _, name = entry.rpartition(".")
    return len(getattr(import_module(f"plumbline.engine.{module}"), name).signatures)


@pytest.mark.compiler
@pytest.mark.parametrize(
    ("entry", "options"),
    [
        ("steps.smooth.step_free", {}),
        ("broad.bvh.find_pairs", {"broad_phase": "bvh"}),
        ("broad.bvh.find_pairs_parallel", {"broad_phase": "bvh", "threads": 2}),
        ("broad.volumes.obb.drop_apart", {"broad_phase": "bvh", "bounding_volume": "obb"}),
    ],
)
def test_what_is_compiled_ahead_is_what_a_world_calls(entry: str, options: Mapping[str, Any]) -> None:
    """The same entry for other types would be compiled and kept beside it, and nobody would use the one of the two."""
    (group,) = [group for group in kernels().groups if entry in group.names]
    group.compile()
    balls = [engine.Body(name=str(k), shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(k, 0, 0)) for k in range(3)]
    engine.World(balls if options else [engine.Body()], options=engine.Options(**options)).step()
    assert group.is_stored()
    assert signatures(entry) == 1


@pytest.mark.compiler
def test_a_group_is_stored_if_the_cache_has_an_index_of_each_entry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLUMBLINE_KERNEL_CACHE", str(tmp_path))
    cache_directory.cache_clear()
    try:
        every = of_studies()
        assert every.folder == str(tmp_path)
        assert not any(group.is_stored() for group in every.groups)
        *others, last = max((group.names for group in every.groups), key=len)
        (largest,) = [group for group in every.groups if last in group.names]
        for entry in (*others, last):
            assert not largest.is_stored()
            module, _, name = entry.rpartition(".")
            path = Path(engine.__file__).parent.joinpath(*module.split(".")).with_suffix(".py")
            cache_directory(path).mkdir(parents=True, exist_ok=True)
            (cache_directory(path) / f"{path.stem}.{name}-1.nbc").touch()
        assert [group for group in every.groups if group.is_stored()] == [largest]
    finally:
        cache_directory.cache_clear()


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> dict[str, Adapter]:
    """The engines that the command line finds, to be filled in."""
    engines: dict[str, Adapter] = {}
    monkeypatch.setattr(plugins, "adapters", lambda: engines)
    return engines


def standing_in(name: str, **fields: Any) -> Adapter:
    """An engine of that name, none of whose modules is loaded ahead."""
    return replace(plugins.adapter("reference"), name=name, loads=(), **fields)


def test_engines_that_come_compiled_say_so(printed: Command, installed: dict[str, Adapter]) -> None:
    assert printed("warm").stdout == ""
    installed["mujoco"] = plugins.adapter("mujoco")
    done = printed("warm")
    assert (done.returncode, done.stdout) == (0, "mujoco: nothing to compile\n")


def test_what_is_lacking_is_compiled_and_then_stored(printed: Command, installed: dict[str, Adapter], tmp_path: Path) -> None:
    installed["disk"] = standing_in("disk", kernels=partial(kernels_in, tmp_path))
    (tmp_path / "search").write_text("before")
    done = printed("warm", "--workers", "2")
    assert done.returncode == 0, done.stderr
    note, stored, compiled = done.stdout.splitlines()
    assert note == "disk: slow today"
    assert stored == f"disk: 1 of 3 groups of functions are stored in {tmp_path}"
    assert compiled.startswith("disk: 2 compiled in ")
    assert "disk: compiling: 2 of 2, " in done.stderr
    written = {name: (tmp_path / name).read_text() for name in NAMES}
    assert written["search"] == "before"
    again = printed("warm")
    assert again.returncode == 0
    assert f"disk: 3 of 3 groups of functions are stored in {tmp_path}" in again.stdout
    assert again.stderr == ""
    assert written == {name: (tmp_path / name).read_text() for name in NAMES}


def test_only_what_comes_first_is_compiled_if_that_is_asked_for(
    printed: Command, installed: dict[str, Adapter], tmp_path: Path
) -> None:
    installed["disk"] = standing_in("disk", kernels=partial(needed_first, tmp_path))
    assert "disk: 0 of 1 groups" in printed("warm", "--first").stdout
    assert [path.name for path in tmp_path.iterdir()] == ["rays"]


def test_a_function_that_fails_or_takes_its_process_down_costs_no_other(
    printed: Command, installed: dict[str, Adapter], tmp_path: Path
) -> None:
    names = ("broken", "deadly", *NAMES)
    installed["disk"] = standing_in("disk", kernels=partial(kernels_in, tmp_path, names))
    installed["lost"] = standing_in("lost", kernels=partial(kernels_in, "no folder"))
    done = printed("warm", "--workers", "1")
    assert done.returncode == 3
    assert "disk: 3 compiled in " in done.stdout
    lines = done.stderr.splitlines()
    assert "disk: broken: RuntimeError: broken has no types" in lines
    assert "disk: deadly: the process died: SIGKILL" in lines
    assert any(line.startswith("lost: TypeError: ") for line in lines)
    assert lines[-1] == "3 could not be compiled; trials will try again"
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(NAMES)


class Terminal(StringIO):
    """A stream that says it is one."""

    def isatty(self) -> bool:
        return True


def test_on_a_terminal_there_is_a_bar(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from plumbline.harness.run.warm_up import warm_up

    monkeypatch.setattr(sys, "stderr", Terminal())
    assert warm_up("disk: compiling", partial(kernels_in, tmp_path), range(3), (), 1) == []
    shown = sys.stderr.getvalue()  # type: ignore[attr-defined]
    assert "disk: compiling" in shown
    assert "3 of 3" in shown


def test_a_cache_that_cannot_be_is_named(printed: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("PLUMBLINE_KERNEL_CACHE", str(tmp_path / "file"))
    done = printed("warm")
    assert done.returncode == 0
    assert "reference: unavailable: PLUMBLINE_KERNEL_CACHE: " in done.stdout


BESIDE = """
import os
import subprocess
import sys
from importlib.metadata import packages_distributions

installed = set(sys.argv[1:])
absent = {
    package
    for package, distributions in packages_distributions().items()
    if not installed.intersection(name.lower().replace("_", "-") for name in distributions)
}


class Absent:
    def find_spec(self, name, path=None, target=None):
        if name in absent - {"plumbline", "adapters", "cases", "engine", "harness", "reports", "findings"}:
            raise ImportError(f"{name} is not there yet")


sys.meta_path.insert(0, Absent())
from plumbline.harness.cli.main import main
main(["warm", "--first", "--help"], standalone_mode=False)
import plumbline.harness.run.warm_up
from plumbline.harness.run.waiting_time import Progress
from rich.progress import Progress as Bar
from plumbline.adapters.reference import ADAPTER
(group,) = [group for group in ADAPTER.kernels().groups if group.names == ("steps.smooth.step_free",)]
assert not group.is_stored()
group.compile()
print(group.is_stored(), len(absent))
"""


@pytest.mark.compiler
def test_what_make_compare_installs_first_is_enough_to_compile(tmp_path: Path) -> None:
    text = (ENGINE.parent / "Makefile").read_text().replace("\\\n", " ")
    (names,) = [line.partition(":=")[2].split() for line in text.splitlines() if line.startswith("COMPILING :=")]
    lock = (ENGINE.parent / "requirements.lock").read_text()
    assert all(f"\n{name}==" in f"\n{lock}" for name in names)
    environment = os.environ | {"PLUMBLINE_KERNEL_CACHE": str(tmp_path)}
    command = [sys.executable, "-c", BESIDE, *names]
    done = subprocess.run(command, cwd=ENGINE.parent, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    stored, absent = done.stdout.splitlines()[-1].split()
    assert stored == "True"
    assert int(absent) > 50
