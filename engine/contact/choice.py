"""Which compiled narrow phase answers the pairs of a world that have no closed form, and what sorts them by colours."""

from collections.abc import Callable

from plumbline.engine.maths.types import Floats, Ints

Collide = Callable[[Floats, Ints], None]


def load_collide(moving_meshes: bool) -> Collide:
    """That of convex shapes, or, where forces move triangle meshes, the one that knows these too."""
    if moving_meshes:
        from plumbline.engine.contact.collide_meshes import collide_meshes

        return collide_meshes
    from plumbline.engine.contact.collide_convex import collide_convex

    return collide_convex


def load_sorting(coloured: bool) -> Collide | None:
    """What sorts the pairs of a step by colours, where these are wanted."""
    if not coloured:
        return None
    from plumbline.engine.contact.colours import sort_pairs

    return sort_pairs
