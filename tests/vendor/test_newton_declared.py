"""What Newton's adapter declares of contacts, joints and materials, in newton's own words."""

import inspect
import math
from typing import Any

import numpy as np
import pytest

from tests.vendor.test_newton import G, mujoco, newton, run, wp

pytestmark = pytest.mark.newton


def on_a_cylinder(**options: Any) -> tuple[float, float]:
    """How deep [m] a box of 0.2 m is in the flat end of a cylinder after 2 s, and how far [1] it has turned."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    config = newton.ModelBuilder.ShapeConfig(mu=0.5, density=0.0)
    below = wp.transform((0.0, 0.0, -0.5), wp.quat_identity())
    builder.add_shape_cylinder(-1, xform=below, radius=1.0, half_height=0.5, cfg=config)
    body = builder.add_body(
        xform=wp.transform((0.0, 0.0, 0.1), wp.quat_identity()),
        mass=1.0,
        inertia=wp.mat33(1 / 150, 0, 0, 0, 1 / 150, 0, 0, 0, 1 / 150),
        lock_inertia=True,
    )
    builder.add_shape_box(body, hx=0.1, hy=0.1, hz=0.1, cfg=config)
    model = builder.finalize(device="cpu")
    pose = run(model, mujoco(model, **options), 480, 1 / 240)[0][0]
    return 0.1 - float(pose[2]), 1.0 - abs(float(pose[6]))


def test_a_box_on_a_cylinder_has_one_point_as_it_comes_and_several_if_enable_multiccd_is_told() -> None:
    deep, turned = on_a_cylinder()
    assert deep > 3e-3
    assert turned > 1e-4
    deep, turned = on_a_cylinder(enable_multiccd=True)
    assert deep < 2e-4
    assert turned < 1e-6


def trembles(share: float, cone: str) -> float:
    """The speed [m/s] at which a column of five boxes on a plane trembles after 5 s. Args: share: its contacts' impedance."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    t, impedance = 0.02, {"mujoco:geom_solimp": (share, share, 0.001, 0.5, 2.0)}
    config = newton.ModelBuilder.ShapeConfig(mu=0.5, density=0.0, ke=1.0 / (1.2 * t) ** 2, kd=2.0 / t)
    builder.add_shape_plane(plane=(0.0, 0.0, 1.0, 0.0), width=0.0, length=0.0, cfg=config, custom_attributes=impedance)
    for k in range(5):
        body = builder.add_body(xform=at(z=0.1 + 0.2 * k), mass=1.0, inertia=round_inertia(1 / 150), lock_inertia=True)
        builder.add_shape_box(body, hx=0.1, hy=0.1, hz=0.1, cfg=config, custom_attributes=impedance)
    model = builder.finalize(device="cpu")
    solver = mujoco(model, cone=cone, impratio=10.0, integrator="euler", nconmax=64, njmax=512)
    return float(np.abs(run(model, solver, 1200, 1 / 240)[1][:, :3]).max())


def test_under_elliptic_cones_a_column_trembles_unless_its_contacts_are_softer() -> None:
    assert trembles(0.999, "elliptic") > 1e-3
    assert max(trembles(0.95, "elliptic"), trembles(0.999, "pyramidal")) < 1e-4


SHAPE = set(newton.ModelBuilder.ShapeConfig.__dataclass_fields__)
BUILDER = {name for name in dir(newton.ModelBuilder) if name.startswith("add_")}


def test_what_a_shape_and_a_builder_have_words_for() -> None:
    """Rolling and torsional friction, mimics, tendons and distances among them, which the adapter does not tell yet."""
    assert {"mu", "mu_rolling", "mu_torsional", "restitution"} <= SHAPE
    assert {"add_constraint_mimic", "add_tendon", "add_joint_distance", "add_spring"} <= BUILDER
    assert "not supported" in str(newton.solvers.SolverMuJoCo.__doc__).split("DISTANCE")[1][:40]


