"""Contact residuals: by how much the recorded contact forces break the laws of unilateral contact and dry friction.

With the normal force N and the tangential force T on B, the gap g and the slip u of B against A in the tangent plane:

    Signorini            0 <= N,  0 <= g,  N g = 0
    friction cone        |T| <= mu_s N
    maximum dissipation  T = -mu_k N u/|u| where u is not 0

Each residual is a force: what would have to be taken away or added for the law to hold, summed over the contacts of an
instant, over the weight of all movable bodies. The worst instant counts. Depths (g < 0) are the business of `penetration`.
Slips are read off the states of the bodies, so that an engine's own report of velocities plays no part.

Source: Moreau, Unilateral Contact and Dry Friction in Finite Freedom Dynamics, 1988; Acary, Brogliato, Numerical Methods for
Nonsmooth Dynamical Systems, 2008, chapter 3 (the three laws); Stewart, SIAM Review 42 (2000) 3 (maximum dissipation).
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Effect, Scene
from harness.trajectory import Contacts, Floats, State, Trajectory

__all__ = ["CONE_RESIDUAL", "DISSIPATION_RESIDUAL", "METRIC", "SIGNORINI_RESIDUAL"]


@dataclass(frozen=True, slots=True)
class _Instant:
    """The contacts of one sample.

    Terms:
        normal (k,) N; tangent (k, 3) N, on B; slip (k, 3) m/s, of B; open (k,) m: the gap beyond what the pair may close within
        the step; static, kinetic (k,): coefficients of friction.
    """

    normal: Floats
    tangent: Floats
    slip: Floats
    open: Floats
    static: Floats
    kinetic: Floats


def _relative(state: State, contacts: Contacts) -> Floats:
    """Velocity (k, 3) m/s of B against A at the points of contact, in W."""
    a, b = contacts.body_A, contacts.body_B
    at_A = state.v_WB[a] + np.cross(state.w_WB[a], contacts.point_W - state.p_WB[a])
    at_B = state.v_WB[b] + np.cross(state.w_WB[b], contacts.point_W - state.p_WB[b])
    found: Floats = at_B - at_A
    return found


def _instants(scene: Scene, actual: Trajectory) -> Iterator[_Instant]:
    assert actual.contacts is not None
    laws: dict[tuple[int, int], tuple[float, float]] = {}
    rubs = Effect.FRICTION in scene.effects
    g = float(np.linalg.norm(scene.gravity))
    for k, contacts in enumerate(actual.contacts):
        if len(contacts) == 0:
            continue
        for a, b in zip(contacts.body_A.tolist(), contacts.body_B.tolist(), strict=True):
            if (a, b) not in laws:
                law = scene.surface(scene.bodies[a], scene.bodies[b])
                laws[a, b] = (law.static_friction, law.kinetic_friction) if rubs else (0.0, 0.0)
        friction = np.array([laws[pair] for pair in zip(contacts.body_A.tolist(), contacts.body_B.tolist(), strict=True)])
        n = contacts.normal_W
        normal = np.sum(contacts.force_W * n, axis=1)
        now = _relative(actual.state(k), contacts)
        along = np.sum(now * n, axis=1)
        # A gap is that of the step's start: what closes within the step may bear force at its end. Between two samples free
        # fall adds at most g times their distance to the speed at which a pair comes closer.
        before = _relative(actual.state(max(k - 1, 0)), contacts)
        closing = np.maximum(np.abs(along), np.abs(np.sum(before * n, axis=1)))
        closing += g * max(float(actual.time[k] - actual.time[max(k - 1, 0)]), actual.dt)
        yield _Instant(
            normal=normal,
            tangent=contacts.force_W - normal[:, None] * n,
            slip=now - along[:, None] * n,
            open=np.maximum(contacts.gap - actual.dt * closing, 0.0),
            static=friction[:, 0],
            kinetic=friction[:, 1],
        )


def _worst(law: Callable[[_Instant, float], Floats]) -> Callable[[Scene, Trajectory, Trajectory | None], float]:
    """A measure: the largest sum over the contacts of an instant of what breaks a law [N], over the weight.

    Args: law: (instant, slowest slip that counts [m/s]) to (k,) N.
    """

    def measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
        if actual.contacts is None:
            raise NotMeasurable("no contacts were recorded")
        if len(actual) == 0:
            raise NotMeasurable("no samples")
        g = float(np.linalg.norm(scene.gravity))
        weight = g * sum(body.mass for body in scene.bodies if body.movable)
        if weight == 0:
            raise NotMeasurable("nothing has weight")
        numbers = (array for c in actual.contacts for array in (c.force_W, c.normal_W, c.point_W, c.gap))
        if not actual.finite or not all(np.isfinite(array).all() for array in numbers):
            return math.nan
        found = [float(np.sum(law(instant, g * actual.dt))) for instant in _instants(scene, actual)]
        return max(found, default=0.0) / weight

    return measure


def _signorini(at: _Instant, slow: float) -> Floats:
    found: Floats = np.maximum(-at.normal, 0.0) + np.where(at.open > 0.0, np.maximum(at.normal, 0.0), 0.0)
    return found


def _cone(at: _Instant, slow: float) -> Floats:
    found: Floats = np.maximum(np.linalg.norm(at.tangent, axis=1) - at.static * np.maximum(at.normal, 0.0), 0.0)
    return found


def _dissipation(at: _Instant, slow: float) -> Floats:
    speed = np.linalg.norm(at.slip, axis=1)
    # What friction and weight can stop within a step is sticking at the step's resolution: no direction is judged there.
    slips = (speed > slow) & (speed > 0.0)
    due = at.kinetic * np.maximum(at.normal, 0.0)
    direction = at.slip / np.where(slips, speed, 1.0)[:, None]
    return np.where(slips, np.linalg.norm(at.tangent + due[:, None] * direction, axis=1), 0.0)


SIGNORINI_RESIDUAL = Metric(
    name="signorini_residual",
    unit="1",
    source="Moreau 1988: normal forces that pull, or act across a gap that the step cannot close, over the weight, at worst",
    measure=_worst(_signorini),
)
CONE_RESIDUAL = Metric(
    name="cone_residual",
    unit="1",
    source="Moreau 1988: tangential forces beyond mu_s N, over the weight, at worst",
    measure=_worst(_cone),
)
DISSIPATION_RESIDUAL = Metric(
    name="dissipation_residual",
    unit="1",
    source="Stewart 2000: |T + mu_k N u/|u|| of contacts that slip faster than g dt, over the weight, at worst",
    measure=_worst(_dissipation),
)

METRIC = (SIGNORINI_RESIDUAL, CONE_RESIDUAL, DISSIPATION_RESIDUAL)
