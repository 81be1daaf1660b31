"""What acts on a scene from outside: laws of forces, of targets and of kinematic bodies, told to a simulation before its steps.

A force that is held over a step dt moves a body by v' = v + f dt and x' = x + v dt + c f dt^2, where c is 1 for semi-implicit
Euler and 1/2 where the motion under a constant force is exact. With f asked for at x + (1 - c) v dt that map is a drift, a
kick and another drift, and keeps phase space whole whatever c; with f asked for elsewhere an orbit spirals. An engine may say
its 1 - c as `Simulation.force_lead`; where it says nothing the law is shown the state as it is, as c = 1 has it.
Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., sections I.1.4 and II.5 (Stoermer-Verlet, splitting).

Targets of drives are a signal of time. What is held over a step is taken from its middle, which differs from the mean over the
step by a term in dt^2 alone: every engine is told the same numbers at the same steps, and all steps follow one signal.
Velocities of kinematic bodies are those that lead from where a law has them at a step's start to where it has them at its end:
they are there after every step, whatever its length.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.adapter import Simulation
from plumbline.harness.scene import Vector3
from plumbline.harness.trajectory import Floats, State
from plumbline.harness.trajectory.kinematics import product
from plumbline.harness.trajectory.pace import Pace

Velocities = Callable[[float, float], Mapping[str, tuple[Vector3, Vector3]]]
"""(time, step) [s] to v_WB [m/s] and w_WB [rad/s] over that step, by the names of kinematic bodies."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """A law of forces, of targets, of kinematic bodies, or of several.

    Terms:
        wrench(time [s], state) gives f_B_W (n, 3) N at the centres of mass and tau_B_W (n, 3) N m, and leaves the state alone.
        targets(time [s]) gives those of drives [rad or m] by the names of their joints.
        velocities(time, step [s]) gives v_WB and w_WB of kinematic bodies over that step, by their names.
        interval [s]: how long each answer is held; 0 for a single step.
    """

    wrench: Callable[[float, State], tuple[Floats, Floats]] | None = None
    targets: Callable[[float], Mapping[str, float]] | None = None
    velocities: Velocities | None = None
    interval: float = 0.0

    def __post_init__(self) -> None:
        if self.wrench is None and self.targets is None and self.velocities is None:
            raise ValueError("control: neither wrench nor targets nor velocities, expected at least one of them")


class Controlled:
    """A simulation under a control: stepped, read and closed like any other."""

    def __init__(self, simulation: Simulation, control: Control, pace: float | Pace, bodies: int) -> None:
        self.simulation = simulation
        self._pace = pace if isinstance(pace, Pace) else Pace(pace)
        self._control, self._reading = control, State.empty(bodies)
        self._every = max(1, round(control.interval / self._pace.dt))
        # What is held for longer than a step is a law of time: it is asked at the start of its interval.
        self._lead = 0.0 if control.interval > 0.0 else float(getattr(simulation, "force_lead", 0.0))
        self._here = 0

    def renew(self, most: int) -> int:
        """Tell what is due, and count `most` steps, or those until it is due again, as taken; how many they are."""
        if self._here % self._every == 0:
            time, law, length = self._pace.time(self._here), self._control, self._pace.length(self._here)
            if law.wrench is not None:
                self.simulation.state(self._reading)
                lead = self._lead * length
                if lead > 0.0:
                    _drift(self._reading, lead)
                self.simulation.wrench(*law.wrench(time + lead, self._reading))
            if law.velocities is not None:
                moved: Any = self.simulation
                moved.prescribe(law.velocities(time, self._pace.span(self._here, self._every)))
            if law.targets is not None:
                self.simulation.command(law.targets(time + (length / 2 if law.interval <= 0.0 else 0.0)))
        count = min(most, self._every - self._here % self._every)
        self._here += count
        return count

    def step(self, count: int = 1) -> None:
        """Advance by count * dt, the wrench renewed whenever it is due. Raises: Diverged, Unsupported."""
        while count > 0:
            steps = self.renew(count)
            self.simulation.step(steps)
            count -= steps

    def save(self) -> object:
        """The simulation's own, with the step that it stands at. Raises: Unsupported."""
        return self._here, self.simulation.save()

    def restore(self, saved: object) -> None:
        """Back to a saved state and its step. Raises: Unsupported."""
        assert isinstance(saved, tuple)
        self._here, inner = saved
        self.simulation.restore(inner)

    def __getattr__(self, name: str) -> Any:
        """All else is the simulation's own."""
        return getattr(self.simulation, name)


def _drift(state: State, time: float) -> None:
    """Move a state on by `time` [s] at constant velocities."""
    state.p_WB[:] += time * state.v_WB
    if not state.w_WB.any():
        return
    angle = time * np.linalg.norm(state.w_WB, axis=1, keepdims=True)
    # np.sinc(x) is sin(pi x)/(pi x), also where one of the bodies does not turn.
    turn = np.concatenate([np.cos(angle / 2), np.sinc(angle / (2 * np.pi)) * state.w_WB * time / 2], axis=1)
    state.q_WB[:] = product(turn, state.q_WB)


def wrench_after(control: Control, state: State) -> bytes:
    """The bits of what a control answers to a state at the start and a second later: what tells it from another one."""
    answer = b""
    for time in (0.0, 1.0):
        if control.wrench is not None:
            answer += b"".join(np.ascontiguousarray(array).tobytes() for array in control.wrench(time, state))
        if control.targets is not None:
            answer += repr(sorted(control.targets(time).items())).encode()
        if control.velocities is not None:
            answer += repr(sorted(control.velocities(time, 1.0).items())).encode()
    return answer
