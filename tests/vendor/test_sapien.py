"""What SAPIEN's adapter says of PhysX, in sapien's own words."""

import math

import numpy as np
import pytest

from tests.vendor.sapien_world import G, physx, put, sapien, weightless, world

pytestmark = pytest.mark.sapien


def test_under_tgs_each_step_gives_a_spin_5e_7_of_itself_even_that_of_a_ball() -> None:
    for dt, tgs in ((1 / 240, True), (1e-3, True), (1 / 240, False)):
        scene, system = world((0.0, 0.0, 0.0), dt, enable_tgs=tgs)
        ball = physx.PhysxRigidDynamicComponent()
        put(scene, ball, (0.0, 0.0, 0.0), 2.0, 0.3)
        ball.set_angular_velocity([1.0, 2.0, -3.0])
        steps = round(4 / dt)
        for _ in range(steps):
            system.step()
        gain = np.linalg.norm(ball.angular_velocity) / math.sqrt(14.0) - 1.0
        assert 2e-7 < gain / steps < 8e-7 if tgs else abs(gain / steps) < 1e-7


def test_a_cylinder_is_a_prism_of_32_sides() -> None:
    scene, system = world()
    solid = physx.PhysxRigidStaticComponent()
    solid.attach(physx.PhysxCollisionShapeCylinder(1.0, 1.0, physx.PhysxMaterial(0.5, 0.5, 0.0)))
    put(scene, solid, (0.0, 0.0, 0.0))
    system.step()
    within = []
    for a in np.linspace(0.0, 2 * math.pi, 6401):
        start = np.array([0.0, 3 * math.cos(a), 3 * math.sin(a)])
        within.append(system.raycast(start, -start / 3, 9.0).distance - 2.0)
    # A face of a prism of n sides whose edges lie on the circle is 1 - cos(pi/n) within.
    assert max(within) == pytest.approx(1 - math.cos(math.pi / 32), rel=0.01)


def slid(static: float, kinetic: float, slope: float) -> float:
    """Way [m] in a second from rest on a slope."""
    angle = math.atan(slope)
    scene, system = world((G * math.sin(angle), 0.0, -G * math.cos(angle)), 1e-3)
    material = physx.PhysxMaterial(static, kinetic, 0.0)
    ground = physx.PhysxRigidStaticComponent()
    ground.attach(physx.PhysxCollisionShapeBox([5.0, 5.0, 0.5], material))
    put(scene, ground, (0.0, 0.0, -0.5))
    box = physx.PhysxRigidDynamicComponent()
    box.attach(weightless(physx.PhysxCollisionShapeBox([0.2, 0.2, 0.05], material)))
    entity = put(scene, box, (0.0, 0.0, 0.05), 1.0, 0.02)
    for _ in range(1000):
        system.step()
    return float(entity.pose.p[0])


def test_static_friction_above_kinetic_lets_go_between_both() -> None:
    assert abs(slid(0.6, 0.4, 0.45)) < 1e-3
    assert slid(0.6, 0.4, 0.5) > 0.4
    assert abs(slid(0.6, 0.6, 0.5)) < 1e-3


def test_continuous_collision_of_a_scene_sweeps_none_of_its_bodies() -> None:
    for swept in (False, True):
        scene, system = world((0.0, 0.0, 0.0), 0.01, enable_ccd=swept)
        material = physx.PhysxMaterial(0.0, 0.0, 0.0)
        wall = physx.PhysxRigidStaticComponent()
        wall.attach(physx.PhysxCollisionShapeBox([0.01, 1.0, 1.0], material))
        put(scene, wall, (0.0, 0.0, 0.0))
        ball = physx.PhysxRigidDynamicComponent()
        ball.attach(weightless(physx.PhysxCollisionShapeSphere(0.05, material)))
        entity = put(scene, ball, (-2.3, 0.0, 0.0))
        ball.set_linear_velocity([97.0, 0.0, 0.0])
        for _ in range(10):
            system.step()
        assert entity.pose.p[0] > 1.0
    physx.set_scene_config(enable_ccd=False)


