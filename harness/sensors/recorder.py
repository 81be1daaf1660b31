"""Recorder: reads the sensors of a scene while it is simulated, each by the reader of its own file.

Streams are named '<sensor>/<channel>' (k, ...); what noise was laid over stands without it under '<channel>_ideal'; time stamps
in '<sensor>/time' (k,) s. A sensor without a noise model gives its ideal signal.
"""

import math
from collections.abc import Callable, Mapping

from harness.adapter import Simulation, Unsupported
from harness.scene import Scene, Sensor
from harness.sensors.camera import CameraReader
from harness.sensors.depth_camera import DepthReader
from harness.sensors.imu import ImuReader
from harness.sensors.lidar import LidarReader
from harness.sensors.reader import Reader, Setting
from harness.trajectory import Floats, State

__all__ = ["SensorRecorder", "steps_between_readings"]

READERS: Mapping[str, Callable[..., Reader]] = {
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
    if round(steps) < 1 or abs(steps - round(steps)) > 1e-6 * steps:
        raise ValueError(
            f"sensor '{sensor.name}': rate {sensor.rate:g} Hz, expected a whole divisor of the {1.0 / dt:g} steps a second"
        )
    return round(steps)


class SensorRecorder:
    """Reads the sensors of a scene; `read` is to be called every `interval_steps` steps, at time 0 too or not."""

    def __init__(self, scene: Scene, simulation: Simulation, seed: int, dt: float) -> None:
        self._dt = dt
        for sensor in scene.sensors:
            if sensor.type not in READERS:
                raise Unsupported(f"sensor '{sensor.name}'", f"no recorder reads a {sensor.type}")
        start = State.empty(len(scene.bodies))
        simulation.state(start)
        setting = Setting(scene, simulation, seed, dt)
        self._due = [
            (steps_between_readings(sensor, dt), READERS[sensor.type](sensor, setting, start)) for sensor in scene.sensors
        ]

    @property
    def interval_steps(self) -> int:
        """Steps between two calls of `read`: the greatest common divisor of all sensors' intervals."""
        return math.gcd(*(steps for steps, _ in self._due))

    def read(self, time: float, state: State) -> None:
        """Take the readings that are due at `time` [s], a multiple of dt; `state` is the simulation's at that time.

        Raises:
            Unsupported: the engine casts no rays, or draws no pictures.
        """
        here = round(time / self._dt)
        for steps, reader in self._due:
            if here % steps == 0:
                reader.read(time, state)

    def streams(self) -> dict[str, Floats]:
        """All signals so far, with noise and without."""
        return {name: signal for _, reader in self._due for name, signal in reader.streams().items()}
