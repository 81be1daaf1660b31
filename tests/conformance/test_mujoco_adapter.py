"""What is particular to the MuJoCo adapter: frames of coordinates, soft constraints, pair surfaces, state kept in `MjData`."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from adapters.mujoco import ADAPTER
from adapters.mujoco.options import Options
from adapters.mujoco.simulation import MujocoSimulation
from adapters.mujoco.surfaces import contact_law
from harness.adapter import Diverged, Settings, SettingsError, Unsupported
from harness.scene import (
    WORLD,
    Ball,
    Body,
    Box,
    Camera,
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
    multiply,
    principal_inertia,
    rotation_matrix,
    sphere_inertia,
)
from harness.trajectory import Floats, State

G = 9.81
TURNED = multiply(axis_angle((0.0, 0.0, 1.0), 0.7), axis_angle((1.0, 2.0, 3.0), 1.1))
DEFAULT, TUNED = ADAPTER.tracks["default"], ADAPTER.tracks["tuned"]
BOTH = pytest.mark.parametrize("settings", [DEFAULT, TUNED], ids=["default", "tuned"])
TETRAHEDRON = ((0.0, 0.0, 0.4), (0.4, 0.0, 0.0), (-0.2, 0.35, 0.0), (-0.2, -0.35, 0.0))
FACES = ((0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2))


def _build(scene: Scene, settings: Settings = DEFAULT, dt: float = 1e-3) -> MujocoSimulation:
    return ADAPTER.build(scene, settings.with_dt(dt))


def _state(simulation: MujocoSimulation, scene: Scene) -> State:
    out = State.empty(len(scene.bodies))
    simulation.state(out)
    return out


def _matrix(q: Floats) -> Floats:
    w, x, y, z = (float(c) for c in q)
    return np.array(rotation_matrix((w, x, y, z)))


def _energy(scene: Scene, state: State) -> float:
    total = 0.0
    for k, body in enumerate(scene.bodies):
        if body.movable:
            w_B = _matrix(state.q_WB[k]).T @ state.w_WB[k]
            turning = w_B @ np.array(body.inertia) @ w_B
            total += float(body.mass * state.v_WB[k] @ state.v_WB[k] + turning) / 2 + body.mass * G * float(state.p_WB[k, 2])
    return total


def _shaped(
    name: str, shape: Shape, p: Vector3, material: str = "block", mass: float = 1.0, v: Vector3 = (0.0, 0.0, 0.0)
) -> Body:
    inertia = box_inertia(mass, shape.half_extents) if isinstance(shape, Box) else sphere_inertia(mass, 0.1)
    return Body(name=name, mass=mass, inertia=inertia, p_WB=p, v_WB=v, material=material, collision=(PlacedShape(shape=shape),))


def _ground(shape: Shape | None = None, p: Vector3 = (0.0, 0.0, -0.5)) -> Body:
    placed = PlacedShape(shape=shape or Box(half_extents=(20.0, 20.0, 0.5)))
    return Body(name="ground", motion="static", material="ground", p_WB=p, collision=(placed,))


def _on_ground(*bodies: Body, mu: float = 0.0, e: float = 0.0) -> Scene:
    pairs = [("ground", "block")] + ([("block", "block")] if len(bodies) > 1 else [])
    return Scene(
        bodies=(_ground(), *bodies),
        surfaces=tuple(Surface(between=pair, static_friction=mu, kinetic_friction=mu, restitution=e) for pair in pairs),
    )


def _stack(n: int, mu: float = 0.5) -> Scene:
    half = (0.1, 0.1, 0.1)
    return _on_ground(*(_shaped(f"box{k}", Box(half_extents=half), (0.0, 0.0, 0.1 + 0.2 * k)) for k in range(n)), mu=mu)


def _rod(
    name: str, p: Vector3, axis: int, w: Vector3 = (0.0, 0.0, 0.0), v: Vector3 = (0.0, 0.0, 0.0), length: float = 1.0
) -> Body:
    moments = [length**2 / 12] * 3
    moments[axis] = 1e-4
    return Body(name=name, inertia=principal_inertia(*moments), p_WB=p, w_WB=w, v_WB=v)


def _hinge(name: str, parent: str, child: str, p: Vector3, **extra: object) -> Revolute:
    return Revolute(name=name, parent=parent, child=child, anchor_W=p, axis_W=(0.0, 1.0, 0.0), **extra)  # type: ignore[arg-type]


def _four_bars() -> Scene:
    """A parallelogram of cranks 1 m and a coupler of 2 m, turning at 1 rad/s."""
    bars = (
        _rod("left", (0.0, 0.0, 0.5), 2, w=(0.0, 1.0, 0.0), v=(0.5, 0.0, 0.0)),
        _rod("top", (1.0, 0.0, 1.0), 0, v=(1.0, 0.0, 0.0), length=2.0),
        _rod("right", (2.0, 0.0, 0.5), 2, w=(0.0, 1.0, 0.0), v=(0.5, 0.0, 0.0)),
    )
    pins = ((WORLD, "left", (0, 0, 0)), ("left", "top", (0, 0, 1)), ("top", "right", (2, 0, 1)), (WORLD, "right", (2, 0, 0)))
    return Scene(bodies=bars, joints=tuple(_hinge(f"{a}-{b}", a, b, p) for a, b, p in pins))


def test_a_fall_errs_by_g_dt_t_half_on_default_and_by_rounding_on_tuned() -> None:
    scene = Scene(bodies=(Body(name="body", p_WB=(1.0, 2.0, 3.0), v_WB=(1.0, 2.0, 3.0)),))
    for settings, expected in ((DEFAULT, -G * 1e-3 / 2), (TUNED, 0.0)):
        simulation = _build(scene, settings)
        simulation.step(1000)
        error = _state(simulation, scene).p_WB[0] - (2.0, 4.0, 6.0 - G / 2)
        # Semi-implicit Euler sums k g dt^2 over 1000 steps: exactly g dt t/2 too low; 1e-11 is rounding of 1000 additions.
        np.testing.assert_allclose(error, (0.0, 0.0, expected), rtol=0, atol=1e-11)


def test_a_top_with_products_of_inertia_follows_the_equations_of_euler() -> None:
    R = _matrix(np.array(TURNED))
    tensor = R @ np.diag([0.1, 0.2, 0.25]) @ R.T
    tensor = (tensor + tensor.T) / 2
    body = Body(name="top", mass=2.0, inertia=tensor.tolist(), p_WB=(1.0, 2.0, 3.0), q_WB=TURNED, w_WB=(3.0, 1.0, -2.0))
    scene = Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0))
    simulation = _build(scene, TUNED)
    np.testing.assert_allclose(_state(simulation, scene).w_WB[0], body.w_WB, atol=1e-14)
    simulation.step(1000)
    end = _state(simulation, scene)
    R_end = _matrix(end.q_WB[0])
    tensor_W = R_end @ tensor @ R_end.T
    momentum = tensor_W @ end.w_WB[0]
    start = R @ tensor @ R.T @ np.array(body.w_WB)
    # RK4 at w dt = 4e-3 errs by (w dt)^4 = 2e-10 a radian at most.
    np.testing.assert_allclose(momentum, start, atol=1e-9)
    assert end.w_WB[0] @ momentum == pytest.approx(np.array(body.w_WB) @ start, rel=1e-9)


@BOTH
def test_angular_damping_of_an_anisotropic_body_is_the_law_w_dot_minus_c_w(settings: Settings) -> None:
    R = _matrix(np.array(TURNED))
    tensor = R @ np.diag([0.1, 0.2, 0.25]) @ R.T
    tensor = (tensor + tensor.T) / 2
    body = Body(
        name="b", inertia=tensor.tolist(), w_WB=(3.0, 1.0, -2.0), v_WB=(1.0, 0.0, 0.0), linear_damping=0.5, angular_damping=0.7
    )
    scene = Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0))
    simulation = _build(scene, settings)
    simulation.step(1000)
    end = _state(simulation, scene)

    def rate(_: float, w: Floats) -> Floats:
        return np.linalg.solve(tensor, -np.cross(w, tensor @ w)) - 0.7 * w

    w_B = solve_ivp(rate, (0.0, 1.0), body.w_WB, rtol=1e-11, atol=1e-11).y[:, -1]
    # First order: c^2 dt/2 and the gyroscopic term |w|^2 dt/2 = 7e-3 a second at most.
    np.testing.assert_allclose(_matrix(end.q_WB[0]).T @ end.w_WB[0], w_B, atol=1e-8 if settings is TUNED else 7e-3)
    assert end.v_WB[0, 0] == pytest.approx(math.exp(-0.5), abs=1e-9 if settings is TUNED else 0.5**2 * 1e-3)


def test_damping_inside_a_chain_is_refused_and_on_a_single_hinge_exact() -> None:
    arm = Body(
        name="arm",
        mass=2.0,
        p_WB=(0.5, 0.0, 0.0),
        w_WB=(0.0, 1.0, 0.0),
        v_WB=(0.0, 0.0, -0.5),
        linear_damping=0.3,
        angular_damping=0.2,
    )
    scene = Scene(bodies=(arm,), joints=(_hinge("j", WORLD, "arm", (0, 0, 0)),), gravity=(0.0, 0.0, 0.0))
    simulation = _build(scene, TUNED)
    simulation.step(1000)
    # (I + m r^2) w' = -(c_w I + c_v m r^2) w with I = 1, m r^2 = 0.5.
    assert _state(simulation, scene).w_WB[0, 1] == pytest.approx(math.exp(-(0.2 + 0.3 * 0.5) / 1.5), rel=1e-10)
    chain = Scene(
        bodies=(arm, Body(name="end", p_WB=(1.5, 0.0, 0.0), v_WB=(0.0, 0.0, -1.0), linear_damping=0.1)),
        joints=(*scene.joints, _hinge("k", "arm", "end", (1, 0, 0))),
    )
    with pytest.raises(Unsupported, match=r"'end'.*damp"):
        _build(chain)


@pytest.mark.parametrize("kind", ["revolute", "ball", "turned round"])
def test_a_pendulum_follows_its_equation_and_has_no_joint_gap(kind: str) -> None:
    rod = _rod("rod", (0.5, 0.0, 0.0), 0, w=(0.0, 1.3, 0.0), v=(0.0, 0.0, -0.65))
    post = Body(name="post", motion="static")
    joint: Joint = _hinge("j", "post", "rod", (0, 0, 0))
    if kind == "ball":
        joint = Ball(name="j", parent=WORLD, child="rod", anchor_W=(0.0, 0.0, 0.0))
    elif kind == "turned round":
        joint = _hinge("j", "rod", "post", (0, 0, 0))
    scene = Scene(bodies=(rod, post), joints=(joint,))
    simulation = _build(scene, TUNED)
    simulation.step(2000)
    end = _state(simulation, scene)
    angle = solve_ivp(lambda _, y: (y[1], 1.5 * G * math.cos(y[0])), (0, 2), (0.0, 1.3), rtol=1e-12, atol=1e-12).y[0, -1]
    # RK4 at rate 6 / s: (w dt)^4 = 1e-9 over two seconds.
    np.testing.assert_allclose(end.p_WB[0], (0.5 * math.cos(angle), 0.0, -0.5 * math.sin(angle)), atol=1e-8)
    np.testing.assert_allclose(end.p_WB[0], _matrix(end.q_WB[0]) @ (0.5, 0.0, 0.0), atol=1e-14)


def test_a_double_pendulum_keeps_its_energy_whatever_the_order_of_bodies_and_joints() -> None:
    bodies = (_rod("upper", (0.0, 0.0, -0.5), 2), _rod("lower", (0.5, 0.0, -1.0), 0))
    joints = (_hinge("a", WORLD, "upper", (0, 0, 0)), _hinge("b", "upper", "lower", (0, 0, -1)))
    ends = []
    for way in (1, -1):
        scene = Scene(bodies=bodies[::way], joints=joints[::way])
        simulation = _build(scene, TUNED)
        start = _energy(scene, _state(simulation, scene))
        simulation.step(2000)
        end = _state(simulation, scene)
        # RK4: (10 / s dt)^5 a step, 2000 steps, of 10 J.
        assert _energy(scene, end) == pytest.approx(start, abs=1e-7)
        ends.append(end.p_WB[::way])
    np.testing.assert_array_equal(ends[0], ends[1])


def test_a_four_bar_loop_closes_to_micrometres() -> None:
    scene = _four_bars()
    simulation = _build(scene, TUNED)
    gap = 0.0
    for _ in range(100):
        simulation.step(10)
        now = _state(simulation, scene)
        foot = now.p_WB[2] - _matrix(now.q_WB[2]) @ (0.0, 0.0, 0.5)
        gap = max(gap, float(np.abs(foot - (2.0, 0.0, 0.0)).max()))
    # Impedance .999, time constant 2 dt: the gap is (1 - d) a (2 dt)^2, 2e-7 m for a below 50 m/s2; tenfold is granted.
    assert 0 < gap < 2e-6


def test_velocities_that_a_joint_forbids_are_refused() -> None:
    scene = _four_bars()
    still = tuple(replace(b, v_WB=(0.0, 0.0, 0.0), w_WB=(0.0, 0.0, 0.0)) if b.name == "right" else b for b in scene.bodies)
    with pytest.raises(Unsupported, match="velocit"):
        _build(replace(scene, bodies=still))
    rod = Distance(name="d", parent=WORLD, child="b", anchor_W=(0.0, 0.0, 0.0), child_anchor_W=(1.0, 0.0, 0.0))
    with pytest.raises(Unsupported, match="velocit"):
        _build(Scene(bodies=(Body(name="b", p_WB=(1.0, 0.0, 0.0), v_WB=(1.0, 0.0, 0.0)),), joints=(rod,)))


def test_a_slide_counts_from_its_position_towards_its_spring() -> None:
    spring = Spring(stiffness=50.0, damping=2.0, rest=0.1)
    slide = Prismatic(
        name="j", parent=WORLD, child="b", anchor_W=(0.0, 0.0, 1.0), axis_W=(1.0, 0.0, 0.0), position=0.3, spring=spring
    )
    scene = Scene(bodies=(Body(name="b", mass=2.0, p_WB=(0.0, 0.0, 1.0)),), joints=(slide,))
    simulation = _build(scene, TUNED)
    simulation.step(1000)
    w, z = 5.0, 0.1
    w_d = w * math.sqrt(1 - z * z)
    x = 0.1 + 0.2 * math.exp(-z * w) * (math.cos(w_d) + z * w / w_d * math.sin(w_d))
    assert simulation.resolved.integrator == "rk4"
    assert _state(simulation, scene).p_WB[0, 0] + 0.3 == pytest.approx(x, abs=1e-9)


@BOTH
def test_a_drive_reaches_its_target_stops_at_limits_and_is_cut_off(settings: Settings) -> None:
    body = Body(name="b", inertia=principal_inertia(0.1, 0.1, 0.1))
    drive = Drive(stiffness=20.0, damping=3.0, target=0.5)
    scene = Scene(
        bodies=(body,), joints=(_hinge("j", WORLD, "b", (0, 0, 0), position=-0.2, limits=Limits(upper=2.0), drive=drive),)
    )
    simulation = _build(scene, settings)

    def angle() -> float:
        q = _state(simulation, scene).q_WB[0]
        return 2 * math.atan2(q[2], q[0]) - 0.2

    simulation.step(3000)
    assert angle() == pytest.approx(0.5, abs=1e-6)
    simulation.command({"j": 3.0})
    simulation.step(3000)
    # A soft stop under 20 N m on 0.1 kg m2: (1 - d) a tc^2 ratio^2 = 0.1 * 200 * 4e-4, doubled for d below .95.
    assert 2.0 <= angle() < 2.016
    with pytest.raises(ValueError, match="'k' has no drive"):
        simulation.command({"k": 1.0})
    weak = replace(drive, stiffness=1e4, limit=0.7)
    scene = Scene(bodies=(body,), joints=(_hinge("j", WORLD, "b", (0, 0, 0), drive=weak),))
    simulation = _build(scene, settings)
    simulation.step(50)
    assert _state(simulation, scene).w_WB[0, 1] == pytest.approx(0.7 * 0.05 / 0.1, rel=1e-9)


def test_distance_joints_hold_limit_or_spring() -> None:
    body = Body(name="b", p_WB=(1.0, 0.0, 0.0))
    span = {}
    for kind, extra in {
        "rod": {},
        "rope": {"limits": Limits(upper=1.2)},
        "spring": {"spring": Spring(stiffness=40.0, rest=1.0)},
    }.items():
        joint = Distance(name="d", parent=WORLD, child="b", anchor_W=(0.0, 0.0, 0.0), child_anchor_W=(1.0, 0.0, 0.0), **extra)  # type: ignore[arg-type]
        scene = Scene(bodies=(body,), joints=(joint,))
        simulation = _build(scene, TUNED)
        length = []
        for _ in range(100):
            simulation.step(10)
            length.append(float(np.linalg.norm(_state(simulation, scene).p_WB[0])))
        span[kind] = (min(length), max(length))
        if kind == "spring":
            energy = _energy(scene, _state(simulation, scene)) + 20 * (length[-1] - 1) ** 2
            assert energy == pytest.approx(0.0, abs=1e-9)
    assert span["rod"] == pytest.approx((1.0, 1.0), abs=1e-4)
    # The rope catches 5 m/s softly: it gives way by about v tc / e with tc = 20 dt.
    assert span["rope"][0] < 1.1
    assert 1.2 <= span["rope"][1] < 1.2 + 5 * 0.02
    assert span["spring"][1] > 1.1


@BOTH
def test_a_box_at_rest_presses_with_its_weight(settings: Settings) -> None:
    scene = _stack(1)
    simulation = _build(scene, settings)
    simulation.step(1500)
    contacts = simulation.contacts()
    assert len(contacts) == 4
    np.testing.assert_array_equal(contacts.body_A, 0)
    np.testing.assert_allclose(contacts.normal_W, [(0, 0, 1)] * 4, atol=1e-9)
    # At rest the sum is the weight up to what still moves: solver tolerance 1e-8 and the last of the settling.
    np.testing.assert_allclose(contacts.force_W.sum(axis=0), (0, 0, G), atol=1e-4)


def test_friction_is_isotropic_on_tuned_and_a_pyramid_on_default() -> None:
    v0, mu = 2.0, 0.4
    far = v0**2 / (2 * mu * G)
    stopped = {}
    for name, settings in (("default", DEFAULT), ("tuned", TUNED)):
        side = v0 / math.sqrt(2)
        scene = _on_ground(_shaped("box", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.1), v=(side, side, 0.0)), mu=mu)
        simulation = _build(scene, settings)
        simulation.step(1200)
        stopped[name] = float(np.linalg.norm(_state(simulation, scene).p_WB[1, :2])) / far
    assert stopped["tuned"] == pytest.approx(1.0, abs=0.005)
    # Towards an edge the pyramid holds with mu/sqrt(2).
    assert stopped["default"] == pytest.approx(math.sqrt(2), rel=0.01)


def test_every_pair_has_its_own_law_through_priorities_or_explicit_pairs() -> None:
    half = Box(half_extents=(0.1, 0.1, 0.1))
    law = {("ground", "a"): 0.2, ("ground", "b"): 0.7, ("a", "b"): 0.0, ("a", "a"): 0.5}
    bodies = (_ground(), *(_shaped(f"{m}{k}", half, (3.0 * k, 0.0, 0.1), m, v=(2.0, 0.0, 0.0)) for k, m in enumerate("aab")))
    surfaces = tuple(Surface(between=pair, static_friction=mu, kinetic_friction=mu) for pair, mu in law.items())
    scene = Scene(bodies=bodies, surfaces=surfaces)
    simulation = _build(scene, TUNED)
    simulation.step(200)
    v = _state(simulation, scene).v_WB[1:]
    mu = np.array([0.2, 0.2, 0.7])
    # Friction's impulse is mu times the normal one, m (g t + v_z), in every step, whatever the soft contact does upwards.
    np.testing.assert_allclose(2.0 - v[:, 0], mu * (G * 0.2 + v[:, 2]), rtol=1e-3)


def test_materials_that_are_apart_and_bodies_that_are_joined_do_not_touch() -> None:
    ball = Sphere(radius=0.1)
    scene = Scene(
        bodies=(
            _shaped("a", ball, (0.0, 0.0, 0.0), "a"),
            _shaped("b", ball, (0.1, 0.0, 0.0), "b"),
            _shaped("c", ball, (0.0, 0.15, 0.0), "a"),
        ),
        apart=(("a", "b"),),
        surfaces=(Surface(between=("a", "a")),),
    )
    simulation = _build(scene)
    assert [(int(a), int(b)) for a, b in zip(simulation.contacts().body_A, simulation.contacts().body_B, strict=True)] == [
        (0, 2)
    ]
    joint = Fixed(name="j", parent="a", child="c")
    assert len(_build(replace(scene, joints=(joint,))).contacts()) == 0
    hinge = _hinge("j", "a", "c", (0, 0, 0), collide=True)
    assert len(_build(replace(scene, joints=(hinge,))).contacts()) == 1


@BOTH
@pytest.mark.parametrize("e", [0.5, 0.8])
def test_the_mean_rebound_over_the_phases_of_the_step_is_the_restitution(settings: Settings, e: float) -> None:
    rebounds = []
    for phase in range(8):
        scene = _on_ground(_shaped("ball", Sphere(radius=0.1), (0.0, 0.0, 1.1 + 4.4e-3 * phase / 8)), e=e)
        simulation = _build(scene, settings)
        down = 0.0
        for _ in range(700):
            simulation.step()
            now = _state(simulation, scene)
            down = min(down, now.v_WB[1, 2])
            if down < -1 and now.v_WB[1, 2] > 0 and now.p_WB[1, 2] > 0.1:
                break
        rebounds.append(now.v_WB[1, 2] / -down)
    # Calibrated without gravity, which takes g N dt = .1 of 4.4 m/s over the impact, half of it before the deepest point.
    assert np.mean(rebounds) == pytest.approx(e, abs=0.012)
    assert np.ptp(rebounds) < 0.09


def test_without_restitution_a_free_body_leaves_with_what_a_contact_that_cannot_pull_gives_back() -> None:
    """x = -v t exp(-w t) is pushed until w t = 2, when its speed is exp(-2) v; 200 steps to 1/w leave half a per cent of it."""
    rebounds = []
    for phase in range(4):
        ball = replace(_shaped("ball", Sphere(radius=0.1), (0.0, 0.0, 0.101 + 5e-5 * phase)), v_WB=(0.0, 0.0, -2.0))
        scene = replace(_on_ground(ball), gravity=(0.0, 0.0, 0.0))
        simulation = _build(scene, DEFAULT, dt=1e-4)
        simulation.step(2000)
        rebounds.append(_state(simulation, scene).v_WB[1, 2] / 2)
    assert np.mean(rebounds) == pytest.approx(math.exp(-2), rel=0.01)


def test_no_restitution_is_no_rebound_and_too_little_is_refused() -> None:
    for settings in (DEFAULT, TUNED):
        scene = _on_ground(_shaped("ball", Sphere(radius=0.1), (0.0, 0.0, 0.6)))
        simulation = _build(scene, settings)
        high = []
        for _ in range(150):
            simulation.step(10)
            high.append(_state(simulation, scene).v_WB[1, 2])
        # It climbs out of the soft contact more slowly than its depth (30 mm) over its time constant (20 ms) and a third.
        assert max(high) < 0.5
        assert _state(simulation, scene).p_WB[1, 2] == pytest.approx(0.1, abs=1e-3)
    with pytest.raises(Unsupported, match=r"restitution 0\.01"):
        _build(_on_ground(_shaped("ball", Sphere(radius=0.1), (0.0, 0.0, 0.6)), e=0.01))


def test_friction_in_a_rebound_is_mu_times_the_normal_impulse() -> None:
    for settings in (DEFAULT, TUNED):
        scene = replace(
            _on_ground(_shaped("ball", Sphere(radius=0.1), (0.0, 0.0, 0.3), v=(5.0, 0.0, -3.0)), mu=0.2, e=0.8),
            gravity=(0.0, 0.0, 0.0),
        )
        simulation = _build(scene, settings)
        simulation.step(300)
        v = _state(simulation, scene).v_WB[1]
        assert 5.0 - v[0] == pytest.approx(0.2 * (3.0 + v[2]), rel=1e-6)
        assert simulation.resolved.options["cone"] == "elliptic"
    with pytest.raises(Unsupported, match="pyramid"):
        _build(scene, Settings(options={"cone": "pyramidal"}))


PHASES = (np.arange(8) + 0.5) / 8
"""Of the step, at which a ball meets the ground."""
REBOUNDING = Effect.CONTACT | Effect.FRICTION | Effect.RESTITUTION


def _bent(slip: float, mu: float, restitution: float, friction_constant: float) -> float:
    """The mean rebound over e, less 1, of a ball at 1 m/s and a slip [m/s], in MuJoCo's own words throughout."""
    mj, law = pytest.importorskip("mujoco"), contact_law(_surface(mu, restitution), REBOUNDING, Options(), 1e-3, "euler")
    left = []
    for phase in PHASES:
        spec = mj.MjSpec()
        spec.option.timestep, spec.option.gravity, spec.option.cone = 1e-3, (0.0, 0.0, 0.0), mj.mjtCone.mjCONE_ELLIPTIC
        ball = spec.worldbody.add_body(pos=(0.0, 0.0, 0.105 + phase * 1e-3))
        ball.add_freejoint()
        ball.add_geom(name="ball", type=mj.mjtGeom.mjGEOM_SPHERE, size=(0.1, 0.0, 0.0), mass=1.0)
        spec.worldbody.add_geom(name="floor", type=mj.mjtGeom.mjGEOM_PLANE, size=(0.0, 0.0, 1.0))
        pair = spec.add_pair(geomname1="floor", geomname2="ball")
        pair.condim, pair.friction, pair.solref, pair.solimp = 3, (mu, mu, 0.0, 0.0, 0.0), law.solref, law.solimp
        pair.solreffriction = (friction_constant, 1.0)
        model = spec.compile()
        data = mj.MjData(model)
        data.qvel[:3] = slip, 0.0, -1.0
        mj.mj_step(model, data, 120)
        left.append(float(data.qvel[2]))
    return float(np.mean(left)) / restitution - 1


