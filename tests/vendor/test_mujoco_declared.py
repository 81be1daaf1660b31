"""What is declared that MuJoCo lacks or refuses, tried as its advocate would: by every word of its documentation that might."""

import math
from typing import Any

import numpy as np
import pytest

from tests.vendor.mujoco_world import G, load, mujoco

pytestmark = pytest.mark.mujoco

DT = 1 / 240
OUTLINE = [(-0.3, -0.2), (-0.2, -0.2), (-0.2, 0.1), (0.2, 0.1), (0.2, -0.2), (0.3, -0.2), (0.3, 0.2), (-0.3, 0.2)]
"""(x, z) of a bridge: two legs of 0.3 m below a deck of 0.1 m."""


def bridge() -> tuple[Any, Any]:
    """A bridge 0.3 m deep as a closed mesh that is not convex: vertices (16, 3) [m] and triangles (28, 3)."""
    count = len(OUTLINE)
    corners = [(x, y, z) for y in (-0.15, 0.15) for x, z in OUTLINE]
    face = [(0, 1, 2), (0, 2, 7), (2, 3, 6), (2, 6, 7), (3, 4, 5), (3, 5, 6)]
    faces = face + [(a + count, c + count, b + count) for a, b, c in face]
    for i in range(count):
        j = (i + 1) % count
        faces += [(i, i + count, j + count), (i, j + count, j)]
    return np.array(corners), np.array(faces)


def stand(how: str, depth: int = 0) -> float:
    """How high [m] a bridge stands over a box of 0.6 m between its legs. Args: how: 'hull', 'sdf' or 'flex'."""
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = 1e-3, (0.0, 0.0, -G)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 0.1])
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.05, 0.4, 0.3], pos=[0, 0, 0.3])
    body = spec.worldbody.add_body(name="bridge", pos=[0, 0, 0.62])
    body.add_freejoint()
    body.explicitinertial, body.mass, body.inertia = True, 1.0, [0.02, 0.03, 0.03]
    body.ipos, body.iquat = [0, 0, 0], [1, 0, 0, 0]
    vertices, faces = bridge()
    if how == "flex":
        flex = spec.add_flex(name="bridge", dim=2)
        flex.vert, flex.elem, flex.vertbody, flex.radius = vertices.ravel(), faces.ravel(), ["bridge"], 1e-4
    else:
        mesh = spec.add_mesh(name="bridge", uservert=vertices.ravel(), userface=faces.ravel())
        mesh.needsdf = how == "sdf"
        if depth:
            mesh.octree_maxdepth = depth
        kind = mujoco.mjtGeom.mjGEOM_SDF if how == "sdf" else mujoco.mjtGeom.mjGEOM_MESH
        body.add_geom(type=kind, meshname="bridge")
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 2000)
    return float(data.qpos[2])


def test_a_mesh_collides_as_its_hull() -> None:
    """By the legs' ends, at the top of the box: 0.6 + 0.2 m, less what a contact gives way by."""
    assert stand("hull") == pytest.approx(0.8, abs=2e-4)


@pytest.mark.parametrize("depth", [0, 4, 8])
def test_a_signed_distance_field_of_the_mesh_collides_as_the_mesh_within_a_tenth_of_a_millimetre(depth: int) -> None:
    assert stand("sdf", depth) == pytest.approx(0.5, abs=2e-4)


def test_a_rigid_flex_of_its_faces_has_no_inside_and_falls_over_the_box() -> None:
    """Its faces are as thin as told: the box is through the deck within a step of 1.5 mm, and the legs stand on the plane."""
    assert stand("flex") == pytest.approx(0.2, abs=2e-4)


@pytest.mark.parametrize("wide", ["0 0", "0.1 0.1"])
def test_a_range_of_no_width_is_refused_and_a_narrow_one_is_not(wide: str) -> None:
    slide = '<body><joint type="slide" limited="true" range="{}"/><geom size="0.1"/></body>'
    with pytest.raises(ValueError, match="should be smaller"):
        load(slide.format(wide), DT)
    load(slide.format("0 1e-9"), DT)


