"""Radius error: how far bodies leave their distance from the vertical through the origin, as a share of the truth's."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.metric.series import three
from plumbline.harness.trajectory import Floats


def _error(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    here, there = (np.hypot(t.p_WB[:, bodies, 0], t.p_WB[:, bodies, 1]) for t in (run.actual, truth))
    if np.size(there) and not there.min() > 0:
        raise NotMeasurable("the truth passes through the vertical through the origin: there is no radius to compare with")
    error: Floats = np.abs(here / there - 1)
    return error


radius_error_max, radius_error_rms, radius_error_final = three(
    "radius_error", "1", "definition: distance from the z axis of W over the truth's, less 1", _error
)
