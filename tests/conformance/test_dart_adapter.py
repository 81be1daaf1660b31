"""What is particular to DART: its detectors, combination rules, loops, implicit springs and sleeping."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from harness.adapter import Diverged, Settings, SettingsError, Simulation, Unsupported
from harness.conformance.exact import angle_between, first_hit, rotation
from harness.scene import (
    WORLD,
    Ball,
    Body,
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Distance,
    Drive,
    Effect,
    Fixed,
    Joint,
    Limits,
    PlacedShape,
    Plane,
    Prismatic,
    Revolute,
    Scene,
    Shape,
    Sphere,
    Spring,
    Surface,
    TriangleMesh,
    Vector3,
    axis_angle,
    box_inertia,
    capsule_inertia,
    multiply,
    principal_inertia,
    sphere_inertia,
)
from harness.trajectory import Floats, State

pytest.importorskip("dartpy", reason="DART is not installed")

from adapters.dart import ADAPTER
from adapters.dart.detectors import DETECTORS
from adapters.dart.solvers import SOLVERS
from cases import friction_wall_pinch, joint_conical_pendulum, spin_heavy_top, stand_quadruped
from tests.conformance.put import put

TUNED, DEFAULT = ADAPTER.tracks["tuned"], ADAPTER.tracks["default"]
FINE = 1e-3
G = 9.81
FLOOR = Plane()
CUBE = tuple((x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1))


def _settings(dt: float = FINE, track: Settings = TUNED, **options: object) -> Settings:
    return replace(track, dt=dt, options={**track.options, **options})


def _state(simulation: Simulation, scene: Scene) -> State:
    out = State.empty(len(scene.bodies))
    simulation.state(out)
    return out


def _after(scene: Scene, duration: float, settings: Settings | None = None) -> State:
    settings = settings or _settings()
    simulation = ADAPTER.build(scene, settings)
    simulation.step(round(duration / settings.dt))
    return _state(simulation, scene)


def _solid(name: str, shape: Shape, p: Vector3, material: str = "b", **more: object) -> Body:
    inertia = {
        "sphere": lambda: sphere_inertia(1.0, shape.radius),  # type: ignore[union-attr]
        "capsule": lambda: capsule_inertia(1.0, shape.radius, shape.half_length),  # type: ignore[union-attr]
    }.get(shape.type, lambda: box_inertia(1.0, (0.1, 0.1, 0.1)))()
    return Body(name=name, inertia=inertia, collision=(PlacedShape(shape=shape),), p_WB=p, material=material, **more)  # type: ignore[arg-type]


def _box(name: str = "box", p: Vector3 = (0.0, 0.0, 0.1), **more: object) -> Body:
    return _solid(name, Box(half_extents=(0.1, 0.1, 0.1)), p, **more)  # type: ignore[arg-type]


def _ground(shape: Shape = FLOOR, p: Vector3 = (0.0, 0.0, 0.0)) -> Body:
    return Body(name="ground", motion="static", material="g", collision=(PlacedShape(shape=shape),), p_WB=p)


def _law(friction: float = 0.5, restitution: float = 0.0, between: tuple[str, str] = ("g", "b")) -> Surface:
    return Surface(between=between, static_friction=friction, kinetic_friction=friction, restitution=restitution)


def _free(name: str, p: Vector3 = (0.0, 0.0, 0.0), moment: float = 0.1, **more: object) -> Body:
    return Body(name=name, inertia=principal_inertia(moment, moment, moment), p_WB=p, **more)  # type: ignore[arg-type]


SLAB = Box(half_extents=(5.0, 5.0, 0.5))


@pytest.mark.parametrize("ground_first", [True, False])
@pytest.mark.parametrize("detector", DETECTORS)
def test_contact_forces_carry_the_box_under_every_detector_whatever_order_it_reports(detector: str, ground_first: bool) -> None:
    bodies = (_ground(SLAB, (0.0, 0.0, -0.5)), _box())
    scene = Scene(bodies=bodies if ground_first else bodies[::-1], surfaces=(_law(),))
    simulation = ADAPTER.build(scene, _settings(detector=detector))
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
            Scene(bodies=(_ground(), _box(p=(0.0, 0.0, height))), surfaces=(_law(),)), _settings(track=DEFAULT)
        )
        simulation.step(3000)
        assert simulation.resolved.options["deactivation"]
        # The forces are those of up to 0.1 s before sleep, at speeds below 1 cm/s: 2 % of m g.
        np.testing.assert_allclose(simulation.contacts().force_W.sum(axis=0), (0.0, 0.0, G), atol=0.02 * G)


@pytest.mark.parametrize("track", [TUNED, DEFAULT])
def test_a_lying_capsule_rests_on_its_own_radius_and_not_on_fcl_s_stand_in(track: Settings) -> None:
    capsule = _solid("c", Capsule(radius=0.2, half_length=0.3), (0.0, 0.0, 0.2), q_WB=axis_angle((0.0, 1.0, 0.0), np.pi / 2))
    scene = Scene(bodies=(_ground(), capsule), surfaces=(_law(),))
    simulation = ADAPTER.build(scene, _settings(track=track))
    simulation.step(500)
    assert simulation.resolved.options["detector"] == "ode"
    assert any("capsule" in notice.text for notice in simulation.warnings()) == (track is DEFAULT)
    # FCL's ball of 0.1 m would let it sink by 0.1 m; DART's contacts give way by micrometres.
    assert abs(_state(simulation, scene).p_WB[1, 2] - 0.2) < 1e-4


def test_a_detector_that_has_a_shape_wrong_is_refused_when_asked_for() -> None:
    for detector, shape in (
        ("fcl", Capsule(radius=0.1, half_length=0.1)),
        ("fcl", ConvexHull(vertices=CUBE)),
        ("dart", ConvexHull(vertices=CUBE)),
    ):
        scene = Scene(bodies=(_ground(SLAB, (0.0, 0.0, -0.5)), _solid("x", shape, (0.0, 0.0, 0.1))), surfaces=(_law(),))
        with pytest.raises(Unsupported, match=shape.type):
            ADAPTER.build(scene, _settings(detector=detector))
    with pytest.raises(Unsupported, match="plane"):
        ADAPTER.build(Scene(bodies=(_ground(), _box()), surfaces=(_law(),)), _settings(detector="dart"))


def test_hulls_stack_without_creeping_and_fit_the_box_that_they_are() -> None:
    hull = ConvexHull(vertices=CUBE)
    scene = Scene(
        bodies=(_ground(), _solid("a", hull, (0.0, 0.0, 0.1)), _solid("b", hull, (0.02, 0.0, 0.3))),
        surfaces=(_law(), _law(between=("b", "b"))),
    )
    end = _after(scene, 2.0, _settings(1 / 240))
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
        bodies=(_ground(TriangleMesh(vertices=vertices, faces=faces)), _solid("ball", Sphere(radius=0.2), (0.0, 0.0, height))),
        surfaces=(_law(),),
    )
    # The groove of 45 degrees holds a ball with its centre at r sqrt 2 over its bottom; the hull would lie 0.9 m higher.
    np.testing.assert_allclose(_after(scene, 0.5).p_WB[1], (0.0, 0.0, height), atol=1e-3)


def _pair_scene(*laws: Surface) -> Scene:
    a = _solid("a", Sphere(radius=0.1), (0.0, 0.0, 0.1), "a", v_WB=(1.0, 0.0, 0.0))
    b = _solid("b", Sphere(radius=0.1), (0.0, 2.0, 0.1), "b", v_WB=(1.0, 0.0, 0.0))
    return Scene(bodies=(_ground(), a, b), surfaces=laws)


def test_numbers_per_material_give_each_pair_its_friction_and_restitution() -> None:
    laws = (_law(0.2, 0.5, ("g", "a")), _law(0.8, 0.25, ("g", "b")), _law(0.2, 0.125, ("a", "b")))
    simulation = ADAPTER.build(_pair_scene(*laws), _settings())
    simulation.step(100)
    bodies = _state(simulation, _pair_scene(*laws))
    # A ball that slips loses mu g t; b grips after 2 v0/(7 mu g) = 36 ms and then rolls at 5/7 v0.
    np.testing.assert_allclose(bodies.v_WB[1:, 0], (1 - 0.2 * G * 0.1, 5 / 7), atol=3e-3)


@pytest.mark.parametrize(
    ("laws", "rule"),
    [
        ((_law(0.1, 0.0, ("g", "a")), _law(0.8, 0.0, ("g", "b")), _law(0.3, 0.0, ("a", "b"))), "smaller"),
        ((_law(0.2, 0.5, ("g", "a")), _law(0.2, 0.25, ("g", "b")), _law(0.2, 0.9, ("a", "b"))), "multiplies"),
        ((_law(0.2, 0.5, ("g", "a")), _law(0.2, 0.5, ("g", "b")), _law(0.2, 0.0, ("a", "b"))), "multiplies"),
        ((_law(1e-3, 0.0, ("g", "a")), _law(0.2, 0.0, ("g", "b")), _law(1e-3, 0.0, ("a", "b"))), "for zero"),
    ],
)
def test_pairs_that_no_numbers_per_material_give_are_refused(laws: tuple[Surface, ...], rule: str) -> None:
    with pytest.raises(Unsupported, match=rule):
        ADAPTER.build(_pair_scene(*laws), _settings())


@pytest.mark.parametrize("azimuth", [0.0, 45.0])
def test_a_sliding_box_stops_where_coulomb_says_in_any_direction(azimuth: float) -> None:
    towards = np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth)), 0.0])
    scene = Scene(bodies=(_ground(), _box(v_WB=tuple(2.0 * towards))), surfaces=(_law(0.4),))
    end = _after(scene, 1.0)
    # v0^2/(2 mu g); a semi-implicit step errs by v0 dt/2, which is 0.2 %.
    assert abs(end.p_WB[1] @ towards / (4 / (2 * 0.4 * G)) - 1) < 3e-3


def test_the_exact_cone_holds_boxes_at_a_wall_as_well_as_the_default_solver() -> None:
    """On one axis box and cone are the same law; a tenth is what two solutions of it may differ by."""
    tuned, default = (put(friction_wall_pinch.CASE, ADAPTER, track.with_dt(1 / 240)) for track in (TUNED, DEFAULT))
    assert not tuned.broken
    assert tuned["position_error_max"] < 1.1 * default["position_error_max"]


@pytest.mark.parametrize("restitution", [0.5, 0.8])
def test_a_dropped_ball_returns_at_the_restitution_of_the_scene(restitution: float) -> None:
    scene = Scene(bodies=(_ground(), _solid("x", Sphere(radius=0.1), (0.0, 0.0, 0.3))), surfaces=(_law(0.0, restitution),))
    simulation = ADAPTER.build(scene, _settings())
    speeds = []
    for _ in range(300):
        simulation.step()
        speeds.append(_state(simulation, scene).v_WB[1, 2])
    # Speed before and after the same step: the ratio is e, but for one step of gravity in either, g dt/v = 0.5 %.
    assert abs(max(speeds) / -min(speeds) - restitution) < 0.01


def test_a_stack_of_ten_boxes_stays_upright_and_still() -> None:
    scene = Scene(
        bodies=(_ground(), *(_box(f"b{i}", (0.0, 0.0, 0.1 + 0.2 * i)) for i in range(10))),
        surfaces=(_law(), _law(between=("b", "b"))),
    )
    simulation = ADAPTER.build(scene, _settings(1 / 240))
    simulation.step(480)
    assert simulation.resolved.solver == "dantzig"
    end, contacts = _state(simulation, scene), simulation.contacts()
    # A millimetre in 2 m and a millimetre a second lie far above DART's jitter and far below a fall.
    np.testing.assert_allclose(end.p_WB[10], (0.0, 0.0, 1.9), atol=1e-3)
    assert np.abs(end.v_WB).max() < 1e-3
    np.testing.assert_allclose(contacts.force_W[contacts.body_A == 0].sum(axis=0), (0.0, 0.0, 10 * G), atol=0.1)


def _four_bar(q: tuple[float, float, float, float], base: Vector3, cut: str = "revolute") -> Scene:
    """A four-bar linkage in its plane x-z, turned by q and moved to base, its bodies turned once more in their own way."""
    R = rotation(q)

    def at(point: Vector3) -> Vector3:
        x, y, z = (float(c) for c in R @ np.array(point) + np.array(base))
        return x, y, z

    def bar(name: str, p: Vector3, turn: tuple[float, float, float, float]) -> Body:
        return Body(name=name, inertia=principal_inertia(0.1, 0.12, 0.15), p_WB=at(p), q_WB=multiply(q, turn))

    bars = (
        bar("left", (0.0, 0.0, 0.5), (1.0, 0.0, 0.0, 0.0)),
        bar("top", (0.65, 0.0, 1.0), axis_angle((1.0, 2.0, 3.0), 0.7)),
        bar("right", (1.25, 0.0, 0.5), axis_angle((1.0, -2.0, 0.5), 1.7)),
    )
    pins = (
        (WORLD, "left", (0.0, 0.0, 0.0)),
        ("left", "top", (0.0, 0.0, 1.0)),
        ("top", "right", (1.3, 0.0, 1.0)),
        (WORLD, "right", (1.2, 0.0, 0.0)),
    )
    joints: list[Joint] = []
    for a, b, p in pins:
        if cut == "ball" and a == "top":
            joints.append(Ball(name=f"{a}-{b}", parent=a, child=b, anchor_W=at(p)))
        else:
            joints.append(Revolute(name=f"{a}-{b}", parent=a, child=b, anchor_W=at(p), axis_W=tuple(R @ (0.0, 1.0, 0.0))))
    return Scene(bodies=bars, joints=tuple(joints), gravity=tuple(R @ (3.0, 0.0, -G)))


@pytest.mark.parametrize("cut", ["revolute", "ball"])
def test_a_four_bar_linkage_closes_its_loop_the_same_in_every_frame(cut: str) -> None:
    upright = _after(_four_bar((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), cut), 1.0)
    q, base = axis_angle((1.0, 2.0, 3.0), 1.1), (1.0, 2.0, 3.0)
    turned = _after(_four_bar(q, base, cut), 1.0)
    back = (turned.p_WB - np.array(base)) @ rotation(q)
    # The same equations in another frame: rounding alone, grown for a thousand steps.
    np.testing.assert_allclose(back, upright.p_WB, atol=1e-8)
    assert np.abs(upright.v_WB).max() > 0.1


@pytest.mark.parametrize("share", [0.01, 0.2])
def test_the_gap_of_a_cut_joint_shrinks_with_the_square_of_the_time_step(share: float) -> None:
    """Each step adds a dt^2/2 and heals a share: a dt^2/(2 share) is left."""

    def gap(dt: float) -> float:
        end = _after(_four_bar((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), 1.0, _settings(dt, error_reduction=share))
        return abs(float(np.linalg.norm(end.p_WB[2] - (1.2, 0.0, 0.0)) - np.hypot(0.05, 0.5)))

    coarse, fine = gap(1e-3), gap(5e-4)
    # The bars swing at some g, a few of them at the turning points: 60 m/s2.
    assert coarse < 60 * 1e-6 / (2 * share)
    assert fine < coarse / 3


def test_an_error_reduction_belongs_to_its_world_though_dart_has_one_for_all() -> None:
    import dartpy

    constraint = dartpy.constraint.DynamicJointConstraint
    usual = constraint.getErrorReductionParameter()
    scene = _four_bar((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    shares = (0.01, 0.2, 0.5)
    alone = [_after(scene, 0.5, _settings(error_reduction=share)) for share in shares]
    worlds = [ADAPTER.build(scene, _settings(error_reduction=share)) for share in shares]
    for _ in range(500):
        for world in worlds:
            world.step()
    for world, share, wanted in zip(worlds, shares, alone, strict=True):
        assert world.resolved.options["error_reduction"] == share
        assert (_state(world, scene).p_WB == wanted.p_WB).all()
    assert (alone[0].p_WB != alone[1].p_WB).any()
    assert constraint.getErrorReductionParameter() == usual
    assert ADAPTER.build(scene, Settings()).resolved.options["error_reduction"] == usual


@pytest.mark.parametrize("spin", [100.0, 400.0, 1600.0])
def test_a_top_stays_on_its_way_on_a_constraint_and_is_lost_on_a_reduced_coordinate_ball_joint(spin: float) -> None:
    """The case's own axis calls a tenth of the stem lost."""

    def off(**options: object) -> float:
        answer = put(spin_heavy_top.CASE, ADAPTER, _settings(1 / 960, **options), parameters={"spin": spin})
        return np.inf if answer.broke else answer["position_error_max"]

    assert off() < spin_heavy_top.LENGTH / 10
    assert off(joints="coordinates") > spin_heavy_top.LENGTH / 10


