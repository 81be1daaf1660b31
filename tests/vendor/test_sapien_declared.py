"""What SAPIEN's adapter declares of moving meshes, joints, springs, saving, rays and points, in sapien's own words."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.vendor.sapien_world import G, physx, put, sapien, weightless, world

pytestmark = pytest.mark.sapien

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float32)
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
"""Of a box, each seen from outside, by its corners."""
ONCE = np.ones(3, dtype=np.float32)


def boxes(*parts: tuple[tuple[float, float, float], tuple[float, float, float]]) -> tuple[Any, Any]:
    """A mesh of boxes. Args: parts: (centre, half extents) [m]."""
    points = [CORNERS * np.array(half, dtype=np.float32) + np.array(centre, dtype=np.float32) for centre, half in parts]
    faces = [[(a, b, c), (a, c, d)] for a, b, c, d in SIDES]
    numbered = [np.array(faces).reshape(-1, 3) + 8 * k for k in range(len(parts))]
    return np.vstack(points), np.vstack(numbered).astype(np.uint32)


TABLE = boxes(((0, 0, 0.15), (0.3, 0.2, 0.05)), ((-0.25, 0, -0.05), (0.05, 0.2, 0.15)), ((0.25, 0, -0.05), (0.05, 0.2, 0.15)))
"""The underside of its top lies 0.1 m above its centre, its feet 0.2 m below."""


def plane(material: Any) -> tuple[Any, Any]:
    return physx.PhysxCollisionShapePlane(material), sapien.Pose([0, 0, 0], [math.sqrt(0.5), 0, -math.sqrt(0.5), 0])


GROUND: dict[str, tuple[Callable[[Any], Any], float]] = {
    "a box between the legs": (lambda m: physx.PhysxCollisionShapeBox([0.1, 0.1, 0.3], m), 0.2),
    "a ball between the legs": (lambda m: physx.PhysxCollisionShapeSphere(0.15, m), 0.05),
    "a capsule between the legs": (lambda m: physx.PhysxCollisionShapeCapsule(0.1, 0.05, m), 0.0),
    "a wide box under the feet": (lambda m: physx.PhysxCollisionShapeBox([5, 5, 0.1], m), 0.3),
    "a hull between the legs": (
        lambda m: physx.PhysxCollisionShapeConvexMesh(boxes(((0, 0, 0), (0.1, 0.1, 0.3)))[0], ONCE, m), 0.2),
}  # fmt: skip
"""Shapes at the origin, and how high [m] the table's centre stands above them."""


def table_on(shape: Any, pose: Any, kind: str = "mesh", moving: bool = False) -> tuple[Any, float]:
    """Where the table is 2 s after it was let go, 2 cm above what bears it at most. Args: moving: does that move."""
    scene, system = world()
    material = physx.PhysxMaterial(0.5, 0.5, 0.0)
    bearer, entity = (physx.PhysxRigidDynamicComponent() if moving else physx.PhysxRigidStaticComponent()), sapien.Entity()
    bearer.attach(weightless(shape))
    if moving:
        bearer.kinematic = True
    entity.add_component(bearer)
    entity.pose = pose
    scene.add_entity(entity)
    points, faces = TABLE
    body = physx.PhysxRigidDynamicComponent()
    make = {
        "mesh": lambda: physx.PhysxCollisionShapeTriangleMesh(points, faces, ONCE, material),
        "hull": lambda: physx.PhysxCollisionShapeConvexMesh(points, ONCE, material),
    }
    body.attach(weightless(make[kind]()))
    table = put(scene, body, (0.0, 0.0, 0.52 if kind == "hull" else 0.32), 1.0, 0.02)
    for _ in range(480):
        system.step()
    return table.pose, float(np.linalg.norm(body.linear_velocity))


@pytest.mark.parametrize("ground", GROUND)
def test_a_moving_mesh_stands_on_its_faces_without_a_gpu(ground: str) -> None:
    shape, height = GROUND[ground]
    pose, speed = table_on(shape(physx.PhysxMaterial(0.5, 0.5, 0.0)), sapien.Pose())
    assert pose.p[2] == pytest.approx(height, abs=2e-4)
    assert speed < 2e-3