def touching(contype: int) -> int:
    """Contacts of a ball on a plane, both of this mask alone."""
    mask = f'contype="{contype}" conaffinity="{contype}"'
    model, data = load(
        f'<geom type="plane" size="1 1 1" {mask}/><body pos="0 0 0.0999"><freejoint/><geom size="0.1" {mask}/></body>', DT
    )
    mujoco.mj_step(model, data)
    return int(data.ncon)


def test_a_mask_has_32_bits_of_which_the_last_is_the_sign_and_none_beyond() -> None:
    assert [touching(1 << bit) for bit in (0, 30)] == [1, 1]
    assert touching(-(1 << 31)) == 1
    with pytest.raises(ValueError, match="too large"):
        touching(1 << 32)


def test_a_plane_is_refused_on_a_body_that_moves_and_taken_on_a_mocap_body() -> None:
    plane = '<geom type="plane" size="1 1 1"/>'
    for joint in ("<freejoint/>", '<joint type="slide"/>'):
        with pytest.raises(ValueError, match="plane only allowed in static bodies"):
            load(f'<body>{joint}<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{plane}</body>', DT)
    load(f'<body mocap="true">{plane}</body>', DT)


def test_a_coordinate_above_1e10_is_reset() -> None:
    model, data = load('<body><freejoint/><geom size="0.1"/></body>', DT, gravity=0.0)
    for place, kept in ((9e9, 9e9), (1.1e10, 0.0)):
        mujoco.mj_resetData(model, data)
        data.qpos[0] = place
        mujoco.mj_step(model, data)
        assert data.qpos[0] == kept


@pytest.mark.parametrize("word", ["static", "kinetic", "velrange", "vellimit", "maxvel", "restitution", "rotorlimit"])
def test_no_joint_geom_pair_or_option_has_such_a_word(word: str) -> None:
    kinds = (mujoco.MjsJoint, mujoco.MjsGeom, mujoco.MjsPair, mujoco.MjsBody, mujoco.MjsEquality, mujoco.MjOption)
    assert not [name for kind in kinds for name in dir(kind) if word in name.lower() and name != "fuse_static"]


@pytest.mark.parametrize(("cone", "share"), [("pyramidal", 0.912), ("elliptic", 0.993)])
def test_rolling_friction_is_a_tenth_too_weak_on_a_pyramid(cone: str, share: float) -> None:
    """A ball that rolls at 1 m/s against a lever of 1 cm: c g/(1.4 r). A pyramid shares one normal force among its edges."""
    law = 'condim="6" friction="1 0.005 0.01"'
    ball = f'<geom type="plane" size="9 9 9" {law}/><body pos="0 0 0.1"><freejoint/><geom size="0.1" mass="1" {law}/></body>'
    model, data = load(ball, DT, option=f'cone="{cone}"')
    mujoco.mj_step(model, data, 50)
    data.qvel[:] = (1, 0, 0, 0, 10, 0)
    mujoco.mj_step(model, data, 120)
    assert (1 - data.qvel[0]) / 0.5 / (0.01 * G / 0.14) == pytest.approx(share, abs=2e-3)


@pytest.mark.parametrize(("constant", "off"), [(0.02, 6.29e-3), (2 * DT, 7.45e-4)])
@pytest.mark.parametrize("kind", ["limit", "equality"])
def test_a_rod_gives_way_by_its_time_constant(kind: str, constant: float, off: float) -> None:
    """A ball falls from level on a rod of 1 m as a tendon; at two steps, the least that is documented, by a ninth."""
    sites = '<site site="a"/><site site="b"/></spatial></tendon>'
    ends = '<site name="a"/><body pos="1 0 0"><freejoint/><geom size="0.1" mass="1"/><site name="b"/></body>'
    if kind == "limit":
        more = f'<tendon><spatial name="rod" limited="true" range="0 1" solreflimit="{constant} 1">{sites}'
    else:
        more = f'<tendon><spatial name="rod">{sites}<equality><tendon tendon1="rod" solref="{constant} 1"/></equality>'
    model, data = load(ends, DT, more=more)
    worst = 0.0
    for _ in range(480):
        mujoco.mj_step(model, data)
        worst = max(worst, abs(float(data.ten_length[0]) - 1))
    assert worst == pytest.approx(off, rel=0.02)


