"""What the steps of an accuracy run take: a simulation whose calls of `step` are clocked on the way."""

import time
from typing import Any


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