def test_it_stands_on_a_box_that_is_led_as_well() -> None:
    shape = physx.PhysxCollisionShapeBox([0.1, 0.1, 0.3], physx.PhysxMaterial(0.5, 0.5, 0.0))
    assert table_on(shape, sapien.Pose(), moving=True)[0].p[2] == pytest.approx(0.2, abs=2e-4)


def test_as_a_hull_the_same_mesh_stands_on_top_of_what_is_between_its_legs() -> None:
    pose, _ = table_on(physx.PhysxCollisionShapeBox([0.1, 0.1, 0.3], physx.PhysxMaterial(0.5, 0.5, 0.0)), sapien.Pose(), "hull")
    assert pose.p[2] == pytest.approx(0.5, abs=2e-3)


def test_a_moving_mesh_falls_through_planes_and_other_meshes() -> None:
    material = physx.PhysxMaterial(0.5, 0.5, 0.0)
    assert table_on(*plane(material))[0].p[2] < -10.0
    other = physx.PhysxCollisionShapeTriangleMesh(*boxes(((0, 0, 0), (0.1, 0.1, 0.3))), ONCE, material)
    assert table_on(other, sapien.Pose())[0].p[2] < -10.0


def tree(
    kinds: list[str],
    masses: list[float],
    dt: float = 1e-3,
    gravity: float = 0.0,
    poses: Any = None,
    limit: tuple[float, float] = (-np.inf, np.inf),
) -> tuple[Any, Any, Any]:
    """A chain of links on a fixed root, without friction or damping. Returns: scene, articulation, links."""
    scene, _ = world((0.0, 0.0, -gravity), dt)
    links = [physx.PhysxArticulationLinkComponent(None)]
    links[0].joint.type = "fixed"
    entities = [sapien.Entity()]
    entities[0].add_component(links[0])
    for k, (kind, mass) in enumerate(zip(kinds, masses, strict=True)):
        link, entity = physx.PhysxArticulationLinkComponent(links[-1]), sapien.Entity()
        link.joint.type, link.joint.limit = kind, [limit]
        link.joint.set_friction(0.0)
        link.joint.max_velocity = 1e6
        link.mass, link.inertia = mass, [min(0.1, mass)] * 3
        link.linear_damping = link.angular_damping = 0.0
        if poses is not None:
            link.joint.pose_in_parent, link.joint.pose_in_child = poses[k]
        entity.add_component(link)
        links.append(link)
        entities.append(entity)
    for entity in entities:
        scene.add_entity(entity)
    return scene, links[0].articulation, links[1:]


def pulled(pull: float, load: float, friction: float = 0.0, cut: float | None = None) -> float:
    """Speed [m/s] of 2 kg on a slide after a second. Args: load: across it [N]. cut: of a drive towards rest [N]."""
    scene, _, (link,) = tree(["prismatic"], [2.0])
    link.joint.set_friction(friction)
    if cut is not None:
        link.joint.set_drive_property(0.0, 1e6, cut, "force")
    for _ in range(1000):
        link.add_force_torque([pull, 0.0, -load], [0.0, 0.0, 0.0])
        scene.step()
    return float(link.linear_velocity[0])


def test_the_friction_of_a_joint_grows_with_what_it_bears() -> None:
    """Nothing without a load, all of it under 50 N."""
    assert pulled(4.0, 0.0, friction=0.1) == pytest.approx(2.0, abs=1e-3)
    assert 1.0 < pulled(4.0, 10.0, friction=0.1) < 1.9
    assert pulled(4.0, 50.0, friction=0.1) == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("load", [0.0, 10.0, 50.0])
def test_a_drive_towards_rest_that_is_cut_off_is_dry_friction_whatever_the_joint_bears(load: float) -> None:
    assert pulled(2.9, load, cut=3.0) == pytest.approx(0.0, abs=1e-5)
    assert pulled(3.1, load, cut=3.0) == pytest.approx(0.05, abs=1e-4)
    assert pulled(5.0, load, cut=3.0) == pytest.approx(1.0, abs=1e-4)