def _surface(mu: float, e: float) -> Surface:
    return Surface(between=("ground", "block"), static_friction=mu, kinetic_friction=mu, restitution=e)


@pytest.mark.parametrize(
    ("e", "slips", "low", "high"),
    [(0.8, (0.3, 1.0), -0.05, 0.05), (0.8, (2.0, 3.0), -0.2, 0.13), (0.5, (1.0, 3.0), -0.2, 0.13), (0.3, (3.0,), 0.4, 0.43)],
)
def test_a_slip_bends_the_rebound_by_what_is_declared_and_it_is_the_engine_that_does_it(
    e: float, slips: tuple[float, ...], low: float, high: float
) -> None:
    """The figures are those of *Deviations*; a ball without friction keeps the rebound to the scatter of eight phases, 1 %."""
    for slip in slips:
        assert low <= _bent(slip, 0.3, e, 0.01) <= high
        assert abs(_bent(slip, 1e-9, e, 0.01)) < 0.01
        left = []
        for phase in PHASES:
            ball = _shaped("ball", Sphere(radius=0.1), (0.0, 0.0, 0.105 + phase * 1e-3), v=(slip, 0.0, -1.0))
            scene = replace(_on_ground(ball, mu=0.3, e=e), gravity=(0.0, 0.0, 0.0))
            simulation = _build(scene, TUNED)
            simulation.step(120)
            left.append(_state(simulation, scene).v_WB[1, 2])
        # The same phases of the step, and the solver's tolerance of 1e-10 against the vendor's of 1e-8.
        assert float(np.mean(left)) / e - 1 == pytest.approx(_bent(slip, 0.3, e, 0.01), abs=1e-4)


