"""Targets over time: what a motion is at an instant, how a file of commands is read, and what engines are told of it."""

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.adapter import Unavailable
from plumbline.harness.case.commands import acting
from plumbline.harness.case.forces import Control, Controlled
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene import Body, Drive, Effect, Motion, Revolute, Samples, Scene, SceneError, Sinusoid, sampled
from plumbline.harness.scene.file import dump_json, dump_toml, parse
from plumbline.harness.scene.importers.companion import Companion, Drives, JointWish
from plumbline.harness.scene.importers.reading import read
from plumbline.harness.scene.importers.replay import load_commands
from plumbline.harness.scene.importers.scenarios import FASTEST, FREQUENCY, SHARE
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.pace import Pace
from plumbline.harness.trial.simulate import simulate
from tests.robot_files import imported, row, urdf

pytestmark = pytest.mark.usefixtures("mjcf_here")
STIFFNESS, DAMPING, MOMENT = 20.0, 2.0, 0.5
WAVE = Sinusoid(amplitude=0.4, frequency=0.7, phase=0.3)


def hinge(motion: Motion | None, target: float = 0.2) -> Scene:
    """A wheel of moment MOMENT about x, driven about its own centre of mass, so that nothing else turns it."""
    body = Body(name="wheel", mass=1.0, inertia=np.diag([MOMENT] * 3))
    drive = Drive(stiffness=STIFFNESS, damping=DAMPING, target=target, motion=motion)
    joint = Revolute(name="axle", parent="world", child="wheel", anchor_W=(0, 0, 0), axis_W=(1, 0, 0), drive=drive)
    return Scene(bodies=(body,), joints=(joint,), gravity=(0.0, 0.0, 0.0))


def test_samples_are_joined_by_straight_lines_and_stay_at_their_ends() -> None:
    told = Samples(time=(1.0, 2.0, 4.0), target=(0.0, 3.0, -1.0))
    assert [told.at(t, 9.0) for t in (0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0)] == [0.0, 0.0, 1.5, 3.0, 1.0, -1.0, -1.0]


def test_a_sinusoid_goes_about_the_drives_own_target() -> None:
    assert WAVE.at(0.25, 2.0) == pytest.approx(2.0 + 0.4 * math.sin(2 * math.pi * 0.7 * 0.25 + 0.3), rel=1e-15)


def test_a_function_becomes_samples_that_hold_it_to_the_second_order() -> None:
    """Between two samples h apart a straight line is off by at most h^2/8 of the greatest second derivative."""
    told = sampled(math.sin, end=2.0, every=0.01)
    assert len(told.time) == 201
    off = max(abs(told.at(t, 0.0) - math.sin(t)) for t in np.linspace(0.0, 2.0, 777))
    assert 0 < off <= 0.01**2 / 8
    with pytest.raises(ValueError, match="at most 100000 samples"):
        sampled(math.sin, end=1e6)
    with pytest.raises(ValueError, match="finite"):
        sampled(lambda t: 1 / t if t else math.inf, end=1.0)


@pytest.mark.parametrize(
    ("drive", "said"),
    [
        ({"motion": {"type": "sinusoid", "amplitude": 1.0, "frequency": 1.0}}, "its target moves and its stiffness is 0"),
        (
            {"stiffness": 1.0, "motion": {"type": "samples", "time": [0.0, 0.0], "target": [1.0, 2.0]}},
            r"time\[1\] is 0 s after 0 s",
        ),
        ({"stiffness": 1.0, "motion": {"type": "samples", "time": [0.0], "target": [1.0, 2.0]}}, "1 times and 2 targets"),
        ({"stiffness": 1.0, "motion": {"type": "saw"}}, "sinusoid"),
    ],
)
def test_a_motion_that_is_none_is_refused(drive: object, said: str) -> None:
    told = json.loads(dump_json(hinge(None)))
    told["joints"][0]["drive"] = drive
    with pytest.raises(SceneError, match=said):
        parse(json.dumps(told))


def test_a_motion_goes_through_a_scene_file_unchanged(tmp_path: Path) -> None:
    for motion in (WAVE, Samples(time=(0.0, 1.0), target=(0.1, 0.2))):
        scene = hinge(motion)
        assert parse(dump_toml(scene), "a.toml") == scene


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        ("t,j\n0,1\n", "line 1: 't', 'j', expected time and then the names of joints"),
        ("time\n0\n", "line 1: 'time', expected time and then"),
        ("time,j,j\n0,1,2\n", "line 1: column 'j' is twice there"),
        ("time,j\n", "0 lines of numbers"),
        ("time,j\n0,1\n1\n", "line 3: 1 values, expected 2"),
        ("time,j\n0,1\n1,x\n", "line 3: column 'j': 'x', expected a finite number"),
        ("time,j\n0,1\n\n1,inf\n", "line 4: column 'j': 'inf', expected a finite number"),
        ("time,j\n0,1\n0,2\n", "line 3: column 'time': 0 after 0, expected a later time"),
        ('time,j\n0,"1\n', "no CSV"),
    ],
)
def test_a_file_of_commands_is_refused_by_line_and_column(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "gait.csv").write_text(text)
    with pytest.raises(RobotError, match=said):
        load_commands(tmp_path / "gait.csv")