def restored(touching: bool, tgs: bool) -> tuple[float, float]:
    """How far [m, 1] a packed state ends from the run that went on, and from itself restored again, half a second on."""
    scene, system = world(enable_tgs=tgs)
    material = physx.PhysxMaterial(0.5, 0.5, 0.0)
    ground = physx.PhysxRigidStaticComponent()
    ground.attach(physx.PhysxCollisionShapeBox([5.0, 5.0, 0.5], material))
    put(scene, ground, (0.0, 0.0, -0.5))
    entities = []
    for k in range(4):
        box = physx.PhysxRigidDynamicComponent()
        box.attach(weightless(physx.PhysxCollisionShapeBox([0.1, 0.1, 0.1], material)))
        entities.append(put(scene, box, (0.0, 0.0, 0.1 + 0.2 * k + (0.0 if touching else 50.0)), 1.0, 1 / 150))
    for _ in range(120):
        system.step()
    packed, ends = system.pack(), []
    assert len(packed) == 4 * 13 * 4  # a pose and two velocities of each, in single precision
    for _ in range(3):
        for _ in range(120):
            system.step()
        ends.append(np.concatenate([np.r_[entity.pose.p, entity.pose.q] for entity in entities]))
        system.unpack(packed)
    return float(np.abs(ends[1] - ends[0]).max()), float(np.abs(ends[2] - ends[1]).max())


@pytest.mark.parametrize("tgs", [True, False])
def test_what_is_packed_goes_on_otherwise_than_what_was_not_where_bodies_touch(tgs: bool) -> None:
    """Poses and velocities alone, without what the solver starts from; in flight the same bit for bit."""
    physx.set_scene_config(enable_tgs=tgs)
    assert restored(False, tgs) == (0.0, 0.0)
    on, again = restored(True, tgs)
    physx.set_scene_config(enable_tgs=True)
    assert 1e-7 < on < 1e-3
    assert again == 0.0


def sprung(dt: float, tgs: bool, iterations: int = 10) -> float:
    """How far [m] 1 kg on a spring of 100 N/m, let go 0.2 m from its rest, leaves the law within a second."""
    scene, system = world((0.0, 0.0, 0.0), dt, enable_tgs=tgs)
    physx.set_body_config(solver_position_iterations=iterations)
    body, entity = physx.PhysxRigidDynamicComponent(), sapien.Entity()
    body.mass, body.inertia = 1.0, [0.01] * 3
    body.linear_damping = body.angular_damping = 0.0
    entity.add_component(body)
    entity.pose = sapien.Pose([0.5, 0.0, 0.0])
    line = physx.PhysxDistanceJointComponent(body)
    line.pose_in_child = line.pose_in_parent = sapien.Pose()
    line.set_limit(0.3, 0.3, 100.0, 0.0)
    entity.add_component(line)
    scene.add_entity(entity)
    worst = 0.0
    for n in range(1, round(1.0 / dt) + 1):
        system.step()
        worst = max(worst, abs(float(entity.pose.p[0]) - 0.3 - 0.2 * math.cos(10.0 * n * dt)))
    physx.set_body_config(solver_position_iterations=10)
    physx.set_scene_config(enable_tgs=True)
    return worst


def test_the_spring_of_a_distance_joint_lags_by_the_step_under_pgs_and_by_its_sub_steps_under_tgs() -> None:
    """A millimetre is what a step of the first order leaves of 0.2 m at 10 rad/s: 0.2 w dt/2."""
    assert 8e-3 < sprung(1e-3, tgs=False) < 10e-3
    assert sprung(2.5e-4, tgs=False) == pytest.approx(sprung(1e-3, tgs=False) / 4, rel=0.1)
    assert sprung(1e-3, tgs=True) == pytest.approx(1e-3, rel=0.1)
    assert sprung(1e-3, tgs=True, iterations=50) < 3e-4


