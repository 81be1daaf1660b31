"""A sub-step of semi-implicit Euler in joint coordinates with soft contacts, and with joints that close loops.

    T(q)^T (M (x(q + h q') - x(q)) - h P - h^2 f) = h^2 (what acts along coordinates) + h T^T (impulses of contacts)

The impulses of the last sub-step go into that solve as forces, so that a tree at rest is answered once. What the sweeps change
of them is answered by the same articulated inertia, to rounding; G, by which sweeps see it coming, is that of the start of the
step. Laws that break, limits and dry friction in joints, are settled anew under the impulses of the sweeps, and the contacts
swept again where that changes what a joint does: both hold together at the end. Loops are solved directly after each sweep, and
G is written for every sub-step there. The relaxing sweeps change momenta alone, along the tangent of the start. Bends are
products of two turns: where machines stand, they are written and not answered.

Source: as `engine.articulated.semi_implicit_euler` and `engine.respond.soft`; Featherstone, Rigid Body Dynamics Algorithms,
2008, chapter 11.
"""

from typing import Final, NamedTuple

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import add_reactions, carry_bases, drift_coordinates
from plumbline.engine.articulated.articulated_body import answer_forces
from plumbline.engine.articulated.bounded import MOST_TURNS, are_settled, settle_laws, start_again, start_laws
from plumbline.engine.articulated.contact_sweeps import start_warm, sweep_trees, write_mobilities
from plumbline.engine.articulated.laws import PRESSED, write_laws
from plumbline.engine.articulated.loops import count_loop_rows, hold_loops, write_loop_matrix, write_loops
from plumbline.engine.articulated.momenta import centre_velocity, go_on_bending, keep_momenta, put_force
from plumbline.engine.articulated.motion import move_links
from plumbline.engine.articulated.responses import BODY, LINK, NOWHERE, Touched, write_free_responses, write_responses
from plumbline.engine.articulated.secants import bend_links
from plumbline.engine.articulated.semi_implicit_euler import close_bends, take_changes
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.articulated.tendons import write_tendons
from plumbline.engine.compile.jit import kernel
from plumbline.engine.integrate.semi_implicit_euler import drift, kick
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, load4, store3, store4
from plumbline.engine.maths.vec import add, axpy, cross, quat_mul, quat_unit, scale
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Contacts, Joints, Rows, Shapes
from plumbline.engine.respond.arms import refresh
from plumbline.engine.respond.share_loads import share_loads
from plumbline.engine.respond.softness import FRESH, PRESS, REBOUND, RELAX, Softness, slow_approach
from plumbline.engine.respond.substep import approach, bounce, end_substep, friction_mode

ROUNDS: Final = 4
"""Times at most that laws and contacts are settled in turns in a sub-step. A stop that is struck takes two."""

UNSEEN: Final = 1e-17
"""The square of a turn [rad] in a sub-step up to which its bends change no coordinate: below a tenth of the rounding of one."""

UNKNOWN: Final = -1.0
"""In place of the segment of a column whose responses are not written."""


class Mechanisms(NamedTuple):
    """The trees of a world, its bodies, joints and shapes, its contacts and what these move, rows for its loops or None.

    Terms: firm: the softness of contacts under links.
    """

    tables: Tables
    bodies: Bodies
    joints: Joints
    shapes: Shapes
    contacts: Contacts
    touched: Touched
    rows: Rows | None
    firm: Softness


@kernel
def forget_responses(tables: Tables) -> None:
    """Let the responses at hand be written anew."""
    for k in range(tables.stage_rate.shape[0]):
        tables.stage_rate[k, tree.ANSWERED] = UNKNOWN


@kernel
def are_answered(tables: Tables) -> bool:
    """Whether the responses at hand are those of the segments that all columns and tendons are on."""
    others, ties = 0, tables.follower.shape[0]
    for k in range(tables.stage_rate.shape[0]):
        others += tables.stage_rate[k, tree.ANSWERED] != tables.law[k, tree.SEGMENT]
    for n in range(tables.tendon.shape[0]):
        others += tables.tie[ties + n, tree.ON] != tables.law[tables.column.shape[0] + n, tree.SEGMENT]
    return others == 0


@kernel
def show_velocities(mechanisms: Mechanisms, kick_by: Vec, h: float) -> None:
    """Write the velocities of the touched links to their bodies, with a kick [m/s] and h times their accelerations."""
    tables, touched, state = mechanisms.tables, mechanisms.touched, mechanisms.bodies.state
    motion, passage = tables.motion, tables.passage
    for k in range(touched.kind.shape[0]):
        i, b = touched.kind[k, LINK], touched.kind[k, BODY]
        if i == NOWHERE:
            continue
        a_w = load3(motion, i, tree.ACCELERATION)
        a = add(load3(motion, i, tree.ACCELERATION + 3), cross(a_w, load3(motion, i, tree.PLACE)))
        v = add(add(centre_velocity(tables, i), load3(passage, i, tree.BEND + 3)), kick_by)
        w = add(load3(motion, i, tree.VELOCITY), load3(passage, i, tree.BEND))
        store3(state, b, at.V, v if h == 0.0 else axpy(h, a, v))
        store3(state, b, at.W, w if h == 0.0 else axpy(h, a_w, w))


