"""Checks of contact forces against motion: step by step they carry the momentum that the bodies gain, friction included."""

from math import inf

import numpy as np

from harness.adapter import Adapter, Feature, Settings
from harness.conformance.check import Finding, check, judge, near, that
from harness.conformance.runs import FINE, built, state_of
from harness.conformance.scenes import G, ball, on_ground
from harness.scene import Body
from harness.trajectory import Floats

_NEEDS = Feature.SPHERE | Feature.CONTACTS | Feature.CONTACT_FORCES
_LINE = 0.05
"""Share of the greatest change of momentum of a step that force and motion may differ by in any step: a damping of .04 a second
takes 1e-4 of the momentum itself in a step; a force of the step before is off by the whole of it, friction that is left out by
mu = .3 of it."""


def _momenta(
    adapter: Adapter, settings: Settings, body: Body, steps: int, friction: float, restitution: float
) -> tuple[Floats, Floats]:
    """What each step of a body of mass m above the ground gains, m dv (k, 3), and what its forces say, (F + m g) dt, [N s]."""
    scene = on_ground(adapter, body, friction=friction, restitution=restitution)
    gained, impulses = [], []
    with built(adapter, scene, settings.with_dt(FINE)) as simulation:
        before = state_of(simulation, scene).v_WB[1]
        for _ in range(steps):
            simulation.step()
            force = simulation.contacts().force_W.sum(axis=0) if len(simulation.contacts()) else np.zeros(3)
            after = state_of(simulation, scene).v_WB[1]
            gained.append(body.mass * (after - before))
            impulses.append((force + np.array([0.0, 0.0, -G * body.mass])) * FINE)
            before = after
    return np.array(gained), np.array(impulses)


def _balanced(what: str, gained: Floats, impulses: Floats) -> Finding:
    peak = float(np.abs(gained).max())
    worst = float(np.abs(gained - impulses).max()) / peak if peak > 0 else inf
    total = np.abs((gained - impulses).sum(axis=0)).max() / float(np.abs(gained).sum(axis=0).max())
    return judge(
        near(f"{what}: worst difference in a step of m dv and (F + m g) dt, over the greatest of them", worst, 0.0, _LINE),
        near(f"{what}: their difference over all steps, over the way of the momentum", total, 0.0, _LINE),
    )


@check("Is the contact force of each step what changes the momentum in that step, friction included?", _NEEDS, firm=True)
def contact_forces_move_what_they_touch(adapter: Adapter, settings: Settings) -> Finding:
    """A ball lands askew on a rough ground: its blow lasts some steps, its friction until it rolls."""
    landing = ball(p=(0.0, 0.0, 0.11), v=(1.0, 0.5, -1.0))
    return _balanced("landing", *_momenta(adapter, settings, landing, 60, 0.3, 0.0))


@check(
    "Do the contact forces of a rebound carry its momentum, and no more once it is over?",
    _NEEDS | Feature.RESTITUTION,
    firm=True,
)
def contact_forces_end_with_the_contact(adapter: Adapter, settings: Settings) -> Finding:
    """A ball bounces and flies on, and no force is said to act in its flight."""
    bouncing = ball(p=(0.0, 0.0, 0.11), v=(0.0, 0.0, -2.0))
    return _balanced("rebound", *_momenta(adapter, settings, bouncing, 100, 0.0, 0.5))


@check("Is the friction of a sliding contact mu times its normal force, to .15 %?", _NEEDS)
def sliding_contact_is_on_its_cone(adapter: Adapter, settings: Settings) -> Finding:
    """A sliding ball has one contact, whose friction is mu N and against the slip, to rounding in every engine tried.

    It slides until 2 v/(7 mu g) = .1 s; judged are the steps in contact of the first 60 ms.
    """
    comparisons = []
    for mu in (0.2, 0.8):
        scene = on_ground(adapter, ball(v=(3.0, 0.0, 0.0)), friction=mu)
        across, normal = np.zeros(3), 0.0
        with built(adapter, scene, settings.with_dt(FINE)) as simulation:
            for _ in range(60):
                simulation.step()
                got = simulation.contacts()
                along = (got.force_W * got.normal_W).sum(axis=1)
                across += (got.force_W - along[:, None] * got.normal_W).sum(axis=0)
                normal += float(along.sum())
        comparisons.append(that(normal > 0, f"normal force at mu {mu}: got {normal:.3g} N, expected above 0"))
        share = across / normal if normal > 0 else np.full(3, np.nan)
        comparisons.append(near(f"friction over normal force at mu {mu}", share, (-mu, 0, 0), 1.5e-3 * mu, "half of .3 %"))
    return judge(*comparisons)