def bounded(*limits: tuple[float, ...], start: float = 0.5) -> tuple[float, float]:
    """Between which distances [m] 1 kg on these limits of distance joints, one each, goes within 2 s of rest at `start`."""
    scene, system = world((0.0, 0.0, 0.0), 1e-3)
    body, entity = physx.PhysxRigidDynamicComponent(), sapien.Entity()
    body.mass, body.inertia = 1.0, [0.01] * 3
    body.linear_damping = body.angular_damping = 0.0
    entity.add_component(body)
    entity.pose = sapien.Pose([start, 0.0, 0.0])
    for limit in limits:
        line = physx.PhysxDistanceJointComponent(body)
        line.pose_in_child = line.pose_in_parent = sapien.Pose()
        line.set_limit(*limit)
        entity.add_component(line)
    scene.add_entity(entity)
    ways = []
    for _ in range(2000):
        system.step()
        ways.append(float(entity.pose.p[0]))
    return min(ways), max(ways)


def test_limits_of_a_distance_are_hard_or_a_spring_and_two_joints_are_both() -> None:
    """Beyond 0.25 to 0.6 m a joint with a stiffness is a spring, which lets 0.7 m come back at 0.15."""
    assert bounded((0.25, 0.6, 100.0, 0.0), start=0.7) == pytest.approx((0.15, 0.7), abs=1e-3)
    assert bounded((0.3, 0.3, 100.0, 0.0)) == pytest.approx((0.1, 0.5), abs=1e-3)
    assert bounded((0.3, 0.3, 100.0, 0.0), (0.25, 0.6)) == pytest.approx((0.25, 0.5), abs=1e-3)


def turned(low: float, high: float, rate: float, articulated: bool) -> float:
    """Through which angle [rad] a hinge with limits turns in 3 s."""
    if articulated:
        scene, articulation, (body,) = tree(["revolute_unwrapped"], [1.0], 1 / 240, limit=(low, high))
        articulation.set_qvel(np.array([rate], dtype=np.float32))
    else:
        scene, _ = world((0.0, 0.0, 0.0), 1 / 240)
        body, entity = physx.PhysxRigidDynamicComponent(), sapien.Entity()
        body.mass, body.inertia = 1.0, [0.1] * 3
        body.linear_damping = body.angular_damping = 0.0
        hinge = physx.PhysxDriveComponent(body)
        for lock in (hinge.set_limit_x, hinge.set_limit_y, hinge.set_limit_z):
            lock(0.0, 0.0)
        hinge.set_limit_twist(low, high)
        entity.add_component(body)
        entity.add_component(hinge)
        scene.add_entity(entity)
        body.set_angular_velocity([rate, 0.0, 0.0])
    angle = 0.0
    for _ in range(720):
        scene.step()
        angle += float(body.angular_velocity[0]) / 240
    return angle


@pytest.mark.parametrize("high", [2.0, 3.1, 4.0, 5.2, 8.0])
def test_the_stop_of_a_constraint_beyond_half_a_turn_is_lost_and_that_of_an_articulation_holds(high: float) -> None:
    """6 rad/s for 3 s; a stop gives way by a step's turn, 0.025 rad."""
    assert turned(-1.0, high, 6.0, True) == pytest.approx(high, abs=0.03)
    assert turned(-1.0, high, 6.0, False) == pytest.approx(high if high < math.pi else 18.0, abs=0.03)


def nearest(joint: str) -> float:
    """How near [m] the centres of two balls of 0.1 m come of which one comes at 1 m/s. Args: joint: that leaves them free."""
    material = physx.PhysxMaterial(0.0, 0.0, 0.0)
    scene, system = world((0.0, 0.0, 0.0), 1e-3)
    kind = physx.PhysxArticulationLinkComponent if joint == "articulation" else physx.PhysxRigidDynamicComponent
    first = kind(None) if joint == "articulation" else kind()
    second = kind(first) if joint == "articulation" else kind()
    entities = []
    for body, x in ((first, 0.0), (second, 0.3)):
        body.attach(weightless(physx.PhysxCollisionShapeSphere(0.1, material)))
        body.mass, body.inertia = 1.0, [0.01] * 3
        entity = sapien.Entity()
        entity.add_component(body)
        entity.pose = sapien.Pose([x, 0.0, 0.0])
        entities.append(entity)
    if joint == "articulation":
        first.joint.type, second.joint.type = "fixed", "prismatic"
        second.joint.limit, second.joint.pose_in_parent = [[-np.inf, np.inf]], sapien.Pose([0.3, 0.0, 0.0])
        second.joint.set_friction(0.0)
    elif joint != "none":
        held = {"distance": physx.PhysxDistanceJointComponent, "drive": physx.PhysxDriveComponent}[joint](second)
        held.parent, held.pose_in_child, held.pose_in_parent = first, sapien.Pose(), sapien.Pose()
        if joint == "distance":
            held.set_limit(0.0, 5.0)
        entities[1].add_component(held)
    for entity in entities:
        scene.add_entity(entity)
    if joint == "articulation":
        first.articulation.set_qvel(np.array([-1.0], dtype=np.float32))
    else:
        second.set_linear_velocity([-1.0, 0.0, 0.0])
    least = math.inf
    for _ in range(600):
        system.step()
        least = min(least, abs(float(entities[1].pose.p[0] - entities[0].pose.p[0])))
    return least


