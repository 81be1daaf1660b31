"""What an MJCF says, as MuJoCo's own compiler understands it: what is carried over, what is said, what is refused by name."""

import math
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.intake.error import RobotError
from plumbline.harness.scene import (
    Ball,
    Body,
    ConvexHull,
    Coupling,
    Ellipsoid,
    Prismatic,
    Scene,
    Surface,
    ellipsoid_inertia,
)
from plumbline.harness.scene.importers.companion import Companion, JointWish, Massless, Units
from tests.robot_files import BALL, imported, joint, mjcf, row

pytest.importorskip("mujoco")
pytestmark = pytest.mark.usefixtures("mjcf_here")


def law(scene: Scene, a: str, b: str) -> Surface:
    return scene.surface(scene.body(a), scene.body(b))


def test_several_joints_of_one_body_are_a_chain_without_masses_between_or_with_stated_ones(tmp_path: Path) -> None:
    text = mjcf(
        f'<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide"/>'
        f'<joint name="turn" axis="0 1 0" pos="0 0 .2"/>{BALL}'
    )
    names = [("x", "world", "arm.x"), ("z", "arm.x", "arm.z"), ("turn", "arm.z", "arm")]
    bare = imported(tmp_path, text)
    assert [(j.name, j.parent, j.child) for j in bare.scene.joints] == names
    assert [body.mass for body in bare.scene.bodies if body.name in ("arm.x", "arm.z")] == [0.0, 0.0]
    got = imported(tmp_path, text, Companion(massless=Massless(mass=1e-9)))
    assert [(j.name, j.parent, j.child) for j in got.scene.joints] == names
    assert got.scene.joints[2].anchor_W == (0, 0, 1.2)  # type: ignore[union-attr]
    assert row(got, "link without mass").count == 2


def test_armature_is_carried_or_dropped_with_the_factor_by_which_joints_turn_more_readily(tmp_path: Path) -> None:
    text = mjcf('<joint name="j" axis="0 1 0" armature="0.5"/><geom size=".1" mass="1"/>')
    kept = imported(tmp_path, text)
    assert (joint(kept).armature, row(kept, "armature").outcome) == (0.5, "exact")
    got = imported(tmp_path, text, drop=frozenset(("armature",)))
    assert joint(got).armature is None
    lost = row(got, "armature")
    # A ball of 1 kg and 0.1 m has 2/5 m r^2 = 0.004 kg m2 about its centre.
    assert (lost.outcome, lost.value) == ("left_out", pytest.approx(1 + 0.5 / 0.004))


def test_a_pattern_drops_what_the_joints_of_that_name_have_and_leaves_the_others(tmp_path: Path) -> None:
    second = f'</body><body name="hand" pos="1 0 0"><joint name="wrist" axis="0 1 0" armature="0.2"/>{BALL}'
    root = '<joint name="root" type="free" armature="0.3"/>'
    text = mjcf(f'<joint name="elbow" axis="0 1 0" armature="0.5" frictionloss="2"/>{BALL}{second}')
    whole, got = imported(tmp_path, text), imported(tmp_path, text, drop=frozenset(("armature@elb*", "friction_loss@wrist")))
    laws = {joint.name: (joint.armature, joint.friction_loss) for joint in got.scene.joints}  # type: ignore[union-attr]
    assert laws == {"elbow": (None, 2.0), "wrist": (0.2, None)}
    rows = {(r.outcome, r.name): r for r in got.fidelity if r.element in ("armature", "friction loss")}
    assert set(rows) == {("left_out", "'elbow'"), ("exact", "'wrist'"), ("exact", "'elbow'")}
    assert (got.dropped, got.undropped) == (("armature@elb*", "friction_loss@wrist"), whole.scene)
    floating = mjcf(f"{root}{BALL}{second}")
    with pytest.raises(RobotError, match=r"joint 'root': armature of up to 0\.3"):
        imported(tmp_path, floating, drop=frozenset(("armature@wrist",)))
    assert joint(imported(tmp_path, floating, drop=frozenset(("armature@root*",)))).armature == 0.2


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("armature@knee*", r"'armature@knee\*': no joint is called so, expected some of 'elbow'"),
        ("plugin@elbow", "'plugin@elbow', expected KIND@PATTERN, KIND being one of armature, "),
        ("armature@", "'armature@', expected KIND@PATTERN"),
        ("armour@elbow", "'armour', expected one of actuator.*did you mean armature"),
    ],
)
def test_a_pattern_that_meets_no_joint_or_no_kind_of_joints_is_refused(tmp_path: Path, text: str, why: str) -> None:
    with pytest.raises(RobotError, match=why):
        imported(tmp_path, mjcf(f'<joint name="elbow" axis="0 1 0" armature="0.5"/>{BALL}'), drop=frozenset((text,)))


