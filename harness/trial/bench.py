"""What the clock runs in a trial: steps of a scene, with or without reading its state, rays cast into it, steps of many worlds
of it, calls that take no step, or intervals of its sensors.

Building, the time before a case is steady, and the law of forces that act from outside are outside the clock. A sample is one
whole run of the scene or several, each built anew; of a steady case, from its steady time to its end. So every engine of a case
is clocked over the same motion: sliding may cost twice what lying still does. Casts and empty calls have no end: one scene
serves all their samples.
"""

import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any

import numpy as np

from plumbline.harness.adapter import Adapter, Simulation
from plumbline.harness.adapter.many_worlds import Batch
from plumbline.harness.case import Case, Rays
from plumbline.harness.case.commands import acting
from plumbline.harness.case.forces import Controlled
from plumbline.harness.scene import Lidar, Scene
from plumbline.harness.sensors.lidar import in_world
from plumbline.harness.sensors.reader import row_of
from plumbline.harness.sensors.recorder import SensorRecorder, steps_between_readings
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import State


def bare_rays(scene: Scene) -> Rays:
    """The beams of all range finders of a scene, from where they stand at its start, as far as the longest goes.

    Raises:
        ValueError: the scene has none.
    """
    finders = [sensor for sensor in scene.sensors if isinstance(sensor, Lidar)]
    if not finders:
        raise ValueError("bare rays: the scene has no range finder, expected one")
    start = State.initial(scene)
    rows = [row_of(scene, finder.body, start) for finder in finders]
    cast = [in_world(finder, row[:3], row[3:7]) for finder, row in zip(finders, rows, strict=True)]
    origins, directions = (np.concatenate(arrays) for arrays in zip(*cast, strict=True))
    return Rays(origins=origins, directions=directions, max_range=max(finder.max_range for finder in finders))


def steps_of_interval(scene: Scene, dt: float) -> int:
    """Steps of dt [s] after which all sensors of a scene have read a whole number of times. Raises: ValueError."""
    if not scene.sensors:
        raise ValueError("sensing: the scene has no sensor, expected one")
    return math.lcm(*(steps_between_readings(sensor, dt) for sensor in scene.sensors))


def sensed_interval(scene: Scene, simulation: Simulation, seed: int, dt: float) -> Callable[[], object]:
    """A function that takes the steps of one such interval, every reading that is due in it, and lays the noise over them.

    The sensors are made anew for each interval, so that what they keep does not grow; `simulation` may be under a control,
    whose law is then part of what is called.
    """
    steps, room = steps_of_interval(scene, dt), State.empty(len(scene.bodies))

    def step_and_sense() -> None:
        recorder = SensorRecorder(scene, simulation, seed, dt)
        every = math.gcd(recorder.interval_steps, steps)
        for here in range(every, steps + 1, every):
            simulation.step(every)
            simulation.state(room)
            recorder.read(here * dt, room)
        recorder.streams()

    return step_and_sense


TOGETHER = 4
"""Steps that a batch of worlds takes in one call: a policy that acts 60 times a second at 240 Hz."""
LONG = 10.0
"""A run that lasts this many times the length of a sample is long: it is repeated `FEW` times, or as often as time allows."""
FEW = 3
"""Samples of a long run: the fewest with a middle that one disturbed sample does not move."""
UNEVEN = 2.0
"""How many times what its beginning foretells a run may take; one that would not fit so is warmed up over all of it."""
PATIENCE = 3.0
"""A sample is made shorter where building anew for each of its runs would make it take more than this many times its length."""
ALIKE = 1.02
"""The ratio within which two samples of a rough cost are one and the same."""


def clock_steps(simulation: Simulation | Batch, steps: int) -> tuple[float, float]:
    """CPU and wall seconds of one call of `step`."""
    wall, cpu = time.perf_counter(), time.process_time()
    simulation.step(steps)
    return time.process_time() - cpu, time.perf_counter() - wall


def clock_calls(call: Callable[[], object], count: int) -> tuple[float, float]:
    """CPU and wall seconds of so many calls."""
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(count):
        call()
    return time.process_time() - cpu, time.perf_counter() - wall


def caster(simulation: Simulation, rays: Rays) -> Callable[[], object]:
    """A function that casts the rays: the engine's own call into arrays made beforehand where its adapter offers one."""
    prepare = getattr(simulation, "caster", None)
    if prepare is None:
        return partial(simulation.cast, rays.origins, rays.directions, rays.max_range)
    prepared: Callable[[], object] = prepare(rays.origins, rays.directions, rays.max_range)
    return prepared


