"""What pulls and ties in an MJCF: servos and motors, loops that equalities close, tendons."""

from pathlib import Path

import pytest

from plumbline.harness.case.undropped import kinds_left_out
from plumbline.harness.intake.error import RobotError
from plumbline.harness.scene import (
    Ball,
    Distance,
    Drive,
    Fixed,
    Limits,
    MomentArm,
    Revolute,
    Samples,
    Spring,
    Tendon,
)
from plumbline.harness.scene.importers.companion import Companion, JointWish, Units
from plumbline.harness.scene.importers.replay import Log, replayed
from tests.robot_files import BALL, imported, joint, mjcf, row

pytest.importorskip("mujoco")
pytestmark = pytest.mark.usefixtures("mjcf_here")


def test_a_servo_becomes_a_drive_and_a_motor_without_a_command_does_nothing(tmp_path: Path) -> None:
    body = f'<joint name="j" axis="0 1 0"/>{BALL}'
    servo = '<actuator><position joint="j" kp="10" kv="2" gear="3" ctrlrange=".5 1" forcerange="-4 4"/></actuator>'
    drive = joint(imported(tmp_path, mjcf(body, servo))).drive
    # Torque 3 (10 u - 10 3 q - 2 3 q'), u held at .5 by its range.
    assert drive is not None
    assert (drive.stiffness, drive.damping, drive.target, drive.limit) == pytest.approx((90, 18, 0.5 / 3, 12))
    motor = imported(tmp_path, mjcf(body, '<actuator><motor joint="j"/></actuator>'))
    assert joint(motor).drive is None
    assert row(motor, "actuator").outcome == "left_out"
    muscle = mjcf(body, '<actuator><muscle name="m" joint="j" lengthrange="0 1"/></actuator>')
    with pytest.raises(RobotError, match=r"actuator 'm'.*--drop actuator"):
        imported(tmp_path, muscle)
    assert joint(imported(tmp_path, muscle, drop=frozenset(("actuator",)))).drive is None


def test_a_motor_with_a_command_is_a_constant_torque_that_its_range_bounds(tmp_path: Path) -> None:
    body = f'<joint name="j" axis="0 1 0"/>{BALL}'
    keys = '<keyframe><key name="on" qpos="0" ctrl="{}"/></keyframe>'
    motor = '<actuator><motor joint="j" gear="3" ctrlrange="-1 1" forcerange="-4 4"/></actuator>'
    for ctrl, torque in ((0.5, 1.5), (-2.0, -3.0)):
        folder = tmp_path / f"{torque}"
        folder.mkdir()
        got = imported(folder, mjcf(body, motor + keys.format(ctrl)), Companion(keyframe="on"))
        assert joint(got).drive == Drive(limit=12.0, feedforward=torque)
        assert row(got, "actuator").outcome == "exact"
    # Torque 3 (10 u + 0.5 - 4 3 q): the constant term of a general actuator stands beside its gains.
    general = '<actuator><general joint="j" gear="3" gainprm="10" biastype="affine" biasprm=".5 -4 0"/></actuator>'
    drive = joint(imported(tmp_path, mjcf(body, general))).drive
    assert drive == Drive(stiffness=36.0, feedforward=1.5)


def test_a_servo_has_the_torque_that_mujoco_gives_it(tmp_path: Path) -> None:
    import mujoco

    text = mjcf(f'<joint name="j" axis="0 1 0"/>{BALL}', '<actuator><position joint="j" kp="10" kv="2" gear="-3"/></actuator>')
    drive = joint(imported(tmp_path, text)).drive
    assert drive is not None
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = 0.7, -0.4
    mujoco.mj_forward(model, data)
    assert data.qfrc_actuator[0] == pytest.approx(drive.stiffness * (drive.target - 0.7) + drive.damping * 0.4, rel=1e-12)


LOOP = mjcf(
    f'<joint name="p" axis="0 1 0"/>{BALL}</body><body name="b" pos="1 0 1"><joint name="q" axis="0 1 0"/>{BALL}',
    "<equality>{}</equality>",
)


def test_a_loop_is_closed_by_a_connection_or_a_weld(tmp_path: Path) -> None:
    closed = imported(tmp_path, LOOP.format('<connect name="c" body1="arm" body2="b" anchor=".5 0 0"/>')).scene.joints[2]
    assert isinstance(closed, Ball)
    assert (closed.anchor_W, closed.collide) == ((0.5, 0, 1), True)
    assert isinstance(imported(tmp_path, LOOP.format('<weld body1="arm" body2="b"/>')).scene.joints[2], Fixed)
    open_pose = Companion(joints={"p": JointWish(position=0.5)})
    with pytest.raises(RobotError, match=r"connection 'c': its two sides lie 0\.\d+ m"):
        imported(tmp_path, LOOP.format('<connect name="c" body1="arm" body2="b" anchor=".5 0 0"/>'), open_pose)
    coupled = LOOP.format('<joint name="e" joint1="p" joint2="q" polycoef="0 1 1 0 0"/>')
    with pytest.raises(RobotError, match=r"equality 'e': equality of joints that is no line.*--drop equality"):
        imported(tmp_path, coupled)
    assert len(imported(tmp_path, coupled, drop=frozenset(("equality",))).scene.joints) == 2