@pytest.mark.parametrize("word", ["static", "kinetic", "pair_friction", "gyro", "ccd", "continuous"])
def test_no_shape_builder_or_rigid_solver_has_such_a_word(word: str) -> None:
    """But `ccd_iterations`, of MuJoCo's distances, and `include_static_kinematic_pairs`, of who meets whom."""
    known = {"ccd_iterations", "ccd_tolerance", "enable_multiccd", "include_static_kinematic_pairs"}
    calls = (newton.solvers.SolverMuJoCo, newton.solvers.SolverXPBD, newton.CollisionPipeline)
    names = SHAPE | BUILDER | {name for call in calls for name in inspect.signature(call.__init__).parameters}
    assert not [name for name in names - known if word in name.lower()]


def test_speculative_contacts_are_told_to_be_no_continuous_collision() -> None:
    text = " ".join(str(newton.solvers.SolverMuJoCo.__init__.__doc__).split())
    assert "mitigates tunneling; it is not continuous collision detection" in text


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    return wp.transform((x, y, z), wp.quat_identity())


def round_inertia(moment: float) -> Any:
    return wp.mat33(moment, 0, 0, 0, moment, 0, 0, 0, moment)


def surface(**words: Any) -> Any:
    return newton.ModelBuilder.ShapeConfig(mu=0.5, density=0.0, **words)


def channel(upside_down: bool) -> Any:
    """A mesh with the profile of a U, 1 m long: a floor .1 m thick its top at z = 0, walls to z = .3 m at |x| = .3 to .4."""
    profile = [(-0.4, -0.1), (0.4, -0.1), (0.4, 0.3), (0.3, 0.3), (0.3, 0.0), (-0.3, 0.0), (-0.3, 0.3), (-0.4, 0.3)]
    points = np.array([(x, y, z) for y in (-0.5, 0.5) for x, z in profile], dtype=np.float32)
    faces = []
    for a, b, c, d in ((0, 1, 4, 5), (1, 2, 3, 4), (0, 5, 6, 7)):
        faces += [(a, b, c), (a, c, d), (a + 8, c + 8, b + 8), (a + 8, d + 8, c + 8)]
    for a, b in ((k, (k + 1) % 8) for k in range(8)):
        faces += [(a, a + 8, b + 8), (a, b + 8, b)]
    if upside_down:
        points = points * np.array([1.0, -1.0, -1.0], dtype=np.float32)
    return newton.Mesh(points, np.array(faces, dtype=np.int32).ravel(), compute_inertia=False)


@pytest.mark.timeout(1800)  # on a new machine kernels are compiled for minutes
@pytest.mark.parametrize("whose", ["mujoco", "newton"])
def test_a_mesh_is_its_hull_to_mujoco_warp_and_a_mesh_to_newton_s_own_contacts_moving_or_not(whose: str) -> None:
    """A ball falls into a channel that stands still, and a channel upside down over a beam; a hull is closed at z = 0.3 m."""
    heights = []
    for upside_down in (False, True):
        builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
        if upside_down:
            builder.add_shape_box(-1, xform=at(z=-0.5), hx=0.2, hy=1.0, hz=0.5, cfg=surface())
            start = 0.35 if whose == "mujoco" else 0.05
            body = builder.add_body(xform=at(z=start), mass=1.0, inertia=round_inertia(0.1), lock_inertia=True)
            builder.add_shape_mesh(body, mesh=channel(upside_down), cfg=surface())
        else:
            builder.add_shape_mesh(-1, mesh=channel(upside_down), cfg=surface())
            body = builder.add_body(xform=at(z=0.42), mass=1.0, inertia=round_inertia(0.004), lock_inertia=True)
            builder.add_shape_sphere(body, radius=0.1, cfg=surface())
        model = builder.finalize(device="cpu")
        solver = mujoco(model, use_mujoco_contacts=whose == "mujoco", nconmax=64, njmax=512)
        heights.append(float(run(model, solver, 480, 1 / 240)[0][0, 2]))
    expected = [0.4, 0.3] if whose == "mujoco" else [0.1, 0.0]
    assert heights == pytest.approx(expected, abs=0.01)


