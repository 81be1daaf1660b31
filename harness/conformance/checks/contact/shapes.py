"""Checks of geometry: every shape rests at the height that its size says, and has all the contacts that its form needs."""

from math import pi, sqrt

import numpy as np

from plumbline.harness.adapter import Feature, Unsupported
from plumbline.harness.conformance.check import Comparisons, firm, near, said
from plumbline.harness.conformance.checks.contract.features import CORNERS, SIDES, TWO_BLOCKS, box_mesh
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.conformance.frames import UPRIGHT, X, Y, Z, aligned, vector
from plumbline.harness.conformance.scenes import G, ball, block, ground, lean, on_ground, shaped, static
from plumbline.harness.scene.body import Body, PlacedShape
from plumbline.harness.scene.motion import axis_angle, multiply
from plumbline.harness.scene.scene import Scene
from plumbline.harness.scene.shape import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    Plane,
    Shape,
    Sphere,
    TriangleMesh,
    principal_inertia,
)
from plumbline.harness.scene.values import Quaternion
from plumbline.harness.trajectory import Floats

_GIVES = "contacts give way by less than 3 mm; a wrong size is off by centimetres"
_X_UP: Quaternion = axis_angle(Y, -pi / 2)
_Y_UP: Quaternion = axis_angle(X, pi / 2)
_BOX_WAYS = ((UPRIGHT, 0.3), (_X_UP, 0.1), (_Y_UP, 0.2))


def _resting(engine: Engine, shape: Shape, ways: tuple[tuple[Quaternion, float], ...]) -> Comparisons:
    """Put the shape on the ground in several orientations, each with the height of its centre.

    Touching, it must stay there, or it is smaller than it should be. Lifted by 2 cm it must fall freely at first, or it is
    larger: an engine may leave a deep overlap as it is for a while, but lets nothing fall into it.
    """
    inertia = principal_inertia(0.1, 0.1, 0.1)
    resting, lifted = (
        tuple(
            shaped(f"way{k}", shape, inertia=inertia, p_WB=(3.0 * k, 1.0, height + lift), q_WB=q)
            for k, (q, height) in enumerate(ways)
        )
        for lift in (0.0, 0.02)
    )
    # Without friction, so that the law among the bodies themselves suits every combination rule.
    end = engine.final(on_ground(engine, *resting, friction=0.0), 0.15)
    t = 0.05
    fall = engine.final(on_ground(engine, *lifted, friction=0.0), t)
    yield near(f"heights of a resting {shape.type} [m]", end.p_WB[1:, 2], [height for _, height in ways], 3e-3, _GIVES)
    yield near("sideways [m]", end.p_WB[1:, :2], [(3.0 * k, 1.0) for k in range(len(ways))], 3e-3, "it rests")
    what = "v_z of one let go 2 cm above the ground [m/s]"
    yield near(what, fall.v_WB[1:, 2], [-G * t] * len(ways), 0.05 * G * t, "free fall")


@firm("Is a sphere's size its radius?", Feature.SPHERE)
def sphere_radius_is_a_radius(engine: Engine) -> Comparisons:
    return _resting(engine, Sphere(radius=0.15), ((UPRIGHT, 0.15),))


@firm("Are a box's extents half, each along its own axis?", Feature.BOX)
def box_extents_are_half(engine: Engine) -> Comparisons:
    return _resting(engine, Box(half_extents=(0.1, 0.2, 0.3)), _BOX_WAYS)


@firm("Are the extents of a static box half as well, and is there nothing beside it?", Feature.BOX | Feature.SPHERE)
def box_ground_extents_are_half(engine: Engine) -> Comparisons:
    table = static("ground", Box(half_extents=(0.5, 0.5, 0.25)), p=(0.0, 0.0, 1.0))
    inside, outside = ball("inside", p=(0.4, 0.0, 1.35)), ball("outside", p=(0.0, 0.7, 1.35))
    scene = Scene(bodies=(table, inside, outside), surfaces=(ground(), ground(other="block")))
    end = engine.final(scene, 0.15)
    yield near("height of a ball on the table [m]", end.p_WB[1, 2], 1.35, 3e-3, _GIVES)
    yield near("height of a ball beside it [m]", end.p_WB[2, 2], 1.35 - G * 0.15**2 / 2, 5e-3, "it falls freely")