def test_a_tendon_between_two_sites_is_a_spring_between_two_bodies(tmp_path: Path) -> None:
    body = f'<freejoint/>{BALL}<site name="s" pos=".1 0 0"/></body><body name="b"><site name="w" pos="0 0 3"/>'
    tendon = '<tendon><spatial name="t" stiffness="20" damping="3" {}><site site="{}"/><site site="{}"/></spatial></tendon>'
    got = imported(tmp_path, mjcf(body, tendon.format('springlength="0.5"', "s", "w")))
    line = got.scene.joints[0]
    assert isinstance(line, Distance)
    assert (line.parent, line.child, line.spring) == ("world", "arm", Spring(stiffness=20.0, damping=3.0, rest=0.5))
    start = got.scene.body("arm").p_WB
    assert line.anchor_W == (0.0, 0.0, 3.0)
    assert line.child_anchor_W == pytest.approx((start[0] + 0.1, start[1], start[2]))
    assert row(got, "tendon").outcome == "exact"
    for extra in ('springlength="0.5 1"', 'limited="true" range="0 2"', 'frictionloss="1"'):
        with pytest.raises(RobotError, match=r"tendon 't': tendon: .*--drop tendon"):
            imported(tmp_path, mjcf(body, tendon.format(extra, "s", "w")))


CORDS = mjcf(
    f'<joint name="j" axis="0 1 0"/>{BALL}<body pos=".3 0 0"><joint name="k" axis="0 1 0"/>{BALL}'
    f'<body pos=".3 0 0"><joint name="s" type="slide" axis="1 0 0"/>{BALL}</body></body>',
    "<tendon>{}</tendon><actuator>{}</actuator>" + '<keyframe><key name="on" qpos="0 0 0" ctrl="{}"/></keyframe>',
)
ARMS = '<joint joint="j" coef="1.5"/><joint joint="k" coef="-2"/><joint joint="s" coef=".5"/>'


@pytest.mark.parametrize(
    ("tendon", "actuator", "ctrl"),
    [
        (f'<fixed name="t" stiffness="3" damping=".7" springlength=".4">{ARMS}</fixed>', "", ""),
        (f'<fixed name="t" stiffness="3">{ARMS}</fixed>', "", ""),
        (f'<fixed name="t">{ARMS}</fixed>', '<position tendon="t" kp="8" kv=".5" gear="3" forcerange="-1.5 1.5"/>', "0.3"),
        (f'<fixed name="t" damping="1">{ARMS}</fixed>', '<motor tendon="t" gear="-2"/><motor joint="k"/>', "0.4 -0.2"),
    ],
)
def test_a_fixed_tendon_has_the_forces_that_mujoco_gives_it(tmp_path: Path, tendon: str, actuator: str, ctrl: str) -> None:
    import mujoco
    import numpy as np

    text = CORDS.format(tendon, actuator, ctrl)
    got = imported(tmp_path, text, Companion(keyframe="on"))
    (cord,) = got.scene.tendons or ()
    assert row(got, "tendon").outcome == "exact"
    names = [one.name for one in got.scene.joints]
    motor = {one.name: one.drive.feedforward or 0.0 for one in got.scene.joints if getattr(one, "drive", None) is not None}  # type: ignore[union-attr]
    arms = np.zeros(3)
    for arm in cord.arms:
        arms[names.index(arm.joint)] = arm.arm
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    for seed in range(4):
        data.qpos[:], data.qvel[:] = np.random.default_rng(seed).normal(size=(2, 3))
        mujoco.mj_forward(model, data)
        length, rate, force = arms @ data.qpos, arms @ data.qvel, 0.0
        if cord.spring is not None:
            force += cord.spring.stiffness * (cord.spring.rest - length) - cord.spring.damping * rate
        if cord.drive is not None:
            drive = cord.drive
            pull = drive.stiffness * (drive.target - length) + drive.damping * (drive.target_velocity - rate)
            limit = float("inf") if drive.limit is None else drive.limit
            force += min(max(pull + (drive.feedforward or 0.0), -limit), limit)
        own = [motor.get(name, 0.0) for name in names]
        assert data.qfrc_passive + data.qfrc_actuator == pytest.approx(force * arms + own, abs=1e-13)


