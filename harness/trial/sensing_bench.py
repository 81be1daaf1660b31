"""What the clock runs of a scene's sensors: their bare rays, or whole intervals with every reading and its noise."""

import math
from collections.abc import Callable

import numpy as np

from plumbline.harness.adapter import Simulation
from plumbline.harness.case import Rays
from plumbline.harness.scene import Lidar, Scene
from plumbline.harness.sensors.lidar import in_world
from plumbline.harness.sensors.reader import row_of
from plumbline.harness.sensors.recorder import SensorRecorder, steps_between_readings
from plumbline.harness.trajectory import State


def bare_rays(scene: Scene) -> Rays:
    """The beams of all range finders of a scene, from where they stand at its start, as far as the longest goes.

    Raises:
        ValueError: the scene has none.
    """
    finders = [sensor for sensor in scene.sensors if isinstance(sensor, Lidar)]
    if not finders:
        raise ValueError("bare rays: the scene has no range finder, expected one")
    start = State.initial(scene)
    rows = [row_of(scene, finder.body, start) for finder in finders]
    cast = [in_world(finder, row[:3], row[3:7]) for finder, row in zip(finders, rows, strict=True)]
    origins, directions = (np.concatenate(arrays) for arrays in zip(*cast, strict=True))
    return Rays(origins=origins, directions=directions, max_range=max(finder.max_range for finder in finders))


def steps_of_interval(scene: Scene, dt: float) -> int:
    """Steps of dt [s] after which all sensors of a scene have read a whole number of times. Raises: ValueError."""
    if not scene.sensors:
        raise ValueError("sensing: the scene has no sensor, expected one")
    return math.lcm(*(steps_between_readings(sensor, dt) for sensor in scene.sensors))


def sensed_interval(scene: Scene, simulation: Simulation, seed: int, dt: float) -> Callable[[], object]:
    """A function that takes the steps of one such interval, every reading that is due in it, and lays the noise over them.

    The sensors are made anew for each interval, so that what they keep does not grow; `simulation` may be under a control,
    whose law is then part of what is called.
    """
    steps, room = steps_of_interval(scene, dt), State.empty(len(scene.bodies))

    def step_and_sense() -> None:
        recorder = SensorRecorder(scene, simulation, seed, dt)
        every = math.gcd(recorder.interval_steps, steps)
        for here in range(every, steps + 1, every):
            simulation.step(every)
            simulation.state(room)
            recorder.read(here * dt, room)
        recorder.streams()

    return step_and_sense
