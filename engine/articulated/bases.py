"""What trees hang on: kinematic bodies, which go their own way, and what a jump of their velocity does to what hangs there.

A base that is told another velocity takes its trees along by what the joints transmit and no more: what slides on it, or turns,
is left behind. That is an impulse, which meets the inertia of the links alone:

    M(q) dq' = -(what the jump of the base gives along each column),   by the articulated-body algorithm with c_root = the jump

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 7.3 and 11.7 (impulsive dynamics).
"""

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.articulated_body import accelerations
from plumbline.engine.articulated.forces import weigh_links
from plumbline.engine.articulated.motion import move_links
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import load3, load4, store3, store4
from plumbline.engine.maths.vec import add, axpy, cross, mat_vec, quat_mat, quat_turn, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints


@kernel
def carry_bases(tables: Tables, bodies: Bodies, h: float) -> None:
    """Move the kinematic bodies for h seconds."""
    state = bodies.state
    for n in range(tables.other.shape[0]):
        b = tables.other[n, 0]
        if bodies.kind[b, at.MOTION] == at.KINEMATIC:
            store3(state, b, at.P, axpy(h, load3(state, b, at.V), load3(state, b, at.P)))
            store4(state, b, at.Q, quat_turn(load4(state, b, at.Q), load3(state, b, at.W), h))


@kernel
def free_columns(tables: Tables, joints: Joints) -> None:
    """Let no force act along any column, and rotors turn with those that have one."""
    column, kind = tables.column, tables.kind
    for k in range(column.shape[0]):
        column[k, tree.ADDED] = column[k, tree.PUSH] = 0.0
    for i in range(kind.shape[0]):
        j = kind[i, tree.JOINT]
        if j >= 0 and joints.kind[j, at.HAS] != 0:
            column[kind[i, tree.FIRST], tree.ADDED] = joints.joint[j, at.ARMATURE]


@kernel
def jumped(tables: Tables, bodies: Bodies) -> bool:
    """Whether a base has another velocity than it was last seen with."""
    state, motion, kind = bodies.state, tables.motion, tables.kind
    for i in range(kind.shape[0]):
        b = kind[i, tree.BASE]
        if b >= 0 and bodies.kind[b, at.MOTION] == at.KINEMATIC:
            for c in range(3):
                if (
                    motion[i, tree.BASE_VELOCITY + c] != state[b, at.W + c]
                    or motion[i, tree.BASE_VELOCITY + 3 + c] != state[b, at.V + c]
                ):
                    return True
    return False


@kernel
def take_jumps(tables: Tables, bodies: Bodies, joints: Joints) -> bool:
    """Change all rates by what jumps of the bases' velocities do since they were last seen. Returns: whether there were any."""
    if not jumped(tables, bodies):
        return False
    state, motion, kind, column = bodies.state, tables.motion, tables.kind, tables.column
    move_links(tables, state)
    weigh_links(tables)
    free_columns(tables, joints)
    for i in range(kind.shape[0]):
        b = kind[i, tree.BASE]
        if kind[i, tree.PARENT] >= 0 or b < 0 or bodies.kind[b, at.MOTION] != at.KINEMATIC:
            continue
        w, v = load3(state, b, at.W), load3(state, b, at.V)
        turning, sliding = sub(w, load3(motion, i, tree.BASE_VELOCITY)), sub(v, load3(motion, i, tree.BASE_VELOCITY + 3))
        arm = mat_vec(quat_mat(load4(state, b, at.Q)), load3(tables.link, i, tree.ANCHOR_A))
        store3(motion, i, tree.BIAS, turning)
        store3(motion, i, tree.BIAS + 3, add(sliding, cross(turning, arm)))
        store3(motion, i, tree.BASE_VELOCITY, w)
        store3(motion, i, tree.BASE_VELOCITY + 3, v)
    accelerations(tables, True)
    for k in range(column.shape[0]):
        column[k, tree.RATE] += column[k, tree.CHANGE]
    weigh_links(tables)
    return True
