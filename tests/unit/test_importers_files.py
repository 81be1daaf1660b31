"""Meshes and other files that robot files lead to: package paths, scale, formats, what is missing, what would lead outside."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull as Qhull

from plumbline.harness.intake.allowance import DEEPEST, Allowance, AllowanceError, allowing, raised
from plumbline.harness.intake.error import RobotError
from plumbline.harness.scene import ConvexHull
from plumbline.harness.scene.importers import mjcf as importer
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.scene.importers.meshes import MOST_CORNERS, load_mesh, simplified
from plumbline.harness.scene.importers.mjcf_model import Model, compile_apart
from plumbline.harness.scene.importers.mjcf_text import Prepared
from plumbline.harness.scene.importers.solids import of_mesh
from tests.mjcf_here import compiled_here
from tests.robot_files import INERTIAL, imported, mjcf, row, urdf

# A tetrahedron with corners at the origin and at 1, 2 and 3 along the axes: volume 1, centre at a quarter of each.
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=float)
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]


def stl(corners: np.ndarray = CORNERS) -> str:
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {' '.join(str(x) for x in corners[k])}\n" for k in face)
        + "endloop\nendfacet\n"
        for face in FACES
    )
    return f"solid t\n{facets}endsolid t\n"


def obj() -> str:
    return (
        "mtllib /etc/hostname\n"
        + "".join(f"v {a} {b} {c}\n" for a, b, c in CORNERS)
        + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in FACES)
    )


def dae() -> str:
    numbers = " ".join(str(x) for x in CORNERS.ravel())
    faces = " ".join(str(k) for face in FACES for k in face)
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        '<asset><up_axis>Z_UP</up_axis></asset><library_geometries><geometry id="g"><mesh>'
        f'<source id="s"><float_array id="a" count="12">{numbers}</float_array><technique_common><accessor source="#a" '
        'count="4" '
        'stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>'
        '</technique_common></source><vertices id="v"><input semantic="POSITION" source="#s"/></vertices>'
        f'<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles></mesh></geometry>'
        '</library_geometries><library_visual_scenes><visual_scene id="w"><node id="n"><instance_geometry url="#g"/></node>'
        '</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>'
    )


def with_mesh(filename: str, more: str = "") -> str:
    shape = f'<collision><geometry><mesh filename="{filename}" {more}/></geometry></collision>'
    return urdf(arm=INERTIAL + shape)


def extent(got: object) -> np.ndarray:
    (placed,) = got.scene.body("arm").collision  # type: ignore[attr-defined]
    assert isinstance(placed.shape, ConvexHull)
    corners = np.array(placed.shape.vertices)
    return np.array([corners.min(axis=0), corners.max(axis=0)])


@pytest.mark.parametrize(("name", "text"), [("t.stl", stl()), ("T.STL", stl()), ("t.obj", obj()), ("t.dae", dae())])
def test_each_format_is_read_whatever_the_case_of_its_ending(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    got = imported(tmp_path, with_mesh(name))
    assert extent(got) == pytest.approx(np.array([[0, 0, 0], [1, 2, 3]]))
    hull = row(got, "collision mesh")
    assert (hull.outcome, hull.becomes, hull.value) == ("approximated", "convex hull", pytest.approx(0, abs=1e-12))


def test_a_mesh_is_scaled_and_mirrored_with_its_faces_outwards(tmp_path: Path) -> None:
    (tmp_path / "t.stl").write_text(stl())
    assert extent(imported(tmp_path, with_mesh("t.stl", 'scale="0.001 -0.001 0.001"'))) == pytest.approx(
        np.array([[0, -2e-3, 0], [1e-3, 0, 3e-3]])
    )
    mirrored = load_mesh(tmp_path / "t.stl", np.array([1.0, -1.0, 1.0]), "here")
    assert mirrored.closed
    assert of_mesh(mirrored).mass == pytest.approx(1)
    with pytest.raises(RobotError, match="scale is '1 0 1', expected no zero"):
        imported(tmp_path, with_mesh("t.stl", 'scale="1 0 1"'))


def test_a_closed_mesh_has_the_volume_centre_and_inertia_of_its_solid(tmp_path: Path) -> None:
    (tmp_path / "t.stl").write_text(stl(CORNERS + np.array([5, 0, 0])))
    solid = of_mesh(load_mesh(tmp_path / "t.stl", np.ones(3), "here"))
    # Of a right tetrahedron with legs a, b, c: second moments a^2/10 V about its corner, products ab/20 V.
    a, b, c = 1.0, 2.0, 3.0
    second = np.array(
        [[a * a / 10, a * b / 20, a * c / 20], [a * b / 20, b * b / 10, b * c / 20], [a * c / 20, b * c / 20, c * c / 10]]
    )
    d = np.array([a, b, c]) / 4
    second -= np.outer(d, d)
    assert solid.mass == pytest.approx(1)
    assert solid.centre == pytest.approx(d + np.array([5, 0, 0]))
    assert solid.inertia == pytest.approx(np.trace(second) * np.eye(3) - second)


def test_a_package_is_found_where_the_user_says_and_told_where_it_is_not(tmp_path: Path) -> None:
    home, pack = tmp_path / "home", tmp_path / "pack"
    home.mkdir()
    (pack / "meshes").mkdir(parents=True)
    (pack / "meshes" / "t.stl").write_text(stl())
    text = with_mesh("package://robot_description/meshes/t.stl")
    lost = imported(home, text)
    assert not lost.scene.body("arm").collision
    assert lost.scene.body("arm").mass == 2
    assert "--package robot_description=DIR" in row(lost, "collision mesh").consequence
    assert extent(imported(home, text, packages={"robot_description": pack}))[1] == pytest.approx([1, 2, 3])
    # A path of the file's own may lead into a package that is named, and nowhere else.
    assert extent(imported(home, with_mesh("../pack/meshes/t.stl"), packages={"robot_description": pack}))[1][2] == 3
    with pytest.raises(RobotError, match=r"mesh filename is '../pack/meshes/t.stl', which leads out of"):
        imported(home, with_mesh("../pack/meshes/t.stl"))


@pytest.mark.parametrize("reference", ["gone.stl", "/etc/hostname", "/home/somebody/meshes/arm.stl"])
def test_a_missing_mesh_costs_contacts_and_nothing_else(tmp_path: Path, reference: str) -> None:
    """A path of another machine is as good as none: nothing is read there, and the file and its link are named."""
    got = imported(tmp_path, with_mesh(reference))
    lost = row(got, "collision mesh")
    assert (lost.outcome, lost.name) == ("left_out", "'arm'")
    assert lost.consequence.startswith(f"'{reference}': ")
    assert got.scene.body("arm").mass == 2


@pytest.mark.parametrize(
    "reference",
    [
        "../../etc/hostname",
        "file:///etc/hostname",
        "http://host/t.stl",
        "package://p/../../t.stl",
        "link.stl",
        "",
        "a\x01",
    ],
)
def test_no_reference_leads_out_of_the_folder(tmp_path: Path, reference: str) -> None:
    home = tmp_path / "home"
    (home / "p").mkdir(parents=True)
    (tmp_path / "t.stl").write_text(stl())
    (home / "link.stl").symlink_to(tmp_path / "t.stl")
    with pytest.raises(RobotError):
        imported(home, with_mesh(reference), packages={"p": home / "p"})


def test_a_companion_names_no_package_outside(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match="expected a folder beside the robot"):
        imported(tmp_path, urdf(), Companion(packages={"p": "/etc"}))


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("t.stl", "solid nothing\nendsolid", "no triangles|no mesh that can be read"),
        ("t.obj", "v 0 0 0\nf 1 2 999999\n", "no mesh that can be read|no triangles"),
        ("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "spans no volume"),
        ("t.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n", "not finite"),
        ("t.step", "anything", "format .step, expected one of .stl, .obj, .dae"),
        ("t.dae", '<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/hostname">]><COLLADA>&e;</COLLADA>', "DOCTYPE"),
    ],
)
def test_a_mesh_that_is_none_is_refused_with_its_line(tmp_path: Path, name: str, text: str, said: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(RobotError, match=said) as refused:
        imported(tmp_path, with_mesh(name))
    assert "line 3: <mesh>" in str(refused.value) or "<collision>: mesh filename" in str(refused.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('<!DOCTYPE robot [<!ENTITY a "b">]><robot name="r"><link name="&a;"/></robot>', "<!DOCTYPE> 'robot'"),
        ('<!DOCTYPE robot SYSTEM "file:///etc/passwd"><robot name="r"><link name="a"/></robot>', "<!DOCTYPE>"),
        ('<robot name="r"><link name="&a;"/></robot>', "no well-formed XML"),
        ('<robot name="r">' + "<a>" * 70, "elements in each other, expected at most 64; --limit depth=VALUE"),
        ("", "no well-formed XML"),
        ("\x00", "no well-formed XML"),
    ],
)
def test_xml_with_entities_or_beyond_a_limit_is_refused(tmp_path: Path, text: str, said: str) -> None:
    for name in ("robot.urdf", "robot.xml"):
        with pytest.raises(RobotError, match=said):
            imported(tmp_path, text, name=name)


def test_limits_are_named_and_can_be_raised(tmp_path: Path) -> None:
    many = urdf(
        *(
            f'<link name="l{k}"/><joint name="k{k}" type="fixed"><parent link="arm"/><child link="l{k}"/></joint>'
            for k in range(20)
        )
    )
    with (
        allowing(["bodies=10"], "here"),
        pytest.raises(RobotError, match="22 bodies, expected at most 10; --limit bodies=VALUE"),
    ):
        imported(tmp_path, many)
    with allowing(["parts=20"], "here"), pytest.raises(RobotError, match="--limit parts=VALUE"):
        imported(tmp_path, many)
    with allowing(["bytes=100"], "here"), pytest.raises(RobotError, match="--limit bytes=VALUE"):
        imported(tmp_path, many)
    (tmp_path / "t.stl").write_text(stl())
    with allowing(["vertices=3"], "here"), pytest.raises(RobotError, match="--limit vertices=VALUE"):
        imported(tmp_path, with_mesh("t.stl"))


MESH_BODY = '<joint/><geom type="mesh" mesh="t"/>'


@pytest.mark.parametrize(
    ("beside", "said"),
    [
        ('<include file="/etc/hostname"/>', "leads out of"),
        ('<include file="../robot.xml"/>', "leads out of"),
        ('<include file="gone.xml"/>', "there is no such file"),
        ('<include file="robot.xml"/>', "included already"),
        ('<asset><mesh name="t" file="/etc/t.stl"/></asset>', "leads out of"),
        ('<asset><mesh name="t" file="gone.stl"/></asset>', "there is no such file; mass may depend on it"),
        ('<asset><mesh name="t" file="t.ply"/></asset>', "expected an ending among .stl, .obj, .msh"),
        (
            '<default><default class="leg"/></default><worldbody><body childclass="legs"/></worldbody>',
            "childclass is 'legs', expected",
        ),
        ('<compiler meshdir="/etc"/><asset><mesh name="t" file="t.stl"/></asset>', "leads out of"),
        ('<asset><model name="x" file="robot.xml"/></asset>', "a model in a model"),
        ('<size memory="nan"/>', "memory is 'nan', expected finite numbers"),
    ],
)
def test_no_file_of_an_mjcf_leads_outside_or_is_missing_in_silence(tmp_path: Path, beside: str, said: str) -> None:
    (tmp_path / "t.ply").write_text("ply")
    with pytest.raises(RobotError, match=said):
        imported(tmp_path, mjcf(MESH_BODY, beside))


@pytest.mark.usefixtures("mjcf_here")
def test_an_mjcf_reads_includes_and_meshes_of_its_own_folder(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "t.OBJ").write_text(obj())
    (tmp_path / "assets.xml").write_text(
        '<mujocoinclude><compiler meshdir="parts"/><asset><mesh file="t.OBJ" scale="2 2 2"/></asset></mujocoinclude>'
    )
    got = imported(tmp_path, mjcf(MESH_BODY, '<include file="assets.xml"/>'))
    body = got.scene.body("arm")
    # Eight times the volume of 1 m3 at MuJoCo's own 1000 kg/m3, in single precision.
    assert body.mass == pytest.approx(8000, rel=1e-6)
    corners = np.array(body.collision[0].shape.vertices)  # type: ignore[union-attr]
    assert np.ptp(corners, axis=0).max() > 4


def test_an_error_of_the_compiler_is_told_with_the_line_of_the_file(tmp_path: Path) -> None:
    text = mjcf('<joint/>\n<geom size=".1"/>\n<wobbly/>')
    with pytest.raises(RobotError, match=r"robot.xml: line 6: <wobbly>: MuJoCo's compiler refuses it:.*unrecognized element"):
        imported(tmp_path, text)


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        ('<joint/>\n<gem size=".1"/>', r"expected one of .*geom, .*body, frame, replicate; did you mean <geom>\?$"),
        ('<geom size=".1"/>\n<body><geom size=".1"/>\n<joint dampng="1"/></body>', r"damping, .*; did you mean damping\?$"),
        ('<geom size=".1"/>\n<frame><gem size=".1"/></frame>', r"line 5: <gem>: .*of inertial, .*; did you mean <geom>\?$"),
        ('<geom size=".1"/>\n<geom sise=".1"/>', r"expected one of .*size, .*; did you mean size\?$"),
        ('<geom size="x"/>', r"bad format in attribute 'size' Element 'geom'$"),
    ],
)
@pytest.mark.usefixtures("mjcf_here")
def test_what_the_compiler_does_not_know_is_told_with_what_it_does(tmp_path: Path, inside: str, words: str) -> None:
    with pytest.raises(RobotError, match=words):
        imported(tmp_path, mjcf(inside))


def test_a_process_of_its_own_leaves_what_the_compiler_leaves_in_this_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A model to the bit, and a refusal to the letter: most tests compile in theirs."""
    left: list[Model] = []

    def twice(text: Prepared, file: str) -> Model:
        ways = (compile_apart, compiled_here)
        try:
            left.extend(way(text, file) for way in ways)
        except RobotError as refused:
            with pytest.raises(RobotError, match=f"^{re.escape(str(refused))}$"):
                compiled_here(text, file)
            raise
        return left[0]

    monkeypatch.setattr(importer, "compile_apart", twice)
    imported(tmp_path, mjcf('<joint name="j"/><geom size=".1"/>', '<actuator><motor joint="j"/></actuator>'))
    apart, here = left
    assert (apart.names, apart.enums, apart.version) == (here.names, here.enums, here.version)
    assert apart.arrays.keys() == here.arrays.keys()
    for name, array in apart.arrays.items():
        np.testing.assert_array_equal(array, here.arrays[name], err_msg=name)
    with pytest.raises(RobotError, match="MuJoCo's compiler refuses it"):
        imported(tmp_path, mjcf('<joint name="j"/><joint name="j"/><geom size=".1"/>'))


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        (
            '<frame>\n<joint dampng="1"/></frame>',
            "line 5: <joint>: attribute 'dampng' is unknown, .*; did you mean damping\\?$",
        ),
        ('<frame><body><geom size=".1"/><joint dampng="1"/></body></frame>', "<joint>: attribute 'dampng' .* mean damping\\?$"),
        ('<frame poss="0 0 1"/>', "<frame>: attribute 'poss' is unknown, expected one of childclass, .*; did you mean pos\\?$"),
        ('<replicate count="2" sip="-"><site name="a"/></replicate>', "attribute 'sip' is unknown, .*; did you mean sep\\?$"),
        ('<replicate count="2"><geom sise=".1" size=".1"/></replicate>', "attribute 'sise' is unknown, .* mean size\\?$"),
    ],
)
@pytest.mark.usefixtures("mjcf_here")
def test_what_the_compiler_passes_over_in_a_frame_is_refused(tmp_path: Path, inside: str, words: str) -> None:
    with pytest.raises(RobotError, match=words):
        imported(tmp_path, mjcf(f'<geom size=".1"/>{inside}'))


