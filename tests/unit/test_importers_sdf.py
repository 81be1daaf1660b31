"""What an SDF says: links and joints in frames of their own, nested models, surfaces, sensors, and what is refused."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene import Camera, DepthCamera, Imu, Lidar, Prismatic, Revolute, rotate
from plumbline.harness.scene.importers.companion import Companion, Ground
from plumbline.harness.scene.importers.imported import Imported
from plumbline.harness.scene.importers.reading import read
from plumbline.harness.scene.parity.canonical import pair_of
from plumbline.harness.scene.parity.comparison import compare
from tests.robot_files import row
from tests.two_formats import URDF

INERTIAL = "<inertial><mass>2</mass><inertia><ixx>.02</ixx><iyy>.03</iyy><izz>.04</izz></inertia></inertial>"

ARM = """<sdf version="1.9"><model name="arm">
<link name="base"/>
<joint name="root" type="fixed"><parent>world</parent><child>base</child></joint>
<link name="upper"><pose relative_to="shoulder"/>
<inertial><pose>0.02 0.01 0.2 0.3 -0.4 0.5</pose><mass>3</mass>
<inertia><ixx>0.05</ixx><ixy>0.002</ixy><ixz>-0.001</ixz><iyy>0.06</iyy><iyz>0.003</iyz><izz>0.02</izz></inertia></inertial></link>
<link name="motor"><pose relative_to="bolt"/><inertial><pose>0.05 0 0 0.2 0.1 0</pose><mass>1.5</mass>
<inertia><ixx>0.002</ixx><iyy>0.004</iyy><izz>0.005</izz></inertia></inertial></link>
<frame name="tip" attached_to="motor"><pose relative_to="motor">0 0.1 0.1 0 0 0</pose></frame>
<link name="fore"><pose relative_to="tip" degrees="true">0 0 0 -28.64788975654116 0 11.459155902616466</pose><inertial>
<pose>0 0.03 0.15 0 0 0</pose><mass>2</mass>
<inertia><ixx>0.03</ixx><ixz>0.001</ixz><iyy>0.025</iyy><izz>0.01</izz></inertia></inertial></link>
<link name="finger"><pose relative_to="fore">0 0 0.3 0 0 0</pose><inertial><mass>0.4</mass>
<inertia><ixx>0.0006</ixx><iyy>0.0005</iyy><izz>0.0004</izz></inertia></inertial></link>
<joint name="shoulder" type="revolute"><pose relative_to="base">0 0 0.5 0 0.3 0</pose><parent>base</parent><child>upper</child>
<axis><xyz>0 1 0</xyz><limit><lower>-2</lower><upper>1.5</upper><effort>80</effort><velocity>3</velocity></limit>
<dynamics><damping>0.7</damping><friction>0.2</friction></dynamics></axis></joint>
<joint name="bolt" type="fixed"><pose relative_to="upper">0.1 0 0.3 0.4 1.2 -0.3</pose><parent>upper</parent>
<child>motor</child></joint>
<joint name="elbow" type="continuous"><parent>motor</parent><child>fore</child><axis><xyz expressed_in="fore">1 1 0</xyz>
<dynamics><damping>0.3</damping></dynamics></axis></joint>
<joint name="grip" type="prismatic"><parent>fore</parent><child>finger</child><axis><xyz>0 0 1</xyz>
<limit><lower>-0.02</lower><upper>0.05</upper><effort>10</effort><velocity>0.5</velocity></limit></axis></joint>
</model></sdf>"""
"""The arm of `tests.two_formats` in a third format, its poses told in joints, frames and links."""


def sdf(*inside: str, version: str = "1.9", model: str = "") -> str:
    return f'<sdf version="{version}"><model name="m"{model}>\n' + "\n".join(inside) + "\n</model></sdf>"


def imported(folder: Path, text: str, companion: Companion | None = None, **wishes: object) -> Imported:
    path = folder / "robot.sdf"
    path.write_text(text)
    return read(path, Wishes(**wishes), companion or Companion())  # type: ignore[arg-type]


def hinge(kind: str = "revolute", axis: str = "<xyz>0 0 1</xyz>", pose: str = "", more: str = "") -> str:
    return (
        f'<link name="base">{INERTIAL}</link>'
        '<joint name="root" type="fixed"><parent>world</parent><child>base</child></joint>\n'
        f'<link name="arm"><pose>1 0 0 0 0 1.5707963267948966</pose>{INERTIAL}{more}</link>\n'
        f'<joint name="j" type="{kind}">{pose}<parent>base</parent><child>arm</child><axis>{axis}</axis></joint>'
    )


def test_an_arm_in_sdf_is_the_arm_of_the_urdf(tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text(URDF)
    (tmp_path / "b.sdf").write_text(ARM)
    # Angles in degrees are right to 1e-16 of them; sums of tens of terms err by 1e-14.
    assert compare(*pair_of(tmp_path / "a.urdf", tmp_path / "b.sdf", Wishes()), tolerance=1e-9) == []


def test_a_model_in_another_is_part_of_its_tree_under_its_own_name(tmp_path: Path) -> None:
    inner = '<model name="tool" placement_frame="flange"><pose relative_to="arm">0 0 .5 0 0 0</pose>'
    inner += f'<link name="head">{INERTIAL}</link>'
    inner += '<frame name="flange" attached_to="head"><pose>0 0 -.1 0 0 0</pose></frame></model>'
    fixed = (
        '<joint name="mount" type="revolute"><parent>arm</parent><child>tool::head</child><axis><xyz>1 0 0</xyz></axis></joint>'
    )
    scene = imported(tmp_path, sdf(hinge(), inner, fixed)).scene
    head = scene.body("tool::head")
    # The flange, 0.1 m below the head, is what lies half a metre above the arm.
    assert head.p_WB == pytest.approx((1, 0, 0.6))
    mount = next(joint for joint in scene.joints if joint.name == "mount")
    assert isinstance(mount, Revolute)
    assert (mount.parent, mount.child) == ("arm", "tool::head")
    # The arm is turned by a quarter about z, and so is what stands in it.
    assert mount.axis_W == pytest.approx((0, 1, 0), abs=1e-12)


@pytest.mark.parametrize(
    ("version", "axis", "pose", "expected"),
    [
        ("1.9", "<xyz>1 0 0</xyz>", "", (0, 1, 0)),
        ("1.9", '<xyz expressed_in="base">1 0 0</xyz>', "", (1, 0, 0)),
        ("1.9", '<xyz expressed_in="__model__">1 0 0</xyz>', "", (1, 0, 0)),
        ("1.9", "<xyz>1 0 0</xyz>", "<pose>0 0 0 0 0 1.5707963267948966</pose>", (-1, 0, 0)),
        ("1.9", "<xyz>1 0 0</xyz>", '<pose relative_to="base">0 0 0 0 0 0</pose>', (1, 0, 0)),
        ("1.6", "<xyz>1 0 0</xyz><use_parent_model_frame>1</use_parent_model_frame>", "", (1, 0, 0)),
    ],
)
def test_an_axis_is_told_in_its_joint_unless_it_says_another_frame(
    tmp_path: Path, version: str, axis: str, pose: str, expected: tuple[float, float, float]
) -> None:
    (joint,) = imported(tmp_path, sdf(hinge(axis=axis, pose=pose), version=version)).scene.joints
    assert isinstance(joint, Revolute)
    assert joint.axis_W == pytest.approx(expected, abs=1e-12)
    assert joint.anchor_W == pytest.approx((0, 0, 0) if "relative_to" in pose else (1, 0, 0))


def test_what_a_joint_says_along_its_axis_is_carried_over(tmp_path: Path) -> None:
    axis = (
        "<xyz>0 0 2</xyz><limit><lower>-1</lower><upper>1e16</upper><effort>-1</effort></limit><dynamics><damping>.3</damping>"
        "<friction>.1</friction><spring_stiffness>5</spring_stiffness><spring_reference>.2</spring_reference></dynamics>"
    )
    (joint,) = imported(tmp_path, sdf(hinge("prismatic", axis))).scene.joints
    assert isinstance(joint, Prismatic)
    assert joint.limits is not None
    assert (joint.limits.lower, joint.limits.upper) == (-1, None)
    assert joint.spring is not None
    assert (joint.spring.stiffness, joint.spring.damping, joint.spring.rest, joint.friction_loss) == (5, 0.3, 0.2, 0.1)


def test_a_joint_that_mimics_another_follows_from_its_reference(tmp_path: Path) -> None:
    more = f'<link name="tip"><pose relative_to="arm">0 0 1 0 0 0</pose>{INERTIAL}</link>'
    more += '<joint name="k" type="revolute"><parent>arm</parent>'
    more += '<child>tip</child><axis><xyz>0 0 1</xyz><mimic joint="j"><multiplier>2</multiplier><offset>.3</offset>'
    more += "<reference>.1</reference></mimic></axis></joint>"
    joints = {joint.name: joint for joint in imported(tmp_path, sdf(hinge(), more)).scene.joints}
    follower = joints["k"]
    assert isinstance(follower, Revolute)
    assert follower.coupling is not None
    assert (follower.coupling.joint, follower.coupling.ratio, follower.coupling.offset) == ("j", 2, pytest.approx(0.1))


def test_a_free_model_a_static_one_and_a_world_with_its_gravity(tmp_path: Path) -> None:
    free = imported(tmp_path, sdf(f'<pose>0 0 2 0 0 0</pose><link name="a">{INERTIAL}</link>'))
    assert free.scene.body("a").p_WB == (0, 0, 2)
    assert (free.scene.bodies[0].movable, free.scene.gravity[2]) == (True, -9.81)
    world = (
        '<sdf version="1.10"><world name="w"><gravity>0 0 -1.6</gravity><model name="ground"><static>true</static>'
        f'<link name="g"/></model><model name="m"><link name="a">{INERTIAL}</link></model></world></sdf>'
    )
    got = imported(tmp_path, world)
    assert got.scene.gravity == (0, 0, -1.6)
    assert row(got, "model").name == "'ground'"
    box = "<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>"
    still = imported(tmp_path, sdf("<static>1</static>", f'<link name="a">{box}</link>'))
    assert [body.motion for body in still.scene.bodies] == ["static"]


def test_shapes_and_surfaces_rub_as_the_smaller_of_a_pair_and_on_the_ground_as_the_robot(tmp_path: Path) -> None:
    def shape(kind: str, mu: float, more: str = "") -> str:
        surface = f"<surface><friction><ode><mu>{mu}</mu></ode></friction>{more}</surface>"
        return f"<collision name='{mu}'><pose>0 0 .1 0 0 0</pose><geometry>{kind}</geometry>{surface}</collision>"

    links = "".join(
        f'<link name="{name}"><pose>{k} 0 0 0 0 0</pose>{INERTIAL}{shape(kind, mu, more)}</link>'
        for k, (name, kind, mu, more) in enumerate(
            (
                (
                    "a",
                    "<box><size>1 2 3</size></box>",
                    0.4,
                    "<bounce><restitution_coefficient>.5</restitution_coefficient></bounce>",
                ),
                ("b", "<capsule><radius>.1</radius><length>1</length></capsule>", 0.7, ""),
                (
                    "c",
                    "<ellipsoid><radii>.1 .2 .3</radii></ellipsoid>",
                    0.7,
                    "<contact><collide_bitmask>0</collide_bitmask></contact>",
                ),
            )
        )
    )
    scene = imported(tmp_path, sdf("<self_collide>true</self_collide>", links), Companion(ground=Ground())).scene
    a, b, c, ground = (scene.body(name) for name in ("a", "b", "c", "ground"))
    assert scene.surface(a, b).kinetic_friction == 0.4
    assert (scene.surface(a, ground).kinetic_friction, scene.surface(a, ground).restitution) == (0.4, 0.5)
    assert scene.surface(b, ground).kinetic_friction == 0.7
    assert not c.collision
    assert a.collision[0].p_BS == pytest.approx((0, 0, 0.1))
    apart = imported(tmp_path, sdf(links)).scene
    assert not apart.collides(apart.body("a"), apart.body("b"))


def test_sensors_look_where_the_file_says(tmp_path: Path) -> None:
    sensors = (
        '<sensor name="i" type="imu"><update_rate>100</update_rate></sensor>'
        '<sensor name="l" type="gpu_lidar"><update_rate>10</update_rate><lidar><scan><horizontal><samples>91</samples>'
        "<min_angle>-0.7853981633974483</min_angle><max_angle>0.7853981633974483</max_angle></horizontal><vertical><samples>4</samples>"
        "<min_angle>-.1</min_angle><max_angle>.2</max_angle></vertical></scan><range><min>.2</min><max>30</max></range></lidar></sensor>"
        '<sensor name="c" type="camera"><pose>0 0 .2 0 0 1.5707963267948966</pose><update_rate>5</update_rate><camera>'
        "<horizontal_fov>1.5707963267948966</horizontal_fov><image><width>64</width><height>48</height></image></camera></sensor>"
        '<sensor name="d" type="depth_camera"><camera><clip><near>.3</near><far>7</far></clip></camera></sensor>'
        '<sensor name="s" type="sonar"/>'
    )
    got = imported(tmp_path, sdf(f'<link name="a">{INERTIAL}{sensors}</link>'))
    imu, lidar, camera, depth = got.scene.sensors
    assert isinstance(imu, Imu)
    assert isinstance(lidar, Lidar)
    assert isinstance(camera, Camera)
    assert isinstance(depth, DepthCamera)
    assert (imu.rate, lidar.columns, lidar.channels, lidar.max_range, depth.near, depth.far) == (100, 360, 4, 30, 0.3, 7)
    assert camera.focal_x == pytest.approx(32)
    # SDF's camera looks along its x, which is turned to y here, with z up.
    assert rotate(camera.q_BS, (0.0, 0.0, 1.0)) == pytest.approx((0, 1, 0), abs=1e-12)
    assert rotate(camera.q_BS, (0.0, 1.0, 0.0)) == pytest.approx((0, 0, -1), abs=1e-12)
    assert row(got, "sensor sonar").outcome == "left_out"


def test_masses_that_are_not_said_are_the_formats_own(tmp_path: Path) -> None:
    ball = "<collision name='c'><density>1000</density><geometry><sphere><radius>.1</radius></sphere></geometry></collision>"
    text = sdf(f'<link name="a"/><link name="b"><inertial auto="true"/>{ball}</link>', version="1.11")
    got = imported(tmp_path, text)
    assert (got.scene.body("a").mass, got.scene.body("a").inertia[0][0]) == (1, 1)
    mass = 1000 * 4 / 3 * math.pi * 1e-3
    assert got.scene.body("b").mass == pytest.approx(mass)
    assert got.scene.body("b").inertia[2][2] == pytest.approx(0.4 * mass * 0.01)
    assert row(got, "inertial").name == "'a'"


def test_poses_take_degrees_and_quaternions(tmp_path: Path) -> None:
    turned = Rotation.from_euler("xyz", [10, 20, 30], degrees=True)
    x, y, z, w = turned.as_quat()
    for pose in ('<pose degrees="1">1 2 3 10 20 30</pose>', f'<pose rotation_format="quat_xyzw">1 2 3 {x} {y} {z} {w}</pose>'):
        body = imported(tmp_path, sdf(f'<link name="a">{pose}{INERTIAL}</link>')).scene.body("a")
        assert body.p_WB == (1, 2, 3)
        assert np.abs(np.dot(body.q_WB, [w, x, y, z])) == pytest.approx(1)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (sdf(hinge(), "<include><uri>model://x</uri></include>"), "<include>: another model is not fetched; 'gz sdf -p"),
        (sdf(hinge(), version="1.4"), "version is '1.4', expected one of 1.6"),
        (sdf(hinge("universal")), "<joint> 'j': type is 'universal'"),
        (sdf(hinge(axis="<xyz>0 0 0</xyz>")), "<axis>: <xyz> has no length"),
        (sdf(hinge(axis="<xyz>0 0 1</xyz><limit><lower>2</lower><upper>1</upper></limit>")), "lower is 2 and upper 1"),
        (sdf(hinge(axis="<xyz>0 0 1</xyz><dynamics><dampin>1</dampin></dynamics>")), "did you mean damping?"),
        (sdf(hinge(pose='<pose relative_to="gone"/>')), "'gone' is no frame of the model, expected one of 'base'"),
        (sdf(hinge(pose='<pose relativ_to="base"/>')), "did you mean relative_to?"),
        (sdf('<frame name="f"><pose relative_to="g"/></frame><frame name="g"><pose relative_to="f"/></frame>'
             '<link name="a"><pose relative_to="f"/></link>'), "are told in each other"),
        (sdf(hinge(), '<joint name="k" type="fixed"><parent>arm</parent><child>base</child></joint>'), "already hangs on"),
        (sdf(hinge().replace("<mass>2", "<mass>-2", 1)), "<mass> is -2, expected a number above 0"),
        (sdf(hinge().replace("<mass>2", "<mass>two", 1)), "<mass>: is 'two', expected 1 finite number"),
        (sdf(hinge(), hinge()), "name stands in line"),
        ('<sdf version="1.9"><world name="w"><model name="a"><link name="l"/></model>'
         '<model name="b"><link name="l"/></model></world></sdf>', "holds 2 models that can move: 'a', 'b'"),
        (sdf(hinge(more="<collision name='c'><geometry><heightmap/></geometry></collision>")), "<heightmap>: is no shape"),
        (sdf(hinge(more="<gravity>0</gravity>")), "--drop gravity_compensation"),
        (sdf(hinge(more="<kinematic>1</kinematic>")), "is kinematic"),
        ("<robot name='r'><link name='a'/></robot>", "expected <sdf>"),
    ],
)  # fmt: skip
def test_what_is_not_read_is_refused_by_line(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(RobotError) as refused:
        imported(tmp_path, text)
    assert said in str(refused.value)


def test_words_that_sdf_does_not_have_are_left_out_and_told(tmp_path: Path) -> None:
    told = list[str]()
    text = sdf(hinge(more="<glow>1</glow><visual name='v'/>"), "<plugin name='p' filename='x.so'/>")
    got = imported(tmp_path, text, tell=told.append)
    assert row(got, "<glow> in <link>").outcome == "left_out"
    assert row(got, "plugin").consequence == "plug-ins are not read"
    assert "<glow> in <link>" in told[0]
    with pytest.raises(RobotError, match="is no word of SDF here"):
        imported(tmp_path, text, strict=True)


def test_a_package_above_the_file_is_found_by_its_manifest(tmp_path: Path) -> None:
    package = tmp_path / "ws" / "src" / "my robot"
    (package / "urdf").mkdir(parents=True)
    (package / "meshes").mkdir()
    (package / "package.xml").write_text("<package><name>robot_description</name></package>")
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (package / "meshes" / "t.obj").write_text(corners)
    mesh = (
        "<collision name='c'><geometry><mesh><uri>package://robot_description/meshes/t.obj</uri></mesh></geometry></collision>"
    )
    got = imported(package / "urdf", sdf(f'<link name="a">{INERTIAL}{mesh}</link>'))
    assert len(got.scene.body("a").collision) == 1
    (package / "package.xml").write_text("<!DOCTYPE x [<!ENTITY e 'y'>]><package><name>&e;</name></package>")
    lost = imported(package / "urdf", sdf(f'<link name="a">{INERTIAL}{mesh}</link>'))
    assert "--package robot_description=DIR" in row(lost, "collision mesh").consequence