def test_which_joints_are_constraints_is_told_as_it_turned_out() -> None:
    top, pendulum = spin_heavy_top.CASE.scene(), joint_conical_pendulum.CASE.scene()
    other = Revolute(name="hinge", parent=WORLD, child="wheel", anchor_W=(0.0, 9.0, 0.0), axis_W=(1.0, 0.0, 0.0))
    mixed = Scene(bodies=(*top.bodies, _free("wheel", (0.0, 9.0, 0.0))), joints=(*top.joints, other))
    for scene, track, joints in (
        (top, TUNED, "constraints"), (pendulum, TUNED, "coordinates"), (mixed, TUNED, "auto"), (top, Settings(), "coordinates")
    ):  # fmt: skip
        assert ADAPTER.build(scene, track).resolved.options["joints"] == joints


def test_a_pendulum_that_does_not_spin_keeps_its_reduced_coordinate_ball_joint() -> None:
    """It leaves no gap: a pendulum on its circle errs by rounding alone, a thousand steps of it."""
    for tilt in (5.0, 30.0, 85.0):
        answer = put(joint_conical_pendulum.CASE, ADAPTER, _settings(1 / 240), parameters={"tilt": tilt})
        assert answer["joint_gap_max"] < 1e-12


def test_a_chain_on_constraints_converges_to_the_same_chain_in_coordinates() -> None:
    """Both are of first order, so half the step brings them twice as near; on free bodies every joint has its gap."""
    y, axis = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    links = (_free("a", (0.5, 0.0, 0.0)), _free("b", (1.5, 0.0, 0.0)), _free("c", (1.5, 0.5, 0.0)))
    joints = (
        Revolute(name="top", parent=WORLD, child="a", anchor_W=(0.0, 0.0, 0.0), axis_W=y),
        Ball(name="elbow", parent="a", child="b", anchor_W=(1.0, 0.0, 0.0)),
        Fixed(name="weld", parent="b", child="c"),
    )
    for some in (joints, (*joints[:2], Revolute(name="end", parent="b", child="c", anchor_W=(1.5, 0.3, 0.0), axis_W=axis))):
        scene = Scene(bodies=links, joints=some)
        apart = []
        for dt in (1e-3, 5e-4):
            ways = [_after(scene, 0.5, _settings(dt, joints=how)).p_WB for how in ("coordinates", "constraints")]
            apart.append(np.abs(ways[0] - ways[1]).max())
        # It falls by half a metre; v dt of it is 5 mm.
        assert 0 < apart[0] < 5e-3
        assert apart[1] < 0.6 * apart[0]


