"""A room of six walls, whose ranges have a closed form, in which a body flies and turns with sensors mounted askew."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plumbline.harness.conformance.closed_forms import first_hit
from plumbline.harness.conformance.engine import COARSE, Engine, state_of
from plumbline.harness.conformance.frames import TURNED, rotation, vector
from plumbline.harness.conformance.scenes import free, static, without_gravity
from plumbline.harness.scene import Appearance, Body, Box, Scene, Sensor, axis_angle, multiply
from plumbline.harness.sensors.recorder import SensorRecorder
from plumbline.harness.trajectory import Floats, State

MOUNT: dict[str, Any] = {
    "body": "carrier",
    "p_BS": (0.4, -0.3, 0.2),
    "q_BS": multiply(axis_angle((0.0, 1.0, 0.0), -0.9), axis_angle((3.0, -1.0, 2.0), 0.6)),
}
"""On a lever and askew, so that no two rotations may change places."""
_SEED = 5
SIGMAS = 5.0
"""Standard deviations that a statistic of noise may be off; its seed is fixed, so that it is off alike each time."""
_LOW, _HIGH = np.array([-4.0, -3.0, -2.0]), np.array([5.0, 6.0, 4.0])
"""Corners of the room [m]."""
_NEAR: tuple[float, float, float] = (0.35, 0.45, 0.55)
"""Half extents [m] of the box."""
WALLS = (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)
"""Reflectivities of the walls, the low and the high one along x, y and z, and of the box."""


def carrier(**fields: Any) -> Body:
    """The body that carries the sensors, turned, with three moments of inertia; `fields` are those of a body."""
    return replace(free("carrier", moments=(0.3, 0.2, 0.25), q=TURNED), **fields)


def read_on(engine: Engine, scene: Scene, steps: int) -> tuple[dict[str, Floats], list[State]]:
    """The streams of a scene's sensors after so many coarse steps, and the states at all of them, the start's first."""
    with engine.built(scene, COARSE) as simulation:
        recorder = SensorRecorder(scene, simulation, _SEED, COARSE)
        states = [state_of(simulation, scene)]
        recorder.read(0.0, states[0])
        for k in range(1, steps + 1):
            simulation.step(1)
            states.append(state_of(simulation, scene))
            if k % recorder.interval_steps == 0:
                recorder.read(k * COARSE, states[k])
        return recorder.streams(), states


def in_a_room(*sensors: Sensor, **carried: Any) -> Scene:
    """The carrier in the middle of the room, and the box beside it."""
    middle, half = (_LOW + _HIGH) / 2, (_HIGH - _LOW) / 2
    bodies = [carrier(**carried)]
    for axis, name in enumerate("xyz"):
        for side in (-1.0, 1.0):
            centre, extents = middle.copy(), half + 1.0
            centre[axis], extents[axis] = middle[axis] + side * (half[axis] + 0.5), 0.5
            wall = static(f"{name} {'low' if side < 0 else 'high'}", Box(half_extents=vector(extents)), p=vector(centre))
            bodies.append(replace(wall, appearance=Appearance(reflectivity=WALLS[len(bodies) - 1])))
    box = static("near", Box(half_extents=_NEAR), p=(1.3, 0.2, 0.6), q=TURNED)
    bodies.append(replace(box, appearance=Appearance(reflectivity=WALLS[6])))
    return without_gravity(*bodies, sensors=sensors)


@dataclass(frozen=True, slots=True)
class _Seen:
    """What rays from one point meet: distance [m], place in the scene, cosine of incidence, each (r,)."""

    distance: Floats
    body: Floats
    cosine: Floats


def seen_from(origin: Floats, directions: Floats) -> _Seen:
    """In the room, for unit directions (r, 3) in W."""
    with np.errstate(divide="ignore"):
        walls = (np.where(directions > 0, _HIGH, _LOW) - origin) / directions
    axis, rows = np.argmin(walls, axis=1), np.arange(len(directions))
    distance = walls[rows, axis]
    body, cosine = 1.0 + 2 * axis + (directions[rows, axis] > 0), np.abs(directions[rows, axis])
    R = rotation(TURNED)
    o, d = R.T @ (origin - (1.3, 0.2, 0.6)), directions @ R
    for k in rows:
        reach = first_hit(Box(half_extents=_NEAR), o, d[k])
        if reach < distance[k]:
            face = int(np.argmax(np.abs(o + reach * d[k]) / _NEAR))
            distance[k], body[k], cosine[k] = reach, 7.0, abs(d[k, face])
    return _Seen(distance, body, cosine)


def mounted(state: State) -> tuple[Floats, Floats]:
    """Origin (3,) and axes (3, 3) in W of what is mounted on the carrier, the first body."""
    R_WB = rotation(state.q_WB[0])
    return state.p_WB[0] + R_WB @ MOUNT["p_BS"], R_WB @ rotation(MOUNT["q_BS"])