def test_a_linear_equality_of_two_joints_is_a_coupling_and_another_is_refused(tmp_path: Path) -> None:
    bodies = f'<joint name="x" axis="0 1 0" ref="0.3"/>{BALL}</body><body name="slider">'
    bodies += f'<joint name="y" type="slide" ref="0.1"/>{BALL}'
    equality = '<compiler angle="radian"/><equality><joint joint1="x" joint2="y" polycoef="0 4 0 0 0"/></equality>'
    got = imported(tmp_path, mjcf(bodies, equality))
    hinge = next(one for one in got.scene.joints if one.name == "x")
    assert hinge.coupling == Coupling(joint="y", ratio=4.0, offset=0.3 - 4.0 * 0.1)  # type: ignore[union-attr]
    assert (row(got, "equality").outcome, row(got, "equality").becomes) == ("approximated", "coupling")
    for kind in ("mimic", "equality"):
        free = imported(tmp_path, mjcf(bodies, equality), drop=frozenset((kind,)))
        assert all(one.coupling is None for one in free.scene.joints)  # type: ignore[union-attr]
        assert any(one.consequence.startswith("mimic was dropped by the user") for one in free.fidelity)
    shifted = imported(tmp_path, mjcf(bodies, equality.replace('"0 4', '"0.2 4')))
    assert row(shifted, "start").value == pytest.approx(0.2)
    for terms in ("0 4 1 0 0", "0 0 0 0 0"):
        with pytest.raises(RobotError, match="--drop equality"):
            imported(tmp_path, mjcf(bodies, equality.replace("0 4 0 0 0", terms)))


def test_angles_are_degrees_unless_the_file_says_radians(tmp_path: Path) -> None:
    body = f'<joint range="-90 45" limited="true"/>{BALL}'
    assert joint(imported(tmp_path, mjcf(body))).limits.upper == pytest.approx(np.pi / 4)  # type: ignore[union-attr]
    radians = mjcf(body.replace("-90 45", "-1 0.5"), '<compiler angle="radian"/>')
    assert joint(imported(tmp_path, radians)).limits.upper == 0.5  # type: ignore[union-attr]


def test_the_order_of_euler_angles_is_the_files(tmp_path: Path) -> None:
    from scipy.spatial.transform import Rotation

    for order in ("xyz", "ZYX"):
        got = imported(
            tmp_path, mjcf(f"<joint/>{BALL}", f'<compiler eulerseq="{order}"/>').replace("pos=", 'euler="20 30 40" pos=')
        )
        # Lower case turns about axes that move along, upper case about fixed ones: the other way round in SciPy.
        truth = Rotation.from_euler(order.swapcase(), [20, 30, 40], degrees=True)
        q = got.scene.body("arm").q_WB
        assert abs(np.dot(q, truth.as_quat(scalar_first=True))) == pytest.approx(1, abs=1e-12)


def test_inertia_from_geoms_overrides_a_given_one_where_the_file_says_so(tmp_path: Path) -> None:
    given = '<inertial pos="0 0 0" mass="7" diaginertia="1 1 1"/>'
    decoration = '<geom size=".1" contype="0" conaffinity="0" pos="1 0 0" mass="1"/>'
    body = f'<joint/>{given}<geom size=".1" mass="1"/>{decoration}'
    assert imported(tmp_path, mjcf(body)).scene.body("arm").mass == 7
    own = imported(tmp_path, mjcf(body, '<compiler inertiafromgeom="true"/>')).scene.body("arm")
    # The decoration counts too: two balls of 1 kg, a metre apart.
    assert own.mass == pytest.approx(2)
    assert own.p_WB == pytest.approx((0.5, 0, 1))
    assert np.diag(own.inertia) == pytest.approx([0.008, 0.508, 0.508])
    assert imported(tmp_path, mjcf(body, '<compiler settotalmass="21"/>')).scene.body("arm").mass == pytest.approx(21)


def test_nested_defaults_and_child_classes_are_resolved_to_the_last(tmp_path: Path) -> None:
    beside = (
        '<default><joint damping="1"/><default class="a"><joint damping="2" stiffness="5"/>'
        '<default class="b"><joint stiffness="9"/></default></default></default>'
    )
    got = imported(tmp_path, mjcf(f"<joint/>{BALL}", beside).replace('name="arm"', 'name="arm" childclass="b"'))
    assert joint(got).spring is not None
    assert (joint(got).spring.stiffness, joint(got).spring.damping) == (9, 2)  # type: ignore[union-attr]