def test_a_cut_hinge_holds_its_axis_under_load() -> None:
    """The vendor's RevoluteJointConstraint amplifies a misalignment by exp(erp t/dt); two ball constraints heal it."""
    bodies = tuple(_free(name, p) for name, p in (("a", (0.0, 0.0, 0.0)), ("b", (1.0, 0.0, 0.0)), ("c", (0.0, 1.0, 0.0))))
    joints: tuple[Joint, ...] = (
        Ball(name="ab", parent="a", child="b", anchor_W=(0.5, 0.0, 0.0)),
        Ball(name="bc", parent="b", child="c", anchor_W=(0.5, 0.5, 0.0)),
        Revolute(name="ca", parent="c", child="a", anchor_W=(0.0, 0.5, 0.0), axis_W=(0.0, 0.0, 1.0)),
    )
    for order in (joints, joints[::-1], joints[1:] + joints[:1]):
        scene = Scene(bodies=bodies, joints=order, gravity=(0.0, 0.0, 0.0))
        simulation = ADAPTER.build(scene, _settings())
        simulation.wrench(np.array([(0.0, 0.0, 0.3), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)]), np.zeros((3, 3)))
        simulation.step(1000)
        end = _state(simulation, scene)
        axes = [rotation(end.q_WB[i]) @ (0.0, 0.0, 1.0) for i in (0, 2)]
        # Healing at 1 % a step against a drift of order (w dt)^2 leaves far less than a thousandth.
        assert np.linalg.norm(np.cross(axes[0], axes[1])) < 1e-3


def test_a_loop_of_sliders_and_a_distance_joint_are_refused_by_name() -> None:
    bodies = (_free("a"), _free("b", (1.0, 0.0, 0.0)))
    slider = Prismatic(name="slider", parent="a", child="b", anchor_W=(0.5, 0.0, 0.0), axis_W=(1.0, 0.0, 0.0))
    with pytest.raises(Unsupported, match="closes a loop"):
        ADAPTER.build(Scene(bodies=bodies, joints=(slider, replace(slider, name="other"))), _settings())
    rod = Distance(name="rod", parent="a", child="b", anchor_W=(0.0, 0.0, 0.0), child_anchor_W=(1.0, 0.0, 0.0))
    with pytest.raises(Unsupported, match="joint 'rod'"):
        ADAPTER.build(Scene(bodies=bodies, joints=(rod,)), _settings())