def test_friction_as_slow_as_the_impact_bends_the_rebound_less_than_half_as_fast_a_one() -> None:
    """At e = .8 and mu = .3 a slip of twice the approach: -12 % against -23 %, in MuJoCo's own words."""
    assert abs(_bent(2.0, 0.3, 0.8, 0.01)) < 0.6 * abs(_bent(2.0, 0.3, 0.8, 0.005))
    scene = _on_ground(_shaped("ball", Sphere(radius=0.1), (0.0, 0.0, 0.3)), mu=0.3, e=0.8)
    assert list(_build(scene, TUNED)._m.pair_solreffriction[0]) == pytest.approx([0.01, 1.0])


@BOTH
def test_a_kinematic_table_turns_on_under_load_and_drags_what_lies_on_it(settings: Settings) -> None:
    table = Body(
        name="table", motion="kinematic", material="ground", v_WB=(0.1, 0.0, 0.0), w_WB=(0.0, 0.0, 2.0),
        collision=(PlacedShape(shape=Cylinder(radius=2.0, half_length=0.1)),),
    )  # fmt: skip
    scene = Scene(
        bodies=(table, _shaped("ball", Sphere(radius=0.1), (0.5, 0.0, 0.2))),
        surfaces=(Surface(between=("ground", "block"), static_friction=0.5, kinetic_friction=0.5),),
    )
    simulation = _build(scene, settings)
    simulation.step(2000)
    end = _state(simulation, scene)
    # The ball's weight moves it by g t/1e12.
    np.testing.assert_allclose(end.p_WB[0], (0.2, 0.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(end.w_WB[0], (0.0, 0.0, 2.0), atol=1e-10)
    np.testing.assert_allclose(end.q_WB[0], axis_angle((0.0, 0.0, 1.0), 4.0), atol=1e-9)
    np.testing.assert_allclose(simulation.contacts().force_W[0, 2], G, rtol=1e-6)
    assert np.linalg.norm(end.v_WB[1, :2]) > 0.1


def test_rays_meet_every_shape_at_the_closed_form_and_stop_at_their_range() -> None:
    o, d = (
        np.array([[0.0, 0.0, 3.0], [0.0, 0.0, 3.0], [5.0, 0.0, 0.0]]),
        np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]),
    )
    tops: list[tuple[Shape, float, float]] = [
        (Sphere(radius=0.4), 2.6, 4.6),
        (Box(half_extents=(0.2, 0.3, 0.4)), 2.6, 4.8),
        (Capsule(radius=0.2, half_length=0.3), 2.5, 4.8),
        (Cylinder(radius=0.3, half_length=0.2), 2.8, 4.7),
        (Plane(), 3.0, math.inf),
        (ConvexHull(vertices=TETRAHEDRON), 2.6, 4.6),
        (TriangleMesh(vertices=TETRAHEDRON, faces=FACES), 2.6, 4.6),
    ]
    for shape, down, across in tops:
        body = Body(name="target", motion="static", p_WB=(10.0, 0.0, 0.0), q_WB=TURNED, collision=(PlacedShape(shape=shape),))
        scene = Scene(bodies=(Body(name="other", motion="static"), body))
        R = _matrix(np.array(TURNED))
        hits = _build(scene).cast(o @ R.T + (10.0, 0.0, 0.0), d @ R.T, 10.0)
        # Meshes are held in single precision: 2^-24 of half a metre; the last ray runs along the tetrahedron's foot.
        np.testing.assert_allclose(hits.distance[:2], (down, math.inf), atol=1e-7)
        np.testing.assert_array_equal(hits.body[:2], (1, -1))
        if not isinstance(shape, ConvexHull | TriangleMesh | Plane):
            assert hits.distance[2] == pytest.approx(across, abs=1e-12)
            np.testing.assert_allclose(hits.normal_W[2], R @ (1.0, 0.0, 0.0), atol=1e-12)
        # The engine's own cutoff leaves out shapes, not hits.
        assert not np.isfinite(_build(scene).cast(o[:1] @ R.T + (10.0, 0.0, 0.0), d[:1] @ R.T, down - 0.01).distance).any()


