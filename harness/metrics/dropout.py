"""Dropout rate: its distance from the law in the standard deviations that the law gives it.

A score below z says that Wilson's interval for confidence z, drawn about the observed rate, holds the law's rate.
"""

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Lidar, Scene
from harness.trajectory import Trajectory

SOURCE = "Wilson, Probable inference, the law of succession, and statistical inference (1927)"


def _score(scene: Scene, actual: Trajectory, _expected: Trajectory | None) -> float:
    scores = []
    for sensor in scene.sensors:
        if not isinstance(sensor, Lidar) or sensor.noise is None:
            continue
        noisy, ideal = (actual.streams.get(f"{sensor.name}/{channel}") for channel in ("range", "range_ideal"))
        if noisy is None or ideal is None:
            raise NotMeasurable(f"ranges of sensor '{sensor.name}' were not recorded")
        if np.isnan(noisy).any() or np.isnan(ideal).any():
            return float("nan")
        hit = np.isfinite(ideal)
        count, law = int(hit.sum()), sensor.noise.dropout
        if count == 0:
            raise NotMeasurable(f"no beam of sensor '{sensor.name}' hits anything")
        if np.isfinite(noisy[~hit]).any():
            # A return from nothing is no dropout, and no law allows it.
            return float("inf")
        lost = float(np.mean(~np.isfinite(noisy[hit])))
        width = np.sqrt(law * (1 - law) / count)
        scores.append(abs(lost - law) / width if width > 0 else (0.0 if lost == law else np.inf))
    if not scores:
        raise NotMeasurable("no range finder of the scene has a noise model")
    return float(np.max(scores))


METRIC = DROPOUT_SCORE = Metric(name="dropout_score", unit="1", source=SOURCE, measure=_score)