def test_initial_velocities_of_a_chain_come_back_and_those_that_break_a_joint_are_refused() -> None:
    a = _free("a", (0.5, 0.0, 0.0), v_WB=(0.0, 0.0, -1.0), w_WB=(0.0, 2.0, 0.0))
    b = _free("b", (1.5, 0.0, 0.0), v_WB=(0.0, 0.0, -0.5), w_WB=(0.0, -3.0, 0.0))
    joints = (
        Revolute(name="elbow", parent="b", child="a", anchor_W=(1.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0)),
        Revolute(name="shoulder", parent=WORLD, child="a", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0)),
    )
    scene = Scene(bodies=(b, a), joints=joints)
    got, expected = _state(ADAPTER.build(scene, _settings()), scene), State.initial(scene)
    np.testing.assert_allclose(got.v_WB, expected.v_WB, atol=1e-13)
    np.testing.assert_allclose(got.w_WB, expected.w_WB, atol=1e-13)
    with pytest.raises(Unsupported, match="joint 'elbow'"):
        ADAPTER.build(Scene(bodies=(b, replace(a, v_WB=(0.0, 0.0, -1.1))), joints=joints), _settings())


def _hinge(
    position: float = 0.2, limits: Limits | None = None, spring: Spring | None = None, drive: Drive | None = None
) -> Scene:
    hinge = Revolute(
        name="hinge",
        parent=WORLD,
        child="wheel",
        anchor_W=(0.0, 0.0, 0.0),
        axis_W=(0.0, 0.0, 1.0),
        position=position,
        limits=limits,
        spring=spring,
        drive=drive,
    )
    return Scene(bodies=(_free("wheel", moment=0.5),), joints=(hinge,), gravity=(0.0, 0.0, 0.0))


def _coordinate(scene: Scene, duration: float, settings: Settings | None = None) -> float:
    w, _, _, z = _after(scene, duration, settings).q_WB[0]
    joint = scene.joints[0]
    assert isinstance(joint, Revolute)
    return float(2 * np.arctan2(z, w) + joint.position)


PD = Drive(stiffness=50.0, damping=5.0, target=1.2, target_velocity=0.3)


def test_a_limit_out_of_reach_leaves_the_drive_exactly_as_it_is_without_one() -> None:
    free, limited = (_after(_hinge(drive=drive), 1.0) for drive in (PD, replace(PD, limit=1e9)))
    np.testing.assert_allclose(limited.q_WB, free.q_WB, atol=1e-13)
    np.testing.assert_allclose(limited.w_WB, free.w_WB, atol=1e-13)


def test_a_saturated_drive_pushes_with_its_limit() -> None:
    # Full limit for 0.3 s: the wheel is still far from its target, w = f t/I.
    end = _after(_hinge(drive=replace(PD, stiffness=500.0, target=3.0, limit=2.0)), 0.3)
    assert abs(end.w_WB[0, 2] - 2.0 * 0.3 / 0.5) < 1e-9


def test_a_stiff_limited_drive_settles_at_a_coarse_step() -> None:
    drive = replace(PD, stiffness=1e6, damping=1e4, target_velocity=0.0, limit=20.0)
    # dt sqrt(k/I) is 6: explicit forces would explode, bang-bang ones would chatter by f dt^2/I = 7e-4.
    assert abs(_coordinate(_hinge(drive=drive), 2.0, _settings(1 / 240)) - 1.2) < 1e-9


def test_a_command_moves_the_target_of_a_drive_and_names_a_joint_without_one() -> None:
    scene = _hinge(drive=replace(PD, target_velocity=0.0))
    for limit in (None, 30.0):
        scene = _hinge(drive=replace(PD, target_velocity=0.0, limit=limit))
        simulation = ADAPTER.build(scene, _settings())
        simulation.command({"hinge": -0.4})
        simulation.step(5000)
        w, _, _, z = _state(simulation, scene).q_WB[0]
        # exp(-5 t) of the way is left after 5 s.
        assert abs(2 * np.arctan2(z, w) + 0.2 + 0.4) < 1e-6
    with pytest.raises(ValueError, match="hinge"):
        ADAPTER.build(_hinge(spring=Spring(stiffness=1.0)), _settings()).command({"hinge": 0.0})


ARM_MASSES, ARM_LENGTHS, ARM_TARGETS = (3.0, 2.0, 1.0), (0.4, 0.35, 0.25), (0.5, -0.8, 0.6)
ARM_DRIVE = Drive(stiffness=200.0, damping=20.0)


def _arm() -> Scene:
    """Three links with shapes in a row along x, hinged about y, driven from rest at zero; a floor that they do not reach."""
    bodies: list[Body] = [_ground(p=(0.0, 0.0, -1.0))]
    joints: list[Joint] = []
    x, parent = 0.0, WORLD
    for i, (mass, length, target) in enumerate(zip(ARM_MASSES, ARM_LENGTHS, ARM_TARGETS, strict=True)):
        half = (length / 2, 0.02, 0.02)
        name = f"link {i}"
        bodies.append(
            Body(
                name=name,
                mass=mass,
                inertia=box_inertia(mass, half),
                collision=(PlacedShape(shape=Box(half_extents=half)),),
                p_WB=(x + length / 2, 0.0, 0.0),
                material="b",
            )
        )
        joints.append(
            Revolute(
                name=name,
                parent=parent,
                child=name,
                anchor_W=(x, 0.0, 0.0),
                axis_W=(0.0, 1.0, 0.0),
                drive=replace(ARM_DRIVE, target=target),
            )
        )
        x, parent = x + length, name
    return Scene(bodies=tuple(bodies), joints=tuple(joints), surfaces=(_law(),), apart=(("b", "b"),))


def _lagrange(duration: float) -> tuple[Floats, float]:
    """Angles [rad] of the arm's links about y after `duration` [s], and the fastest turn [rad/s], from Lagrange's equations."""
    lengths, masses = np.array(ARM_LENGTHS), np.array(ARM_MASSES)
    central = np.array([box_inertia(m, (c / 2, 0.02, 0.02))[1][1] for m, c in zip(masses, lengths, strict=True)])
    # Centre of link i is the sum of its levers[i, j] along the directions (cos, -sin) of the links j.
    levers = np.tril(np.ones((3, 3)), -1) * lengths + np.diag(lengths / 2)

    def rate(_: float, y: Floats) -> Floats:
        turn, w = y[:3], y[3:]
        inertia, force = np.diag(central), np.zeros(3)
        for i in range(3):
            way = levers[i] * np.array([-np.sin(turn), -np.cos(turn)])
            inertia += masses[i] * way.T @ way
            inward = (levers[i] * w**2 * np.array([-np.cos(turn), np.sin(turn)])).sum(axis=1)
            force += masses[i] * way.T @ (np.array([0.0, -G]) - inward)
        bend, rate_of_bend = np.diff(turn, prepend=0.0), np.diff(w, prepend=0.0)
        torque = ARM_DRIVE.stiffness * (np.array(ARM_TARGETS) - bend) - ARM_DRIVE.damping * rate_of_bend
        return np.concatenate((w, np.linalg.solve(inertia, force + torque - np.append(torque[1:], 0.0))))

    solved = solve_ivp(rate, (0.0, duration), np.zeros(6), method="Radau", rtol=1e-10, atol=1e-11)
    return solved.y[:3, -1], float(np.abs(solved.y[3:]).max())


