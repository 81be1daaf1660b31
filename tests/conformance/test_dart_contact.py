"""Contact in DART: its detectors and what each has right, combination rules, sleeping, the exact cone."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.adapter import Settings, Unsupported
from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Effect,
    Plane,
    Revolute,
    Scene,
    Shape,
    Sphere,
    Surface,
    TriangleMesh,
    axis_angle,
    multiply,
    principal_inertia,
)

pytest.importorskip("dartpy", reason="DART is not installed")

from plumbline.adapters.dart import ADAPTER
from plumbline.adapters.dart.detectors import DETECTORS
from plumbline.cases import friction_wall_pinch
from tests.conformance.dart_scenes import (
    CUBE,
    DEFAULT,
    PD,
    TUNED,
    G,
    box_body,
    ground_body,
    hinged_wheel,
    solid_body,
    state_after,
    state_of,
    surface_law,
    with_options,
)
from tests.conformance.put import put

SLAB = Box(half_extents=(5.0, 5.0, 0.5))


@pytest.mark.parametrize("ground_first", [True, False])
@pytest.mark.parametrize("detector", DETECTORS)
def test_contact_forces_carry_the_box_under_every_detector_whatever_order_it_reports(detector: str, ground_first: bool) -> None:
    bodies = (ground_body(SLAB, (0.0, 0.0, -0.5)), box_body())
    scene = Scene(bodies=bodies if ground_first else bodies[::-1], surfaces=(surface_law(),))
    simulation = ADAPTER.build(scene, with_options(detector=detector))
    simulation.step(500)
    contacts = simulation.contacts()
    upwards = 1.0 if ground_first else -1.0
    assert len(contacts) == 4
    # The box has come to rest within half a second: the sum is m g but for what is left of its jitter.
    np.testing.assert_allclose(contacts.force_W.sum(axis=0), (0.0, 0.0, upwards * G), atol=1e-3 * G)
    np.testing.assert_allclose(contacts.normal_W, [(0.0, 0.0, upwards)] * 4, atol=1e-6)
    assert (contacts.body_A < contacts.body_B).all()


def test_a_sleeping_box_keeps_the_contacts_that_carry_it() -> None:
    for height in (0.1, 0.15):
        simulation = ADAPTER.build(
            Scene(bodies=(ground_body(), box_body(p=(0.0, 0.0, height))), surfaces=(surface_law(),)),
            with_options(track=DEFAULT),
        )
        simulation.step(3000)
        assert simulation.resolved.options["deactivation"]
        # The forces are those of up to 0.1 s before sleep, at speeds below 1 cm/s: 2 % of m g.
        np.testing.assert_allclose(simulation.contacts().force_W.sum(axis=0), (0.0, 0.0, G), atol=0.02 * G)


@pytest.mark.parametrize("track", [TUNED, DEFAULT])
def test_a_lying_capsule_rests_on_its_own_radius_and_not_on_fcl_s_stand_in(track: Settings) -> None:
    capsule = solid_body(
        "c", Capsule(radius=0.2, half_length=0.3), (0.0, 0.0, 0.2), q_WB=axis_angle((0.0, 1.0, 0.0), np.pi / 2)
    )
    scene = Scene(bodies=(ground_body(), capsule), surfaces=(surface_law(),))
    simulation = ADAPTER.build(scene, with_options(track=track))
    simulation.step(500)
    assert simulation.resolved.options["detector"] == "ode"
    assert any("capsule" in notice.text for notice in simulation.warnings()) == (track is DEFAULT)
    # FCL's ball of 0.1 m would let it sink by 0.1 m; DART's contacts give way by micrometres.
    assert abs(state_of(simulation, scene).p_WB[1, 2] - 0.2) < 1e-4


def test_a_detector_that_has_a_shape_wrong_is_refused_when_asked_for() -> None:
    for detector, shape in (
        ("fcl", Capsule(radius=0.1, half_length=0.1)),
        ("fcl", ConvexHull(vertices=CUBE)),
        ("dart", ConvexHull(vertices=CUBE)),
    ):
        scene = Scene(
            bodies=(ground_body(SLAB, (0.0, 0.0, -0.5)), solid_body("x", shape, (0.0, 0.0, 0.1))), surfaces=(surface_law(),)
        )
        with pytest.raises(Unsupported, match=shape.type):
            ADAPTER.build(scene, with_options(detector=detector))
    with pytest.raises(Unsupported, match="plane"):
        ADAPTER.build(Scene(bodies=(ground_body(), box_body()), surfaces=(surface_law(),)), with_options(detector="dart"))


def test_hulls_stack_without_creeping_and_fit_the_box_that_they_are() -> None:
    hull = ConvexHull(vertices=CUBE)
    scene = Scene(
        bodies=(ground_body(), solid_body("a", hull, (0.0, 0.0, 0.1)), solid_body("b", hull, (0.02, 0.0, 0.3))),
        surfaces=(surface_law(), surface_law(between=("b", "b"))),
    )
    end = state_after(scene, 2.0, with_options(1 / 240))
    # ODE's sideways normals between meshes push them apart by millimetres a second; a box of these sizes stays.
    np.testing.assert_allclose(end.p_WB[1:], [(0.0, 0.0, 0.1), (0.02, 0.0, 0.3)], atol=1e-3)


def test_a_ball_lies_in_the_groove_of_a_mesh_that_its_hull_would_fill() -> None:
    outline = ((-1.0, -1.0), (1.0, -1.0), (1.0, 0.5), (0.0, -0.5), (-1.0, 0.5))
    vertices = tuple((x, y, z) for y in (-1.0, 1.0) for x, z in outline)
    front = ((0, 1, 3), (1, 2, 3), (0, 3, 4))
    sides = tuple(face for i in range(5) for face in ((i, i + 5, (i + 1) % 5), ((i + 1) % 5, i + 5, (i + 1) % 5 + 5)))
    faces = front + tuple((a + 5, c + 5, b + 5) for a, b, c in front) + sides
    height = -0.5 + 0.2 * np.sqrt(2)
    scene = Scene(
        bodies=(
            ground_body(TriangleMesh(vertices=vertices, faces=faces)),
            solid_body("ball", Sphere(radius=0.2), (0.0, 0.0, height)),
        ),
        surfaces=(surface_law(),),
    )
    # The groove of 45 degrees holds a ball with its centre at r sqrt 2 over its bottom; the hull would lie 0.9 m higher.
    np.testing.assert_allclose(state_after(scene, 0.5).p_WB[1], (0.0, 0.0, height), atol=1e-3)


def _pair_scene(*laws: Surface) -> Scene:
    a = solid_body("a", Sphere(radius=0.1), (0.0, 0.0, 0.1), "a", v_WB=(1.0, 0.0, 0.0))
    b = solid_body("b", Sphere(radius=0.1), (0.0, 2.0, 0.1), "b", v_WB=(1.0, 0.0, 0.0))
    return Scene(bodies=(ground_body(), a, b), surfaces=laws)


def test_numbers_per_material_give_each_pair_its_friction_and_restitution() -> None:
    laws = (surface_law(0.2, 0.5, ("g", "a")), surface_law(0.8, 0.25, ("g", "b")), surface_law(0.2, 0.125, ("a", "b")))
    simulation = ADAPTER.build(_pair_scene(*laws), with_options())
    simulation.step(100)
    bodies = state_of(simulation, _pair_scene(*laws))
    # A ball that slips loses mu g t; b grips after 2 v0/(7 mu g) = 36 ms and then rolls at 5/7 v0.
    np.testing.assert_allclose(bodies.v_WB[1:, 0], (1 - 0.2 * G * 0.1, 5 / 7), atol=3e-3)


@pytest.mark.parametrize(
    ("laws", "rule"),
    [
        ((surface_law(0.1, 0.0, ("g", "a")), surface_law(0.8, 0.0, ("g", "b")), surface_law(0.3, 0.0, ("a", "b"))), "smaller"),
        (
            (surface_law(0.2, 0.5, ("g", "a")), surface_law(0.2, 0.25, ("g", "b")), surface_law(0.2, 0.9, ("a", "b"))),
            "multiplies",
        ),
        (
            (surface_law(0.2, 0.5, ("g", "a")), surface_law(0.2, 0.5, ("g", "b")), surface_law(0.2, 0.0, ("a", "b"))),
            "multiplies",
        ),
        (
            (surface_law(1e-3, 0.0, ("g", "a")), surface_law(0.2, 0.0, ("g", "b")), surface_law(1e-3, 0.0, ("a", "b"))),
            "for zero",
        ),
    ],
)
def test_pairs_that_no_numbers_per_material_give_are_refused(laws: tuple[Surface, ...], rule: str) -> None:
    with pytest.raises(Unsupported, match=rule):
        ADAPTER.build(_pair_scene(*laws), with_options())


@pytest.mark.parametrize("azimuth", [0.0, 45.0])
def test_a_sliding_box_stops_where_coulomb_says_in_any_direction(azimuth: float) -> None:
    towards = np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth)), 0.0])
    scene = Scene(bodies=(ground_body(), box_body(v_WB=tuple(2.0 * towards))), surfaces=(surface_law(0.4),))
    end = state_after(scene, 1.0)
    # v0^2/(2 mu g); a semi-implicit step errs by v0 dt/2, which is 0.2 %.
    assert abs(end.p_WB[1] @ towards / (4 / (2 * 0.4 * G)) - 1) < 3e-3


def test_the_exact_cone_holds_boxes_at_a_wall_as_well_as_the_default_solver() -> None:
    """On one axis box and cone are the same law; a tenth is what two solutions of it may differ by."""
    tuned, default = (put(friction_wall_pinch.CASE, ADAPTER, track.with_dt(1 / 240)) for track in (TUNED, DEFAULT))
    assert not tuned.broken
    assert tuned["position_error_max"] < 1.1 * default["position_error_max"]


@pytest.mark.parametrize("restitution", [0.5, 0.8])
def test_a_dropped_ball_returns_at_the_restitution_of_the_scene(restitution: float) -> None:
    scene = Scene(
        bodies=(ground_body(), solid_body("x", Sphere(radius=0.1), (0.0, 0.0, 0.3))), surfaces=(surface_law(0.0, restitution),)
    )
    simulation = ADAPTER.build(scene, with_options())
    speeds = []
    for _ in range(300):
        simulation.step()
        speeds.append(state_of(simulation, scene).v_WB[1, 2])
    # Speed before and after the same step: the ratio is e, but for one step of gravity in either, g dt/v = 0.5 %.
    assert abs(max(speeds) / -min(speeds) - restitution) < 0.01


def test_a_stack_of_ten_boxes_stays_upright_and_still() -> None:
    scene = Scene(
        bodies=(ground_body(), *(box_body(f"b{i}", (0.0, 0.0, 0.1 + 0.2 * i)) for i in range(10))),
        surfaces=(surface_law(), surface_law(between=("b", "b"))),
    )
    simulation = ADAPTER.build(scene, with_options(1 / 240))
    simulation.step(480)
    assert simulation.resolved.solver == "dantzig"
    end, contacts = state_of(simulation, scene), simulation.contacts()
    # A millimetre in 2 m and a millimetre a second lie far above DART's jitter and far below a fall.
    np.testing.assert_allclose(end.p_WB[10], (0.0, 0.0, 1.9), atol=1e-3)
    assert np.abs(end.v_WB).max() < 1e-3
    np.testing.assert_allclose(contacts.force_W[contacts.body_A == 0].sum(axis=0), (0.0, 0.0, 10 * G), atol=0.1)


@pytest.mark.parametrize(("collide", "expected"), [(False, 0), (True, 4)])
def test_jointed_bodies_collide_only_if_the_joint_says_so(collide: bool, expected: int) -> None:
    joint = Revolute(name="j", parent="a", child="b", anchor_W=(0.075, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0), collide=collide)
    scene = Scene(
        bodies=(box_body("a"), box_body("b", (0.15, 0.0, 0.1))), joints=(joint,), surfaces=(surface_law(between=("b", "b")),)
    )
    simulation = ADAPTER.build(scene, with_options())
    simulation.step()
    assert len(simulation.contacts()) == expected


def test_more_contacts_than_dart_keeps_are_told() -> None:
    crowd = tuple(box_body(f"b{i}", (0.3 * (i % 17), 0.3 * (i // 17), 0.0999)) for i in range(260))
    simulation = ADAPTER.build(
        Scene(bodies=(ground_body(), *crowd), surfaces=(surface_law(), surface_law(between=("b", "b")))), with_options(1 / 240)
    )
    assert not any("contacts reached" in notice.text for notice in simulation.warnings())
    simulation.step()
    # 260 boxes of four contacts each are 40 more than the vendor's bound.
    assert [notice.kind for notice in simulation.warnings() if "contacts reached 1000" in notice.text] == ["capacity"]


def test_effects_that_are_narrowed_away_are_not_simulated() -> None:
    scene = Scene(bodies=(ground_body(), box_body(v_WB=(1.0, 0.0, 0.0))), surfaces=(surface_law(),))
    assert abs(state_after(replace(scene, narrow=Effect.CONTACT), 0.5).v_WB[1, 2] + G * 0.5) < 1e-9
    assert abs(state_after(replace(scene, narrow=Effect.FRICTION), 0.5).v_WB[1, 0] - 1.0) < 1e-6
    weightless = state_after(replace(hinged_wheel(drive=PD), narrow=Effect.DRIVES), 0.5)
    np.testing.assert_allclose(weightless.w_WB, np.zeros((1, 3)), atol=0.0)
    ADAPTER.build(replace(hinged_wheel(drive=PD), narrow=Effect.DRIVES), with_options()).command({"hinge": 1.0})
    fast = ADAPTER.build(replace(scene, widen=Effect.CONTINUOUS_COLLISION), with_options())
    assert Effect.CONTINUOUS_COLLISION in {notice.effect for notice in fast.warnings() if notice.kind == "missing"}
    top = Body(name="top", inertia=principal_inertia(1.0, 2.0, 2.5), w_WB=(1.0, 2.0, 3.0))
    told = ADAPTER.build(Scene(bodies=(top,), narrow=Effect.GYROSCOPIC), with_options()).warnings()
    assert Effect.GYROSCOPIC in {notice.effect for notice in told if notice.kind == "surplus"}


LYING = axis_angle((1.0, 0.0, 0.0), np.pi / 2)
ROUND_PAIRS: dict[str, tuple[Shape, float, Shape, tuple[float, float, float, float]]] = {
    "capsule on box": (Box(half_extents=(0.5, 0.5, 0.1)), -0.1, Capsule(radius=0.1, half_length=0.15), LYING),
    "cylinder on box": (Box(half_extents=(0.5, 0.5, 0.1)), -0.1, Cylinder(radius=0.1, half_length=0.15), LYING),
    "capsule on cylinder": (Cylinder(radius=0.5, half_length=0.1), -0.1, Capsule(radius=0.1, half_length=0.15), LYING),
    "cylinder on cylinder": (Cylinder(radius=0.5, half_length=0.1), -0.1, Cylinder(radius=0.1, half_length=0.15), LYING),
    "box on cylinder": (Cylinder(radius=0.5, half_length=0.1), -0.1, Box(half_extents=(0.1, 0.1, 0.1)), (1.0, 0.0, 0.0, 0.0)),
}
"""Support, its height, mover, its turn."""


@pytest.mark.parametrize("track", [TUNED, DEFAULT])
@pytest.mark.parametrize("pair", ROUND_PAIRS)
def test_round_shapes_rest_at_their_height_whatever_lies_under_them(pair: str, track: Settings) -> None:
    support, depth, shape, q_WB = ROUND_PAIRS[pair]
    scene = Scene(
        bodies=(ground_body(support, (0.0, 0.0, depth)), solid_body("x", shape, (0.0, 0.0, 0.1), q_WB=q_WB)),
        surfaces=(surface_law(0.8),),
    )
    # It falls for one step before its contact is found, g dt^2 = 0.17 mm, and is lifted from there on.
    assert abs(state_after(scene, 3.0, with_options(1 / 240, track)).p_WB[1, 2] - 0.1) < G / 240**2


def test_pairs_of_which_no_detector_has_all_right_are_refused_by_name() -> None:
    mesh = TriangleMesh(vertices=CUBE, faces=((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)))
    round_ones = (
        solid_body("capsule", Capsule(radius=0.1, half_length=0.1), (0.0, 0.0, 1.0)),
        solid_body("cylinder", Cylinder(radius=0.1, half_length=0.1), (1.0, 0.0, 1.0)),
    )
    scene = Scene(bodies=(ground_body(mesh), *round_ones), surfaces=(surface_law(), surface_law(between=("b", "b"))))
    for track in (TUNED, DEFAULT):
        with pytest.raises(Unsupported, match=r"capsule/cylinder.*cylinder/triangle_mesh"):
            ADAPTER.build(scene, with_options(track=track))
    # Bodies that never meet do not count.
    parted = replace(scene, apart=(("b", "b"),), surfaces=(surface_law(),))
    assert ADAPTER.build(parted, with_options()).resolved.options["detector"] == "ode"


def test_a_plane_by_the_bullet_detector_is_a_slab_that_brakes_a_box_as_coulomb_says_and_meets_rays_as_a_plane() -> None:
    pillar = solid_body("pillar", Capsule(radius=0.1, half_length=0.5), (3.0, 5.0, 0.6))
    sunk = Plane(normal=(0.0, 0.0, 2.0))
    scene = Scene(
        bodies=(ground_body(sunk), box_body(v_WB=(2.0, 0.0, 0.0)), pillar),
        surfaces=(surface_law(0.5), surface_law(between=("b", "b"))),
    )
    simulation = ADAPTER.build(scene, with_options(1 / 240))
    assert simulation.resolved.options["detector"] == "bullet"
    simulation.step(240)
    # v0^2/(2 mu g), and v0 dt/2 of a semi-implicit step; on the vendor's plane it tumbles over its one contact.
    box = state_of(simulation, scene).p_WB[1]
    assert abs(box[0] - 4 / (2 * 0.5 * G)) < 2 / 240
    assert abs(box[2] - 0.1) < G / 240**2
    hits = simulation.cast(np.array([(9e3, 0.0, 2.0), (0.3, 4.0, 2.0)]), np.array([(0.0, 0.0, -1.0)] * 2), 10.0)
    np.testing.assert_allclose(hits.distance, (2.0, 2.0), atol=1e-9)
    assert hits.body.tolist() == [0, 0]


@pytest.mark.parametrize("settings", [with_options(1 / 240, detector="ode"), replace(TUNED, dt=1 / 240)], ids=("ode", "tuned"))
def test_a_box_on_an_edge_parallel_to_one_of_what_bears_it_is_borne_in_every_direction(settings: Settings) -> None:
    """ODE's detector alone lets 3 of these 100 fall."""
    height = math.sqrt(2) * 0.1
    for yaw in np.random.default_rng(0).uniform(0.0, 2 * math.pi, 100).tolist():
        about = axis_angle((0.0, 0.0, 1.0), yaw)
        tilted = multiply(about, axis_angle((0.0, 1.0, 0.0), math.pi / 4))
        slab = Body.fixed("slab", Box(half_extents=(1.0, 1.0, 0.1)), p_WB=(0.0, 0.0, -0.1), q_WB=about)
        cube = Body.box("cube", (0.1, 0.1, 0.1), mass=1.0, p_WB=(0.0, 0.0, height - 1e-6), q_WB=tilted)
        state = state_after(Scene(bodies=(slab, cube), surfaces=(Surface.rough(0.5),)), 8 * settings.dt, settings)
        # In eight steps it would fall by .0055 m; what keeps it grants a step's fall.
        assert state.p_WB[1, 2] > height - G * settings.dt**2, yaw
