"""What a URDF says and does not say, point by point: what is carried over, said, or refused with the words that mend it."""

import gc
import re
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene import Box, ConvexHull, Coupling, Prismatic, Revolute
from plumbline.harness.scene.importers import reading
from plumbline.harness.scene.importers.companion import Companion, Drives, JointWish, Massless
from plumbline.harness.scene.importers.fidelity import Imported
from plumbline.harness.scene.importers.joint_tree import tree_of
from plumbline.harness.scene.importers.kinematics import posed
from plumbline.harness.scene.importers.materials import laws_of
from plumbline.harness.scene.importers.merging import Group, grouped
from plumbline.harness.scene.importers.poses import IDENTITY
from plumbline.harness.scene.importers.reading import read, robot_of
from plumbline.harness.scene.importers.robot import Robot
from tests.robot_files import INERTIAL, LIMIT, imported, row, urdf


def joint(got: Imported, name: str = "j") -> Revolute:
    return next(one for one in got.scene.joints if one.name == name)  # type: ignore[return-value]


def test_a_joint_stands_where_it_says_about_a_unit_axis_with_its_range_damping_and_effort(tmp_path: Path) -> None:
    text = urdf(joint=f'{LIMIT}<dynamics damping="0.5"/>')
    scene = imported(tmp_path, text, Companion(root="fixed", drives=Drives(stiffness=7, damping=1))).scene
    (joint,) = scene.joints
    assert isinstance(joint, Revolute)
    assert (joint.parent, joint.child, joint.anchor_W, joint.axis_W) == ("world", "arm", (0, 0, 1), (0, 1, 0))
    assert joint.limits is not None
    assert (joint.limits.lower, joint.limits.upper) == (-1, 1)
    assert joint.spring is not None
    assert joint.spring.damping == 0.5
    assert joint.drive is not None
    assert (joint.drive.stiffness, joint.drive.limit) == (7, 5)
    assert scene.body("arm").mass == 2


