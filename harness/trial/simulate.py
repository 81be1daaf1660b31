"""A simulation stepped to its end: its states at the samples, its contacts and what its sensors said.

The kinetic energy beyond which a run has blown up: finite numbers that nothing in the scene can have paid for.

What can: the kinetic energy and that of springs at the start, a fall for the whole of the run, and drives that push with their
limit in one direction all the time. A drive without a limit, an effort, a body that is led and a force from outside can give
anything; what they ask for at the start is counted, and they leave more room. Engines err by shares of what is in play, not by
a million times it.
"""

from dataclasses import dataclass

import numpy as np

from plumbline.harness.adapter import Diverged, Simulation, Unsupported
from plumbline.harness.adapter.what_comes_out import BrokenContract
from plumbline.harness.metric.contact_impulses import forces_between, impulses_of
from plumbline.harness.scene import WORLD, Body, Prismatic, Revolute, Scene
from plumbline.harness.sensors.recorder import SensorRecorder
from plumbline.harness.trajectory import Contacts, Floats, Integers, State, Trajectory
from plumbline.harness.trajectory.kinematics import movable, rotate_back
from plumbline.harness.trajectory.pace import Pace

TIMES, TIMES_UNLIMITED = 1e6, 1e12
"""Of the energy that can be there: where all sources are limited, and where one has no limit."""


@dataclass(frozen=True, slots=True)
class EnergyLimit:
    """Terms: bodies (m,): places of those that a force moves, with their mass (m,) kg and inertia (m, 3, 3) kg m2. moment (m,)
    kg m2: the trace of that, which no axis has more than. payable [J]: the energy that can be there. most [J]: beyond it a run
    has diverged; infinite where nothing is in play."""

    bodies: Integers
    mass: Floats
    inertia: Floats
    moment: Floats
    payable: float
    most: float

    @classmethod
    def of(cls, scene: Scene, duration: float, *, pushed: bool = False) -> "EnergyLimit":
        """Of a scene that runs for `duration` [s]. Args: pushed: does a force from outside act on it?"""
        places = movable(scene)
        mass = np.array([scene.bodies[index].mass for index in places])
        inertia = np.array([scene.bodies[index].inertia for index in places]).reshape(-1, 3, 3)
        start = State.initial(scene)
        payable = float(np.sum(_kinetic(start, places, mass, inertia)))
        fall = np.linalg.norm(start.v_WB[places], axis=1) + np.linalg.norm(scene.gravity) * duration
        payable += float(np.sum(mass * fall**2)) / 2
        unlimited = pushed
        for joint in scene.joints:
            spring = getattr(joint, "spring", None)
            if spring is not None and isinstance(joint, Revolute | Prismatic):
                payable += spring.stiffness * (joint.position - spring.rest) ** 2 / 2
            elif spring is not None:
                length = float(np.linalg.norm(np.subtract(joint.anchor_W, joint.child_anchor_W)))  # type: ignore[union-attr]
                payable += spring.stiffness * (length - spring.rest) ** 2 / 2
            if isinstance(joint, Revolute | Prismatic) and joint.effort is not None:
                unlimited = True
            if isinstance(joint, Revolute | Prismatic) and joint.drive is not None:
                energy, limited = _of_drive(scene, joint, duration)
                payable, unlimited = payable + energy, unlimited or not limited
        for body in scene.bodies:
            if body.motion == "kinematic":
                v_WB, w_WB = body.velocity_at_start
                unlimited, payable = True, payable + float(mass.sum()) * float(np.dot(v_WB, v_WB) + np.dot(w_WB, w_WB)) / 2
        times = TIMES_UNLIMITED if unlimited else TIMES
        moment = np.trace(inertia, axis1=1, axis2=2)
        return cls(places, mass, inertia, moment, payable, times * payable if payable > 0 else np.inf)

    def check(self, state: State) -> None:
        """Raises: Diverged, where a state has more."""
        v_WB, w_WB = state.v_WB[self.bodies], state.w_WB[self.bodies]
        at_most = self.mass @ np.einsum("bi,bi->b", v_WB, v_WB) + self.moment @ np.einsum("bi,bi->b", w_WB, w_WB)
        if at_most / 2 <= self.most:  # which is far from it, as a rule
            return
        energy = float(np.sum(_kinetic(state, self.bodies, self.mass, self.inertia)))
        if energy > self.most:
            raise Diverged(
                f"kinetic energy {energy:.3g} J, more than {self.most / self.payable:.0e} times the {self.payable:.3g} J that "
                "the scene can give"
            )


