"""Ideal inertial signal against its truth: the largest difference of accelerometer and gyroscope without noise.

The truth carries streams of the same names; readings are matched by their time stamps, and one that the truth does not have
within a nanosecond makes the error infinite.
"""

import numpy as np

from plumbline.harness.metric import Metric, NotMeasurable, Run
from plumbline.harness.metric.series import maximum
from plumbline.harness.scene import Imu


def _error(channel: str, unit: str) -> Metric:
    def measure(run: Run) -> float:
        worst = []
        for sensor in run.scene.sensors:
            if not isinstance(sensor, Imu):
                continue
            name, stamps = f"{sensor.name}/{channel}_ideal", f"{sensor.name}/time"
            if run.expected is None or name not in run.expected.streams:
                raise NotMeasurable(f"the truth has no stream '{name}'")
            if name not in run.actual.streams or len(run.actual.streams[name]) == 0:
                raise NotMeasurable(f"stream '{name}' was not recorded")
            here, there = run.actual.streams[stamps], run.expected.streams[stamps]
            if here.shape != there.shape or not np.all(np.abs(here - there) < 1e-9):
                return float("inf")
            worst.append(maximum(np.linalg.norm(run.actual.streams[name] - run.expected.streams[name], axis=1)))
        if not worst:
            raise NotMeasurable("the scene has no inertial sensor")
        return maximum(np.array(worst))

    return Metric(
        name=f"{channel}_ideal_error", unit=unit, source="definition: |signal - signal of the truth|", measure=measure
    )


accelerometer_ideal_error, gyroscope_ideal_error = _error("accelerometer", "m/s2"), _error("gyroscope", "rad/s")
