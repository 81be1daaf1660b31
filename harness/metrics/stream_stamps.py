"""Time stamps of sensors: whole multiples of the sensor's interval, none left out, up to the end of the run.

The metric is the largest distance of a stamp from its multiple, infinite where one is missing or stands twice. The first stamp
is time 0 for a sensor that reads an instant, and for inertial ones and spinning range finders, which tell of an interval, the
first one by which a whole interval and the latency have passed.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import maximum
from plumbline.harness.scene import Imu, Lidar


@metric("s")
def time_stamp_error(run: Run) -> float:
    """definition: |stamp - k/rate|"""
    worst = []
    for sensor in run.scene.sensors:
        name = f"{sensor.name}/time"
        if name not in run.actual.streams:
            raise NotMeasurable(f"stream '{name}' was not recorded")
        stamps, interval = run.actual.streams[name], 1.0 / sensor.rate
        first = 0
        if isinstance(sensor, Imu):
            first = 1 + int(np.ceil(sensor.latency / interval - 1e-9))
        elif isinstance(sensor, Lidar) and sensor.spinning:
            first = 1
        last = int(np.floor(float(run.actual.time[-1]) / interval + 1e-6))
        due = np.arange(first, last + 1) * interval
        if len(stamps) != len(due):
            return float("inf")
        if not np.isfinite(stamps).all():
            return float("nan")
        worst.append(np.abs(stamps - due))
    if not worst or sum(map(len, worst)) == 0:
        raise NotMeasurable("the scene has no sensor, or none was read")
    return maximum(np.concatenate(worst))
