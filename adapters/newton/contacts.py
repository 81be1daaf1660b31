"""Contacts as MuJoCo-Warp tells them: where they are at the end of the last sub-step."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from plumbline.adapters.newton.vendor import view
from plumbline.harness.trajectory import Contacts, Floats, Integers


def of_mujoco(solver: Any, model: Any, owners: Sequence[int], before: Floats, after: Floats) -> Contacts:
    """The points of MuJoCo-Warp with their forces: of the start of the sub-step, moved with the bodies to its end.

    Args: before, after (l, 7): poses of Newton's bodies then and now, quaternions (x, y, z, w).
    """
    data = solver.mjw_data
    count = int(view(data.nacon)[0])
    if count == 0:
        return Contacts.none()
    contact = data.contact
    shapes = view(solver.mjc_geom_to_newton_shape)[0]
    geoms = view(contact.geom)[:count]
    frame = view(contact.frame)[:count].reshape(-1, 3, 3).astype(np.float64)
    gap, middle = view(contact.dist)[:count].astype(np.float64), view(contact.pos)[:count].astype(np.float64)
    normal, half = frame[:, 0], 0.5 * gap[:, None] * frame[:, 0]
    first, second = shapes[geoms[:, 0]], shapes[geoms[:, 1]]
    bodies = view(model.shape_body)
    p = _placed(after, bodies[first], _body_fixed(before, bodies[first], middle - half))
    q = _placed(after, bodies[second], _body_fixed(before, bodies[second], middle + half))
    return _contacts(owners, first, second, p, q, normal, _forces(solver, contact, count, frame))


def _forces(solver: Any, contact: Any, count: int, frame: Floats) -> Floats:
    """Forces (count, 3) N on the second geom, in W. Source: `contact_force_fn` of MuJoCo-Warp."""
    address, sizes = view(contact.efc_address)[:count], view(contact.dim)[:count]
    rows, friction = view(solver.mjw_data.efc.force)[0], view(contact.friction)[:count]
    pyramid = int(solver.mjw_model.opt.cone) == 0
    local = np.zeros((count, 3))
    for k in range(count):
        size = int(sizes[k])
        # What there was no room for has no row, which `Stepper.notices` tells.
        if address[k, 0] < 0 or address[k, : max(1, size if not pyramid else 2 * (size - 1))].max() >= len(rows):
            continue
        if pyramid and size > 1:
            edges = rows[address[k, 0] : address[k, 0] + 2 * (size - 1)]
            local[k, 0] = edges.sum()
            for axis in range(min(size - 1, 2)):
                local[k, 1 + axis] = friction[k, axis] * (edges[2 * axis] - edges[2 * axis + 1])
        else:
            for axis in range(min(size, 3)):
                local[k, axis] = rows[address[k, axis]]
    force: Floats = np.einsum("ki,kij->kj", local, frame)
    return force


def _contacts(
    owners: Sequence[int], first: Integers, second: Integers, p: Floats, q: Floats, normal: Floats, force: Floats
) -> Contacts:
    """Points half-way between p and q that overlap or bear a force."""
    gap = np.einsum("ki,ki->k", q - p, normal)
    touch = (gap <= 0.0) | force.any(axis=1)
    if not touch.any():
        return Contacts.none()
    owner = np.asarray(owners)
    return Contacts.of(
        owner[first[touch]], owner[second[touch]], (0.5 * (p + q))[touch], normal[touch], gap[touch], force[touch]
    )


def _turn(q: Floats, vector: Floats) -> Floats:
    """Vectors (k, 3) turned by quaternions (k, 4) in the order (x, y, z, w)."""
    u, w = q[:, :3], q[:, 3:]
    t = 2.0 * np.cross(u, vector)
    turned: Floats = vector + w * t + np.cross(u, t)
    return turned


def _placed(poses: Floats, bodies: Integers, points: Floats) -> Floats:
    """Points of bodies in W; those of the world, whose number is -1, are there."""
    placed = np.asarray(points, dtype=np.float64).copy()
    moved = bodies >= 0
    at = poses[bodies[moved]].astype(np.float64)
    placed[moved] = at[:, :3] + _turn(at[:, 3:], placed[moved])
    return placed


def _body_fixed(poses: Floats, bodies: Integers, points: Floats) -> Floats:
    """Points of W in bodies."""
    fixed = points.copy()
    moved = bodies >= 0
    at = poses[bodies[moved]].astype(np.float64)
    back = at[:, 3:] * np.array([-1.0, -1.0, -1.0, 1.0])
    fixed[moved] = _turn(back, points[moved] - at[:, :3])
    return fixed