@pytest.mark.parametrize("joint", ["none", "distance", "drive", "articulation"])
def test_bodies_that_a_joint_holds_pass_through_each_other(joint: str) -> None:
    assert nearest(joint) == pytest.approx(0.2 if joint == "none" else 0.0, abs=2e-3)
    kinds = (physx.PhysxJointComponent, physx.PhysxDriveComponent, physx.PhysxArticulationJoint, physx.PhysxArticulation)
    assert not [name for kind in kinds for name in dir(kind) if "collis" in name or "contact" in name]


SOLIDS: dict[str, Callable[[Any], Any]] = {
    "ball": lambda m: physx.PhysxCollisionShapeSphere(0.5, m),
    "box": lambda m: physx.PhysxCollisionShapeBox([0.5, 0.5, 0.5], m),
    "capsule": lambda m: physx.PhysxCollisionShapeCapsule(0.5, 0.5, m),
    "cylinder": lambda m: physx.PhysxCollisionShapeCylinder(0.5, 0.5, m),
    "mesh": lambda m: physx.PhysxCollisionShapeTriangleMesh(*boxes(((0, 0, 0), (0.5, 0.5, 0.5))), ONCE, m),
}


@pytest.mark.parametrize("solid", SOLIDS)
def test_a_ray_that_starts_in_a_solid_meets_it_there_and_one_from_outside_on_its_surface(solid: str) -> None:
    """A mesh is a surface, seen from outside alone."""
    scene, system = world((0.0, 0.0, 0.0))
    component = physx.PhysxRigidStaticComponent()
    component.attach(SOLIDS[solid](physx.PhysxMaterial(0.5, 0.5, 0.0)))
    put(scene, component, (0.0, 0.0, 0.0))
    system.step()
    outside = system.raycast([0.0, 0.0, 3.0], [0.0, 0.0, -1.0], 9.0)
    assert outside.distance == pytest.approx(2.5, abs=3e-3)
    inside = system.raycast([0.0, 0.0, 0.2], [0.0, 0.0, -1.0], 9.0)
    assert inside is None if solid == "mesh" else inside.distance == 0.0


SMALL: dict[str, Callable[[Any], Any]] = {
    "ball": lambda m: physx.PhysxCollisionShapeSphere(0.1, m),
    "box": lambda m: physx.PhysxCollisionShapeBox([0.1, 0.1, 0.1], m),
    "capsule": lambda m: physx.PhysxCollisionShapeCapsule(0.1, 0.1, m),
}