def test_depth_agrees_with_rays_through_a_tilted_pinhole_off_its_centre() -> None:
    camera = Camera(
        name="c",
        body="mount",
        rate=1.0,
        width=80,
        height=60,
        focal_x=50,
        focal_y=55,
        centre_x=42,
        centre_y=27,
        p_BS=(0.1, 0, 0),
    )
    wall = Body(
        name="wall", motion="static", p_WB=(0.0, 0.0, 4.0), collision=(PlacedShape(shape=Box(half_extents=(9.0, 9.0, 0.5))),)
    )
    mount = Body(name="mount", motion="static", p_WB=(0.2, 0.1, -1.0), q_WB=axis_angle((0.0, 1.0, 0.0), 0.1))
    simulation = _build(Scene(bodies=(wall, mount)))
    try:
        depth = simulation.render(camera).depth
    except Unsupported as refused:
        pytest.skip(str(refused))
    finally:
        simulation.close()
    R = _matrix(np.array(mount.q_WB))
    u, v = np.meshgrid(np.arange(80) + 0.5, np.arange(60) + 0.5)
    ray = np.stack([(u - 42) / 50, (v - 27) / 55, np.ones_like(u)], axis=-1) @ R.T
    eye = np.array(mount.p_WB) + R @ (0.1, 0.0, 0.0)
    # Reversed z in single precision: z^2/near 2^-24 = 2e-4 at 5 m and near = .01.
    np.testing.assert_allclose(depth, (3.5 - eye[2]) / ray[..., 2], atol=3e-4)