def hinge(friction: float = 0.0, limits: tuple[float, float] = (-1e10, 1e10), **attributes: Any) -> Any:
    """1 kg, 0.1 kg m^2 on a hinge of the world through its centre."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    link = builder.add_link(mass=1.0, inertia=round_inertia(0.1), lock_inertia=True)
    told = {f"mujoco:{name}": [value] for name, value in attributes.items()}
    joint = builder.add_joint_revolute(
        -1,
        link,
        axis=(0, 1, 0),
        limit_lower=limits[0],
        limit_upper=limits[1],
        friction=friction,
        velocity_limit=0.5,
        custom_attributes=told or None,
    )
    builder.add_articulation([joint])
    return builder.finalize(device="cpu")


def pushed(model: Any, solver: Any, effort: float, steps: int = 2000, dt: float = 1e-3) -> tuple[float, float]:
    """Coordinate and rate under a constant effort, after an even number of steps; XPBD tells no coordinate."""
    model.joint_f.assign(np.array([effort], dtype=np.float32))
    control, states = model.control(), [model.state(), model.state()]
    with wp.ScopedCapture(device="cpu") as capture:
        for here, there in (states, states[::-1]):
            solver.step(here, there, control, None, dt)
    for _ in range(steps // 2):
        wp.capture_launch(capture.graph)
    if isinstance(solver, newton.solvers.SolverXPBD):
        return math.nan, float(np.linalg.norm(states[0].body_qd.numpy()[0, 3:]))
    return float(states[0].joint_q.numpy()[0]), float(states[0].joint_qd.numpy()[0])


def test_contacts_dry_friction_and_loops_are_soft_by_20_ms_as_they_come_and_limits_springs_of_1e4() -> None:
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    links = [builder.add_link(xform=at(0.5 * k), mass=1.0, inertia=round_inertia(0.1), lock_inertia=True) for k in (0, 1)]
    builder.add_shape_sphere(links[0], radius=0.1, cfg=surface())
    limits = {"axis": (0, 1, 0), "limit_lower": -1.0, "limit_upper": 1.0}
    tree = [builder.add_joint_revolute(-1, links[0], **limits)]
    tree.append(builder.add_joint_revolute(links[0], links[1], parent_xform=at(0.5), **limits))
    builder.add_articulation(tree)
    builder.add_joint_ball(-1, links[1], parent_xform=at(1.0), child_xform=at(0.5))
    soft = mujoco(builder.finalize(device="cpu")).mjw_model
    for name in ("geom_solref", "dof_solref", "eq_solref"):
        assert getattr(soft, name).numpy()[0, 0] == pytest.approx([0.02, 1.0])
    assert (soft.jnt_solref.numpy()[0, :, 0] > 0.1).all(), "not .02 s: a spring for the inertia of each coordinate"
    for effort in (10.0, 100.0):
        model = hinge(limits=(-1.0, 0.0))
        assert pushed(model, mujoco(model), effort)[0] == pytest.approx(effort / 1e4, rel=0.03)
    stiff: dict[str, Any] = {"solreflimit": (2e-3, 1.7), "solreflimit_mode": 1, "solimplimit": (0.999, 0.999, 0.001, 0.5, 2.0)}
    model = hinge(limits=(-1.0, 0.0), **stiff)
    assert pushed(model, mujoco(model), 100.0)[0] < 1e-4


STIFF: dict[str, Any] = {"solreffriction": (2e-3, 1.0), "solimpfriction": (0.999, 0.999, 0.001, 0.5, 2.0)}


def test_what_dry_friction_holds_creeps_as_it_comes_and_hardly_at_two_steps() -> None:
    """Under .6 of the bound, at 1 ms."""
    model = hinge(friction=1.0)
    assert 3e-3 < pushed(model, mujoco(model), 0.6)[1] < 1e-2
    model = hinge(friction=1.0, **STIFF)
    assert pushed(model, mujoco(model), 0.6)[1] < 1e-5


def test_a_rate_under_stiff_dry_friction_is_off_in_single_precision_and_exact_in_mujoco_s_double() -> None:
    """A bound of 1 N m brakes 12 rad/s by 10 rad/s in a second; MuJoCo steps the very model that Newton made for it."""
    steps, dt, double = 1000, 1e-3, pytest.importorskip("mujoco")
    model = hinge(friction=1.0, **STIFF)
    model.joint_qd.assign(np.array([12.0], dtype=np.float32))
    solver = mujoco(model, integrator="euler")
    single = pushed(model, solver, 0.0, steps, dt)[1]
    solver.mj_model.opt.timestep = dt
    data = double.MjData(solver.mj_model)
    data.qvel[0] = 12.0
    for _ in range(steps):
        double.mj_step(solver.mj_model, data)
    exact = 12.0 - 1.0 / float(np.float32(0.1))  # the inertia that Newton tells
    assert abs(data.qvel[0] - exact) < 1e-9
    assert 1e-6 < abs(single - exact) < 1e-3


def test_neither_mujoco_nor_xpbd_bounds_the_rate_of_a_joint_and_steel_does() -> None:
    """A bound of .5 rad/s, and 2 s under 1 rad/s^2."""
    rates = {}
    for name, make in (
        ("mujoco", mujoco),
        ("xpbd", newton.solvers.SolverXPBD),
        ("steel", lambda model: newton.solvers.SolverSteel(model, enable_joint_velocity_limits=True)),
    ):
        model = hinge()
        rates[name] = pushed(model, make(model), 0.1, steps=500, dt=4e-3)[1]
    assert rates == pytest.approx({"mujoco": 2.0, "xpbd": 2.0, "steel": 0.5}, rel=1e-3)


@pytest.mark.parametrize(("turn", "least", "most"), [(0.0, 0.0, 5e-6), (0.7, 3e-5, 5e-4)], ids=["flat", "tilted"])
def test_rays_meet_a_tilted_plane_at_a_graze_a_tenth_of_a_millimetre_off(turn: float, least: float, most: float) -> None:
    """Within 50 m, from .9 m above; on a plane along the axes no more than the digits of the distance."""
    axis = np.array([1.0, 2.0, 0.5]) / math.sqrt(5.25)
    x, y, z, w = (*(axis * math.sin(turn / 2)), math.cos(turn / 2))
    normal = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    along = np.cross(normal, [0.0, 1.0, 0.0])
    along /= np.linalg.norm(along)
    builder, count = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0)), 2000
    builder.add_shape_plane(None, xform=wp.transform((0.0, 0.0, 0.0), wp.quat(x, y, z, w)), width=0.0, length=0.0)
    model = builder.finalize(device="cpu")
    model.bvh_refit_shapes(model.state())
    draw = np.random.default_rng(0)
    falls, angles = draw.uniform(0.02, 0.1, (count, 1)), draw.uniform(0.0, 2 * math.pi, (count, 1))
    level = np.cos(angles) * along + np.sin(angles) * np.cross(normal, along)
    ways = (np.sqrt(1.0 - falls**2) * level - falls * normal).astype(np.float32)
    starts = np.tile(0.9 * normal, (count, 1)).astype(np.float32)
    distance = wp.full(count, -1.0, dtype=float, device="cpu")
    newton.intersect_ray(
        model,
        ray_origins=wp.array(starts, dtype=wp.vec3, device="cpu"),
        ray_directions=wp.array(ways, dtype=wp.vec3, device="cpu"),
        ray_worlds=wp.zeros(count, dtype=wp.int32, device="cpu"),
        out_dist=distance,
        out_shape_id=wp.full(count, -1, dtype=wp.int32, device="cpu"),
        out_normal=wp.zeros(count, dtype=wp.vec3, device="cpu"),
        fast_math=False,
    )
    exact = -(starts.astype(np.float64) @ normal) / (ways.astype(np.float64) @ normal)
    assert least <= np.abs(distance.numpy() - exact).max() < most


def spun(tensor: Any, solver: Any) -> Any:
    """v and w after 1 s of a free body of 2 kg whose coordinates are damped by .2 m and by .5 of its moments of inertia."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    body = builder.add_body(mass=2.0, inertia=wp.mat33(*np.ravel(tensor).tolist()), lock_inertia=True)
    builder.joint_damping[0:6] = [0.4, 0.4, 0.4, *(0.5 * float(tensor[k][k]) for k in range(3))]
    builder.joint_qd[0] = builder.joint_qd[3] = 1.0
    builder.body_qd[body] = wp.spatial_vector(1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    model = builder.finalize(device="cpu")
    return run(model, solver(model), 1000, 1e-3)[1][0]


def test_mujoco_damps_coordinates_each_by_itself_so_products_of_inertia_turn_what_a_body_s_damping_would_not() -> None:
    """Damping of a body, a torque of -.5 I w, leaves e^-.5 of each spin's momentum after 1 s, whatever I is."""
    v_x, _, _, w_x, w_y, _ = spun(np.diag([0.1, 0.1, 0.1]), mujoco)
    assert v_x == pytest.approx(math.exp(-0.2), rel=1e-3)
    assert w_x == pytest.approx(math.exp(-0.5), rel=1e-3)
    assert abs(w_y) < 1e-6
    uneven = spun([[0.1, 0.04, 0.0], [0.04, 0.1, 0.0], [0.0, 0.0, 0.12]], mujoco)
    assert abs(uneven[3] - math.exp(-0.5)) > 0.02
    assert "viscosity" in inspect.signature(newton.solvers.SolverMuJoCo.__init__).parameters, "of one medium for all bodies"
    assert not [name for name in inspect.signature(newton.ModelBuilder.add_body).parameters if "damp" in name]


def test_xpbd_has_one_damping_of_spin_for_all_bodies_and_reads_none_of_coordinates() -> None:
    for damping in (0.0, 0.5):
        v_x, _, _, w_x, _, _ = spun(
            np.diag([0.1, 0.1, 0.1]), lambda model, c=damping: newton.solvers.SolverXPBD(model, angular_damping=c)
        )
        assert v_x == pytest.approx(1.0, rel=1e-3)
        assert w_x == pytest.approx(math.exp(-damping), rel=2e-3)
    words = [name for name in inspect.signature(newton.solvers.SolverXPBD.__init__).parameters if "damp" in name]
    assert words == ["angular_damping"]


def test_mujoco_s_own_contacts_let_no_body_touch_the_one_that_it_hangs_on_newton_s_and_xpbd_do() -> None:
    """A ball slides down a rail on a plate of .1 m that lies on the ground, and comes to rest on one of both."""
    heights = {}
    for name, make in (
        ("mujoco", lambda model: mujoco(model, nconmax=64, njmax=256)),
        ("newton's", lambda model: mujoco(model, nconmax=64, njmax=256, use_mujoco_contacts=False)),
        ("xpbd", newton.solvers.SolverXPBD),
    ):
        builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
        plate = builder.add_link(mass=5.0, inertia=round_inertia(1.0), lock_inertia=True)
        builder.add_shape_box(plate, hx=0.5, hy=0.5, hz=0.05, cfg=surface(collision_filter_parent=False))
        ball = builder.add_link(xform=at(z=0.3), mass=1.0, inertia=round_inertia(0.01), lock_inertia=True)
        builder.add_shape_sphere(ball, radius=0.1, cfg=surface(collision_filter_parent=False))
        held = {"parent_xform": at(z=0.3), "collision_filter_parent": False}
        rail = builder.add_joint_prismatic(plate, ball, axis=(0, 0, 1), **held)
        free = builder.add_joint_free(plate, collision_filter_parent=False)
        builder.add_articulation([free, rail] if free < rail else [rail, free])
        builder.add_shape_plane(None, xform=at(z=-0.05), width=0.0, length=0.0, cfg=surface())
        model = builder.finalize(device="cpu")
        heights[name] = float(run(model, make(model), 480, 1 / 240)[0][1, 2])
    assert heights == pytest.approx({"mujoco": 0.05, "newton's": 0.15, "xpbd": 0.15}, abs=2e-3)


def told_force(make: Any, rebound: float) -> tuple[float, float]:
    """What contacts are told to have given a ball of 1 kg in a tenth of a second, and what they did [N s], upwards.

    It lies on a plane; or comes at 2 m/s from a tenth of a metre above, with this restitution.
    """
    builder, speed, dt = newton.ModelBuilder(gravity=(0.0, 0.0, -G)), -2.0 if rebound else 0.0, 1e-3
    builder.add_shape_plane(None, xform=at(), width=0.0, length=0.0, cfg=surface(restitution=rebound))
    body = builder.add_body(xform=at(z=0.2 if rebound else 0.1), mass=1.0, inertia=round_inertia(0.004), lock_inertia=True)
    builder.add_shape_sphere(body, radius=0.1, cfg=surface(restitution=rebound))
    builder.joint_qd[2], builder.body_qd[body] = speed, wp.spatial_vector(0.0, 0.0, speed, 0.0, 0.0, 0.0)
    model = builder.finalize(device="cpu")
    solver, pipeline, states, impulse = make(model), newton.CollisionPipeline(model), [model.state(), model.state()], 0.0
    contacts = pipeline.contacts()
    seen = solver.observables([newton.solvers.SolverBase.ObservableKind.CONTACT_F], contacts=contacts)
    for _ in range(100):
        pipeline.collide(states[0], contacts)
        solver.step(states[0], states[1], model.control(), contacts, dt, observables=seen)
        states.reverse()
        impulse -= float(seen.contact_f.numpy()[:, 2].sum()) * dt
    return impulse, float(states[0].body_qd.numpy()[0, 2]) - speed + G * 0.1


def test_both_solvers_tell_forces_of_what_rests_and_xpbd_none_of_rebounds() -> None:
    for make in (lambda model: mujoco(model, nconmax=64, njmax=256), newton.solvers.SolverXPBD):
        told, given = told_force(make, 0.0)
        assert told == pytest.approx(given, rel=0.02)
    told, given = told_force(lambda model: newton.solvers.SolverXPBD(model, enable_restitution=True), 0.8)
    assert given > 3.0
    assert told < 0.1 * given
    assert "approximate" in str(newton.solvers.SolverXPBD.__doc__).split("CONTACT_F")[1][:60]


def test_nothing_that_moves_is_without_mass() -> None:
    """MuJoCo's compiler refuses a link of no mass that bears another; XPBD lets it stand in the air."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    links = [builder.add_link(mass=m, inertia=round_inertia(0.1 * m), lock_inertia=True) for m in (0.0, 1.0)]
    first = builder.add_joint_revolute(-1, links[0], axis=(0, 1, 0))
    second = builder.add_joint_revolute(links[0], links[1], axis=(1, 0, 0), child_xform=at(0.3, 0.2))
    builder.add_articulation([first, second])
    model = builder.finalize(device="cpu")
    with pytest.raises(ValueError, match="mass and inertia of moving bodies must be larger than mjMINVAL"):
        mujoco(model)
    assert (run(model, newton.solvers.SolverXPBD(model), 480, 1 / 240)[0][0] == [0, 0, 0, 0, 0, 0, 1]).all()


def test_a_plane_hangs_on_what_stands_still_under_mujoco_and_moves_with_a_body_under_xpbd() -> None:
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    led = builder.add_body(mass=1.0, inertia=round_inertia(1.0), lock_inertia=True, is_kinematic=True)
    builder.add_shape_plane(None, xform=at(), width=0.0, length=0.0, body=led, cfg=surface())
    ball = builder.add_body(xform=at(z=0.1), mass=1.0, inertia=round_inertia(0.004), lock_inertia=True)
    builder.add_shape_sphere(ball, radius=0.1, cfg=surface())
    model = builder.finalize(device="cpu")
    for whose in (True, False):
        with pytest.raises(ValueError, match="Planes can only be attached to static bodies"):
            mujoco(model, use_mujoco_contacts=whose)
    solver, pipeline, states = newton.solvers.SolverXPBD(model), newton.CollisionPipeline(model), [model.state(), model.state()]
    contacts = pipeline.contacts()
    for step in range(240):
        states[0].body_q.numpy()[led, 2], states[0].body_qd.numpy()[led, 2] = 0.5 * step / 240, 0.5
        pipeline.collide(states[0], contacts)
        solver.step(states[0], states[1], model.control(), contacts, 1 / 240)
        states.reverse()
    assert float(states[0].body_q.numpy()[ball, 2]) == pytest.approx(0.6, abs=0.01)


def test_no_solver_moves_a_kinematic_body_by_its_velocity() -> None:
    """It keeps the velocity that it is told and stays where it is: who leads it has to put it there."""
    for make in (mujoco, newton.solvers.SolverXPBD):
        builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
        led = builder.add_body(mass=1.0, inertia=round_inertia(1.0), lock_inertia=True, is_kinematic=True)
        builder.joint_qd[0], builder.body_qd[led] = 0.5, wp.spatial_vector(0.5, 0.0, 0.0, 0.0, 0.0, 0.0)
        model = builder.finalize(device="cpu")
        pose, rate = run(model, make(model), 480, 1 / 240)
        assert (pose[0, :3] == 0.0).all()
        assert rate[0, 0] == 0.5
