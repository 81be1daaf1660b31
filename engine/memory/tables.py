"""The tables that kernels work on, handed on as one thing: carved once where compiled code is entered, named from there on."""

from typing import NamedTuple

from engine.compile.jit import kernel
from engine.maths.vec import Floats, Ints
from engine.memory.arena import (
    BODY,
    BODY_KIND,
    LOAD,
    MANIFOLD,
    MANIFOLD_KEY,
    POINT,
    POINT_KEY,
    POSE,
    SHAPE,
    SHAPE_KIND,
    STATE,
    TURNED,
)
from engine.memory.carve import floats_of, ints_of

__all__ = ["Bodies", "Contacts", "Shapes", "bodies_of", "contacts_of", "shapes_of"]


class Bodies(NamedTuple):
    """What is known of every body: state, constants, inverse inertia in W, force and torque, and how it moves."""

    state: Floats
    body: Floats
    turned: Floats
    load: Floats
    kind: Ints


class Contacts(NamedTuple):
    """Manifolds and their points, four rows of points a manifold."""

    manifold: Floats
    point: Floats
    key: Ints
    point_key: Ints


class Shapes(NamedTuple):
    """Sizes, poses in W, and types of shapes."""

    shape: Floats
    pose: Floats
    kind: Ints


@kernel
def bodies_of(floats: Floats, ints: Ints) -> Bodies:
    """The tables of the bodies of an arena."""
    return Bodies(
        floats_of(floats, ints, STATE),
        floats_of(floats, ints, BODY),
        floats_of(floats, ints, TURNED),
        floats_of(floats, ints, LOAD),
        ints_of(ints, BODY_KIND),
    )


@kernel
def contacts_of(floats: Floats, ints: Ints) -> Contacts:
    """The tables of the contacts of an arena."""
    return Contacts(
        floats_of(floats, ints, MANIFOLD),
        floats_of(floats, ints, POINT),
        ints_of(ints, MANIFOLD_KEY),
        ints_of(ints, POINT_KEY),
    )


@kernel
def shapes_of(floats: Floats, ints: Ints) -> Shapes:
    """The tables of the shapes of an arena."""
    return Shapes(floats_of(floats, ints, SHAPE), floats_of(floats, ints, POSE), ints_of(ints, SHAPE_KIND))
