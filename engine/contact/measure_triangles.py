"""Where many pairs of triangles cross, by the same test as the contacts of two meshes."""

from engine.compile.jit import entry
from engine.maths.rows import Floats, Ints, load9, store3
from engine.narrow.triangle_triangle import triangle_triangle


@entry
def measure_triangles(one: Floats, two: Floats, kind: Ints, ends: Floats) -> None:
    """Write how each pair meets, with the edges on which the ends of its segment lie, and these ends [m].

    Args: one, two (k, 9): corners by rows [m]; kind (k, 3), ends (k, 6): as `triangle_triangle` returns them.
    """
    for k in range(one.shape[0]):
        met, first, last, begins, stops = triangle_triangle(load9(one, k, 0), load9(two, k, 0))
        kind[k, 0], kind[k, 1], kind[k, 2] = met, begins, stops
        store3(ends, k, 0, first)
        store3(ends, k, 3, last)
