"""Two files of one robot are told to be the same, and each planted difference is named with what it is worth."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from plumbline.harness.cli.main import main
from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene.importers.poses import IDENTITY, Array, screw
from plumbline.harness.scene.parity.canonical import Canonical, pair_of, stated
from plumbline.harness.scene.parity.comparison import compare
from plumbline.harness.scene.parity.difference import Difference
from plumbline.harness.scene.parity.motion import Configuration, dynamics, passive
from tests.passive_motion import after
from tests.robot_files import mjcf
from tests.two_formats import MJCF, URDF

pytestmark = pytest.mark.usefixtures("mjcf_here")
EXACT = 1e-9
"""Relative: the inertial tensors of MJCF are made diagonal and back, and sums of tens of terms err by 1e-14."""


def differing(folder: Path, urdf: str = URDF, mjcf: str = MJCF, tolerance: float = EXACT) -> list[Difference]:
    (folder / "a.urdf").write_text(urdf)
    (folder / "b.xml").write_text(mjcf)
    return compare(*pair_of(folder / "a.urdf", folder / "b.xml", Wishes()), tolerance)


def edited(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1, old
    return text.replace(old, new)


def causes(rows: list[Difference]) -> set[tuple[str, str]]:
    derived = ("gravity torque", "mass matrix", "acceleration")
    return {(row.quantity, row.element.partition(":")[0]) for row in rows if row.quantity not in derived}


def test_an_arm_in_two_formats_is_the_same_to_a_billionth(tmp_path: Path) -> None:
    assert differing(tmp_path) == []


PLANTED = {
    "a wrong mass": ("urdf", '<mass value="2"/>', '<mass value="2.1"/>', {("mass", "what 'elbow' moves")}),
    "a wrong axis": ("urdf", '<axis xyz="1 1 0"/>', '<axis xyz="1 0.9 0"/>', {("axis", "elbow")}),
    "a turned inertial": (
        "mjcf",
        'pos="0 0.03 0.15" mass="2"',
        'pos="0 0.03 0.15" euler="0 0 0.3" mass="2"',
        {("inertia", "what 'elbow' moves")},
    ),
    "a damper that is left out": ("mjcf", ' damping="0.3"', "", {("damping", "elbow")}),
    "a rotor": ("mjcf", ' damping="0.3"', ' damping="0.3" armature="0.05"', {("armature", "elbow")}),
    "a limit": ("urdf", 'upper="1.5"', 'upper="1.6"', {("upper", "shoulder")}),
    "dry friction": ("urdf", 'friction="0.2"', 'friction="0"', {("friction_loss", "shoulder")}),
    "an effort": ("urdf", 'effort="80"', 'effort="60"', {("effort", "shoulder")}),
    "a fixed joint without its turn": (
        "mjcf",
        'pos="0.05 0 0" euler="0.2 0.1 0"',
        'pos="0.05 0 0"',
        {("inertia", "what 'shoulder' moves")},
    ),
    "an anchor": (
        "urdf",
        'xyz="0 0 0.3"/>\n<axis xyz="0 0 1"',
        'xyz="0 0 0.31"/>\n<axis xyz="0 0 1"',
        {("centre", "what 'grip' moves")},
    ),
}


def planted(text: str, old: str, new: str) -> str:
    if "mass=" in old and "mass=" in new and "euler" in new:
        # MuJoCo takes no orientation beside a full tensor: the tensor is turned by hand.
        turn = np.array([[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]])
        tensor = np.array([[0.03, 0, 0.001], [0, 0.025, 0], [0.001, 0, 0.01]])
        t = turn @ tensor @ turn.T
        six = " ".join(repr(float(t[k])) for k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
        return edited(text, 'fullinertia="0.03 0.025 0.01 0 0.001 0"', f'fullinertia="{six}"')
    return edited(text, old, new)


LONG_ONES = ("a turned inertial",)
"""A fixed joint without its turn is a wrong tensor too."""


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow if name in LONG_ONES else ()) for name in PLANTED])
def test_a_planted_difference_is_named_with_its_consequence(name: str, tmp_path: Path) -> None:
    where, old, new, expected = PLANTED[name]
    texts = {"urdf": URDF, "mjcf": MJCF}
    texts[where] = planted(texts[where], old, new)
    rows = differing(tmp_path, texts["urdf"], texts["mjcf"])
    assert causes(rows) == expected
    row = rows[0]
    assert row.words
    if row.quantity in ("mass", "axis", "inertia", "damping", "armature", "centre"):
        assert row.torque is not None
        assert row.torque > 0
    if row.quantity == "damping":
        # 0.3 N m s/rad at the 1 rad/s that a sweep comes to.
        assert row.torque == pytest.approx(0.3)
        assert row.torque_unit == "N m"


def test_a_second_of_a_pendulum_has_its_closed_period(tmp_path: Path) -> None:
    """A rod at 1e-4 rad: cos of sqrt(m g l / I) t; a step of the integration may err by 1e-9 rad, the cube by 1e-12."""
    (tmp_path / "p.urdf").write_text(
        '<robot name="p"><link name="b"/><link name="l"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>'
        '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>'
        '<joint name="j" type="continuous"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/></joint></robot>'
    )
    robot = stated(tmp_path / "p.urdf", Wishes())[0]
    end = after(robot, Configuration(np.array([1e-4]), {}, np.zeros(1)), np.array([0, 0, -9.81]))
    inertia = 0.1 + 2 * 0.5**2
    assert end.q[0] == pytest.approx(1e-4 * np.cos(np.sqrt(2 * 9.81 * 0.5 / inertia)), abs=1e-9)


def test_a_free_root_keeps_its_energy(tmp_path: Path) -> None:
    """A floating arm with a spinning root and free joints loses no energy in a second, to the integration's tolerance."""
    moments = '<inertia ixx="0.03" ixy="0" ixz="0" iyy="0.04" iyz="0" izz="0.05"/>'
    base = f'<link name="base"><inertial><mass value="2"/>{moments}</inertial></link>'
    text = edited(URDF, '<link name="base"/>', base)
    for damping in (' damping="0.7"', ' damping="0.3"'):
        text = text.replace(damping, "")
    (tmp_path / "f.urdf").write_text(text)
    robot, gravity = stated(tmp_path / "f.urdf", Wishes(root="floating"))[0], np.array([0.0, 0.0, -9.81])
    assert robot.joints[0].kind == "free"
    rng = np.random.default_rng(3)
    start = Configuration(np.array([0.0, 0.4, -0.3, 0.01]), {}, rng.uniform(-1, 1, 9))

    def energy(at: Configuration) -> float:
        """Kinetic by the mass matrix, and potential by the heights of the centres."""
        solids = [(link.name, link.solid) for link in robot.moving if link.solid is not None]
        kinetic = at.rates @ dynamics(robot, at, gravity).M @ at.rates / 2
        return float(kinetic + 9.81 * sum(solid.mass * _centre(robot, at, name)[2] for name, solid in solids))

    end = after(robot, start, gravity)
    assert energy(end) == pytest.approx(energy(start), abs=1e-6)


