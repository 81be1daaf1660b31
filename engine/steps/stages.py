"""A sub-step of contacts and joints, of all that a world has or of an island, and what comes before the first of them.

    begin     kick; write the rows of joints; note what strikes
    solve     share loads; push again; press, so often as strikes and new contacts need; drift; turn; relax
    release   rebound, where any was struck; choose friction's mode; count impulses

Joints, where there are any, are held after each sweep over the contacts.

Source: Catto, Solver2D, 2024 (TGS Soft).
"""

from collections.abc import Callable
from typing import NamedTuple

from plumbline.engine.compile.jit import kernel, template
from plumbline.engine.constrain.reactions import clear_reactions
from plumbline.engine.constrain.stages import BEGIN, END, KNOWN, NEW, Held
from plumbline.engine.contact.find_contacts import find_contacts, keep_contacts
from plumbline.engine.integrate.all_bodies import drift_all, kick_all
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import ints_of
from plumbline.engine.memory.status import DONE
from plumbline.engine.memory.tables import Bodies, Contacts, Joints, Rows, bodies_of, in_order, joints_of
from plumbline.engine.respond.share_loads import share_loads
from plumbline.engine.respond.softness import FRESH, FRESH_JOINTED, PRESS, PUSH, REBOUND, RELAX, TURN, Softness, slow_approach
from plumbline.engine.respond.substep import approach, bounce, end_substep, friction_mode

RINGS = 1
"""How many contacts away from a struck body more sweeps go."""


class Group(NamedTuple):
    """What is solved together: which bodies (k, 1), which contacts and joints, and the rows of these.

    Terms: sharing: the contacts of bodies that share their load; sums: room for `share_loads`; hurried: for the order of what
    `near_blows` finds.
    """

    bodies: Bodies
    touched: Ints
    contacts: Contacts
    sharing: Contacts
    joints: Joints
    rows: Rows
    sums: Floats
    hurried: Ints


class Effort(NamedTuple):
    """Which contacts are swept `times` times as often as set, the others once. Terms: times: 0 where none is swept."""

    near: Contacts
    times: int


@kernel
def meet(floats: Floats, ints: Ints) -> int:
    """Keep the contacts of the last step where all bodies are still, else find those of this one. Returns: a status."""
    return DONE if keep_contacts(floats, ints) else int(find_contacts(floats, ints))


@kernel
def meet_jointed(floats: Floats, ints: Ints) -> int:
    """Find the contacts of this step, and let joints touch their bodies. Returns: a status."""
    status, bodies, joints = find_contacts(floats, ints), bodies_of(floats, ints), joints_of(floats, ints)
    if status == DONE:
        for j in range(joints.kind.shape[0]):
            bodies.kind[joints.kind[j, at.PARENT], at.TOUCHED] = 1
            bodies.kind[joints.kind[j, at.CHILD], at.TOUCHED] = 1
        clear_reactions(joints)
    return int(status)


@kernel
def near_blows(kind: Ints, contacts: Contacts, room: Ints, step: int) -> int:
    """The contacts near one that strikes or is new, which get more sweeps: the others' impulses carry their load.

    Near is what moves a body that is at most `RINGS` contacts away from a body of such a one; what does not move passes
    nothing on. Args: room (k, 1): for their order; step: whose new contacts count, -1 for none. Returns: how many they are.
    """
    key, rings, n = contacts.key, at.RING, 0
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        n += 1 if key[m, at.STRIKES] == 1 or key[m, at.BEGUN] == step else 0
    if n == 0:
        return 0
    for rank in range(len(contacts.order)):
        for side in (at.BODY_A, at.BODY_B):
            kind[key[contacts.order[rank, 0], side], rings] = RINGS + 1
    for ring in range(RINGS + 1):
        for rank in range(len(contacts.order)):
            m = contacts.order[rank, 0]
            source = key[m, at.STRIKES] == 1 or key[m, at.BEGUN] == step
            if ring > 0:
                source = kind[key[m, at.BODY_A], rings] == ring - 1 or kind[key[m, at.BODY_B], rings] == ring - 1
            for side in (at.BODY_A, at.BODY_B):
                if source and kind[key[m, side], at.MOTION] == at.DYNAMIC:
                    kind[key[m, side], rings] = min(kind[key[m, side], rings], ring)
    n = 0
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        if min(kind[key[m, at.BODY_A], rings], kind[key[m, at.BODY_B], rings]) <= RINGS:
            room[n, 0] = m
            n += 1
    return n


