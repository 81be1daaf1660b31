"""What bodies give each other through contacts, in the mean over all steps.

A balance of momentum over a stretch of time holds of all steps. Forces of contacts may shake from one to the next, and the mean
of each fourth of them is another number. So the impulses of every step are summed up as a run goes, in a stream.
"""

import numpy as np

from plumbline.harness.metric.metric import Run
from plumbline.harness.trajectory import Contacts, Floats

PLACE = "contacts/"
STAMPS = PLACE + "time"
"""The streams: 'contacts/<a>:<b>' (k, 3), what body number a gave body number b since the sample before, in W [N s], of all
pairs that touched; their stamps."""


def forces_between(contacts: Contacts, bodies: int) -> Floats:
    """The force [N] of body a on body b at an instant, in W, antisymmetric (bodies, bodies, 3)."""
    force = np.zeros((bodies, bodies, 3))
    np.add.at(force, (contacts.body_A, contacts.body_B), contacts.force_W)
    return force - force.transpose(1, 0, 2)


def forces_on(contacts: Contacts, bodies: int) -> Floats:
    """The sum of the forces [N] of all contacts on each body at an instant, in W, (bodies, 3)."""
    total = np.zeros((bodies, 3))
    np.add.at(total, contacts.body_B, contacts.force_W)
    np.add.at(total, contacts.body_A, -contacts.force_W)
    return total


def impulses_of(time: list[float], sums: list[dict[tuple[int, int], Floats]]) -> dict[str, Floats]:
    """The streams. Args: time (k,) s: of samples; sums: at each, by pair, the impulse [N s] of the stretch that ends there."""
    streams: dict[str, Floats] = {STAMPS: np.array(time)}
    for a, b in sorted({pair for one in sums for pair in one}):
        streams[f"{PLACE}{a}:{b}"] = np.array([one.get((a, b), np.zeros(3)) for one in sums])
    return streams


def mean_forces(run: Run) -> Floats:
    """The mean force [N] of body a on body b, in W, antisymmetric (bodies, bodies, 3).

    It is that of all steps between the first and the last sample where they were summed up, and of the samples elsewhere.

    Raises: NotMeasurable.
    """
    actual, bodies = run.actual, len(run.bodies)
    if STAMPS not in actual.streams or len(actual) == 1:
        mean: Floats = np.mean([forces_between(contacts, bodies) for contacts in run.contacts], axis=0)
        return mean
    # What came before the first sample is no part of this stretch.
    later, seconds = actual.streams[STAMPS] > actual.time[0], actual.time[-1] - actual.time[0]
    mean = np.zeros((bodies, bodies, 3))
    for name, impulse in actual.streams.items():
        if name.startswith(PLACE) and name != STAMPS:
            a, b = map(int, name.removeprefix(PLACE).split(":"))
            mean[a, b] = impulse[later].sum(axis=0) / seconds
            mean[b, a] = -mean[a, b]
    return mean