def test_a_concave_mesh_is_seen_by_rays_and_refused_in_contact() -> None:
    # A roof turned upside down: the middle vertex lies below the plane of the others.
    vertices = (*TETRAHEDRON[1:], (0.0, 0.0, 0.1), (0.0, 0.0, -0.4))
    faces = ((0, 1, 3), (1, 2, 3), (2, 0, 3), (1, 0, 4), (2, 1, 4), (0, 2, 4))
    dented = TriangleMesh(vertices=(*vertices[:3], (0.0, 0.0, -0.1), vertices[4]), faces=faces)
    static = Body(name="dent", motion="static", material="ground", collision=(PlacedShape(shape=dented),))
    middle = np.mean([vertices[0], vertices[1], (0.0, 0.0, -0.1)], axis=0)
    hits = _build(Scene(bodies=(static,))).cast(middle[None] * (1, 1, 0) + (0, 0, 1), np.array([[0.0, 0.0, -1.0]]), 5.0)
    # Single precision of the vertices.
    assert hits.distance[0] == pytest.approx(1.0 - middle[2], abs=1e-6)
    ball = _shaped("ball", Sphere(radius=0.1), (0.0, 0.0, 1.0))
    with pytest.raises(Unsupported, match="not convex"):
        _build(Scene(bodies=(static, ball), surfaces=(Surface(between=("ground", "block")),)))
    _build(
        Scene(
            bodies=(replace(static, collision=(PlacedShape(shape=TriangleMesh(vertices=vertices, faces=faces)),)), ball),
            surfaces=(Surface(between=("ground", "block")),),
        )
    )


