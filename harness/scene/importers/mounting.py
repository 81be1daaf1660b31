"""Sensors of a robot, mounted on links: each comes to stand on the body that its link is part of."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import WORLD, Body, Sensor
from plumbline.harness.scene.importers.poses import IDENTITY, Pose, pose, quaternion, vector


def mounted(
    sensors: Iterable[Sensor], links: Mapping[str, str], at: Mapping[str, Pose], bodies: Iterable[Body], source: str
) -> tuple[Sensor, ...]:
    """The sensors on bodies.

    Args:
        sensors: their body names a link, their pose is in its frame. links: body by link; at: pose in W of each link.
    Raises:
        RobotError: a link that is none, or a name that stands twice.
    """
    own = {body.name: body for body in bodies}
    made: list[Sensor] = []
    for sensor in sensors:
        if sensor.body not in links and sensor.body != WORLD:
            raise RobotError(
                f"{source}: sensor {quoted(sensor.name, 80)}: body {quoted(sensor.body, 80)} is no link of the robot, expected "
                f"one of {listed(list(links), 12)}"
            )
        if any(other.name == sensor.name for other in made):
            raise RobotError(f"{source}: sensor {quoted(sensor.name, 80)} stands twice, expected names, each once")
        body = links.get(sensor.body, WORLD)
        X_WL, X_WB = at.get(sensor.body, IDENTITY), pose(own[body].p_WB, own[body].q_WB) if body in own else IDENTITY
        X_BS = X_WB.inverse() @ X_WL @ pose(sensor.p_BS, sensor.q_BS)
        made.append(replace(sensor, body=body, p_BS=vector(X_BS.p), q_BS=quaternion(X_BS.R)))
    return tuple(made)
