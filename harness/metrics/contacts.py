"""Contacts: how deep bodies stand in one another, what contacts bear, how often points of contact come and go, and by how much
their forces break the laws of mechanics.

An engine's contacts may be told for the pose before the step, be cut short, or hold margins and slops; poses cannot.

The load is the heaviest movable body, the highest of them where several are; all other movable bodies are its supports.

Contact residuals: by how much the recorded contact forces break the laws of unilateral contact and dry friction.

With the normal force N and the tangential force T on B, the gap g and the slip u of B against A in the tangent plane:

    Signorini            0 <= N,  0 <= g,  N g = 0
    friction cone        |T| <= mu_s N
    maximum dissipation  T = -mu_k N u/|u| where u is not 0

A force may follow the slip of any instant of its step: to that of its end, which is known, weight adds g dt at most, and turns
a slip u by asin(g dt/|u|); bodies that turn at w take the slips of their points along, by w dt. Within that angle every
direction counts as the slip's, and the mean over the step of a force that turns along is shorter, by sin(w dt/2)/(w dt/2).

Each residual is a force: what would have to be taken away or added for the law to hold, summed over the contacts of an
instant, over the weight of all movable bodies. The worst instant counts. Depths (g < 0) are the business of `penetration`.
Slips are read off the states of the bodies, so that an engine's own report of velocities plays no part.

Source: Moreau, Unilateral Contact and Dry Friction in Finite Freedom Dynamics, 1988; Acary, Brogliato, Numerical Methods for
Nonsmooth Dynamical Systems, 2008, chapter 3 (the three laws); Stewart, SIAM Review 42 (2000) 3 (maximum dissipation).

Momentum residual: by how much contact forces and gravity miss the change of momentum that the bodies show in the same step.

    r_k = m (v_k - v_{k-1}) - (F_k + m g) dt

for each movable body without joints, with the sum F_k of the recorded contact forces on it, which are averages over the last
step. Only samples one step apart can be judged: between others forces went unrecorded. The worst of all steps and bodies
counts, over the greatest m |v_k - v_{k-1}| of the record, so that 1 is a force that is missing where it matters most.

Source: Newton's second law in its integral form; Moreau, Unilateral Contact and Dry Friction in Finite Freedom Dynamics, 1988.
"""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.contact_impulses import forces_on, mean_forces
from plumbline.harness.scene import Effect, Scene
from plumbline.harness.trajectory import Contacts, Floats, Integers, Trajectory
from plumbline.harness.trajectory.depths import pair_depths


@metric("m", verdict="two bodies share space, by where they are and what shapes they have")
def penetration(run: Run) -> float:
    """impenetrability: the shortest way that would part two bodies (Ericson, Real-Time Collision Detection, section 4.4), from
    their poses and shapes, greatest of all pairs and samples; 0 where nothing overlaps"""
    if not any(run.scene.collides(a, b) for i, a in enumerate(run.bodies) for b in run.bodies[:i]):
        raise NotMeasurable("no two bodies can touch")
    deepest = 0.0
    for a, b, deep in pair_depths(run.scene, run.actual):
        if deep is None:
            raise NotMeasurable(f"no exact depth is known of '{run.bodies[a].name}' in '{run.bodies[b].name}'")
        deepest = max(deepest, float(np.max(deep)))
    return deepest


@metric("m", contacts=True, verdict="the engine lists a point of contact with a negative gap")
def reported_penetration(run: Run) -> float:
    """definition: greatest depth (negative gap) of any point of contact that the engine reports, 0 where none is deep"""
    gaps = np.concatenate([contacts.gap for contacts in run.contacts])
    return max(0.0, -float(gaps.min(initial=0.0))) if np.isfinite(gaps).all() else math.nan


@metric("1", contacts=True, impulses=True)
def support_force_error(run: Run) -> float:
    """balance of momentum at rest: |mean contact force of the fixed bodies on the movable ones + weight| / |weight|"""
    movable = np.array([body.movable for body in run.bodies])
    weight = sum(body.mass for body in run.bodies if body.movable) * np.array(run.scene.gravity)
    forces = mean_forces(run)
    if not weight.any():
        raise NotMeasurable("nothing has weight")
    return float(np.linalg.norm(forces[~movable][:, movable].sum(axis=(0, 1)) + weight) / np.linalg.norm(weight))


def _bearing(contacts: Contacts) -> Counter[tuple[int, int]]:
    """Number of points of each pair of bodies that carry force; a near miss that an engine lists carries none."""
    loaded = np.linalg.norm(contacts.force_W, axis=1) > 0
    pairs = zip(contacts.body_A[loaded].tolist(), contacts.body_B[loaded].tolist(), strict=True)
    return Counter(pairs)