@pytest.mark.parametrize(("constant", "rate"), [(0.02, 1.056e-3), (2 * DT, 4.40e-4)])
def test_dry_friction_lets_what_it_holds_creep_by_its_time_constant(constant: float, rate: float) -> None:
    """2 kg under 2 N against a bound of 3 N."""
    joint = f'<joint type="slide" axis="0 0 1" frictionloss="3" solreffriction="{constant} 1"/>'
    slide = f'<body>{joint}<geom size="0.1" mass="2"/></body>'
    model, data = load(slide, DT, gravity=1.0)
    mujoco.mj_step(model, data, 480)
    assert -float(data.qvel[0]) == pytest.approx(rate, rel=0.02)


@pytest.mark.parametrize(("constant", "apart"), [(0.02, 1.567e-2), (2 * DT, 8.2e-3)])
def test_coupled_slides_part_at_first_by_their_time_constant(constant: float, apart: float) -> None:
    """2 kg and 1 kg over a pulley, from rest."""
    slides = "".join(
        f'<body pos="{x} 0 0"><joint name="j{x}" type="slide" axis="0 0 1"/><geom size="0.1" mass="{m}"/></body>'
        for x, m in ((0, 2), (1, 1))
    )
    tie = f'<equality><joint joint1="j1" joint2="j0" polycoef="0 -1 0 0 0" solref="{constant} 1"/></equality>'
    model, data = load(slides, DT, more=tie)
    worst = 0.0
    for _ in range(240):
        mujoco.mj_step(model, data)
        worst = max(worst, abs(float(data.qvel.sum())))
    assert worst == pytest.approx(apart, rel=0.03)


LEVERS = (0.4, 0.5, 2 / 3, 1.0)
"""I/(m r^2) of a solid sphere, a cylinder, a shell and a hoop."""


def thrown(dt: float, constant: float, ratio: float, **option: str) -> float:
    """The greatest error [m/s], seen 60 times a second, of balls of 0.1 m thrown at 5 m/s without spin on mu 0.3 (Coulomb)."""
    law = f'condim="3" friction="0.3 0 0" solref="{constant!r} {ratio}"'
    if ratio != 1:
        law += ' solimp="0.999 0.999 0.001"'
    world = f'<geom type="plane" size="0 0 1" {law}/>'
    for k, lever in enumerate(LEVERS):
        moment = lever * 0.01
        world += (
            f'<body pos="0 {k} 0.1"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="{moment} {moment} {moment}"/>'
            f'<geom size="0.1" {law} contype="2" conaffinity="1"/></body>'
        )
    model, data = load(world, dt, option=" ".join(f'{name}="{value}"' for name, value in option.items()))
    data.qvel[::6] = 5.0
    every, worst = round(4 * DT / dt), 0.0
    for n in range(4, 481, 4):
        mujoco.mj_step(model, data, every)
        for k, lever in enumerate(LEVERS):
            truth = max(5.0 - 0.3 * G * n * DT, 5.0 / (1 + lever))
            slow = np.array([data.qvel[6 * k] - truth, data.qvel[6 * k + 1], data.qvel[6 * k + 2]])
            worst = max(worst, float(np.linalg.norm(slow)))
    return worst


DUE = 2 * 0.3 * G * DT
"""A first step without a contact, and the step in which slip ends: mu g dt each [m/s]."""


def test_by_default_balls_thrown_without_spin_hop_and_are_rubbed_late() -> None:
    assert thrown(DT, 0.02, 1.0) == pytest.approx(0.5703, rel=0.01)


def test_on_an_elliptic_cone_they_do_as_well() -> None:
    assert thrown(DT, 0.02, 1.2, cone="elliptic", impratio="10", tolerance="1e-10") == pytest.approx(0.5788, rel=0.01)


