"""Scene files: whatever can be said in a scene survives TOML and JSON, and whatever is broken is refused by name."""

import json
import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plumbline.harness.scene import (
    Ball,
    Body,
    Box,
    Camera,
    Capsule,
    ConvexHull,
    Cylinder,
    DepthCamera,
    Distance,
    Drive,
    Effect,
    Ellipsoid,
    Fixed,
    Imu,
    ImuNoise,
    Lidar,
    LidarNoise,
    Limits,
    PlacedShape,
    Plane,
    Prismatic,
    Revolute,
    Scene,
    SceneError,
    Sphere,
    Spring,
    StereoNoise,
    StructuredLightNoise,
    Surface,
    TimeOfFlightNoise,
    TriangleMesh,
    axis_angle,
    principal_inertia,
)
from plumbline.harness.scene.file import dump_json, dump_toml, load, parse, schema
from tests.conftest import Command

finite = st.floats(-1e6, 1e6)
positive = st.floats(1e-6, 1e6)
shares = st.floats(0, 1)
vectors = st.tuples(finite, finite, finite)
directions = vectors.filter(lambda v: math.hypot(*v) > 1e-3)
turns = st.builds(axis_angle, directions, st.floats(-3.0, 3.0))
TETRAHEDRON = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
shapes = st.one_of(
    st.builds(Sphere, radius=positive),
    st.builds(Box, half_extents=st.tuples(positive, positive, positive)),
    st.builds(Capsule, radius=positive, half_length=positive),
    st.builds(Cylinder, radius=positive, half_length=positive),
    st.builds(Ellipsoid, semi_axes=st.tuples(positive, positive, positive)),
    st.just(ConvexHull(vertices=TETRAHEDRON)),
    st.just(TriangleMesh(vertices=TETRAHEDRON, faces=FACES)),
)
placed = st.builds(PlacedShape, shape=shapes, p_BS=vectors, q_BS=turns)
names = st.text(st.characters(codec="utf-8", categories=("L", "N", "P", "S")), min_size=1, max_size=12).filter(
    lambda text: text not in {"world", "floor"}
)
limits = st.one_of(st.none(), st.builds(Limits, lower=st.floats(-2, 0) | st.none(), upper=st.floats(0, 2) | st.none()))
springs = st.none() | st.builds(Spring, stiffness=st.floats(0, 1e4), damping=st.floats(0, 10), rest=finite)
drives = st.none() | st.builds(Drive, stiffness=st.floats(0, 1e4), target=finite, limit=positive | st.none())

depth_noises = st.one_of(
    st.none(),
    st.builds(StereoNoise, baseline=positive, disparity_sigma=st.floats(0, 2), missing=shares),
    st.builds(StructuredLightNoise, baseline=positive, disparity_step=st.floats(0, 1), least_signal=st.floats(0, 9)),
    st.builds(TimeOfFlightNoise, range_sigma=st.floats(0, 1), unambiguous_range=positive, multipath=shares),
)


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    bodies = [
        Body(
            name=name,
            mass=draw(positive),
            inertia=principal_inertia(2.0, 3.0, draw(st.floats(1.0, 5.0))),
            collision=tuple(draw(st.lists(placed, max_size=3))),
            visual=draw(st.none() | st.just(())),
            material=draw(st.sampled_from(("wood", "steel"))),
            p_WB=draw(vectors),
            q_WB=draw(turns),
            v_WB=draw(vectors),
            w_WB=draw(vectors),
            linear_damping=draw(st.floats(0, 10)),
        )
        for name in draw(st.lists(names, min_size=2, max_size=4, unique=True))
    ]
    ground = Body(name="floor", motion="static", collision=(PlacedShape(shape=Plane()),), material="stone")
    materials = ("steel", "stone", "wood")
    surfaces = tuple(
        Surface(between=(a, b), static_friction=0.5, kinetic_friction=draw(st.floats(0, 0.5)), restitution=draw(shares))
        for i, a in enumerate(materials)
        for b in materials[i:]
    )
    a, b = bodies[0].name, bodies[1].name
    anchor, axis = draw(vectors), draw(directions)
    joints = (
        Fixed(name="fixed", parent=a, child=b),
        Ball(name="ball", parent="world", child=a, anchor_W=anchor),
        Revolute(name="revolute", parent=a, child=b, anchor_W=anchor, axis_W=axis, limits=draw(limits), drive=draw(drives)),
        Prismatic(name="prismatic", parent=a, child=b, anchor_W=anchor, axis_W=axis, spring=draw(springs)),
        Distance(name="distance", parent=a, child=b, anchor_W=(0, 0, 0), child_anchor_W=(0, 0, 1), spring=draw(springs)),
    )
    sensors = (
        Imu(name="imu", body=a, rate=100.0, noise=draw(st.none() | st.just(ImuNoise()))),
        Lidar(name="lidar", body="world", rate=10.0, noise=LidarNoise(dropout=draw(shares))),
        Camera(name="camera", body=b, rate=30.0),
        DepthCamera(name="depth", body=b, rate=30.0, noise=draw(depth_noises)),
    )
    return Scene(
        bodies=(*bodies, ground),
        joints=joints,
        surfaces=surfaces,
        sensors=sensors,
        gravity=draw(vectors),
        widen=draw(st.sampled_from((Effect.NONE, Effect.CONTINUOUS_COLLISION))),
        narrow=draw(st.sampled_from((Effect.NONE, Effect.FRICTION | Effect.GYROSCOPIC))),
    )