@metric("1/step", contacts=True, samples=2, verdict="a point begins or ceases to carry force")
def contact_flips(run: Run) -> float:
    """points that begin or cease to carry force, per step: sum over pairs of bodies of the change of their number"""
    contacts, spacing = run.contacts, np.diff(run.actual.time)
    if run.actual.dt > 0 and np.any(np.abs(spacing - run.actual.dt) > 1e-6 * run.actual.dt):
        raise NotMeasurable(f"samples {spacing.max():g} s apart, expected one every step of {run.actual.dt:g} s")
    counts = [_bearing(c) for c in contacts]
    if not any(counts) or not all(np.isfinite(c.force_W).all() for c in contacts):
        return math.nan
    flips = (sum(abs(b[pair] - a[pair]) for pair in a.keys() | b.keys()) for a, b in pairwise(counts))
    return sum(flips) / (len(counts) - 1)


@metric("N s", contacts=True, even=True)
def impulse_max(run: Run) -> Floats:
    """definition: greatest |sum of the contact forces on a body|, averaged over a step, times the step"""
    if run.actual.dt <= 0.0:
        raise NotMeasurable("a truth has no steps")
    forces = np.array([forces_on(contacts, len(run.bodies))[run.movable] for contacts in run.contacts])
    impulses: Floats = np.linalg.norm(forces, axis=-1) * run.actual.dt
    return impulses


def load_shares(run: Run) -> Floats:
    """Mean share (supports,) of the load's weight that each support bears, in the scene's order. Raises: NotMeasurable."""
    places = run.movable.tolist()
    if len(places) < 2 or not any(run.scene.gravity):
        raise NotMeasurable("no load with supports that bears down on them")
    load = max(places, key=lambda place: (run.bodies[place].mass, run.bodies[place].p_WB[2]))
    supports = [place for place in places if place != load]
    forces, weight = mean_forces(run), np.array(run.scene.gravity)
    # What a support does to the load counts against the pull of gravity.
    shares: Floats = -(forces[supports, load] @ weight) / (weight @ weight) / run.bodies[load].mass
    return shares


@metric("1", contacts=True, impulses=True)
def load_split_error(run: Run) -> float:
    """statics: mean share of each support in the weight of the load against an equal share, worst support"""
    shares = load_shares(run)
    return float(np.max(np.abs(shares - 1 / len(shares))))


@dataclass(frozen=True, slots=True)
class _Recorded:
    """The contacts of all samples, one after the other.

    Terms:
        sample (k,): of which sample each is; normal (k,) N; tangent (k, 3) N, on B; slip (k, 3) m/s, of B; turned (k,) rad: by
        both bodies within the step; open (k,) m: the gap beyond what the pair may close within the step; static, kinetic (k,):
        coefficients of friction.
    """

    sample: Integers
    normal: Floats
    tangent: Floats
    slip: Floats
    turned: Floats
    open: Floats
    static: Floats
    kinetic: Floats


def _relative(actual: Trajectory, sample: Integers, contacts: Contacts) -> Floats:
    """Velocity (k, 3) m/s of B against A at the points of contact, in W, each at a sample of its own."""

    def of(body: Integers) -> Floats:
        arm = contacts.point_W - actual.p_WB[sample, body]
        velocity: Floats = actual.v_WB[sample, body] + np.cross(actual.w_WB[sample, body], arm)
        return velocity

    return of(contacts.body_B) - of(contacts.body_A)