@BOTH
def test_restored_runs_repeat_bit_for_bit_whatever_is_read_in_between(settings: Settings) -> None:
    scene = _stack(6)
    first, second = _build(scene, settings), _build(scene, settings)
    first.step(300)
    saved = first.save()
    first.step(200)
    expected = _state(first, scene)
    first.restore(saved)
    second.step(300)
    for simulation in (first, second):
        for _ in range(200):
            simulation.step()
            simulation.contacts()
            simulation.cast(np.array([[0.0, 0.0, 5.0]]), np.array([[0.0, 0.0, -1.0]]), 10.0)
            got = _state(simulation, scene)
        for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
            np.testing.assert_array_equal(getattr(got, name), getattr(expected, name))


def test_a_state_that_is_not_finite_is_raised_not_reset() -> None:
    scene = Scene(bodies=(Body(name="b"),))
    simulation = _build(scene)
    simulation.wrench(np.array([[1e308, 0.0, 0.0]]), np.zeros((1, 3)))
    with pytest.raises(Diverged, match="BADQACC"):
        simulation.step()
    with pytest.raises(Diverged):
        simulation.step()


def test_only_the_effects_called_for_are_on_and_the_rest_is_named() -> None:
    box = _shaped("box", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.1))
    scene = _on_ground(box, mu=0.5)
    off = _build(replace(scene, narrow=Effect.CONTACT | Effect.FRICTION | Effect.GRAVITY))
    assert {"contact", "gravity", "autoreset"} <= set(off.resolved.options["disabled"])
    assert len(off.contacts()) == 0
    assert Effect.GYROSCOPIC in {notice.effect for notice in off.warnings() if notice.kind == "surplus"}
    plain = _build(replace(scene, widen=Effect.CONTINUOUS_COLLISION))
    assert Effect.CONTINUOUS_COLLISION in {notice.effect for notice in plain.warnings() if notice.kind == "missing"}
    fast = _build(replace(scene, widen=Effect.CONTINUOUS_COLLISION), TUNED)
    assert fast.resolved.options["enabled"] == ["speculative"]
    slippery = replace(scene, narrow=Effect.FRICTION, bodies=(scene.bodies[0], replace(box, v_WB=(1.0, 0.0, 0.0))))
    simulation = _build(slippery)
    simulation.step(100)
    assert _state(simulation, slippery).v_WB[1, 0] == pytest.approx(1.0, abs=1e-12)


def test_by_scene_the_integrator_follows_contacts_and_stiffness() -> None:
    body = Body(name="b", inertia=principal_inertia(0.1, 0.1, 0.1))
    # sqrt(k/I) dt is 1.0 and 3.2; RK4 is stable up to 2.8.
    firm, stiff = (
        Scene(bodies=(body,), joints=(_hinge("j", WORLD, "b", (0, 0, 0), drive=Drive(stiffness=k)),)) for k in (1e5, 1e6)
    )
    box = _shaped("b", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.1))
    for e, name in ((0.0, "discrete"), (0.5, "implicitfast")):
        assert _build(replace(_on_ground(box, e=e), joints=stiff.joints), TUNED).resolved.integrator == name
    assert _build(Scene(bodies=(body,)), TUNED).resolved.integrator == "rk4"
    assert _build(_stack(1), TUNED).resolved.integrator == "euler"
    assert _build(firm, TUNED).resolved.integrator == "rk4"
    assert _build(stiff, TUNED).resolved.integrator == "discrete"
    assert _build(stiff, DEFAULT).resolved.integrator == "euler"
    with pytest.raises(Unsupported, match="discrete integrator"):
        _build(_on_ground(box, e=0.5), replace(TUNED, integrator="discrete"))


ARM_LENGTHS, ARM_MASSES, ARM_TARGETS = np.array([0.4, 0.35, 0.25]), np.array([3.0, 2.0, 1.0]), np.array([0.5, -0.8, 0.6])


def _arm(stiffness: float, damping: float) -> Scene:
    """Three rods in a row along x, held out over the ground by drives of their hinges; angles count from x upwards."""
    bodies, joints, x = [], [], 0.0
    for k, (length, mass, target) in enumerate(zip(ARM_LENGTHS, ARM_MASSES, ARM_TARGETS, strict=True)):
        turning = mass * length**2 / 12
        bodies.append(
            Body(name=f"l{k}", mass=mass, inertia=principal_inertia(1e-3, turning, turning), p_WB=(x + length / 2, 0.0, 0.0))
        )
        drive = Drive(stiffness=stiffness, damping=damping, target=target)
        parent = WORLD if k == 0 else f"l{k - 1}"
        joints.append(
            Revolute(name=f"j{k}", parent=parent, child=f"l{k}", anchor_W=(x, 0.0, 0.0), axis_W=(0.0, -1.0, 0.0), drive=drive)
        )
        x += length
    return Scene(bodies=tuple(bodies), joints=tuple(joints))


def _arm_truth(time: float, stiffness: float, damping: float) -> Floats:
    """Angles from x (3,) [rad] after `time` [s], by Lagrange's equations in absolute angles and an integrator of order 8.

    M_ij = a_ij cos(th_i - th_j), a_ii = l_i^2 (m_i/3 + masses further out), a_ij = l_i l_j (m_j/2 + masses beyond j).
    """
    out = np.array([ARM_MASSES[k + 1 :].sum() for k in range(3)])
    lever = ARM_LENGTHS * (ARM_MASSES / 2 + out)
    a = np.outer(ARM_LENGTHS, lever)
    a = np.triu(a, 1) + np.triu(a, 1).T + np.diag(ARM_LENGTHS**2 * (ARM_MASSES / 3 + out))

    def rate(_: float, y: Floats) -> Floats:
        angle, speed = y[:3], y[3:]
        apart = angle[:, None] - angle[None, :]
        torque = stiffness * (ARM_TARGETS - np.diff(angle, prepend=0.0)) - damping * np.diff(speed, prepend=0.0)
        load = torque - np.append(torque[1:], 0.0) - G * lever * np.cos(angle) - (a * np.sin(apart)) @ speed**2
        return np.concatenate([speed, np.linalg.solve(a * np.cos(apart), load)])

    return np.asarray(solve_ivp(rate, (0.0, time), np.zeros(6), method="DOP853", rtol=1e-11, atol=1e-13).y[:3, -1])


@pytest.mark.parametrize(("damping", "dt", "name"), [(2.0, 1 / 240, "rk4"), (20.0, 1e-4, "rk4"), (20.0, 1e-3, "implicitfast")])
def test_a_driven_arm_takes_the_integrator_that_is_nearer_to_an_independent_one(damping: float, dt: float, name: str) -> None:
    """The outer link's inertia is 40 times what it is to the joint: only joint-space inertia tells what RK4 can carry."""
    scene, truth, errors = _arm(200.0, damping), _arm_truth(0.25, 200.0, damping), {}
    assert _build(scene, TUNED, dt).resolved.integrator == name
    for integrator in ("rk4", "implicitfast"):
        simulation = _build(scene, replace(TUNED, integrator=integrator), dt)
        try:
            simulation.step(round(0.25 / dt))
        except Diverged:
            errors[integrator] = math.inf
            continue
        q = _state(simulation, scene).q_WB
        errors[integrator] = float(np.abs(-2 * np.arctan2(q[:, 2], q[:, 0]) - truth).max())
    other = "rk4" if name == "implicitfast" else "implicitfast"
    # Where RK4 resolves the fastest mode it errs by far less than a rule of first order; where it does not, it diverges.
    assert errors[name] < errors[other] / 10
    assert errors[name] < 2e-3