def test_a_tendon_counts_only_where_it_pulls(tmp_path: Path) -> None:
    body = f'<joint name="j" axis="0 1 0"/>{BALL}'
    tendon = '<tendon><fixed name="t" {}><joint joint="j" coef="2"/></fixed></tendon>'
    assert row(imported(tmp_path, mjcf(body, tendon.format(""))), "tendon").outcome == "left_out"
    bounded = mjcf(body, tendon.format('limited="true" range="-1 .5" stiffness="3"'))
    got = imported(tmp_path, bounded)
    assert got.scene.tendons == (
        Tendon(
            name="t", arms=(MomentArm(joint="j", arm=2.0),), limits=Limits(lower=-1.0, upper=0.5), spring=Spring(stiffness=3)
        ),
    )
    dropped = imported(tmp_path, bounded, drop=frozenset(("tendon",)))
    assert (dropped.scene.tendons, dropped.undropped) == (None, got.scene)
    assert kinds_left_out(dropped.scene, got.scene) == ("tendon",)
    assert row(dropped, "tendon", "left_out").name == "'t'"
    with pytest.raises(RobotError, match=r"tendon 't': its length has a unit of its own"):
        imported(tmp_path, bounded, Companion(units=Units(length=0.01)))
    for law in ('frictionloss="1"', 'stiffness="3" springlength="0 1"'):
        with pytest.raises(RobotError, match=r"tendon 't': tendon: .*--drop tendon"):
            imported(tmp_path, mjcf(body, tendon.format(law)))


@pytest.mark.parametrize(
    "actuators",
    [
        '<position joint="j" kp="10" kv="2" gear="3" forcerange="-1 4"/>',
        '<position joint="j" kp="10" gear="-3" forcerange="-1 4"/>',
        '<general joint="j" gainprm="5" biastype="affine" biasprm=".5 -4 -1" gear="2" ctrlrange="-1 .25" forcerange="0 2"/>',
        '<position joint="j" kp="10"/><velocity joint="j" kv="3"/><motor joint="j" gear="2" forcerange="-.5 1"/>',
        '<velocity joint="j" kv="3" forcerange="-2 .5"/>',
    ],
)
def test_actuators_of_a_joint_give_the_torque_that_mujoco_gives_it(tmp_path: Path, actuators: str) -> None:
    import mujoco

    count = actuators.count("joint=")
    ctrl = [0.6, -0.9, 0.8][:count]
    key = f'<keyframe><key name="on" qpos="0" ctrl="{" ".join(map(str, ctrl))}"/></keyframe>'
    text = mjcf(f'<joint name="j" axis="0 1 0"/>{BALL}', f"<actuator>{actuators}</actuator>{key}")
    got = joint(imported(tmp_path, text, Companion(keyframe="on")))
    drive = got.drive
    assert drive is not None
    push = 0.0 if got.effort is None else got.effort.at(0.3, 0.0)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    bounded = set()
    for q, rate in ((0.7, -0.4), (-0.2, 0.1), (0.05, 0.02), (0.2, 0.05), (-0.9, 1.5), (0.4, 0.6)):
        data.qpos[0], data.qvel[0], data.ctrl[:] = q, rate, ctrl
        mujoco.mj_forward(model, data)
        free = drive.stiffness * (drive.target - q) + drive.damping * (drive.target_velocity - rate) + (drive.feedforward or 0)
        limit = float("inf") if drive.limit is None else drive.limit
        bounded.add(abs(free) > limit)
        # Rounding of a few terms of at most 100 N m.
        assert data.qfrc_actuator[0] == pytest.approx(push + min(max(free, -limit), limit), abs=1e-13)
    assert bounded == ({True, False} if drive.limit is not None else {False})


def test_what_no_one_drive_says_of_several_actuators_is_refused_by_name(tmp_path: Path) -> None:
    body = f'<joint name="j" axis="0 1 0"/>{BALL}'
    both = '<actuator><position name="p" joint="j" kp="10" forcerange="-1 1"/><velocity name="v" joint="j" kv="3"/></actuator>'
    with pytest.raises(RobotError, match=r"actuator 'p', 'v': actuator: .*--drop actuator"):
        imported(tmp_path, mjcf(body, both))
    away = '<actuator><general name="g" joint="j" biastype="affine" biasprm="0 4 0"/></actuator>'
    with pytest.raises(RobotError, match=r"actuator 'g'.*--drop actuator"):
        imported(tmp_path, mjcf(body, away))


def test_uneven_bounds_stay_where_torques_are_told_and_go_where_the_user_gives_a_limit(tmp_path: Path) -> None:
    body = f'<joint name="j" axis="0 1 0"/>{BALL}'
    text = mjcf(body, '<actuator><position joint="j" kp="10" forcerange="-1 4"/></actuator>')
    wished = joint(imported(tmp_path, text, Companion(joints={"j": JointWish(stiffness=10.0, limit=2.0)})))
    assert (wished.drive, wished.effort) == (Drive(stiffness=10.0, limit=2.0), None)
    swung = joint(imported(tmp_path, text, scenario="swing"))
    assert (swung.drive, swung.effort) == (None, None)
    scene = imported(tmp_path, text).scene
    log = Log(source="log", time=(0.0, 1.0, 2.0), columns={("j", "torque"): (-3.0, 2.0, 9.0)})
    led = replayed(scene, log, duration=2.0, joined=False, gains=None, tell=lambda _: None).joints[0]
    assert isinstance(led, Revolute)
    assert isinstance(led.effort, Samples)
    assert (led.drive, led.effort.target) == (None, (-1.0, 2.0, 4.0))
