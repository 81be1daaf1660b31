"""What is compiled before the tests: every entry of the engine but those that long tests alone use, each once."""

import ast
from collections import Counter
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import engine
from engine.options import BROAD_PHASES, FREE_INTEGRATORS
from tests import warm_up
from tests.warm_up import FAMILIES, FAMILY, JOBS, following, is_kept

ENGINE = Path(engine.__file__).parent
LONG = {"steps.islands_jointed.step_islands_jointed_parallel"}
"""Used by tests marked `slow` alone."""


def entries() -> set[str]:
    """The functions of the engine that Python calls compiled, as `module.function`."""
    listed = set()
    for path in ENGINE.rglob("*.py"):
        module = ".".join(path.relative_to(ENGINE).with_suffix("").parts)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef):
                decorators = {one.id for one in node.decorator_list if isinstance(one, ast.Name)}
                if decorators & {"entry", "parallel_entry"}:
                    listed.add(f"{module}.{node.name}")
    return listed


def test_each_entry_is_compiled_by_one_job() -> None:
    named = Counter(entry for job in JOBS for entry in job.entries)
    assert set(named) == entries() - LONG
    assert set(named.values()) == {1}
    assert len(named) > len(BROAD_PHASES) + len(FREE_INTEGRATORS)


def test_a_process_goes_on_with_the_family_that_it_has_begun_then_with_a_fresh_one_and_helps_with_others_last() -> None:
    every = [*range(len(JOBS))]
    first, second, third = (FAMILY.index(family) for family in range(3))
    assert following(every, [set(), set()], 0) == first
    assert following(every[1:], [{0}, set()], 1) == second
    assert following(every[1:], [{0}, {1}], 0) == first + 1
    assert following(every[second + 1 :], [{0}, {1}], 0) == third
    assert following(every[1:second], [{0}, {1}], 1) == first + 1
    assert [len(jobs) for jobs in FAMILIES] == [FAMILY.count(family) for family in range(len(FAMILIES))]


def signatures(entry: str) -> int:
    """For how many sets of types of arguments this process has an entry compiled or loaded."""
    module, _, name = entry.rpartition(".")
    return len(getattr(import_module(f"engine.{module}"), name).signatures)


@pytest.mark.compiler
@pytest.mark.parametrize(
    ("entry", "options"),
    [
        ("steps.smooth.step_free", {}),
        ("broad.bvh.find_pairs", {"broad_phase": "bvh"}),
        ("broad.parallel.bvh.find_candidates", {"broad_phase": "bvh", "threads": 2}),
        ("broad.parallel.pairs.write_pairs", {"broad_phase": "bvh", "threads": 2}),
        ("broad.volumes.obb.drop_apart", {"broad_phase": "bvh", "bounding_volume": "obb"}),
    ],
)
def test_what_is_compiled_ahead_is_what_a_world_calls(entry: str, options: Mapping[str, Any]) -> None:
    """The same entry for other types would be compiled and kept beside it, and nobody would use the one of the two."""
    (job,) = [job for job in JOBS if entry in job.entries]
    job.compile()
    balls = [engine.Body(name=str(k), shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(k, 0, 0)) for k in range(3)]
    engine.World(balls if options else [engine.Body()], options=engine.Options(**options)).step()
    assert is_kept(entry)
    assert signatures(entry) == 1


@pytest.mark.compiler
def test_where_all_is_kept_nothing_is_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An empty cache lacks every job, and one with the index of each entry none."""
    monkeypatch.setattr(warm_up, "cache_directory", lambda path: tmp_path / path.relative_to(ENGINE).with_suffix(""))
    assert [*warm_up.lacking()] == [*range(len(JOBS))]
    for entry in (entry for job in JOBS[1:] for entry in job.entries):
        module, _, name = entry.rpartition(".")
        folder = tmp_path.joinpath(*module.split("."))
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{folder.name}.{name}-1.py311.nbi").touch()
    assert [*warm_up.lacking()] == [0]
