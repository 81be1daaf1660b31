"""What engines' own loaders make of a robot file is read back rightly, and what they change is named by its kind."""

import contextlib
import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from pydantic import TypeAdapter

from plumbline.harness.adapter import Unsupported
from plumbline.harness.cli.main import main
from plumbline.harness.intake.import_wishes import Root, Wishes
from plumbline.harness.run.importer_audit import LoaderAnswer, loaded_apart, loader_answer
from plumbline.harness.scene.parity.canonical import Canonical, canonical, stated
from plumbline.harness.scene.parity.comparison import compare
from plumbline.harness.scene.parity.difference import Difference, kind_of
from plumbline.harness.scene.parity.loaded import Loaded, Request
from plumbline.harness.study import plugins
from tests.two_formats import MJCF, URDF

FROM_FILE = "URDF_USE_INERTIA_FROM_FILE"
DOUBLE = 1e-9
QUERIED = 1e-5
"""pybullet tells turns of frames in double precision, made from single ones: 6e-8 each, some tens of them in a chain."""


def loaded_here(engine: str, request: Request, path: Path) -> Loaded:
    """As `loaded_apart`, through the same text, in this process: for what a loader makes of a file, not for how it is started.

    A loader may change the folder that it works in.
    """
    with contextlib.chdir(path.parent):
        text = json.dumps(loader_answer(engine, path.resolve(), request))
    answer = TypeAdapter(LoaderAnswer).validate_json(text)
    if answer.loaded is None:
        raise Unsupported(answer.what, answer.why)
    return answer.loaded


def made(loaded: Loaded) -> Canonical:
    """The loader's robot in the form in which it is compared."""
    return canonical(loaded.robot, read_back=True)


@pytest.mark.parametrize(
    ("engine", "loader", "tolerance"), [("mujoco", "", DOUBLE), ("dart", "", DOUBLE), ("bullet", FROM_FILE, QUERIED)]
)
def test_a_sound_arm_is_read_as_it_is_stated(engine: str, loader: str, tolerance: float, tmp_path: Path) -> None:
    """Its facts are the file's, and the engine's own mass matrix is that of its facts; DART enforces no limits unless told."""
    pytest.importorskip({"bullet": "pybullet", "dart": "dartpy"}.get(engine, engine))
    path = tmp_path / "arm.urdf"
    path.write_text(URDF.replace('<axis xyz="1 1 0"/>', '<axis xyz="0.6 0.8 0"/>'))
    # One of them in a process of its own, as a person has them all.
    loaded = (loaded_apart if engine == "bullet" else loaded_here)(engine, Request(way=loader), path)
    assert loaded.matrix_gap is not None
    assert loaded.matrix_gap < tolerance
    rows = compare(stated(path, Wishes())[0], made(loaded), tolerance)
    limits = {("shoulder", "lower"), ("shoulder", "upper"), ("grip", "lower"), ("grip", "upper")}
    assert {(row.element, row.quantity) for row in rows} == (limits if engine == "dart" else set())


