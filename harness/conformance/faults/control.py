"""What a negative control is: one planted fault, and what has to catch it."""

from collections.abc import Callable
from dataclasses import dataclass

from harness.adapter import Adapter, Feature
from harness.scene import Scene
from harness.trajectory import Trajectory

__all__ = ["SLIDES", "Control"]

SLIDES = (
    "friction_backspin", "friction_roll_incline", "friction_slip_to_roll", "friction_spinning", "friction_static_kinetic",
    "friction_stop", "friction_threshold", "friction_wall_pinch",
)  # fmt: skip
"""Cases in which something slides: they notice the same faults."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """One planted fault.

    Terms:
        name, fault: what is broken, in snake case and in words. caught_by: the conformance checks of which at least one must
        fail, each of which passes on the sound engine. needs: features without which the fault cannot show.
        plant: the adapter with the fault. spoil: the same for a recorded trajectory, for faults behind the engine.
        sensors: the same for the scene that the readers of sensors are told, while the case judges by its own.
        applies_to_cases: patterns of case names that should notice it as well.
    """

    name: str
    fault: str
    caught_by: tuple[str, ...]
    plant: Callable[[Adapter], Adapter] = lambda adapter: adapter
    spoil: Callable[[Trajectory], Trajectory] = lambda trajectory: trajectory
    sensors: Callable[[Scene], Scene] = lambda scene: scene
    needs: Feature = Feature.NONE
    applies_to_cases: tuple[str, ...] = ()

    @property
    def on_trajectory(self) -> bool:
        """Does the fault lie behind the engine, in recorded streams?"""
        return not self.caught_by or self.caught_by == ("noise_axes_are_independent",)
