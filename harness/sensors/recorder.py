"""Recorder: reads the sensors of a scene while it is simulated, each by the reader of its own file.

Streams are named '<sensor>/<channel>' (k, ...); what errors were laid over stands without them under '<channel>_ideal'; time
stamps in '<sensor>/time' (k,) s. A sensor without a noise model gives its ideal signal.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from plumbline.harness.adapter import Simulation, Unsupported
from plumbline.harness.scene import Imu, Lidar, Scene, Sensor
from plumbline.harness.sensors.camera import CameraReader
from plumbline.harness.sensors.depth_camera import DepthReader
from plumbline.harness.sensors.imu import ImuReader
from plumbline.harness.sensors.lidar import LidarReader
from plumbline.harness.sensors.reader import SensorReader, Setting
from plumbline.harness.sensors.spinning import SpinningReader
from plumbline.harness.trajectory import Floats, State

READERS: Mapping[str, Callable[..., SensorReader]] = {
    "imu": ImuReader,
    "lidar": LidarReader,
    "camera": CameraReader,
    "depth_camera": DepthReader,
}
"""What reads each type of sensor: reader(sensor, setting, start)."""


def steps_between_readings(sensor: Sensor, dt: float) -> int:
    """How many steps of dt [s] lie between two readings.

    Raises:
        ValueError: the sensor's interval is no whole number of steps.
    """
    steps = 1.0 / (sensor.rate * dt)
    if not 0.5 < steps < math.inf or abs(steps - round(steps)) > 1e-6 * steps:
        raise ValueError(
            f"sensor '{sensor.name}': rate {sensor.rate:g} Hz, expected a whole divisor of the {1.0 / dt:g} steps a second"
        )
    return round(steps)


def steps_of_latency(sensor: Sensor, dt: float) -> int:
    """How many steps of dt [s] a signal is old when it is read.

    Raises:
        ValueError: the latency is no whole number of steps; nothing is interpolated.
    """
    latency = sensor.latency if isinstance(sensor, Imu) else 0.0
    steps = latency / dt
    if abs(steps - round(steps)) > 1e-6 * max(steps, 1.0):
        raise ValueError(f"sensor '{sensor.name}': latency {latency:g} s, expected a whole number of steps of {dt:g} s")
    return round(steps)


@dataclass(frozen=True, slots=True)
class _Due:
    """A reader and the steps at which it reads: those n with n + late a multiple of `every`."""

    every: int
    late: int
    reader: SensorReader


def _due(sensor: Sensor, setting: Setting, start: State) -> _Due:
    """Raises: ValueError."""
    every = steps_between_readings(sensor, setting.dt)
    if isinstance(sensor, Lidar) and sensor.spinning:
        return _Due(1, 0, SpinningReader(sensor, setting, start))
    return _Due(every, steps_of_latency(sensor, setting.dt), READERS[sensor.type](sensor, setting, start))


class SensorRecorder:
    """Reads the sensors of a scene; `read` is to be called every `interval_steps` steps, at time 0 too or not.

    Terms: interval_steps: the greatest common divisor of all sensors' intervals and latencies.
    """

    def __init__(self, scene: Scene, simulation: Simulation, seed: int, dt: float) -> None:
        self._dt = dt
        for sensor in scene.sensors:
            if sensor.type not in READERS:
                raise Unsupported(f"sensor '{sensor.name}'", f"no recorder reads a {sensor.type}")
        start = State.empty(len(scene.bodies))
        simulation.state(start)
        setting = Setting(scene, simulation, seed, dt)
        self._due = [_due(sensor, setting, start) for sensor in scene.sensors]
        self.interval_steps = math.gcd(*(steps for due in self._due for steps in (due.every, due.late)))
        self._until = 0.0

    def read(self, time: float, state: State) -> None:
        """Take the readings that are due at `time` [s], a multiple of dt; `state` is the simulation's at that time.

        Raises:
            Unsupported: the engine casts no rays, or draws no pictures.
        """
        here, self._until = round(time / self._dt), time
        for due in self._due:
            if (here + due.late) % due.every == 0:
                due.reader.read(time, state)

    def streams(self) -> dict[str, Floats]:
        """All signals so far, with noise and without; what is late enough to be stamped after the last call is left out."""
        signals = {name: signal for due in self._due for name, signal in due.reader.streams().items()}
        kept: dict[str, Floats] = {}
        for name, signal in signals.items():
            stamps = signals[name.rsplit("/", 1)[0] + "/time"]
            kept[name] = signal if not len(stamps) or stamps[-1] <= self._until else signal[stamps <= self._until + 1e-9]
        return kept
