"""What robots of two files touch with, what drives them, and what a term is worth in a motion that excites it."""

import json
import math
from pathlib import Path

import pytest
from click.testing import CliRunner

from plumbline.harness.cli.main import main
from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene.parity.canonical import pair_of
from plumbline.harness.scene.parity.comparison import compare, compared
from plumbline.harness.scene.parity.difference import Difference
from tests.two_formats import MJCF, URDF

pytestmark = pytest.mark.usefixtures("mjcf_here")

ARM = """<mujoco><option gravity="0 0 0"/><worldbody>
<geom name="floor" type="plane" size="1 1 .1" pos="0 0 -1" friction=".7"/>
<body name="one"><joint name="a" axis="0 0 1" damping=".1"/><geom name="g1" type="box" size=".1 .2 .05" friction=".7"/>
<body name="two" pos=".5 0 0"><joint name="b" axis="0 0 1"/><geom name="g2" size=".1" friction=".7"/>
<body name="three" pos=".5 0 0"><joint name="c" type="slide" axis="1 0 0"/>
<geom name="g3" type="capsule" size=".05 .1" friction=".7"/></body></body></body></worldbody>
<actuator><position joint="a" kp="50" kv="2" forcerange="-9 9"/><motor joint="b"/></actuator></mujoco>"""


def differing(folder: Path, a: str, b: str) -> list[Difference]:
    (folder / "a.xml").write_text(a)
    (folder / "b.xml").write_text(b)
    return compare(*pair_of(folder / "a.xml", folder / "b.xml", Wishes()))


def edited(old: str, new: str) -> str:
    assert ARM.count(old) == 1, old
    return ARM.replace(old, new)


PLANTED = {
    "a gain": (edited('kp="50"', 'kp="60"'), {"drive stiffness"}),
    "a gain of rates": (edited('kv="2"', 'kv="3"'), {"drive damping"}),
    "a bound of a drive": (edited("-9 9", "-8 8"), {"drive limit"}),
    "a drive that is left out": (
        edited('<position joint="a" kp="50" kv="2" forcerange="-9 9"/>', ""),
        {"drive stiffness", "drive damping", "drive limit"},
    ),
    "an exclusion": (edited("<actuator>", '<contact><exclude body1="one" body2="three"/></contact><actuator>'), {"touch"}),
    "a mask": (edited('name="g3"', 'name="g3" contype="2" conaffinity="2"'), {"touch"}),
    "friction": (edited('size=".05 .1" friction=".7"', 'size=".05 .1" friction=".9"'), {"friction"}),
    "a shape": (edited('size=".1 .2 .05"', 'size=".1 .2 .05" pos="0 0 .01"'), {"shape", "centre"}),
    "a rotor about an upright axis": (edited('name="b"', 'name="b" armature=".02"'), {"armature"}),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_difference_is_found_and_is_worth_something(tmp_path: Path, name: str) -> None:
    text, expected = PLANTED[name]
    assert differing(tmp_path, ARM, ARM) == []
    rows = [
        row for row in differing(tmp_path, ARM, text) if row.quantity not in ("mass matrix", "acceleration", "gravity torque")
    ]
    assert {row.quantity for row in rows} == expected
    assert all(row.words for row in rows)
    for row in rows:
        if row.quantity in ("drive stiffness", "drive damping", "armature", "mass"):
            # Nothing falls here: what a rotor is worth shows in a sweep alone.
            assert row.torque is not None
            assert row.torque > 1e-3


def test_the_same_shape_told_in_another_way_is_the_same(tmp_path: Path) -> None:
    turned = edited('type="box" size=".1 .2 .05"', 'type="box" size=".2 .1 .05" euler="0 0 90"')
    assert not [row for row in differing(tmp_path, ARM, turned) if row.quantity == "shape"]


def test_the_last_line_names_what_was_compared_and_what_was_not(tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text(URDF)
    (tmp_path / "b.xml").write_text(MJCF)
    a, b = pair_of(tmp_path / "a.urdf", tmp_path / "b.xml", Wishes())
    looked_at, passed_over = compared(a, b)
    assert "shapes" in looked_at
    assert "drives and their gains" not in looked_at
    assert "drives and their gains (A has no word for it)" in passed_over
    assert "speed (B has no word for it)" in passed_over
    done = CliRunner().invoke(main, ["parity", str(tmp_path / "a.urdf"), str(tmp_path / "b.xml")])
    assert done.exit_code == 0
    last = done.output.strip().splitlines()[-1]
    assert last.startswith("compared: joints, axes and anchors, ")
    assert "; not compared: " in last
    (tmp_path / "c.xml").write_text(MJCF.replace('axis="2 2 0"', 'axis="2 2 0" armature="0.1"'))
    differs = CliRunner().invoke(main, ["parity", str(tmp_path / "b.xml"), str(tmp_path / "c.xml"), "--json"])
    assert differs.exit_code == 1
    assert json.loads(differs.stdout)[0]["quantity"] == "armature"


def test_a_rotor_that_nothing_turns_by_itself_is_worth_what_a_sweep_takes(tmp_path: Path) -> None:
    body = '<body><joint name="a" axis="0 0 1"/><geom size=".1"/></body>'
    lone = f'<mujoco><option gravity="0 0 0"/><worldbody>{body}</worldbody></mujoco>'
    row = differing(tmp_path, lone, lone.replace('axis="0 0 1"', 'axis="0 0 1" armature=".02"'))[0]
    # 0.02 kg m2 at the greatest acceleration of a sine of 1 Hz that comes to 1 rad/s.
    assert (row.quantity, row.torque) == ("armature", pytest.approx(0.02 * 2 * math.pi))
