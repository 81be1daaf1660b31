"""Laws beside the tree are compared by their numbers, and two robots are moved alike until they part."""

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from plumbline.harness.cli.main import main
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene.parity.canonical import renamed, stated
from plumbline.harness.scene.parity.comparison import compare
from plumbline.harness.scene.parity.difference import Difference
from plumbline.harness.scene.parity.motion import Configuration
from plumbline.harness.scene.parity.parting import DT, PARTED, motion_of, parting
from plumbline.harness.study import plugins
from tests.planted_robots import MJCF, URDF
from tests.two_formats import MJCF as ARM

pytestmark = pytest.mark.usefixtures("mjcf_here")
TOLERANCE = 1e-9
DOWN = np.array([0.0, 0.0, -9.81])


def differing(folder: Path, name: str, text: str, old: str, new: str) -> list[Difference]:
    assert text.count(old) == 1
    a, b = folder / f"a.{name}", folder / f"b.{name}"
    a.write_text(text)
    b.write_text(text.replace(old, new))
    return compare(stated(a, Wishes())[0], stated(b, Wishes())[0], TOLERANCE)


@pytest.mark.parametrize(
    ("name", "text", "old", "new", "quantity", "element", "size"),
    [
        ("urdf", URDF, 'multiplier="0.5"', 'multiplier="0.4"', "ratio", "mimic shut", 0.1),
        ("urdf", URDF, 'offset="0.01"', 'offset="0.03"', "offset", "mimic shut", 0.02),
        ("xml", MJCF, 'polycoef="0.1 0.5', 'polycoef="0.1 0.7', "ratio", "mimic grip", 0.2),
        ("xml", MJCF, 'polycoef="0.1 0.5', 'polycoef="0.3 0.5', "offset", "mimic grip", 0.2),
    ],
)
def test_the_numbers_of_a_mimic_are_compared(
    name: str, text: str, old: str, new: str, quantity: str, element: str, size: float, tmp_path: Path
) -> None:
    (row,) = differing(tmp_path, name, text, old, new)
    assert (row.quantity, row.element) == (quantity, element)
    assert row.absolute == pytest.approx(size)
    assert row.words


LOOP = """<mujoco><compiler angle="radian"/><worldbody>
<body name="crank"><joint name="crank" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="1"/>
<body name="rod" pos="0.3 0 0"><joint name="rod" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.02" mass="1"/></body></body>
<body name="slider" pos="0.7 0 0"><joint name="slider" type="slide" axis="1 0 0"/>
<geom type="sphere" size="0.05" mass="1"/></body>
</worldbody><equality><connect name="{name}" body1="rod" body2="slider" anchor="0.4 0 {z}"/></equality></mujoco>"""


def test_the_point_of_a_closed_loop_is_compared_whatever_its_name(tmp_path: Path) -> None:
    files = {}
    for key, (name, z) in {"a": ("pin", 0), "same": ("bolt", 0), "off": ("pin", 0.02)}.items():
        files[key] = tmp_path / f"{key}.xml"
        files[key].write_text(LOOP.format(name=name, z=z))
    a, same, off = (stated(path, Wishes())[0] for path in files.values())
    assert compare(a, same, TOLERANCE) == []
    (row,) = compare(a, off, TOLERANCE)
    assert (row.quantity, row.element) == ("point", "closure pin")
    assert row.absolute == pytest.approx(0.02)
    gone = tmp_path / "gone.xml"
    gone.write_text(files["a"].read_text().partition("<equality>")[0] + "</mujoco>")
    (row,) = compare(a, stated(gone, Wishes())[0], TOLERANCE)
    assert (row.quantity, row.value_B) == ("law", "absent")


def test_names_of_joints_reach_into_laws(tmp_path: Path) -> None:
    path = tmp_path / "a.urdf"
    path.write_text(URDF)
    robot = renamed(stated(path, Wishes())[0], {"open": "left", "shut": "right"})
    (tied,) = (joint for joint in robot.joints if joint.tie is not None)
    assert tied.tie is not None
    assert (tied.name, tied.tie.joint, tied.tie.ratio, tied.tie.offset) == ("right", "left", 0.5, 0.01)


def test_robots_that_are_the_same_do_not_part_and_others_part_at_the_joint_that_differs(tmp_path: Path) -> None:
    """The finger slides on no other joint: its damper alone is another one, and it is the first to be elsewhere."""
    pytest.importorskip("mujoco")
    path = tmp_path / "a.xml"
    path.write_text(ARM)
    robot = stated(path, Wishes())[0]
    path.write_text(ARM.replace('range="-0.02 0.05"', 'range="-0.02 0.05" damping="4"'))
    other = stated(path, Wishes())[0]
    start = Configuration(np.array([0.3, -0.2, 0.0]), {}, np.zeros(3))
    engine, motion = plugins.adapter("mujoco"), motion_of("sines", robot, start, DOWN, 0.5)
    assert np.abs(motion.torques).max(axis=0).min() > 0
    once, again, elsewhere = (engine.move_robot(one, motion) for one in (robot, robot, other))
    assert parting(robot, once, again).time is None
    parted = parting(robot, once, elsewhere)
    assert (parted.joint, parted.unit) == ("grip", "m")
    assert parted.time is not None
    sample = round(parted.time / DT)
    assert (
        abs(once[sample, 2, 0] - elsewhere[sample, 2, 0]) > PARTED >= abs(once[sample - 1, 2, 0] - elsewhere[sample - 1, 2, 0])
    )


