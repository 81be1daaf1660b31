"""Rest: every body stays where the scene puts it."""

from collections.abc import Callable
from typing import Any

from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory


def resting(scene: Callable[[Any], Scene]) -> Callable[[Floats, Any], Trajectory]:
    """The truth of a case in whose scene nothing moves."""
    return lambda time, parameters: Trajectory.at_rest(scene(parameters), time)