@pytest.mark.parametrize("z", [0.05, 0.5, 1.0, 1.9, 2.1, 2.7])
def test_a_damper_takes_the_rule_that_decays_nearest_to_the_closed_form(z: float) -> None:
    """w = w0 e^(-c t/I): RK4 up to c h/I = 2, where its factor of 1/3 a step is that of the implicit rule, and not beyond."""
    spin = Body(name="b", inertia=principal_inertia(1.0, 1.0, 1.0), w_WB=(0.0, 1.0, 0.0))
    damper = _hinge("j", WORLD, "b", (0, 0, 0), spring=Spring(stiffness=0.0, damping=1e3 * z))
    scene, errors = Scene(bodies=(spin,), joints=(damper,)), {}
    for integrator in ("rk4", "implicitfast"):
        simulation = _build(scene, replace(TUNED, integrator=integrator))
        simulation.step(1)
        errors[integrator] = abs(_state(simulation, scene).w_WB[0, 1] - math.exp(-z))
    assert _build(scene, TUNED).resolved.integrator == min(errors, key=lambda name: errors[name])


def test_a_spring_that_the_velocity_implicit_rule_would_blow_up_is_given_to_the_one_that_is_implicit_in_position() -> None:
    """Undamped at w h = 1, 1.4, 1.6, 3 and 250: below the limit of 2 the energy of the one keeps, beyond it the other fades.

    Semi-implicit in velocity, an amplitude stays within 1/sqrt(1 - (w h/2)^2) of what it was; implicit in position, it falls by
    1/sqrt(1 + (w h)^2) a step.
    """
    mass, dt, steps = Body(name="b", p_WB=(0.3, 0.0, 0.0)), 1e-3, 1000
    for z, name in ((1.0, "implicitfast"), (1.4, "implicitfast"), (1.6, "discrete"), (3.0, "discrete"), (250.0, "discrete")):
        # Damping that RK4 does not carry, of another coordinate, so that the spring alone decides.
        springs = {"b": Spring(stiffness=(z / dt) ** 2, damping=0.0), "c": Spring(stiffness=0.0, damping=10 / dt)}
        rails = tuple(
            Prismatic(name=k, parent=WORLD, child=k, anchor_W=(0, 0, 0), axis_W=(1, 0, 0), position=x, spring=springs[k])
            for k, x in (("b", 0.3), ("c", 0.0))
        )
        scene = Scene(bodies=(mass, Body(name="c")), joints=rails, gravity=(0.0, 0.0, 0.0))
        simulation, far = _build(scene, TUNED, dt), 0.0
        assert simulation.resolved.integrator == name
        for _ in range(steps):
            simulation.step()
            far = max(far, abs(float(_state(simulation, scene).p_WB[0, 0])))
        bound = 1 / math.sqrt(1 - z * z / 4) if name == "implicitfast" else 1.0
        assert far <= 0.3 * bound * (1 + 1e-9)
        # After 1000 steps at z = 1.6 and beyond nothing is left but rounding.
        assert name == "implicitfast" or abs(float(_state(simulation, scene).p_WB[0, 0])) < 1e-15
    with pytest.raises(Diverged):
        _build(scene, replace(TUNED, integrator="implicitfast"), dt).step(steps)


def test_a_light_slide_on_a_heavy_one_is_judged_by_the_inertia_that_its_damper_moves() -> None:
    """Linear, so that the matrix exponential is the truth. A damper between 10 kg and 0.1 kg moves 10 x 0.1/10.1 kg."""
    heavy, light = Body(name="heavy", mass=10.0), Body(name="light", mass=0.1, v_WB=(1.0, 0.0, 0.0))
    c, k, dt = 50.0, 400.0, 1e-3
    joints = tuple(
        Prismatic(name=child, parent=parent, child=child, anchor_W=(0, 0, 0), axis_W=(1.0, 0.0, 0.0), spring=spring)
        for parent, child, spring in (
            (WORLD, "heavy", Spring(stiffness=k, damping=0.0)),
            ("heavy", "light", Spring(stiffness=k, damping=c)),
        )
    )
    scene = Scene(bodies=(heavy, light), joints=joints, gravity=(0.0, 0.0, 0.0))
    K, C = np.array([[2 * k, -k], [-k, k]]), np.array([[c, -c], [-c, c]])
    inverse = np.diag([1 / 10.0, 1 / 0.1])
    motion = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ K, -inverse @ C]])
    truth = expm(motion * 0.1) @ np.array([0.0, 0.0, 0.0, 1.0])
    errors = {}
    for integrator in (None, "implicitfast"):
        simulation = _build(scene, replace(TUNED, integrator=integrator), dt)
        simulation.step(100)
        errors[integrator] = float(np.abs(_state(simulation, scene).p_WB[:, 0] - truth[:2]).max())
    # c h/m is .505: |R(-z) - e^-z| is z^5/120 = 2.7e-4 of the first step's decay; the implicit rule errs by z^2/2 = 13 %.
    assert errors[None] < errors["implicitfast"] / 100


def test_time_constants_are_what_resolved_says_and_bounded_only_by_a_bound_that_is_set() -> None:
    """A ball that falls on steps of 1/60 s: the engine's own way with a constant of two steps, and with what is asked."""
    ball = _on_ground(_shaped("ball", Sphere(radius=0.1), (0.0, 0.0, 0.3)))

    def landed(options: dict[str, object], dt: float) -> tuple[float, float]:
        simulation = _build(ball, Settings(options=options), dt)
        simulation.step(round(0.4 / dt))
        return simulation.resolved.options["contact_time_constant"], float(_state(simulation, ball).p_WB[1, 2])

    asked, sunk = landed({"contact_steps": 20.0}, 1 / 240)
    assert asked == pytest.approx(20 / 240)
    bounded, shallow = landed({"contact_steps": 20.0, "slowest": 0.02}, 1 / 240)
    assert bounded == pytest.approx(0.02)
    assert shallow > sunk
    # mjDSBL_REFSAFE: at 1/60 s both ask for less than two steps, and get two.
    vendor, two = landed({}, 1 / 60), landed({"contact_steps": 2.0}, 1 / 60)
    assert vendor == two
    assert vendor[0] == pytest.approx(2 / 60)
    assert _build(ball, TUNED, 1 / 240).resolved.options["contact_time_constant"] == pytest.approx(0.02)