@kernel
def effort_of(group: Group, count: Ints, fresh: bool, struck: bool) -> Effort:
    """What is swept more often in a sub-step. Args: fresh: whether contacts may be new; struck: whether any may strike."""
    near, times = group.contacts, 0 if count[0, at.MANIFOLDS] == 0 else 1
    if times == 1 and (fresh or struck):
        if count[0, at.JOINTS] > 0:
            return Effort(near, FRESH_JOINTED)
        hurried = near_blows(group.bodies.kind, near, group.hurried, count[0, at.STEPS] if fresh else -1)
        near, times = in_order(near, group.hurried[:hurried]), FRESH if hurried > 0 else 1
    return Effort(near, times)


def _begin(group: Group, setting: Floats, held: Held, soft: Softness, holding: Callable[..., Held]) -> tuple[int, Held]:
    """Begin a sub-step. Args: holding: as `hold`. Returns: how many points are about to strike, and the rows of joints."""
    kick_all(group.bodies, group.touched, setting, soft.h)
    held = holding(group.bodies, group.joints, group.rows, held, BEGIN, soft.h)
    return approach(group.bodies, group.contacts, setting, soft.h, slow_approach(setting, soft.h)), held


def _solve(
    floats: Floats,
    ints: Ints,
    group: Group,
    held: Held,
    soft: Softness,
    effort: Effort,
    visit: Callable[..., None],
    holding: Callable[..., Held],
) -> bool:
    """Solve with the position error, drift, and relax.

    Args: visit: does to contacts what is to be done to each, as `as_found`.
    Returns: whether any is to rebound.
    """
    bodies, contacts, joints, rows, count = group.bodies, group.contacts, group.joints, group.rows, ints_of(ints, at.COUNT)
    share_loads(bodies, group.sharing, group.sums)
    visit(floats, ints, bodies, contacts, soft, PUSH)
    holding(bodies, joints, rows, held, NEW, soft.h)
    for k in range(count[0, at.ITERATIONS] * effort.times):
        visit(floats, ints, bodies, contacts if k % effort.times == 0 else effort.near, soft, PRESS)
        holding(bodies, joints, rows, held, KNOWN, soft.h)
    drift_all(bodies, group.touched, count, soft.h)
    visit(floats, ints, bodies, contacts, soft, TURN)
    share_loads(bodies, group.sharing, group.sums)
    for k in range(count[0, at.RELAXATIONS] * effort.times):
        visit(floats, ints, bodies, contacts if k % effort.times == 0 else effort.near, soft, RELAX)
        holding(bodies, joints, rows, held, KNOWN, soft.h)
    return bounce(contacts)


def _release(
    floats: Floats,
    ints: Ints,
    group: Group,
    held: Held,
    soft: Softness,
    struck: bool,
    visit: Callable[..., None],
    holding: Callable[..., Held],
) -> None:
    """End a sub-step. Args: struck: whether anything is to rebound; the others as above."""
    bodies, contacts, joints, rows, count = group.bodies, group.contacts, group.joints, group.rows, ints_of(ints, at.COUNT)
    for _ in range(FRESH * (count[0, at.ITERATIONS] + count[0, at.RELAXATIONS]) if struck else 0):
        visit(floats, ints, bodies, contacts, soft, REBOUND)
        holding(bodies, joints, rows, held, KNOWN, soft.h)
    friction_mode(bodies, contacts)
    end_substep(contacts)
    holding(bodies, joints, rows, held, END, soft.h)


begin_world, solve_world, release_world = template(_begin), template(_solve), template(_release)
"""Written into the steps of whole worlds, whose visits threads may share."""
begin_island, solve_island, release_island = kernel(_begin), kernel(_solve), kernel(_release)
"""Called for each island."""
