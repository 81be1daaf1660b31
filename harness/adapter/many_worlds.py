"""Many equal worlds stepped together: the protocol, and the plain way that any engine can go."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from plumbline.harness.adapter.notice import Notice
from plumbline.harness.adapter.settings import Settings
from plumbline.harness.adapter.simulation import Simulation
from plumbline.harness.trajectory import State


class Batch(Protocol):
    """Several worlds of one scene under one group of settings."""

    @property
    def resolved(self) -> Settings:
        """The settings that the engine really uses, the same in every world."""

    @property
    def worlds(self) -> int:
        """How many there are."""

    def step(self, count: int = 1) -> None:
        """Advance every world by count * dt. Raises: Diverged."""

    def state(self, world: int, out: State) -> None:
        """Write the present state of a world into the arrays of `out`."""

    def warnings(self) -> tuple[str | Notice, ...]:
        """What the engine or the adapter has to say of any of them."""

    def close(self) -> None:
        """Free the engine's memory; may be called twice."""


class Turns:
    """One simulation a world, stepped in turn on the calling thread."""

    def __init__(self, simulations: Sequence[Simulation]) -> None:
        self._simulations = list(simulations)

    @property
    def resolved(self) -> Settings:
        """Of the first world."""
        return self._simulations[0].resolved

    @property
    def worlds(self) -> int:
        """How many simulations there are."""
        return len(self._simulations)

    def step(self, count: int = 1) -> None:
        """Advance one world after the other."""
        for simulation in self._simulations:
            simulation.step(count)

    def state(self, world: int, out: State) -> None:
        """Write the present state of a world."""
        self._simulations[world].state(out)

    def warnings(self) -> tuple[str | Notice, ...]:
        """All of them, each once."""
        return tuple(dict.fromkeys(warning for simulation in self._simulations for warning in simulation.warnings()))

    def close(self) -> None:
        """Close every world."""
        for simulation in self._simulations:
            simulation.close()


class WorldOf:
    """One world of a batch as a simulation that is stepped and read, nothing else; stepping it steps them all."""

    def __init__(self, batch: Batch, world: int) -> None:
        self._batch, self._world = batch, world

    @property
    def resolved(self) -> Settings:
        """Of the batch."""
        return self._batch.resolved

    def step(self, count: int = 1) -> None:
        """Advance the whole batch."""
        self._batch.step(count)

    def state(self, out: State) -> None:
        """Write the present state of this world."""
        self._batch.state(self._world, out)

    def warnings(self) -> tuple[str | Notice, ...]:
        """Of the batch."""
        return self._batch.warnings()

    def close(self) -> None:
        """Close the batch."""
        self._batch.close()


def spread(batch: Batch, bodies: int) -> float:
    """Largest difference of any number of any world's state from the first world's; NaN where a number is not finite."""
    first, other, worst = State.empty(bodies), State.empty(bodies), 0.0
    batch.state(0, first)
    for world in range(batch.worlds):
        batch.state(world, other)
        for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
            # max() of Python would drop a NaN.
            worst = float(np.max([worst, np.max(np.abs(getattr(other, name) - getattr(first, name)))]))
    return worst
