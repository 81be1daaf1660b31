"""Which meshes are their own hulls."""

import numpy as np

from plumbline.harness.adapter.convex_meshes import is_convex

CUBE = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
SIDES = np.array(
    [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]
)  # fmt: skip


def test_a_closed_cube_is_its_hull_at_any_size_and_place() -> None:
    for size in (1e-3, 1.0, 1e3):
        assert is_convex(size * CUBE + np.array([3.0, -2.0, 1.0]) * size, SIDES)


def test_a_cube_without_a_face_or_with_a_dent_is_not() -> None:
    assert not is_convex(CUBE, SIDES[1:])
    dented = CUBE.copy()
    dented[7] -= 0.4
    assert not is_convex(dented, SIDES)


def test_two_cubes_beside_each_other_are_no_hull() -> None:
    both = np.vstack((CUBE, CUBE + np.array([2.0, 0.0, 0.0])))
    assert not is_convex(both, np.vstack((SIDES, SIDES + len(CUBE))))
