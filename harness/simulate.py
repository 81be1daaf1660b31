"""A simulation stepped to its end: its states at the samples, its contacts and what its sensors said."""

import numpy as np

from harness.adapter import Diverged, Simulation
from harness.scene import Scene
from harness.sensors.recorder import SensorRecorder
from harness.trajectory import Contacts, Floats, State, Trajectory

__all__ = ["simulate", "steps_between_samples"]


def steps_between_samples(interval: float, dt: float) -> int:
    """Whole steps of dt [s] between two samples `interval` [s] apart, at least one."""
    return max(1, round(interval / dt))


class _Log:
    """Room for a trajectory, filled sample by sample."""

    def __init__(self, steps: int, every: int, dt: float, bodies: int, with_contacts: bool) -> None:
        places = [*range(0, steps, every), steps]
        self.trajectory = Trajectory.of(np.array(places, dtype=np.float64) * dt, bodies)
        self.contacts: list[Contacts] | None = [] if with_contacts else None
        self.filled = 0

    def take(self, simulation: Simulation) -> State:
        """Read the next sample; raises Diverged where it is not finite."""
        state = self.trajectory.state(self.filled)
        simulation.state(state)
        if not state.finite:
            raise Diverged("the state is not finite")
        if self.contacts is not None:
            self.contacts.append(simulation.contacts())
        self.filled += 1
        return state

    def result(self, dt: float, streams: dict[str, Floats]) -> Trajectory:
        """The trajectory as far as it was filled."""
        n, t = self.filled, self.trajectory
        contacts = None if self.contacts is None else tuple(self.contacts)
        return Trajectory(t.time[:n], t.p_WB[:n], t.q_WB[:n], t.v_WB[:n], t.w_WB[:n], dt=dt, contacts=contacts, streams=streams)


def simulate(
    simulation: Simulation,
    scene: Scene,
    *,
    dt: float,
    duration: float,
    sample_interval: float,
    with_contacts: bool,
    seed: int,
) -> tuple[Trajectory, str | None]:
    """Step a simulation to its end; the trajectory and, where it diverged, when and how."""
    steps = max(1, round(duration / dt))
    every = steps_between_samples(sample_interval, dt)
    log = _Log(steps, every, dt, len(scene.bodies), with_contacts)
    sensors = SensorRecorder(scene, simulation, seed, dt) if scene.sensors else None
    here, reading = 0, State.empty(len(scene.bodies))
    try:
        log.take(simulation)
        if sensors is not None:
            simulation.state(reading)
            sensors.read(0.0, reading)
        while here < steps:
            next_sample = min((here // every + 1) * every, steps)
            until = next_sample
            if sensors is not None:
                until = min(until, (here // sensors.interval_steps + 1) * sensors.interval_steps)
            simulation.step(until - here)
            here = until
            if here == next_sample:
                log.take(simulation)
            if sensors is not None and here % sensors.interval_steps == 0:
                simulation.state(reading)
                sensors.read(here * dt, reading)
    except Diverged as error:
        return log.result(dt, {}), f"by step {here + 1} of {steps} (t = {here * dt:.6g} s): {error}"
    return log.result(dt, {} if sensors is None else sensors.streams()), None