def test_reference_and_spring_reference_shift_the_coordinate(tmp_path: Path) -> None:
    body = f'<joint name="j" type="slide" axis="1 0 0" ref=".3" springref=".1" stiffness="4" range="0 1" limited="true"/>{BALL}'
    got = joint(imported(tmp_path, mjcf(body)))
    assert isinstance(got, Prismatic)
    assert (got.position, got.spring.rest, got.limits.lower) == (0.3, 0.1, 0)  # type: ignore[union-attr]
    moved = imported(tmp_path, mjcf(body), Companion(joints={"j": JointWish(position=0.5)})).scene
    assert moved.body("arm").p_WB == pytest.approx((0.2, 0, 1))


@pytest.mark.parametrize(
    ("option", "gravity"),
    [
        ('<option gravity="1 2 -3"/>', (1, 2, -3)),
        ('<option gravity="0 0 0"/>', (0, 0, 0)),
        ('<option gravity="0 0 -9"><flag gravity="disable"/></option>', (0, 0, 0)),
    ],
)
def test_gravity_is_the_files_tilted_or_none(tmp_path: Path, option: str, gravity: tuple[float, ...]) -> None:
    assert imported(tmp_path, mjcf(f"<joint/>{BALL}", option)).scene.gravity == gravity


def test_centimetres_and_grams_are_suspected_and_turned_into_si_units_where_told(tmp_path: Path) -> None:
    body = '<joint name="j" axis="0 1 0" damping="3" pos="0 0 5" range="-90 90" limited="true"/><geom size="10" mass="2000"/>'
    text = mjcf(body, '<option gravity="0 0 -981"/>').replace('pos="0 0 1"', 'pos="0 0 100"')
    assert row(imported(tmp_path, text), "gravity").value == 981
    got = imported(tmp_path, text, Companion(units=Units(length=0.01, mass=0.001)))
    body_of = got.scene.body("arm")
    assert got.scene.gravity == pytest.approx((0, 0, -9.81))
    assert (body_of.mass, body_of.p_WB[2]) == pytest.approx((2, 1))
    assert body_of.inertia[0][0] == pytest.approx(0.4 * 2 * 0.01)
    assert body_of.collision[0].shape.radius == pytest.approx(0.1)  # type: ignore[union-attr]
    # 3 g cm2/s are 3e-7 kg m2/s; an angle stays as it is.
    assert joint(got).spring.damping == pytest.approx(3e-7)  # type: ignore[union-attr]
    assert joint(got).limits.upper == pytest.approx(np.pi / 2)  # type: ignore[union-attr]
    assert joint(got).anchor_W == pytest.approx((0, 0, 1.05))


def test_dry_friction_stands_beside_damping_and_a_ball_joint_can_be_damped(tmp_path: Path) -> None:
    dry = joint(imported(tmp_path, mjcf(f'<joint damping="1" frictionloss="2"/>{BALL}')))
    assert (dry.friction_loss, dry.spring.damping) == (2, 1)  # type: ignore[union-attr]
    with pytest.raises(RobotError, match=r"joint 'b': friction loss of up to 2 N m or N: .*--drop friction_loss"):
        imported(tmp_path, mjcf(f'<joint name="b" type="ball" frictionloss="2"/>{BALL}'))
    text = mjcf(f'<joint name="b" type="ball" damping="1"/>{BALL}')
    with pytest.raises(RobotError, match=r"joint 'b': ball spring damping of a ball joint.*--drop ball_spring"):
        imported(tmp_path, text)
    (found,) = imported(tmp_path, text, drop=frozenset(("ball_spring",))).scene.joints
    assert isinstance(found, Ball)


