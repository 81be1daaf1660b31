"""Creep: the speed of bodies that friction should hold."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric


@metric("m/s")
def creep_speed(run: Run) -> float:
    """static friction holds: mean speed over the window of the bodies that the truth keeps in place, worst body"""
    if run.expected is None:
        raise NotMeasurable("no truth to say which bodies stay")
    if len(run.actual) < 2:
        raise NotMeasurable("fewer than two samples")
    still = [
        i for i, b in enumerate(run.scene.bodies) if b.movable and not np.any(run.expected.p_WB[:, i] - run.expected.p_WB[0, i])
    ]
    if not still:
        raise NotMeasurable("the truth holds no body")
    way = np.linalg.norm(run.actual.p_WB[-1, still] - run.actual.p_WB[0, still], axis=1)
    return float(way.max() / (run.actual.time[-1] - run.actual.time[0]))
