"""A range finder in front of a convex hull and of a triangle mesh: does every beam end on a face?"""

from plumbline.harness.case import Case, Check, Count, Parameters
from plumbline.harness.case.bounds import SINGLE
from plumbline.harness.metrics import ranges
from plumbline.harness.scene import WORLD, Body, ConvexHull, Lidar, Scene, TriangleMesh, Vector3, axis_angle
from plumbline.harness.sensors.true_views import seen

DURATION, RATE = 0.2, 10.0
REACH = 8.0
GRAZING = 0.01
"""No beam of the default pattern meets a face at a smaller cosine of incidence; a test holds this."""

HULL: tuple[Vector3, ...] = (
    (-0.5, -0.5, -0.25), (0.5, -0.5, -0.25), (0.5, 0.5, -0.25), (-0.5, 0.5, -0.25), (0.0, 0.0, 0.75), (0.75, 0.0, 0.125),
)  # fmt: skip
"""A skew pyramid; all numbers are exact in single precision, in which some engines hold vertices."""
OCTAHEDRON: tuple[Vector3, ...] = ((1.0, 0, 0), (-1.0, 0, 0), (0, 1.0, 0), (0, -1.0, 0), (0, 0, 0.75), (0, 0, -0.75))
FACES = ((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5))


class P(Parameters):
    channels: Count = 16
    columns: Count = 180


def scene(p: P) -> Scene:
    """Two turned polyhedra to the sides of a range finder that hangs in the world."""
    hull = Body.fixed("hull", ConvexHull(vertices=HULL), p_WB=(2.1, 0.3, 0.1), q_WB=axis_angle((0.3, 0.2, 1.0), 0.6))
    mesh = Body.fixed(
        "mesh", TriangleMesh(vertices=OCTAHEDRON, faces=FACES), p_WB=(-2.3, 0.7, -0.2), q_WB=axis_angle((1.0, 0.4, 0.2), 0.8)
    )
    lidar = Lidar(
        name="lidar",
        body=WORLD,
        rate=RATE,
        q_BS=axis_angle((0.6, 1.0, 0.3), 0.1),
        channels=p.channels,
        columns=p.columns,
        max_range=REACH,
    )
    return Scene(bodies=(hull, mesh), sensors=(lidar,), gravity=(0.0, 0.0, 0.0))


expected = seen(scene)

RANGE_BOUND = 8 * SINGLE * REACH / GRAZING

CASE = Case.of(
    globals(),
    title="A range finder, a hull and a mesh",
    question="Do an engine's rays end on the faces of a convex hull and of a triangle mesh?",
    source="Kay, Kajiya, Ray tracing complex scenes (1986); Moeller, Trumbore, ray/triangle intersection (1997)",
    truth="closed form",
    sample_interval=0.1,
    checks=(
        Check(
            ranges.range_error_max,
            RANGE_BOUND,
            "vertices and faces in single precision: eight roundings of the reach over the cosine of the most grazing beam",
        ),
        Check(ranges.range_false_return_share, 0.0, "no beam passes an edge so closely that rounding decides what it meets"),
        Check(
            ranges.intensity_error_max,
            64 * SINGLE,
            "normals are those of faces and do not move with the hit; a few roundings in single precision",
        ),
    ),
    observe=(ranges.range_error_rms,),
)