def test_bit_masks_exclusions_and_friction_per_geom_are_split_into_materials(tmp_path: Path) -> None:
    world = '<geom name="floor" type="plane" size="1 1 1" contype="1" conaffinity="1" friction=".3"/>'
    text = mjcf(
        '<freejoint/><geom size=".1" contype="1" conaffinity="0" friction=".9 .01 .001" condim="4"/></body>'
        '<body name="b" pos="1 0 0"><freejoint/><geom size=".1" contype="2" conaffinity="2" friction=".2"/></body>'
        '<body name="c" pos="2 0 0"><freejoint/><geom size=".1" contype="3" conaffinity="3" friction=".5"/></body>'
        '<body name="d" pos="3 0 0"><freejoint/><geom size=".1" contype="3" conaffinity="3" friction=".5"/>',
        '<contact><exclude body1="c" body2="d"/></contact>',
        world,
    )
    scene = imported(tmp_path, text).scene

    def touch(a: str, b: str) -> bool:
        return scene.collides(scene.body(a), scene.body(b))

    # a touches what takes type 1; b, which has bit 2 alone, touches c and d and not the floor; c and d are excluded.
    names = {"a": "arm", "b": "b", "c": "c", "d": "d", "w": "world_2"}
    pairs = {"ab": False, "ac": True, "bc": True, "cd": False, "bd": True, "aw": True, "bw": False, "cw": True}
    assert {pair: touch(names[pair[0]], names[pair[1]]) for pair in pairs} == pairs
    floor = law(scene, "arm", "world_2")
    assert (floor.kinetic_friction, floor.torsional_friction, floor.rolling_friction) == (0.9, 0.01, 0)
    assert law(scene, "c", "world_2").kinetic_friction == 0.5
    assert law(scene, "c", "b").kinetic_friction == 0.5


def test_shapes_of_one_body_that_rub_differently_are_said(tmp_path: Path) -> None:
    text = mjcf(
        '<freejoint/><geom size=".1" friction=".9"/><geom size=".1" pos="1 0 0" friction=".1"/>',
        "",
        '<geom type="plane" size="1 1 1" friction=".05"/>',
    )
    got = imported(tmp_path, text)
    assert row(got, "contact").value == pytest.approx(0.8)
    assert law(got.scene, "arm", "world_2").kinetic_friction == 0.9


def test_margins_and_softness_are_said(tmp_path: Path) -> None:
    got = imported(tmp_path, mjcf('<freejoint/><geom size=".1" margin=".02"/>'))
    assert row(got, "margin, gap").value == 0.02
    assert row(got, "solref, solimp").outcome == "left_out"


def test_an_ellipsoid_is_one_and_weighs_as_the_vendor_says(tmp_path: Path) -> None:
    got = imported(tmp_path, mjcf('<freejoint/><geom type="ellipsoid" size=".1 .2 .3" density="500"/>'))
    body = got.scene.body("arm")
    assert body.collision[0].shape == Ellipsoid(semi_axes=(0.1, 0.2, 0.3))
    mass = 500 * 4 / 3 * math.pi * 0.1 * 0.2 * 0.3
    assert body.mass == pytest.approx(mass)
    assert np.array(body.inertia) == pytest.approx(np.array(ellipsoid_inertia(mass, (0.1, 0.2, 0.3))))
    assert (row(got, "geom ellipsoid").outcome, row(got, "geom ellipsoid").becomes) == ("exact", "ellipsoid")


def test_an_ellipsoid_becomes_a_polyhedron_where_the_companion_asks_for_it(tmp_path: Path) -> None:
    asked = Companion(ellipsoids="polyhedra")
    got = imported(tmp_path, mjcf('<freejoint/><geom type="ellipsoid" size=".1 .2 .3"/>'), asked)
    shape = got.scene.body("arm").collision[0].shape
    assert isinstance(shape, ConvexHull)
    corners = np.array(shape.vertices) / [0.1, 0.2, 0.3]
    assert np.linalg.norm(corners, axis=1) == pytest.approx(np.ones(len(corners)))
    assert 0 < (row(got, "geom ellipsoid").value or 0) < 0.03 * 0.3


@pytest.mark.parametrize(
    ("beside", "kind"),
    [
        ('<option density="1.2"/>', "fluid"),
        ('<extension><plugin plugin="mujoco.pid"/></extension>', "plugin"),
        ('<deformable><skin name="s"/></deformable>', "flex"),
    ],
)
def test_what_a_scene_has_no_word_for_is_refused_by_name_unless_dropped(tmp_path: Path, beside: str, kind: str) -> None:
    with pytest.raises(RobotError, match=f"--drop {kind} leaves it out"):
        imported(tmp_path, mjcf(f"<joint/>{BALL}", beside))
    assert imported(tmp_path, mjcf(f"<joint/>{BALL}", beside), drop=frozenset((kind,))).dropped == (kind,)


def test_a_height_field_that_is_touched_is_refused_or_dropped(tmp_path: Path) -> None:
    beside = '<asset><hfield name="h" nrow="2" ncol="2" size="1 1 1 1" elevation="0 1 0 1"/></asset>'
    text = mjcf(f"<joint/>{BALL}", beside, '<geom type="hfield" hfield="h"/>')
    with pytest.raises(RobotError, match="--drop height_field"):
        imported(tmp_path, text)
    assert imported(tmp_path, text, drop=frozenset(("height_field",))).scene.body("arm").mass > 0
    with pytest.raises(RobotError, match="heights, expected at most"):
        imported(tmp_path, text.replace('nrow="2"', 'nrow="1e12"'))