def test_contacts_tell_the_normal_part_of_a_force_alone() -> None:
    scene, system = world()
    material = physx.PhysxMaterial(0.5, 0.5, 0.0)
    ground = physx.PhysxRigidStaticComponent()
    ground.attach(physx.PhysxCollisionShapeBox([5.0, 5.0, 0.5], material))
    put(scene, ground, (0.0, 0.0, -0.5))
    box = physx.PhysxRigidDynamicComponent()
    box.attach(weightless(physx.PhysxCollisionShapeBox([0.1, 0.1, 0.1], material)))
    put(scene, box, (0.0, 0.0, 0.1))
    box.set_linear_velocity([2.0, 0.0, 0.0])
    for _ in range(30):
        system.step()
    assert box.linear_velocity[0] == pytest.approx(2.0 - 0.5 * G * 30 / 240, rel=0.02)
    (contact,) = system.get_contacts()
    force = 240 * np.sum([point.impulse for point in contact.points], axis=0)
    assert force[2] == pytest.approx(G, rel=0.01)
    assert np.abs(force[:2]).max() < 1e-3


def held(joint_limits: str) -> float:
    """How far [m] a body falls in .3 s whose hinge, half a metre off its centre, is upright."""
    scene, system = world(dt=1e-3)
    body, entity = physx.PhysxRigidDynamicComponent(), sapien.Entity()
    body.mass, body.inertia = 1.0, [0.1] * 3
    entity.add_component(body)
    entity.pose = sapien.Pose([0.5, 0.0, 0.0])
    upright, along = [math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0], sapien.Pose([1.0, 0.0, 0.0])
    joints = [physx.PhysxDriveComponent(body) for _ in range(2 if joint_limits == "second point" else 1)]
    for joint in joints:
        joint.pose_in_parent, joint.pose_in_child = sapien.Pose([0.0] * 3, upright), sapien.Pose([-0.5, 0.0, 0.0], upright)
        joint.set_limit_y(0.0, 0.0)
        joint.set_limit_z(0.0, 0.0)
    joints[0].set_limit_x(0.0, 0.0)
    if joint_limits == "cone":
        joints[0].set_limit_cone(0.0, 0.0)
    elif joint_limits == "pyramid":
        joints[0].set_limit_pyramid(0.0, 0.0, 0.0, 0.0)
    elif joint_limits == "second point":
        joints[1].pose_in_parent, joints[1].pose_in_child = joints[1].pose_in_parent * along, joints[1].pose_in_child * along
    for joint in joints:
        entity.add_component(joint)
    scene.add_entity(entity)
    for _ in range(300):
        system.step()
    return -float(entity.pose.p[2])


def test_limits_of_swing_do_nothing_and_a_second_point_of_the_axis_holds() -> None:
    free = held("none")
    assert free > 0.2
    assert held("cone") == free
    assert held("pyramid") == free
    assert abs(held("second point")) < 1e-4


@pytest.mark.parametrize("tgs", [True, False])
def test_a_joint_takes_the_turning_of_a_led_body_for_nought_under_pgs(tgs: bool) -> None:
    scene, system = world((0.0, 0.0, 0.0), 1e-3, enable_tgs=tgs)
    led, towed = physx.PhysxRigidDynamicComponent(), physx.PhysxRigidDynamicComponent()
    put(scene, led, (0.0, 0.0, 0.0))
    led.kinematic = True
    entity = sapien.Entity()
    entity.add_component(towed)
    entity.pose = sapien.Pose([0.5, 0.0, 0.0])
    joint = physx.PhysxDriveComponent(towed)
    joint.parent, joint.pose_in_parent = led, sapien.Pose([0.5, 0.0, 0.0])
    for lock in (joint.set_limit_x, joint.set_limit_y, joint.set_limit_z):
        lock(0.0, 0.0)
    entity.add_component(joint)
    scene.add_entity(entity)
    towed.set_linear_velocity([0.0, 0.5, 0.0])
    for k in range(1, 4):
        led.set_kinematic_target(sapien.Pose([0.0] * 3, [math.cos(k * 5e-4), 0.0, 0.0, math.sin(k * 5e-4)]))
        system.step()
    # At 1 rad/s half a metre out it ought to go on at .5 m/s.
    assert towed.linear_velocity[1] == pytest.approx(0.5 if tgs else 0.0, abs=1e-4)
    assert entity.pose.p[1] == pytest.approx(1.5e-3 if tgs else 1e-3, abs=1e-5)