@firm("Is a capsule held on its cap and on its side, by half_length + radius and by radius?", Feature.CAPSULE)
def capsule_is_a_capsule(engine: Engine) -> Comparisons:
    return _resting(engine, Capsule(radius=0.06, half_length=0.25), ((UPRIGHT, 0.31), (_X_UP, 0.06)))


@firm("Is a cylinder held on its end and on its side, by half_length and by radius?", Feature.CYLINDER)
def cylinder_is_a_cylinder(engine: Engine) -> Comparisons:
    return _resting(engine, Cylinder(radius=0.12, half_length=0.25), ((UPRIGHT, 0.25), (_X_UP, 0.12)))


@firm("Is an ellipsoid held on the end of each axis, by that semi-axis?", Feature.ELLIPSOID)
def ellipsoid_is_an_ellipsoid(engine: Engine) -> Comparisons:
    """It rests on each end of its axes; on the longer two it stands as a pencil does, and has no time to fall.

    Each in a scene of its own: an engine may know ellipsoids, and no two of them together.
    """
    found = [list(_resting(engine, Ellipsoid(semi_axes=(0.1, 0.2, 0.3)), (way,))) for way in _BOX_WAYS]
    yield from next((each for each in found if not all(compared.holds for compared in each)), found[0])


@firm("Does a convex hull reach to its vertices and no further?", Feature.CONVEX_HULL)
def convex_hull_is_its_vertices(engine: Engine) -> Comparisons:
    return _resting(engine, ConvexHull(vertices=CORNERS), _BOX_WAYS)


def _on_mesh(engine: Engine, mesh: TriangleMesh, places: tuple[tuple[float, float], ...]) -> Floats:
    """Heights [m] after .15 s of balls of 10 cm let go 40 cm above the middle of a static mesh, whose top is at 30 cm."""
    balls = tuple(ball(f"ball{k}", p=(x, y, 0.4)) for k, (x, y) in enumerate(places))
    scene = Scene(bodies=(static("ground", mesh), *balls), surfaces=(ground(), ground(other="block")))
    return engine.final(scene, 0.15).p_WB[1:, 2]


@firm("Does a triangle mesh hold what lies on it, and nothing beside it?", Feature.TRIANGLE_MESH | Feature.SPHERE)
def triangle_mesh_is_its_faces(engine: Engine) -> Comparisons:
    z = _on_mesh(engine, TriangleMesh(vertices=CORNERS, faces=SIDES), ((-0.03, -0.1), (0.6, 0.6)))
    yield near("height of the ball on the mesh [m]", z[0], 0.4, 3e-3, _GIVES)
    yield near("height of the ball beside the mesh [m]", z[1], 0.4 - G * 0.15**2 / 2, 5e-3, "it falls freely")


@firm("Is a mesh that is not convex either what it is, or refused?", Feature.TRIANGLE_MESH | Feature.SPHERE)
def triangle_mesh_is_not_its_hull(engine: Engine) -> Comparisons:
    """One mesh of two blocks with a gap: a ball lies on each, one falls through the gap, which a convex hull would close."""
    mesh = TriangleMesh(vertices=TWO_BLOCKS[0], faces=TWO_BLOCKS[1])
    try:
        z = _on_mesh(engine, mesh, ((-0.53, -0.1), (0.54, 0.07), (0.0, 0.0)))
    except Unsupported as refusal:
        yield said(f"refused: {refusal}")
        return
    yield near("heights of the balls on the blocks of the mesh [m]", z[:2], (0.4, 0.4), 3e-3, _GIVES)
    yield near("height of the ball in the gap [m]", z[2], 0.4 - G * 0.15**2 / 2, 5e-3, "a mesh is not its convex hull")


