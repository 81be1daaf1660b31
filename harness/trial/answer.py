"""What an engine makes of a problem: built and stepped in this process. Nothing is measured here, and nothing judged.

All that moves a run is imported from here: an answer is named by these texts, and by none that judge it.

What ideal sensors have to read on a motion that was recorded: where no truth is known of the motion, one is known of those.

A gyroscope reads its body's angular velocity in its own frame; a beam is as long as the way to the first shape that it meets,
in closed form. Both are told at the readings' instants that were recorded too, the start left out.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import psutil

from plumbline.harness.adapter import Adapter, Diverged, Feature, Notice, Settings, Simulation, Unsupported
from plumbline.harness.adapter.many_worlds import WorldOf, spread
from plumbline.harness.adapter.notice import as_notices
from plumbline.harness.adapter.what_comes_out import Answering
from plumbline.harness.case.commands import acting
from plumbline.harness.case.forces import Controlled
from plumbline.harness.case.problem import Problem, Rays
from plumbline.harness.case.symmetries import Retelling
from plumbline.harness.scene import Imu, Lidar, Scene, Sensor
from plumbline.harness.sensors.lidar import ideal, in_world
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.sensors.reader import row_of
from plumbline.harness.store.record import StoredNotice
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import Floats, State, Trajectory
from plumbline.harness.trajectory.kinematics import rotate_back
from plumbline.harness.trajectory.pace import Pace
from plumbline.harness.trial.equivalent_runs import check_paced, equivalent_run, equivalent_streams, paced
from plumbline.harness.trial.simulate import simulate

SAME = 1e-9
"""Seconds between a reading and a sample of one instant."""


def readings_due(scene: Scene, actual: Trajectory) -> dict[str, Floats]:
    """Streams '<sensor>/gyroscope_due' (k, 3) rad/s and '<sensor>/range_due' (k, channels, columns) m, as many as there are
    readings, NaN where a reading has no state beside it; none of a sensor with a latency, that spins, or meets shapes without
    a closed form."""
    due: dict[str, Floats] = {}
    for sensor in scene.sensors:
        try:
            if isinstance(sensor, Imu) and sensor.latency == 0:
                due |= _stream(scene, sensor, actual, "gyroscope", _turning)
            elif isinstance(sensor, Lidar) and not sensor.spinning:
                due |= _stream(scene, sensor, actual, "range", _ranges)
        except TypeError:  # of `first_hits`: a shape without a closed form
            continue
    return due


def _stream(
    scene: Scene, sensor: Any, actual: Trajectory, channel: str, law: Callable[[Scene, Any, State], Floats]
) -> dict[str, Floats]:
    read = actual.streams.get(f"{sensor.name}/{channel}_ideal")
    if read is None:
        return {}
    due = np.full(read.shape, np.nan)
    for k, state in _instants(sensor, actual):
        due[k] = law(scene, sensor, state)
    return {f"{sensor.name}/{channel}_due": due}


def _instants(sensor: Sensor, actual: Trajectory) -> Iterator[tuple[int, State]]:
    """The places of readings that have a state, with it."""
    stamps = actual.streams.get(f"{sensor.name}/time", np.zeros(0))
    for k, sample in enumerate(np.searchsorted(actual.time, stamps - SAME)):
        if stamps[k] > 0 and sample < len(actual) and abs(actual.time[sample] - stamps[k]) <= SAME:
            yield k, actual.state(int(sample))


def _turning(scene: Scene, sensor: Imu, state: State) -> Floats:
    row = row_of(scene, sensor.body, state)
    return rotate_back(np.array(sensor.q_BS), rotate_back(row[3:7], row[10:13]))


def _ranges(scene: Scene, sensor: Lidar, state: State) -> Floats:
    row = row_of(scene, sensor.body, state)
    origins, directions = in_world(sensor, row[:3], row[3:7])
    return ideal(sensor, scene, directions, first_hits(scene, state, origins, directions, sensor.max_range))[0]


def cast_once(simulation: Simulation, rays: Rays) -> dict[str, Floats]:
    """Streams 'rays/range_ideal' and 'rays/body' of the rays of a case, cast at the start."""
    hits = simulation.cast(rays.origins, rays.directions, rays.max_range)
    bodies = hits.body[None].astype(np.float64)
    return {"rays/time": np.zeros(1), "rays/range_ideal": hits.distance[None], "rays/body": bodies}


@dataclass(frozen=True, slots=True)
class RunAnswer:
    """What an engine made of a scene.

    Terms: broke: when and how it diverged, None where it did not. pace: of its steps. cpu [s]: that they took, once and from
    cold; 0 where nobody asks. memory [B]: by how much the process grew while worlds were built and stepped; None of others.
    """

    actual: Trajectory
    broke: str | None
    resolved: Mapping[str, Any]
    warnings: tuple[StoredNotice, ...]
    pace: Pace
    cpu: float = 0.0
    memory: float | None = None

    @property
    def steps(self) -> int:
        """Whole steps taken."""
        return self.pace.steps(float(self.actual.time[-1])) if len(self.actual) else 0

    @property
    def sim_seconds(self) -> float:
        """The time that these steps take [s]."""
        return self.pace.time(self.steps)

    def substep(self, asked: Settings) -> float:
        """The longest step taken [s]: as reported, else as requested."""
        return self.pace.longest / (self.resolved.get("substeps") or asked.substeps or 1)


class StepTime:
    """A simulation with the CPU time of all its steps so far; all else is the simulation's own.

    A whole run is clocked so, once and from cold: roughly, and for nothing.
    """

    def __init__(self, simulation: Any) -> None:
        self._simulation = simulation
        self.cpu = 0.0

    def step(self, count: int = 1) -> None:
        """Advance the simulation. Raises: Diverged."""
        begun = time.process_time()
        try:
            self._simulation.step(count)
        finally:
            self.cpu += time.process_time() - begun

    def __getattr__(self, name: str) -> Any:
        return getattr(self._simulation, name)


def answer_of(trial: Trial, problem: Problem, adapter: Adapter) -> RunAnswer:
    """Build and step: what the engine of a trial makes of a problem that belongs to the trial's case.

    Raises: Unsupported, Unavailable, SettingsError.
    """
    check_paced(adapter, trial.settings)
    pace = Pace.of(trial.settings.pace, trial.settings.dt)
    if trial.alteration.every_step:
        problem = replace(problem, sample_interval=0.0)
    retelling = trial.alteration.retelling(problem.scene, problem.duration)
    try:
        if retelling is not None:
            return _equivalent(trial, retelling, adapter, problem, pace)
        return _stepped(trial, problem, adapter, pace)
    except Diverged as error:
        return RunAnswer(Trajectory.of(np.zeros(0), len(problem.scene.bodies)), str(error), {}, (), pace)


def _stepped(trial: Trial, problem: Problem, adapter: Adapter, pace: Pace) -> RunAnswer:
    """Raises: Diverged, outside its steps; otherwise as `answer_of`."""
    scene, batch = problem.scene, None
    step_time: StepTime | None = None

    def clocked(stepped: Simulation) -> Simulation:
        nonlocal step_time
        if not trial.experiment.dominance:
            return stepped
        step_time = StepTime(stepped)
        return cast(Simulation, step_time)

    simulation: Simulation
    occupied, memory = _resident() if problem.worlds else 0.0, None
    if problem.worlds > 1:
        if not pace.even:
            raise Unsupported("many worlds under uneven steps", "a batch of worlds takes even steps")
        batch = adapter.build_batch(scene, trial.settings, problem.worlds)
        simulation = cast(Simulation, Answering(clocked(cast(Simulation, WorldOf(batch, problem.worlds - 1))), scene))
    else:
        simulation = paced(cast(Simulation, Answering(clocked(adapter.build(scene, trial.settings)), scene)), pace)
        control = acting(scene, problem.control)
        if control is not None:
            simulation = cast(Simulation, Controlled(simulation, control, pace, len(scene.bodies)))
    try:
        readable = Feature.CONTACTS | Feature.CONTACT_FORCES in adapter.features and batch is None
        seen = {} if problem.rays is None else cast_once(simulation, problem.rays)
        actual, broke = simulate(
            simulation,
            scene,
            pace=pace,
            duration=problem.duration,
            sample_interval=problem.sample_interval,
            with_contacts=problem.contacts and readable,
            seed=trial.seed,
            with_impulses=problem.impulses and readable,
            pushed=problem.control is not None,
        )
        if scene.sensors and problem.readings_due:
            seen |= readings_due(scene, actual)
        memory = _resident() - occupied if problem.worlds else None
        if problem.worlds and broke is None:
            apart = 0.0 if batch is None else spread(batch, len(scene.bodies))
            seen |= {"worlds/time": actual.time[-1:], "worlds/spread": np.array([apart])}
        resolved, warnings = simulation.resolved.plain(), _stored(simulation.warnings())
        if not pace.even:
            resolved |= {"pace": trial.settings.pace, "longest_step": pace.longest}
    finally:
        simulation.close()
    if problem.retellings is not None and broke is None and not trial.alteration.every_step:
        for retelling in problem.retellings:
            other = replace(retelling, scene=trial.alteration.of(retelling.scene))
            streams, remarks = equivalent_streams(other, adapter, trial.settings, problem.duration, problem.sample_interval)
            seen, warnings = seen | streams, (*warnings, *map(StoredNotice, remarks))
    cpu = 0.0 if step_time is None else step_time.cpu
    return RunAnswer(replace(actual, streams={**actual.streams, **seen}), broke, resolved, warnings, pace, cpu, memory)


def _resident() -> float:
    """Memory [B] that this process holds of its own, what it shares with its fork server left out."""
    info = psutil.Process().memory_info()
    return float(info.rss - getattr(info, "shared", 0))


def _stored(warnings: tuple[str | Notice, ...]) -> tuple[StoredNotice, ...]:
    """What an engine or its adapter said, as records keep it."""
    return tuple(
        StoredNotice(notice.text, notice.kind, "" if notice.effect is None else ", ".join(notice.effect.names))
        for notice in as_notices(warnings)
    )


def _equivalent(trial: Trial, retelling: Retelling, adapter: Adapter, problem: Problem, pace: Pace) -> RunAnswer:
    actual, broke = equivalent_run(retelling, adapter, trial.settings, problem.duration, problem.sample_interval)
    return RunAnswer(actual, broke, {}, (), pace)
