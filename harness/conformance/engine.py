"""Running a scene on an engine, on one of its tracks: what every check does with it."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from plumbline.harness.adapter import Adapter, Feature, Settings, Simulation
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import State, Trajectory

COARSE = 1 / 240
"""Time step of checks on free motion [s]."""
FINE = 1e-3
"""Time step of checks on contacts and joints [s]: small enough that first-order schemes err by less than the tolerances."""
ROUNDING = 1e-5
"""Relative rounding granted after some hundred steps: engines in single precision (2^-24 = 6e-8 a step) must pass."""


@dataclass(frozen=True, slots=True)
class Engine:
    """An engine with the settings of a track. Args of its calls: dt: of a step [s]; None is that of the track."""

    adapter: Adapter
    settings: Settings

    @property
    def features(self) -> Feature:
        """What the engine claims."""
        return self.adapter.features

    def at(self, dt: float | None) -> Settings:
        """The settings at this step."""
        return self.settings if dt is None else self.settings.with_dt(dt)

    @contextmanager
    def built(self, scene: Scene, dt: float | None = FINE) -> Iterator[Simulation]:
        """The scene in the engine, closed at the end whatever happens."""
        simulation = self.adapter.build(scene, self.at(dt))
        try:
            yield simulation
        finally:
            simulation.close()

    def final(self, scene: Scene, duration: float, dt: float | None = FINE) -> State:
        """The state after `duration` [s], rounded to whole steps, in one call of step."""
        with self.built(scene, dt) as simulation:
            simulation.step(round(duration / self.at(dt).dt))
            return state_of(simulation, scene)

    def record(self, scene: Scene, duration: float, every: int = 1, dt: float | None = FINE) -> Trajectory:
        """The states from 0 to `duration` [s], each `every` steps."""
        step = self.at(dt).dt
        samples = round(duration / step / every)
        time = np.array([k * every * step for k in range(samples + 1)], dtype=np.float64)
        states: list[State] = []
        with self.built(scene, dt) as simulation:
            for k in range(samples + 1):
                if k:
                    simulation.step(every)
                states.append(state_of(simulation, scene))
        p, q, v, w = (np.stack([getattr(s, name) for s in states]) for name in ("p_WB", "q_WB", "v_WB", "w_WB"))
        return Trajectory(time, p, q, v, w, step)


def state_of(simulation: Simulation, scene: Scene) -> State:
    """The present state in fresh arrays, filled with NaN before, so that what is not written is seen."""
    n = len(scene.bodies)
    out = State(np.full((n, 3), np.nan), np.full((n, 4), np.nan), np.full((n, 3), np.nan), np.full((n, 3), np.nan))
    simulation.state(out)
    return out
