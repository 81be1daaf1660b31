"""A retelling carried out: the same engine, settings and number of steps, its motion told back as streams beside the case's."""

from dataclasses import replace
from typing import Any, cast

import numpy as np

from plumbline.harness.adapter import Adapter, Diverged, Feature, Settings, Simulation, Unsupported
from plumbline.harness.adapter.what_comes_out import Answering
from plumbline.harness.case.commands import acting
from plumbline.harness.case.forces import Controlled
from plumbline.harness.case.symmetries import Retelling
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.pace import Pace
from plumbline.harness.trial.simulate import simulate, steps_between_samples


def check_paced(adapter: Adapter, settings: Settings) -> None:
    """Raises: Unsupported, where the settings ask for uneven steps and the engine takes none."""
    if settings.pace and Feature.STEP_LENGTHS not in adapter.features:
        raise Unsupported(f"steps at the pace '{settings.pace}'", "the engine's steps are all as long as it was built with")


def paced(simulation: Simulation, pace: Pace) -> Simulation:
    """The simulation at that pace; the very same one where steps are even."""
    return simulation if pace.even else cast(Simulation, Paced(simulation, pace))


class Paced:
    """A simulation at an uneven pace: stepped, read and closed like any other."""

    def __init__(self, simulation: Simulation, pace: Pace) -> None:
        self._simulation: Any = simulation
        self._pace, self._here = pace, 0

    def step(self, count: int = 1) -> None:
        """Take the next `count` steps, each as long as the sequence says. Raises: Diverged, Unsupported."""
        for _ in range(count):
            self._simulation.retime(self._pace.length(self._here))
            self._simulation.step(1)
            self._here += 1

    def save(self) -> object:
        """The simulation's own, with the step that it stands at. Raises: Unsupported."""
        return self._here, self._simulation.save()

    def restore(self, saved: object) -> None:
        """Back to a saved state and its step. Raises: Unsupported."""
        assert isinstance(saved, tuple)
        self._here, inner = saved
        self._simulation.restore(inner)

    def __getattr__(self, name: str) -> Any:
        """All else is the simulation's own."""
        return getattr(self._simulation, name)


def equivalent_streams(
    retelling: Retelling, adapter: Adapter, settings: Settings, duration: float, sample_interval: float
) -> tuple[dict[str, Floats], tuple[str, ...]]:
    """Streams '<name>/time', '/p_WB' (k, n, 3), '/q_WB' (k, n, 4), '/v_WB' and '/w_WB' (k, n, 3); and what there is to say.

    A run that diverges ends in a state that is not finite; one that the engine cannot make has no streams.

    Args: duration, sample_interval [s] of the case.
    """
    try:
        run, broke = equivalent_run(retelling, adapter, settings, duration, sample_interval)
    except Unsupported as error:
        return {}, (f"{retelling.name}: not told: {error}",)
    except Diverged as error:
        return {}, (f"{retelling.name}: diverged before it could be told: {error}",)
    states = {name: getattr(run, name) for name in ("p_WB", "q_WB", "v_WB", "w_WB")}
    time = run.time
    if broke is not None:
        time = np.append(time, time[-1:] + max(sample_interval, settings.dt))
        states = {name: np.concatenate([array, np.full((1, *array.shape[1:]), np.nan)]) for name, array in states.items()}
    streams = {f"{retelling.name}/{name}": array for name, array in (("time", time), *states.items())}
    return streams, () if broke is None else (f"{retelling.name}: diverged {broke}",)


def equivalent_run(
    retelling: Retelling, adapter: Adapter, settings: Settings, duration: float, sample_interval: float
) -> tuple[Trajectory, str | None]:
    """The motion of a retelling in the words of the first telling and, where it diverged, when and how.

    Raises: Unsupported; Diverged: before there is anything to tell.
    """
    dt, clock = settings.dt, retelling.clock
    pace = Pace.of(settings.pace, dt * clock)
    built = adapter.build(retelling.scene, settings.with_dt(dt * clock))
    simulation = paced(cast(Simulation, Answering(built, retelling.scene)), pace)
    control = acting(retelling.scene, retelling.control)
    if control is not None:
        simulation = cast(Simulation, Controlled(simulation, control, pace, len(retelling.scene.bodies)))
    try:
        before = (
            0
            if retelling.restored_at is None
            else _taken_back(simulation, retelling.restored_at, duration, sample_interval, dt)
        )
        run, broke = simulate(
            simulation,
            retelling.scene,
            pace=pace.since(before),
            duration=(duration - before * dt) * clock,
            sample_interval=sample_interval * clock,
            with_contacts=False,
            seed=0,
        )
    finally:
        simulation.close()
    made = retelling.back(run)
    return replace(made, time=made.time + Pace.of(settings.pace, dt).time(before), even=pace.even), broke


def _taken_back(simulation: Simulation, time: float, duration: float, sample_interval: float, dt: float) -> int:
    """Save at a sample near `time` [s], go to the end and back; the steps before that sample. Raises: Diverged, Unsupported."""
    every = steps_between_samples(sample_interval, dt)
    before = every * max(1, round(time / (every * dt)))
    simulation.step(before)
    saved = simulation.save()
    simulation.step(max(1, round(duration / dt) - before))
    simulation.restore(saved)
    return before
