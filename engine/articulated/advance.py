"""Coordinates and rates as they move on, as the state of the bodies that they mean, and the bases that trees hang on.

Bases are kinematic bodies, which go their own way. One that is told another velocity takes its trees along by what the joints
transmit and no more: what slides on it, or turns, is left behind. That is an impulse, which meets the inertia of the links
alone:

    M(q) dq' = -(what the jump of the base gives along each column),   by the articulated-body algorithm with c_root = the jump

Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, section IV.8 (Lie group methods); Featherstone, Rigid Body
Dynamics Algorithms, 2008, sections 7.3 and 11.7 (impulsive dynamics).
"""

import math

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.articulated_body import accelerations, transmitted
from plumbline.engine.articulated.forces import centre_velocity, weigh_links
from plumbline.engine.articulated.motion import move_links, rates_of
from plumbline.engine.articulated.passes import forces_inwards, outwards
from plumbline.engine.articulated.spatial import Spatial, axpy6, dot6, sliding, turning
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.articulated.ties import follow_coordinates, follow_rates, pull_ties, pulled_beside
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import load3, load4, load6, load9, store3, store4, store6
from plumbline.engine.maths.vec import add, axpy, cross, mat_vec, neg, quat_mat, quat_turn, quat_unit, sub
from plumbline.engine.memory import arena as at


@kernel
def carry_bases(trees: Trees, h: float) -> None:
    """Move the kinematic bodies for h seconds."""
    state = trees.bodies.state
    for n in range(trees.other.shape[0]):
        b = trees.other[n, 0]
        if trees.bodies.kind[b, at.MOTION] == at.KINEMATIC:
            store3(state, b, at.P, axpy(h, load3(state, b, at.V), load3(state, b, at.P)))
            store4(state, b, at.Q, quat_turn(load4(state, b, at.Q), load3(state, b, at.W), h))


@kernel
def free_columns(trees: Trees) -> None:
    """Let no force act along any column, and rotors turn with those that have one."""
    column, kind = trees.column, trees.kind
    for k in range(column.shape[0]):
        column[k, tree.ADDED] = column[k, tree.PUSH] = 0.0
    for i in range(kind.shape[0]):
        j = kind[i, tree.JOINT]
        if j >= 0 and trees.joints.kind[j, at.HAS] != 0:
            column[kind[i, tree.FIRST], tree.ADDED] = trees.joints.joint[j, at.ARMATURE]


@kernel
def jump_of(trees: Trees, i: int) -> tuple[Spatial, Spatial]:
    """w and v of the base of root i, and by how much they differ from those that it was last seen with."""
    state, b = trees.bodies.state, trees.kind[i, tree.BASE]
    if b < 0 or trees.bodies.kind[b, at.MOTION] != at.KINEMATIC:
        seen = load6(trees.motion, i, tree.BASE_VELOCITY)
        return seen, axpy6(-1.0, seen, seen)
    now = (*load3(state, b, at.W), *load3(state, b, at.V))
    return now, axpy6(-1.0, load6(trees.motion, i, tree.BASE_VELOCITY), now)


@kernel
def jumped(trees: Trees) -> bool:
    """Whether a base has another velocity than it was last seen with."""
    for i in range(trees.kind.shape[0]):
        _now, jump = jump_of(trees, i)
        if dot6(jump, jump) != 0.0:
            return True
    return False


@kernel
def take_jumps(trees: Trees) -> bool:
    """Change all rates by what jumps of the bases' velocities do since they were last seen. Returns: whether there were any."""
    if not jumped(trees):
        return False
    motion, kind, column = trees.motion, trees.kind, trees.column
    move_links(trees)
    weigh_links(trees)
    free_columns(trees)
    for i in range(kind.shape[0]):
        b = kind[i, tree.BASE]
        if b >= 0:
            now, jump = jump_of(trees, i)
            arm = mat_vec(quat_mat(load4(trees.bodies.state, b, at.Q)), load3(trees.link, i, tree.ANCHOR_A))
            store3(motion, i, tree.BIAS, turning(jump))
            store3(motion, i, tree.BIAS + 3, add(sliding(jump), cross(turning(jump), arm)))
            store6(motion, i, tree.BASE_VELOCITY, now)
    accelerations(trees, True)
    for k in range(column.shape[0]):
        column[k, tree.RATE] += trees.along[k, tree.CHANGE]
    weigh_links(trees)
    return True


@kernel
def change_rates(trees: Trees, h: float) -> tuple[float, float]:
    """q' <- q' + h q''; where a jump fixes the rate, it is that of the jump to the last bit.

    Returns: the largest change of a rate that none fixes, and the largest rate.
    """
    column, largest, fastest = trees.column, 0.0, 0.0
    for k in range(column.shape[0]):
        if column[k, tree.ADDED] == math.inf:
            column[k, tree.RATE] = trees.law[k, tree.HELD]
        else:
            change = h * trees.along[k, tree.CHANGE]
            column[k, tree.RATE] += change
            largest = max(largest, abs(change))
        fastest = max(fastest, abs(column[k, tree.RATE]))
    follow_rates(trees)
    return largest, fastest


