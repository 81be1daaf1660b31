"""Checks of what contacts say: normals and gaps pair by pair of shapes, and forces that carry the momentum bodies gain."""

from itertools import combinations_with_replacement
from math import inf

import numpy as np

from plumbline.harness.adapter import Feature, Unsupported
from plumbline.harness.conformance.check import Comparisons, check, firm, near, that
from plumbline.harness.conformance.engine import FINE, Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN
from plumbline.harness.conformance.scenes import G, ball, block, ground, on_ground, shaped, static, without_gravity
from plumbline.harness.scene import Body, Box, Capsule, Cylinder, Ellipsoid, Plane, Shape, Sphere, Vector3
from plumbline.harness.trajectory import Floats

_SHAPES: tuple[tuple[Feature, Shape, float], ...] = (
    (Feature.PLANE, Plane(), 0.0),
    (Feature.BOX, Box(half_extents=(0.2, 0.2, 0.2)), 0.2),
    (Feature.SPHERE, Sphere(radius=0.2), 0.2),
    (Feature.CAPSULE, Capsule(radius=0.1, half_length=0.1), 0.2),
    (Feature.CYLINDER, Cylinder(radius=0.2, half_length=0.2), 0.2),
    (Feature.ELLIPSOID, Ellipsoid(semi_axes=(0.15, 0.18, 0.2)), 0.2),
)
"""Shapes that can stand upright on each other, each with the height of its centre [m]."""
_DEEP = 0.004
"""By how much they overlap [m]: more than any engine's slop, less than a fiftieth of their size."""


def _upright(name: str, shape: Shape, p_WB: Vector3, material: str) -> Body:
    """A body of 1 kg of that shape, its axis upwards."""
    return shaped(name, shape, inertia=block().inertia, material=material, p_WB=p_WB)


@firm(
    "Do the contacts of every pair of shapes have their normal from A to B and the gap that the places say?",
    Feature.CONTACTS,
    nothing="the engine supports no pair of shapes that could touch",
)
def contacts_of_every_pair_of_shapes(engine: Engine) -> Comparisons:
    """Each shape stands in the middle of each other one, sunk in by 4 mm, without gravity; in the scene above and below.

    One step lies between the places before and after; the gap is one of theirs or between, whenever it was read.
    """
    claimed = [(shape, height) for feature, shape, height in _SHAPES if feature in engine.features]
    margin = 0.1 * _DEEP
    for (lower, low), (above, high) in combinations_with_replacement(claimed, 2):
        if isinstance(above, Plane):
            continue
        for first in (True, False):
            pair = f"{above.type} on {lower.type}, {'lower' if first else 'upper'} one first"
            base = static("base", lower) if isinstance(lower, Plane) else _upright("base", lower, ORIGIN, "ground")
            # Round on round touches at one point above the other's centre; a face does not mind where.
            aside = (0.0, 0.0) if {lower.type, above.type} <= {"sphere", "capsule", "ellipsoid"} else (0.01, 0.02)
            top = _upright("top", above, (*aside, low + high - _DEEP), "block")
            scene = without_gravity(*(base, top) if first else (top, base), surfaces=(ground(),))
            try:
                with engine.built(scene) as simulation:
                    simulation.step()
                    got, after = simulation.contacts(), state_of(simulation, scene)
            except Unsupported:
                continue
            up = 1.0 if first else -1.0
            opened = float(after.p_WB[1, 2] - after.p_WB[0, 2]) * up - (low + high)
            least, most = sorted((-_DEEP, opened))
            yield that(len(got) > 0, f"{pair}: got no contact, expected at least one")
            yield near(f"{pair}: upward part of the normals", got.normal_W[:, 2], np.full(len(got), up), 0.05)
            if len(got):
                deepest = float(got.gap.min())
                text = f"{pair}: gap of the deepest point: got {deepest:.5g} m, expected {least:.5g}..{most:.5g} m"
                yield that(least - margin <= deepest <= most + margin, f"{text}, a tenth of the depth granted")


