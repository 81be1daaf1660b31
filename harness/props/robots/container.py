"""A floor and four walls: what heaps lie in."""

from plumbline.harness.scene import Body, Plane

WALLS = {"west": (1, 0, 0), "east": (-1, 0, 0), "south": (0, 1, 0), "north": (0, -1, 0)}
"""Names and the normals that point inwards."""


def container(reach: float, material: str) -> tuple[Body, ...]:
    """The half spaces under z = 0 and beyond `reach` [m] to the four sides, all static and of one material."""
    floor = Body.fixed("floor", Plane(), material=material)
    walls = (
        Body.fixed(name, Plane(normal=(x, y, z)), material=material, p_WB=(-reach * x, -reach * y, 0.0))
        for name, (x, y, z) in WALLS.items()
    )
    return (floor, *walls)