@kernel
def place_links(mechanisms: Mechanisms) -> None:
    """Write the poses at the end of the sub-step of the touched links to their bodies."""
    tables, touched, state = mechanisms.tables, mechanisms.touched, mechanisms.bodies.state
    motion, passage = tables.motion, tables.passage
    for k in range(touched.kind.shape[0]):
        i, b = touched.kind[k, LINK], touched.kind[k, BODY]
        if i != NOWHERE:
            start = add(load3(motion, tables.kind[i, tree.ROOT], tree.ORIGIN), load3(motion, i, tree.PLACE))
            store3(state, b, at.P, add(start, load3(passage, i, tree.WAY)))
            store4(state, b, at.Q, quat_unit(quat_mul(load4(passage, i, tree.TURNING), load4(motion, i, tree.ORIENTATION))))


@kernel
def press_by_given(mechanisms: Mechanisms) -> None:
    """Count what links were given towards what contacts give them in this sub-step."""
    touched, stage = mechanisms.touched, mechanisms.tables.stage
    for k in range(touched.kind.shape[0]):
        for c in range(6):
            if touched.kind[k, LINK] != NOWHERE:
                stage[touched.kind[k, LINK], tree.PRESSURE + c] += touched.given[k, c]
            touched.given[k, c] = 0.0


@kernel
def answer_given(mechanisms: Mechanisms, h: float, reactions: bool) -> None:
    """Change all rates by the impulses that links were given beside the forces of the last solve."""
    tables, touched = mechanisms.tables, mechanisms.touched
    for i in range(tables.body.shape[0]):
        for c in range(6):
            tables.body[i, tree.FORCE + c] = 0.0
    links = 0
    for k in range(touched.kind.shape[0]):
        i = touched.kind[k, LINK]
        if i != NOWHERE:
            links += 1
            put_force(tables, i, scale(-1.0 / h, load3(touched.given, k, 3)), scale(-1.0 / h, load3(touched.given, k, 0)))
        for c in range(6):
            touched.given[k, c] = 0.0
    if links == 0:
        return
    answer_forces(tables, h)
    if reactions:
        add_reactions(tables, mechanisms.joints, h)


@kernel
def sweep_all(mechanisms: Mechanisms, soft: Softness, aim: int, sweeps: int, reactions: bool) -> None:
    """Sweep over the contacts so often, and close the loops after each; once where there are loops alone."""
    joints, touched = mechanisms.joints, mechanisms.touched
    state, loops = mechanisms.bodies.state, count_loop_rows(mechanisms.tables, joints)
    for _ in range(sweeps if len(mechanisms.contacts.order) > 0 else 1):
        sweep_trees(state, mechanisms.contacts, touched, soft, mechanisms.firm, aim)
        if loops > 0:
            hold_loops(state, joints, touched, mechanisms.rows, loops, 1.0 if aim == PRESS else 0.0, reactions)


@kernel
def stands(tables: Tables, h: float) -> bool:
    """Whether all turns of a sub-step are so small that what they bend, a product of two of them, cannot be seen."""
    motion, column, most = tables.motion, tables.column, 0.0
    for i in range(motion.shape[0]):
        most += abs(motion[i, tree.VELOCITY]) + abs(motion[i, tree.VELOCITY + 1]) + abs(motion[i, tree.VELOCITY + 2])
    for k in range(column.shape[0]):
        most += abs(column[k, tree.RATE])
    return h * most * (h * most) <= UNSEEN


@kernel
def settle_contacts(
    mechanisms: Mechanisms, setting: Floats, count: Ints, soft: Softness, breaks: int, times: int, reactions: bool
) -> bool:
    """Sweep over contacts and loops, and settle laws with breaks, until all hold. Returns: whether the laws had an answer."""
    tables, bodies, touched = mechanisms.tables, mechanisms.bodies, mechanisms.touched
    joints, rows = mechanisms.joints, mechanisms.rows
    for _ in range(ROUNDS):
        if not are_answered(tables):
            write_responses(tables, touched)
            write_mobilities(bodies, mechanisms.contacts, touched)
            write_loop_matrix(bodies, touched, rows, count_loop_rows(tables, joints))
            for k in range(tables.stage_rate.shape[0]):
                tables.stage_rate[k, tree.ANSWERED] = tables.law[k, tree.SEGMENT]
            for n in range(tables.tendon.shape[0]):
                on = tables.law[tables.column.shape[0] + n, tree.SEGMENT]
                tables.tie[tables.follower.shape[0] + n, tree.ON] = on
        show_velocities(mechanisms, (0.0, 0.0, 0.0), soft.h)
        sweep_all(mechanisms, soft, PRESS, count[0, at.ITERATIONS] * times, reactions)
        if breaks == 0:
            break
        press_by_given(mechanisms)
        if not settle_laws(tables, bodies, joints, setting, soft.h, count[0, at.GYROSCOPIC], PRESSED, breaks):
            return False
        if are_answered(tables):
            break
    return True


