"""A log laid over a scene: read with what is wrong named, told to every engine as the law that it stands for, and fitted."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from plumbline.harness.adapter import Unavailable
from plumbline.harness.case.commands import acting
from plumbline.harness.case.forces import Controlled
from plumbline.harness.cli.main import main
from plumbline.harness.cli.robot_options import scene_to_run
from plumbline.harness.findings import tables
from plumbline.harness.findings.tables.recorded import _answer, _answering, _delayed
from plumbline.harness.intake.error import RobotError
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.scene import Body, Drive, Prismatic, Revolute, Samples, Scene, Sinusoid
from plumbline.harness.scene.file import dump_toml, load, parse
from plumbline.harness.scene.importers.companion import beside, load_companion
from plumbline.harness.scene.importers.fidelity import Imported
from plumbline.harness.scene.importers.reading import read
from plumbline.harness.scene.importers.replay import Gains, load_commands, read_log, recorded, replayed
from plumbline.harness.scene.importers.start_pose import started_at
from plumbline.harness.store.imported_scenes import keep
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Refinement
from plumbline.harness.study.study import Study, study_of
from plumbline.harness.trajectory import State
from plumbline.harness.trajectory.kinematics import carried
from plumbline.harness.trajectory.pace import Pace
from tests.in_process import in_this_process

MOMENT, DT = 0.5, 1 / 480
NO_WISHES = {"root": None, "scenario": None, "start": None, "convex": None, "one_friction": False, "strict": False}
DAMPED = 0.1
"""Seconds that a drive of 400 N m/rad and 40 N m s/rad lags behind a slow target: d / k."""


def wheel(drive: Drive | None = None) -> Scene:
    """A wheel about x through its own centre of mass, in the void."""
    body = Body(name="wheel", mass=1.0, inertia=np.diag([MOMENT] * 3))
    joint = Revolute(name="axle", parent="world", child="wheel", anchor_W=(0, 0, 0), axis_W=(1, 0, 0), drive=drive)
    return Scene(bodies=(body,), joints=(joint,), gravity=(0.0, 0.0, 0.0))


def log(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "log.csv"
    path.write_text(text)
    return path


def laid(scene: Scene, path: Path, *, gains: Gains | None = None, duration: float = 1.0) -> tuple[Scene, list[str]]:
    said: list[str] = []
    return replayed(scene, read_log(path), duration=duration, gains=gains, joined=False, tell=said.append), said


def test_a_csv_and_an_npz_say_the_same(tmp_path: Path) -> None:
    path = log(tmp_path, "time, knee, hip:torque\n0, 1, 2\n0.5, 3, 4\n")
    np.savez(
        tmp_path / "log.npz", **{"time": np.array([0.0, 0.5]), "knee": np.array([1, 3]), "hip:torque": np.array([2.0, 4.0])}
    )
    one, other = read_log(path), read_log(tmp_path / "log.npz")
    assert one.time == other.time == (0.0, 0.5)
    assert one.columns == other.columns == {("knee", "position"): (1.0, 3.0), ("hip", "torque"): (2.0, 4.0)}
    with pytest.raises(RobotError, match="column 'hip:torque': expected a position"):
        load_commands(path)


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"knee": np.zeros(2)}, "expected time and then the names of joints"),
        (
            {"time": np.arange(2.0), "knee": np.zeros(3)},
            r"array 'knee': float64 of shape \(3,\), expected numbers of shape \(2,\)",
        ),
        ({"time": np.arange(2.0), "knee": np.array(["a", "b"])}, "array 'knee'"),
        ({"time": np.array([0.0, 0.0]), "knee": np.zeros(2)}, "sample 1: column 'time': 0 after 0, expected a later time"),
        ({"time": np.arange(2.0), "knee": np.array([0.0, np.nan])}, "sample 1: column 'knee': nan, expected finite numbers"),
        ({"time": np.arange(2.0), "knee": np.zeros(2), "knee:position": np.zeros(2)}, "column 'knee:position' is twice there"),
    ],
)
def test_what_is_wrong_with_an_npz_is_named(tmp_path: Path, arrays: dict[str, np.ndarray], words: str) -> None:
    np.savez(tmp_path / "log.npz", **arrays)
    with pytest.raises(RobotError, match=words):
        read_log(tmp_path / "log.npz")


def test_what_is_no_npz_at_all_is_refused(tmp_path: Path) -> None:
    for name, content in (("log.npz", b"PK no zip"), ("objects.npz", None)):
        if content is None:
            np.savez(tmp_path / name, time=np.array([object()]), knee=np.zeros(1))
        else:
            (tmp_path / name).write_bytes(content)
        with pytest.raises(RobotError, match="no npz of plain arrays"):
            read_log(tmp_path / name)
    with pytest.raises(RobotError, match="no npz of plain arrays"):
        read_log(tmp_path / "nowhere.npz")


def test_held_samples_stay_until_the_next_one() -> None:
    held = Samples(time=(0.0, 1.0, 2.0), target=(5.0, 7.0, 9.0), held=True)
    assert [held.at(t, 0.0) for t in (-1.0, 0.0, 0.99, 1.0, 1.5, 2.0, 3.0)] == [5.0, 5.0, 5.0, 7.0, 7.0, 9.0, 9.0]
    assert held.rate_at_start() == 0.0


def test_names_are_checked_both_ways_with_the_near_miss(tmp_path: Path) -> None:
    driven = wheel(Drive(stiffness=1.0))
    with pytest.raises(RobotError, match=r"column 'axel' is no joint of the file; did you mean 'axle'\?"):
        laid(driven, log(tmp_path, "time,axel\n0,1\n"))
    two = replace(driven, joints=(*driven.joints, replace(driven.joints[0], name="axle_2")))
    with pytest.raises(RobotError, match=r"joint 'axle_2' has a drive and no column; did you mean 'axle'\?"):
        laid(two, log(tmp_path, "time,axle\n0,1\n"))
    with pytest.raises(RobotError, match="joint 'axle' has two columns"):
        laid(driven, log(tmp_path, "time,axle,axle:torque\n0,1,1\n"))
    with pytest.raises(RobotError, match="column 'axle:torque': expected a position, as joints are compared"):
        recorded(driven, read_log(log(tmp_path, "time,axle:torque\n0,1\n")))


def test_a_position_is_a_held_target_with_the_files_gains_else_with_those_given(tmp_path: Path) -> None:
    path = log(tmp_path, "time,axle\n0,1\n0.5,2\n")
    own, _ = laid(wheel(Drive(stiffness=30.0, damping=3.0, target=9.0)), path)
    drive = own.joints[0].drive  # type: ignore[union-attr]
    assert drive == Drive(
        stiffness=30.0, damping=3.0, target=9.0, motion=Samples(time=(0.0, 0.5), target=(1.0, 2.0), held=True)
    )
    given, _ = laid(wheel(), path, gains=Gains(stiffness=8.0, damping=2.0))
    assert given.joints[0].drive.stiffness == 8.0  # type: ignore[union-attr]
    with pytest.raises(RobotError, match="joint 'axle': its drive has no stiffness, which a position needs; --gains"):
        laid(wheel(), path)
    assert parse(dump_toml(own), "s.toml") == own


def test_what_is_assumed_is_said(tmp_path: Path) -> None:
    _, said = laid(wheel(Drive(stiffness=1.0)), log(tmp_path, "time,axle\n10,1\n10.5,2\n"), duration=2.0)
    assert "its first time, 10 s, is taken as the start" in said[0]
    assert "ends at 0.5 s of 2 s; its last values are held from there on" in said[1]
    assert "axle (position); held between samples" in said[2]


def turned_after(scene: Scene, engine: str, steps: int) -> float:
    """The rate [rad/s, m/s] of the last body's coordinate about or along x."""
    adapter = plugins.adapter(engine)
    try:
        adapter.version()
    except Unavailable as error:
        pytest.skip(str(error))
    control = acting(scene)
    assert control is not None
    simulation = Controlled(adapter.build(scene, replace(adapter.tracks["tuned"], dt=DT)), control, Pace(DT), len(scene.bodies))
    simulation.step(steps)
    end = State.empty(len(scene.bodies))
    simulation.state(end)
    simulation.close()
    return float(end.w_WB[-1, 0] if isinstance(scene.joints[0], Revolute) else end.v_WB[-1, 0])


