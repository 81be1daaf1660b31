"""The tables of the stages of contact, handed on as one thing: the pairs, the laws, and the manifolds of the last step."""

from typing import NamedTuple

from plumbline.engine.compile.jit import inlined
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of


class Pairs(NamedTuple):
    """The pairs of shapes of a step, and the answers of the convex narrow phase.

    Terms: pair: two shapes; points: their number; normal: from A to B; point, point_key: points and features, four rows a pair.
    """

    pair: Ints
    points: Ints
    normal: Floats
    point: Floats
    point_key: Ints


class Rules(NamedTuple):
    """The settings and the numbers of a world, and the law of each pair of materials."""

    setting: Floats
    numbers: Ints
    surface: Floats


class OldContacts(NamedTuple):
    """The manifolds of the last step and their points, and for each shape the list of those of which it is the first."""

    manifold: Floats
    point: Floats
    key: Ints
    point_key: Ints
    head: Ints
    following: Ints


@inlined
def pairs_of(floats: Floats, ints: Ints) -> Pairs:
    """The pairs of an arena."""
    return Pairs(
        ints_of(ints, at.PAIR),
        ints_of(ints, at.CONVEX_KEY),
        floats_of(floats, ints, at.CONVEX_NORMAL),
        floats_of(floats, ints, at.CONVEX_POINT),
        ints_of(ints, at.CONVEX_POINT_KEY),
    )


@inlined
def rules_of(floats: Floats, ints: Ints) -> Rules:
    """The settings and laws of an arena."""
    return Rules(floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT), floats_of(floats, ints, at.SURFACE))


@inlined
def old_contacts_of(floats: Floats, ints: Ints) -> OldContacts:
    """The contacts that an arena keeps of the last step."""
    return OldContacts(
        floats_of(floats, ints, at.OLD_MANIFOLD),
        floats_of(floats, ints, at.OLD_POINT),
        ints_of(ints, at.OLD_KEY),
        ints_of(ints, at.OLD_POINT_KEY),
        ints_of(ints, at.HEAD),
        ints_of(ints, at.NEXT),
    )