@kernel
def relax(mechanisms: Mechanisms, count: Ints, sums: Floats, soft: Softness, times: int, reactions: bool) -> None:
    """Take the correction of positions out of the velocities, let what was struck rebound, and choose friction's mode."""
    bodies, contacts = mechanisms.bodies, mechanisms.contacts
    place_links(mechanisms)
    write_free_responses(bodies, mechanisms.touched)
    refresh(bodies.state, mechanisms.shapes, contacts)
    share_loads(bodies, contacts, sums)
    show_velocities(mechanisms, (0.0, 0.0, 0.0), 0.0)
    sweep_all(mechanisms, soft, RELAX, count[0, at.RELAXATIONS] * times, reactions)
    if bounce(contacts):
        sweep_all(mechanisms, soft, REBOUND, FRESH * (count[0, at.ITERATIONS] + count[0, at.RELAXATIONS]), reactions)
    friction_mode(bodies, contacts)
    end_substep(contacts)


@kernel
def start_contacts(mechanisms: Mechanisms, setting: Floats, count: Ints, sums: Floats, h: float, substep: int) -> int:
    """Note what strikes, and press the links by the impulses of the last sub-step. Returns: times as many sweeps."""
    bodies, contacts, touched = mechanisms.bodies, mechanisms.contacts, mechanisms.touched
    write_free_responses(bodies, touched)
    show_velocities(mechanisms, scale(h, load3(setting, 0, at.GRAVITY)), 0.0)
    strikes = approach(bodies, contacts, setting, h, slow_approach(setting, h))
    share_loads(bodies, contacts, sums)
    start_warm(bodies.state, contacts, touched)
    press_by_given(mechanisms)
    return FRESH if strikes > 0 or (substep == 0 and count[0, at.NEW] > 0) else 1


@kernel
def move_others(tables: Tables, bodies: Bodies, setting: Floats, h: float, gyroscopic: int, drifts: bool) -> None:
    """Kick, or move, the touched bodies that no tree has for h seconds."""
    for n in range(tables.other.shape[0]):
        b = tables.other[n, 0]
        if bodies.kind[b, at.MOTION] != at.DYNAMIC or bodies.kind[b, at.TOUCHED] == 0:
            continue
        if drifts:
            drift(bodies, b, h, gyroscopic)
        else:
            kick(bodies, setting, b, h)


@kernel
def touching_substep(
    mechanisms: Mechanisms,
    setting: Floats,
    count: Ints,
    sums: Floats,
    soft: Softness,
    substep: int,
    moved: bool,
    reactions: bool,
) -> bool:
    """Advance all trees, and the free bodies that contacts touch, by a sub-step.

    Args: sums: room for `share_loads`; moved: whether links are where their coordinates say; reactions: whether to count what
        joints carry. Returns: whether the laws had an answer.
    """
    tables, bodies, joints = mechanisms.tables, mechanisms.bodies, mechanisms.joints
    h, gyroscopic, touches, times = soft.h, count[0, at.GYROSCOPIC], mechanisms.touched.kind.shape[0] > 0, 1
    if tables.closing.shape[0] > 0:
        write_loops(tables, bodies, joints, mechanisms.rows, h)
        forget_responses(tables)
    move_others(tables, bodies, setting, h, gyroscopic, drifts=False)
    if not moved:
        move_links(tables, bodies.state)
    go_on_bending(tables)
    for i in range(tables.stage.shape[0]):
        for c in range(6):
            tables.stage[i, tree.PRESSURE + c] = 0.0
    if touches:
        times = start_contacts(mechanisms, setting, count, sums, h, substep)
    start_laws(tables)
    breaks = write_laws(tables, joints, h, PRESSED) + write_tendons(tables, h)
    for turn in range(MOST_TURNS if breaks > 0 else 1):
        if turn > 0:
            if are_settled(tables, joints, setting, h):
                break
            start_again(tables, bodies, joints, setting, h, gyroscopic, PRESSED, reactions)
        if not settle_laws(tables, bodies, joints, setting, h, gyroscopic, PRESSED, breaks):
            return False
        if touches and not settle_contacts(mechanisms, setting, count, soft, breaks, times, reactions):
            return False
        take_changes(tables, joints, h, reactions)
        if touches and breaks == 0:
            answer_given(mechanisms, h, reactions)
        if turn == 0 and stands(tables, h):
            bend_links(tables, bodies, h)
        else:
            close_bends(tables, bodies, joints, setting, h, reactions)
    drift_coordinates(tables, h)
    carry_bases(tables, bodies, h)
    move_others(tables, bodies, setting, h, gyroscopic, drifts=True)
    if touches:
        relax(mechanisms, count, sums, soft, times, reactions)
        answer_given(mechanisms, h, reactions)
    keep_momenta(tables, gyroscopic)
    return True
