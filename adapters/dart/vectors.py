"""Vectors and turns as arrays."""

import numpy as np

from plumbline.harness.trajectory import Floats


def tangents(normal: Floats) -> Floats:
    """Two directions (2, 3) across a unit vector and each other."""
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    return np.vstack((first, np.cross(normal, first)))


def cross_matrix(a: Floats) -> Floats:
    """The matrix (3, 3) of a x."""
    return np.cross(np.eye(3), a).T


def quaternions(turn: Floats) -> Floats:
    """Unit quaternions (w, x, y, z) of rotation vectors [rad], shape (n, 3) to (n, 4)."""
    half = np.linalg.norm(turn, axis=1) / 2
    # numpy's sinc is sin(pi x)/(pi x), and so finite at zero.
    return np.column_stack((np.cos(half), turn * (0.5 * np.sinc(half / np.pi))[:, None]))
