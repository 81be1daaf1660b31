"""Load split: the share of a load that each of its supports bears.

The load is the heaviest movable body, the highest of them where several are; all other movable bodies are its supports.
"""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import movable

__all__ = ["LOAD_SPLIT_ERROR", "METRIC", "load_shares"]


def load_shares(scene: Scene, actual: Trajectory) -> Floats:
    """Mean share (supports,) of the load's weight that each support bears, in the scene's order.

    Raises: NotMeasurable.
    """
    if actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    places = movable(scene).tolist()
    if len(places) < 2 or len(actual) == 0 or not any(scene.gravity):
        raise NotMeasurable("no load with supports that bears down on them, or no samples")
    load = max(places, key=lambda place: (scene.bodies[place].mass, scene.bodies[place].p_WB[2]))
    supports = [place for place in places if place != load]
    weight = np.array(scene.gravity)
    borne = np.zeros(len(scene.bodies))
    for contacts in actual.contacts:
        # force_W acts on B; what a support does to the load counts against the pull of gravity.
        up = -(contacts.force_W @ weight) / (weight @ weight)
        np.add.at(borne, contacts.body_A[contacts.body_B == load], up[contacts.body_B == load])
        np.add.at(borne, contacts.body_B[contacts.body_A == load], -up[contacts.body_A == load])
    shares: Floats = borne[supports] / (len(actual) * scene.bodies[load].mass)
    return shares


def _measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    shares = load_shares(scene, actual)
    if not actual.finite:
        return math.nan
    return float(np.max(np.abs(shares - 1 / len(shares))))


LOAD_SPLIT_ERROR = Metric(
    name="load_split_error",
    unit="1",
    source="statics: mean share of each support in the weight of the load against an equal share, worst support",
    measure=_measure,
)

METRIC = LOAD_SPLIT_ERROR
