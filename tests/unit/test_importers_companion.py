"""The file beside a robot, the wishes of the command line, scenarios, frictions and our own scene files."""

from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.import_wishes import Wishes, package_roots
from plumbline.harness.scene import Drive, Surface
from plumbline.harness.scene.file import TEMPLATE, dump_toml, parse
from plumbline.harness.scene.importers.companion import Companion, Ground, JointWish, load_companion
from plumbline.harness.scene.importers.reading import read
from plumbline.harness.scene.importers.scenarios import CLEARANCE, HOLD_RATE, SWING
from tests.robot_files import INERTIAL, imported, row, urdf

SHAPED = f'{INERTIAL}<collision><geometry><sphere radius="0.1"/></geometry></collision>'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("rot = 'fixed'", "rot: unknown, got 'fixed', expected one of .*, root, start, keyframe, base, .*; did you mean root?"),
        ("[base]\npositon = [0, 0, 1]", "base > positon: unknown, got .*, expected one of position, orientation"),
        ("[joints.j]\nlimit_s = 1", "joints > j > limit_s: unknown, got 1, expected one of position, velocity, target"),
        ("root = 'flying'", "root: Input should be 'fixed' or 'floating', got 'flying'"),
        ("duration = -1.0", "duration: Input should be greater than 0"),
        ("[joints.k]\nposition = 0.1", "joint 'k' is not of the robot, expected one of 'j'"),
        ("[materials]\nleg = 'rubber'", "material of a link 'leg' is not of the robot"),
        ("look_at = ['head']", "look_at 'head' is not of the robot, expected one of 'base', 'arm', 'j'"),
        ("drop = ['armor']", "drop: 'armor', expected one of actuator, .*did you mean armature"),
        ("[base]\nrpy = [0, 0, 0]\norientation = [1, 0, 0, 0]", "orientation and rpy are both given"),
        ("[[surfaces]]\nbetween = ['robot', 'moon']\n[ground]", "surface between 'moon' is not of the robot"),
    ],
)
def test_a_typo_is_told_with_the_valid_keys(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "robot.urdf").write_text(urdf(arm=SHAPED))
    (tmp_path / "robot.plumb.toml").write_text(text.replace("'", '"'))
    with pytest.raises(RobotError, match=said):
        read(tmp_path / "robot.urdf", Wishes(root="fixed"))


def test_without_a_companion_there_is_an_empty_one(tmp_path: Path) -> None:
    assert load_companion(tmp_path / "robot.plumb.toml") == Companion()


