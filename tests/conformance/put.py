"""A case put to an engine in this process: what the engine said, and what the case's own metrics say of it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, cast

from plumbline.harness.adapter import Adapter, Feature, Settings, Simulation
from plumbline.harness.case import Case
from plumbline.harness.case.forces import Controlled
from plumbline.harness.scene import Scene
from plumbline.harness.store.record import Measurement
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trajectory.pace import Pace
from plumbline.harness.trial.accuracy import judge
from plumbline.harness.trial.simulate import simulate
from plumbline.harness.trial.truth_cache import bounded, truth_of

__all__ = ["Answer", "put"]


@dataclass(frozen=True, slots=True)
class Answer:
    """The scene, the engine's trajectory, its measurements, and why it broke off, if it did."""

    scene: Scene
    actual: Trajectory
    measurements: tuple[Measurement, ...]
    broke: str | None

    @property
    def broken(self) -> dict[str, Measurement]:
        """The checks that fail."""
        return {m.metric: m for m in self.measurements if m.passed is False}

    def __getitem__(self, metric: str) -> float:
        """The value of a metric; of one that is checked twice the first."""
        return next(m.value for m in self.measurements if m.metric == metric)


def _same(trajectory: Trajectory) -> Trajectory:
    return trajectory


def _as_it_is(scene: Scene) -> Scene:
    return scene


def put(
    case: Case,
    adapter: Adapter,
    settings: Settings,
    spoil: Callable[[Trajectory], Trajectory] = _same,
    parameters: Mapping[str, Any] | None = None,
    sensors: Callable[[Scene], Scene] = _as_it_is,
) -> Answer:
    """Run a case on an engine; `spoil` changes what was recorded, `sensors` what readers are told."""
    chosen = dict(case.parameters) | ({"seed": 0} if case.ensemble > 1 else {}) | dict(parameters or {})
    case = case.put(chosen)
    scene = case.scene(case.parameters)
    simulation = adapter.build(scene, settings)
    if case.control is not None:
        simulation = cast(Simulation, Controlled(simulation, case.control(case.parameters), settings.dt, len(scene.bodies)))
    with_contacts = case.with_contacts and Feature.CONTACTS in adapter.features
    try:
        actual, broke = simulate(
            simulation,
            sensors(scene),
            pace=Pace(settings.dt),
            duration=case.duration,
            sample_interval=case.sample_interval,
            with_contacts=with_contacts,
            seed=0,
            with_impulses=with_contacts and any(metric.impulses for metric in case.metrics),
            pushed=case.control is not None,
        )
        substep = simulation.resolved.substep
    finally:
        simulation.close()
    if broke is not None:
        return Answer(scene, actual, (), broke)
    actual = spoil(actual)
    at, truth = bounded(case, settings.dt, substep, chosen, None), truth_of(case, scene, actual.time, chosen, None)
    return Answer(scene, actual, judge(at, scene, actual, truth), None)
