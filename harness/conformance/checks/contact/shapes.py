"""Checks of geometry: every shape rests at the height that its size says, and has all the contacts that its form needs."""

from math import pi, sqrt

import numpy as np

from plumbline.harness.adapter import Adapter, Feature, Settings, Unsupported
from plumbline.harness.conformance.check import CheckResult, Compared, check, judge, near
from plumbline.harness.conformance.checks.contract.features import CORNERS, SIDES, TWO_BLOCKS, box_mesh
from plumbline.harness.conformance.room import FINE, final
from plumbline.harness.conformance.scenes import G, angle_between, ball, block, floor, ground, on_ground, static
from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    PlacedShape,
    Plane,
    Quaternion,
    Scene,
    Shape,
    Sphere,
    Surface,
    TriangleMesh,
    Vector3,
    axis_angle,
    multiply,
    principal_inertia,
)
from plumbline.harness.trajectory import Floats

_GIVES = "contacts give way by less than 3 mm; a wrong size is off by centimetres"
_UPRIGHT: Quaternion = (1.0, 0.0, 0.0, 0.0)
_X_UP: Quaternion = axis_angle((0.0, 1.0, 0.0), -pi / 2)
_Y_UP: Quaternion = axis_angle((1.0, 0.0, 0.0), pi / 2)


def _resting(adapter: Adapter, settings: Settings, shape: Shape, ways: tuple[tuple[Quaternion, float], ...]) -> CheckResult:
    """Put the shape on the ground in several orientations, each with the height of its centre.

    Touching, it must stay there, or it is smaller than it should be. Lifted by 2 cm it must fall freely at first, or it is
    larger: an engine may leave a deep overlap as it is for a while, but lets nothing fall into it.
    """
    above = 0.02
    resting, lifted = (
        tuple(
            Body(
                name=f"way{k}",
                inertia=principal_inertia(0.1, 0.1, 0.1),
                collision=(PlacedShape(shape=shape),),
                material="block",
                p_WB=(3.0 * k, 1.0, height + lift),
                q_WB=q,
            )
            for k, (q, height) in enumerate(ways)
        )
        for lift in (0.0, above)
    )
    # Without friction, so that the law among the bodies themselves suits every combination rule.
    end = final(adapter, on_ground(adapter, *resting, friction=0.0), settings.with_dt(FINE), 0.15)
    t = 0.05
    fall = final(adapter, on_ground(adapter, *lifted, friction=0.0), settings.with_dt(FINE), t)
    return judge(
        near(f"heights of a resting {shape.type} [m]", end.p_WB[1:, 2], [height for _, height in ways], 3e-3, _GIVES),
        near("sideways [m]", end.p_WB[1:, :2], [(3.0 * k, 1.0) for k in range(len(ways))], 3e-3, "it rests"),
        near(
            "v_z of one let go 2 cm above the ground [m/s]", fall.v_WB[1:, 2], [-G * t] * len(ways), 0.05 * G * t, "free fall"
        ),
    )


@check("Is a sphere's size its radius?", Feature.SPHERE, firm=True)
def sphere_radius_is_a_radius(adapter: Adapter, settings: Settings) -> CheckResult:
    return _resting(adapter, settings, Sphere(radius=0.15), ((_UPRIGHT, 0.15),))


@check("Are a box's extents half, each along its own axis?", Feature.BOX, firm=True)
def box_extents_are_half(adapter: Adapter, settings: Settings) -> CheckResult:
    shape = Box(half_extents=(0.1, 0.2, 0.3))
    return _resting(adapter, settings, shape, ((_UPRIGHT, 0.3), (_X_UP, 0.1), (_Y_UP, 0.2)))


@check("Are the extents of a static box half as well, and is there nothing beside it?", Feature.BOX | Feature.SPHERE, firm=True)
def box_ground_extents_are_half(adapter: Adapter, settings: Settings) -> CheckResult:
    table = static("ground", Box(half_extents=(0.5, 0.5, 0.25)), p=(0.0, 0.0, 1.0))
    inside, outside = ball("inside", p=(0.4, 0.0, 1.35)), ball("outside", p=(0.0, 0.7, 1.35))
    scene = Scene(bodies=(table, inside, outside), surfaces=(ground(), Surface(between=("block", "block"))))
    end = final(adapter, scene, settings.with_dt(FINE), 0.15)
    return judge(
        near("height of a ball on the table [m]", end.p_WB[1, 2], 1.35, 3e-3, _GIVES),
        near("height of a ball beside it [m]", end.p_WB[2, 2], 1.35 - G * 0.15**2 / 2, 5e-3, "it falls freely"),
    )


