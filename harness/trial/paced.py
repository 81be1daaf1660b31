"""A simulation whose steps follow a recorded sequence of lengths: each is told its own before it is taken."""

from typing import Any, cast

from plumbline.harness.adapter import Adapter, Feature, Settings, Simulation, Unsupported
from plumbline.harness.trajectory.pace import Pace


def check_paced(adapter: Adapter, settings: Settings) -> None:
    """Raises: Unsupported, where the settings ask for uneven steps and the engine takes none."""
    if settings.pace and Feature.STEP_LENGTHS not in adapter.features:
        raise Unsupported(f"steps at the pace '{settings.pace}'", "the engine's steps are all as long as it was built with")


def paced(simulation: Simulation, pace: Pace) -> Simulation:
    """The simulation at that pace; the very same one where steps are even."""
    return simulation if pace.even else cast(Simulation, Paced(simulation, pace))


class Paced:
    """A simulation at an uneven pace: stepped, read and closed like any other."""

    def __init__(self, simulation: Simulation, pace: Pace) -> None:
        self._simulation: Any = simulation
        self._pace, self._here = pace, 0

    def step(self, count: int = 1) -> None:
        """Take the next `count` steps, each as long as the sequence says. Raises: Diverged, Unsupported."""
        for _ in range(count):
            self._simulation.retime(self._pace.length(self._here))
            self._simulation.step(1)
            self._here += 1

    def save(self) -> object:
        """The simulation's own, with the step that it stands at. Raises: Unsupported."""
        return self._here, self._simulation.save()

    def restore(self, saved: object) -> None:
        """Back to a saved state and its step. Raises: Unsupported."""
        assert isinstance(saved, tuple)
        self._here, inner = saved
        self._simulation.restore(inner)

    def __getattr__(self, name: str) -> Any:
        """All else is the simulation's own."""
        return getattr(self._simulation, name)
