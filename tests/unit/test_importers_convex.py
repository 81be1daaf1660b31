"""A mesh that is not convex is taken apart on request, and what is left of its hollow is told."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from plumbline.harness.conformance.checks.contact.resting import GIVES
from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene import Body, PlacedShape, Sphere, Surface, TriangleMesh, sphere_inertia
from plumbline.harness.scene.importers.decomposition import in_pieces, pieces_of
from plumbline.harness.scene.importers.meshes import load_mesh
from plumbline.harness.scene.importers.reading import read
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import State


def angle_mesh(size: float = 1.0) -> tuple[np.ndarray, list[tuple[int, int, int]]]:
    """Vertices and faces of an L of volume 3 size^3, whose hull has 3.5."""
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    vertices = np.array([(x, y, z) for z in (0, 1) for x, y in outline], dtype=float) * size
    top = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [(a, c, b) for a, b, c in top] + [(a + 6, b + 6, c + 6) for a, b, c in top]
    for i in range(6):
        j = (i + 1) % 6
        faces += [(i, j, j + 6), (i, j + 6, i + 6)]
    return vertices, faces


def angle(path: Path) -> None:
    """A file of that L."""
    trimesh.Trimesh(*angle_mesh(), process=False).export(path)


@pytest.mark.parametrize(("convex", "pieces", "excess", "slack"), [(None, 1, 3.5 / 3 - 1, 1e-6), (4, 2, 0.0, 1e-3)])
def test_pieces_replace_the_hull_and_say_what_they_add(
    convex: int | None, pieces: int, excess: float, slack: float, tmp_path: Path
) -> None:
    """CoACD cuts between samples of its own: a thousandth of the volume is left to it."""
    if convex is not None:
        pytest.importorskip("coacd")
    angle(tmp_path / "l.stl")
    path = tmp_path / "l.urdf"
    path.write_text(
        '<robot name="l"><link name="l"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
        '</inertial><collision><geometry><mesh filename="l.stl"/></geometry></collision></link></robot>'
    )
    imported = read(path, Wishes(root="floating", convex=convex))
    (body,) = imported.scene.bodies
    assert len(body.collision) == pieces
    (row,) = [row for row in imported.fidelity if row.element == "collision mesh"]
    assert row.outcome == "approximated"
    assert row.value == pytest.approx(excess, abs=slack)
    assert ("CoACD" in row.becomes) == (convex is not None)


def test_pieces_are_worked_out_once_whatever_becomes_of_what_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("coacd")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    angle(tmp_path / "l.stl")
    mesh = load_mesh(tmp_path / "l.stl", np.ones(3), "here")
    told: list[str] = []
    first = pieces_of(mesh, 4, "here", told.append)
    (kept,) = (tmp_path / "cache" / "plumbline" / "pieces").iterdir()
    again = pieces_of(mesh, 4, "here", told.append)
    assert again == first
    assert told == [f"here: {len(mesh.faces)} faces are taken apart into convex pieces, once on this machine"]
    for broken in (b"", b"no archive", kept.read_bytes()[:-40]):
        kept.write_bytes(broken)
        assert pieces_of(mesh, 4, "here", told.append) == first
    assert len(told) == 4
    scaled = load_mesh(tmp_path / "l.stl", np.array([1.0, 1.0, 2.0]), "here")
    assert pieces_of(scaled, 4, "here", None)[1] == pytest.approx(2 * first[1], rel=5e-3)


SCENE = """
[[bodies]]
name = "ground"
motion = "static"
material = "ground"
[[bodies.collision]]
shape = { type = "plane" }

[[bodies]]
name = "angle"
mass = 3.0
inertia = [[0.011, -0.005, 0.0], [-0.005, 0.011, 0.0], [0.0, 0.0, 0.016]]
material = "angle"
p_WB = [0.083, 0.083, 0.051]
[[bodies.collision]]
p_BS = [-0.083, -0.083, -0.05]
shape = { type = "triangle_mesh", vertices = VERTICES, faces = FACES }

[[surfaces]]
between = ["ground", "angle"]
static_friction = 0.5
kinetic_friction = 0.5
"""


def angle_scene(path: Path) -> None:
    """That L, 20 cm by 20 cm by 10 cm, let go 1 mm above a plane."""
    vertices, faces = angle_mesh(0.1)
    path.write_text(SCENE.replace("VERTICES", str(vertices.tolist())).replace("FACES", str([list(face) for face in faces])))


def test_a_mesh_of_a_scene_in_pieces_moves_on_every_engine(tmp_path: Path) -> None:
    """A ball falls past an L that lies on a plane, into its notch, where the hull would hold it.

    The pieces are drawn as the mesh, stand where it stands, and have its volume but for a thousandth, as above. Contacts give
    way by what the checks of rest allow an engine; the hull would hold the ball ten centimetres higher.
    """
    pytest.importorskip("coacd")
    angle_scene(tmp_path / "angle.toml")
    whole = read(tmp_path / "angle.toml").scene
    got = read(tmp_path / "angle.toml", Wishes(convex=4))
    (before, after) = (scene.bodies[1] for scene in (whole, got.scene))
    assert [placed.shape.type for placed in after.collision] == ["convex_hull"] * 2
    assert {(placed.p_BS, placed.q_BS) for placed in after.collision} == {(before.collision[0].p_BS, before.collision[0].q_BS)}
    assert after.visual == before.collision
    (row,) = got.fidelity
    assert (row.element, row.name, row.outcome) == ("collision mesh", "'angle'", "approximated")
    assert row.value == pytest.approx(0.0, abs=1e-3)
    ball = Body(
        name="ball", mass=0.1, inertia=sphere_inertia(0.1, 0.02), material="ball", p_WB=(0.135, 0.135, 0.14),
        collision=(PlacedShape(shape=Sphere(radius=0.02)),),
    )  # fmt: skip
    laws = (Surface(between=("ball", "ground")), Surface(between=("ball", "angle")))
    for engine in ("reference", "mujoco", "bullet", "dart"):
        adapter = plugins.adapter(engine)
        scene = replace(got.scene, bodies=(*got.scene.bodies, ball), surfaces=(*got.scene.surfaces, *laws))
        simulation = adapter.build(scene, adapter.tracks["tuned"].with_dt(1 / 480))
        simulation.step(240)
        state = State.initial(scene)
        simulation.state(state)
        simulation.close()
        assert state.p_WB[2, 2] == pytest.approx(0.02, abs=GIVES), engine
        assert state.p_WB[1] == pytest.approx((0.083, 0.083, 0.05), abs=GIVES), engine


def test_an_open_mesh_of_a_scene_stays_what_it_is(tmp_path: Path) -> None:
    angle_scene(tmp_path / "angle.toml")
    scene = read(tmp_path / "angle.toml").scene
    shape = scene.bodies[1].collision[0].shape
    assert isinstance(shape, TriangleMesh)
    torn = replace(scene.bodies[1].collision[0], shape=replace(shape, faces=shape.faces[1:]))
    opened = replace(scene, bodies=(scene.bodies[0], replace(scene.bodies[1], motion="static", collision=(torn,))))
    assert in_pieces(opened, 4, "here") == (opened, [])
