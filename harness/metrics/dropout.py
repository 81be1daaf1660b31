"""Dropout rate: its distance from the law in the standard deviations that the law gives it.

A score below z says that Wilson's interval for confidence z, drawn about the observed rate, holds the law's rate.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Lidar

SOURCE = "Wilson, Probable inference, the law of succession, and statistical inference (1927)"


@metric("1", SOURCE)
def dropout_score(run: Run) -> float:
    scores = []
    for sensor in run.scene.sensors:
        if not isinstance(sensor, Lidar) or sensor.noise is None:
            continue
        noisy, ideal = (run.actual.streams.get(f"{sensor.name}/{channel}") for channel in ("range", "range_ideal"))
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