def driven(articulated: bool, tgs: bool = True, iterations: int = 10, limit: float = 3e38) -> float:
    """Speed [m/s] of 2 kg after 0.3 s on a slide whose drive is 8 (0.5 - v) N."""
    scene, system = world((0.0, 0.0, 0.0), 1e-3, enable_tgs=tgs)
    physx.set_body_config(solver_position_iterations=iterations)
    if articulated:
        root = physx.PhysxArticulationLinkComponent(None)
        body = physx.PhysxArticulationLinkComponent(root)
        base, entity = sapien.Entity(), sapien.Entity()
        base.add_component(root)
        entity.add_component(body)
        root.joint.type, body.joint.type = "fixed", "prismatic"
        body.joint.limit = [[-np.inf, np.inf]]
        body.joint.set_friction(0.0)
        body.joint.set_drive_property(0.0, 8.0, 3e38, "force")
        body.joint.set_drive_velocity_target(0.5)
        scene.add_entity(base)
    else:
        body, entity = physx.PhysxRigidDynamicComponent(), sapien.Entity()
        entity.add_component(body)
        joint = physx.PhysxDriveComponent(body)
        joint.set_limit_y(0.0, 0.0)
        joint.set_limit_z(0.0, 0.0)
        joint.set_limit_cone(0.0, 0.0)
        joint.set_limit_twist(0.0, 0.0)
        joint.set_drive_property_x(0.0, 8.0, limit, "force")
        joint.set_drive_velocity_target([0.5, 0.0, 0.0], [0.0, 0.0, 0.0])
        entity.add_component(joint)
    body.mass, body.inertia = 2.0, [0.01] * 3
    body.linear_damping = body.angular_damping = 0.0
    scene.add_entity(entity)
    for _ in range(300):
        system.step()
    return float(body.linear_velocity[0])


def test_drives_of_constraints_miss_their_law_under_tgs_where_those_of_articulations_keep_it() -> None:
    """By half of what one iteration is of all, since the velocity iteration drives once more. Under PGS they keep it."""
    law = 0.5 * (1.0 - math.exp(-8.0 * 0.3 / 2.0))
    assert driven(True) == pytest.approx(law, rel=0.005)
    for iterations in (10, 50):
        assert driven(False, iterations=iterations) / law - 1.0 == pytest.approx(0.5 / iterations, rel=0.1)
        assert driven(False, tgs=False, iterations=iterations) == pytest.approx(law, rel=0.002)
    physx.set_scene_config(enable_tgs=True)


def test_the_limit_of_a_constraint_s_drive_is_one_of_its_impulse() -> None:
    """1 N over 0.3 s would bring 2 kg to 0.15 m/s; 1 N s a step is no limit here."""
    law = 0.5 * (1.0 - math.exp(-8.0 * 0.3 / 2.0))
    for tgs in (True, False):
        assert driven(False, tgs=tgs, limit=1.0) == pytest.approx(law, rel=0.06)
        assert driven(False, tgs=tgs, limit=1.0 / 1000) == pytest.approx(0.15, rel=0.06)
    physx.set_scene_config(enable_tgs=True)


def test_boxes_stacked_at_10_iterations_tremble_under_tgs_where_nothing_sleeps() -> None:
    speeds = {}
    for tgs in (True, False):
        scene, system = world(enable_tgs=tgs)
        material = physx.PhysxMaterial(0.5, 0.5, 0.0)
        ground = physx.PhysxRigidStaticComponent()
        ground.attach(physx.PhysxCollisionShapeBox([5.0, 5.0, 0.5], material))
        put(scene, ground, (0.0, 0.0, -0.5))
        boxes = []
        for k in range(6):
            box = physx.PhysxRigidDynamicComponent()
            box.attach(weightless(physx.PhysxCollisionShapeBox([0.1, 0.1, 0.1], material)))
            put(scene, box, (0.0, 0.0, 0.1 + 0.2 * k), 1.0, 1 / 150)
            boxes.append(box)
        squares = []
        for step in range(960):
            system.step()
            if step >= 480:
                squares.append(np.mean([float(box.linear_velocity @ box.linear_velocity) for box in boxes]))
        speeds[tgs] = math.sqrt(np.mean(squares))
    physx.set_scene_config(enable_tgs=True)
    assert speeds[True] > 10 * speeds[False]