@check("Is a capsule held on its cap and on its side, by half_length + radius and by radius?", Feature.CAPSULE, firm=True)
def capsule_is_a_capsule(adapter: Adapter, settings: Settings) -> CheckResult:
    return _resting(adapter, settings, Capsule(radius=0.06, half_length=0.25), ((_UPRIGHT, 0.31), (_X_UP, 0.06)))


@check("Is a cylinder held on its end and on its side, by half_length and by radius?", Feature.CYLINDER, firm=True)
def cylinder_is_a_cylinder(adapter: Adapter, settings: Settings) -> CheckResult:
    return _resting(adapter, settings, Cylinder(radius=0.12, half_length=0.25), ((_UPRIGHT, 0.25), (_X_UP, 0.12)))


@check("Is an ellipsoid held on the end of each axis, by that semi-axis?", Feature.ELLIPSOID, firm=True)
def ellipsoid_is_an_ellipsoid(adapter: Adapter, settings: Settings) -> CheckResult:
    """It rests on each end of its axes; on the longer two it stands as a pencil does, and has no time to fall.

    Each in a scene of its own: an engine may know ellipsoids, and no two of them together.
    """
    shape, ways = Ellipsoid(semi_axes=(0.1, 0.2, 0.3)), ((_UPRIGHT, 0.3), (_X_UP, 0.1), (_Y_UP, 0.2))
    findings = [_resting(adapter, settings, shape, (way,)) for way in ways]
    return next((finding for finding in findings if finding.status == "failed"), findings[0])


@check("Does a convex hull reach to its vertices and no further?", Feature.CONVEX_HULL, firm=True)
def convex_hull_is_its_vertices(adapter: Adapter, settings: Settings) -> CheckResult:
    return _resting(adapter, settings, ConvexHull(vertices=CORNERS), ((_UPRIGHT, 0.3), (_X_UP, 0.1), (_Y_UP, 0.2)))


def _on_mesh(adapter: Adapter, settings: Settings, mesh: TriangleMesh, places: tuple[tuple[float, float], ...]) -> Floats:
    """Heights [m] after .15 s of balls of 10 cm let go 40 cm above the middle of a static mesh, whose top is at 30 cm."""
    balls = tuple(ball(f"ball{k}", p=(x, y, 0.4)) for k, (x, y) in enumerate(places))
    scene = Scene(bodies=(static("ground", mesh), *balls), surfaces=(ground(), Surface(between=("block", "block"))))
    return final(adapter, scene, settings.with_dt(FINE), 0.15).p_WB[1:, 2]


@check("Does a triangle mesh hold what lies on it, and nothing beside it?", Feature.TRIANGLE_MESH | Feature.SPHERE, firm=True)
def triangle_mesh_is_its_faces(adapter: Adapter, settings: Settings) -> CheckResult:
    z = _on_mesh(adapter, settings, TriangleMesh(vertices=CORNERS, faces=SIDES), ((-0.03, -0.1), (0.6, 0.6)))
    return judge(
        near("height of the ball on the mesh [m]", z[0], 0.4, 3e-3, _GIVES),
        near("height of the ball beside the mesh [m]", z[1], 0.4 - G * 0.15**2 / 2, 5e-3, "it falls freely"),
    )


@check("Is a mesh that is not convex either what it is, or refused?", Feature.TRIANGLE_MESH | Feature.SPHERE, firm=True)
def triangle_mesh_is_not_its_hull(adapter: Adapter, settings: Settings) -> CheckResult:
    """One mesh of two blocks with a gap: a ball lies on each, one falls through the gap, which a convex hull would close."""
    mesh = TriangleMesh(vertices=TWO_BLOCKS[0], faces=TWO_BLOCKS[1])
    try:
        z = _on_mesh(adapter, settings, mesh, ((-0.53, -0.1), (0.54, 0.07), (0.0, 0.0)))
    except Unsupported as refusal:
        return CheckResult("passed", f"refused: {refusal}")
    return judge(
        near("heights of the balls on the blocks of the mesh [m]", z[:2], (0.4, 0.4), 3e-3, _GIVES),
        near("height of the ball in the gap [m]", z[2], 0.4 - G * 0.15**2 / 2, 5e-3, "a mesh is not its convex hull"),
    )