@pytest.mark.usefixtures("mjcf_here")
def test_a_sound_frame_is_read(tmp_path: Path) -> None:
    framed = '<frame name="f" pos="0 0 1" euler="0 0 1"><geom size=".1"/><frame quat="1 0 0 0"><site name="s"/></frame></frame>'
    copies = '<replicate count="2" offset="1 0 0"><geom size=".1"/></replicate>'
    got = imported(tmp_path, mjcf(f'<joint/><geom size=".1"/>{framed}{copies}'))
    assert len(got.scene.body("arm").collision) == 4


def lumps(count: int) -> np.ndarray:
    """Points on an ellipsoid of 0.1, 0.12 and 0.08 m."""
    points = np.random.default_rng(1).normal(size=(count, 3))
    return points * np.array([0.1, 0.12, 0.08]) / np.linalg.norm(points, axis=1)[:, None]


def test_a_hull_of_many_corners_gets_fewer_and_says_how_far_off_it_is(tmp_path: Path) -> None:
    points = lumps(2000)
    faces = Qhull(points).simplices
    text = "".join(f"v {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in points)
    (tmp_path / "t.obj").write_text(text + "".join(f"f {a} {b} {c}\n" for a, b, c in faces + 1))
    got = imported(tmp_path, with_mesh("t.obj"))
    (placed,) = got.scene.body("arm").collision
    assert isinstance(placed.shape, ConvexHull)
    kept = np.array(placed.shape.vertices)
    assert len(kept) == MOST_CORNERS
    planes = Qhull(kept).equations
    outside = float((points @ planes[:, :3].T + planes[:, 3]).max())
    told = row(got, "collision hull")
    assert (told.outcome, told.value) == ("approximated", pytest.approx(outside))
    # A cap of a sphere of radius r that n points share is as high as 2 r / n; a few times that where they lie unevenly.
    assert 0 < outside < 10 * 2 * 0.12 / MOST_CORNERS
    few = ConvexHull(vertices=points[:100].tolist())
    assert simplified(few) == (few, 0.0)


def test_meshes_may_hold_more_than_scenes_and_more_bytes_allow_more_of_them(tmp_path: Path) -> None:
    plain, more = Allowance(), raised(["bytes=4e8"], "here")
    assert plain.meshes == 64_000_000
    assert (more.meshes, more.vertices) == (400_000_000, 16_000_000)
    assert raised(["bytes=4e8", "vertices=7"], "here").vertices == 7
    for name in ("a.stl", "b.stl"):
        (tmp_path / name).write_text(stl())
    size = (tmp_path / "a.stl").stat().st_size
    two = "".join(f'<collision><geometry><mesh filename="{name}.stl"/></geometry></collision>' for name in "ab")
    with allowing([f"meshes={2 * size - 1}"], "here"), pytest.raises(RobotError, match="bytes of all meshes, expected at most"):
        imported(tmp_path, urdf(arm=INERTIAL + two))
    with allowing([f"meshes={2 * size}"], "here"):
        assert len(imported(tmp_path, urdf(arm=INERTIAL + two)).scene.body("arm").collision) == 2


def test_as_many_levels_as_may_be_allowed_are_read_and_more_may_not_be_allowed(tmp_path: Path) -> None:
    """MuJoCo's own parser takes 500 levels; those of a file's readers are calls in each other."""
    chain = "".join(f'<body pos="0 0 1"><joint name="k{k}" axis="0 1 0"/><geom size=".1"/>' for k in range(DEEPEST - 4))
    text = mjcf('<geom size=".1"/>', world=chain + "</body>" * (DEEPEST - 4))
    with allowing([f"depth={DEEPEST}"], "here"):
        assert len(imported(tmp_path, text).scene.joints) == DEEPEST - 4
    with pytest.raises(AllowanceError, match=f"depth is '{DEEPEST + 1}', expected a whole number from 1 to {DEEPEST}"):
        raised([f"depth={DEEPEST + 1}"], "here")
