"""A drill: two nights of one engine, the second with two faults in it, to see whether this machine's gate names both."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from time import thread_time
from typing import Any

from plumbline.harness.adapter import Adapter, Settings, Simulation
from plumbline.harness.history.folder import opened
from plumbline.harness.scene import Scene

TIME, FRICTION = 1.2, 1.05
"""Of the planted faults: times the CPU time of a step, times the friction of every surface."""
ENGINE = "drill"
"""What the wrapped engine is called."""
PLANTED: Mapping[str, Callable[[Mapping[str, Any]], bool]] = {
    f"{TIME:g} times the CPU time": lambda row: row["kind"] == "price",
    f"{FRICTION:g} times the friction": lambda row: row["kind"] in ("error", "verdict") and row["case"] == "friction_stop",
}
"""What is planted, each with which rows of `told` name it."""
STUDY = """name = "drill"
recordings = false
[[experiments]]
name = "look"
cases = ["flight_projectile", "friction_stop"]
dt = [0.016666666666666666, 0.008333333333333333, 0.004166666666666667]
samples = 9
sample_seconds = 0.03
"""
"""Twelve prices: an engine as a whole is told from eight on, in a machine's noise."""
_MODULE = """from plumbline.harness.history.drill import planted
from plumbline.harness.study import plugins

PLANTED = planted(plugins.adapter({engine!r}), time={time!r}, friction={friction!r})
"""
_FOR_PACKAGES = f"[plumbline.adapters]\n{ENGINE} = drill_engine:PLANTED\n"


@dataclass(frozen=True, kw_only=True)
class _Planted(Adapter):
    """An engine with two faults."""

    inner: Adapter
    time: float
    friction: float

    def version(self) -> str:
        return self.inner.version()

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """The engine, told of rougher surfaces."""
        rougher = tuple(
            replace(
                surface,
                static_friction=self.friction * surface.static_friction,
                kinetic_friction=self.friction * surface.kinetic_friction,
            )
            for surface in scene.surfaces
        )
        slower: Any = _Slower(self.inner.build(replace(scene, surfaces=rougher), settings), self.time)
        simulation: Simulation = slower
        return simulation


class _Slower:
    """A simulation whose steps take so many times as long; all else is as it is inside."""

    def __init__(self, inner: Simulation, times: float) -> None:
        self._inner, self._times = inner, times

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)

    def step(self, count: int = 1) -> None:
        """Advance, and then wait by work that does nothing."""
        began = thread_time()
        self._inner.step(count)
        until = began + self._times * (thread_time() - began)
        while thread_time() < until:
            pass


def planted(inner: Adapter, *, time: float, friction: float) -> Adapter:
    """The engine with these faults; 1 for none. It has no versions of its own, and its price is of all that it does."""
    return _Planted(
        name=ENGINE,
        title=f"{inner.title} in a drill",
        distribution=inner.distribution,
        features=inner.features,
        tracks=inner.tracks,
        inner=inner,
        time=time,
        friction=friction,
    )


def nights(folder: Path, engine: str) -> Iterator[tuple[subprocess.CompletedProcess[str], dict[str, str]]]:
    """Carry out both nights in a folder that is empty. Args: engine: which one is wrapped.

    Yields: the process of each, and by what is planted the sentence that names it, '' for none. Raises: OSError.
    """
    study, packages, root = folder / "drill.toml", folder / "packages", folder / "history"
    study.write_text(STUDY)
    about = packages / "plumbline_drill-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: plumbline-drill\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(_FOR_PACKAGES)
    paths = [str(packages), *filter(None, (os.environ.get("PYTHONPATH"),))]
    words = ["nightly", "--history", root, "--study", study, "--engine", ENGINE, "--gate", ENGINE, "--no-report"]
    for time, friction in ((1.0, 1.0), (TIME, FRICTION)):
        (packages / "drill_engine.py").write_text(_MODULE.format(engine=engine, time=time, friction=friction))
        ended = subprocess.run(
            [sys.executable, "-B", "-m", "plumbline", *map(str, words)],
            env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
            capture_output=True,
            text=True,
            check=False,
        )
        done = opened(root).nights()[-1:] if (root / "history.json").is_file() else ()
        worse = [row for night in done for row in night.plan.get("told", ()) if row["regression"]]
        yield ended, {what: next((str(row["sentence"]) for row in worse if is_of(row)), "") for what, is_of in PLANTED.items()}
