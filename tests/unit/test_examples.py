"""The examples of the project are read, told row by row, and run by our engine and by MuJoCo."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.adapter import Feature, Unsupported
from plumbline.harness.adapter.features import features_of
from plumbline.harness.intake.import_wishes import Drop, Wishes
from plumbline.harness.scene import Sphere, rotate
from plumbline.harness.scene.importers.companion import beside, load_companion
from plumbline.harness.scene.importers.reading import read
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import State

pytestmark = pytest.mark.usefixtures("mjcf_here")
EXAMPLES = Path(__file__).parents[2] / "examples"
ROBOTS = ("arm.urdf", "quadruped.urdf", "four_bar.xml", "gripper.xml")
DROPPED: dict[str, frozenset[Drop]] = {"gripper.xml": frozenset(("armature", "equality"))}
"""What has to be left out of an example so that all engines run it."""


def test_every_robot_among_the_examples_is_one_of_these() -> None:
    assert {path.name for path in EXAMPLES.iterdir() if path.suffix in (".urdf", ".xml")} == set(ROBOTS)
    page = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    assert all(name in page for name in ROBOTS)


@pytest.mark.parametrize("engine", ["reference", "mujoco"])
@pytest.mark.parametrize("name", ROBOTS)
def test_an_example_runs_with_its_joints_whole(name: str, engine: str) -> None:
    adapter = plugins.adapter(engine)
    if plugins.version_of(adapter)[1] is not None:
        pytest.skip("not installed")
    scene = read(EXAMPLES / name, Wishes(drop=DROPPED.get(name, frozenset()))).scene
    simulation = adapter.build(scene, replace(adapter.tracks["tuned"], dt=1 / 480))
    start, end = State.initial(scene), State.empty(len(scene.bodies))
    simulation.step(48)
    simulation.state(end)
    simulation.close()
    movable = [k for k, body in enumerate(scene.bodies) if body.movable]
    ways = np.linalg.norm(end.p_WB - start.p_WB, axis=1)
    # The strongest push is 120 N m at the arm's shoulder on some 1.5 kg m2: 0.4 rad in a tenth of a second, 0.36 m at the hand.
    assert np.isfinite(end.p_WB).all()
    assert 0 < ways[movable].max() < 0.5


def test_the_arm_has_its_mesh_its_motor_merged_and_its_drives() -> None:
    got = read(EXAMPLES / "arm.urdf")
    assert got.links["elbow_motor"] == "upper_arm"
    assert got.links["tool"] == "hand"
    assert got.scene.body("upper_arm").mass == pytest.approx(5.1)
    (hull,) = got.scene.body("forearm").collision
    assert hull.shape.type == "convex_hull"
    # The mesh is in millimetres: 300 of them are 0.3 m.
    assert np.ptp(np.array(hull.shape.vertices), axis=0)[2] == pytest.approx(0.3)
    assert all(joint.drive is not None for joint in got.scene.joints)  # type: ignore[union-attr]


def test_the_quadruped_stands_on_its_feet() -> None:
    scene = read(EXAMPLES / "quadruped.urdf").scene
    feet = [
        body.p_WB[2] + rotate(body.q_WB, placed.p_BS)[2] - placed.shape.radius
        for body in scene.bodies
        for placed in body.collision
        if isinstance(placed.shape, Sphere)
    ]
    assert len(feet) == 4
    assert all(0 <= foot < 0.02 for foot in feet)


def test_the_linkage_is_closed() -> None:
    scene = read(EXAMPLES / "four_bar.xml").scene
    assert [joint.type for joint in scene.joints] == ["revolute"] * 3 + ["ball"]


@pytest.mark.parametrize("engine", ["bullet", "dart", "mujoco", "reference"])
def test_the_gripper_runs_where_an_engine_has_its_laws_and_is_refused_by_name_elsewhere(engine: str) -> None:
    adapter = plugins.adapter(engine)
    if plugins.version_of(adapter)[1] is not None:
        pytest.skip("not installed")
    got = read(EXAMPLES / "gripper.xml")
    assert got.undropped is None
    tilt, turn, left, right = got.scene.joints
    assert (tilt.armature, tilt.friction_loss, tilt.spring.stiffness, tilt.drive.limit) == (0.004, 0.02, 0.8, 4.0)  # type: ignore[union-attr]
    assert turn.drive.feedforward == pytest.approx(0.002 * 5)  # type: ignore[union-attr]
    assert (left.position, right.position, right.coupling.joint) == (0.02, 0.02, "left_slide")  # type: ignore[union-attr]
    needed = {"armature": Feature.ARMATURE, "coupling": Feature.COUPLING}
    lacking = [word for word, feature in needed.items() if feature not in adapter.features]
    if engine == "bullet":
        lacking = ["friction loss beside joints with rotors"]
    settings = replace(adapter.tracks["tuned"], dt=1 / 480)
    if lacking:
        with pytest.raises(Unsupported, match="|".join(lacking)):
            adapter.build(got.scene, settings)
        return
    simulation = adapter.build(got.scene, settings)
    end = State.empty(len(got.scene.bodies))
    simulation.step(240)
    simulation.state(end)
    simulation.close()
    # The fingers go from 0.02 to about 0.01 m off their places and stay opposite each other, whatever the wrist does.
    palm, one, other = (
        end.p_WB[[body.name for body in got.scene.bodies].index(n)] for n in ("palm", "left_finger", "right_finger")
    )
    assert np.linalg.norm(one - palm) == pytest.approx(np.linalg.norm(other - palm), abs=1e-3)
    assert np.linalg.norm(one - other) == pytest.approx(0.04 + 2 * 0.01, abs=4e-3)


SCENES = tuple(sorted(path.stem for path in (EXAMPLES / "scenes").glob("*.toml") if not path.name.endswith(".plumb.toml")))


def test_the_page_names_every_scene() -> None:
    page = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    assert len(SCENES) == 10
    assert all(f"`{name}`" in page for name in SCENES)


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_is_read_with_its_duration_and_every_engine_claims_what_it_needs(name: str) -> None:
    read_scene = read(
        EXAMPLES / "scenes" / f"{name}.toml", companion=load_companion(beside(EXAMPLES / "scenes" / f"{name}.toml"))
    )
    assert 1.0 <= read_scene.duration <= 4.0
    for engine in ("reference", "mujoco", "bullet", "dart"):
        assert not features_of(read_scene.scene) & ~plugins.adapter(engine).features