@pytest.mark.parametrize("count", [20, pytest.param(200, marks=pytest.mark.slow)])
def test_a_scene_survives_toml_and_json_bit_for_bit(count: int) -> None:
    settings(max_examples=count, deadline=None)(given(scenes())(survives))()


def survives(scene: Scene) -> None:
    assert parse(dump_toml(scene), "scene.toml") == scene
    assert parse(dump_json(scene), "scene.json") == scene


SOUND = """
[[bodies]]
name = "ball"
mass = 1.0
inertia = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
material = "rubber"
[[bodies.collision]]
shape = { type = "sphere", radius = 0.1 }
[[bodies]]
name = "ground"
motion = "static"
material = "floor"
[[bodies.collision]]
shape = { type = "plane" }
[[joints]]
type = "revolute"
name = "hinge"
parent = "world"
child = "ball"
anchor_W = [0.0, 0.0, 1.0]
axis_W = [0.0, 1.0, 0.0]
[[surfaces]]
between = ["rubber", "floor"]
static_friction = 0.5
kinetic_friction = 0.5
restitution = 0.5
"""

BROKEN = {
    "negative mass": ("mass = 1.0", "mass = -1.0", ("bodies[0] 'ball'", "mass", "-1.0")),
    "nan": ("mass = 1.0", "mass = nan", ("bodies[0] 'ball'", "mass", "nan")),
    "infinity": ("radius = 0.1", "radius = inf", ("'ball'", "radius", "inf")),
    "triangle inequality": ("[0.0, 0.0, 1.0]]", "[0.0, 0.0, 5.0]]", ("body 'ball'", "inertia", "triangle inequality")),
    "zero axis": ("axis_W = [0.0, 1.0, 0.0]", "axis_W = [0.0, 0.0, 0.0]", ("joints[0] 'hinge'", "axis_W", "zero")),
    "negative friction": ("kinetic_friction = 0.5", "kinetic_friction = -0.5", ("surfaces[0]", "kinetic_friction", "-0.5")),
    "restitution above one": ("restitution = 0.5", "restitution = 1.5", ("surfaces[0]", "restitution", "1.5")),
    "duplicate name": ('name = "ground"', 'name = "ball"', ("body 'ball'", "name", "2 times")),
    "unknown field": ("mass = 1.0", "mas = 1.0", ("bodies[0] 'ball'", "mas")),
    "unknown shape": ('type = "sphere"', 'type = "spere"', ("bodies[0] 'ball'", "shape", "spere")),
    "broken limits": (
        "axis_W = [0.0, 1.0, 0.0]",
        "axis_W = [0.0, 1.0, 0.0]\nlimits = { lower = nan }",
        ("joints[0] 'hinge' > limits > lower", "nan"),
    ),
    "broken sphere": ("radius = 0.1", "radius = -0.1", ("bodies[0] 'ball' > collision[0] > shape > radius", "-0.1")),
    "no toml": ("mass = 1.0", "mass = = 1.0", ("not readable",)),
}


def test_the_sound_file_is_accepted() -> None:
    assert parse(SOUND, "scene.toml").effects


@pytest.mark.parametrize("fault", BROKEN)
def test_a_broken_file_is_refused_naming_file_element_field_and_value(fault: str, tmp_path: Path) -> None:
    before, after, words = BROKEN[fault]
    assert before in SOUND
    path = tmp_path / "scene.toml"
    path.write_text(SOUND.replace(before, after, 1))
    with pytest.raises(SceneError) as caught:
        load(path)
    for word in (str(path), *words):
        assert word in str(caught.value)


@pytest.mark.parametrize("fault", BROKEN)
def test_the_command_line_refuses_a_broken_scene_before_any_engine_and_writes_nothing(
    fault: str, tmp_path: Path, printed: Command
) -> None:
    before, after, words = BROKEN[fault]
    path = tmp_path / "scene.toml"
    path.write_text(SOUND.replace(before, after, 1))
    done = printed("run", path, "--out", tmp_path / "out")
    assert done.returncode == 2, done.stderr
    for word in words:
        assert word in done.stderr
    assert not (tmp_path / "out").exists()


def test_the_schema_accepts_what_the_reader_accepts() -> None:
    import jsonschema

    jsonschema.validate(json.loads(dump_json(parse(SOUND, "scene.toml"))), schema())


def test_a_scene_of_the_users_own_is_carried_by_an_engine_and_shown(tmp_path: Path, printed: Command) -> None:
    path = tmp_path / "ball.toml"
    path.write_text(SOUND.partition("[[joints]]")[0] + "[[surfaces]]" + SOUND.partition("[[surfaces]]")[2])
    done = printed("run", path, "--engine", "mujoco", "--duration", "1", "--budget", "20", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    rows = json.loads(printed("show", tmp_path / "out", "--format", "json").stdout)
    assert {row["status"] for row in rows} == {"passed"}
    for track in ("default", "tuned"):
        steps = {row["dt"] for row in rows if row["experiment"] == "ladder" and row["track"] == track}
        assert {1 / 240, 1 / 480, 1 / 960} <= steps, track  # and as many more as there is time for
    assert "Audit:" in done.stderr  # does it call for what it needs?
    page = Path(done.stdout.strip().splitlines()[-1])  # the page of the scene, whose first screen has the answers
    assert page.parent == tmp_path / "out" / "report"
    assert "Who is off, and why?" in page.read_text()