def _kinetic(state: State, places: Integers, mass: Floats, inertia: Floats) -> Floats:
    """Of each body, (m,) J."""
    with np.errstate(over="ignore", invalid="ignore"):
        w_B = rotate_back(state.q_WB[places], state.w_WB[places])
        energy: Floats = (mass * np.sum(state.v_WB[places] ** 2, axis=1) + np.einsum("bi,bij,bj->b", w_B, inertia, w_B)) / 2
    return energy


def _of_drive(scene: Scene, joint: Revolute | Prismatic, duration: float) -> tuple[float, bool]:
    """What a drive may give [J], and whether that is all: a force F on a mass m for a time T gives F^2 T^2 / (2 m)."""
    drive = joint.drive
    assert drive is not None
    ends = [scene.body(name) for name in (joint.parent, joint.child) if name != WORLD and scene.body(name).movable]
    yields = sum(1 / felt for body in ends if (felt := _felt(body, joint)) > 0)
    constant = drive.feedforward is not None and not (drive.stiffness or drive.damping)
    limit = abs(drive.feedforward or 0.0) if constant and drive.limit is None else drive.limit
    if limit is not None:
        return (limit * duration) ** 2 * yields / 2, True
    pulled = drive.stiffness * (drive.target - joint.position) ** 2 / 2
    return pulled + (drive.target_velocity**2 / (2 * yields) if yields else 0.0), False


def _felt(body: Body, joint: Revolute | Prismatic) -> float:
    """The least that a joint may feel of a body: its mass [kg], or its moment [kg m2] about the axis through its centre."""
    if isinstance(joint, Prismatic):
        return body.mass
    axis_B = rotate_back(np.array(body.q_WB), np.array(joint.axis_W))
    return float(axis_B @ np.array(body.inertia) @ axis_B)


UNIT = 1e-6
"""How far the norm of a quaternion may be off 1: ten times what one that is normalised in single precision leaves."""


def steps_between_samples(interval: float, dt: float) -> int:
    """Whole steps of dt [s] between two samples `interval` [s] apart, at least one."""
    return max(1, round(interval / dt))


class _Impulses:
    """What bodies give each other in every step, summed up from sample to sample."""

    def __init__(self, pace: Pace, bodies: int) -> None:
        self.pace, self.sum = pace, np.zeros((bodies, bodies, 3))
        self.time: list[float] = []
        self.sums: list[dict[tuple[int, int], Floats]] = []

    def step(self, simulation: Simulation, here: int, until: int) -> None:
        """Advance a simulation from one place to another, step by step."""
        for place in range(here, until):
            simulation.step(1)
            self.sum += self.pace.length(place) * forces_between(simulation.contacts(), len(self.sum))

    def take(self, place: int) -> None:
        """Close the stretch that ends here."""
        self.time.append(self.pace.time(place))
        pairs = np.argwhere(np.triu((self.sum != 0.0).any(axis=2))).tolist()
        self.sums.append({(a, b): self.sum[a, b].copy() for a, b in pairs})
        self.sum[:] = 0.0

    def streams(self) -> dict[str, Floats]:
        """What came together so far."""
        return impulses_of(self.time, self.sums)


