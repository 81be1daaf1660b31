"""Equal systems side by side from starts that hardly differ: what they do on average once chance has parted them.

The members of an ensemble are told by the number at the end of their bodies' names. Late in a chaotic motion no member can be
compared with the truth's, but averages over members and time can, to their standard error.
"""

import re

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import rotate_back


def _members(scene: Scene) -> list[list[int]]:
    """The places of each member's movable bodies, member by member."""
    by_number: dict[int, list[int]] = {}
    for place, body in enumerate(scene.bodies):
        number = re.fullmatch(r".*_(\d+)", body.name)
        if body.movable and number is not None:
            by_number.setdefault(int(number[1]), []).append(place)
    members = [by_number[number] for number in sorted(by_number)]
    if len(members) < 2 or len({len(member) for member in members}) > 1:
        raise NotMeasurable("an ensemble needs two members or more with the same number of bodies each")
    return members


def kinetic_energies(scene: Scene, run: Trajectory) -> Floats:
    """Kinetic energy of each member, averaged over time, (members,) J. Raises: NotMeasurable."""
    members = _members(scene)
    if len(run) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    means = np.zeros(len(members))
    for k, member in enumerate(members):
        for place in member:
            w_B = rotate_back(run.q_WB[:, place], run.w_WB[:, place])
            inertia = np.array(scene.bodies[place].inertia)
            means[k] += scene.bodies[place].mass * np.mean(np.sum(np.square(run.v_WB[:, place]), axis=-1)) / 2
            means[k] += np.mean(np.sum(w_B * (w_B @ inertia), axis=-1)) / 2
    return means


@metric("1")
def ensemble_energy_error(run: Run) -> float:
    """definition: mean kinetic energy over members and time, over the truth's, less 1"""
    here, there = (kinetic_energies(run.scene, motion).mean() for motion in (run.actual, run.truth))
    return float(abs(here / there - 1))


@metric("m")
def ensemble_spread(run: Run) -> float:
    """definition: root mean square distance, at the end, of a body from the mean of its kind over the members"""
    members = np.array(_members(run.scene))
    if len(run.actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    p_WB = run.actual.p_WB[-1][members]
    return float(np.sqrt(np.mean(np.sum(np.square(p_WB - p_WB.mean(axis=0)), axis=-1))))