def test_mujoco_reads_its_own_format_as_it_is_stated(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    path = tmp_path / "arm.xml"
    path.write_text(MJCF)
    assert compare(stated(path, Wishes())[0], made(loaded_here("mujoco", Request(), path)), DOUBLE) == []


@pytest.mark.slow
def test_what_bullet_makes_of_the_arm_is_named_and_gated(tmp_path: Path) -> None:
    """Inertias are those of the shapes by its defaults, of which the arm has none; an axis of length 1.41 stays one.

    DART's limits, which are not enforced unless told to be, are documented, and so does nobody else's gate fail by them.
    """
    pytest.importorskip("pybullet")
    path, out = tmp_path / "arm.urdf", tmp_path / "out"
    path.write_text(URDF)
    result = CliRunner().invoke(main, ["parity", str(path), "--json", "--gate", "bullet", "--out", str(out)])
    assert result.exit_code == 1
    rows = [row for row in json.loads(result.stdout) if row["kind"]]
    assert {(row["loader"], row["kind"], bool(row["documented"])) for row in rows} == {
        ("bullet", "axis not normalised", False),
        ("bullet", "inertia replaced", True),
        (f"bullet {FROM_FILE}", "axis not normalised", False),
        ("dart", "limit ignored", True),
    }
    assert "What this engine&#39;s importer makes of your robot" in (out / "index.html").read_text()
    for engine in ("dart", "mujoco"):
        assert CliRunner().invoke(main, ["parity", str(path), "--gate", engine]).exit_code == 0, engine


@pytest.mark.parametrize(("engine", "tolerance"), [("mujoco", DOUBLE), ("dart", DOUBLE), ("bullet", QUERIED)])
def test_a_floating_root_and_a_mesh_of_a_package_reach_the_loaders(engine: str, tolerance: float, tmp_path: Path) -> None:
    """Without the package DART and pybullet refuse the file."""
    pytest.importorskip({"bullet": "pybullet", "dart": "dartpy"}.get(engine, engine))
    import trimesh

    (tmp_path / "elsewhere" / "meshes").mkdir(parents=True)
    trimesh.creation.box((0.2, 0.3, 0.4)).export(tmp_path / "elsewhere" / "meshes" / "box.stl")
    mesh = '<collision><geometry><mesh filename="package://stuff/meshes/box.stl"/></geometry></collision>'
    trunk = (
        '<inertial><origin xyz="0.1 0 0.2"/><mass value="4"/><inertia ixx="0.3" ixy="0" ixz="0" iyy="0.4" iyz="0" izz="0.5"/>'
    )
    text = URDF.replace('<axis xyz="1 1 0"/>', '<axis xyz="0.6 0.8 0"/>')
    text = text.replace('<link name="base"/>', f'<link name="base">{trunk}</inertial>{mesh}</link>')
    path = tmp_path / "robot" / "arm.urdf"
    path.parent.mkdir()
    path.write_text(text)
    packages = {"stuff": tmp_path / "elsewhere"}
    robot = stated(path, Wishes(root="floating", packages=packages))[0]
    assert robot.joints[0].kind == "free"
    request = Request(way=FROM_FILE if engine == "bullet" else "", root="floating", packages=packages)
    loaded = loaded_here(engine, request, path)
    assert loaded.notes == ()
    rows = compare(robot, made(loaded), tolerance)
    assert {row.quantity for row in rows} <= ({"lower", "upper"} if engine == "dart" else set())
    if engine == "bullet":
        with pytest.raises(Unsupported):
            loaded_here(engine, Request(way=FROM_FILE), path)


def test_a_loader_that_refuses_or_is_not_there_says_why(tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(MJCF)
    pytest.importorskip("dartpy")
    (tmp_path / "arm.sdf").write_text("<sdf/>")
    with pytest.raises(Unsupported, match="of URDF and MJCF alone are compared here"):
        loaded_apart("dart", Request(), tmp_path / "arm.sdf")
    with pytest.raises(Unsupported, match="no loader of its own"):
        plugins.adapter("reference").load_robot(path, Request())


@pytest.mark.parametrize(
    ("quantity", "stated", "loaded", "kind"),
    [
        ("damping", 0.3, 0.0, "damping dropped"),
        ("damping", 0.3, 0.1, "damping changed"),
        ("armature", 0.05, 0.0, "armature ignored"),
        ("upper", 1.5, None, "limit ignored"),
        ("lower", None, 0.0, "limit made up"),
        ("effort", 80.0, None, "effort ignored"),
        ("inertia", (1.0, 2.0, 2.5, 0.0, 0.0, 0.0), (2.0, 1.0, 2.5, 0.0, 0.0, 0.0), "rotation of the inertia lost"),
        ("inertia", (1.0, 2.0, 2.5, 0.3, 0.0, 0.0), (1.0, 2.0, 2.5, 0.0, 0.0, 0.0), "inertia made diagonal"),
        ("inertia", (1.0, 2.0, 2.5, 0.3, 0.0, 0.0), (0.1, 0.1, 0.1, 0.0, 0.0, 0.0), "inertia replaced"),
        ("axis", (0.0, 0.6, 0.8), (0.0, 1.2, 1.6), "axis not normalised"),
        ("axis", (0.0, 0.6, 0.8), (0.0, 0.8, 0.6), "axis changed"),
    ],
)
def test_a_change_has_its_kind(quantity: str, stated: object, loaded: object, kind: str) -> None:
    row = Difference(quantity=quantity, element="j", value_A=stated, value_B=loaded, unit="", tolerance=1e-5)  # type: ignore[arg-type]
    assert kind_of(row) == kind


def test_frames_without_a_mass_and_limits_of_continuous_joints_are_told_apart(tmp_path: Path) -> None:
    """A frame at the elbow's end weighs a kilogram on DART and Bullet; MuJoCo gives it none, as the file."""
    for module in ("mujoco", "dartpy", "pybullet"):
        pytest.importorskip(module)
    frame = '<link name="eye"/><joint name="mount" type="fixed"><parent link="fore"/><child link="eye"/></joint></robot>'
    limit = '<limit lower="-0.1" upper="0.1" effort="9" velocity="2"/>'
    text = URDF.replace("</robot>", frame).replace('<axis xyz="1 1 0"/>', f'<axis xyz="0.6 0.8 0"/>{limit}')
    path = tmp_path / "arm.urdf"
    path.write_text(text)
    robot = stated(path, Wishes())[0]

    def causes(engine: str, loader: str) -> set[tuple[str, float | str | tuple[float, ...] | None]]:
        rows = compare(robot, made(loaded_here(engine, Request(way=loader), path)), QUERIED)
        return {(row.quantity, row.absolute and round(row.absolute, 6)) for row in rows if row.quantity in ("mass", "lower")}

    assert causes("mujoco", "") == set()
    assert causes("dart", "") == {("mass", 1.0), ("lower", None)}  # those of the other joints, which it does not enforce
    assert causes("bullet", FROM_FILE) == {("mass", 1.0)}


BOX = (
    '<robot name="b"><link name="base"/><link name="arm"><inertial><mass value="1"/>'
    '<inertia ixx=".01" iyy=".02" izz=".015" ixy="0" ixz="0" iyz="0"/></inertial>'
    '<collision><geometry><box size=".1 .1 .1"/></geometry></collision></link>'
    '<joint name="j" type="{}"><parent link="base"/><child link="arm"/><axis xyz="1 2 3"/></joint></robot>'
)


@pytest.mark.parametrize("engine", ["mujoco", "dart"])
def test_a_planar_joint_is_the_same_whichever_directions_its_slides_have(engine: str, tmp_path: Path) -> None:
    """The engine's own mass matrix is that of two slides and a hinge across them."""
    pytest.importorskip({"dart": "dartpy"}.get(engine, engine))
    path = tmp_path / "planar.urdf"
    path.write_text(BOX.format("planar"))
    loaded = loaded_here(engine, Request(), path)
    assert [joint.name for joint in made(loaded).joints] == ["j.x", "j.y", "j.angle"]
    assert loaded.matrix_gap is not None
    assert loaded.matrix_gap < DOUBLE
    assert compare(stated(path, Wishes(root="fixed"))[0], made(loaded), DOUBLE) == []


def test_bullet_tells_no_axes_of_a_planar_joint(tmp_path: Path) -> None:
    pytest.importorskip("pybullet")
    path = tmp_path / "planar.urdf"
    path.write_text(BOX.format("planar"))
    with pytest.raises(Unsupported, match=r"joint 'j'.*no axes of a planar joint"):
        loaded_here("bullet", Request(), path)


@pytest.mark.parametrize(
    ("engine", "given"),
    [
        ("bullet", {"friction": 0.5, "torsional friction": 0.0, "rolling friction": 0.0, "restitution": 0.0}),
        ("bullet", {"motor that holds joints still, in a step by up to": 1.0, "damping of moving bodies": 0.04}),
        ("dart", {"friction": 1.0, "restitution": 0.0}),
        ("mujoco", {"friction": 1.0, "torsional friction": 0.005, "rolling friction": 1e-4, "contact margin": 0.0}),
    ],
)
def test_what_a_loader_gives_shapes_of_its_own_is_a_row_and_no_difference(
    engine: str, given: dict[str, float], tmp_path: Path
) -> None:
    """The numbers are those that each vendor documents as its defaults; Bullet's source has the damping and the motors.

    Source: Bullet, btMultiBody.cpp: m_linearDamping and m_angularDamping are .04. The motors: test_bullet_default_motors.
    """
    pytest.importorskip({"bullet": "pybullet", "dart": "dartpy"}.get(engine, engine))
    path = tmp_path / "box.urdf"
    path.write_text(BOX.format("continuous"))
    own = {each.quantity: each.values for each in loaded_here(engine, Request(), path).own}
    assert {quantity: own[quantity] for quantity in given} == {quantity: (value,) for quantity, value in given.items()}


@pytest.mark.parametrize("root", ["fixed", "floating"])
def test_what_bullet_adds_to_an_arm_is_measured_whether_its_root_moves_or_not(root: Root, tmp_path: Path) -> None:
    """Of three joints one after the other: no motion is left over from one to the next."""
    pytest.importorskip("pybullet")
    path = tmp_path / "arm.urdf"
    path.write_text(URDF)
    own = loaded_here("bullet", Request(way=FROM_FILE, root=root), path).own
    added = [(each.quantity.partition(" ")[0], each.values, each.unit) for each in own]
    assert added == [("motor", (1.0,), "N m s"), ("motor", (1.0,), "N s"), ("damping", (0.04,), "1/s")]


@pytest.mark.slow
def test_what_loaders_give_of_their_own_is_said_and_stands_in_the_json(tmp_path: Path) -> None:
    path = tmp_path / "box.urdf"
    path.write_text(BOX.format("continuous"))
    done = CliRunner().invoke(main, ["parity", str(path), "--root", "fixed"])
    assert "of its own, where the file has no word, it gives friction 1, " in done.output
    rows = json.loads(CliRunner().invoke(main, ["parity", str(path), "--root", "fixed", "--json"]).stdout)
    assert ("mujoco", "own value", "friction", 1.0) in {
        (row["loader"], row["kind"], row["element"], row["value_B"]) for row in rows if row["kind"] == "own value"
    }