@pytest.mark.parametrize("track", [TUNED, DEFAULT])
def test_a_driven_arm_beside_contact_converges_to_lagrange_s_equations(track: Settings) -> None:
    """A step of first order is late by a step at most: the error is below dt times the fastest turn, and goes with dt."""
    for duration in (0.2, 1.0):
        expected, fastest = _lagrange(duration)
        errors, steps = [], (1 / 240, 1e-3, 2.5e-4)
        for dt in steps:
            q = _after(_arm(), duration, _settings(dt, track)).q_WB[1:]
            errors.append(float(np.abs(2 * np.arctan2(q[:, 2], q[:, 0]) - expected).max()))
            assert errors[-1] < dt * fastest
        # The next order is dt times the rate at which the errors change, tens a second: a fifth at the coarse step.
        for k in (0, 1):
            assert errors[k] / errors[k + 1] == pytest.approx(steps[k] / steps[k + 1], rel=0.2)


def test_drives_are_foreseen_on_tuned_wherever_something_can_hold_them_and_joint_springs_elsewhere() -> None:
    standing, hung = stand_quadruped.scene(), _hinge(drive=PD)
    stopped = _hinge(drive=PD, limits=Limits(lower=-1.0))
    for scene, track, law in (
        (standing, TUNED, "stable"), (stopped, TUNED, "stable"), (hung, TUNED, "spring"), (standing, Settings(), "spring")
    ):  # fmt: skip
        assert ADAPTER.build(scene, _settings(1 / 240, track)).resolved.options["drives"] == law


@pytest.mark.parametrize("limit", [None, 20.0])
def test_a_drive_that_nothing_holds_obeys_the_same_law_foreseen_or_as_a_joint_spring(limit: float | None) -> None:
    scene = _hinge(drive=replace(PD, limit=limit), spring=Spring(stiffness=3.0, damping=0.2, rest=-0.5))
    foreseen, sprung = (ADAPTER.build(scene, _settings(1 / 240, drives=law)) for law in ("stable", "spring"))
    for simulation in (foreseen, sprung):
        simulation.step(100)
        simulation.command({"hinge": 0.5})
        simulation.step(100)
    # The same equations solved in another order: rounding alone, over two hundred steps.
    np.testing.assert_allclose(_state(foreseen, scene).q_WB, _state(sprung, scene).q_WB, atol=1e-12)
    np.testing.assert_allclose(_state(foreseen, scene).w_WB, _state(sprung, scene).w_WB, atol=1e-12)


@pytest.mark.parametrize("limit", [None, 2e3])
def test_a_servo_closes_in_on_its_target_at_stiffness_over_damping_whatever_weighs_on_it(
    limit: float | None,
) -> None:
    """x' = k/c (t - x), implicit: a step leaves 1/(1 + dt k/c) of the way, a weight of 2 N m or none."""
    dt, steps = 1 / 240, 100
    scene = _hinge(drive=replace(PD, target_velocity=0.0, limit=limit))
    for weight in (0.0, 2.0):
        simulation = ADAPTER.build(scene, _settings(dt, drives="servo"))
        assert simulation.resolved.options["drives"] == "servo"
        assert any("another law" in notice.text for notice in simulation.warnings())
        simulation.wrench(np.zeros((1, 3)), np.array([[0.0, 0.0, -weight]]))
        simulation.step(steps)
        w, _, _, z = _state(simulation, scene).q_WB[0]
        left = PD.target - (0.2 + 2 * np.arctan2(z, w))
        # DART softens the constraint by 1e-9 of its mobility.
        assert abs(left - (PD.target - 0.2) / (1 + dt * PD.stiffness / PD.damping) ** steps) < 1e-7


def test_a_servo_pushes_with_no_more_than_its_limit() -> None:
    end = _after(_hinge(drive=replace(PD, target=3.0, limit=2.0)), 0.1, _settings(drives="servo"))
    # It would go at 28 rad/s: the limit bears all the while, w = f t/I.
    assert abs(end.w_WB[0, 2] - 2.0 * 0.1 / 0.5) < 1e-9


def test_a_quadruped_stands_on_servos_at_a_sixtieth_of_a_second_without_sagging() -> None:
    """It stands where its targets are: higher than on the scene's own drives, which give way under its weight."""
    machine = stand_quadruped.scene()
    servo = _after(machine, 1.0, _settings(1 / 60, drives="servo")).p_WB[1, 2]
    finer = _after(machine, 1.0, _settings(1 / 240, drives="servo")).p_WB[1, 2]
    assert servo > State.initial(machine).p_WB[1, 2]
    assert abs(servo - finer) < G / 60**2


def test_a_servo_is_refused_where_a_spring_would_press_beside_it_beyond_a_limit() -> None:
    scene = _hinge(limits=Limits(upper=0.5), drive=PD, spring=Spring(stiffness=1.0, rest=2.0))
    with pytest.raises(Unsupported, match="servo"):
        ADAPTER.build(scene, _settings(drives="servo"))


def _on_springs(scene: Scene) -> Scene:
    """The same machine on passive springs and dampers."""
    joints = []
    for joint in scene.joints:
        assert isinstance(joint, Revolute)
        assert joint.drive is not None
        drive = joint.drive
        spring = Spring(stiffness=drive.stiffness, damping=drive.damping, rest=drive.target)
        joints.append(replace(joint, drive=None, spring=spring))
    return replace(scene, joints=tuple(joints))


@pytest.mark.parametrize("machine", [stand_quadruped.scene(), _on_springs(stand_quadruped.scene())], ids=["drives", "springs"])
def test_a_machine_in_equilibrium_stands_on_what_is_foreseen_and_sags_on_joint_springs(machine: Scene) -> None:
    """The deviation of joint springs: after a second the trunk has sunk by a centimetre at least. Foreseen, it falls for one
    step until its contacts are loaded, g dt^2, and stays: also at a step at which plain torques explode."""
    start = State.initial(machine)
    for dt in (1 / 60, 1 / 240):
        assert abs(_after(machine, 1.0, _settings(dt)).p_WB[1, 2] - start.p_WB[1, 2]) < G * dt**2
    sagged = _after(machine, 1.0, _settings(1 / 240, drives="spring"))
    assert start.p_WB[1, 2] - sagged.p_WB[1, 2] > 1e-2


def _leaning_parallelogram() -> Scene:
    """Three bars of 1 kg and 1 m that lean by half a radian, held in equilibrium by a spring at one foot."""
    lean, stiffness = 0.5, 200.0
    x, z = float(np.sin(lean)), float(np.cos(lean))
    # About +y the weights turn both cranks further, by m g sin/2 each, and by m g sin for the coupler that they carry.
    held = Spring(stiffness=stiffness, damping=20.0, rest=-2 * G * x / stiffness)
    bars = (_free("left", (x / 2, 0.0, z / 2)), _free("top", (x + 0.5, 0.0, z)), _free("right", (1 + x / 2, 0.0, z / 2)))
    pins: tuple[tuple[str, str, Vector3], ...] = (
        (WORLD, "left", (0.0, 0.0, 0.0)),
        ("left", "top", (x, 0.0, z)),
        ("top", "right", (1 + x, 0.0, z)),
        (WORLD, "right", (1.0, 0.0, 0.0)),
    )
    joints = tuple(
        Revolute(
            name=f"{a}-{b}",
            parent=a,
            child=b,
            anchor_W=p,
            axis_W=(0.0, 1.0, 0.0),
            spring=held if (a, b) == pins[0][:2] else None,
        )
        for a, b, p in pins
    )
    return Scene(bodies=bars, joints=joints)