def test_a_companion_is_found_beside_its_robot_and_says_what_the_run_is(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text(urdf())
    (tmp_path / "robot.plumb.toml").write_text(
        'root = "fixed"\nduration = 1.5\nlook_at = ["arm"]\nseed = 7\ngravity = [0.0, 0.0, -1.6]'
    )
    got = read(tmp_path / "robot.urdf")
    assert (got.duration, got.look_at, got.seed, got.scene.gravity) == (1.5, ("arm",), 7, (0, 0, -1.6))


def test_the_command_line_goes_before_the_companion(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text(urdf(base=INERTIAL))
    (tmp_path / "robot.plumb.toml").write_text('root = "fixed"')
    assert len(read(tmp_path / "robot.urdf", Wishes(root="floating")).scene.bodies) == 2


def test_friction_is_per_pair_of_materials_or_assumed_and_said(tmp_path: Path) -> None:
    law = Surface(between=("rubber", "ground"), static_friction=0.9, kinetic_friction=0.9, restitution=0.1)
    told = Companion(root="floating", ground=Ground(), materials={"arm": "rubber"}, surfaces=(law,))
    got = imported(tmp_path, urdf(base=SHAPED, arm=SHAPED), told)
    scene = got.scene
    assert scene.surface(scene.body("arm"), scene.body("ground")) == law
    assumed = row(got, "friction")
    assert (assumed.name, assumed.value) == ("'ground/robot'", 0.8)
    assert not scene.collides(scene.body("arm"), scene.body("base"))
    assert row(got, "self-collision").outcome == "left_out"


def test_a_robot_touches_itself_where_the_user_says_so(tmp_path: Path) -> None:
    joint = '<joint name="k" type="continuous"><parent link="arm"/><child link="hand"/></joint>'
    third = f'<link name="hand">{SHAPED}</link>{joint}'
    scene = imported(tmp_path, urdf(third, base=SHAPED, arm=SHAPED), Companion(root="fixed", self_collision=True)).scene
    assert scene.collides(scene.body("base"), scene.body("hand"))
    assert not scene.collides(scene.body("arm"), scene.body("hand"))


def test_one_friction_is_the_kinetic_one_and_is_said(tmp_path: Path) -> None:
    law = Surface(between=("robot", "ground"), static_friction=0.9, kinetic_friction=0.6)
    told = Companion(root="floating", ground=Ground(), surfaces=(law,))
    assert imported(tmp_path, urdf(base=SHAPED), told).scene.surfaces[0].static_friction == 0.9
    got = imported(tmp_path, urdf(base=SHAPED), told, one_friction=True)
    assert got.scene.surfaces[0].static_friction == 0.6
    assert row(got, "surface").value == pytest.approx(1.5)


def test_drop_lets_go_a_robot_without_drives_just_above_the_ground(tmp_path: Path) -> None:
    got = imported(tmp_path, urdf(base=SHAPED, arm=SHAPED), scenario="drop")
    assert {b.name: b.p_WB[2] for b in got.scene.bodies} == pytest.approx(
        {"base": CLEARANCE + 0.1, "arm": CLEARANCE + 1.1, "ground": 0}
    )
    assert got.scene.joints[0].anchor_W[2] == pytest.approx(CLEARANCE + 1.1)  # type: ignore[union-attr]
    with pytest.raises(RobotError, match="no shape of the robot touches anything"):
        imported(tmp_path, urdf(base=INERTIAL), scenario="drop")
    with pytest.raises(RobotError, match="scenario drop needs a floating root, and it is fixed"):
        imported(tmp_path, urdf(base=SHAPED), scenario="drop", root="fixed")


def test_a_joint_s_feedforward_in_the_companion_is_a_motor(tmp_path: Path) -> None:
    told = Companion(joints={"j": JointWish(feedforward=1.5)})
    # The effort of the file bounds it, as it bounds every drive.
    assert imported(tmp_path, urdf(), told).scene.joints[0].drive == Drive(limit=5.0, feedforward=1.5)  # type: ignore[union-attr]


def test_hold_gives_each_joint_a_critically_damped_drive_of_its_own_inertia(tmp_path: Path) -> None:
    got = imported(tmp_path, urdf(), scenario="hold")
    drive = got.scene.joints[0].drive  # type: ignore[union-attr]
    assert drive is not None
    assert (drive.stiffness, drive.damping, drive.target, drive.limit) == pytest.approx(
        (0.03 * HOLD_RATE**2, 2 * 0.03 * HOLD_RATE, 0, 5)
    )
    assert row(got, "drive").unit == "Hz"


def test_swing_starts_off_the_place_and_within_the_range(tmp_path: Path) -> None:
    assert imported(tmp_path, urdf(), scenario="swing").coordinates == {"j": SWING}
    near = urdf(joint='<limit lower="-1" upper="0.1" effort="1" velocity="1"/>')
    assert imported(tmp_path, near, scenario="swing").coordinates == {"j": -SWING}
    tight = urdf(joint='<limit lower="-0.1" upper="0.2" effort="1" velocity="1"/>')
    assert imported(tmp_path, tight, scenario="swing").coordinates == {"j": pytest.approx(0.1)}


def test_a_package_is_a_name_and_a_folder_that_is_there(tmp_path: Path) -> None:
    assert package_roots((f"a={tmp_path}",)) == {"a": tmp_path}
    for text in ("a", "=x", "a=", "a=/gone/away", "a/b=/"):
        with pytest.raises(RobotError, match="--package"):
            package_roots((text,))
    with pytest.raises(RobotError, match="given twice"):
        package_roots((f"a={tmp_path}", f"a={tmp_path}"))


def test_our_own_scenes_are_read_as_they_are(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(TEMPLATE.read_text())
    got = read(tmp_path / "own.toml")
    assert got.scene == parse(TEMPLATE.read_text(), "own.toml")
    assert got.fidelity == ()
    (tmp_path / "own.plumb.toml").write_text('root = "fixed"')
    with pytest.raises(RobotError, match="root in its companion file is for robot files"):
        read(tmp_path / "own.toml")
    (tmp_path / "own.plumb.toml").write_text("duration = 2.0")
    assert read(tmp_path / "own.toml").duration == 2
    with pytest.raises(RobotError, match="--drop, --package, --root and --scenario are for robot files"):
        read(tmp_path / "own.toml", Wishes(root="fixed"))


def test_an_imported_scene_survives_our_own_format(tmp_path: Path) -> None:
    scene = imported(tmp_path, urdf(arm=SHAPED), Companion(root="fixed", start="middle")).scene
    assert parse(dump_toml(scene), "back.toml") == scene


@pytest.mark.parametrize("name", ["robot.step", "robot", "robot.urdf.txt"])
def test_another_ending_is_refused_with_those_that_there_are(tmp_path: Path, name: str) -> None:
    with pytest.raises(RobotError, match=r"expected one of \.toml, \.json, \.xml, \.mjcf, \.sdf, \.world, \.urdf"):
        read(tmp_path / name)


def test_a_urdf_may_end_in_xml(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(urdf())
    assert np.isclose(read(tmp_path / "robot.xml", Wishes(root="fixed")).scene.body("arm").mass, 2)
