"""The momenta that belong to coordinates, and what changes them.

    p_k = S_k . H_k + armature q'_k,    p_k' = (v_a x S_k) . H_k + S_k . F_k + (what acts along it)

H_k and F_k are the momentum and the outer force of all that hangs on column k, v_a the motion of what carries its axis, and
(v_a x S_k) . H_k is what the kinetic energy changes by with the coordinate, at equal rates. Of a ball and a free root the p are
momenta along axes that its parent carries.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 2.9 (cross products), 2.11 (momentum) and 2.14; Hairer,
Lubich, Wanner, Geometric Numerical Integration, section VI.1 (Hamilton's equations).
"""

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import free_columns
from plumbline.engine.articulated.articulated_body import accelerations
from plumbline.engine.articulated.forces import weigh_links
from plumbline.engine.articulated.motion import carrier, move_links
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, load3, load6, load9, store3
from plumbline.engine.maths.vec import add, axpy, cross, dot, scale, sym_rotate, sym_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints


@kernel
def load_wholes(tables: Tables, bodies: Bodies, setting: Floats, gyroscopic: int) -> None:
    """Write momentum and outer force of every link alone."""
    link, motion, passage, g = tables.link, tables.motion, tables.passage, load3(setting, 0, at.GRAVITY)
    for i in range(link.shape[0]):
        m, r, b = link[i, tree.MASS], load3(motion, i, tree.PLACE), tables.kind[i, tree.ROW]
        w = load3(motion, i, tree.VELOCITY)
        v = add(load3(motion, i, tree.VELOCITY + 3), cross(w, r))
        spin = sym_vec(sym_rotate(load9(motion, i, tree.MATRIX), load6(link, i, tree.INERTIA)), w)
        store3(passage, i, tree.WHOLE_MOMENTUM, axpy(m, cross(r, v), spin))
        store3(passage, i, tree.WHOLE_MOMENTUM + 3, scale(m, v))
        f = axpy(-m * link[i, tree.LINEAR_DAMPING], v, axpy(m, g, load3(bodies.load, b, 0)))
        torque = axpy(-link[i, tree.ANGULAR_DAMPING], spin, load3(bodies.load, b, 3))
        if gyroscopic == 0:
            # What keeps w, against what would keep the angular momentum.
            torque = add(torque, cross(w, spin))
        store3(passage, i, tree.WHOLE_FORCE, add(torque, cross(r, f)))
        store3(passage, i, tree.WHOLE_FORCE + 3, f)


@kernel
def column_momenta(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, gyroscopic: int) -> None:
    """Write the momentum of every column, and into BESIDE what changes it beside the laws, where links are and move now."""
    passage, column, kind = tables.passage, tables.column, tables.kind
    load_wholes(tables, bodies, setting, gyroscopic)
    for i in range(kind.shape[0] - 1, -1, -1):
        spin, momentum = load3(passage, i, tree.WHOLE_MOMENTUM), load3(passage, i, tree.WHOLE_MOMENTUM + 3)
        torque, force = load3(passage, i, tree.WHOLE_FORCE), load3(passage, i, tree.WHOLE_FORCE + 3)
        w, v, _a = carrier(tables, bodies.state, i)
        for k in range(kind[i, tree.FIRST], kind[i, tree.FIRST] + kind[i, tree.COLUMNS]):
            turning, sliding = load3(column, k, tree.AXIS_W), load3(column, k, tree.AXIS_W + 3)
            column[k, tree.MOMENTUM] = dot(turning, spin) + dot(sliding, momentum)
            turned = dot(cross(w, turning), spin) + dot(add(cross(w, sliding), cross(v, turning)), momentum)
            column[k, tree.BESIDE] = turned + dot(turning, torque) + dot(sliding, force)
        j, k = kind[i, tree.JOINT], kind[i, tree.FIRST]
        if j >= 0 and joints.kind[j, at.HAS] != 0:
            column[k, tree.MOMENTUM] += joints.joint[j, at.ARMATURE] * column[k, tree.RATE]
        if kind[i, tree.PARENT] >= 0:
            for c in range(12):
                passage[kind[i, tree.PARENT], c] += passage[i, c]


@kernel
def begin_column_momenta(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, gyroscopic: int) -> None:
    """Keep the momenta that the present rates mean, and those as the last ones."""
    move_links(tables, bodies.state)
    column_momenta(tables, bodies, joints, setting, gyroscopic)
    for k in range(tables.column.shape[0]):
        tables.stage_rate[k, tree.KEPT_RATE] = tables.column[k, tree.RATE]
        tables.stage_rate[k, tree.KEPT_MOMENTUM] = tables.column[k, tree.MOMENTUM]
        tables.stage_rate[k, tree.KEPT_CHANGE] = 0.0


@kernel
def rates_of_momenta(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, gyroscopic: int) -> None:
    """Write the rates that the kept momenta mean where links are now."""
    column = tables.column
    move_links(tables, bodies.state)
    column_momenta(tables, bodies, joints, setting, gyroscopic)
    weigh_links(tables)
    free_columns(tables, joints)
    for k in range(column.shape[0]):
        column[k, tree.PUSH] = tables.stage_rate[k, tree.KEPT_MOMENTUM] - column[k, tree.MOMENTUM]
        column[k, tree.BESIDE] = 0.0
    accelerations(tables, False)
    for k in range(column.shape[0]):
        column[k, tree.RATE] += column[k, tree.CHANGE]