@check(
    "Does a body of one mesh that is not convex stand on its faces, whatever its hull would stand on?",
    Feature.MOVING_MESH | Feature.PLANE | Feature.BOX,
    firm=True,
)
def moving_mesh_is_its_faces(adapter: Adapter, settings: Settings) -> CheckResult:
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
    inertia = principal_inertia(0.05, 0.3, 0.27)
    body = Body(name="blocks", inertia=inertia, collision=(PlacedShape(shape=blocks),), material="block", p_WB=(0.0, 0.0, 0.3))
    found: list[Compared] = []
    for name, bodies in floors.items():
        scene = Scene(bodies=(*bodies, body), surfaces=(ground(0.5),))
        try:
            end = final(adapter, scene, settings.with_dt(FINE), 0.25)
        except Unsupported:
            if not found:
                raise
            continue
        found += [
            near(f"height of the blocks on {name} [m]", end.p_WB[-1, 2], 0.3, 3e-3, "a mesh that moves is not its hull"),
            near(f"turned on {name} [rad]", angle_between(end.q_WB[-1], _UPRIGHT), 0.0, 0.01, "it stands on both"),
        ]
    return judge(*found)


@check("Is a plane solid below its normal, given in its own frame?", Feature.PLANE | Feature.SPHERE, firm=True)
def plane_normal_points_out(adapter: Adapter, settings: Settings) -> CheckResult:
    """Gravity along -x holds a ball against a plane with the normal +x, given in S and by turning the body."""
    comparisons = []
    for how, wall in (
        ("normal (1, 0, 0)", static("ground", Plane(normal=(1.0, 0.0, 0.0)), p=(0.5, 0.0, 0.0))),
        ("normal z turned to x", static("ground", Plane(), p=(0.5, 0.0, 0.0), q=axis_angle((0.0, 1.0, 0.0), pi / 2))),
    ):
        scene = Scene(bodies=(wall, ball(p=(0.6, 2.0, 3.0))), surfaces=(ground(),), gravity=(-G, 0.0, 0.0))
        end = final(adapter, scene, settings.with_dt(FINE), 0.15)
        comparisons.append(near(f"ball on a plane, {how} [m]", end.p_WB[1], (0.6, 2.0, 3.0), 3e-3, _GIVES))
    return judge(*comparisons)


@check("Does a body of several shapes touch with each of them?", Feature.COMPOUND | Feature.SPHERE, firm=True)
def compound_keeps_all_shapes(adapter: Adapter, settings: Settings) -> CheckResult:
    """A dumbbell lies on both its balls; with one of them missing it would tip over at once."""
    balls = tuple(PlacedShape(shape=Sphere(radius=r), p_BS=(x, 0.0, r - 0.1)) for x, r in ((-0.3, 0.1), (0.3, 0.05)))
    body = Body(
        name="dumbbell", inertia=principal_inertia(0.02, 0.1, 0.1), collision=balls, material="block", p_WB=(0.0, 0.0, 0.1)
    )
    end = final(adapter, on_ground(adapter, body), settings.with_dt(FINE), 0.2)
    return judge(
        near("height of the dumbbell [m]", end.p_WB[1, 2], 0.1, 3e-3, _GIVES),
        near(
            "tilt [rad]",
            angle_between(end.q_WB[1], _UPRIGHT),
            0.0,
            0.02,
            "3 mm over .3 m; one ball alone lets it tip by .5 rad",
        ),
    )


