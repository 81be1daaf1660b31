"""Rotations between the frames of a scene and those of an engine."""

import numpy as np
import pytest

from plumbline.harness.adapter.rotations import conjugate, matrix, principal_frame, products
from plumbline.harness.scene import Body, multiply


def test_a_principal_frame_gives_the_tensor_back() -> None:
    random = np.random.default_rng(3)
    for _ in range(50):
        root = random.normal(size=(3, 3))
        # Moments that are sums of squares of two axes each obey the triangle inequality.
        tensor = np.trace(root @ root.T) * np.eye(3) - root @ root.T
        tensor = (tensor + tensor.T) / 2
        moments, q_BP = principal_frame(Body(name="b", inertia=tuple(map(tuple, tensor.tolist()))))
        R_BP = matrix(q_BP)
        # Some tens of roundings of numbers as large as the tensor's greatest.
        assert R_BP @ np.diag(moments) @ R_BP.T == pytest.approx(tensor, abs=1e-14 * np.abs(tensor).max())
        assert np.linalg.det(R_BP) == pytest.approx(1.0)


def test_products_row_by_row_are_those_of_single_quaternions() -> None:
    random = np.random.default_rng(4)
    a, b = random.normal(size=(2, 5, 4))
    assert products(a, b).tolist() == [list(multiply(tuple(p), tuple(q))) for p, q in zip(a, b, strict=True)]
    q = (0.5, -0.5, 0.5, 0.5)
    assert multiply(q, conjugate(q)) == (1.0, 0.0, 0.0, 0.0)
