"""Running a scene on an adapter: built, stepped, recorded and closed again."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from plumbline.harness.adapter import Adapter, Settings, Simulation
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import State, Trajectory

COARSE = 1 / 240
"""Time step of checks on free motion [s]."""
FINE = 1e-3
"""Time step of checks on contacts and joints [s]: small enough that first-order schemes err by less than the tolerances."""
ROUNDING = 1e-5
"""Relative rounding granted after some hundred steps: engines in single precision (2^-24 = 6e-8 a step) must pass."""


@contextmanager
def built(adapter: Adapter, scene: Scene, settings: Settings) -> Iterator[Simulation]:
    """The scene in the engine, closed at the end whatever happens."""
    simulation = adapter.build(scene, settings)
    try:
        yield simulation
    finally:
        simulation.close()


def state_of(simulation: Simulation, scene: Scene) -> State:
    """The present state in fresh arrays, filled with NaN before, so that what is not written is seen."""
    n = len(scene.bodies)
    out = State(np.full((n, 3), np.nan), np.full((n, 4), np.nan), np.full((n, 3), np.nan), np.full((n, 3), np.nan))
    simulation.state(out)
    return out


def final(adapter: Adapter, scene: Scene, settings: Settings, duration: float) -> State:
    """The state after `duration` [s], rounded to whole steps, in one call of step."""
    with built(adapter, scene, settings) as simulation:
        simulation.step(round(duration / settings.dt))
        return state_of(simulation, scene)


def record(adapter: Adapter, scene: Scene, settings: Settings, duration: float, every: int = 1) -> Trajectory:
    """The states from 0 to `duration` [s], each `every` steps."""
    samples = round(duration / settings.dt / every)
    time = np.array([k * every * settings.dt for k in range(samples + 1)], dtype=np.float64)
    states: list[State] = []
    with built(adapter, scene, settings) as simulation:
        for k in range(samples + 1):
            if k:
                simulation.step(every)
            states.append(state_of(simulation, scene))
    return Trajectory(
        time,
        np.stack([s.p_WB for s in states]),
        np.stack([s.q_WB for s in states]),
        np.stack([s.v_WB for s in states]),
        np.stack([s.w_WB for s in states]),
        settings.dt,
    )
