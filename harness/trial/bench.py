"""What the clock runs in a trial: steps of a scene, with or without reading its state, rays cast into it, steps of many worlds
of it, calls that take no step, or intervals of its sensors.

Building, the time before a case is steady, and the law of forces that act from outside are outside the clock. A steady case
goes on with one run until its end and then starts anew; any other starts anew for each sample, so that all samples have the
same part of the motion.
"""

import math
import sys
import time
from collections.abc import Callable
from functools import partial
from statistics import median
from typing import Any

from harness.adapter import Adapter, Simulation
from harness.adapter.many_worlds import Batch
from harness.case import Case, Rays
from harness.case.commands import acting
from harness.case.forces import Controlled
from harness.study.trial import Trial
from harness.trajectory import State
from harness.trial.sensing_bench import bare_rays, sensed_interval, steps_of_interval

__all__ = ["TOGETHER", "Bench", "calibrate", "caster", "clock_steps", "rough_cost", "rough_cost_beside"]

TOGETHER = 4
"""Steps that a batch of worlds takes in one call: a policy that acts 60 times a second at 240 Hz."""
LONGEST = 10.0
"""A single run of a scene is cut off after this many times the sample's length."""
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


class Bench:
    """A trial under the clock.

    Terms:
        whole: clocked steps of a full run, without end for casts and empty calls. units: what one step or cast counts for.
        steady: may a run go on over samples? unit: what is counted. dt [s].
        starting: CPU seconds that it last took to build and to go to where the clock starts. settled: does the clock of a
        steady case wait until the case is steady?
    """

    def __init__(self, case: Case, adapter: Adapter, trial: Trial, *, settled: bool = True) -> None:
        self._adapter, self._trial = adapter, trial
        self._scene = trial.scene(case)
        self._rays = None if case.rays is None else case.rays(**trial.parameters)
        if trial.clocks == "casting":
            self._rays = bare_rays(self._scene)
        self._control = acting(self._scene, None if case.control is None else case.control(**trial.parameters))
        self._worlds = case.count_of_worlds(trial.parameters)
        self.unit, self.dt = case.unit(trial.parameters, trial.clocks), trial.settings.dt
        endless = self._rays is not None or trial.clocks == "call"
        self.steady = case.steady is not None or endless
        dt = trial.settings.dt
        self._before = round(case.steady / dt) if case.steady is not None and settled else 0
        self.whole = sys.maxsize if endless else max(1, round(case.duration / dt) - self._before)
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


def calibrate(bench: Bench, seconds: float) -> int:
    """Warm up and find how many steps, casts or calls last `seconds` of CPU time: whole runs of a scene unless too long.

    Of one that is too long it is the first half, quarter, eighth, ...: sliding may cost twice what lying still does, so that a
    part that followed the clock would be another part, at another price, every time.
    They last less where most of a sample would go by outside the clock, in building short runs anew.
    """
    bench.start()
    bench.clock(1)
    if bench.steady:
        count, spent = 1, bench.clock(1)[0]
        while spent < seconds / 4:
            count *= 4
            spent = bench.clock(count)[0]
        outside = bench.starting / bench.whole
        return max(1, min(math.ceil(count * seconds / spent), int(PATIENCE * seconds / (spent / count + outside))))
    done, spent = 1, 0.0
    while done < bench.whole and spent < LONGEST * seconds:
        count = min(max(1, bench.whole // 20), bench.whole - done)
        spent += bench.clock(count)[0]
        done += count
    if done < bench.whole:
        return max(1, bench.whole >> math.ceil(math.log2(bench.whole / done)))
    runs = min(math.ceil(seconds / max(spent, 1e-7)), int(PATIENCE * seconds / max(spent + bench.starting, 1e-7)))
    return bench.whole * max(1, runs)


def rough_cost(bench: Bench, seconds: float = 2e-3) -> float:
    """CPU seconds per simulated second, per unit where that is no step: the least of up to five short samples, taken at once.

    What disturbs a sample makes it longer, so that the least is known as soon as another comes within `ALIKE` of it: building
    anew for each sample may take far longer than the sample. Whatever comes of it, the bench is stopped.
    """
    try:
        steps = calibrate(bench, seconds)
        samples = [bench.clock(steps)[0]]
        while len(samples) < 5 and (len(samples) == 1 or samples[1] > ALIKE * samples[0]):
            samples = sorted((*samples, bench.clock(steps)[0]))
        taken = samples[0] / (steps * bench.units)
    finally:
        bench.stop()
    return taken / _length(bench)


def rough_cost_beside(bench: Bench, yardstick: Bench, seconds: float = 5e-4) -> tuple[float, float]:
    """The rough cost of a bench, and how many times that of a yardstick it is: the median of five samples, taken in turns.

    What slows the machine for a while slows both: under a load that came and went every second or two, the ratio was off by
    4 % and a cost alone by 16 % (root mean square). Whatever comes of it, both are stopped.
    """
    try:
        both = [(side, calibrate(side, seconds)) for side in (bench, yardstick)]
        taken = [[side.clock(steps)[0] / (steps * side.units) for side, steps in both] for _ in range(5)]
    finally:
        bench.stop()
        yardstick.stop()
    ratio = median(own / other for own, other in taken) * _length(yardstick) / _length(bench)
    return ratio * min(other for _, other in taken) / _length(yardstick), ratio


def _length(bench: Bench) -> float:
    """What a unit counts for in a rough cost: its simulated time [s] where it is a step, itself elsewhere."""
    return bench.dt if bench.unit == "step" else 1.0