@firm(
    "Does a body of one mesh that is not convex stand on its faces, whatever its hull would stand on?",
    Feature.MOVING_MESH | Feature.PLANE | Feature.BOX,
)
def moving_mesh_is_its_faces(engine: Engine) -> Comparisons:
    """Two blocks with a gap, one mesh and one body, set down astride a post that their hull would stand on.

    Once on a plane with a post that is a box, once on one mesh of slab and post, which may be refused.
    """
    blocks = TriangleMesh(vertices=TWO_BLOCKS[0], faces=TWO_BLOCKS[1])
    slab, post = box_mesh((1.0, 0.5, 0.1), (0.0, 0.0, -0.1)), box_mesh((0.2, 0.1, 0.2), (0.0, 0.0, 0.2))
    both = TriangleMesh(vertices=slab[0] + post[0], faces=SIDES + tuple((a + 8, b + 8, c + 8) for a, b, c in SIDES))
    floors = {
        "a plane and a box": (
            static("ground", Plane()), static("post", Box(half_extents=(0.2, 0.1, 0.2)), p=(0.0, 0.0, 0.2))
        ),
        "a mesh": (static("ground", both),),
    }  # fmt: skip
    body = shaped("blocks", blocks, inertia=principal_inertia(0.05, 0.3, 0.27), p_WB=(0.0, 0.0, 0.3))
    for name, bodies in floors.items():
        try:
            end = engine.final(Scene(bodies=(*bodies, body), surfaces=(ground(0.5),)), 0.25)
        except Unsupported:
            if name != "a mesh":
                raise
            return
        yield near(f"height of the blocks on {name} [m]", end.p_WB[-1, 2], 0.3, 3e-3, "a mesh that moves is not its hull")
        yield aligned(f"turned on {name} [rad]", end.q_WB[-1], UPRIGHT, 0.01, "it stands on both")


@firm("Is a plane solid below its normal, given in its own frame?", Feature.PLANE | Feature.SPHERE)
def plane_normal_points_out(engine: Engine) -> Comparisons:
    """Gravity along -x holds a ball against a plane with the normal +x, given in S and by turning the body."""
    for how, wall in (
        ("normal (1, 0, 0)", static("ground", Plane(normal=(1.0, 0.0, 0.0)), p=(0.5, 0.0, 0.0))),
        ("normal z turned to x", static("ground", Plane(), p=(0.5, 0.0, 0.0), q=axis_angle(Y, pi / 2))),
    ):
        held = ball(p=(0.6, 2.0, 3.0))
        end = engine.final(Scene(bodies=(wall, held), surfaces=(ground(),), gravity=(-G, 0.0, 0.0)), 0.15)
        yield near(f"ball on a plane, {how} [m]", end.p_WB[1], (0.6, 2.0, 3.0), 3e-3, _GIVES)


@firm("Does a body of several shapes touch with each of them?", Feature.COMPOUND | Feature.SPHERE)
def compound_keeps_all_shapes(engine: Engine) -> Comparisons:
    """A dumbbell lies on both its balls; with one of them missing it would tip over at once."""
    balls = tuple(PlacedShape(shape=Sphere(radius=r), p_BS=(x, 0.0, r - 0.1)) for x, r in ((-0.3, 0.1), (0.3, 0.05)))
    body = shaped("dumbbell", *balls, inertia=principal_inertia(0.02, 0.1, 0.1), p_WB=(0.0, 0.0, 0.1))
    end = engine.final(on_ground(engine, body), 0.2)
    yield near("height of the dumbbell [m]", end.p_WB[1, 2], 0.1, 3e-3, _GIVES)
    yield aligned("tilt [rad]", end.q_WB[1], UPRIGHT, 0.02, "3 mm over .3 m; one ball alone lets it tip by .5 rad")