@check("Does a shape stand in its body where p_BS and q_BS say?", Feature.BOX, firm=True)
def shapes_are_placed_in_B(adapter: Adapter, settings: Settings) -> CheckResult:
    """A long box turned by q_BS and moved by p_BS within its body stands upright on the ground."""
    placed = PlacedShape(shape=Box(half_extents=(0.3, 0.1, 0.1)), p_BS=(0.0, 0.0, 0.05), q_BS=axis_angle((0.0, 1.0, 0.0), 0.4))
    # The body is turned back by the same angle less a quarter turn, so that the box's long axis points up.
    back = axis_angle((0.0, 1.0, 0.0), -pi / 2 - 0.4)
    offset = np.array([0.05 * np.sin(-pi / 2 - 0.4), 0.0, 0.05 * np.cos(-pi / 2 - 0.4)])
    p = np.array([0.0, 0.0, 0.3]) - offset
    body = Body(
        name="body",
        inertia=principal_inertia(0.1, 0.1, 0.1),
        collision=(placed,),
        material="block",
        p_WB=(float(p[0]), 0.0, float(p[2])),
        q_WB=back,
    )
    end = final(adapter, Scene(bodies=(floor(adapter), body), surfaces=(ground(0.5),)), settings.with_dt(FINE), 0.15)
    return judge(
        near("place of the body [m]", end.p_WB[1], p, 3e-3, _GIVES),
        near("turn of the body [rad]", angle_between(end.q_WB[1], back), 0.0, 0.02, "it stands on a face .2 m wide"),
    )


def _tipped(adapter: Adapter, settings: Settings, support: Body) -> CheckResult:
    """A cube on a slope of 1:2 with much friction: its weight passes through its face, one contact point cannot hold it."""
    slope = 0.5
    lean: Vector3 = (G * slope / sqrt(1 + slope**2), 0.0, -G / sqrt(1 + slope**2))
    cube = block("cube", half=(0.2, 0.2, 0.2), p=(0.0, 0.0, 0.2))
    scene = Scene(bodies=(support, cube), surfaces=(ground(1.0),), gravity=lean)
    end = final(adapter, scene, settings.with_dt(FINE), 0.4)
    because = "the tipping torque is half of m g w/2; on one contact point it would turn by 1 rad"
    return judge(
        near("tilt of the cube [rad]", angle_between(end.q_WB[1], _UPRIGHT), 0.0, 0.02, because),
        near("its height [m]", end.p_WB[1, 2], 0.2, 3e-3, _GIVES),
    )


@check("Does a box on a plane resist tipping, as a face does and a point does not?", Feature.BOX | Feature.PLANE, firm=True)
def box_on_plane_has_a_face_contact(adapter: Adapter, settings: Settings) -> CheckResult:
    return _tipped(adapter, settings, static("ground", Plane()))


@check("Does a box on a box resist tipping?", Feature.BOX, firm=True)
def box_on_box_has_a_face_contact(adapter: Adapter, settings: Settings) -> CheckResult:
    return _tipped(adapter, settings, static("ground", Box(half_extents=(5.0, 5.0, 0.5)), p=(0.0, 0.0, -0.5)))


@check("Does a box that leans over an edge meet a box with a parallel edge, in whatever direction?", Feature.BOX, firm=True)
def box_on_parallel_edges_is_borne(adapter: Adapter, settings: Settings) -> CheckResult:
    """Cubes on an edge, each on a slab turned as it is: what rounding leaves of parallel edges must not hide a contact."""
    count, half = 48, 0.1
    height, t = sqrt(2) * half, 0.03
    bodies: list[Body] = []
    for k in range(count):
        turn = axis_angle((0.0, 0.0, 1.0), 2.0 * pi * (k + 0.25) / count)
        tilted = multiply(turn, axis_angle((0.0, 1.0, 0.0), pi / 4))
        bodies.append(static(f"slab{k}", Box(half_extents=(0.5, 0.5, 0.1)), p=(3.0 * k, 0.0, -0.1), q=turn))
        bodies.append(block(f"cube{k}", half=(half, half, half), p=(3.0 * k, 0.0, height - 1e-6), q=tilted))
    surfaces = (ground(0.5), Surface.rough(0.5, ("block", "block")))
    end = final(adapter, Scene(bodies=tuple(bodies), surfaces=surfaces), settings.with_dt(FINE), t)
    because = "contacts give way by less than .3 mm; free fall is 4.4 mm, and .3 mm after 8 ms"
    return judge(near("heights of the cubes [m]", end.p_WB[1::2, 2], [height] * count, 3e-4, because))
