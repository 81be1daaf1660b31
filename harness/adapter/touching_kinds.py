"""The kinds of body that can touch, with the law of contact of each pair of kinds."""

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
