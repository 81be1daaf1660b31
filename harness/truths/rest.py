"""Rest: every body stays where the scene puts it."""

from collections.abc import Callable
from typing import Any

from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory


def at_rest(scene: Scene, time: Floats) -> Trajectory:
    """The bodies of a scene in their places at each time [s], with no speed."""
    truth = Trajectory.of(time, len(scene.bodies))
    truth.p_WB[:] = [body.p_WB for body in scene.bodies]
    truth.q_WB[:] = [body.q_WB for body in scene.bodies]
    return truth


def resting(scene: Callable[[Any], Scene]) -> Callable[[Floats, Any], Trajectory]:
    """The truth of a case in whose scene nothing moves."""
    return lambda time, parameters: at_rest(scene(parameters), time)
