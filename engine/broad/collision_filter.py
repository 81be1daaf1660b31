"""Which pairs of shapes never touch, whatever their bounds."""

from typing import NamedTuple

from plumbline.engine.compile.jit import inlined, kernel
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of


class CollisionFilter(NamedTuple):
    """What decides whether two shapes may touch.

    Terms: kind: motion of bodies; shape_kind: owner and material of shapes; surface: law of each pair of materials; excluded:
    pairs of bodies that a joint keeps apart.
    """

    kind: Ints
    shape_kind: Ints
    surface: Floats
    materials: int
    excluded: Ints
    exclusions: int


@kernel
def collision_filter_of(floats: Floats, ints: Ints) -> CollisionFilter:
    """The filter of an arena."""
    count = ints_of(ints, at.COUNT)
    return CollisionFilter(
        ints_of(ints, at.BODY_KIND),
        ints_of(ints, at.SHAPE_KIND),
        floats_of(floats, ints, at.SURFACE),
        count[0, at.MATERIALS],
        ints_of(ints, at.EXCLUDED),
        count[0, at.EXCLUSIONS],
    )


@inlined
def kept_apart(rules: CollisionFilter, i: int, j: int) -> bool:
    """Whether shapes i and j never touch: neither can move, or they belong to one body, or a joint or material parts them."""
    a, b = rules.shape_kind[i, at.OWNER], rules.shape_kind[j, at.OWNER]
    if a == b or (rules.kind[a, at.MOTION] != at.DYNAMIC and rules.kind[b, at.MOTION] != at.DYNAMIC):
        return True
    if rules.surface[rules.shape_kind[i, at.MATERIAL] * rules.materials + rules.shape_kind[j, at.MATERIAL], at.APART] == 1.0:
        return True
    for e in range(rules.exclusions):
        one, two = rules.excluded[e, 0], rules.excluded[e, 1]
        if (one == a and two == b) or (one == b and two == a):
            return True
    return False
