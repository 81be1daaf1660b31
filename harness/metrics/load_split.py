"""Load split: the share of a load that each of its supports bears.

The load is the heaviest movable body, the highest of them where several are; all other movable bodies are its supports.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.contact_impulses import mean_forces
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import movable


def load_shares(scene: Scene, actual: Trajectory) -> Floats:
    """Mean share (supports,) of the load's weight that each support bears, in the scene's order.

    Raises: NotMeasurable.
    """
    places = movable(scene).tolist()
    if len(places) < 2 or not any(scene.gravity):
        raise NotMeasurable("no load with supports that bears down on them")
    load = max(places, key=lambda place: (scene.bodies[place].mass, scene.bodies[place].p_WB[2]))
    supports = [place for place in places if place != load]
    forces, weight = mean_forces(actual, len(scene.bodies)), np.array(scene.gravity)
    # What a support does to the load counts against the pull of gravity.
    shares: Floats = -(forces[supports, load] @ weight) / (weight @ weight) / scene.bodies[load].mass
    return shares


@metric("1", impulses=True)
def load_split_error(run: Run) -> float:
    """statics: mean share of each support in the weight of the load against an equal share, worst support"""
    shares = load_shares(run.scene, run.actual)
    return float(np.max(np.abs(shares - 1 / len(shares))))