def spun_on_a_patch(ball: float, ground: float, friction: float, tgs: bool = True) -> float:
    """Torque over mu N [m] that brakes a ball of 0.1 m that spins on the spot. Args: radii [m] of the patches of both."""
    scene, _ = world(enable_tgs=tgs)
    material = sapien.physx.PhysxMaterial(friction, friction, 0.0)
    floor, body = sapien.physx.PhysxRigidStaticComponent(), sapien.physx.PhysxRigidDynamicComponent()
    for component, shape, radius in (
        (floor, sapien.physx.PhysxCollisionShapePlane(material), ground),
        (body, sapien.physx.PhysxCollisionShapeSphere(0.1, material), ball),
    ):
        shape.density, shape.min_patch_radius, shape.patch_radius = 0.0, radius, radius
        component.attach(shape)
    entity = sapien.Entity()
    entity.add_component(floor)
    entity.pose = sapien.Pose([0, 0, 0], [math.sqrt(0.5), 0, -math.sqrt(0.5), 0])
    scene.add_entity(entity)
    put(scene, body, (0.0, 0.0, 0.1), moments=0.004)
    body.angular_damping = 0.0
    for _ in range(24):
        scene.step()
    body.angular_velocity = [0.0, 0.0, 5.0]
    rates = []
    for _ in range(2):
        for _ in range(12):
            scene.step()
        rates.append(float(body.angular_velocity[2]))
    return (rates[0] - rates[1]) / 0.05 * 0.004 / (friction * G)


@pytest.mark.parametrize(("ball", "ground"), [(0.01, 0.0), (0.0, 0.01), (0.01, 0.01), (0.01, 0.02), (0.02, 0.01)])
@pytest.mark.parametrize("friction", [0.2, 0.5])
def test_a_patch_of_contact_brakes_a_spin_by_the_larger_radius_times_mu_n(ball: float, ground: float, friction: float) -> None:
    assert spun_on_a_patch(ball, ground, friction) == pytest.approx(max(ball, ground), rel=1e-3)


def test_without_a_patch_or_under_pgs_nothing_does() -> None:
    assert abs(spun_on_a_patch(0.0, 0.0, 0.5)) < 1e-5
    assert abs(spun_on_a_patch(0.01, 0.01, 0.5, tgs=False)) < 1e-5


@pytest.mark.parametrize("ratio", [1.0, 2.0, -1.0])
def test_a_gear_ties_two_hinges(ratio: float) -> None:
    """0.1 N m for a second on the first of two wheels of 0.1 kg m2, held on hinges by constraints: w2 = -ratio w1."""
    scene, _ = world(gravity=(0.0, 0.0, 0.0))
    wheels = []
    for k in range(2):
        wheel = physx.PhysxRigidDynamicComponent()
        put(scene, wheel, (0.0, float(k), 0.0), moments=0.1)
        hinge = physx.PhysxDriveComponent(wheel)
        hinge.parent, hinge.pose_in_child, hinge.pose_in_parent = None, sapien.Pose(), sapien.Pose([0, k, 0])
        for axis in "xyz":
            getattr(hinge, f"set_limit_{axis}")(0, 0)
        hinge.set_limit_cone(0, 0)
        wheel.entity.add_component(hinge)
        wheels.append(wheel)
    gear = physx.PhysxGearComponent(wheels[1])
    gear.parent, gear.gear_ratio = wheels[0], ratio
    gear.pose_in_child = gear.pose_in_parent = sapien.Pose()
    wheels[1].entity.add_component(gear)
    gear.enable_hinges()
    for _ in range(240):
        wheels[0].add_force_torque([0, 0, 0], [0.1, 0, 0])
        scene.step()
    rates = [float(wheel.angular_velocity[0]) for wheel in wheels]
    assert rates == pytest.approx([1 / (1 + ratio**2), -ratio / (1 + ratio**2)], rel=1e-3)


@pytest.mark.parametrize("word", ["rolling", "ellipsoid", "combine", "ccd", "friction_anchor", "tangent", "sweep"])
def test_no_shape_body_material_or_contact_has_such_a_word(word: str) -> None:
    """`enable_ccd` is the scene's, and of bodies there is none."""
    px = sapien.physx
    kinds = (px.PhysxCollisionShape, px.PhysxRigidDynamicComponent, px.PhysxMaterial, px.PhysxContact, px.PhysxContactPoint)
    assert not [name for kind in kinds for name in dir(kind) if word in name.lower()]