def test_how_the_root_is_held_has_to_be_said(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(urdf(base=INERTIAL))
    with pytest.raises(RobotError, match=r"root 'base' is held.*--root fixed or --root floating"):
        read(path)
    with pytest.raises(
        RobotError, match=re.escape(f"\n  plumbline run {path} --root fixed\n  plumbline run {path} --root floating")
    ):
        read(path)
    floating = imported(tmp_path, urdf(base=INERTIAL), root="floating").scene
    assert [b.name for b in floating.bodies if b.movable] == ["base", "arm"]
    assert floating.joints[0].parent == "base"


def test_a_root_called_world_is_fixed_without_a_word_and_takes_no_name_of_ours(tmp_path: Path) -> None:
    text = urdf().replace('"base"', '"world"')
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    assert read(path).scene.joints[0].parent == "world"
    shaped = text.replace(
        '<link name="world">', '<link name="world"><collision><geometry><sphere radius="1"/></geometry></collision>'
    )
    assert [b.name for b in imported(tmp_path, shaped).scene.bodies] == ["world_2", "arm"]


def test_a_floating_joint_in_the_file_lets_its_link_go(tmp_path: Path) -> None:
    got = imported(tmp_path, urdf(kind="floating", joint=""))
    assert not got.scene.joints
    assert got.scene.body("arm").p_WB == (0, 0, 1)


def test_what_is_fixed_together_is_one_body_with_the_rotation_of_the_fixed_joint(tmp_path: Path) -> None:
    part = (
        '<link name="part"><inertial><origin xyz="0.1 0 0" rpy="0 0 0.4"/><mass value="1"/>'
        '<inertia ixx="0.001" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.0105"/></inertial></link>'
        '<joint name="bolt" type="fixed"><parent link="arm"/><child link="part"/>'
        '<origin xyz="0 0.2 0" rpy="0.3 -0.5 0.9"/></joint>'
    )
    got = imported(tmp_path, urdf(part))
    (body,) = (b for b in got.scene.bodies if b.movable)
    X = Rotation.from_euler("xyz", [0.3, -0.5, 0.9])
    place = X.apply([0.1, 0, 0]) + np.array([0, 0.2, 0])
    centre = place / 3
    assert body.mass == 3
    assert np.array(body.p_WB) == pytest.approx(centre + np.array([0, 0, 1]), abs=1e-15)

    def about(mass: float, d: np.ndarray) -> np.ndarray:
        return mass * (d @ d * np.eye(3) - np.outer(d, d))

    R = (X * Rotation.from_euler("z", 0.4)).as_matrix()
    tensor = (
        np.diag([0.02, 0.03, 0.04]) + about(2, centre) + R @ np.diag([0.001, 0.01, 0.0105]) @ R.T + about(1, place - centre)
    )
    assert np.array(body.inertia) == pytest.approx(tensor, abs=1e-15)
    assert got.links["part"] == "arm"


def test_an_impossible_tensor_is_refused_only_once_all_that_is_fixed_together_is_merged(tmp_path: Path) -> None:
    impossible = INERTIAL.replace('izz="0.04"', 'izz="0.4"')
    with pytest.raises(RobotError, match=r"line 3: <link> 'arm': link 'arm' has principal moments .*triangle inequality"):
        imported(tmp_path, urdf(arm=impossible))
    heavy = (
        '<link name="heavy"><inertial><mass value="1"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
        '<joint name="f" type="fixed"><parent link="arm"/><child link="heavy"/></joint>'
    )
    assert imported(tmp_path, urdf(heavy, arm=impossible)).scene.body("arm").mass == 3


def test_a_link_without_mass_stands_between_two_joints_or_weighs_what_the_user_states(tmp_path: Path) -> None:
    hand = (
        f'<link name="hand">{INERTIAL}</link><joint name="k" type="continuous"><parent link="arm"/><child link="hand"/></joint>'
    )
    got = imported(tmp_path, urdf(hand, arm=""))
    assert [(body.name, body.massless) for body in got.scene.bodies if body.movable] == [("arm", True), ("hand", False)]
    assert [(joint.parent, joint.child) for joint in got.scene.joints] == [("world", "arm"), ("arm", "hand")]
    assert [(r.name, r.becomes) for r in got.fidelity if r.element == "link" and "arm" in r.name] == [
        ("'arm'", "a body without mass between two joints")
    ]
    got = imported(tmp_path, urdf(hand, arm=""), Companion(massless=Massless(mass=0.01)))
    assert got.scene.body("arm").mass == 0.01
    stated = row(got, "link without mass")
    # About j the hand has 0.03 kg m2, the ball 2/5 0.01 0.01^2 = 4e-7.
    assert stated.value == pytest.approx(4e-7 / 0.03, rel=1e-9)
    frame = '<link name="frame"/><joint name="f" type="fixed"><parent link="arm"/><child link="frame"/></joint>'
    assert imported(tmp_path, urdf(frame)).links["frame"] == "arm"


@pytest.mark.parametrize("hands", [0, 2])
def test_a_link_without_mass_that_ends_or_forks_is_refused(tmp_path: Path, hands: int) -> None:
    after = "".join(
        f'<link name="h{k}">{INERTIAL}</link>'
        f'<joint name="k{k}" type="continuous"><parent link="arm"/><child link="h{k}"/></joint>'
        for k in range(hands)
    )
    with pytest.raises(
        RobotError, match=r"line 3: <link> 'arm': link 'arm' has no mass and hangs on a joint that moves; \[massless\]"
    ):
        imported(tmp_path, urdf(after, arm=""))


def test_a_start_outside_the_range_is_said_and_the_middle_is_offered(tmp_path: Path) -> None:
    text = urdf(joint=LIMIT.replace('lower="-1"', 'lower="0.4"'))
    got = imported(tmp_path, text)
    assert row(got, "start").value == pytest.approx(0.4)
    assert "kick at t = 0" in row(got, "start").consequence
    middle = imported(tmp_path, text, Companion(start="middle"))
    assert middle.coordinates == {"j": pytest.approx(0.7)}
    assert middle.scene.joints[0].position == pytest.approx(0.7)  # type: ignore[union-attr]
    for inside in (imported(tmp_path, text, Companion(start="inside")), imported(tmp_path, text, start="inside")):
        assert inside.coordinates == {"j": pytest.approx(0.4)}
        assert (row(inside, "start").outcome, row(inside, "start").value) == ("approximated", pytest.approx(0.4))
    assert imported(tmp_path, text, scenario="hold").coordinates == {"j": pytest.approx(0.4)}
    assert imported(tmp_path, text, Companion(start="zero"), scenario="hold").coordinates == {"j": 0.0}
    within = imported(tmp_path, urdf(), start="inside")
    assert within.scene == imported(tmp_path, urdf()).scene


@pytest.mark.parametrize("joint", ["", '<limit effort="1" velocity="1"/>', '<limit upper="1" effort="1" velocity="1"/>'])
def test_a_missing_range_is_not_read_as_zero_to_zero(tmp_path: Path, joint: str) -> None:
    with pytest.raises(RobotError, match=r"line 4: <joint> 'j': a revolute joint without lower and upper.*0 to 0: locked"):
        imported(tmp_path, urdf(joint=joint))
    opened = imported(tmp_path, urdf(joint=joint), Companion(joints={"j": JointWish(limits="none")}))
    assert opened.scene.joints[0].limits is None  # type: ignore[union-attr]
    ranged = imported(tmp_path, urdf(joint=joint), Companion(joints={"j": JointWish(limits=(-2, 3))}))
    assert ranged.scene.joints[0].limits.upper == 3  # type: ignore[union-attr]


def test_a_continuous_joint_ignores_a_range_and_says_so(tmp_path: Path) -> None:
    got = imported(tmp_path, urdf(kind="continuous"))
    assert got.scene.joints[0].limits is None  # type: ignore[union-attr]
    assert row(got, "limit").outcome == "left_out"


def test_efforts_and_speeds_without_a_word_in_the_scene_are_said(tmp_path: Path) -> None:
    got = imported(tmp_path, urdf())
    assert row(got, "effort").outcome == "left_out"
    assert row(got, "velocity limit").value == 3
    assert (row(got, "velocity limit").outcome, joint(got).speed_limit) == ("left_out", None)


def test_velocity_limits_are_laws_where_the_companion_says_so(tmp_path: Path) -> None:
    got = imported(tmp_path, urdf(), Companion(speed_limits=True))
    assert (row(got, "velocity limit").outcome, joint(got).speed_limit) == ("exact", 3)


def test_a_mimic_joint_never_becomes_a_free_one_unannounced(tmp_path: Path) -> None:
    second = f'<link name="b">{INERTIAL}</link><joint name="k" type="continuous">'
    second += '<parent link="arm"/><child link="b"/><mimic joint="j"/></joint>'
    tied = imported(tmp_path, urdf(second))
    assert joint(tied, "k").coupling == Coupling(joint="j", ratio=1.0)
    assert (row(tied, "mimic").name, row(tied, "mimic").outcome) == ("'k'", "exact")
    got = imported(tmp_path, urdf(second), drop=frozenset(("mimic",)))
    assert any("mimic was dropped by the user" in one.consequence for one in got.fidelity)
    assert joint(got, "k").coupling is None
    assert got.dropped == ("mimic",)
    with pytest.raises(RobotError, match="joint is 'nobody'"):
        imported(tmp_path, urdf(second.replace('mimic joint="j"', 'mimic joint="nobody"')))


def test_a_follower_starts_where_its_leader_puts_it_and_has_no_drive_of_its_own(tmp_path: Path) -> None:
    second = f'<link name="b">{INERTIAL}</link><joint name="k" type="continuous">'
    second += '<parent link="arm"/><child link="b"/><axis xyz="0 1 0"/><mimic joint="j" multiplier="-2" offset="0.1"/></joint>'
    told = Companion(
        root="fixed", joints={"j": JointWish(position=0.3, velocity=0.5)}, drives=Drives(stiffness=4.0, damping=1.0)
    )
    got = imported(tmp_path, urdf(second), told)
    follower = joint(got, "k")
    assert follower.coupling == Coupling(joint="j", ratio=-2.0, offset=0.1)
    assert (follower.position, follower.drive, joint(got, "j").drive is None) == (-0.5, None, False)
    # The hinge at `k` turns by -2 times the rate of `j`, whose axis is its own: the forearm turns by the sum.
    assert got.scene.body("b").w_WB == pytest.approx(np.array(got.scene.body("arm").w_WB) * -1.0)
    with pytest.raises(RobotError, match="the joint follows 'j', which says where it starts"):
        imported(tmp_path, urdf(second), Companion(root="fixed", joints={"k": JointWish(position=0.3)}))
    with pytest.raises(RobotError, match="mimic each then moves freely"):
        imported(tmp_path, urdf(second.replace('multiplier="-2"', 'multiplier="0"')))
    with pytest.raises(RobotError, match="joint 'j' follows itself"):
        imported(tmp_path, urdf(second, joint=f'{LIMIT}<mimic joint="k"/>'))


def test_dry_friction_is_carried_or_dropped_with_its_size(tmp_path: Path) -> None:
    text = urdf(joint=f'{LIMIT}<dynamics damping="0.1" friction="0.7"/>')
    kept = imported(tmp_path, text)
    assert (joint(kept).friction_loss, row(kept, "friction loss").outcome) == (0.7, "exact")
    dropped = imported(tmp_path, text, drop=frozenset(("friction_loss",)))
    lost = row(dropped, "friction loss")
    assert joint(dropped).friction_loss is None
    assert (lost.value, lost.unit) == (0.7, "N m")


def test_stiff_damping_on_a_tiny_link_is_said_with_its_rate(tmp_path: Path) -> None:
    tiny = (
        INERTIAL.replace('"2"', '"1e-9"').replace('"0.02"', '"2e-15"').replace('"0.03"', '"3e-15"').replace('"0.04"', '"4e-15"')
    )
    got = imported(tmp_path, urdf(arm=tiny, joint=f'{LIMIT}<dynamics damping="1e-6"/>'))
    assert row(got, "damping").value == pytest.approx(1e-6 / 3e-15, rel=1e-6)
    assert not any(
        one.element == "damping" for one in imported(tmp_path, urdf(joint=f'{LIMIT}<dynamics damping="1"/>')).fidelity
    )


def test_mass_of_shapes_is_filled_in_only_with_a_density_and_never_a_unit_tensor(tmp_path: Path) -> None:
    shape = '<collision><origin xyz="0 0 0.5"/><geometry><box size="1 2 3"/></geometry></collision>'
    with pytest.raises(RobotError, match=r"density = .* fills its shapes"):
        imported(tmp_path, urdf(arm=shape))
    got = imported(tmp_path, urdf(arm=shape), Companion(density=100))
    body = got.scene.body("arm")
    assert body.mass == pytest.approx(600)
    assert np.diag(body.inertia) == pytest.approx([50 * (4 + 9), 50 * (1 + 9), 50 * (1 + 4)])
    assert row(got, "inertial").outcome == "approximated"
    no_tensor = imported(tmp_path, urdf(arm=f'<inertial><mass value="6"/></inertial>{shape}')).scene.body("arm")
    assert np.diag(no_tensor.inertia) == pytest.approx([6.5, 5, 2.5])
    with pytest.raises(RobotError, match=r"has a mass of 6 kg and no <inertia>, and there is no shape"):
        imported(tmp_path, urdf(arm='<inertial><mass value="6"/></inertial>'))
    with pytest.raises(RobotError, match="line 3: <inertia>: ixx is missing"):
        imported(tmp_path, urdf(arm='<inertial><mass value="6"/><inertia iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'))


def test_mass_zero_with_a_tensor_is_refused_where_it_moves_and_told_nowhere_else(tmp_path: Path) -> None:
    nothing = INERTIAL.replace('value="2"', 'value="0"')
    with pytest.raises(RobotError, match="mass 0 and an inertia that is not 0"):
        imported(tmp_path, urdf(arm=nothing))
    assert imported(tmp_path, urdf(base=nothing)).scene.body("arm").mass == 2
    frame = f'<link name="f">{nothing}</link><joint name="m" type="fixed"><parent link="arm"/><child link="f"/></joint>'
    body = imported(tmp_path, urdf(frame)).scene.body("arm")
    assert body.mass == 2
    assert np.diag(body.inertia) == pytest.approx([0.04, 0.06, 0.08])


@pytest.mark.parametrize("mass", [0.0, 1e-6])
def test_a_planar_joint_is_two_slides_and_a_hinge_with_or_without_stated_masses(tmp_path: Path, mass: float) -> None:
    companion = Companion(massless=Massless(mass=mass)) if mass > 0 else None
    scene = imported(tmp_path, urdf(kind="planar", joint=""), companion).scene
    assert [scene.body(name).mass for name in ("arm.j.x", "arm.j.y", "arm")] == [mass, mass, 2.0]
    x, y, turn = scene.joints
    assert isinstance(x, Prismatic)
    assert isinstance(y, Prismatic)
    assert isinstance(turn, Revolute)
    axes = np.array([x.axis_W, y.axis_W, turn.axis_W])
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-15)
    assert turn.axis_W == (0, 1, 0)
    assert (x.parent, x.child, y.child, turn.child) == ("world", "arm.j.x", "arm.j.y", "arm")