_NEEDS = Feature.SPHERE | Feature.CONTACTS | Feature.CONTACT_FORCES
_LINE = 0.05
"""Share of the greatest change of momentum of a step that force and motion may differ by in any step: a damping of .04 a second
takes 1e-4 of the momentum itself in a step; a force of the step before is off by the whole of it, friction that is left out by
mu = .3 of it."""


def _momenta(engine: Engine, body: Body, steps: int, friction: float, restitution: float) -> tuple[Floats, Floats]:
    """What each step of a body of mass m above the ground gains, m dv (k, 3), and what its forces say, (F + m g) dt, [N s]."""
    scene = on_ground(engine, body, friction=friction, restitution=restitution)
    gained, impulses = [], []
    with engine.built(scene) as simulation:
        before = state_of(simulation, scene).v_WB[1]
        for _ in range(steps):
            simulation.step()
            force = simulation.contacts().force_W.sum(axis=0) if len(simulation.contacts()) else np.zeros(3)
            after = state_of(simulation, scene).v_WB[1]
            gained.append(body.mass * (after - before))
            impulses.append((force + np.array([0.0, 0.0, -G * body.mass])) * FINE)
            before = after
    return np.array(gained), np.array(impulses)


def _balanced(what: str, gained: Floats, impulses: Floats) -> Comparisons:
    peak = float(np.abs(gained).max())
    greatest = float(np.abs(gained - impulses).max()) / peak if peak > 0 else inf
    total = np.abs((gained - impulses).sum(axis=0)).max() / float(np.abs(gained).sum(axis=0).max())
    yield near(f"{what}: worst difference in a step of m dv and (F + m g) dt, over the greatest of them", greatest, 0.0, _LINE)
    yield near(f"{what}: their difference over all steps, over the way of the momentum", total, 0.0, _LINE)


@firm("Is the contact force of each step what changes the momentum in that step, friction included?", _NEEDS)
def contact_forces_move_what_they_touch(engine: Engine) -> Comparisons:
    """A ball lands askew on a rough ground: its blow lasts some steps, its friction until it rolls."""
    landing = ball(p=(0.0, 0.0, 0.11), v=(1.0, 0.5, -1.0))
    return _balanced("landing", *_momenta(engine, landing, 60, 0.3, 0.0))


@firm("Do the contact forces of a rebound carry its momentum, and no more once it is over?", _NEEDS | Feature.RESTITUTION)
def contact_forces_end_with_the_contact(engine: Engine) -> Comparisons:
    """A ball bounces and flies on, and no force is said to act in its flight."""
    bouncing = ball(p=(0.0, 0.0, 0.11), v=(0.0, 0.0, -2.0))
    return _balanced("rebound", *_momenta(engine, bouncing, 100, 0.0, 0.5))


@check("Is the friction of a sliding contact mu times its normal force, to .15 %?", _NEEDS)
def sliding_contact_is_on_its_cone(engine: Engine) -> Comparisons:
    """A sliding ball has one contact, whose friction is mu N and against the slip, to rounding in every engine tried.

    It slides until 2 v/(7 mu g) = .1 s; judged are the steps in contact of the first 60 ms.
    """
    for mu in (0.2, 0.8):
        scene = on_ground(engine, ball(v=(3.0, 0.0, 0.0)), friction=mu)
        across, normal = np.zeros(3), 0.0
        with engine.built(scene) as simulation:
            for _ in range(60):
                simulation.step()
                got = simulation.contacts()
                along = (got.force_W * got.normal_W).sum(axis=1)
                across += (got.force_W - along[:, None] * got.normal_W).sum(axis=0)
                normal += float(along.sum())
        yield that(normal > 0, f"normal force at mu {mu}: got {normal:.3g} N, expected above 0")
        share = across / normal if normal > 0 else np.full(3, np.nan)
        yield near(f"friction over normal force at mu {mu}", share, (-mu, 0, 0), 1.5e-3 * mu, "half of .3 %")