@pytest.mark.parametrize("engine", ["reference", "mujoco", "bullet", "dart"])
def test_a_torque_turns_by_itself_over_the_inertia_cut_off_at_the_drives_limit(tmp_path: Path, engine: str) -> None:
    """3 N m held for half a second, then 1 of the 8 that the limit leaves: (1.5 + .5) / MOMENT rad/s. A torque is held over a
    step, and the log changes at one, so that no step errs."""
    scene, _ = laid(wheel(Drive(stiffness=7.0, limit=3.0)), log(tmp_path, "time,axle:torque\n0,8\n0.5,1\n"))
    assert scene.joints[0].drive is None  # type: ignore[union-attr]
    assert turned_after(scene, engine, 480) == pytest.approx((1.5 + 0.5) / MOMENT, rel=1e-3)


@pytest.mark.parametrize("engine", ["reference", "mujoco", "bullet", "dart"])
def test_a_velocity_is_reached_as_the_damping_of_the_drive_has_it(tmp_path: Path, engine: str) -> None:
    """d (v - x') on MOMENT: x' = v (1 - exp(-d t / MOMENT)), with d / MOMENT = 4 / s; first order in 4 dt < 1 %."""
    scene, _ = laid(wheel(), log(tmp_path, "time,axle:velocity\n0,2\n"), gains=Gains(stiffness=0.0, damping=2.0))
    rate = turned_after(scene, engine, 240)
    assert rate == pytest.approx(2.0 * (1 - math.exp(-4.0 * 0.5)), rel=4 * DT)


