"""Maximal or multibody coordinates: which of the two a body without joints is put in."""

import math

from plumbline.adapters.bullet.ground import faced
from plumbline.adapters.bullet.plan import Plan
from plumbline.adapters.bullet.straight import goes_straight
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import Body, Effect

FAST_TURN = 0.05
"""The angle [rad] a step beyond which a body of uneven inertia stays out of multibody coordinates: from 0.1 on it explodes."""


def maximal(plan: Plan, place: int) -> bool:
    """Is this body without joints put in maximal coordinates? As the option prefers, unless an effect decides.

    Raises: Unsupported.
    """
    body = plan.scene.bodies[place]
    needed = "damping" if damping_of(plan, body) is not None else "continuous collision" if plan.swept and body.movable else ""
    braked = (body.material, body.movable) in plan.braked and body.movable
    if needed and braked:
        raise Unsupported(
            f"{needed} with rolling or torsional friction on body '{body.name}'",
            "Bullet has the one in maximal coordinates alone, where it brakes at one contact of each pair only",
        )
    if needed or body.motion == "kinematic":
        return True
    preferred = plan.options["coordinates"]
    return not braked and preferred != "multibody" and not (preferred == "scene" and _rubs(plan, place))


def _rubs(plan: Plan, place: int) -> bool:
    """May this body slide, and are multibody coordinates, which bound friction by a cone, safe and right for it?"""
    body, moments = plan.scene.bodies[place], plan.principal[place][0]
    law, even = plan.coefficients(body), max(moments) <= min(moments) * (1 + 1e-12)
    turned = math.hypot(*body.w_WB) * plan.h
    if not plan.sliding or law.friction == 0 or law.restitution > 0 or not (even or turned <= FAST_TURN):
        return False
    return not faced(body) or goes_straight(plan.scene, body)


def damping_of(plan: Plan, body: Body) -> dict[str, float] | None:
    """Bullet's coefficients b = 1 - exp(-c) in maximal coordinates: v (1 - b)^dt = v exp(-c dt). None: no damping."""
    wanted = {}
    for effect, name, key in (
        (Effect.LINEAR_DAMPING, "linear_damping", "linearDamping"),
        (Effect.ANGULAR_DAMPING, "angular_damping", "angularDamping"),
    ):
        rate = getattr(body, name)
        if body.movable and effect in plan.effects and rate > 0:
            wanted[key] = -math.expm1(-rate)
    return wanted or None