def test_a_loop_in_equilibrium_stands_on_a_spring_that_is_foreseen_and_sags_on_a_joint_spring() -> None:
    scene = _leaning_parallelogram()
    start = State.initial(scene).p_WB[1, 2]
    foreseen, sprung = (
        _after(scene, 1.0, settings).p_WB[1, 2] for settings in (_settings(1 / 240), _settings(1 / 240, DEFAULT))
    )
    # Statics: rounding, and what makes redundant holds share; the joint spring gives way while the loop is being closed.
    assert abs(foreseen - start) < 1e-9
    assert start - sprung > 1e-4


def test_a_spring_whose_rest_lies_beyond_a_limit_presses_against_it_with_its_full_force() -> None:
    """DART refuses such a rest position on the console only; a push against the motion shows what is left."""
    limited = _hinge(limits=Limits(lower=-0.3, upper=0.5), spring=Spring(stiffness=20.0, damping=2.0, rest=2.0))
    assert abs(_coordinate(limited, 2.0) - 0.5) < 1e-6
    # Before it reaches the limit it moves as it would without: a from rest is k (rest - x)/I.
    free = _hinge(spring=Spring(stiffness=20.0, damping=2.0, rest=2.0))
    assert abs(_coordinate(limited, 0.05) - _coordinate(free, 0.05)) < 1e-12
    assert _coordinate(free, 0.05) > 0.25


def test_a_joint_hung_by_its_parent_counts_its_coordinate_the_same_way() -> None:
    """The wheel as the parent of the world's stand-in: a positive push turns the parent backwards."""
    post = Body(name="post", motion="static")
    joint = Revolute(
        name="j", parent="wheel", child="post", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 0.0, 1.0), position=0.2, drive=PD
    )
    backwards = Scene(bodies=(_free("wheel", moment=0.5), post), joints=(joint,), gravity=(0.0, 0.0, 0.0))
    np.testing.assert_allclose(_after(backwards, 0.5).w_WB[0], -_after(_hinge(drive=PD), 0.5).w_WB[0], atol=1e-12)


def test_a_kinematic_body_keeps_its_velocity_and_carries_what_is_jointed_to_it() -> None:
    arm = _free("arm", (0.0, 0.0, -1.0), v_WB=(1.0, 0.0, 0.0))
    cart = Body(name="cart", motion="kinematic", v_WB=(1.0, 0.0, 0.0))
    joint = Revolute(name="j", parent="cart", child="arm", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0))
    end = _after(Scene(bodies=(arm, cart), joints=(joint,)), 2.0)
    np.testing.assert_allclose(end.p_WB, [(2.0, 0.0, -1.0), (2.0, 0.0, 0.0)], atol=1e-9)
    table = _solid(
        "table", Cylinder(radius=1.0, half_length=0.1), (0.0, 0.0, -0.1), "g", motion="kinematic", w_WB=(0.0, 0.0, 2.0)
    )
    spun = _after(Scene(bodies=(table, _box()), surfaces=(_law(),)), 1.0)
    assert angle_between(spun.q_WB[0], axis_angle((0.0, 0.0, 1.0), 2.0)) < 1e-12
    np.testing.assert_allclose(spun.w_WB[0], (0.0, 0.0, 2.0), atol=0.0)
    # The box at the centre has gripped long ago and turns with the table.
    assert abs(spun.w_WB[1, 2] - 2.0) < 1e-3


def test_damping_of_an_asymmetric_body_is_a_rate_and_not_a_torque() -> None:
    inertia = ((0.3, 0.05, 0.02), (0.05, 0.4, 0.03), (0.02, 0.03, 0.5))
    w = np.array([1e-4, 2e-4, 3e-4])
    body = Body(name="x", inertia=inertia, v_WB=(1.0, 2.0, 3.0), w_WB=tuple(w), linear_damping=0.5, angular_damping=1.0)
    end = _after(Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0)), 1.0)
    # Implicit first order errs by c^2 t dt/2 = 5e-4; gyroscopic terms are w t = 1e-4 of w.
    np.testing.assert_allclose(end.v_WB[0], np.exp(-0.5) * np.array([1.0, 2.0, 3.0]), rtol=6e-4)
    np.testing.assert_allclose(end.w_WB[0], np.exp(-1.0) * w, rtol=1e-3)


def test_damping_as_a_force_is_implicit_at_any_step() -> None:
    """Step by step v / (1 + c dt): at c dt = 1/2 the explicit force would leave 1/2 of the speed, the implicit one 2/3.

    Products of inertia turn the axis by w dt: 1e-6 rad keep that out of seven digits.
    """
    inertia = ((0.3, 0.05, 0.02), (0.05, 0.4, 0.03), (0.02, 0.03, 0.5))
    v, w = np.array([1.0, 2.0, 3.0]), np.array([1e-6, 2e-6, 3e-6])
    body = Body(name="x", inertia=inertia, v_WB=tuple(v), w_WB=tuple(w), linear_damping=50.0, angular_damping=25.0)
    end = _after(Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0)), 0.03, _settings(dt=0.01))
    np.testing.assert_allclose(end.v_WB[0], v / 1.5**3, rtol=1e-9)
    np.testing.assert_allclose(end.w_WB[0], w / 1.25**3, rtol=1e-6)


SHAPES: tuple[Shape, ...] = (
    Sphere(radius=0.4),
    Box(half_extents=(0.3, 0.2, 0.4)),
    Capsule(radius=0.2, half_length=0.3),
    Cylinder(radius=0.3, half_length=0.4),
    Plane(normal=(1.0, 2.0, 3.0)),
    ConvexHull(vertices=tuple((3 * x, 2 * y, 4 * z) for x, y, z in CUBE)),
)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.type)
def test_rays_meet_each_shape_where_geometry_says(shape: Shape) -> None:
    q, q_BS, p, p_BS = (
        axis_angle((1, -2, 0.5), 0.9),
        axis_angle((0, 1, 1), 0.4),
        np.array([1.0, 2.0, 3.0]),
        np.array([0.1, 0.2, -0.1]),
    )
    placed = PlacedShape(shape=shape, p_BS=tuple(p_BS), q_BS=q_BS)
    target = Body(name="x", motion="static", p_WB=tuple(p), q_WB=q, collision=(placed,))
    R, centre = rotation(multiply(q, q_BS)), p + rotation(q) @ p_BS
    draw = np.random.default_rng(7)
    out = draw.normal(size=(300, 3))
    origins = centre + 3.0 * out / np.linalg.norm(out, axis=1)[:, None]
    if isinstance(shape, Plane):
        origins = origins[(origins - centre) @ R @ np.array(shape.normal) > 0]
    aims = centre + draw.uniform(-0.5, 0.5, (len(origins), 3)) - origins
    directions = aims / np.linalg.norm(aims, axis=1)[:, None]
    hits = ADAPTER.build(Scene(bodies=(_free("o", (50.0, 0.0, 0.0)), target)), _settings()).cast(origins, directions, 10.0)
    solid = SHAPES[1] if isinstance(shape, ConvexHull) else shape
    expected = np.array([first_hit(solid, (o - centre) @ R, d @ R) for o, d in zip(origins, directions, strict=True)])
    expected[expected > 10.0] = np.inf
    met = np.isfinite(expected)
    assert met.sum() > 50
    assert (np.isfinite(hits.distance) == met).all()
    assert (hits.body == np.where(met, 1, -1)).all()
    # Rounding over 10 m, grown at grazing rays; a hull's corners are single precision, 2^-24 of 0.4 m, grown alike.
    np.testing.assert_allclose(hits.distance[met], expected[met], atol=1e-6 if isinstance(shape, ConvexHull) else 1e-11)
    assert (np.einsum("ij,ij->i", hits.normal_W, directions)[met] < 0).all()


