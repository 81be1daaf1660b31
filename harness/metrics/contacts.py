"""Contacts: what they bear, how deep bodies stand in one another, how often points of contact come and go.

Penetration: how deep bodies stand in one another, from their poses and shapes; and, apart, as the engine's contacts say.

An engine's contacts may be told for the pose before the step, be cut short, or hold margins and slops; poses cannot.

Support force: do the fixed bodies carry the weight of the others?

Contact flips: how often points of contact appear and vanish.

Impulse: the largest one that contacts give to a body within one step.

Load split: the share of a load that each of its supports bears.

The load is the heaviest movable body, the highest of them where several are; all other movable bodies are its supports.
"""

import math
from collections import Counter
from itertools import pairwise

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.contact_impulses import forces_on, mean_forces
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Contacts, Floats, Trajectory
from plumbline.harness.trajectory.depths import pair_depths
from plumbline.harness.trajectory.kinematics import movable


@metric("m", verdict="two bodies share space, by where they are and what shapes they have")
def penetration(run: Run) -> float:
    """impenetrability: the shortest way that would part two bodies (Ericson, Real-Time Collision Detection, section 4.4), from
    their poses and shapes, greatest of all pairs and samples; 0 where nothing overlaps"""
    if len(run.actual) == 0:
        raise NotMeasurable("no samples")
    if not any(run.scene.collides(a, b) for i, a in enumerate(run.scene.bodies) for b in run.scene.bodies[:i]):
        raise NotMeasurable("no two bodies can touch")
    deepest = 0.0
    for a, b, deep in pair_depths(run.scene, run.actual):
        if deep is None:
            raise NotMeasurable(f"no exact depth is known of '{run.scene.bodies[a].name}' in '{run.scene.bodies[b].name}'")
        deepest = max(deepest, float(np.max(deep)))
    return deepest


@metric("m", verdict="the engine lists a point of contact with a negative gap")
def reported_penetration(run: Run) -> float:
    """definition: greatest depth (negative gap) of any point of contact that the engine reports, 0 where none is deep"""
    if run.actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    if len(run.actual) == 0:
        raise NotMeasurable("no samples")
    gaps = np.concatenate([c.gap for c in run.actual.contacts])
    if not np.isfinite(gaps).all():
        return math.nan
    return max(0.0, -float(gaps.min())) if len(gaps) else 0.0


@metric("1", impulses=True)
def support_force_error(run: Run) -> float:
    """balance of momentum at rest: |mean contact force of the fixed bodies on the movable ones + weight| / |weight|"""
    movable = np.array([body.movable for body in run.scene.bodies])
    weight = sum(body.mass for body in run.scene.bodies if body.movable) * np.array(run.scene.gravity)
    forces = mean_forces(run.actual, len(run.scene.bodies))
    if not weight.any():
        raise NotMeasurable("nothing has weight")
    return float(np.linalg.norm(forces[~movable][:, movable].sum(axis=(0, 1)) + weight) / np.linalg.norm(weight))


def _bearing(contacts: Contacts) -> Counter[tuple[int, int]]:
    """Number of points of each pair of bodies that carry force; a near miss that an engine lists carries none."""
    loaded = np.linalg.norm(contacts.force_W, axis=1) > 0
    pairs = zip(contacts.body_A[loaded].tolist(), contacts.body_B[loaded].tolist(), strict=True)
    return Counter(pairs)


@metric("1/step", verdict="a point begins or ceases to carry force")
def contact_flips(run: Run) -> float:
    """points that begin or cease to carry force, per step: sum over pairs of bodies of the change of their number"""
    if run.actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    if len(run.actual) < 2:
        raise NotMeasurable("fewer than two samples")
    spacing = np.diff(run.actual.time)
    if run.actual.dt > 0 and np.any(np.abs(spacing - run.actual.dt) > 1e-6 * run.actual.dt):
        raise NotMeasurable(f"samples {spacing.max():g} s apart, expected one every step of {run.actual.dt:g} s")
    if not all(np.isfinite(c.force_W).all() for c in run.actual.contacts):
        return math.nan
    counts = [_bearing(c) for c in run.actual.contacts]
    if not any(counts):
        return math.nan
    flips = 0
    for before, after in pairwise(counts):
        flips += sum(abs(after[pair] - before[pair]) for pair in before.keys() | after.keys())
    return flips / (len(counts) - 1)


@metric("N s", even=True)
def impulse_max(run: Run) -> float:
    """definition: greatest |sum of the contact forces on a body|, averaged over a step, times the step"""
    if run.actual.contacts is None:
        raise NotMeasurable("the run has no contacts")
    if run.actual.dt <= 0.0:
        raise NotMeasurable("a truth has no steps")
    largest = 0.0
    for contacts in run.actual.contacts:
        total = forces_on(contacts, len(run.scene.bodies))
        # max() of Python would drop a NaN.
        largest = float(np.max([largest, *np.linalg.norm(total[run.movable], axis=1)]))
    return largest * run.actual.dt


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