def test_a_file_of_commands_beside_a_robot_moves_the_targets_of_its_joints(tmp_path: Path) -> None:
    (tmp_path / "gait.csv").write_text("time,j\n0,0.1\n2,0.5\n")
    (tmp_path / "robot.urdf").write_text(urdf())
    (tmp_path / "robot.plumb.toml").write_text(
        'root = "fixed"\ncommands = "gait.csv"\n[drives]\nstiffness = 5.0\ndamping = 1.0\n'
    )
    (joint,) = read(tmp_path / "robot.urdf").scene.joints
    assert joint.drive.motion == Samples(time=(0.0, 2.0), target=(0.1, 0.5))  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("toml", "header", "said"),
    [
        ('commands = "no.csv"', "time,j", "commands is 'no.csv': there is no such file"),
        ('commands = "../gait.csv"', "time,j", "leads out of"),
        ('commands = "gait.csv"', "time,k", "gait.csv: column 'k' is not of the robot, expected one of 'j'"),
        ('commands = "gait.csv"', "time,j", "its target moves, and it has no drive that follows"),
        ('commands = "gait.csv"\n[joints.j]\ntarget = 1.0', "time,j", "has a column in gait.csv and a target"),
        ('[joints.j]\nmotion = { type = "sinusoid", amplitude = 1.0 }', "time,j", "frequency: Field required"),
        (
            '[joints.j]\nmotion = { type = "sinusoid", freq = 1.0 }',
            "time,j",
            "freq: unknown, got 1.0, expected one of amplitude",
        ),
    ],
)
def test_commands_that_reach_no_joint_are_refused(tmp_path: Path, toml: str, header: str, said: str) -> None:
    folder = tmp_path / "robots"
    folder.mkdir()
    for place in (folder, tmp_path):
        (place / "gait.csv").write_text(f"{header}\n0,0.1\n")
    (folder / "robot.urdf").write_text(urdf())
    (folder / "robot.plumb.toml").write_text(toml)
    with pytest.raises(RobotError, match=said):
        read(folder / "robot.urdf", Wishes(root="fixed"))


def test_a_file_of_commands_beside_a_scene_of_ours_does_too(tmp_path: Path) -> None:
    (tmp_path / "wheel.toml").write_text(dump_toml(hinge(None)))
    (tmp_path / "wheel.plumb.toml").write_text('commands = "turn.csv"\nduration = 1.0\n')
    (tmp_path / "turn.csv").write_text("time,axle\n0,0\n1,2\n")
    case = plugins.case(f"{plugins.SCENE_PREFIX}{tmp_path / 'wheel.toml'}")
    (joint,) = case.scene(case.parameters).joints
    assert joint.drive.motion == Samples(time=(0.0, 1.0), target=(0.0, 2.0))  # type: ignore[union-attr]
    (tmp_path / "turn.csv").write_text("time,axles\n0,0\n")
    with pytest.raises(RobotError, match="column 'axles' is no joint with a drive that follows, expected one of 'axle'"):
        plugins.case(f"{plugins.SCENE_PREFIX}{tmp_path / 'wheel.toml'}")


class Told:
    """A simulation that notes its commands and steps."""

    def __init__(self) -> None:
        self.said: list[tuple[str, float]] = []

    def command(self, targets: Mapping[str, float]) -> None:
        self.said += list(targets.items())

    def step(self, count: int = 1) -> None:
        self.said.append(("step", count))

    def save(self) -> object:
        return len(self.said)

    def restore(self, saved: object) -> None:
        self.said.append(("restored", float(saved)))  # type: ignore[arg-type]


def ramp(time: float) -> Mapping[str, float]:
    return {"axle": time}


def test_the_target_of_a_step_is_the_signal_in_its_middle() -> None:
    told = Told()
    Controlled(told, Control(targets=ramp), 0.1, 1).step(2)  # type: ignore[arg-type]
    assert told.said == [("axle", pytest.approx(0.05)), ("step", 1), ("axle", pytest.approx(0.15)), ("step", 1)]


def test_a_restored_simulation_goes_on_with_the_commands_of_its_own_time() -> None:
    told = Told()
    controlled = Controlled(told, Control(targets=ramp), 0.1, 1)  # type: ignore[arg-type]
    controlled.step()
    saved = controlled.save()
    controlled.step(3)
    controlled.restore(saved)
    controlled.step()
    assert told.said[-2:] == [("axle", pytest.approx(0.15)), ("step", 1)]


@pytest.mark.parametrize("without", [Effect.JOINTS, Effect.DRIVES])
def test_drives_that_do_not_act_are_not_commanded(without: Effect) -> None:
    scene = hinge(Sinusoid(amplitude=0.3, frequency=1.0))
    assert acting(scene) is not None
    assert acting(replace(scene, narrow=without)) is None


