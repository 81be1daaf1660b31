"""What URDFs hold beside URDF: what changes no motion is left out and told, what may be a slip of the pen is refused."""

from pathlib import Path

import pytest

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.near_miss import edit_distance, misspelt
from tests.robot_files import INERTIAL, LIMIT, imported, row, urdf

BALL = '<geometry><sphere radius=".1"/></geometry>'
DIALECTS = {
    "gains and friction of a controller": (
        urdf(joint=f'{LIMIT}<dynamics damping="1" D="1" K="7000" mu_coulomb="0" mu_viscous="16"/>'),
        "mu_viscous of <dynamics>",
    ),
    "a joint that a converter is to keep": (
        urdf().replace('type="revolute"', 'type="revolute" dont_collapse="true"'),
        "dont_collapse of <joint>",
    ),
    "an effort of commands": (urdf(joint=LIMIT.replace("/>", ' command_effort="3"/>')), "command_effort of <limit>"),
    "a filter of a planner": (urdf(arm=f'{INERTIAL}<self_filter><scale value="1"/></self_filter>'), "<self_filter> in <link>"),
    "a check of collisions": (
        urdf(arm=f"{INERTIAL}<collision_checking>{BALL}</collision_checking>"),
        "<collision_checking> in <link>",
    ),
    "a kinematic link": (urdf(arm=f"{INERTIAL}<kinematic/>"), "<kinematic> in <link>"),
    "a position of reference": (
        urdf(joint=f'{LIMIT}<calibration reference_position="0"/>'),
        "reference_position of <calibration>",
    ),
    "an origin of a link": (urdf(arm=f'{INERTIAL}<origin xyz="1 2 3"/>'), "<origin> in <link>"),
    "a name of a geometry": (
        urdf(arm=INERTIAL + "<collision>" + BALL.replace("<geometry>", '<geometry name="g">') + "</collision>"),
        "name of <geometry>",
    ),
    "a robot without a name": (urdf().replace('<robot name="r">', "<robot>"), ""),
}


@pytest.mark.parametrize("name", DIALECTS)
def test_a_dialects_own_words_are_left_out_with_a_row_and_a_line(tmp_path: Path, name: str) -> None:
    text, word = DIALECTS[name]
    told = list[str]()
    got = imported(tmp_path, text, tell=told.append)
    plain = imported(tmp_path, urdf())
    assert got.scene.joints == plain.scene.joints or name == "gains and friction of a controller"
    assert got.scene.body("arm").mass == 2
    if not word:
        assert (got.name, told) == ("robot", [])
        return
    assert row(got, word).outcome == "left_out"
    (line,) = told
    assert "robot.urdf: left out, since URDF has no such word: " in line
    assert word in line
    with pytest.raises(RobotError, match="is unknown"):
        imported(tmp_path, text, strict=True)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (urdf(joint=f'{LIMIT}<dynamics dampin="1"/>'), "did you mean damping?"),
        (urdf(joint=f'{LIMIT}<dynamics frictoin="1"/>'), "did you mean friction?"),
        (urdf(joint=LIMIT.replace("effort", "eforts")), "did you mean effort?"),
        (urdf(joint=f'{LIMIT}<axes xyz="1 0 0"/>').replace('<axis xyz="0 2 0"/>', ""), "did you mean <axis>?"),
        (urdf(joint=f'{LIMIT}<dynamic damping="1"/>'), "did you mean <dynamics>?"),
        (urdf(joint=f'{LIMIT}<mimics joint="j"/>'), "did you mean <mimic>?"),
        (urdf(arm=INERTIAL.replace("<inertia ", "<intertia ")), "did you mean <inertia>?"),
        (urdf().replace('origin xyz="0 0 1"', 'origin xzy="0 0 1"'), "attribute 'xzy' is unknown"),
        # A word that changes the motion, in an element that does not have it.
        (urdf(arm='<mass value="2"/>'), "<mass>: is unknown in <link>"),
        (urdf(joint=LIMIT.replace("/>", ' damping="3"/>')), "attribute 'damping' is unknown"),
    ],
)
def test_a_slip_of_the_pen_that_changes_the_motion_is_refused(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(RobotError) as refused:
        imported(tmp_path, text)
    assert said in str(refused.value)


def test_edits_are_counted_and_single_letters_are_no_slip() -> None:
    assert [edit_distance(a, b) for a, b in (("", "ab"), ("kitten", "sitting"), ("xzy", "xyz"))] == [2, 3, 1]
    assert misspelt("dampin", ["damping"]) == "damping"
    assert misspelt("masss", ["mass"]) == "mass"
    assert misspelt("ms", ["mass"]) is None
    assert misspelt("K", ["x"]) is None
    assert misspelt("mu_viscous", ["damping", "friction"]) is None