def _friction(scene: Scene, contacts: Contacts) -> Floats:
    """Static and kinetic coefficients (k, 2) of the pairs."""
    count = len(scene.bodies)
    pairs, which = np.unique(contacts.body_A * count + contacts.body_B, return_inverse=True)
    laws = [scene.surface(scene.bodies[pair // count], scene.bodies[pair % count]) for pair in pairs]
    rubs = Effect.FRICTION in scene.effects
    coefficients = [(law.static_friction, law.kinetic_friction) if rubs else (0.0, 0.0) for law in laws]
    return np.array(coefficients, dtype=np.float64).reshape(-1, 2)[which]


def _joined(contacts: Sequence[Contacts]) -> tuple[Integers, Contacts]:
    """The contacts of all samples as one, and of which sample each is (k,)."""
    sample = np.repeat(np.arange(len(contacts)), [len(sampled) for sampled in contacts])
    return sample, Contacts(*(np.concatenate([getattr(sampled, f.name) for sampled in contacts]) for f in fields(Contacts)))


def _recorded(scene: Scene, actual: Trajectory, sample: Integers, contacts: Contacts) -> _Recorded:
    friction, spin = _friction(scene, contacts), np.linalg.norm(actual.w_WB, axis=-1)
    n = contacts.normal_W
    normal = np.sum(contacts.force_W * n, axis=1)
    now = _relative(actual, sample, contacts)
    along = np.sum(now * n, axis=1)
    # A gap is that of the step's start: what closes within the step may bear force at its end. Between two samples free
    # fall adds at most g times their distance to the speed at which a pair comes closer.
    earlier = np.maximum(sample - 1, 0)
    before = _relative(actual, earlier, contacts)
    closing = np.maximum(np.abs(along), np.abs(np.sum(before * n, axis=1)))
    closing += float(np.linalg.norm(scene.gravity)) * np.maximum(actual.time[sample] - actual.time[earlier], actual.dt)
    return _Recorded(
        sample=sample,
        normal=normal,
        tangent=contacts.force_W - normal[:, None] * n,
        slip=now - along[:, None] * n,
        turned=actual.dt * (spin[sample, contacts.body_A] + spin[sample, contacts.body_B]),
        open=np.maximum(contacts.gap - actual.dt * closing, 0.0),
        static=friction[:, 0],
        kinetic=friction[:, 1],
    )


def _worst(run: Run, law: Callable[[_Recorded, float], Floats]) -> float:
    """The largest sum over the contacts of an instant of what breaks a law [N], over the weight.

    Args: law: (contacts, slowest slip that counts [m/s]) to (k,) N.
    """
    (sample, contacts), g = _joined(run.contacts), float(np.linalg.norm(run.scene.gravity))
    weight = g * sum(body.mass for body in run.bodies if body.movable)
    if weight == 0:
        raise NotMeasurable("nothing has weight")
    numbers = (contacts.force_W, contacts.normal_W, contacts.point_W, contacts.gap)
    if not all(np.isfinite(array).all() for array in numbers):
        return math.nan
    recorded = _recorded(run.scene, run.actual, sample, contacts)
    sums = np.bincount(recorded.sample, weights=law(recorded, g * run.actual.dt))
    return float(sums.max(initial=0.0)) / weight


@metric("1", contacts=True, even=True)
def signorini_residual(run: Run) -> float:
    """Moreau 1988: normal forces that pull, or act across a gap that the step cannot close, over the weight, at worst"""
    return _worst(run, lambda at, _: np.maximum(-at.normal, 0.0) + np.where(at.open > 0.0, np.maximum(at.normal, 0.0), 0.0))


@metric("1", contacts=True, even=True)
def cone_residual(run: Run) -> float:
    """Moreau 1988: tangential forces beyond mu_s N, over the weight, at worst"""
    return _worst(
        run, lambda at, _: np.maximum(np.linalg.norm(at.tangent, axis=1) - at.static * np.maximum(at.normal, 0.0), 0.0)
    )


def _dissipation(at: _Recorded, slow: float) -> Floats:
    speed = np.linalg.norm(at.slip, axis=1)
    # What friction and weight can stop within a step is sticking at the step's resolution: no direction is judged there.
    slips = (speed > slow) & (speed > 0.0)
    due, rubs = at.kinetic * np.maximum(at.normal, 0.0), np.linalg.norm(at.tangent, axis=1)
    against = -np.sum(at.tangent * at.slip, axis=1) / np.where(slips & (rubs > 0.0), rubs * speed, 1.0)
    # A force may follow the slip of any instant of its step, which differs from that of the end by as much at most.
    turn = np.arcsin(slow / np.where(slips, speed, np.inf)) + at.turned
    askew = np.maximum(np.arccos(np.clip(against, -1.0, 1.0)) - np.minimum(turn, np.pi), 0.0)
    nearest = np.clip(rubs, due * np.sinc(np.minimum(at.turned / (2 * np.pi), 1.0)), due)
    # The law of cosines, as a sum of squares.
    return np.where(slips, np.hypot(rubs - nearest, 2.0 * np.sqrt(rubs * nearest) * np.sin(askew / 2)), 0.0)


@metric("1", contacts=True, even=True)
def dissipation_residual(run: Run) -> float:
    """Stewart 2000: |T + mu_k N u/|u|| of contacts that slip faster than g dt, over the weight, at worst"""
    return _worst(run, _dissipation)


@metric("1", contacts=True, even=True)
def momentum_residual(run: Run) -> float:
    """Newton's second law over a step: |m dv - (F + m g) dt| at worst, over the greatest m |dv|"""
    contacts, dt = run.contacts, run.actual.dt
    steps = np.flatnonzero(np.abs(np.diff(run.actual.time) - dt) < 1e-6 * dt) + 1
    if len(steps) == 0:
        raise NotMeasurable("no two samples are one step apart, so that forces went unrecorded")
    jointed = {name for joint in run.scene.joints for name in (joint.parent, joint.child)}
    bodies = [k for k, b in enumerate(run.bodies) if b.movable and b.name not in jointed and b.linear_damping == 0]
    if not bodies:
        raise NotMeasurable("no body moves under contacts and gravity alone")
    mass = np.array([run.bodies[k].mass for k in bodies])[:, None]
    gravity = np.array(run.scene.gravity) * (Effect.GRAVITY in run.scene.effects)
    gained = mass * (run.actual.v_WB[steps][:, bodies] - run.actual.v_WB[steps - 1][:, bodies])
    force = np.array([forces_on(contacts[k], len(run.bodies))[bodies] for k in steps])
    greatest = float(np.linalg.norm(gained, axis=-1).max())
    if greatest == 0.0:
        raise NotMeasurable("nothing changes its momentum")
    return float(np.linalg.norm(gained - (force + mass * gravity) * dt, axis=-1).max()) / greatest