@pytest.mark.parametrize("engine", ["reference", "mujoco", "bullet", "dart"])
def test_a_force_of_a_slide_acts_on_both_bodies(tmp_path: Path, engine: str) -> None:
    """Of 1 and 3 kg under 6 N between them the lighter goes by 6 m/s after a second, and the sum of momenta stays nought."""
    bodies = (Body.box("heavy", (0.1, 0.1, 0.1), 3.0, touches=False), Body.box("light", (0.1, 0.1, 0.1), 1.0, touches=False))
    slide = Prismatic(name="slide", parent="heavy", child="light", anchor_W=(0, 0, 0), axis_W=(1, 0, 0))
    scene, _ = laid(Scene(bodies=bodies, joints=(slide,), gravity=(0, 0, 0)), log(tmp_path, "time,slide:torque\n0,6\n"))
    assert turned_after(scene, engine, 480) == pytest.approx(6.0, rel=1e-3)


def test_fits_find_what_was_planted() -> None:
    time = np.arange(0, 4, 1 / 60)
    scene = wheel(Drive(stiffness=50.0, damping=5.0))
    joint = scene.joints[0]
    assert isinstance(joint, Revolute)
    assert carried(scene, joint) == pytest.approx(MOMENT)
    rate = np.cos(2 * time)
    dry, viscous = (_answer(scene, joint, torque, time) for torque in (-np.sign(rate), -rate))
    for planted, own, other in ((0.8, dry, viscous), (0.3, viscous, dry)):
        size, share = _answering(planted * own, own)
        assert (size, share) == (pytest.approx(planted), pytest.approx(1.0))
        assert _answering(planted * own, other)[1] < 0.99
    # At rest under a torque of 1 the drive gives way by 1 / stiffness.
    assert _answer(scene, joint, np.ones_like(time), time)[-1] == pytest.approx(1 / 50.0, rel=1e-3)
    delay, share = _delayed(time, np.sin(2 * (time - 0.05)), np.sin(2 * time))
    assert delay == pytest.approx(0.05, abs=2e-3)
    # The first .05 of 4 s stand before the run begins; their errors are twice the mean's square at most.
    assert share > 1 - 2 * 0.05 / 4
    assert _delayed(time, np.sin(2 * time), np.sin(2 * time)) == (0.0, 0.0)


def test_the_command_refuses_an_unknown_joint_before_anything_runs(tmp_path: Path) -> None:
    (tmp_path / "w.toml").write_text(dump_toml(wheel(Drive(stiffness=1.0))))
    path = log(tmp_path, "time,axel\n0,1\n")
    done = CliRunner().invoke(main, ["run", str(tmp_path / "w.toml"), "--out", str(tmp_path / "o"), "--commands", str(path)])
    assert done.exit_code == 2
    assert "did you mean 'axle'?" in done.output
    done = CliRunner().invoke(main, ["run", str(tmp_path / "w.toml"), "--out", str(tmp_path / "o"), "--gains", "1,2"])
    assert done.exit_code == 2
    assert "--interpolate and --gains are about --commands" in done.output


