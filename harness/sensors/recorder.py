"""Recorder: reads the sensors of a scene while it is simulated, and puts noise on the signals when the run is over.

Streams of an inertial sensor: '<name>/accelerometer', '<name>/gyroscope' (k, 3), of a range finder: '<name>/range',
'<name>/intensity' (k, channels, columns); each also as '<stream>_ideal', without noise; time stamps in '<name>/time' (k,) s.
A sensor without a noise model gives its ideal signal. Inertial sensors read nothing at time 0: no interval has passed yet.
"""

import math

import numpy as np

from harness.adapter import Simulation, Unsupported
from harness.scene import WORLD, Effect, Imu, Lidar, Scene, Sensor
from harness.sensors import imu as inertial
from harness.sensors import imu_noise, lidar_noise
from harness.sensors import lidar as scanning
from harness.trajectory import Floats, State

__all__ = ["SensorRecorder", "steps_between_readings"]

_WORLD_ROW = np.array([1.0, 0.0, 0.0, 0.0] + [0.0] * 6)
"""q_WB, v_WB, w_WB of the world frame."""


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
        self._scene, self._simulation, self._seed, self._dt = scene, simulation, seed, dt
        for sensor in scene.sensors:
            if not isinstance(sensor, Imu | Lidar):
                raise Unsupported(f"sensor '{sensor.name}'", f"no recorder reads a {sensor.type}")
        self._steps = {sensor.name: steps_between_readings(sensor, dt) for sensor in scene.sensors}
        self._times: dict[str, list[float]] = {sensor.name: [] for sensor in scene.sensors}
        self._rows: dict[str, list[Floats]] = {sensor.name: [] for sensor in scene.sensors}
        self._intensities: dict[str, list[Floats]] = {sensor.name: [] for sensor in scene.sensors}
        start = State.empty(len(scene.bodies))
        simulation.state(start)
        for sensor in scene.sensors:
            if isinstance(sensor, Imu):
                self._times[sensor.name].append(0.0)
                self._rows[sensor.name].append(self._row(sensor, start))

    @property
    def interval_steps(self) -> int:
        """Steps between two calls of `read`: the greatest common divisor of all sensors' intervals."""
        return math.gcd(*self._steps.values())

    def _row(self, imu: Imu, state: State) -> Floats:
        """q_WB, v_WB, w_WB of the carrying body, (10,)."""
        if imu.body == WORLD:
            return _WORLD_ROW
        place = self._scene.index(imu.body)
        return np.concatenate([state.q_WB[place], state.v_WB[place], state.w_WB[place]])

    def read(self, time: float, state: State) -> None:
        """Take the readings that are due at `time` [s], a multiple of dt; `state` is the simulation's at that time.

        Raises:
            Unsupported: the engine casts no rays.
        """
        here = round(time / self._dt)
        for sensor in self._scene.sensors:
            if here % self._steps[sensor.name]:
                continue
            if isinstance(sensor, Imu) and here > 0:
                self._times[sensor.name].append(time)
                self._rows[sensor.name].append(self._row(sensor, state))
            elif isinstance(sensor, Lidar):
                self._times[sensor.name].append(time)
                self._scan(sensor, state)

    def _scan(self, lidar: Lidar, state: State) -> None:
        if lidar.body == WORLD:
            p_WB, q_WB = np.zeros(3), _WORLD_ROW[:4]
        else:
            place = self._scene.index(lidar.body)
            p_WB, q_WB = state.p_WB[place], state.q_WB[place]
        origins, directions = scanning.in_world(lidar, p_WB, q_WB)
        # An engine may cut the ray's end off by rounding; the bounds of the sensor are applied to what comes back.
        hits = self._simulation.cast(origins, directions, lidar.max_range)
        ranges, intensities = scanning.ideal(lidar, directions, hits)
        self._rows[lidar.name].append(ranges)
        self._intensities[lidar.name].append(intensities)

    def streams(self) -> dict[str, Floats]:
        """All signals so far, with noise and without."""
        found: dict[str, Floats] = {}
        for sensor in self._scene.sensors:
            if isinstance(sensor, Imu):
                found |= self._inertial_streams(sensor)
            elif isinstance(sensor, Lidar):
                found |= self._range_streams(sensor)
        return found

    def _inertial_streams(self, sensor: Imu) -> dict[str, Floats]:
        name = sensor.name
        time, rows = np.array(self._times[name]), np.stack(self._rows[name])
        felt = (0.0, 0.0, 0.0) if Effect.GRAVITY in self._scene.narrow else self._scene.gravity
        force, rate = inertial.ideal(sensor, time, rows[:, :4], rows[:, 4:7], rows[:, 7:], felt)
        found = {f"{name}/time": time[1:], f"{name}/accelerometer_ideal": force, f"{name}/gyroscope_ideal": rate}
        interval = self._steps[name] * self._dt
        for channel, signal in (("accelerometer", force), ("gyroscope", rate)):
            law = None if sensor.noise is None else getattr(sensor.noise, channel)
            if law is None:
                found[f"{name}/{channel}"] = signal.copy()
            else:
                found[f"{name}/{channel}"] = signal + imu_noise.three_axes(
                    law, len(signal), interval, self._seed, name, channel
                )
        return found

    def _range_streams(self, sensor: Lidar) -> dict[str, Floats]:
        name = sensor.name
        shape = (-1, sensor.channels, sensor.columns)
        ranges = np.array(self._rows[name], dtype=np.float64).reshape(shape)
        intensities = np.array(self._intensities[name], dtype=np.float64).reshape(shape)
        heard = (ranges.copy(), intensities.copy())
        if sensor.noise is not None:
            heard = lidar_noise.noisy(sensor.noise, ranges, intensities, self._seed, name)
        return {
            f"{name}/time": np.array(self._times[name]),
            f"{name}/range_ideal": ranges,
            f"{name}/intensity_ideal": intensities,
            f"{name}/range": heard[0],
            f"{name}/intensity": heard[1],
        }
