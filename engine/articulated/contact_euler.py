"""What soft contacts, and joints that close loops, are in a sub-step of semi-implicit Euler in joint coordinates.

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
from plumbline.engine.articulated.advance import answer_forces
from plumbline.engine.articulated.bounded import ALL, settle_laws
from plumbline.engine.articulated.contact_sweeps import start_warm, sweep_trees, write_mobilities
from plumbline.engine.articulated.forces import put_force
from plumbline.engine.articulated.loops import count_loop_rows, hold_loops, write_loop_matrix, write_loops
from plumbline.engine.articulated.momenta import bent_velocities
from plumbline.engine.articulated.responses import BODY, LINK, NOWHERE, Touched, write_free_responses, write_responses
from plumbline.engine.articulated.spatial import NOTHING, STILL, sliding, turning, velocity_at
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.integrate.semi_implicit_euler import drift, kick
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, load4, load6, store3, store4, store6
from plumbline.engine.maths.vec import add, axpy, quat_mul, quat_unit, scale
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Contacts, Rows, Shapes
from plumbline.engine.respond.arms import refresh
from plumbline.engine.respond.share_loads import share_loads
from plumbline.engine.respond.softness import FRESH, PRESS, REBOUND, RELAX, Softness, slow_approach
from plumbline.engine.respond.substep import approach, bounce, end_substep, friction_mode

ROUNDS: Final = 4
"""Times at most that laws and contacts are settled in turns in a sub-step. A stop that is struck takes two."""

UNKNOWN: Final = -1.0
"""In place of the segment of a law whose responses are not written."""


class Touching(NamedTuple):
    """What holds trees beside their joints: contacts and what these move, rows for loops or None.

    Terms: sums: room for `share_loads`; soft, firm: the softness of contacts, and of those under links. Where there is none of
    all this, None stands in its place, and nothing of it is compiled.
    """

    shapes: Shapes
    contacts: Contacts
    touched: Touched
    rows: Rows | None
    sums: Floats
    counts: Ints
    soft: Softness
    firm: Softness


@kernel
def forget_responses(trees: Trees) -> None:
    """Let the responses at hand be written anew."""
    for k in range(trees.law.shape[0]):
        trees.law[k, tree.ANSWERED] = UNKNOWN


@kernel
def are_answered(trees: Trees) -> bool:
    """Whether the responses at hand are those of the segments that all laws are on."""
    others = 0
    for k in range(trees.law.shape[0]):
        others += trees.law[k, tree.ANSWERED] != trees.law[k, tree.SEGMENT]
    return others == 0


@kernel
def show_velocities(trees: Trees, touching: Touching, kick_by: Vec, h: float) -> None:
    """Write the velocities of the touched links to their bodies, with a kick [m/s] and h times their accelerations."""
    state, touched = trees.bodies.state, touching.touched.kind
    for k in range(touched.shape[0]):
        i, b = touched[k, LINK], touched[k, BODY]
        if i != NOWHERE:
            a, moved = load6(trees.answer, i, tree.ACCELERATION), bent_velocities(trees, i)
            v, w = add(sliding(moved), kick_by), turning(moved)
            if h != 0.0:
                v, w = axpy(h, velocity_at(a, load3(trees.motion, i, tree.PLACE)), v), axpy(h, turning(a), w)
            store3(state, b, at.V, v)
            store3(state, b, at.W, w)


@kernel
def place_links(trees: Trees, touching: Touching) -> None:
    """Write the poses at the end of the sub-step of the touched links to their bodies."""
    state, touched, motion, passage = trees.bodies.state, touching.touched.kind, trees.motion, trees.passage
    for k in range(touched.shape[0]):
        i, b = touched[k, LINK], touched[k, BODY]
        if i != NOWHERE:
            start = add(load3(motion, trees.kind[i, tree.ROOT], tree.ORIGIN), load3(motion, i, tree.PLACE))
            store3(state, b, at.P, add(start, load3(passage, i, tree.WAY)))
            store4(state, b, at.Q, quat_unit(quat_mul(load4(passage, i, tree.TURNING), load4(motion, i, tree.ORIENTATION))))


@kernel
def press_by_given(trees: Trees, touching: Touching) -> None:
    """Count what links were given towards what contacts give them in this sub-step."""
    touched, passage = touching.touched, trees.passage
    for k in range(touched.kind.shape[0]):
        for c in range(6):
            if touched.kind[k, LINK] != NOWHERE:
                passage[touched.kind[k, LINK], tree.PRESSURE + (c + 3) % 6] += touched.given[k, c]
            touched.given[k, c] = 0.0


@kernel
def answer_given(trees: Trees, touching: Touching | None, h: float, reactions: bool) -> None:
    """Change all rates by the impulses that links were given beside the forces of the last solve."""
    if touching is None:
        return
    touched, links = touching.touched, 0
    for i in range(trees.kind.shape[0]):
        store6(trees.answer, i, tree.FORCE, NOTHING)
    for k in range(touched.kind.shape[0]):
        if touched.kind[k, LINK] != NOWHERE:
            links += 1
            f, t = load3(touched.given, k, 0), load3(touched.given, k, 3)
            put_force(trees, touched.kind[k, LINK], scale(-1.0 / h, t), scale(-1.0 / h, f))
        store6(touched.given, k, 0, NOTHING)
    if links > 0:
        answer_forces(trees, h, reactions)


@kernel
def sweep_all(trees: Trees, touching: Touching, aim: int, sweeps: int, reactions: bool) -> None:
    """Sweep over the contacts so often, and close the loops after each; once where there are loops alone."""
    loops, contacts, touched = count_loop_rows(trees), touching.contacts, touching.touched
    for _ in range(sweeps if len(contacts.order) > 0 else 1):
        sweep_trees(trees.bodies.state, contacts, touched, touching.soft, touching.firm, aim)
        if loops > 0:
            hold_loops(trees, touched, touching.rows, loops, 1.0 if aim == PRESS else 0.0, reactions)


@kernel
def settle_contacts(trees: Trees, touching: Touching | None, breaks: int, times: int, reactions: bool) -> bool:
    """Sweep over contacts and loops, and settle laws with breaks, until all hold. Returns: whether the laws had an answer."""
    if touching is None:
        return True
    touched, h = touching.touched, touching.soft.h
    for _ in range(ROUNDS if touched.kind.shape[0] > 0 else 0):
        if not are_answered(trees):
            write_responses(trees, touched)
            write_mobilities(trees.bodies, touching.contacts, touched)
            write_loop_matrix(trees, touched, touching.rows, count_loop_rows(trees))
            for k in range(trees.law.shape[0]):
                trees.law[k, tree.ANSWERED] = trees.law[k, tree.SEGMENT]
        show_velocities(trees, touching, STILL, h)
        sweep_all(trees, touching, PRESS, touching.counts[0, at.ITERATIONS] * times, reactions)
        if breaks == 0:
            break
        press_by_given(trees, touching)
        if not settle_laws(trees, h, ALL, breaks):
            return False
        if are_answered(trees):
            break
    return True


@kernel
def relax(trees: Trees, touching: Touching | None, times: int, reactions: bool) -> None:
    """Take the correction of positions out of the velocities, let what was struck rebound, and choose friction's mode."""
    if touching is None:
        return
    bodies, contacts, count = trees.bodies, touching.contacts, touching.counts
    if touching.touched.kind.shape[0] == 0:
        return
    place_links(trees, touching)
    write_free_responses(bodies, touching.touched)
    refresh(bodies.state, touching.shapes, contacts)
    share_loads(bodies, contacts, touching.sums)
    show_velocities(trees, touching, STILL, 0.0)
    sweep_all(trees, touching, RELAX, count[0, at.RELAXATIONS] * times, reactions)
    if bounce(contacts):
        sweep_all(trees, touching, REBOUND, FRESH * (count[0, at.ITERATIONS] + count[0, at.RELAXATIONS]), reactions)
    friction_mode(bodies, contacts)
    end_substep(contacts)
    answer_given(trees, touching, touching.soft.h, reactions)


