"""Position error: distance between the centres of mass of answer and truth, over the bodies that a force moves."""

import numpy as np

from plumbline.harness.metric import Run
from plumbline.harness.metric.series import three
from plumbline.harness.trajectory import Floats


def _distance(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    distance: Floats = np.linalg.norm(run.actual.p_WB[:, bodies] - truth.p_WB[:, bodies], axis=-1)
    return distance


position_error_max, position_error_rms, position_error_final = three(
    "position_error", "m", "definition: |p_WB - p_WB of the truth|", _distance
)
