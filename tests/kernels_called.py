"""Which compiled functions of the reference engine the trials of studies call: `python -m tests.kernels_called STUDY...`.

With `--knobs` also those that a search calls, which turns each knob of both tracks to each of its values.
"""

import ast
import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path

from plumbline.harness.adapter import Adapter, Settings, SettingsError, Unsupported
from plumbline.harness.scene import Scene
from plumbline.harness.study import plugins
from plumbline.harness.study.study import load_study

__all__ = ["called", "entries"]

ROOT = Path(__file__).parents[1]
LARGE = 1500
"""Bodies from which on a scene is left out: smaller ones of the same case call the same functions."""


def entries() -> set[str]:
    """The functions of the engine that Python calls compiled, as `module.function`."""
    listed = set()
    for path in (ROOT / "engine").rglob("*.py"):
        module = ".".join(path.relative_to(ROOT / "engine").with_suffix("").parts)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef):
                decorators = {one.id for one in node.decorator_list if isinstance(one, ast.Name)}
                if decorators & {"entry", "parallel_entry"}:
                    listed.add(f"{module}.{node.name}")
    return listed


def called(*arguments: str) -> set[str]:
    """What a process of its own finds. Args: arguments: of this module."""
    command = [sys.executable, "-m", "tests.kernels_called", *arguments]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout))


def _scenes(adapter: Adapter, studies: list[str], knobs: bool) -> Iterator[tuple[Scene, Settings]]:
    cases = plugins.cases()
    for name in studies:
        for trial in load_study(name).trials(cases, {adapter.name: adapter}, {adapter.name: adapter.version()}):
            yield trial.scene(cases[trial.case]), trial.settings
    for case in cases.values() if knobs else ():
        scene = case.scene(case.parameters)
        for track in adapter.tracks.values():
            for knob in ("solver", "integrator", "options.continuous", "options.coordinates"):
                for value in adapter.knobs[knob]:
                    option = knob.removeprefix("options.")
                    turned = {knob: value} if option == knob else {"options": {**track.options, option: value}}
                    yield scene, replace(track.with_dt(case.dt), **turned)


def _call_all(studies: list[str], knobs: bool) -> None:
    adapter, done = plugins.adapter("reference"), set[tuple[str, str]]()
    for scene, settings in _scenes(adapter, studies, knobs):
        if len(scene.bodies) > LARGE:
            continue
        key = repr(scene), repr(replace(settings, dt=1.0, substeps=None, iterations=None))
        if key in done:
            continue
        done.add(key)
        try:
            adapter.compile(scene, settings)
            simulation = adapter.build(scene, settings)
            simulation.step(2)
            simulation.contacts()
        except (Unsupported, SettingsError):
            continue


def _has_run(entry: str) -> bool:
    module, _, name = entry.rpartition(".")
    return f"plumbline.engine.{module}" in sys.modules and bool(
        getattr(import_module(f"plumbline.engine.{module}"), name).signatures
    )


if __name__ == "__main__":
    _call_all([name for name in sys.argv[1:] if name != "--knobs"], "--knobs" in sys.argv)
    print(json.dumps(sorted(filter(_has_run, entries()))))