@kernel
def begin_loops(trees: Trees, touching: Touching | None, h: float) -> None:
    """Write the rows of joints that close loops, which change the responses."""
    if touching is None:
        return
    if trees.closing.shape[0] > 0:
        write_loops(trees, touching.rows, h)
        forget_responses(trees)


@kernel
def start_contacts(trees: Trees, touching: Touching | None, h: float, substep: int) -> int:
    """Note what strikes, and press the links by the impulses of the last sub-step. Returns: times as many sweeps."""
    if touching is None:
        return 1
    bodies, contacts, touched, setting = trees.bodies, touching.contacts, touching.touched, trees.setting
    for i in range(trees.passage.shape[0]):
        store6(trees.passage, i, tree.PRESSURE, NOTHING)
    if touched.kind.shape[0] == 0:
        return 1
    write_free_responses(bodies, touched)
    show_velocities(trees, touching, scale(h, load3(setting, 0, at.GRAVITY)), 0.0)
    strikes = approach(bodies, contacts, setting, h, slow_approach(setting, h))
    share_loads(bodies, contacts, touching.sums)
    start_warm(bodies.state, contacts, touched)
    press_by_given(trees, touching)
    return FRESH if strikes > 0 or (substep == 0 and touching.counts[0, at.NEW] > 0) else 1


@kernel
def move_others(trees: Trees, touching: Touching | None, h: float, drifts: bool) -> None:
    """Kick, or move, the touched bodies that no tree has for h seconds."""
    if touching is None:
        return
    bodies = trees.bodies
    for n in range(trees.other.shape[0]):
        b = trees.other[n, 0]
        if bodies.kind[b, at.MOTION] == at.DYNAMIC and bodies.kind[b, at.TOUCHED] == 1:
            if drifts:
                drift(bodies, b, h, trees.gyroscopic)
            else:
                kick(bodies, trees.setting, b, h)
