"""Contact residuals: by how much the recorded contact forces break the laws of unilateral contact and dry friction.

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
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.contact_impulses import forces_on
from plumbline.harness.scene import Effect, Scene
from plumbline.harness.trajectory import Contacts, Floats, Integers, Trajectory


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
    if run.actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    if len(run.actual) == 0:
        raise NotMeasurable("no samples")
    g = float(np.linalg.norm(run.scene.gravity))
    weight = g * sum(body.mass for body in run.scene.bodies if body.movable)
    if weight == 0:
        raise NotMeasurable("nothing has weight")
    sample, contacts = _joined(run.actual.contacts)
    numbers = (contacts.force_W, contacts.normal_W, contacts.point_W, contacts.gap)
    if not all(np.isfinite(array).all() for array in numbers):
        return math.nan
    recorded = _recorded(run.scene, run.actual, sample, contacts)
    sums = np.bincount(recorded.sample, weights=law(recorded, g * run.actual.dt))
    return float(sums.max(initial=0.0)) / weight


@metric("1", even=True)
def signorini_residual(run: Run) -> float:
    """Moreau 1988: normal forces that pull, or act across a gap that the step cannot close, over the weight, at worst"""
    return _worst(run, lambda at, _: np.maximum(-at.normal, 0.0) + np.where(at.open > 0.0, np.maximum(at.normal, 0.0), 0.0))


@metric("1", even=True)
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


@metric("1", even=True)
def dissipation_residual(run: Run) -> float:
    """Stewart 2000: |T + mu_k N u/|u|| of contacts that slip faster than g dt, over the weight, at worst"""
    return _worst(run, _dissipation)


@metric("1", even=True)
def momentum_residual(run: Run) -> float:
    """Newton's second law over a step: |m dv - (F + m g) dt| at worst, over the greatest m |dv|"""
    if run.actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    steps = np.flatnonzero(np.abs(np.diff(run.actual.time) - run.actual.dt) < 1e-6 * run.actual.dt) + 1
    if len(steps) == 0:
        raise NotMeasurable("no two samples are one step apart, so that forces went unrecorded")
    jointed = {name for joint in run.scene.joints for name in (joint.parent, joint.child)}
    bodies = [k for k, b in enumerate(run.scene.bodies) if b.movable and b.name not in jointed and b.linear_damping == 0]
    if not bodies:
        raise NotMeasurable("no body moves under contacts and gravity alone")
    mass = np.array([run.scene.bodies[k].mass for k in bodies])[:, None]
    gravity = np.array(run.scene.gravity) * (Effect.GRAVITY in run.scene.effects)
    gained = mass * (run.actual.v_WB[steps][:, bodies] - run.actual.v_WB[steps - 1][:, bodies])
    force = np.array([forces_on(run.actual.contacts[k], len(run.scene.bodies))[bodies] for k in steps])
    greatest = float(np.linalg.norm(gained, axis=-1).max())
    if greatest == 0.0:
        raise NotMeasurable("nothing changes its momentum")
    return float(np.linalg.norm(gained - (force + mass * gravity) * run.actual.dt, axis=-1).max()) / greatest