def test_a_recorded_robot_stands_beside_every_engine_with_fits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wheel that follows a sinusoid; the recorded one is the same, 50 ms late: that alone explains what is off."""
    in_this_process(monkeypatch)
    wave = Sinusoid(amplitude=0.4, frequency=0.7)
    scene = wheel(Drive(stiffness=400.0, damping=40.0, motion=wave))
    time = np.linspace(0.0, 2.0, 401)
    late = 0.4 * np.sin(2 * math.pi * 0.7 * np.clip(time - 0.05 - DAMPED, 0.0, None))
    measured = log(tmp_path, "time,axle\n" + "".join(f"{t},{x}\n" for t, x in zip(time, late, strict=True)))
    path = keep(tmp_path / "run", Imported(name="w", scene=scene, source="w.toml", duration=2.0), read_log(measured))
    case = plugins.case(f"{plugins.SCENE_PREFIX}{path}")
    ladder = replace(
        study_of(case).experiments[0], timing=False, tracks=("tuned",), refine=Refinement(finest=1 / 960, members=0)
    )
    study = Study(name="scene", title="w", purpose="", experiments=(ladder,))
    store = carry_out(
        study, tmp_path / "run", {case.name: case}, {"mujoco": plugins.adapter("mujoco")}, workers=1, resume=False
    )
    (row,) = tables.table("recorded").rows(store)
    assert (row["engine"], row["joint"], row["unit"]) == ("mujoco", "axle", "rad")
    # The drive follows at d / k = .1 s behind; what is left is the delay that was planted, to a few of its milliseconds.
    assert row["delay"] == pytest.approx(0.05, abs=0.01)
    assert row["delay_explains"] > 0.9
    assert row["rms"] == pytest.approx(0.05 * 0.4 * 2 * math.pi * 0.7 / math.sqrt(2), rel=0.2)
    (words,) = tables.table("recorded").said(store)
    assert "a delay of" in words
    assert words.endswith("(a fit).")


QUADRUPED = Path(__file__).parents[2] / "examples" / "quadruped.urdf"


def test_joints_that_start_elsewhere_take_along_what_hangs_on_them_as_the_importer_has_it() -> None:
    """The standing quadruped, once as its companion starts it, once straightened and then brought to the same coordinates."""
    stands = read(QUADRUPED).scene
    companion = load_companion(beside(QUADRUPED))
    straight = read(QUADRUPED, companion=replace(companion, joints={}, start="zero")).scene
    starts = {joint.name: joint.position for joint in stands.joints if isinstance(joint, Revolute)}
    assert sum(position != 0 for position in starts.values()) == 8
    brought = started_at(straight, starts, "log.csv")
    for one, other in zip(brought.bodies, stands.bodies, strict=True):
        assert one.p_WB == pytest.approx(other.p_WB, abs=1e-12)
        assert abs(np.dot(one.q_WB, other.q_WB)) == pytest.approx(1.0, abs=1e-12)
    for one, other in zip(brought.joints, stands.joints, strict=True):
        assert isinstance(one, Revolute)
        assert isinstance(other, Revolute)
        assert (one.anchor_W, one.axis_W) == (pytest.approx(other.anchor_W, abs=1e-12), pytest.approx(other.axis_W, abs=1e-12))
        assert one.position == other.position


def test_a_start_that_tears_a_loop_or_carries_on_a_velocity_is_refused() -> None:
    loop = read(QUADRUPED.with_name("four_bar.xml")).scene
    first = next(joint for joint in loop.joints if isinstance(joint, Revolute))
    with pytest.raises(RobotError, match="closes a loop, which the start pose would tear"):
        started_at(loop, {first.name: first.position + 0.3}, "log.csv")
    assert started_at(loop, {first.name: first.position}, "log.csv") == loop
    spinning = wheel()
    spinning = replace(spinning, bodies=(replace(spinning.bodies[0], w_WB=(1.0, 0.0, 0.0)),))
    with pytest.raises(RobotError, match="'wheel' has a velocity that is of another pose"):
        started_at(spinning, {"axle": 0.3}, "log.csv")


def test_engines_start_where_the_recorded_robot_does_and_it_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "w.toml").write_text(dump_toml(wheel(Drive(stiffness=1.0))))
    for first, start in ((0.25, 0.25), (1e-9, 0.0)):
        measured = log(tmp_path, f"time,axle\n0,{first}\n1,0.4\n")
        options = {"states": measured, "drop": (), "packages": (), **NO_WISHES}
        scene = load(Path(scene_to_run(str(tmp_path / "w.toml"), tmp_path / "run", options)))
        (joint,) = scene.joints
        assert isinstance(joint, Revolute)
        assert joint.position == start
        # Turned about x by as much.
        assert scene.bodies[0].q_WB == pytest.approx((math.cos(start / 2), math.sin(start / 2), 0.0, 0.0), abs=1e-9)
        said = "joints start where the recorded robot does: axle at 0.25 in place of 0" in capsys.readouterr().err
        assert said == (start == 0.25)