@pytest.mark.parametrize("gap", [-4e-3, 4e-3])
@pytest.mark.parametrize(
    ("below", "above", "on"),
    [("ball", "ball", 0), ("box", "box", 0), ("box", "ball", 0), ("ball", "box", 1), ("capsule", "capsule", 1),
     ("box", "capsule", 1), ("capsule", "box", 0), ("ball", "capsule", 0), ("capsule", "ball", 1)],
)  # fmt: skip
def test_the_point_of_a_contact_lies_on_one_of_both_surfaces(below: str, above: str, on: int, gap: float) -> None:
    """Half the gap off the middle. Args: on: on the lower surface, 0, at .1 m, or on the upper, 1, at .1 m and the gap."""
    scene, system = world((0.0, 0.0, 0.0), 1e-4)
    material = physx.PhysxMaterial(0.0, 0.0, 0.0)
    ground, body = physx.PhysxRigidStaticComponent(), physx.PhysxRigidDynamicComponent()
    ground.attach(SMALL[below](material))
    body.attach(weightless(SMALL[above](material)))
    put(scene, ground, (0.0, 0.0, 0.0))
    put(scene, body, (0.0, 0.0, 0.2 + gap))
    system.step()
    points = [point for contact in system.get_contacts() for point in contact.points]
    assert points
    for point in points:
        assert point.separation == pytest.approx(gap, abs=1e-5)
        assert point.position[2] == pytest.approx(0.1 + on * gap, abs=1e-5)


def crossed(mass: float) -> tuple[float, Any]:
    """The mass that PhysX takes for a link told this one between two crossed hinges, and where the bob is after a second."""
    start, across = [0.6, 0.48, -0.64], [math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]
    poses = [
        (sapien.Pose(), sapien.Pose()),
        (sapien.Pose([0.0] * 3, across), sapien.Pose([-x for x in start], across)),
    ]
    scene, _, (between, bob) = tree(["revolute_unwrapped"] * 2, [mass, 1.0], gravity=G, poses=poses)
    for _ in range(1000):
        scene.step()
    return float(between.mass), np.array(bob.entity_pose.p)


def test_a_link_without_mass_is_given_a_kilogram_and_one_of_a_microgram_moves_as_one_without() -> None:
    """The console says so. 1e-9 and 1e-6 kg end within rounding of each other, and 1e-2 kg two millimetres off."""
    assert crossed(0.0)[0] == 1.0
    light, lighter, heavy = crossed(1e-6)[1], crossed(1e-9)[1], crossed(1e-2)[1]
    assert np.abs(light - lighter).max() < 2e-5
    assert np.abs(crossed(0.0)[1] - lighter).max() > 0.1
    assert 5e-4 < np.abs(heavy - lighter).max() < 5e-3


def tied(arms: list[float]) -> tuple[Any, Any]:
    """How far [m] slides in a row, of 1 and 2 kg, go in .1 s by a tendon of 10 N/m that is .1 m too short, and by its law."""
    masses = [1.0, 2.0][: len(arms)]
    scene, articulation, links = tree(["prismatic"] * len(arms), masses)
    articulation.set_solver_position_iterations(50)
    root = articulation.links[0]
    articulation.create_fixed_tendon([root, *links], [0.0, *arms], [0.0, *arms], rest_length=0.1, stiffness=10.0)
    for _ in range(100):
        scene.step()
    went = np.array([1.0, 2.0]) if len(arms) == 2 else np.array([1.0])
    weighs = np.array([[went[max(i, j) :].sum() for j in range(len(arms))] for i in range(len(arms))])
    rate = np.linalg.solve(weighs, np.array(arms))
    swing = 10.0 * float(np.array(arms) @ rate)
    law = rate * 0.1 / float(np.array(arms) @ rate) * (1 - math.cos(math.sqrt(swing) * 0.1))
    return np.array(articulation.get_qpos()), law


def test_a_fixed_tendon_keeps_a_spring_s_law_along_one_joint_and_gives_two_other_shares_than_their_arms() -> None:
    one, law = tied([1.0])
    assert one == pytest.approx(law, rel=0.03)
    for arms in ([1.0, 1.0], [1.0, 2.0], [1.0, -1.0]):
        both, law = tied(arms)
        assert np.abs(both - law).max() > 0.2 * np.abs(law).max()


def test_a_joint_of_an_articulation_has_one_drive_and_no_second_word_for_a_spring() -> None:
    words = dir(physx.PhysxArticulationJoint)
    assert sorted(name for name in words if name.startswith("set_drive")) == [
        "set_drive_properties", "set_drive_property", "set_drive_target", "set_drive_velocity_target",
    ]  # fmt: skip
    assert not [name for name in words if "spring" in name or "motor" in name or "passive" in name]
