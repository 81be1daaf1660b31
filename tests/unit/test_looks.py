"""How a robot looks: meshes coarsened, colours, what a recording draws, and the pictures of a page."""

from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene import Box, Camera, TriangleMesh
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.scene.importers.looks import FACES, coarse
from plumbline.harness.scene.importers.meshes import Mesh
from plumbline.harness.scene.importers.reading import read
from plumbline.harness.store.imported_scenes import keep, looks_of, unsound
from plumbline.reports.recordings.runs import dressed
from tests.robot_files import INERTIAL, imported, row, urdf

VISUAL = (
    f'{INERTIAL}<visual><origin xyz="0 0 0.5"/><geometry><box size="0.2 0.4 0.6"/></geometry><material name="red"/></visual>'
    '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
)
RED = '<material name="red"><color rgba="1 0.5 0 1"/></material>'


def test_what_is_drawn_stands_beside_the_scene_and_not_in_it(tmp_path: Path) -> None:
    got = imported(tmp_path, urdf(RED, arm=VISUAL), looks=True)
    (placed,) = got.looks["arm"]
    assert placed.shape == Box(half_extents=(0.1, 0.2, 0.3))
    # The link's centre of mass is its origin.
    assert placed.p_BS == pytest.approx((0.0, 0.0, 0.5))
    body = got.scene.body("arm")
    assert body.visual is None
    # Colours of files are for screens: half of a screen's light is a fifth of the light.
    assert body.appearance.colour == pytest.approx((1.0, 0.5**2.2, 0.0))
    assert row(got, "visual").outcome == "exact"
    assert row(imported(tmp_path, urdf(RED, arm=VISUAL)), "visual").outcome == "left_out"


def test_a_camera_sees_how_the_robot_looks(tmp_path: Path) -> None:
    eye = Camera(name="eye", body="base", rate=10.0, width=8, height=8)
    got = imported(tmp_path, urdf(RED, arm=VISUAL, base=INERTIAL), Companion(root="fixed", sensors=(eye,)))
    assert got.scene.body("arm").visual == got.looks["arm"]


def test_a_mesh_that_is_not_there_is_told_and_nothing_else(tmp_path: Path) -> None:
    arm = VISUAL.replace('<box size="0.2 0.4 0.6"/>', '<mesh filename="../../outside.stl"/>')
    got = imported(tmp_path, urdf(RED, arm=arm), looks=True)
    assert got.looks == {}
    assert row(got, "visual").outcome == "left_out"


def wavy(n: int) -> Mesh:
    """A sheet of n x n vertices, 1 m wide."""
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    vertices = np.stack([u, v, 0.1 * np.sin(7 * u) * np.cos(5 * v)], axis=-1).reshape(-1, 3)
    k = np.arange(n * n).reshape(n, n)
    a, b, c, d = (part.ravel() for part in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    return Mesh(vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def test_a_fine_mesh_is_coarsened_to_what_a_picture_shows_and_says_by_how_much() -> None:
    """Vertices move within a cell, whose diagonal is sqrt(3) times its side; a sheet of 1 m keeps its area to a tenth."""
    mesh = wavy(120)
    made, off = coarse(mesh, "sheet")
    assert isinstance(made, TriangleMesh)
    assert FACES / 3 < len(made.faces) <= FACES
    assert 0 < off < 3**0.5 / 15
    points, faces = np.array(made.vertices), np.array(made.faces)
    sides = points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]]
    cells = wavy(120)
    p, f = cells.vertices, cells.faces
    true = np.linalg.norm(np.cross(p[f[:, 1]] - p[f[:, 0]], p[f[:, 2]] - p[f[:, 0]]), axis=1).sum()
    assert np.linalg.norm(np.cross(*sides), axis=1).sum() == pytest.approx(true, rel=0.1)


def test_a_small_mesh_is_drawn_as_it_is() -> None:
    made, off = coarse(wavy(10), "sheet")
    assert (len(made.faces), off) == (2 * 81, 0.0)


def test_looks_are_kept_with_the_import_sealed_and_dress_a_recording(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text(urdf(RED, arm=VISUAL))
    got = read(tmp_path / "robot.urdf", Wishes(root="fixed", looks=True))
    path = keep(tmp_path / "run", got)
    assert list(unsound(tmp_path / "run")) == []
    kept = looks_of(tmp_path / "run", f"scene:{path}")
    (placed,) = kept["arm"]
    assert placed["shape"] == {"type": "box", "half_extents": [0.1, 0.2, 0.3]}
    scene = dressed({"bodies": [{"name": "arm"}, {"name": "base"}]}, kept)
    assert scene["bodies"] == [{"name": "arm", "visual": kept["arm"]}, {"name": "base"}]
    assert looks_of(tmp_path / "run", "joint_pendulum") == {}
