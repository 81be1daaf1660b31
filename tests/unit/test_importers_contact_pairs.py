"""Which shapes may touch: those of the scene that is imported are those that MuJoCo's own collision finds."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene import Revolute, rotate
from plumbline.harness.scene.importers.companion import Companion, Massless
from plumbline.harness.scene.importers.fidelity import Imported
from plumbline.harness.scene.importers.reading import read
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import State
from tests.robot_files import imported, row, urdf

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.usefixtures("mjcf_here")
ROOT = Path(__file__).parents[2]
FILES = sorted(path for folder in ("examples", "tests/stress/sound_robots") for path in (ROOT / folder).glob("*.xml"))
"""Every MJCF file of the examples and tests."""

PENDULUM = """<mujoco><worldbody>
<body name="base" pos="0 0 1"><geom name="b" type="box" size=".1 .1 .1" pos=".15 0 -.15"/></body>
<body name="arm" pos="0 0 1"><joint name="j" axis="0 1 0"/><geom name="a" type="box" size=".1 .1 .1" pos=".15 0 0"/></body>
</worldbody><contact><exclude body1="base" body2="arm"/></contact></mujoco>"""
"""Two boxes in one another, one of them fixed to the world, and a hinge: the pair is excluded."""

STILL = """<mujoco><worldbody>
<geom name="floor" type="plane" size="1 1 .1" pos="0 0 -.5"/>
<body name="base"><geom name="b1" size=".1"/><body name="cover" pos=".3 0 0"><geom name="b2" size=".1"/></body>
<body name="one" pos="0 0 .1"><joint name="j1" axis="0 1 0"/><geom name="o" size=".1"/>
<body name="two" pos="0 0 .3"><joint name="j2" axis="0 1 0"/><geom name="t" size=".1"/>
<body name="three" pos="0 0 .3"><joint name="j3" axis="0 1 0"/><geom name="h" size=".1"/></body></body></body></body>
</worldbody><contact><exclude body1="base" body2="one"/><exclude body1="cover" body2="two"/>
<exclude body1="one" body2="three"/></contact></mujoco>"""
"""Two links that are fixed to the world, each excluded with another of three that move."""

MASKS = """<mujoco><worldbody><geom name="floor" type="plane" size="1 1 .1" contype="1" conaffinity="1"/>
<body name="a" pos="0 0 1"><freejoint/><geom name="ga" size=".1" contype="1" conaffinity="0"/></body>
<body name="b" pos="1 0 1"><freejoint/><geom name="gb" size=".1" contype="2" conaffinity="2"/></body>
<body name="c" pos="2 0 1"><freejoint/><geom name="gc" size=".1" contype="3" conaffinity="3"/></body>
<body name="d" pos="3 0 1"><freejoint/><geom name="gd" size=".1" contype="0" conaffinity="0"/></body>
</worldbody><contact><exclude body1="b" body2="c"/><pair geom1="gb" geom2="gc"/>
<pair geom1="gd" geom2="gc"/></contact></mujoco>"""
"""Bit masks, and a pair by name that is excluded too: the pair holds."""

RAIL = """<mujoco><worldbody><geom name="floor" type="plane" size="1 1 .1" pos="0 0 -1"/>
<body name="torso"><joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide"/><joint name="r" axis="0 1 0"/>
<geom name="g1" size=".1"/><body name="leg" pos="0 0 -.2"><joint name="hip" axis="0 1 0"/><geom name="g2" size=".1"/></body>
</body></worldbody></mujoco>"""


def may_touch(path: Path) -> set[frozenset[str]]:
    """Pairs of geoms between which MuJoCo finds contacts where all of them reach ten metres around themselves."""
    spec = mujoco.MjSpec.from_file(str(path))
    names = [geom.name for geom in spec.geoms]
    assert len(set(names)) == len(names)
    for geom in spec.geoms:
        geom.margin = 10.0
    for pair in spec.pairs:
        pair.margin = 10.0
    spec.memory = 1 << 28
    model = spec.compile()
    at = mujoco.MjData(model)
    mujoco.mj_forward(model, at)
    still = model.body_weldid == 0
    pairs = set()
    for contact in at.contact:
        a, b = (int(k) for k in contact.geom)
        if not (still[model.geom_bodyid[a]] and still[model.geom_bodyid[b]]):
            pairs.add(frozenset((model.geom(a).name, model.geom(b).name)))
    return pairs


def touching(path: Path, got: Imported) -> set[frozenset[str]]:
    """Pairs of the file's geoms whose bodies may touch in the scene, each geom found by where its shape lies."""
    model = mujoco.MjModel.from_xml_path(str(path))
    at = mujoco.MjData(model)
    mujoco.mj_kinematics(model, at)
    body = {}
    for k in range(model.ngeom):
        here = [
            each
            for each in got.scene.bodies
            for placed in each.collision
            if np.allclose(np.array(each.p_WB) + rotate(each.q_WB, placed.p_BS), at.geom_xpos[k], atol=1e-9)
        ]
        if here:
            (body[model.geom(k).name],) = here
    return {frozenset(pair) for pair in combinations(body, 2) if got.scene.collides(body[pair[0]], body[pair[1]])}