def test_gravity_compensation_is_refused_or_dropped(tmp_path: Path) -> None:
    text = mjcf(f"<joint/>{BALL}").replace('name="arm"', 'name="arm" gravcomp="1"')
    with pytest.raises(RobotError, match=r"body 'arm': gravity compensation.*--drop gravity_compensation"):
        imported(tmp_path, text)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (f'<joint name="j" range="1 -1" limited="true"/>{BALL}', "<joint> 'j': range is .* expected lower <= upper|range"),
        (f'<joint name="j" damping="-1"/>{BALL}', "<joint> 'j': damping is -1, expected 0 or more"),
        (f'<joint name="j" armature="-1"/>{BALL}', "armature is -1|armature"),
        (f'<joint name="j" stiffness="-1"/>{BALL}', "stiffness is negative"),
        ('<joint/><geom size=".1" friction="-1 0 0"/>', "friction is negative|friction"),
        (f'<joint name="j"/><joint name="j"/>{BALL}', "repeated name 'j'"),
        ("<joint/>", "mass and inertia of moving bodies must be larger"),
        (f'<joint axis="0 0 0"/>{BALL}', "axis|zero"),
    ],
)
def test_what_no_robot_has_is_refused_by_name(tmp_path: Path, body: str, said: str) -> None:
    with pytest.raises(RobotError, match=said):
        imported(tmp_path, mjcf(body))


def test_bodies_and_joints_without_names_get_some_and_world_is_taken(tmp_path: Path) -> None:
    text = mjcf(f"<joint/>{BALL}<body><joint/>{BALL}</body>").replace('name="arm"', "")
    scene = imported(tmp_path, text).scene
    assert [b.name for b in scene.bodies] == ["body_1", "body_2"]
    assert [j.name for j in scene.joints] == ["joint_0", "joint_1"]


def test_a_keyframe_is_where_it_starts(tmp_path: Path) -> None:
    text = mjcf(f"<freejoint/>{BALL}", '<keyframe><key name="up" qpos="1 2 3 0 1 0 0"/></keyframe>')
    body: Body = imported(tmp_path, text, Companion(keyframe="up")).scene.body("arm")
    assert (body.p_WB, body.q_WB) == ((1, 2, 3), (0, 1, 0, 0))
    with pytest.raises(RobotError, match="keyframe 'down' is not in the file, expected one of 'up'"):
        imported(tmp_path, text, Companion(keyframe="down"))


def test_a_link_on_the_world_touches_what_stands_in_it_as_mujoco_has_it(tmp_path: Path) -> None:
    scene = imported(tmp_path, mjcf(f"<joint/>{BALL}", "", '<geom type="box" size="1 1 1"/>')).scene
    assert scene.joints[0].parent == "world"
    assert scene.collides(scene.body("arm"), scene.body("world_2"))


def test_shapes_that_touch_nothing_are_drawn(tmp_path: Path) -> None:
    body = imported(tmp_path, mjcf('<joint/><geom size=".1" contype="0" conaffinity="0"/>')).scene.body("arm")
    assert not body.collision
    assert body.visual is not None
    assert body.visual[0].shape.type == "sphere"


def test_velocities_of_free_and_ball_joints_in_a_keyframe_are_mujocos(tmp_path: Path) -> None:
    """Every body's velocities at the start, by MuJoCo's own forward kinematics of the same keyframe, at its centre of mass."""
    import mujoco

    inner = f'<body name="tip" pos=".3 0 .1"><joint type="ball" pos="0 0 .05"/>{BALL}</body>'
    key = '<keyframe><key name="thrown" qpos="1 2 3 .5 .5 .5 .5 .8 .6 0 0" qvel=".1 .2 .3 1 2 3 -1 .5 2"/></keyframe>'
    text = mjcf(f'<freejoint/><geom size=".1" pos=".1 0 0" mass="2"/>{inner}', key)
    scene = imported(tmp_path, text, Companion(keyframe="thrown")).scene
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    for name in ("arm", "tip"):
        told = np.zeros(6)
        place = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, place, told, 0)
        body = scene.body(name)
        assert np.array(body.w_WB) == pytest.approx(told[:3], abs=1e-12)
        assert np.array(body.v_WB) == pytest.approx(told[3:], abs=1e-12)
