"""The check of noise on recorded streams: its channels are independent."""

import numpy as np

from harness.conformance.check import Finding, judge, near
from harness.trajectory import Trajectory

__all__ = ["noise_axes_are_independent"]


def noise_axes_are_independent(trajectory: Trajectory) -> Finding:
    """Are the channels of each stream (k, c) uncorrelated about their means, as separately seeded noise is?

    Equation: the correlation of k independent pairs has the standard deviation 1/sqrt(k); five of them are granted.
    """
    found = []
    for name, signal in trajectory.streams.items():
        if name.endswith("/time") or signal.ndim != 2 or len(signal) < 100:
            continue
        moving = signal[:, signal.std(axis=0) > 0]
        for a in range(moving.shape[1]):
            for b in range(a + 1, moving.shape[1]):
                r = float(np.corrcoef(moving[:, a], moving[:, b])[0, 1])
                found.append(near(f"correlation of axes {a} and {b} of {name}", r, 0.0, 5 / np.sqrt(len(signal))))
    return judge(*found) if found else Finding("not_applicable", "no stream with two noisy channels of 100 samples")
