"""Angular velocity error: distance between the angular velocities of answer and truth, in W."""

import numpy as np

from plumbline.harness.metric import Run
from plumbline.harness.metric.series import three
from plumbline.harness.trajectory import Floats


def _difference(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    difference: Floats = np.linalg.norm(run.actual.w_WB[:, bodies] - truth.w_WB[:, bodies], axis=-1)
    return difference


angular_velocity_error_max, angular_velocity_error_rms, angular_velocity_error_final = three(
    "angular_velocity_error", "rad/s", "definition: |w_WB - w_WB of the truth|", _difference
)
