"""Ellipsoids as polyhedra, for engines that have none: only where the robot's companion asks for it."""

from dataclasses import replace

import numpy as np

from plumbline.harness.scene import ConvexHull, Ellipsoid, polyhedron_of
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.robot import Geometry, Robot

ELEMENT = "geom ellipsoid"
"""What rows on ellipsoids are of."""


def as_polyhedra(robot: Robot) -> Robot:
    """The robot whose ellipsoids that touch are the hulls of points on them, with a row that says how far those lie inside."""
    links, names, inside = [], [], 0.0
    for link in robot.links:
        made = []
        for geometry in link.geometries:
            if isinstance(geometry.shape, Ellipsoid):
                names.append(link.name)
                inside = max(inside, _inside(geometry.shape))
                made.append(Geometry(ConvexHull(vertices=polyhedron_of(geometry.shape)), geometry.X_LG, geometry.contact))
            else:
                made.append(geometry)
        links.append(replace(link, geometries=tuple(made)))
    if not names:
        return robot
    words = "as the companion asks; it rocks on its facets, and contacts lie inside the true surface by up to"
    row = Fidelity.approximated(ELEMENT, names, "a polyhedron of 162 corners", consequence=words, value=inside, unit="m")
    rows = tuple(each for each in robot.rows if each.element != ELEMENT)
    return replace(robot, links=tuple(links), rows=rows).told(row)


def _inside(shape: Ellipsoid) -> float:
    """How far the facets lie inside the ellipsoid at most [m], its largest semi-axis times that of the unit ball's."""
    from scipy.spatial import ConvexHull as Hull  # late: a listing must not pay for it

    planes = Hull(np.array(polyhedron_of(Ellipsoid(semi_axes=(1.0, 1.0, 1.0))))).equations
    return float(max(shape.semi_axes) * (1 + planes[:, 3]).max())