@pytest.mark.parametrize("text", [PENDULUM, STILL, MASKS], ids=["one still", "two still", "masks"])
def test_what_may_touch_is_what_may_touch_in_mujoco(tmp_path: Path, text: str) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(text, encoding="utf-8")
    vendor = may_touch(path)
    assert vendor or text is PENDULUM
    assert touching(path, read(path, Wishes())) == vendor


def test_a_body_on_rails_of_the_world_touches_what_is_still(tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(RAIL, encoding="utf-8")
    companion = "[massless]\nmass = 1e-6\n"
    path.with_suffix(".plumb.toml").write_text(companion, encoding="utf-8")
    assert touching(path, read(path)) == may_touch(path) == {frozenset(("floor", "g1")), frozenset(("floor", "g2"))}


@pytest.mark.parametrize("file", FILES, ids=[path.name for path in FILES])
def test_what_may_touch_in_an_example_is_what_may_touch_in_mujoco(tmp_path: Path, file: Path) -> None:
    spec = mujoco.MjSpec.from_file(str(file))
    for k, geom in enumerate(spec.geoms):
        geom.name = geom.name or f"unnamed_{k}"
    path = tmp_path / file.name
    path.write_text(spec.to_xml(), encoding="utf-8")
    got = read(path, Wishes(drop=frozenset(("armature", "equality", "mimic", "ball_spring"))))
    assert touching(path, got) == may_touch(path)


def test_an_excluded_hinge_swings_as_in_mujoco(tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(PENDULUM, encoding="utf-8")
    got = read(path)
    adapter = plugins.adapter("mujoco")
    settings = adapter.tracks["default"]
    simulation = adapter.build(got.scene, settings)
    simulation.step(round(1 / settings.dt))
    end = State.empty(len(got.scene.bodies))
    simulation.state(end)
    simulation.close()
    alone = mujoco.MjModel.from_xml_path(str(path))
    alone.opt.timestep = settings.dt
    at = mujoco.MjData(alone)
    mujoco.mj_step(alone, at, round(1 / settings.dt))
    (hinge,) = got.scene.joints
    assert isinstance(hinge, Revolute)
    arm = got.scene.index("arm")
    # The centre of mass turns about the hinge by what MuJoCo alone says; both steps are of order dt, as both integrators are.
    turned = rotate((np.cos(at.qpos[0] / 2), 0.0, np.sin(at.qpos[0] / 2), 0.0), (0.15, 0.0, 0.0))
    assert end.p_WB[arm] - (0, 0, 1) == pytest.approx(np.array(turned), abs=0.15 * 9.81 * settings.dt * 10)


def test_pairs_that_a_file_keeps_apart_or_together_are_told(tmp_path: Path) -> None:
    got = imported(tmp_path, STILL)
    assert (row(got, "exclude").count, row(got, "exclude").outcome) == (3, "exact")
    assert row(got, "neighbours").name == "'one/two', 'two/three'"
    masks = imported(tmp_path, MASKS)
    assert row(masks, "contype, conaffinity").count == 5
    pair = STILL.replace("<contact>", '<contact><pair geom1="o" geom2="t"/>')
    assert row(imported(tmp_path, pair), "pair").name == "'one/two'"


def test_an_exclusion_of_one_of_two_links_that_are_fixed_together_is_told(tmp_path: Path) -> None:
    text = STILL.replace(
        '<geom name="h" size=".1"/>', '<geom name="h" size=".1"/><body name="tip" pos="0 0 .2"><geom size=".1"/></body>'
    )
    got = imported(tmp_path, text)
    assert row(got, "exclude", "approximated").name == "'one/three'"


def test_a_planar_joint_keeps_a_link_from_touching_its_fixed_root(tmp_path: Path) -> None:
    shape = '<collision><geometry><sphere radius=".1"/></geometry></collision>'
    mass = '<inertial><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial>'
    text = urdf(base=shape, arm=mass + shape, joint="", kind="planar")
    text = text.replace('<axis xyz="0 2 0"/>', '<axis xyz="0 0 1"/>')
    got = imported(tmp_path, text, Companion(massless=Massless(mass=1e-6), self_collision=True))
    assert not got.scene.collides(got.scene.body("base"), got.scene.body("arm"))
