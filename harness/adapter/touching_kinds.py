"""The kinds of body that can touch, with the law of contact of each pair, and numbers of kinds that make such laws."""

from collections.abc import Mapping

import numpy as np

from plumbline.harness.scene import Scene, Surface

Kind = tuple[str, bool]
"""A material, and whether the bodies of it move: what stands still may be given another number than what moves."""


def kinds_of(scene: Scene) -> dict[Kind, int]:
    """How many bodies with shapes there are of each kind, kinds in the order of the scene's bodies."""
    kinds: dict[Kind, int] = {}
    for body in scene.bodies:
        if body.collision:
            kinds[body.material, body.movable] = kinds.get((body.material, body.movable), 0) + 1
    return kinds


def touching_kinds(scene: Scene) -> dict[tuple[Kind, Kind], Surface]:
    """The law of each pair (a, b) of kinds, a <= b, of which two bodies can touch; kinds in the order of the scene's bodies.

    One of the two moves, the materials do not stand apart, and a kind meets itself where two bodies are of it. Joints between
    single bodies do not count.
    """
    bodies = kinds_of(scene)
    laws, apart = {law.pair: law for law in scene.surfaces}, {frozenset(pair) for pair in scene.apart}
    return {
        (a, b): laws[frozenset((a[0], b[0]))]
        for a in bodies
        for b in bodies
        if a <= b and (a[1] or b[1]) and (a != b or bodies[a] > 1) and frozenset((a[0], b[0])) not in apart
    }


def mean_numbers(pairs: Mapping[tuple[Kind, Kind], Surface], name: str) -> tuple[dict[Kind, float], Surface | None]:
    """Numbers r >= 0, one for each kind, with (r_a + r_b)/2 = the value of each pair, for an engine that takes means.

    Args: name: of the value, a field of `Surface`. Returns: the numbers, and the law that they miss most, if any.
    """
    from scipy.optimize import nnls

    kinds = sorted({kind for pair in pairs for kind in pair})
    if not kinds:
        return {}, None
    shares, values = np.zeros((len(pairs), len(kinds))), np.array([getattr(law, name) for law in pairs.values()])
    for row, (a, b) in enumerate(pairs):
        shares[row, kinds.index(a)] += 0.5
        shares[row, kinds.index(b)] += 0.5
    numbers = np.linalg.lstsq(shares, values, rcond=None)[0]
    if numbers.min() < 0:
        numbers, _ = nnls(shares, values)
    off = np.abs(shares @ numbers - values)
    missed = list(pairs.values())[int(off.argmax())] if off.max() > 1e-9 * max(1.0, values.max()) else None
    return dict(zip(kinds, numbers.tolist(), strict=True)), missed