def test_a_root_without_mass_is_held_fixed_and_that_is_told(tmp_path: Path) -> None:
    path, told = tmp_path / "robot.urdf", list[str]()
    path.write_text(urdf('<link name="top"/>', '<joint name="t" type="fixed"><parent link="base"/><child link="top"/></joint>'))
    got = read(path, Wishes(tell=told.append))
    assert (got.scene.joints[0].parent, row(got, "root").becomes) == ("world", "fixed")
    assert told == [f"{path}: root 'base' is held fixed: it has no mass, so that nothing else is possible"]
    # What is fixed to it weighs: both are possible.
    path.write_text(
        urdf(f'<link name="top">{INERTIAL}</link><joint name="t" type="fixed"><parent link="base"/><child link="top"/></joint>')
    )
    with pytest.raises(RobotError, match="--root fixed or --root floating"):
        read(path)


def test_mimics_of_fixed_joints_are_named(tmp_path: Path) -> None:
    tip = '<link name="tip"/><joint name="t" type="fixed"><parent link="arm"/><child link="tip"/>{}</joint>'
    got = imported(tmp_path, urdf(tip.format('<mimic joint="j"/>')))
    assert (row(got, "mimic").name, row(got, "mimic").outcome) == ("'t'", "left_out")
    with pytest.raises(RobotError, match="joint 'j': mimic of a fixed joint, which does not move"):
        imported(tmp_path, urdf(tip.format(""), joint=f'{LIMIT}<mimic joint="t"/>'))