def test_a_scene_without_motions_is_not_commanded() -> None:
    assert acting(hinge(None)) is None
    with pytest.raises(ValueError, match="both move"):
        acting(hinge(WAVE), Control(targets=ramp))


def driven(engine: str, track: str, dt: float, motion: Motion) -> Floats:
    """The angle [rad] of the wheel at each tenth of a second of one."""
    adapter = plugins.adapter(engine)
    scene = hinge(motion)
    try:
        simulation = adapter.build(scene, adapter.tracks[track].with_dt(dt))
    except Unavailable as error:
        pytest.skip(str(error))
    control = acting(scene)
    assert control is not None
    run, broke = simulate(
        Controlled(simulation, control, dt, 1),  # type: ignore[arg-type]
        scene,
        pace=Pace(dt),
        duration=1.0,
        sample_interval=0.1,
        with_contacts=False,
        seed=0,
    )
    simulation.close()
    assert broke is None
    turned: Floats = 2 * np.arctan2(run.q_WB[:, 0, 1], run.q_WB[:, 0, 0])
    return turned


def true_angle(motion: Motion) -> Floats:
    """By SciPy: MOMENT x'' = STIFFNESS (target(t) - x) - DAMPING x'."""
    from scipy.integrate import solve_ivp

    def law(t: float, y: Floats) -> list[float]:
        return [y[1], (STIFFNESS * (motion.at(t, 0.2) - y[0]) - DAMPING * y[1]) / MOMENT]

    times = np.linspace(0.0, 1.0, 11)
    return np.asarray(solve_ivp(law, (0.0, 1.0), [0.0, 0.0], t_eval=times, rtol=1e-11, atol=1e-12, max_step=0.01).y[0])


@pytest.mark.parametrize("engine", ["reference", "mujoco", "bullet", "dart"])
@pytest.mark.parametrize("motion", [WAVE, Samples(time=(0.0, 0.3, 1.0), target=(0.0, 0.9, -0.4))], ids=["wave", "samples"])
def test_every_engine_follows_one_signal_whatever_its_step(engine: str, motion: Motion) -> None:
    """All are of the first order at least: half the step makes at most six tenths of the error, and at dt = 1/480 that is less
    than three steps of the greatest rate, 2 rad/s, so that no engine follows another signal."""
    truth = true_angle(motion)
    coarse, fine = (float(np.abs(driven(engine, "tuned", dt, motion) - truth).max()) for dt in (1 / 240, 1 / 480))
    assert fine < 3 * 2.0 / 480
    assert fine < 0.6 * coarse or fine < 1e-6


def test_a_sweep_starts_where_the_joint_stands_and_stays_within_its_range_and_speed(tmp_path: Path) -> None:
    wish = Companion(root="fixed", joints={"j": JointWish(position=0.6)})
    got = imported(tmp_path, urdf(joint='<limit lower="-1" upper="2" effort="5" velocity="1.5"/>'), wish, scenario="sweep")
    (joint,) = got.scene.joints
    assert isinstance(joint, Revolute)
    assert joint.drive is not None
    motion = joint.drive.motion
    assert isinstance(motion, Sinusoid)
    assert motion.at(0.0, joint.drive.target) == pytest.approx(0.6, abs=1e-12)
    path = np.array([motion.at(t, joint.drive.target) for t in np.linspace(0, 1 / motion.frequency, 2001)])
    assert (path.min(), path.max()) == (pytest.approx(0.5 - 1.5 * SHARE, abs=1e-5), pytest.approx(0.5 + 1.5 * SHARE, abs=1e-5))
    assert np.abs(np.diff(path)).max() * 2000 * motion.frequency <= 1.5 * (1 + 1e-9)
    assert motion.frequency < FREQUENCY
    assert joint.drive.limit == 5.0
    assert row(got, "sweep").becomes == "a slower sinusoid"
    # Without a speed of its own the same joint goes as fast as arms do.
    free = imported(tmp_path, urdf(joint='<limit lower="-1" upper="2"/>'), wish, scenario="sweep").scene.joints[0]
    assert isinstance(free, Revolute)
    assert free.drive is not None
    assert isinstance(free.drive.motion, Sinusoid)
    assert free.drive.motion.frequency * 2 * math.pi * free.drive.motion.amplitude == pytest.approx(FASTEST, rel=1e-12)


def test_a_sweep_leaves_the_motion_that_the_companion_states(tmp_path: Path) -> None:
    wish = Companion(root="fixed", joints={"j": JointWish(motion=WAVE)}, drives=Drives(stiffness=3.0, damping=0.1))
    (joint,) = imported(tmp_path, urdf(), wish, scenario="sweep").scene.joints
    assert joint.drive.motion == WAVE  # type: ignore[union-attr]
    assert joint.drive.stiffness == 3.0  # type: ignore[union-attr]


def test_of_a_closed_loop_one_joint_is_swept() -> None:
    scene = read(Path("examples/four_bar.xml"), Wishes(scenario="sweep")).scene
    moving = [joint.name for joint in scene.joints if getattr(getattr(joint, "drive", None), "motion", None) is not None]
    assert moving == ["crank_pin"]