def test_a_pendulum_that_is_moved_swings_by_its_closed_period(tmp_path: Path) -> None:
    """At 1e-3 rad, as cos of sqrt(m g l / I) t: implicitfast errs in first order, by half a step of a rate below 4e-3 rad/s."""
    pytest.importorskip("mujoco")
    path = tmp_path / "p.urdf"
    path.write_text(
        '<robot name="p"><link name="b"/><link name="l"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>'
        '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>'
        '<joint name="j" type="continuous"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/></joint></robot>'
    )
    robot = stated(path, Wishes())[0]
    motion = motion_of("drop", robot, Configuration(np.array([1e-3]), {}, np.zeros(1)), DOWN, 1.0)
    end = plugins.adapter("mujoco").move_robot(robot, motion)[-1, 0, 0]
    assert end == pytest.approx(1e-3 * np.cos(np.sqrt(2 * 9.81 * 0.5 / 0.6)), abs=1e-6)


def test_torques_of_a_file_are_joined_by_lines_and_refused_by_column(tmp_path: Path) -> None:
    path, table = tmp_path / "a.xml", tmp_path / "t.csv"
    path.write_text(ARM)
    robot = stated(path, Wishes())[0]
    start = Configuration(np.zeros(3), {}, np.zeros(3))
    table.write_text("time,elbow\n0,0\n1,8\n")
    torques = motion_of(str(table), robot, start, DOWN, 1.0).torques
    assert torques[:, [0, 2]].any() == 0
    assert torques[2000, 1] == pytest.approx(8 * 2000 * DT)
    for text, said in (
        ("time,knee\n0,0\n", "'knee' is no joint of the file, expected one of"),
        ("a\n0\n", "line 1: 'a', expected time and then the names of joints"),
        ("time,elbow\n0,0\nx,1\n", "line 3.*'x'"),
    ):
        table.write_text(text)
        with pytest.raises(RobotError, match=said):
            motion_of(str(table), robot, start, DOWN, 1.0)


SLIDE = (
    '<robot name="s"><link name="b"/><link name="l"><inertial><mass value="{mass}"/>'
    '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>'
    '<joint name="rail" type="prismatic"><parent link="b"/><child link="l"/><axis xyz="1 0 0"/>'
    '<limit lower="-9" upper="9" effort="100" velocity="100"/></joint></robot>'
)


@pytest.mark.parametrize(("option", "seconds"), [((), 0.3449), (("--interpolate",), 0.2329)])
def test_two_files_part_under_a_recorded_force_when_their_masses_say(
    tmp_path: Path, option: tuple[str, ...], seconds: float
) -> None:
    """2 and 2.1 kg lie (1/2 - 1/2.1) of the twofold integral of the force apart: a millimetre takes .042 N s2. The log begins
    at its own time. Held, there is no force for .2 s, and then 4 t^2 / 2 makes that in .1449 s. Joined by lines, 20 t makes
    20 t^3 / 6 = .0267 N s2 and 10 t^2 = .4 N s in .2 s, and .0267 + .4 t + 4 t^2 / 2 is .042 after another .0329 s.
    """
    pytest.importorskip("mujoco")
    paths = [tmp_path / "a.urdf", tmp_path / "b.urdf"]
    for path, mass in zip(paths, ("2", "2.1"), strict=True):
        path.write_text(SLIDE.format(mass=mass))
    recorded = tmp_path / "log.csv"
    recorded.write_text("time,rail:torque\n1000,0\n1000.2,4\n1000.4,4\n")
    command = [
        "parity",
        *map(str, paths),
        "--commands",
        str(recorded),
        "--seconds",
        "1",
        "--out",
        str(tmp_path / "out"),
        *option,
    ]
    done = CliRunner().invoke(main, command)
    assert done.exit_code == 1  # their masses differ
    told = re.search(r"they part after ([\d.]+) s, at 'rail'", done.output)
    assert told is not None, done.output
    assert float(told[1]) == pytest.approx(seconds, abs=2 * DT)
    for sentence in (
        "its first time, 1000 s, is taken as the start",
        "ends at 0.4 s of 1 s; its last values are held from there on",
        f"rail (torque); {'joined by straight lines' if option else 'held between samples'}",
    ):
        assert sentence in done.output
    assert "log.csv" in (tmp_path / "out" / "index.html").read_text()