def _centre(robot: Canonical, at: Configuration, name: str) -> Array:
    """Where the centre of what a joint moves is in W, by the product of the displacements above it."""
    chain, links, above = [], {link.name: (k, link) for k, link in enumerate(robot.moving)}, name
    while above:
        chain.append(links[above])
        above = links[above][1].parent or ""
    X = IDENTITY
    for k, link in chain[::-1]:
        one = link.coordinate
        slides = one.kind == "prismatic"
        way = screw(one.axis, one.anchor, 0.0 if slides else float(at.q[k]), float(at.q[k]) if slides else 0.0)
        X = X @ (at.turned.get(k, IDENTITY) if one.kind == "free" else way)
    solid = links[name][1].solid
    assert solid is not None
    return X.of(solid.centre)


def test_the_passive_forces_of_a_rotor_and_a_damper_are_on_their_joint_alone(tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text(URDF)
    robot, gravity = stated(tmp_path / "a.urdf", Wishes())[0], np.zeros(3)
    at = Configuration(np.zeros(3), {}, np.array([0.0, 1.0, 0.0]))
    M, forces = passive(robot, at, gravity)
    elbow = replace(robot.moving[1], coordinates=(replace(robot.joints[1], armature=0.5, damping=1.3),))
    links = tuple(elbow if link.name == "elbow" else link for link in robot.links)
    more, other = passive(replace(robot, links=links), at, gravity)
    assert np.flatnonzero(more - M).tolist() == [4]
    assert (more - M)[1, 1] == pytest.approx(0.5)
    assert (other - forces).tolist() == pytest.approx([0.0, 1.0, 0.0])


def test_the_command_tells_and_gates(tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text(URDF)
    (tmp_path / "b.xml").write_text(MJCF)
    (tmp_path / "c.xml").write_text(MJCF.replace('"elbow"', '"knee"').replace('mass="0.4"', 'mass="0.5"'))
    run = CliRunner().invoke
    same = run(main, ["parity", str(tmp_path / "a.urdf"), str(tmp_path / "b.xml"), "--json"])
    assert (same.exit_code, json.loads(same.stdout)) == (0, [])
    names = tmp_path / "names.toml"
    names.write_text('[joints]\nelbow = "knee"\n')
    other = run(main, ["parity", str(tmp_path / "a.urdf"), str(tmp_path / "c.xml"), "--map", str(names), "--json"])
    rows = json.loads(other.stdout)
    assert other.exit_code == 1
    assert rows[0]["quantity"] == "mass"
    assert rows[0]["relative"] == pytest.approx(0.25)
    strangers = run(main, ["parity", str(tmp_path / "a.urdf"), str(tmp_path / "c.xml")])
    assert strangers.exit_code == 1
    assert "knee" in strangers.stdout
    names.write_text('[joints]\nelbow = "hip"\n')
    assert run(main, ["parity", str(tmp_path / "a.urdf"), str(tmp_path / "c.xml"), "--map", str(names)]).exit_code == 2
    assert run(main, ["parity", str(tmp_path / "a.urdf"), str(tmp_path / "none.xml")]).exit_code != 0


PLANAR = (
    '<joint name="x" type="slide" axis="{} {} 0" damping="{}"/><joint name="y" type="slide" axis="{} {} 0" damping="2"/>'
    '<joint name="a" axis="0 0 1"/><geom type="box" size=".1 .2 .3" pos=".3 0 0"/>'
)


def test_the_slides_of_a_planar_joint_may_point_anywhere_in_its_plane_if_they_are_resisted_alike(tmp_path: Path) -> None:
    c, s = np.cos(0.5), np.sin(0.5)
    texts = {
        "straight.xml": PLANAR.format(1, 0, 2, 0, 1),
        "turned.xml": PLANAR.format(c, s, 2, -s, c),
        "uneven.xml": PLANAR.format(c, s, 3, -s, c),
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(mjcf(text))
    straight, turned, uneven = (stated(tmp_path / name, Wishes())[0] for name in texts)
    assert compare(straight, turned) == []
    assert {("axis", "x"), ("axis", "y"), ("damping", "x")} <= {
        (row.quantity, row.element) for row in compare(straight, uneven)
    }
