"""A mesh that is not convex is taken apart on request, and what is left of its hollow is told."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from harness.intake.import_wishes import Wishes
from harness.scene.importers.decomposition import pieces_of
from harness.scene.importers.meshes import load_mesh
from harness.scene.importers.reading import read


def angle(path: Path) -> None:
    """An L of volume 3, whose hull has 3.5."""
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    vertices = np.array([(x, y, z) for z in (0, 1) for x, y in outline], dtype=float)
    top = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [(a, c, b) for a, b, c in top] + [(a + 6, b + 6, c + 6) for a, b, c in top]
    for i in range(6):
        j = (i + 1) % 6
        faces += [(i, j, j + 6), (i, j + 6, i + 6)]
    trimesh.Trimesh(vertices, faces, process=False).export(path)


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
