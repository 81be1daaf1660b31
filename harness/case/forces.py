"""Forces from outside: a law that is told to a simulation before its steps.

A force that is held over a step dt moves a body by v' = v + f dt and x' = x + v dt + c f dt^2, where c is 1 for semi-implicit
Euler and 1/2 where the motion under a constant force is exact. With f asked for at x + (1 - c) v dt that map is a drift, a
kick and another drift, and keeps phase space whole whatever c; with f asked for elsewhere an orbit spirals. An engine may say
its 1 - c as `Simulation.force_lead`; where it says nothing the law is shown the state as it is, as c = 1 has it.
Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., sections I.1.4 and II.5 (Stoermer-Verlet, splitting).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.adapter import Simulation
from harness.trajectory import Floats, State
from harness.trajectory.kinematics import product

__all__ = ["Control", "Controlled", "wrench_after"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """A law of forces.

    Terms:
        wrench(time [s], state) gives f_B_W (n, 3) N at the centres of mass and tau_B_W (n, 3) N m, and leaves the state alone.
        interval [s]: how long each answer is held; 0 for a single step.
    """

    wrench: Callable[[float, State], tuple[Floats, Floats]]
    interval: float = 0.0


class Controlled:
    """A simulation under a control: stepped, read and closed like any other."""

    def __init__(self, simulation: Simulation, control: Control, dt: float, bodies: int) -> None:
        self.simulation = simulation
        self._law, self._dt, self._reading = control.wrench, dt, State.empty(bodies)
        self._every = max(1, round(control.interval / dt))
        # What is held for longer than a step is a law of time: it is asked at the start of its interval.
        self._lead = 0.0 if control.interval > 0.0 else float(getattr(simulation, "force_lead", 0.0)) * dt
        self._here = 0

    def renew(self, most: int) -> int:
        """Tell the wrench if it is due, and count `most` steps, or those until it is due again, as taken; how many they are."""
        if self._here % self._every == 0:
            self.simulation.state(self._reading)
            if self._lead > 0.0:
                _drift(self._reading, self._lead)
            self.simulation.wrench(*self._law(self._here * self._dt + self._lead, self._reading))
        count = min(most, self._every - self._here % self._every)
        self._here += count
        return count

    def step(self, count: int = 1) -> None:
        """Advance by count * dt, the wrench renewed whenever it is due. Raises: Diverged, Unsupported."""
        while count > 0:
            part = self.renew(count)
            self.simulation.step(part)
            count -= part

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
    return b"".join(np.ascontiguousarray(part).tobytes() for time in (0.0, 1.0) for part in control.wrench(time, state))