@kernel
def take_changes(trees: Trees, h: float, reactions: bool) -> tuple[float, float]:
    """Change rates, and velocities of links along the tangent, by h times what was solved for; count what joints carry.

    Args: reactions: whether to. Returns: as `change_rates`.
    """
    if reactions:
        add_reactions(trees, h)
    motion = trees.motion
    for i in range(motion.shape[0]):
        a = load6(trees.answer, i, tree.ACCELERATION)
        store6(motion, i, tree.VELOCITY, axpy6(h, a, load6(motion, i, tree.VELOCITY)))
    return change_rates(trees, h)


@kernel
def answer_forces(trees: Trees, h: float, reactions: bool) -> tuple[float, float]:
    """Change rates, and velocities of links, by what forces of links do over h; nothing pushes along columns, and links have no
    bias.

    Rates that are prescribed stay, and the force that keeps them is counted. Returns: as `change_rates`.
    """
    column, along = trees.column, trees.along
    for k in range(column.shape[0]):
        if column[k, tree.ADDED] != math.inf:
            along[k, tree.LEFT] = 0.0
    forces_inwards(trees, 0)
    if trees.tie.shape[0] > 0:
        pull_ties(trees, False, False)
    outwards(trees, 0, False, False)
    for k in range(column.shape[0]):
        if column[k, tree.ADDED] == math.inf:
            i = int(trees.law[k, tree.OWNER])
            along[k, tree.LEFT] += dot6(load6(column, k, tree.PULL), load6(trees.answer, i, tree.ACCELERATION))
            along[k, tree.LEFT] += dot6(load6(column, k, tree.AXIS_W), load6(trees.answer, i, tree.FORCE))
            along[k, tree.LEFT] -= pulled_beside(trees, k)
    return take_changes(trees, h, reactions)


@kernel
def drift_coordinates(trees: Trees, h: float) -> None:
    """Move all coordinates for h seconds with their rates."""
    coordinate, kind = trees.coordinate, trees.kind
    for i in range(kind.shape[0]):
        k = kind[i, tree.FIRST]
        if kind[i, tree.COLUMNS] == 1:
            coordinate[i, 0] += h * trees.column[k, tree.RATE]
        elif kind[i, tree.COLUMNS] > 1:
            store4(coordinate, i, 0, quat_turn(load4(coordinate, i, 0), rates_of(trees, k), h))
            if kind[i, tree.TYPE] == tree.FREE:
                store3(coordinate, i, tree.POSITION, axpy(h, rates_of(trees, k + 3), load3(coordinate, i, tree.POSITION)))
    follow_coordinates(trees)


@kernel
def is_finite_forest(trees: Trees) -> bool:
    """Whether every coordinate and rate is finite, and every number of the state of a body that no tree has."""
    # Sums of a row do not wait for each other.
    total = 0.0
    for i in range(trees.coordinate.shape[0]):
        row = 0.0
        for c in range(tree.POSE):
            row += 0.0 * trees.coordinate[i, c]
        total += row
    for n in range(trees.other.shape[0]):
        row = 0.0
        for c in range(13):
            row += 0.0 * trees.bodies.state[trees.other[n, 0], c]
        total += row
    for k in range(trees.column.shape[0]):
        total += 0.0 * trees.column[k, tree.RATE]
    return math.isfinite(total)


@kernel
def write_state(trees: Trees) -> None:
    """Write pose and velocity of every link to its body, and coordinates to their joints."""
    state, motion, kind = trees.bodies.state, trees.motion, trees.kind
    move_links(trees)
    for i in range(kind.shape[0]):
        b = kind[i, tree.ROW]
        store3(state, b, at.P, add(load3(motion, kind[i, tree.ROOT], tree.ORIGIN), load3(motion, i, tree.PLACE)))
        store4(state, b, at.Q, quat_unit(load4(motion, i, tree.ORIENTATION)))
        store3(state, b, at.V, centre_velocity(trees, i))
        store3(state, b, at.W, load3(motion, i, tree.VELOCITY))
        if kind[i, tree.COLUMNS] == 1:
            trees.joints.joint[kind[i, tree.JOINT], at.COORDINATE] = trees.coordinate[i, 0]


@kernel
def add_reactions(trees: Trees, share: float) -> None:
    """Count what the joints carry now towards their reactions, as if for `share` seconds."""
    kind, joint, motion = trees.kind, trees.joints.joint, trees.motion
    for i in range(kind.shape[0]):
        j = kind[i, tree.JOINT]
        if j < 0:
            continue
        carried = transmitted(trees, i)
        torque, force, on, anchor = turning(carried), sliding(carried), i, tree.ANCHOR_B
        if trees.joints.kind[j, at.CHILD] != kind[i, tree.ROW]:
            # The joint's child is what this link hangs on, and takes the opposite, about its own anchor.
            torque, force, on, anchor = neg(torque), neg(force), kind[i, tree.PARENT], tree.ANCHOR_A
        about = (0.0, 0.0, 0.0)
        if on >= 0:
            arm = mat_vec(load9(motion, on, tree.MATRIX), load3(trees.link, i, anchor))
            about = add(load3(motion, on, tree.PLACE), arm)
        store3(joint, j, at.REACTION, axpy(share, force, load3(joint, j, at.REACTION)))
        moment = sub(torque, cross(about, force))
        store3(joint, j, at.REACTION + 3, axpy(share, moment, load3(joint, j, at.REACTION + 3)))