class _Log:
    """Room for a trajectory, filled sample by sample."""

    def __init__(self, steps: int, every: int, pace: Pace, limit: EnergyLimit, bodies: int, with_contacts: bool) -> None:
        places = [*range(0, steps, every), steps]
        self.trajectory = Trajectory.of(np.array([pace.time(place) for place in places], dtype=np.float64), bodies)
        self.pace, self.limit = pace, limit
        self.contacts: list[Contacts] | None = [] if with_contacts else None
        self.filled = 0

    def take(self, simulation: Simulation) -> State:
        """Read the next sample; raises Diverged where it is not finite, or has more energy than anything can have given."""
        state = self.trajectory.state(self.filled)
        simulation.state(state)
        if not state.finite:
            raise Diverged("the state is not finite")
        self.limit.check(state)
        if self.contacts is not None:
            self.contacts.append(simulation.contacts())
        self.filled += 1
        return state

    def result(self, streams: dict[str, Floats]) -> Trajectory:
        """The trajectory as far as it was filled."""
        n, t = self.filled, self.trajectory
        contacts = None if self.contacts is None else tuple(self.contacts)
        states = t.p_WB[:n], t.q_WB[:n], t.v_WB[:n], t.w_WB[:n]
        dt, even = self.pace.longest, self.pace.even
        return Trajectory(t.time[:n], *states, dt=dt, contacts=contacts, streams=streams, even=even)


def _promised(trajectory: Trajectory, scene: Scene) -> Trajectory:
    """The trajectory, whose quaternions are turns. Raises: BrokenContract."""
    off = np.abs(np.linalg.norm(trajectory.q_WB, axis=2) - 1)
    if off.max(initial=0.0) > UNIT:
        sample, place = np.unravel_index(np.argmax(off > UNIT), off.shape)
        norm, body = np.linalg.norm(trajectory.q_WB[sample, place]), scene.bodies[place].name
        raise BrokenContract(f"q_WB of body '{body}' at t = {trajectory.time[sample]:.6g} s: got norm {norm:.6g}, expected 1")
    return trajectory


def simulate(
    simulation: Simulation,
    scene: Scene,
    *,
    pace: Pace,
    duration: float,
    sample_interval: float,
    with_contacts: bool,
    seed: int,
    with_impulses: bool = False,
    pushed: bool = False,
) -> tuple[Trajectory, str | None]:
    """Step a simulation to its end; the trajectory and, where it diverged, when and how.

    Samples are taken every so many steps, at the times at which these end: uneven ones, where the steps are.

    Args: with_impulses: read contacts after every step, for the streams of `harness.metric.contact_impulses`; where every step
        is a sample, there are none. pushed: does a force from outside act on the scene?
    Raises: BrokenContract; Unsupported for sensors under uneven steps.
    """
    dt = pace.dt
    if scene.sensors and not pace.even:
        raise Unsupported("sensors under uneven steps", "their readings and latencies are whole numbers of even steps")
    steps = max(1, round(duration / dt))
    every = steps_between_samples(sample_interval, dt)
    limit = EnergyLimit.of(scene, duration, pushed=pushed)
    log = _Log(steps, every, pace, limit, len(scene.bodies), with_contacts)
    sensors = SensorRecorder(scene, simulation, seed, dt) if scene.sensors else None
    impulses = _Impulses(pace, len(scene.bodies)) if with_impulses and every > 1 else None
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
            if impulses is None:
                simulation.step(until - here)
            else:
                impulses.step(simulation, here, until)
            here = until
            if here == next_sample:
                log.take(simulation)
                if impulses is not None:
                    impulses.take(here)
            if sensors is not None and here % sensors.interval_steps == 0:
                simulation.state(reading)
                sensors.read(here * dt, reading)
    except Diverged as error:
        return _promised(log.result({}), scene), f"by step {here + 1} of {steps} (t = {pace.time(here):.6g} s): {error}"
    streams = {} if sensors is None else sensors.streams()
    return _promised(log.result(streams if impulses is None else streams | impulses.streams()), scene), None