def test_a_stop_is_passed_by_less_than_a_step_and_the_limit_is_no_softer_than_its_own_settings_say() -> None:
    """A rod swings down into a stop: by its own `limit_steps`, whatever contacts are told."""
    inertia = principal_inertia(1 / 12, 1 / 12, 1e-3)
    rod = Body(name="rod", inertia=inertia, p_WB=(0.0, 0.0, -0.5), w_WB=(0.0, 4.0, 0.0), v_WB=(-2.0, 0.0, 0.0))
    scene = Scene(bodies=(rod,), joints=(_hinge("j", WORLD, "rod", (0, 0, 0), limits=Limits(upper=0.3)),))
    for dt in (1 / 240, 1e-3):
        simulation, beyond = _build(scene, TUNED, dt), 0.0
        for _ in range(round(0.4 / dt)):
            simulation.step()
            q = _state(simulation, scene).q_WB[0]
            beyond = max(beyond, 2 * math.atan2(q[2], q[0]) - 0.3)
        # Noticed once it is passed, it is passed by at most a step's way at 4 rad/s; the damping takes what is left of a step.
        assert 0.0 < beyond < 1.25 * 4.0 * dt
        assert simulation.resolved.options["limit_time_constant"] == pytest.approx(2 * dt)


def test_settings_out_of_range_name_field_value_and_expectation() -> None:
    scene = Scene(bodies=(Body(name="b"),))
    for settings, said in (
        (Settings(integrator="verlet"), "integrator 'verlet'.*euler"),
        (Settings(options={"impratio": -1}), "'impratio' is -1, expected"),
        (Settings(options={"cone": "round"}), "'cone' is 'round', expected one of pyramidal, elliptic"),
        (Settings(options={"multiccd": 1}), "'multiccd' is 1, expected true or false"),
    ):
        with pytest.raises(SettingsError, match=said):
            ADAPTER.build(scene, settings)


def test_substeps_divide_the_step() -> None:
    scene = Scene(bodies=(Body(name="b"),))
    simulation = ADAPTER.build(scene, Settings(dt=0.01, substeps=4))
    simulation.step(100)
    # g h t/2 below the parabola with h = dt/4.
    assert _state(simulation, scene).p_WB[0, 2] == pytest.approx(-G / 2 - G * 0.0025 / 2, abs=1e-11)
    assert simulation.resolved.dt == pytest.approx(0.01)


@BOTH
def test_substeps_are_the_engine_s_own_steps_under_a_wrench_that_is_held_and_one_of_them_changes_nothing(
    settings: Settings,
) -> None:
    """What a step of n sub-steps gives is, bit for bit, what n steps of dt/n give that are told the same."""
    box = _shaped("box", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.099), v=(0.5, 0.0, 0.0))
    scene, dt = _on_ground(box, mu=0.5), 1 / 64
    push = np.array([[0.0, 0.0, 0.0], [2.0, 1.0, -1.0]])

    def after(substeps: int | None, step: float, calls: int) -> tuple[MujocoSimulation, State]:
        simulation = ADAPTER.build(scene, replace(settings, dt=step, substeps=substeps))
        simulation.wrench(push, np.zeros((2, 3)))
        for _ in range(calls):
            simulation.step()
        return simulation, _state(simulation, scene)

    for one, other in (((None, dt, 32), (1, dt, 32)), ((4, dt, 32), (None, dt / 4, 128))):
        (simulation, a), (_, b) = after(*one), after(*other)
        assert simulation.resolved.substeps == (one[0] or 1)
        assert simulation.resolved.dt == dt
        for field in ("p_WB", "q_WB", "v_WB", "w_WB"):
            np.testing.assert_array_equal(getattr(a, field), getattr(b, field))


def test_friction_takes_its_own_time_constant_and_a_pyramid_has_none() -> None:
    """A cube slides at 5 cm/s: with a constant tc, b = 2/tc slows it by 2 v/tc where that is below mu g."""
    scene, dt = _on_ground(_shaped("cube", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.1)), mu=0.5), 1e-3
    for steps, constant, slowed in ((30.0, 0.03, 3.333), (40.0, 0.04, 2.5), (80.0, 0.08, 1.25)):
        options = {**TUNED.options, "friction_steps": steps, "slowest": 1.0}
        simulation = _build(scene, replace(TUNED, options=options), dt)
        assert simulation.resolved.options["friction_time_constant"] == pytest.approx(constant)
        simulation.step(1000)
        simulation._d.qvel[0] = 0.05
        simulation.step()
        # Exact but for the share of .999 that the impedance leaves to the reference.
        assert (0.05 - _state(simulation, scene).v_WB[1, 0]) / dt == pytest.approx(slowed, rel=2e-3)
    options = {**TUNED.options, "friction_steps": 2.0, "cone": "pyramidal"}
    pyramid = _build(scene, replace(TUNED, options=options), dt).resolved.options
    assert pyramid["friction_time_constant"] == pyramid["contact_time_constant"] == pytest.approx(0.02)


def test_the_next_value_of_every_knob_of_contact_tells_at_the_usual_step() -> None:
    """A search turns each knob once, to its next value, and leaves alone what then changes nothing, bit for bit."""
    box = _shaped("box", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.11), v=(0.5, 0.0, 0.0))
    scene = _on_ground(box, mu=0.5)

    def end(settings: Settings) -> Floats:
        simulation = ADAPTER.build(scene, settings.with_dt(1 / 240))
        simulation.step(60)
        return _state(simulation, scene).p_WB

    own = end(TUNED)
    knobs = ("contact_steps", "contact_damping_ratio", "contact_impedance", "friction_steps", "slowest", "impratio", "cone")
    for knob in knobs:
        values = ADAPTER.knobs[f"options.{knob}"]
        now = TUNED.options.get(knob)
        following = values[values.index(now) + 1] if now in values[:-1] else values[0]
        assert not np.array_equal(end(replace(TUNED, options={**TUNED.options, knob: following})), own), knob


def test_friction_of_a_rebound_is_as_slow_as_the_impact_or_as_it_is_told() -> None:
    scene = _on_ground(_shaped("ball", Sphere(radius=0.1), (0.0, 0.0, 0.3)), mu=0.3, e=0.8)
    for told, constant in (({}, 10e-3), ({"rebound_steps": 40}, 40e-3), ({"rebound_steps": 40, "friction_steps": 60.0}, 60e-3)):
        simulation = _build(scene, replace(TUNED, options={**TUNED.options, **told}))
        assert list(simulation._m.pair_solreffriction[0]) == pytest.approx([constant, 1.0])
        assert simulation.resolved.options["friction_steps"] == pytest.approx(constant / 1e-3)


def test_loops_that_no_constraint_of_the_engine_closes_are_refused() -> None:
    bodies = tuple(_rod(name, (float(k), 0.0, 0.0), 0) for k, name in enumerate("ab"))
    slides = tuple(
        Prismatic(name=f"{a}-{b}", parent=a, child=b, anchor_W=(0.0, 0.0, 0.0), axis_W=(1.0, 0.0, 0.0))
        for a, b in ((WORLD, "a"), ("a", "b"), (WORLD, "b"))
    )
    with pytest.raises(Unsupported, match="prismatic joint that closes a loop"):
        _build(Scene(bodies=bodies, joints=slides))
