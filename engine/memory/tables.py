"""The tables that kernels work on, handed on as one thing: carved once where compiled code is entered, named from there on."""

from typing import Annotated, NamedTuple

from plumbline.engine.compile.jit import inlined
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import carved, ints_of


class Bodies(NamedTuple):
    """What is known of every body: state, constants, inverse inertia in W, force and torque, and how it moves."""

    state: Annotated[Floats, at.STATE]
    body: Annotated[Floats, at.BODY]
    turned: Annotated[Floats, at.TURNED]
    load: Annotated[Floats, at.LOAD]
    kind: Annotated[Ints, at.BODY_KIND]


class Contacts(NamedTuple):
    """Manifolds and their points, four rows of points a manifold; and in which order (k, 1) which of them are visited."""

    manifold: Annotated[Floats, at.MANIFOLD]
    point: Annotated[Floats, at.POINT]
    key: Annotated[Ints, at.MANIFOLD_KEY]
    point_key: Annotated[Ints, at.POINT_KEY]
    order: Annotated[Ints, at.MANIFOLD_ORDER]


class OldContacts(NamedTuple):
    """The manifolds of the last step and their points, and for each shape the list of those of which it is the first."""

    manifold: Annotated[Floats, at.OLD_MANIFOLD]
    point: Annotated[Floats, at.OLD_POINT]
    key: Annotated[Ints, at.OLD_KEY]
    point_key: Annotated[Ints, at.OLD_POINT_KEY]
    head: Annotated[Ints, at.HEAD]
    following: Annotated[Ints, at.NEXT]


class Shapes(NamedTuple):
    """Sizes, poses in W, and types of shapes."""

    shape: Annotated[Floats, at.SHAPE]
    pose: Annotated[Floats, at.POSE]
    kind: Annotated[Ints, at.SHAPE_KIND]


class Pairs(NamedTuple):
    """The pairs of shapes of a step, and the answers of the convex narrow phase.

    Terms: pair: two shapes; points: their number; normal: from A to B; point, point_key: points and features, four rows a pair.
    """

    pair: Annotated[Ints, at.PAIR]
    points: Annotated[Ints, at.CONVEX_KEY]
    normal: Annotated[Floats, at.CONVEX_NORMAL]
    point: Annotated[Floats, at.CONVEX_POINT]
    point_key: Annotated[Ints, at.CONVEX_POINT_KEY]


class Rules(NamedTuple):
    """The settings and the numbers of a world, and the law of each pair of materials."""

    setting: Annotated[Floats, at.SETTING]
    numbers: Annotated[Ints, at.COUNT]
    surface: Annotated[Floats, at.SURFACE]


class Joints(NamedTuple):
    """What is known of every joint: its constants and coordinate, its kind with its bodies; and, as of contacts, an order."""

    joint: Annotated[Floats, at.JOINT]
    kind: Annotated[Ints, at.JOINT_KIND]
    order: Annotated[Ints, at.JOINT_ORDER]


class Rows(NamedTuple):
    """The scalar constraints of joints, J v = ..., and the equations for their impulses.

    Terms: row: J, gap, curvature, softness, bias, bounds; body: A and B; reach: M^-1 J^T; matrix: J M^-1 J^T + softness;
    factor: of the matrix, by Cholesky; vector: impulses, right-hand sides and marks, one number a row each.
    """

    row: Annotated[Floats, at.ROW]
    body: Annotated[Ints, at.ROW_BODY]
    reach: Annotated[Floats, at.REACH]
    matrix: Annotated[Floats, at.MATRIX]
    factor: Annotated[Floats, at.FACTOR]
    vector: Annotated[Floats, at.VECTOR]


bodies_of, contacts_of, old_contacts_of, shapes_of = carved(Bodies), carved(Contacts), carved(OldContacts), carved(Shapes)
pairs_of, rules_of, joints_of, rows_of = carved(Pairs), carved(Rules), carved(Joints), carved(Rows)


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
