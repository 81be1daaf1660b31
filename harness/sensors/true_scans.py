"""Scans of a range finder among solids at rest, in closed form: what an engine's own are measured against."""

import numpy as np

from plumbline.harness.scene import Lidar, Scene
from plumbline.harness.sensors.lidar import ideal, in_world
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.sensors.reader import row_of
from plumbline.harness.trajectory import Floats, State


def true_scans(scene: Scene, lidar: Lidar, end: float) -> dict[str, Floats]:
    """Streams '<name>/time' (k,), '<name>/range_ideal' and '<name>/intensity_ideal' (k, channels, columns) up to `end` [s].

    Raises:
        TypeError: a shape without a closed form.
    """
    start = State.initial(scene)
    row = row_of(scene, lidar.body, start)
    origins, directions = in_world(lidar, row[:3], row[3:7])
    hits = first_hits(scene, start, origins, directions, lidar.max_range)
    count = int(np.floor(end * lidar.rate + 1e-6)) + 1
    streams: dict[str, Floats] = {f"{lidar.name}/time": np.arange(count) / lidar.rate}
    for name, signal in zip(("range", "intensity"), ideal(lidar, scene, directions, hits), strict=True):
        streams[f"{lidar.name}/{name}_ideal"] = np.broadcast_to(signal, (count, *signal.shape))
    return streams