@pytest.mark.parametrize("before", [True, False])
def test_a_file_is_read_without_the_collector_of_cycles_which_is_as_it_was_afterwards(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, before: bool, request: pytest.FixtureRequest
) -> None:
    collected: list[bool] = []
    request.addfinalizer(gc.enable if gc.isenabled() else gc.disable)
    (gc.enable if before else gc.disable)()

    def watched(robot: Robot) -> dict[str, Group]:
        collected.append(gc.isenabled())
        return grouped(robot)

    monkeypatch.setattr(reading, "grouped", watched)
    imported(tmp_path, urdf())
    with pytest.raises(RobotError):
        imported(tmp_path, urdf('<link name="lost"/>'))
    assert collected == [False]
    assert gc.isenabled() is before


def test_a_long_chain_is_kept_link_by_link(tmp_path: Path) -> None:
    names = ["arm", *(f"l{k}" for k in range(300))]
    links = "".join(
        f'<link name="{child}">{INERTIAL}</link>'
        f'<joint name="j{child}" type="continuous"><parent link="{parent}"/><child link="{child}"/></joint>'
        for parent, child in pairwise(names)
    )
    path = tmp_path / "robot.urdf"
    path.write_text(urdf(links))
    robot, _, _ = robot_of(path)
    groups = grouped(robot)
    at = posed(robot, IDENTITY)
    massive = tree_of(robot, groups, at, laws_of(robot, groups, Companion()), Companion()).massive
    assert len(list(massive[-1].lines)) == 301
    # What moves a body is that of its parent and its own line: of n links n lines are kept, not n squared.
    assert all(body.lines.above is parent.lines for parent, body in pairwise(massive))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            urdf(joint='<limit lower="1" upper="-1" effort="1" velocity="1"/>'),
            "line 4: <limit>: lower is 1 and upper -1, expected lower <= upper",
        ),
        (urdf(joint=f'{LIMIT}<dynamics damping="-1"/>'), "<dynamics>: damping is '-1', expected 0 or more"),
        (urdf('<link name="lost"/>'), "2 links hang on no joint: 'base' (line 2), 'lost' (line 5); expected one root"),
        (urdf('<link name="arm"/>'), "line 5: <link> 'arm': name stands in line 3 too"),
        (
            urdf('<joint name="j" type="fixed"><parent link="arm"/><child link="base"/></joint>'),
            "<joint> 'j': name stands in line 4 too",
        ),
        (urdf('<joint name="k" type="fixed"><parent link="arm"/><child link="base"/></joint>'), "go round in a circle"),
        (
            urdf('<joint name="k" type="fixed"><parent link="base"/><child link="arm"/></joint>'),
            "already hangs on joint 'j' (line 4)",
        ),
        (
            urdf('<joint name="k" type="fixed"><parent link="base"/><child link="gone"/></joint>'),
            "child is 'gone', expected the name",
        ),
        (urdf(kind="wobbly"), "type is 'wobbly', expected one of revolute"),
        (urdf(arm=INERTIAL.replace('"2"', '"nan"')), "<mass>: value is 'nan', expected finite number"),
        (urdf(arm=INERTIAL.replace('"2"', '"1e999"')), "<mass>: value is '1e999', expected finite number"),
        (urdf(arm=INERTIAL.replace('"2"', '"1_0"')), "<mass>: value is '1_0', expected finite number"),
        (urdf(arm=INERTIAL.replace('"2"', '"-2"')), "<mass>: value is '-2', expected 0 or more"),
        (urdf().replace('xyz="0 2 0"', 'xyz="0 0 0"'), "<axis>: xyz is '0 0 0', expected a direction"),
        (urdf().replace('xyz="0 0 1"', 'xyz="0 0"'), "<origin>: xyz is '0 0', expected 3 numbers"),
        (
            urdf(arm="<inertail/>"),
            "<inertail>: is unknown in <link>, expected one of inertial, visual, collision; did you mean <inertial>?",
        ),
        (
            urdf(joint=f'{LIMIT}<dynamics dampin="1"/>'),
            "attribute 'dampin' is unknown, expected damping, friction; did you mean damping?",
        ),
        (urdf(joint=f"{LIMIT}{LIMIT}"), "<limit>: stands twice"),
        (urdf(arm="<xacro:box/>"), "a macro that was not expanded; run xacro first"),
        (urdf(arm='<collision><geometry><box size="1 0 1"/></geometry></collision>'), "size is '1 0 1', expected above 0"),
        (urdf(joint='<joint_properties damping="3"/>'), "damping is '3' in a dialect's element"),
        ("<robot name='r'></robot>", "has no <link>"),
        ("<robot name='r'><link", "no well-formed XML"),
        (
            urdf(arm=INERTIAL, base="")
            .replace('name="arm"', 'name="a&#10;b"', 1)
            .replace('child link="arm"', 'child link="a&#10;b"'),
            "180 printable characters",
        ),
    ],
)
def test_what_parsers_accept_and_no_robot_has_is_refused_by_line(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(RobotError) as refused:
        imported(tmp_path, text)
    assert said in str(refused.value)


def test_the_same_name_for_a_link_and_a_joint_is_no_clash(tmp_path: Path) -> None:
    scene = imported(tmp_path, urdf().replace('joint name="j"', 'joint name="arm"')).scene
    assert scene.joints[0].name == scene.joints[0].child == "arm"


def test_markup_in_a_name_stays_text(tmp_path: Path) -> None:
    hostile = urdf().replace('"arm"', '"&lt;script&gt;=cmd()"')
    assert imported(tmp_path, hostile).scene.joints[0].child == "<script>=cmd()"


def test_elements_of_dialects_are_left_out_and_counted(tmp_path: Path) -> None:
    got = imported(tmp_path, urdf("<gazebo/><gazebo/>", '<transmission name="t"/>'))
    assert row(got, "gazebo").count == 2
    assert row(got, "transmission").outcome == "left_out"


def test_base_and_velocities_of_the_start_reach_every_body(tmp_path: Path) -> None:
    from plumbline.harness.scene.importers.companion import Base

    arm = INERTIAL.replace("<mass", '<origin xyz="0 0 0.5"/><mass')
    told = Companion(
        root="floating",
        base=Base(position=(1, 2, 3), rpy=(0, 0, np.pi / 2), velocity=(0.5, 0, 0), angular_velocity=(0, 0, 2)),
        joints={"j": JointWish(position=0.0, velocity=3.0)},
    )
    body = imported(tmp_path, urdf(base=INERTIAL, arm=arm), told).scene.body("arm")
    # The base is turned by 90 degrees, so that the axis is -x: 0.5 m above it the arm moves by -3 x 0.5 z cross -x.
    assert body.p_WB == pytest.approx((1, 2, 4.5))
    assert body.w_WB == pytest.approx((-3, 0, 2))
    assert body.v_WB == pytest.approx((0.5, 1.5, 0))


def test_shapes_are_placed_from_the_centre_of_mass(tmp_path: Path) -> None:
    arm = INERTIAL.replace("<mass", '<origin xyz="0 0 0.5"/><mass')
    shape = '<collision><origin xyz="0 0 0.2" rpy="0 0 1"/><geometry><box size="1 2 3"/></geometry></collision>'
    (placed,) = imported(tmp_path, urdf(arm=arm + shape)).scene.body("arm").collision
    assert placed.shape == Box(half_extents=(0.5, 1, 1.5))
    assert placed.p_BS == pytest.approx((0, 0, -0.3))
    assert placed.q_BS == pytest.approx((np.cos(0.5), 0, 0, np.sin(0.5)))


def test_no_hull_is_made_for_a_shape_that_has_a_name_in_a_scene(tmp_path: Path) -> None:
    shapes = "".join(
        f"<collision><geometry>{one}</geometry></collision>"
        for one in ('<box size="1 1 1"/>', '<sphere radius="1"/>', '<cylinder radius="1" length="2"/>')
    )
    got = imported(tmp_path, urdf(arm=INERTIAL + shapes)).scene.body("arm").collision
    assert not any(isinstance(placed.shape, ConvexHull) for placed in got)
    assert got[2].shape.half_length == 1  # type: ignore[union-attr]


def test_a_chain_twice_as_long_takes_twice_the_calls(tmp_path: Path) -> None:
    """What is done for a link does not grow with the links before it; 20 000 in a row are a scene."""

    def calls(links: int) -> int:
        text = urdf(
            *(
                f'<link name="l{k}">{INERTIAL}</link><joint name="k{k}" type="continuous"><axis xyz="0 1 0"/>'
                f'<origin xyz="0 0 1"/><parent link="{f"l{k - 1}" if k else "arm"}"/><child link="l{k}"/></joint>'
                for k in range(links)
            )
        )
        count = 0

        def counted(_frame: object, event: str, _argument: object) -> None:
            nonlocal count
            count += event in ("call", "c_call")

        sys.setprofile(counted)
        try:
            got = imported(tmp_path, text)
        finally:
            sys.setprofile(None)
        assert len(got.scene.joints) == links + 1
        return count

    calls(1)  # what is loaded on first use
    few, twice, four = (calls(links) for links in (200, 400, 800))
    assert four - twice == pytest.approx(2 * (twice - few), rel=0.05)