@pytest.mark.parametrize(("collide", "expected"), [(False, 0), (True, 4)])
def test_jointed_bodies_collide_only_if_the_joint_says_so(collide: bool, expected: int) -> None:
    joint = Revolute(name="j", parent="a", child="b", anchor_W=(0.075, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0), collide=collide)
    scene = Scene(bodies=(_box("a"), _box("b", (0.15, 0.0, 0.1))), joints=(joint,), surfaces=(_law(between=("b", "b")),))
    simulation = ADAPTER.build(scene, _settings())
    simulation.step()
    assert len(simulation.contacts()) == expected


def test_more_contacts_than_dart_keeps_are_told() -> None:
    crowd = tuple(_box(f"b{i}", (0.3 * (i % 17), 0.3 * (i // 17), 0.0999)) for i in range(260))
    simulation = ADAPTER.build(
        Scene(bodies=(_ground(), *crowd), surfaces=(_law(), _law(between=("b", "b")))), _settings(1 / 240)
    )
    assert not any("contacts reached" in notice.text for notice in simulation.warnings())
    simulation.step()
    # 260 boxes of four contacts each are 40 more than the vendor's bound.
    assert any("contacts reached 1000" in notice.text for notice in simulation.warnings())


def test_effects_that_are_narrowed_away_are_not_simulated() -> None:
    scene = Scene(bodies=(_ground(), _box(v_WB=(1.0, 0.0, 0.0))), surfaces=(_law(),))
    assert abs(_after(replace(scene, narrow=Effect.CONTACT), 0.5).v_WB[1, 2] + G * 0.5) < 1e-9
    assert abs(_after(replace(scene, narrow=Effect.FRICTION), 0.5).v_WB[1, 0] - 1.0) < 1e-6
    weightless = _after(replace(_hinge(drive=PD), narrow=Effect.DRIVES), 0.5)
    np.testing.assert_allclose(weightless.w_WB, np.zeros((1, 3)), atol=0.0)
    ADAPTER.build(replace(_hinge(drive=PD), narrow=Effect.DRIVES), _settings()).command({"hinge": 1.0})
    fast = ADAPTER.build(replace(scene, widen=Effect.CONTINUOUS_COLLISION), _settings())
    assert Effect.CONTINUOUS_COLLISION in {notice.effect for notice in fast.warnings() if notice.kind == "missing"}
    top = Body(name="top", inertia=principal_inertia(1.0, 2.0, 2.5), w_WB=(1.0, 2.0, 3.0))
    told = ADAPTER.build(Scene(bodies=(top,), narrow=Effect.GYROSCOPIC), _settings()).warnings()
    assert Effect.GYROSCOPIC in {notice.effect for notice in told if notice.kind == "surplus"}


def test_a_run_beyond_double_precision_is_diverged_and_not_repaired() -> None:
    body = Body(name="x", inertia=principal_inertia(1.0, 2.0, 2.5), v_WB=(1e200, 0.0, 0.0), w_WB=(1e200, 1.0, 0.0))
    with pytest.raises(Diverged):
        ADAPTER.build(Scene(bodies=(body,)), _settings()).step()
    with pytest.raises(ValueError, match="finite"):
        ADAPTER.build(Scene(bodies=(_free("x"),)), _settings()).wrench(np.full((1, 3), np.nan), np.zeros((1, 3)))


def test_the_sign_of_a_quaternion_does_not_jump_while_a_body_turns_round_and_round() -> None:
    q = multiply((-1.0, 0.0, 0.0, 0.0), axis_angle((1.0, 2.0, 3.0), 0.3))
    scene = Scene(bodies=(_free("x", q_WB=q, w_WB=(0.0, 0.0, 9.0)),), gravity=(0.0, 0.0, 0.0))
    simulation, last = ADAPTER.build(scene, _settings()), np.array(q)
    for _ in range(150):
        simulation.step(10)
        now = _state(simulation, scene).q_WB[0]
        # Ten steps turn it by 0.09 rad, half of that in the four-dimensional angle.
        assert np.linalg.norm(now - last) < 0.05
        last = now


def test_two_worlds_stepped_in_turn_do_what_one_does_alone() -> None:
    bodies = tuple(_box(f"b{i}", (0.01 * i, 0.0, 0.3 + 0.25 * i), q_WB=axis_angle((1.0, 2.0, 3.0), 0.1 * i)) for i in range(4))
    scene = Scene(bodies=(_ground(), *bodies), surfaces=(_law(), _law(between=("b", "b"))))
    for track in (TUNED, DEFAULT):
        settings = _settings(1 / 240, track)
        alone = _after(scene, 1.0, settings)
        pair = [ADAPTER.build(scene, settings) for _ in range(2)]
        for _ in range(240):
            for one in pair:
                one.step()
        for one in pair:
            assert (_state(one, scene).p_WB == alone.p_WB).all()
            assert (_state(one, scene).q_WB == alone.q_WB).all()


def _busy() -> Scene:
    """A little of everything: a fall, sliding, damping, a drive with a limit, a top, a body on its way."""
    bodies = (
        _ground(),
        _box("faller", (0.0, 0.0, 0.12), w_WB=(0.3, 0.2, 0.1)),
        _box("slider", (1.0, 0.0, 0.1), v_WB=(1.0, 0.5, 0.0), linear_damping=0.3, angular_damping=0.2),
        Body(name="belt", motion="kinematic", v_WB=(0.1, 0.0, 0.0), p_WB=(0.0, 0.0, 5.0)),
        _free("wheel", (0.0, 3.0, 2.0)),
        Body(name="top", inertia=principal_inertia(0.1, 0.1, 0.2), p_WB=(0.0, 5.0, 3.0), w_WB=(0.0, 0.0, 30.0)),
    )
    joints = (
        Revolute(
            name="hinge", parent=WORLD, child="wheel", anchor_W=(0.0, 3.0, 2.0), axis_W=(1.0, 0.0, 0.0),
            drive=replace(PD, limit=3.0),
        ),
        Ball(name="tip", parent=WORLD, child="top", anchor_W=(0.0, 5.0, 2.8)),
    )  # fmt: skip
    return Scene(bodies=bodies, joints=joints, surfaces=(_law(), _law(between=("b", "b"))))


@pytest.mark.parametrize("drives", ["spring", "stable", "servo"])
def test_sub_steps_are_steps_of_their_own_length_bit_for_bit(drives: str) -> None:
    """With the same forces from outside, four sub-steps of 1/240 s are four steps of 1/960 s: both are the same double."""
    scene = _busy()
    push = np.zeros((6, 3))
    push[1:3] = 0.5, 0.2, 1.0
    whole, fine = (
        ADAPTER.build(scene, replace(_settings(dt, drives=drives), substeps=substeps))
        for dt, substeps in ((1 / 240, 4), (1 / 960, None))
    )
    assert (whole.resolved.dt, whole.resolved.substeps) == (1 / 240, 4)
    assert (fine.resolved.dt, fine.resolved.substeps) == (1 / 960, 1)
    for simulation, count in ((whole, 30), (fine, 120)):
        simulation.step(count)
        simulation.wrench(push, push)
        simulation.step(count)
    for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
        assert (getattr(_state(whole, scene), name) == getattr(_state(fine, scene), name)).all()
    assert (whole.contacts().force_W == fine.contacts().force_W).all()


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        (_settings(detector="gjk"), "detector"),
        (replace(TUNED, solver="dantzig", iterations=10), "dantzig"),
        (_settings(error_reduction=1.5), "error_reduction"),
        (_settings(error_reduction=True), "error_reduction"),
        (_settings(joints="links"), "joints"),
        (_settings(ground="box"), "ground"),
    ],
)
def test_settings_that_dart_does_not_have_are_refused(settings: Settings, match: str) -> None:
    with pytest.raises(SettingsError, match=match):
        ADAPTER.build(Scene(bodies=(_free("x"),)), settings)


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_solver_that_is_asked_for_is_the_one_that_runs(solver: str) -> None:
    iterations = None if solver == "dantzig" else 77
    scene = Scene(bodies=(_ground(), _box()), surfaces=(_law(),))
    simulation = ADAPTER.build(scene, replace(TUNED, solver=solver, iterations=iterations))
    assert (simulation.resolved.solver, simulation.resolved.iterations) == (solver, iterations)


@pytest.mark.parametrize("solver", ["pgs", "matrix_free"])
def test_a_finer_tolerance_brings_a_swept_solver_nearer_to_the_one_that_pivots(solver: str) -> None:
    """Of at most three hundred sweeps what ends them is the tolerance alone."""
    scene = Scene(
        bodies=(_ground(), *(_box(f"b{i}", (0.0, 0.0, 0.1 + 0.2 * i)) for i in range(3))),
        surfaces=(_law(), _law(between=("b", "b"))),
    )
    exact = _after(scene, 0.5, replace(_settings(1 / 240), solver="dantzig")).p_WB
    off = []
    for tolerance in (1e-3, 1e-7):
        swept = _after(scene, 0.5, replace(_settings(1 / 240), solver=solver, iterations=300, tolerance=tolerance))
        off.append(np.abs(swept.p_WB - exact).max())
    assert off[1] < off[0] / 2


def test_building_and_stepping_write_nothing_to_the_console(capfd: pytest.CaptureFixture[str]) -> None:
    scene = Scene(bodies=(_ground(), _solid("x", ConvexHull(vertices=CUBE), (0.0, 0.0, 0.1))), surfaces=(_law(),))
    for solver in ("dantzig", "pgs", "nsgs"):
        ADAPTER.build(scene, replace(TUNED, solver=solver)).step(10)
    out, err = capfd.readouterr()
    assert (out, err) == ("", "")


def test_a_weld_holds_two_bodies_and_a_full_tensor_together() -> None:
    a, b = (
        _free("a", v_WB=(0.0, 1.0, 0.0), w_WB=(0.0, 0.0, 2.0)),
        _free("b", (1.0, 0.0, 0.0), v_WB=(0.0, 3.0, 0.0), w_WB=(0.0, 0.0, 2.0)),
    )
    scene = Scene(bodies=(a, b), joints=(Fixed(name="weld", parent="b", child="a"),), gravity=(0.0, 0.0, 0.0))
    end = _after(scene, 1.0)
    # The common centre goes straight on and both turn by 2 rad; half a metre to either side of it. First order: 2e-3.
    turned = np.array([np.cos(2.0), np.sin(2.0), 0.0])
    centre = np.array([0.5, 2.0, 0.0])
    np.testing.assert_allclose(end.p_WB, [centre - turned / 2, centre + turned / 2], atol=2e-3)


def test_no_mesh_file_is_left_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    ADAPTER.build(Scene(bodies=(_solid("x", ConvexHull(vertices=CUBE), (0.0, 0.0, 0.0)),)), _settings()).step()
    assert list(tmp_path.iterdir()) == []


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
        bodies=(_ground(support, (0.0, 0.0, depth)), _solid("x", shape, (0.0, 0.0, 0.1), q_WB=q_WB)), surfaces=(_law(0.8),)
    )
    # It falls for one step before its contact is found, g dt^2 = 0.17 mm, and is lifted from there on.
    assert abs(_after(scene, 3.0, _settings(1 / 240, track)).p_WB[1, 2] - 0.1) < G / 240**2


def test_pairs_of_which_no_detector_has_all_right_are_refused_by_name() -> None:
    mesh = TriangleMesh(vertices=CUBE, faces=((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)))
    round_ones = (
        _solid("capsule", Capsule(radius=0.1, half_length=0.1), (0.0, 0.0, 1.0)),
        _solid("cylinder", Cylinder(radius=0.1, half_length=0.1), (1.0, 0.0, 1.0)),
    )
    scene = Scene(bodies=(_ground(mesh), *round_ones), surfaces=(_law(), _law(between=("b", "b"))))
    for track in (TUNED, DEFAULT):
        with pytest.raises(Unsupported, match=r"capsule/cylinder.*cylinder/triangle_mesh"):
            ADAPTER.build(scene, _settings(track=track))
    # Bodies that never meet do not count.
    parted = replace(scene, apart=(("b", "b"),), surfaces=(_law(),))
    assert ADAPTER.build(parted, _settings()).resolved.options["detector"] == "ode"


def test_a_plane_by_the_bullet_detector_is_a_slab_that_brakes_a_box_as_coulomb_says_and_meets_rays_as_a_plane() -> None:
    pillar = _solid("pillar", Capsule(radius=0.1, half_length=0.5), (3.0, 5.0, 0.6))
    sunk = Plane(normal=(0.0, 0.0, 2.0))
    scene = Scene(bodies=(_ground(sunk), _box(v_WB=(2.0, 0.0, 0.0)), pillar), surfaces=(_law(0.5), _law(between=("b", "b"))))
    simulation = ADAPTER.build(scene, _settings(1 / 240))
    assert simulation.resolved.options["detector"] == "bullet"
    simulation.step(240)
    # v0^2/(2 mu g), and v0 dt/2 of a semi-implicit step; on the vendor's plane it tumbles over its one contact.
    box = _state(simulation, scene).p_WB[1]
    assert abs(box[0] - 4 / (2 * 0.5 * G)) < 2 / 240
    assert abs(box[2] - 0.1) < G / 240**2
    hits = simulation.cast(np.array([(9e3, 0.0, 2.0), (0.3, 4.0, 2.0)]), np.array([(0.0, 0.0, -1.0)] * 2), 10.0)
    np.testing.assert_allclose(hits.distance, (2.0, 2.0), atol=1e-9)
    assert hits.body.tolist() == [0, 0]