@pytest.mark.parametrize(
    ("dt", "constant", "option"),
    [
        (DT, 0.02, {"noslip_iterations": "20", "cone": "elliptic"}),
        (DT, 0.02, {"impratio": "100", "cone": "elliptic"}),
        (DT, 0.02, {"integrator": "RK4"}),
        (DT, 0.1, {"cone": "elliptic"}),
        (DT / 8, 0.02, {"cone": "elliptic"}),
        (DT / 8, 0.1, {"cone": "elliptic"}),
    ],
)
def test_no_setting_that_the_documentation_has_for_slip_brings_them_within_two_steps_of_friction(
    dt: float, constant: float, option: dict[str, str]
) -> None:
    assert thrown(dt, constant, 1.2, **option) > 2 * DUE


ARMS = {"a": (1.0, 1.0), "b": (2.0, 2.0), "c": (3.0, -1.0)}
"""Mass [kg] and arm on a tendon of three slides side by side."""


def tied(extra: str = "", joint: str = "c") -> mujoco.MjModel:
    """The slides on one fixed tendon of 10 N/m that is 0.1 m too short. Args: joint: the name of the last joint on it."""
    bodies = "".join(
        f'<body name="{name}" pos="0 {k} 0"><joint name="{name}" type="slide" axis="1 0 0"/>'
        f'<geom size=".1" mass="{mass}"/></body>'
        for k, (name, (mass, _)) in enumerate(ARMS.items())
    )
    arms = "".join(f'<joint joint="{joint if n == "c" else n}" coef="{arm}"/>' for n, (_, arm) in ARMS.items())
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 0" timestep="0.001" integrator="RK4"/><worldbody>{bodies}</worldbody>{extra}'
        f'<tendon><fixed springlength="0.1" stiffness="10">{arms}</fixed></tendon></mujoco>'
    )


def test_a_fixed_tendon_pulls_each_joint_by_its_arm() -> None:
    """l = sum of arm x; l'' = -k W (l - rest) with W the sum of arm^2/m, and x = arm/m l/W."""
    model = tied()
    data = mujoco.MjData(model)
    for _ in range(500):
        mujoco.mj_step(model, data)
    mass, arm = np.array(list(ARMS.values())).T
    lightness = float(arm @ (arm / mass))
    length = 0.1 * (1 - math.cos(math.sqrt(10 * lightness) * 0.5))
    assert data.qpos == pytest.approx(arm / mass * length / lightness, abs=1e-9)


def test_what_closes_a_loop_has_no_coordinate_that_a_tendon_could_hold() -> None:
    loop = '<equality><connect name="loop" body1="a" body2="b" anchor="0 0 0"/></equality>'
    tied(loop)
    with pytest.raises(ValueError, match="joint 'loop' not found"):
        tied(loop, joint="loop")


@pytest.mark.parametrize(
    ("compiler", "between", "builds"),
    [("", True, False), ("", False, True), ('<compiler boundmass="1e-9" boundinertia="1e-9"/>', True, True)],
)
def test_a_body_between_two_joints_needs_a_mass_and_two_joints_of_one_body_do_not(
    compiler: str, between: bool, builds: bool
) -> None:
    """A compiler that is told a least mass gives it one."""
    apart = ("<body>", "</body>") if between else ("", "")
    text = (
        f'<mujoco>{compiler}<worldbody><body><joint axis="1 0 0"/>{apart[0]}<joint axis="0 1 0"/><geom size=".1"/>{apart[1]}'
        "</body></worldbody></mujoco>"
    )
    if builds:
        assert mujoco.MjModel.from_xml_string(text).nv == 2
    else:
        with pytest.raises(ValueError, match="must be larger than mjMINVAL"):
            mujoco.MjModel.from_xml_string(text)


def test_loops_are_closed_by_points_welds_and_ties_of_coordinates_and_by_no_hinge_or_slide() -> None:
    kinds = {name.removeprefix("mjEQ_") for name in mujoco.mjtEq.__members__}
    assert {"CONNECT", "WELD", "JOINT", "TENDON"} <= kinds
    assert not [kind for kind in kinds if "SLIDE" in kind or "HINGE" in kind or "PRISMATIC" in kind or "REVOLUTE" in kind]
