"""Many equal worlds as the states of one model, stepped one after the other in one `MjData`."""

from collections.abc import Sequence

import numpy as np

from plumbline.adapters.mujoco.simulation import MujocoSimulation
from plumbline.harness.adapter import Notice, Settings
from plumbline.harness.trajectory import State


class MujocoWorlds:
    """A batch: each world is a row of all that `mj_step` reads, warm start included, so that it goes as it would alone.

    Source: MuJoCo, "Simulation", state and control (mjSTATE_INTEGRATION); `mujoco.rollout` does the same without warm starts.
    """

    def __init__(self, simulation: MujocoSimulation, count: int) -> None:
        self._simulation = simulation
        self._states: Sequence[np.ndarray] = list(np.tile(simulation.integration(), (count, 1)))

    @property
    def resolved(self) -> Settings:
        """Of the model."""
        return self._simulation.resolved

    @property
    def worlds(self) -> int:
        """How many states there are."""
        return len(self._states)

    def step(self, count: int = 1) -> None:
        """Advance every world by count * dt. Raises: Diverged."""
        for state in self._states:
            self._simulation.continue_from(state)
            self._simulation.step(count)
            self._simulation.integration(state)

    def state(self, world: int, out: State) -> None:
        """Write the present state of a world."""
        self._simulation.continue_from(self._states[world])
        self._simulation.state(out)

    def warnings(self) -> tuple[Notice, ...]:
        """Of all worlds together."""
        return self._simulation.warnings()

    def close(self) -> None:
        """Close the simulation."""
        self._simulation.close()