def carried_round(tgs: bool, dt: float, iterations: int = 50) -> np.ndarray:
    """Where [m] a ball is after two seconds that rolls on a table which is led round at 1 rad/s, let go at rest 0.5 m out."""
    scene, system = world(dt=dt, enable_tgs=tgs)
    physx.set_body_config(solver_position_iterations=iterations, sleep_threshold=0.0)
    material = physx.PhysxMaterial(0.8, 0.8, 0.0)
    table, ball = physx.PhysxRigidDynamicComponent(), physx.PhysxRigidDynamicComponent()
    table.attach(weightless(physx.PhysxCollisionShapeBox([3.0, 3.0, 0.1], material)))
    ball.attach(weightless(physx.PhysxCollisionShapeSphere(0.1, material)))
    put(scene, table, (0.0, 0.0, -0.1))
    table.kinematic = True
    entity = put(scene, ball, (0.5, 0.0, 0.1), 1.0, 4e-3)
    for step in range(1, round(2.0 / dt) + 1):
        angle = step * dt / 2
        table.set_kinematic_target(sapien.Pose([0.0, 0.0, -0.1], [math.cos(angle), 0.0, 0.0, math.sin(angle)]))
        system.step()
    return np.array(entity.pose.p)


def test_a_ball_on_a_table_that_is_led_round_goes_astray_under_pgs_and_not_under_tgs() -> None:
    """Against TGS in steps of a quarter."""
    right = carried_round(True, 1 / 960)
    assert np.linalg.norm(carried_round(True, 1 / 240) - right) < 5e-3
    assert np.linalg.norm(carried_round(False, 1 / 240) - right) > 5e-2
    physx.set_scene_config(enable_tgs=True)


def crept(tgs: bool, iterations: int) -> float:
    """How far [m] a box goes in four seconds, after a first one, on a slope of .45 on which a friction of .5 holds it."""
    slope = math.atan(0.45)
    scene, system = world((G * math.sin(slope), 0.0, -G * math.cos(slope)), enable_tgs=tgs)
    physx.set_body_config(solver_position_iterations=iterations, sleep_threshold=0.0)
    material = physx.PhysxMaterial(0.5, 0.5, 0.0)
    ground, box = physx.PhysxRigidStaticComponent(), physx.PhysxRigidDynamicComponent()
    ground.attach(physx.PhysxCollisionShapeBox([5.0, 5.0, 0.5], material))
    box.attach(weightless(physx.PhysxCollisionShapeBox([0.1, 0.1, 0.1], material)))
    put(scene, ground, (0.0, 0.0, -0.5))
    entity = put(scene, box, (0.0, 0.0, 0.1), 1.0, 1 / 150)
    places = []
    for _ in range(5):
        for _ in range(240):
            system.step()
        places.append(float(entity.pose.p[0]))
    return places[-1] - places[0]


@pytest.mark.parametrize("tgs", [True, False])
def test_a_box_creeps_on_a_slope_at_10_iterations_and_not_at_50(tgs: bool) -> None:
    assert crept(tgs, 10) > 1e-4
    assert abs(crept(tgs, 50)) < 2e-6
    physx.set_scene_config(enable_tgs=True)


def test_ten_boxes_stacked_sink_by_a_tenth_of_a_millimetre_together_since_contacts_are_no_springs() -> None:
    scene, system = world(enable_tgs=True)
    material = physx.PhysxMaterial(0.5, 0.5, 0.0)
    ground = physx.PhysxRigidStaticComponent()
    ground.attach(physx.PhysxCollisionShapeBox([5.0, 5.0, 0.5], material))
    put(scene, ground, (0.0, 0.0, -0.5))
    for k in range(10):
        box = physx.PhysxRigidDynamicComponent()
        box.attach(weightless(physx.PhysxCollisionShapeBox([0.1, 0.1, 0.1], material)))
        top = put(scene, box, (0.0, 0.0, 0.1 + 0.2 * k), 1.0, 1 / 150)
    for _ in range(960):
        system.step()
    assert abs(top.pose.p[2] - 1.9) < 2e-4
