"""Velocity error: distance between the velocities of the centres of mass of answer and truth, in W."""

import numpy as np

from plumbline.harness.metric import Run
from plumbline.harness.metric.series import three
from plumbline.harness.trajectory import Floats


def _difference(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    difference: Floats = np.linalg.norm(run.actual.v_WB[:, bodies] - truth.v_WB[:, bodies], axis=-1)
    return difference


velocity_error_max, velocity_error_rms, velocity_error_final = three(
    "velocity_error", "m/s", "definition: |v_WB - v_WB of the truth|", _difference
)
