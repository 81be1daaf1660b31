"""Phase and period error of an oscillation, from the instants at which the first movable body passes the middle of its path.

The path is projected on the direction in which the truth moves most. A passage is found by inverse interpolation with the
cubic through four samples, alike in answer and truth, so that the interpolation's own error (of fourth order) cancels.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.trajectory import Floats

SOURCE = "definition: instants of upward passage through the middle of the path"


def _passages(time: Floats, x: Floats) -> Floats:
    """The instants [s] at which x passes zero upwards, each from the cubic through the two samples on either side."""
    instants = []
    for k in np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0)):
        first = min(max(int(k) - 1, 0), len(x) - 4)
        nodes = time[first : first + 4] - time[k]
        cubic = np.polynomial.Polynomial.fit(nodes, x[first : first + 4], 3, domain=[nodes[0], nodes[-1]])
        roots = np.asarray(cubic.roots())
        real = roots[np.abs(roots.imag) < 1e-6 * (nodes[-1] - nodes[0])].real
        middle = (time[k + 1] - time[k]) / 2
        instants.append(time[k] + real[np.argmin(np.abs(real - middle))])
    return np.array(instants)


def _both(run: Run) -> tuple[Floats, Floats]:
    """Passages of answer and truth."""
    truth, bodies = run.truth, run.movable
    if len(bodies) == 0 or len(run.actual) < 4:
        raise NotMeasurable("a passage needs a body that moves and at least 4 samples")
    path = truth.p_WB[:, bodies[0]]
    centre = (path.max(axis=0) + path.min(axis=0)) / 2
    direction = np.linalg.svd(path - path.mean(axis=0), full_matrices=False)[2][0]
    of_truth = _passages(truth.time, (path - centre) @ direction)
    if len(of_truth) < 2:
        raise NotMeasurable(f"the truth passes the middle of its path {len(of_truth)} times, a period needs 2")
    return _passages(run.actual.time, (run.actual.p_WB[:, bodies[0]] - centre) @ direction), of_truth


@metric("rad", SOURCE)
def phase_error(run: Run) -> float:
    answer, truth = _both(run)
    if len(answer) == 0:
        return float("inf")
    # The last passage that both have; whole passages lost or won since count as whole turns.
    count = min(len(answer), len(truth))
    period = (truth[-1] - truth[0]) / (len(truth) - 1)
    turns = max(abs(len(answer) - len(truth)) - 1, 0)
    return float(2 * np.pi * (abs(answer[count - 1] - truth[count - 1]) / period + turns))


@metric("1", SOURCE)
def period_error(run: Run) -> float:
    answer, truth = _both(run)
    if len(answer) < 2:
        return float("inf")
    return float(abs((answer[-1] - answer[0]) / (len(answer) - 1) * (len(truth) - 1) / (truth[-1] - truth[0]) - 1))
