"""Several joints of one link become a chain whose bodies share the link's own mass, and the scene moves as the file's does."""

from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.intake.error import RobotError
from plumbline.harness.scene.importers import merging
from plumbline.harness.scene.importers.companion import Companion, Massless
from tests.joint_space import JointSpace
from tests.robot_files import imported, mjcf, row

pytestmark = pytest.mark.usefixtures("mjcf_here")
EXACT = 1e-9
"""As of all joint trees: sums of some tens of terms in double precision."""
LEG = (
    '<joint name="x" axis="1 0 0" pos="0 .02 .1"/><joint name="z" axis="0 .3 1" pos="0 .02 .1"/>'
    '<joint name="y" axis="0 1 0" pos="0 .02 .1"/><geom type="capsule" fromto="0 0 .1 .05 0 -.3" size=".06"/>'
    '<body name="foot" pos=".05 0 -.35"><joint name="ankle_y" axis="0 1 0" pos="0 0 .08"/>'
    '<joint name="ankle_x" axis="1 0 .5" pos="0 0 .04"/><geom type="box" size=".1 .05 .03"/></body>'
)
"""Three hinges through one point, and two whose axes lie 4 cm apart: the last axis alone counts there."""


HOPPER = (
    '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" ref="1"/>'
    '<joint name="y" axis="0 1 0" pos="0 0 .05"/><geom type="capsule" fromto="0 0 .2 .03 0 -.2" size=".05"/>'
    '<body name="thigh" pos="0 0 -.2"><joint name="hip" axis="0 -1 0"/>'
    '<geom type="capsule" fromto="0 0 0 0 0 -.45" size=".05"/>'
    '<body name="leg" pos="0 0 -.45"><joint name="knee" axis="0 -1 0"/>'
    '<geom type="capsule" fromto="0 0 0 0 0 -.5" size=".04"/>'
    '<body name="foot" pos="0 0 -.5"><joint name="ankle" axis="0 -1 0"/>'
    '<geom type="capsule" fromto="-.1 0 0 .2 0 0" size=".06"/>'
    "</body></body></body>"
)
"""Two slides and a hinge at the root, which no point of its own is fixed by: nothing with mass can stand between them."""
LAMP = (
    '<joint name="a" axis="1 0 0"/><joint name="b" axis="0 1 0" pos="0 0 .1"/><joint name="c" pos=".1 0 0"/>'
    '<joint name="d" type="slide" axis=".6 0 .8"/><geom type="box" pos=".2 0 0" size=".1 .2 .05"/>'
)
"""Three hinges whose axes do not meet, and a slide behind them."""


def compared(tmp_path: Path, text: str = LEG) -> tuple[float, float]:
    """How far mass matrix and accelerations lie from MuJoCo's, of their largest entries, at the worst of ten states."""
    mujoco = pytest.importorskip("mujoco")
    text = mjcf(text, '<compiler angle="radian"/><option><flag contact="disable"/></option>')
    scene = imported(tmp_path, text).scene
    space = JointSpace(scene)
    model = mujoco.MjModel.from_xml_string(text)
    data, rng = mujoco.MjData(model), np.random.default_rng(5)
    order = [model.joint(j.name).dofadr[0] for j in space.joints]
    apart = np.zeros(2)
    for _ in range(10):
        q, qd = rng.uniform(-1, 1, model.nv), rng.normal(0, 2, model.nv)
        data.qpos[order], data.qvel[order] = q, qd
        mujoco.mj_forward(model, data)
        theirs = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, theirs)
        M, h, _ = space.at(q, qd)
        a = np.linalg.solve(M, -h)
        off = (
            np.abs(M - theirs[np.ix_(order, order)]).max() / np.abs(M).max(),
            np.abs(a - data.qacc[order]).max() / np.abs(a).max(),
        )
        apart = np.maximum(apart, off)
    assert sum(body.mass for body in scene.bodies) == pytest.approx(model.body_mass.sum(), rel=EXACT)
    return float(apart[0]), float(apart[1])


def test_but_for_a_small_moment_a_chain_is_the_link_exactly(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(merging, "MOMENT", 1e-11)
    assert max(compared(tmp_path)) < EXACT


def test_the_moment_changes_what_the_row_says(tmp_path: Path) -> None:
    M, a = compared(tmp_path)
    said = row(imported(tmp_path, mjcf(LEG)), "several joints of a link")
    assert said.count == 3
    assert said.value is not None
    assert said.value >= M
    # Of three hinges the third is along the first where the second is turned far: their difference is moved more readily.
    assert a < 1e-3
    assert said.value <= merging.MOMENT


def test_a_link_does_not_touch_what_it_hangs_on_by_several_joints(tmp_path: Path) -> None:
    scene = imported(tmp_path, mjcf(f'<freejoint/><geom size=".2"/><body name="leg">{LEG}</body>')).scene
    arm, leg, foot = (scene.body(name) for name in ("arm", "leg", "foot"))
    assert not scene.collides(arm, leg)
    assert not scene.collides(leg, foot)
    assert scene.collides(arm, foot)


def test_links_that_pass_through_each_other_by_wish_still_touch_the_ground(tmp_path: Path) -> None:
    text = mjcf(
        f'<freejoint/><geom size=".2"/><body name="leg">{LEG}</body>', world='<geom name="floor" type="plane" size="1 1 1"/>'
    )
    kept, dropped = imported(tmp_path, text), imported(tmp_path, text, drop=frozenset(("self_collision",)))
    for got, touches in ((kept, True), (dropped, False)):
        arm, foot, ground = (got.scene.body(name) for name in ("arm", "foot", got.scene.bodies[0].name))
        assert got.scene.collides(arm, foot) == touches
        assert got.scene.collides(foot, ground)
    assert row(dropped, "self-collision").outcome == "left_out"
    assert dropped.undropped == kept.scene


@pytest.mark.parametrize("text", [HOPPER, LAMP], ids=["hopper", "lamp"])
def test_where_no_share_of_the_mass_can_stand_nothing_with_mass_does_and_the_scene_is_the_file_exactly(
    tmp_path: Path, text: str
) -> None:
    """Mass matrix and accelerations are MuJoCo's: sums of some tens of terms, over a mass matrix of condition below 1e5."""
    M, a = compared(tmp_path, text)
    assert M < EXACT
    assert a < 1e3 * EXACT
    got = imported(tmp_path, mjcf(text))
    between = [body for body in got.scene.bodies if body.massless]
    assert [body.name.split(".")[0] for body in between] == ["arm"] * (text.count("<joint") - 1 if text == LAMP else 2)
    assert not [line for line in got.fidelity if line.element in ("several joints of a link", "link without mass")]


@pytest.mark.parametrize(
    "joints",
    [
        '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide"/>',
        '<joint name="a" axis="1 0 0"/><joint name="b" axis="0 1 0" pos="0 0 .1"/><joint name="c" pos=".1 0 0"/>',
    ],
)
def test_a_mass_between_joints_may_be_stated_all_the_same(tmp_path: Path, joints: str) -> None:
    text = mjcf(f'{joints}<geom size=".1" mass="1"/>')
    assert row(imported(tmp_path, text, Companion(massless=Massless(mass=1e-6))), "link without mass").outcome == "approximated"


def test_a_ball_joint_before_a_slide_is_refused_or_stated(tmp_path: Path) -> None:
    text = mjcf('<joint name="b" type="ball"/><joint name="s" type="slide"/><geom size=".1" mass="1"/>')
    with pytest.raises(
        RobotError, match=r"several joints 'b', 's' move one body, ball joint 'b' among them.*\[massless\] mass"
    ):
        imported(tmp_path, text)