@firm("Does a shape stand in its body where p_BS and q_BS say?", Feature.BOX)
def shapes_are_placed_in_B(engine: Engine) -> Comparisons:
    """A long box turned by q_BS and moved by p_BS within its body stands upright on the ground."""
    placed = PlacedShape(shape=Box(half_extents=(0.3, 0.1, 0.1)), p_BS=(0.0, 0.0, 0.05), q_BS=axis_angle(Y, 0.4))
    # The body is turned back by the same angle less a quarter turn, so that the box's long axis points up.
    back = axis_angle(Y, -pi / 2 - 0.4)
    offset = np.array([0.05 * np.sin(-pi / 2 - 0.4), 0.0, 0.05 * np.cos(-pi / 2 - 0.4)])
    p = np.array([0.0, 0.0, 0.3]) - offset
    body = shaped("body", placed, inertia=principal_inertia(0.1, 0.1, 0.1), p_WB=vector(p), q_WB=back)
    end = engine.final(on_ground(engine, body), 0.15)
    yield near("place of the body [m]", end.p_WB[1], p, 3e-3, _GIVES)
    yield aligned("turn of the body [rad]", end.q_WB[1], back, 0.02, "it stands on a face .2 m wide")


def _tipped(engine: Engine, support: Body) -> Comparisons:
    """A cube on a slope of 1:2 with much friction: its weight passes through its face, one contact point cannot hold it."""
    cube = block("cube", half=(0.2, 0.2, 0.2), p=(0.0, 0.0, 0.2))
    end = engine.final(Scene(bodies=(support, cube), surfaces=(ground(1.0),), gravity=lean(0.5)), 0.4)
    because = "the tipping torque is half of m g w/2; on one contact point it would turn by 1 rad"
    yield aligned("tilt of the cube [rad]", end.q_WB[1], UPRIGHT, 0.02, because)
    yield near("its height [m]", end.p_WB[1, 2], 0.2, 3e-3, _GIVES)


@firm("Does a box on a plane resist tipping, as a face does and a point does not?", Feature.BOX | Feature.PLANE)
def box_on_plane_has_a_face_contact(engine: Engine) -> Comparisons:
    return _tipped(engine, static("ground", Plane()))


@firm("Does a box on a box resist tipping?", Feature.BOX)
def box_on_box_has_a_face_contact(engine: Engine) -> Comparisons:
    return _tipped(engine, static("ground", Box(half_extents=(5.0, 5.0, 0.5)), p=(0.0, 0.0, -0.5)))


@firm("Does a box that leans over an edge meet a box with a parallel edge, in whatever direction?", Feature.BOX)
def box_on_parallel_edges_is_borne(engine: Engine) -> Comparisons:
    """Cubes on an edge, each on a slab turned as it is: what rounding leaves of parallel edges must not hide a contact."""
    count, half = 48, 0.1
    height, t = sqrt(2) * half, 0.03
    bodies: list[Body] = []
    for k in range(count):
        turn = axis_angle(Z, 2.0 * pi * (k + 0.25) / count)
        tilted = multiply(turn, axis_angle(Y, pi / 4))
        bodies.append(static(f"slab{k}", Box(half_extents=(0.5, 0.5, 0.1)), p=(3.0 * k, 0.0, -0.1), q=turn))
        bodies.append(block(f"cube{k}", half=(half, half, half), p=(3.0 * k, 0.0, height - 1e-6), q=tilted))
    surfaces = (ground(0.5), ground(0.5, other="block"))
    end = engine.final(Scene(bodies=tuple(bodies), surfaces=surfaces), t)
    because = "contacts give way by less than .3 mm; free fall is 4.4 mm, and .3 mm after 8 ms"
    yield near("heights of the cubes [m]", end.p_WB[1::2, 2], [height] * count, 3e-4, because)
