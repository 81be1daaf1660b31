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
from plumbline.engine.articulated.forces import centre_velocity, turned_inertia, weigh_links
from plumbline.engine.articulated.motion import carrier, move_links
from plumbline.engine.articulated.spatial import across, add_row, dot6, force_at
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import load3, load6, store6
from plumbline.engine.maths.vec import add, axpy, cross, scale, sym_vec
from plumbline.engine.memory import arena as at


@kernel
def load_wholes(trees: Trees) -> None:
    """Write momentum and outer force of every link alone."""
    link, load, g = trees.link, trees.bodies.load, load3(trees.setting, 0, at.GRAVITY)
    for i in range(link.shape[0]):
        m, r, b = link[i, tree.MASS], load3(trees.motion, i, tree.PLACE), trees.kind[i, tree.ROW]
        w, v = load3(trees.motion, i, tree.VELOCITY), centre_velocity(trees, i)
        spin = sym_vec(turned_inertia(trees, i), w)
        store6(trees.passage, i, tree.WHOLE_MOMENTUM, force_at(spin, scale(m, v), r))
        f = axpy(-m * link[i, tree.LINEAR_DAMPING], v, axpy(m, g, load3(load, b, 0)))
        torque = axpy(-link[i, tree.ANGULAR_DAMPING], spin, load3(load, b, 3))
        if trees.gyroscopic == 0:
            # What keeps w, against what would keep the angular momentum.
            torque = add(torque, cross(w, spin))
        store6(trees.passage, i, tree.WHOLE_FORCE, force_at(torque, f, r))


@kernel
def column_momenta(trees: Trees) -> None:
    """Write the momentum of every column, and into BESIDE what changes it beside the laws, where links are and move now."""
    passage, column, kind, joints = trees.passage, trees.column, trees.kind, trees.joints
    load_wholes(trees)
    for i in range(kind.shape[0] - 1, -1, -1):
        momentum, force = load6(passage, i, tree.WHOLE_MOMENTUM), load6(passage, i, tree.WHOLE_FORCE)
        carried, _a = carrier(trees, i)
        for k in range(kind[i, tree.FIRST], kind[i, tree.FIRST] + kind[i, tree.COLUMNS]):
            axis = load6(column, k, tree.AXIS_W)
            column[k, tree.MOMENTUM] = dot6(axis, momentum)
            column[k, tree.BESIDE] = dot6(across(carried, axis), momentum) + dot6(axis, force)
        j, k = kind[i, tree.JOINT], kind[i, tree.FIRST]
        if j >= 0 and joints.kind[j, at.HAS] != 0:
            column[k, tree.MOMENTUM] += joints.joint[j, at.ARMATURE] * column[k, tree.RATE]
        if kind[i, tree.PARENT] >= 0:
            add_row(passage, kind[i, tree.PARENT], tree.WHOLE_MOMENTUM, momentum)
            add_row(passage, kind[i, tree.PARENT], tree.WHOLE_FORCE, force)


@kernel
def begin_column_momenta(trees: Trees) -> None:
    """Keep the momenta that the present rates mean, and those as the last ones."""
    column = trees.column
    move_links(trees)
    column_momenta(trees)
    for k in range(column.shape[0]):
        column[k, tree.KEPT_RATE], column[k, tree.KEPT_MOMENTUM] = column[k, tree.RATE], column[k, tree.MOMENTUM]
        column[k, tree.KEPT_CHANGE] = 0.0


@kernel
def rates_of_momenta(trees: Trees) -> None:
    """Write the rates that the kept momenta mean where links are now."""
    column = trees.column
    move_links(trees)
    column_momenta(trees)
    weigh_links(trees)
    free_columns(trees)
    for k in range(column.shape[0]):
        column[k, tree.PUSH] = column[k, tree.KEPT_MOMENTUM] - column[k, tree.MOMENTUM]
        column[k, tree.BESIDE] = 0.0
    accelerations(trees, False)
    for k in range(column.shape[0]):
        column[k, tree.RATE] += trees.along[k, tree.CHANGE]