def reader(simulation: Simulation, out: State) -> Callable[[], object]:
    """A function that takes one step and reads the state of all bodies."""

    def step_and_read() -> None:
        simulation.step()
        simulation.state(out)

    return step_and_read


class NotClocked(Exception):
    """A whole run does not fit the time that a sample may take."""


@dataclass(frozen=True, slots=True)
class Sampling:
    """How a bench is sampled.

    Terms:
        steps: of a sample, or its casts or empty calls. run: steps of a whole run, of which `steps` is a multiple; 0 for casts
        and calls. most: how many samples there is time for; None for as many as are asked for. emulated: the share of the CPU
        time (0 to 1) that the adapter's own laws take.
    """

    steps: int
    run: int = 0
    most: int | None = None
    emulated: float = 0.0


class Bench:
    """A trial under the clock.

    Terms:
        whole: clocked steps of a full run, without end for casts and empty calls. units: what one step or cast counts for.
        endless: casts and empty calls, which go on over samples. unit: what is counted. dt [s].
        starting: CPU seconds that it last took to build and to go to where the clock starts. settled: does the clock of a
        steady case wait until the case is steady?
    """

    def __init__(self, case: Case, adapter: Adapter, trial: Trial, *, settled: bool = True) -> None:
        self._adapter, self._trial = adapter, trial
        case = case.put(trial.parameters)
        self._scene = trial.scene(case)
        self._rays = None if case.rays is None else case.rays(case.parameters)
        if trial.clocks == "casting":
            self._rays = bare_rays(self._scene)
        self._control = acting(self._scene, None if case.control is None else case.control(case.parameters))
        self._worlds = case.count_of_worlds(trial.parameters)
        self.unit, self.dt = case.unit(trial.parameters, trial.clocks), trial.settings.dt
        self.endless = self._rays is not None or trial.clocks == "call"
        dt = trial.settings.dt
        self._before = round(case.steady / dt) if case.steady is not None and settled else 0
        self.whole = sys.maxsize if self.endless else max(1, round(case.duration / dt) - self._before)
        if trial.clocks == "sensing":
            self.whole = max(1, self.whole // steps_of_interval(self._scene, dt))
        self.units = self._worlds if self._rays is None else len(self._rays.origins)
        self._simulation: Any = None
        self._call: Callable[[], object] | None = None
        self._advance: Callable[[int], tuple[float, float]]
        self._here = 0
        self.starting = 0.0

    def start(self) -> None:
        """Build and go to where the clock starts."""
        self.stop()
        begun = time.process_time()
        scene, settings = self._scene, self._trial.settings
        if self._worlds > 1:
            self._simulation = self._adapter.build_batch(scene, settings, self._worlds)
        else:
            plain = self._simulation = self._adapter.build(scene, settings)
            if self._trial.clocks == "reading":
                self._advance = partial(clock_calls, reader(plain, State.empty(len(scene.bodies))))
            else:
                self._advance = partial(clock_steps, plain)
            if self._trial.clocks == "call":
                self._call = partial(plain.step, 0)
            if self._control is not None:
                self._simulation = Controlled(self._simulation, self._control, settings.dt, len(scene.bodies))
            if self._trial.clocks == "sensing":
                # The law of forces is inside: readings fall between its instants, where the clock cannot stand still.
                sensed = sensed_interval(scene, self._simulation, self._trial.seed, settings.dt)
                self._advance = partial(clock_calls, sensed)
        if self._rays is not None:
            self._call = caster(self._simulation, self._rays)
        elif self._before:
            self._simulation.step(self._before)
        self._here = 0
        self.starting = time.process_time() - begun

    def stop(self) -> None:
        """Free what was built."""
        if self._simulation is not None:
            self._simulation.close()
        self._simulation = self._call = None

    def clock(self, count: int) -> tuple[float, float]:
        """CPU and wall seconds of `count` steps, casts or empty calls."""
        cpu = wall = 0.0
        while count > 0:
            if self._simulation is None or self._here >= self.whole:
                self.start()
            if self._call is not None:
                return clock_calls(self._call, count)
            steps = min(count, self.whole - self._here)
            one_cpu, one_wall = self._step(steps)
            cpu, wall = cpu + one_cpu, wall + one_wall
            self._here += steps
            count -= steps
        return cpu, wall

    def _step(self, count: int) -> tuple[float, float]:
        if self._control is not None and self._trial.clocks != "sensing":
            return self._controlled(count)
        if self._worlds == 1:
            return self._advance(count)
        calls, rest = divmod(count, TOGETHER)
        cpu, wall = clock_calls(partial(self._simulation.step, TOGETHER), calls)
        last = clock_steps(self._simulation, rest) if rest else (0.0, 0.0)
        return cpu + last[0], wall + last[1]

    def _controlled(self, count: int) -> tuple[float, float]:
        """Steps under forces from outside: the clock stands still while these are found and told."""
        cpu = wall = 0.0
        while count > 0:
            steps = self._simulation.renew(count)
            one_cpu, one_wall = self._advance(steps)
            cpu, wall, count = cpu + one_cpu, wall + one_wall, count - steps
        return cpu, wall


def calibrate(bench: Bench, seconds: float, deadline: float = math.inf) -> Sampling:
    """Warm up and find what lasts `seconds` of CPU time: whole runs of a scene, one at least.

    Samples have fewer runs where most of them would go by outside the clock, in building. A long run is warmed up over its
    beginning alone, unless it may not fit the deadline [s], which one sample with its building has to.
    Raises: NotClocked, for a run that does not fit.
    """
    bench.start()
    bench.clock(1)
    if bench.endless:
        return Sampling(_lasting(bench, seconds))
    long, allowed = LONG * seconds, deadline - bench.starting
    left, spent, chunk = bench.whole - 1, 0.0, max(1, bench.whole // 20)  # what is cold in the first step is in no sample
    run = 0.0
    while left and (spent < long or UNEVEN * run > allowed):
        count = min(chunk, left)
        spent += bench.clock(count)[0]
        left -= count
        run = spent * bench.whole / (bench.whole - 1 - left)
        if spent > allowed:
            took = f"{bench.starting:.3g} s to build and {spent:.3g} s for {bench.whole - left} of {bench.whole} steps"
            raise NotClocked(f"a whole run does not fit the {deadline:g} s of a trial: {took}")
    if spent < long:
        runs = min(math.ceil(seconds / max(spent, 1e-7)), int(PATIENCE * seconds / max(spent + bench.starting, 1e-7)))
        return Sampling(bench.whole * max(1, runs), bench.whole)
    return Sampling(bench.whole, bench.whole, FEW if FEW * (bench.starting + run) <= deadline else 1)


def _lasting(bench: Bench, seconds: float) -> int:
    """Casts or calls that last `seconds` of CPU time."""
    count, spent = 1, bench.clock(1)[0]
    while spent < seconds / 4:
        count *= 4
        spent = bench.clock(count)[0]
    return max(1, math.ceil(count * seconds / spent))


def rough_cost(bench: Bench, seconds: float = 2e-3) -> float:
    """CPU seconds per simulated second, per unit where that is no step: the least of up to five short samples, taken at once.

    What disturbs a sample makes it longer, so that the least is known as soon as another comes within `ALIKE` of it: building
    anew for each sample may take far longer than the sample. A long run is taken once. Whatever comes of it, the bench is
    stopped.
    """
    try:
        sampling = calibrate(bench, seconds)
        most = 5 if sampling.most is None else 1
        samples = [bench.clock(sampling.steps)[0]]
        while len(samples) < most and (len(samples) == 1 or samples[1] > ALIKE * samples[0]):
            samples = sorted((*samples, bench.clock(sampling.steps)[0]))
        taken = samples[0] / (sampling.steps * bench.units)
    finally:
        bench.stop()
    return taken / _length(bench)


def rough_cost_beside(bench: Bench, yardstick: Bench, seconds: float = 5e-4) -> tuple[float, float]:
    """The rough cost of a bench, and how many times that of a yardstick it is: the median of five samples, taken in turns.

    What slows the machine for a while slows both: under a load that came and went every second or two, the ratio was off by
    4 % and a cost alone by 16 % (root mean square). Long runs are taken once each. Whatever comes of it, both are stopped.
    """
    try:
        both = [(side, calibrate(side, seconds)) for side in (bench, yardstick)]
        turns = 5 if all(sampling.most is None for _, sampling in both) else 1
        taken = [[side.clock(of.steps)[0] / (of.steps * side.units) for side, of in both] for _ in range(turns)]
    finally:
        bench.stop()
        yardstick.stop()
    ratio = median(own / other for own, other in taken) * _length(yardstick) / _length(bench)
    return ratio * min(other for _, other in taken) / _length(yardstick), ratio


def _length(bench: Bench) -> float:
    """What a unit counts for in a rough cost: its simulated time [s] where it is a step, itself elsewhere."""
    return bench.dt if bench.unit == "step" else 1.0
