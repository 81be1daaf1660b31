"""Friction and restitution: numbers for each material by which DART's rules give the law of every pair."""

import math
from collections import deque
from collections.abc import Mapping

from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.touching_kinds import Kind, kinds_of, touching_kinds
from plumbline.harness.scene import Body, Effect, Scene

SMALLEST_COEFFICIENT = 1e-3
"""DART_FRICTION_COEFF_THRESHOLD and DART_RESTITUTION_COEFF_THRESHOLD: what is not above counts as zero."""


def coefficients(scene: Scene) -> dict[Kind, tuple[float, float]]:
    """(friction, restitution) for each (material, movable) so that DART's rules give every pair's law exactly.

    Friction: min(f_a, f_b) = mu_ab has a solution only if f_a = max over b of mu_ab is one. Restitution: r_a r_b = e_ab.
    Raises: Unsupported.
    """
    effects, kinds = scene.effects, kinds_of(scene)
    friction: dict[tuple[Kind, Kind], float] = {}
    bounce: dict[tuple[Kind, Kind], float] = {}
    for (a, b), law in touching_kinds(scene).items():
        name = f"surface {law.between[0]}/{law.between[1]}"
        if Effect.ROLLING_FRICTION in effects and law.rolling_friction > 0:
            raise Unsupported(name, "DART has no rolling friction")
        if Effect.TORSIONAL_FRICTION in effects and law.torsional_friction > 0:
            raise Unsupported(name, "DART has no torsional friction")
        mu = law.kinetic_friction if Effect.FRICTION in effects else 0.0
        if Effect.FRICTION in effects and law.static_friction > law.kinetic_friction:
            raise Unsupported(name, f"DART has one coefficient, not static {law.static_friction} above kinetic {mu}")
        e = law.restitution if Effect.RESTITUTION in effects else 0.0
        for what, value in (("friction", mu), ("restitution", e)):
            if 0 < value <= SMALLEST_COEFFICIENT:
                raise Unsupported(name, f"DART takes a {what} of {SMALLEST_COEFFICIENT} and less for zero, got {value}")
        friction[a, b], bounce[a, b] = mu, e
    f = {kind: max((mu for pair, mu in friction.items() if kind in pair), default=0.0) for kind in kinds}
    for (a, b), mu in friction.items():
        if min(f[a], f[b]) != mu:
            raise Unsupported(
                f"surface {a[0]}/{b[0]}",
                f"DART takes the smaller of two numbers, one for each material; none give {mu} here beside the others",
            )
    r = _factors(kinds, bounce)
    return {kind: (f[kind], r[kind]) for kind in kinds}


def _factors(kinds: Mapping[Kind, int], wanted: Mapping[tuple[Kind, Kind], float]) -> dict[Kind, float]:
    """Numbers r in 0..1 with r_a r_b = e for each wanted pair. Raises: Unsupported.

    Over each connected part of the graph of pairs log r_a = s t + o with s = +-1; t is free unless a cycle is odd.
    """
    near: dict[Kind, list[tuple[Kind, float]]] = {kind: [] for kind in kinds}
    for (a, b), e in wanted.items():
        if e > 0:
            near[a].append((b, math.log(e)))
            near[b].append((a, math.log(e)))
    r: dict[Kind, float] = {}
    for start in kinds:
        if start in r:
            continue
        if not near[start]:
            r[start] = 0.0
            continue
        line: dict[Kind, tuple[float, float]] = {start: (1.0, 0.0)}
        fixed: float | None = None
        queue = deque([start])
        while queue:
            a = queue.popleft()
            s, o = line[a]
            for b, log_e in near[a]:
                if b not in line:
                    line[b] = (-s, log_e - o)
                    queue.append(b)
                elif line[b][0] == s:
                    fixed = (log_e - o - line[b][1]) / (2 * s)
        low = max((o for s, o in line.values() if s < 0), default=-math.inf)
        high = min(-o for s, o in line.values() if s > 0)
        t = fixed if fixed is not None else (low + high) / 2
        for kind, (s, o) in line.items():
            r[kind] = min(math.exp(s * t + o), 1.0)
    for (a, b), e in wanted.items():
        if abs(r[a] * r[b] - e) > 1e-12:
            raise Unsupported(
                f"surface {a[0]}/{b[0]}",
                f"DART multiplies two numbers in 0..1, one for each material; none give {e} here beside the others",
            )
    return r


def touching_bodies(scene: Scene) -> list[Body]:
    """The bodies that can touch others: those with shapes, if the scene has contacts."""
    return [b for b in scene.bodies if b.collision] if Effect.CONTACT in scene.effects else []
