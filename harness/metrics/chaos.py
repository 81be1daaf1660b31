"""Motions in which small differences grow: balls on the edge, and ensembles that chance has parted.

Of balls let go near the tops of fixed balls: how fast a small tilt grows, and how small a one decides where a ball falls. The
tilt of a ball is the angle between the upward vertical and the line to its centre from that of the fixed ball beneath it. While
it is small it grows like exp(L t). A start is followed if the ball leaves to the side that it was set to, at a time that fits
it: not as if it had been set ten times nearer or farther. Growth is fitted between twenty times the start and 0.1 rad, alike in
answer and truth.

Of equal systems side by side from starts that hardly differ: what they do on average once chance has parted them. The members
of an ensemble are told by the number at the end of their bodies' names. Late in a chaotic motion no member can be compared with
the truth's, but averages over members and time can, to their standard error.
"""

import re

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Scene, Sphere
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import rotate_back

GROWN, LINEAR = 0.1, 20.0
TENFOLD = float(np.log(10.0))
SOURCE = "Ott, Chaos in Dynamical Systems, 2nd ed., section 4.4 (exponent of the growth of a small difference)"


def _pairs(scene: Scene) -> list[tuple[int, int]]:
    """Places of each movable ball and of the fixed ball beneath it."""
    balls = [place for place, body in enumerate(scene.bodies) if isinstance(body.only_shape, Sphere)]
    free = [place for place in balls if scene.bodies[place].movable]
    fixed = [place for place in balls if place not in free]
    if not fixed or not free or not any(scene.gravity):
        raise NotMeasurable("balls, balls that stand still beneath them, and gravity are needed")
    centres = np.array([scene.bodies[place].p_WB for place in fixed])
    beneath = (np.argmin(np.linalg.norm(centres - np.array(scene.bodies[place].p_WB), axis=1)) for place in free)
    return [(place, fixed[int(nearest)]) for place, nearest in zip(free, beneath, strict=True)]


def _tilts(scene: Scene, run: Trajectory) -> tuple[Floats, Floats]:
    """The tilts (t, n) rad, and the unit horizontal directions (t, n, 3), zero where there is no tilt."""
    balls, bumps = np.array(_pairs(scene)).T
    up = -np.array(scene.gravity) / np.linalg.norm(scene.gravity)
    line = run.p_WB[:, balls] - run.p_WB[:, bumps]
    height = line @ up
    aside = line - height[..., None] * up
    distance = np.linalg.norm(aside, axis=-1)
    direction: Floats = aside / np.where(distance > 0, distance, 1.0)[..., None]
    return np.arctan2(distance, height), direction


def _exits(time: Floats, tilts: Floats) -> Floats:
    """When each tilt passes GROWN, (n,) s, by interpolation of its logarithm; inf where it never does."""
    exits = np.full(tilts.shape[1], np.inf)
    for k, tilt in enumerate(tilts.T):
        out = np.flatnonzero(tilt >= GROWN)
        if len(out) and out[0] > 0:
            a, b = np.log(tilt[out[0] - 1 : out[0] + 1])
            share = (np.log(GROWN) - a) / (b - a) if np.isfinite(a) and b > a else 1.0
            exits[k] = time[out[0] - 1] + share * (time[out[0]] - time[out[0] - 1])
    return exits


def _exponents(time: Floats, tilts: Floats) -> Floats:
    """Slope of the logarithm of each tilt between LINEAR times its start and GROWN, (n,) 1/s; NaN with less than 3 samples."""
    exponents = np.full(tilts.shape[1], np.nan)
    for k, tilt in enumerate(tilts.T):
        out = np.flatnonzero(tilt >= GROWN)
        end = int(out[0]) if len(out) else len(tilt)
        linear = np.flatnonzero(tilt[:end] > LINEAR * tilt[0])
        if len(linear) >= 3:
            exponents[k] = np.polyfit(time[linear], np.log(tilt[linear]), 1)[0]
    return exponents


@metric("1", SOURCE)
def growth_exponent_error(run: Run) -> float:
    """over the truth's, less 1, median of the starts"""
    truth = run.truth
    here, there = (_exponents(motion.time, _tilts(run.scene, motion)[0]) for motion in (run.actual, truth))
    usable = np.isfinite(there)
    if not usable.any():
        raise NotMeasurable("no start of the truth grows twentyfold before it is out")
    # One that has no growth of its own to fit is off by all of it.
    return float(np.median(np.abs(np.nan_to_num(here[usable], nan=0.0) / there[usable] - 1)))


def _followed(run: Run) -> tuple[Floats, Floats]:
    """Which of the starts whose truth leaves in time are followed, and how large these starts are [rad]."""
    truth = run.truth
    (tilts, sides), (true_tilts, true_sides) = _tilts(run.scene, run.actual), _tilts(run.scene, truth)
    left, due = _exits(run.actual.time, tilts), _exits(truth.time, true_tilts)
    rate = np.nanmedian(_exponents(truth.time, true_tilts))
    judged = np.flatnonzero(due + TENFOLD / rate <= truth.time[-1])
    if len(judged) == 0:
        raise NotMeasurable("no start of the truth leaves early enough before the end")
    fine = np.zeros(len(judged))
    for k, place in enumerate(judged):
        if abs(left[place] - due[place]) <= TENFOLD / rate:
            here, there = (
                int(np.searchsorted(motion.time, at)) for motion, at in ((run.actual, left[place]), (truth, due[place]))
            )
            fine[k] = float(sides[here, place] @ true_sides[there, place] >= 0.5)
    return fine, true_tilts[0, judged]


@metric("1", verdict="a ball leaves to another side, or at another time, than its start says")
def lost_start_share(run: Run) -> float:
    """definition: share of the starts that are not followed"""
    followed, _ = _followed(run)
    return float(1 - followed.mean())


@metric("rad", finite=False)
def smallest_followed_start(run: Run) -> float:
    """definition: start from which on all are followed"""
    followed, sizes = _followed(run)
    if not run.actual.finite or not followed.any():
        return float("inf")
    # The smallest above which none is lost.
    lost = sizes[followed == 0]
    return float(sizes[sizes > lost.max(initial=0.0)].min(initial=np.inf))


@metric("s")
def exit_time_error_rms(run: Run) -> float:
    """definition: time at which the tilt passes 0.1 rad, less the truth's"""
    truth = run.truth
    left, due = (_exits(motion.time, _tilts(run.scene, motion)[0]) for motion in (run.actual, truth))
    judged = np.isfinite(due)
    if not judged.any():
        raise NotMeasurable("no start of the truth leaves before the end")
    return float(np.sqrt(np.mean(np.square(left[judged] - due[judged]))))


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
    p_WB = run.actual.p_WB[-1][members]
    return float(np.sqrt(np.mean(np.sum(np.square(p_WB - p_WB.mean(axis=0)), axis=-1))))
