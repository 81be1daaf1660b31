"""What a trial would cost, before anything is done for it: the scene of a case at given parameters, its steps and rays."""

import math
from collections.abc import Mapping
from typing import Any

from plumbline.harness.case import Case, Parameters
from plumbline.harness.intake.allowance import beyond
from plumbline.harness.intake.safe_text import quoted, readable
from plumbline.harness.scene import Camera, DepthCamera, Lidar, Scene, Sensor


class NoScene(ValueError):
    """Parameters at which a case has no scene; the message names the case, the parameters and the reason."""


def misfit(parameters: Parameters, name: str, value: bool | int | float | str) -> str:
    """What is wrong with a value for a parameter of a case, in words; '' if nothing is."""
    own = parameters[name]
    if isinstance(own, bool) and not isinstance(value, bool):
        return f"{quoted(value)}, expected true or false"
    if isinstance(own, int | float) and not isinstance(own, bool) and (isinstance(value, bool | str)):
        return f"{quoted(value)}, expected a number"
    if isinstance(own, str) and not isinstance(value, str):
        return f"{quoted(value)}, expected a text like {quoted(own)}"
    if isinstance(own, list | tuple):
        return f"{quoted(value)}, expected none: a study cannot set it"
    if (
        isinstance(own, int)
        and not isinstance(own, bool)
        and not isinstance(value, str)
        and (excess := beyond("things", abs(value)))
    ):
        return excess
    reason = parameters.misfit(name, value)
    return f"{quoted(value)}, expected {reason}" if reason else ""


def scene_at(case: Case, parameters: Mapping[str, Any]) -> Scene:
    """The scene of a case. Raises: NoScene."""
    try:
        return case.scene(case.at(**parameters))
    except Exception as error:
        given = {name: value for name, value in parameters.items() if case.parameters.get(name) != value}
        message = " ".join(str(error).split())
        raise NoScene(
            f"case '{readable(case.name, 300)}' has no scene at {quoted(given) if given else 'its parameters'}: "
            f"{type(error).__name__}: {readable(message, 300)}"
        ) from error


def _rays(sensor: Sensor) -> int:
    """Rays, pixels or readings at one instant."""
    match sensor:
        case Lidar():
            return sensor.channels * sensor.columns
        case Camera():
            return sensor.width * sensor.height * sensor.samples
        case DepthCamera():
            return sensor.width * sensor.height
        case _:
            return 1


def too_many_steps(duration: float, dt: float) -> str:
    """How far a run of so long [s] at steps of dt [s] goes beyond the limit, in words; '' where it does not."""
    excess = beyond("steps", math.ceil(min(duration / dt, 1e300)))
    return f"duration {duration:g} s at dt {dt:g} s: {excess}" if excess else ""


def too_much(case: Case, scene: Scene, dt: float, *, every_step: bool = False) -> str:
    """What a run of a scene asks for beyond a limit, at steps of dt [s], in words; '' where it does not."""
    if excess := too_many_steps(case.duration, dt):
        return excess
    interval = dt if every_step or not case.sample_interval else case.sample_interval
    if excess := beyond("samples", math.ceil(case.duration / interval * len(scene.bodies))):
        return f"{len(scene.bodies)} bodies every {interval:g} s over {case.duration:g} s: {excess}"
    costs = {sensor.name: _rays(sensor) * sensor.rate * case.duration for sensor in scene.sensors}
    if excess := beyond("rays", math.ceil(min(math.fsum(costs.values()), 1e300)), "rays, pixels and readings"):
        return f"sensor '{max(costs, key=lambda name: costs[name])}' at most of them, over {case.duration:g} s: {excess}"
    return ""
