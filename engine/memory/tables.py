"""The tables that kernels work on, handed on as one thing: carved once where compiled code is entered, named from there on."""

from typing import NamedTuple

from plumbline.engine.compile.jit import inlined
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of


class Bodies(NamedTuple):
    """What is known of every body: state, constants, inverse inertia in W, force and torque, and how it moves."""

    state: Floats
    body: Floats
    turned: Floats
    load: Floats
    kind: Ints


class Contacts(NamedTuple):
    """Manifolds and their points, four rows of points a manifold; and in which order (k, 1) which of them are visited."""

    manifold: Floats
    point: Floats
    key: Ints
    point_key: Ints
    order: Ints


class Shapes(NamedTuple):
    """Sizes, poses in W, and types of shapes."""

    shape: Floats
    pose: Floats
    kind: Ints


class Joints(NamedTuple):
    """What is known of every joint: its constants and coordinate, its kind with its bodies; and, as of contacts, an order."""

    joint: Floats
    kind: Ints
    order: Ints


class Rows(NamedTuple):
    """The scalar constraints of joints, J v = ..., and the equations for their impulses.

    Terms: row: J, gap, curvature, softness, bias, bounds; body: A and B; reach: M^-1 J^T; matrix: J M^-1 J^T + softness;
    factor: of the matrix, by Cholesky; vector: impulses, right-hand sides and marks, one number a row each.
    """

    row: Floats
    body: Ints
    reach: Floats
    matrix: Floats
    factor: Floats
    vector: Floats


@inlined
def bodies_of(floats: Floats, ints: Ints) -> Bodies:
    """The tables of the bodies of an arena."""
    return Bodies(
        floats_of(floats, ints, at.STATE),
        floats_of(floats, ints, at.BODY),
        floats_of(floats, ints, at.TURNED),
        floats_of(floats, ints, at.LOAD),
        ints_of(ints, at.BODY_KIND),
    )


@inlined
def contacts_of(floats: Floats, ints: Ints) -> Contacts:
    """The tables of the contacts of an arena."""
    return Contacts(
        floats_of(floats, ints, at.MANIFOLD),
        floats_of(floats, ints, at.POINT),
        ints_of(ints, at.MANIFOLD_KEY),
        ints_of(ints, at.POINT_KEY),
        ints_of(ints, at.MANIFOLD_ORDER),
    )


@inlined
def present_contacts(floats: Floats, ints: Ints) -> Contacts:
    """The contacts of this step, once they are found."""
    return some_contacts(contacts_of(floats, ints), 0, ints_of(ints, at.COUNT)[0, at.MANIFOLDS])


@inlined
def in_order(contacts: Contacts, order: Ints) -> Contacts:
    """Those of an order (k, 1) alone."""
    return Contacts(contacts.manifold, contacts.point, contacts.key, contacts.point_key, order)


@inlined
def some_contacts(contacts: Contacts, first: int, end: int) -> Contacts:
    """Those of ranks first..end - 1 alone."""
    return in_order(contacts, contacts.order[first:end])


@inlined
def shapes_of(floats: Floats, ints: Ints) -> Shapes:
    """The tables of the shapes of an arena."""
    return Shapes(floats_of(floats, ints, at.SHAPE), floats_of(floats, ints, at.POSE), ints_of(ints, at.SHAPE_KIND))


@inlined
def joints_of(floats: Floats, ints: Ints) -> Joints:
    """The tables of the joints of an arena."""
    return Joints(floats_of(floats, ints, at.JOINT), ints_of(ints, at.JOINT_KIND), ints_of(ints, at.JOINT_ORDER))


@inlined
def rows_of(floats: Floats, ints: Ints) -> Rows:
    """The tables of the rows of an arena."""
    return Rows(
        floats_of(floats, ints, at.ROW),
        ints_of(ints, at.ROW_BODY),
        floats_of(floats, ints, at.REACH),
        floats_of(floats, ints, at.MATRIX),
        floats_of(floats, ints, at.FACTOR),
        floats_of(floats, ints, at.VECTOR),
    )


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
