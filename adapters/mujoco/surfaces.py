"""The law of contact: what MuJoCo is told of each pair of materials, and which pairs priorities of geoms can tell."""

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from plumbline.adapters.mujoco.options import Options
from plumbline.adapters.mujoco.rebound import elastic
from plumbline.adapters.mujoco.softness import friction_constant, impedance, time_constant
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.touching_kinds import touching_kinds
from plumbline.harness.scene import Effect, Scene, Surface

REBOUND_IMPEDANCE = 0.9999
"""Impedance of a contact that rebounds: its reference acceleration is taken as it is, with next to nothing of gravity."""


@dataclass(frozen=True, slots=True)
class Law:
    """A pair's contact in MuJoCo's words: friction is (slide, torsion, roll); solref_friction None: as solref."""

    condim: int
    friction: tuple[float, float, float]
    solref: tuple[float, float]
    solimp: tuple[float, ...] | None
    solref_friction: tuple[float, float] | None = None


def contact_law(surface: Surface, effects: Effect, options: Options, h: float, integrator: str | None) -> Law:
    """The contact of one pair of materials. Raises: Unsupported."""
    where = "/".join(surface.between)
    slide = surface.kinetic_friction if Effect.FRICTION in effects else 0.0
    torsion = surface.torsional_friction if Effect.TORSIONAL_FRICTION in effects else 0.0
    roll = surface.rolling_friction if Effect.ROLLING_FRICTION in effects else 0.0
    if Effect.FRICTION in effects and surface.static_friction != surface.kinetic_friction:
        raise Unsupported(
            f"surface {where}: static friction {surface.static_friction:g} above kinetic friction {surface.kinetic_friction:g}",
            "MuJoCo has one coefficient of sliding friction",
        )
    condim = 6 if roll > 0 else 4 if torsion > 0 else 3 if slide > 0 else 1
    e = surface.restitution if Effect.RESTITUTION in effects else 0.0
    if e > 0:
        if integrator == "discrete":
            raise Unsupported(f"surface {where}: restitution under the discrete integrator", "it damps every rebound")
        # The four stages of Runge and Kutta follow the continuous law, which many fine steps stand for.
        solref = elastic(e, h, options.rebound_steps, 16 if integrator == "rk4" else 1)
        # Friction has a reference of its own, whatever the rebound, by default as slow as the impact lasts: e^-2 of a slip that
        # could be stopped is left. A faster one stops more of it and, on the cone, bends the rebound the more (see Deviations).
        steps = options.rebound_steps if options.friction_steps is None else options.friction_steps
        firm = (steps * h, 1.0) if condim > 1 else None
        return Law(condim, (slide, torsion, roll), solref, impedance(REBOUND_IMPEDANCE), firm)
    constant = time_constant(options.contact_steps, h, options.slowest)
    solimp = None if options.contact_impedance is None else impedance(options.contact_impedance)
    own = friction_constant(options, h) if condim > 1 else None
    firm = None if own is None else (own, 1.0)
    return Law(condim, (slide, torsion, roll), (constant, options.contact_damping_ratio or 1.0), solimp, firm)


def contact_laws(
    scene: Scene,
    effects: Effect,
    options: Options,
    h: float,
    integrator: str | None,
    pressed: Container[frozenset[str]] = frozenset(),
) -> dict[frozenset[str], Law]:
    """The contact of each pair of materials of which two bodies can touch, in steps of h [s]. Raises: Unsupported.

    Args: pressed: the pairs that take `fast_steps`.
    """
    if Effect.CONTACT not in effects:
        return {}
    met = {frozenset((a[0], b[0])) for a, b in touching_kinds(scene)}
    known: dict[Surface, Law] = {}
    laws = {}
    for surface in scene.surfaces:
        if surface.pair not in met:
            continue
        if surface not in known:
            told = replace(options, contact_steps=options.fast_steps) if surface.pair in pressed else options
            known[surface] = contact_law(surface, effects, told, h, integrator)
        laws[surface.pair] = known[surface]
    return laws


def ranked(laws: Mapping[frozenset[str], Law], materials: Sequence[str]) -> tuple[dict[str, tuple[int, Law]], list[str]]:
    """Priorities that make MuJoCo's rule (the geom of higher priority decides) give each pair its own law.

    A material qualifies when all its laws with the materials below it are the same; taking any that qualifies is complete,
    since it still qualifies among fewer. Those that are left need explicit pairs, as does a law with a reference for friction.
    """
    left, ranks = list(materials), {}
    while left:
        for a in left:
            own = {laws[pair] for b in left if (pair := frozenset((a, b))) in laws}
            if len(own) <= 1 and all(law.solref_friction is None for law in own):
                ranks[a] = (len(left), next(iter(own), None))
                left.remove(a)
                break
        else:
            break
    return {a: (rank, law) for a, (rank, law) in ranks.items() if law is not None}, left


def tell_surface(geom: Any, law: Law) -> None:
    """Give a geom, or a pair of geoms, the law but its friction."""
    geom.condim, geom.solref = law.condim, law.solref
    if law.solimp is not None:
        geom.solimp = law.solimp
