"""Why PhysX is best or worst of some cases, in sapien's own words."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest

from tests.vendor.sapien_world import G, physx, put, sapien, weightless, world

pytestmark = pytest.mark.sapien
UPRIGHT, ACROSS = [math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0], [math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]
"""What turns x to z, and to y."""
FREE = np.array([[-np.inf, np.inf]], dtype=np.float32)


@pytest.fixture(autouse=True)
def _as_it_came() -> Iterator[None]:
    yield
    physx.set_scene_config(enable_tgs=True, bounce_threshold=2.0)
    physx.set_body_config()
    physx.set_shape_config()


def solved(iterations: int, sleep_threshold: float = 0.0) -> None:
    physx.set_body_config(solver_position_iterations=iterations, solver_velocity_iterations=1, sleep_threshold=sleep_threshold)


def floor(scene: Any, material: Any) -> None:
    """A wide box under z = 0."""
    component = physx.PhysxRigidStaticComponent()
    component.attach(physx.PhysxCollisionShapeBox([20.0, 20.0, 0.5], material))
    put(scene, component, (0.0, 0.0, -0.5))


def solid(scene: Any, shape: Any, p: tuple[float, float, float], mass: float = 1.0, moments: float = 0.01) -> tuple[Any, Any]:
    """A body of one shape without damping, and its entity."""
    body = physx.PhysxRigidDynamicComponent()
    body.attach(weightless(shape))
    return body, put(scene, body, p, mass, moments)


# What bodies come with: damping, caps, sleep


def spins_on(damping: float | None) -> float:
    """What is left after 20 s of a spin of 2 rad/s. Args: damping: None as it comes."""
    scene, system = world((0.0, 0.0, 0.0), 1 / 120)
    body, entity = physx.PhysxRigidDynamicComponent(), sapien.Entity()
    body.mass, body.inertia = 1.0, [0.1] * 3
    if damping is not None:
        body.angular_damping = damping
    entity.add_component(body)
    scene.add_entity(entity)
    body.set_angular_velocity([0.0, 0.0, 2.0])
    for _ in range(2400):
        system.step()
    return float(body.angular_velocity[2]) / 2.0


def test_a_body_comes_with_a_damping_of_a_twentieth_of_its_spin_a_second() -> None:
    assert spins_on(None) == pytest.approx(math.exp(-0.05 * 20), rel=2e-3)
    assert spins_on(0.0) == pytest.approx(1.0, rel=2e-3)


def drifts_on(damping: float | None) -> float:
    """What is left [m/s] after 2 s of 1 m/s of a free articulation of two links. Args: damping: None as it comes."""
    scene, system = world((0.0, 0.0, 0.0))
    root = physx.PhysxArticulationLinkComponent(None)
    for link in (root, physx.PhysxArticulationLinkComponent(root)):
        entity = sapien.Entity()
        link.mass, link.inertia = 1.0, [0.1] * 3
        link.joint.type = "undefined" if link is root else "fixed"
        if damping is not None:
            link.linear_damping = link.angular_damping = damping
        entity.add_component(link)
        scene.add_entity(entity)
    root.articulation.set_root_linear_velocity([1.0, 0.0, 0.0])
    for _ in range(480):
        system.step()
    return float(root.linear_velocity[0])


def test_a_link_comes_with_a_damping_of_its_speed_too() -> None:
    assert drifts_on(None) == pytest.approx(math.exp(-0.05 * 2), rel=2e-3)
    assert drifts_on(0.0) == pytest.approx(1.0, rel=1e-4)


def swung(damping: float | None) -> float:
    """Share of its energy that a rod of an articulation has after ten seconds of swinging from 30 degrees."""
    scene, system = world()
    root = physx.PhysxArticulationLinkComponent(None)
    rod, base, entity = physx.PhysxArticulationLinkComponent(root), sapien.Entity(), sapien.Entity()
    base.add_component(root)
    entity.add_component(rod)
    root.joint.type, rod.joint.type = "fixed", "revolute_unwrapped"
    rod.mass, rod.inertia = 1.0, [1 / 12, 1 / 12, 1e-4]
    if damping is not None:
        rod.linear_damping = rod.angular_damping = damping
    rod.joint.pose_in_parent, rod.joint.pose_in_child = sapien.Pose([0.0] * 3, ACROSS), sapien.Pose([0.0, 0.0, 0.5], ACROSS)
    rod.joint.limit = FREE
    rod.joint.set_friction(0.0)
    scene.add_entity(base)
    scene.add_entity(entity)
    root.articulation.set_qpos(np.array([math.radians(30.0)], dtype=np.float32))
    for _ in range(2400):
        system.step()
    angle, rate = float(root.articulation.qpos[0]), float(root.articulation.qvel[0])
    energy = rate**2 / 6 + G / 2 * (1 - math.cos(angle))
    return energy / (G / 2 * (1 - math.cos(math.radians(30.0))))


def test_by_it_a_pendulum_loses_a_third_of_its_energy_in_ten_seconds() -> None:
    assert 0.5 < swung(None) < 0.75
    assert swung(0.0) == pytest.approx(1.0, abs=0.01)


def capped(link: bool, turn: float, speed: float, free: bool) -> tuple[float, float]:
    """Spin and speed a step after a body, or a link, was told them [rad/s, m/s]. Args: free: are the caps lifted?"""
    scene, system = world((0.0, 0.0, 0.0))
    body = physx.PhysxArticulationLinkComponent(None) if link else physx.PhysxRigidDynamicComponent()
    put(scene, body, (0.0, 0.0, 0.0))
    if free:
        body.max_angular_velocity = body.max_linear_velocity = 1e16
    if link:
        body.articulation.set_root_linear_velocity([speed, 0.0, 0.0])
        body.articulation.set_root_angular_velocity([0.0, 0.0, turn])
    else:
        body.set_linear_velocity([speed, 0.0, 0.0])
        body.set_angular_velocity([0.0, 0.0, turn])
    system.step()
    return float(body.angular_velocity[2]), float(body.linear_velocity[0])


def test_turns_and_the_speeds_of_links_are_cut() -> None:
    """A ball of a tenth of a millimetre that rolls, and a rod as long as a hill that swings, pass what bodies come with."""
    for link, most, fastest in ((False, 100.0, 31.6), (True, 50.0, 10.0)):
        assert capped(link, 300.0, 31.6, free=False) == pytest.approx((most, fastest), rel=0.01)
        assert capped(link, 300.0, 31.6, free=True) == pytest.approx((300.0, 31.6), rel=1e-4)


def crept(sleep_threshold: float) -> tuple[float, float]:
    """How far [m] a box goes in two seconds on a slope of 10 degrees, after half a one, and its most speed [m/s] in them."""
    lean = math.radians(10.0)
    scene, system = world((G * math.sin(lean), 0.0, -G * math.cos(lean)))
    solved(10, sleep_threshold)
    material = physx.PhysxMaterial(0.5, 0.5, 0.0)
    floor(scene, material)
    body, entity = solid(scene, physx.PhysxCollisionShapeBox([0.1, 0.1, 0.05], material), (0.0, 0.0, 0.05))
    way, fastest = 0.0, 0.0
    for step in range(600):
        if step == 120:
            way = float(entity.pose.p[0])
        system.step()
        if step >= 120:
            fastest = max(fastest, float(np.linalg.norm(body.linear_velocity)))
    return float(entity.pose.p[0]) - way, fastest


def test_a_box_on_a_slope_creeps_by_nothing_since_it_sleeps() -> None:
    assert crept(5e-3) == (0.0, 0.0)
    assert crept(0.0)[1] > 1e-5


# Impacts


def struck(gaps: float, threshold: float, balls: int = 5, speed: float = 0.5) -> list[float]:
    """Velocities [m/s] of a row of elastic balls after the first came at the others."""
    scene, system = world((0.0, 0.0, 0.0), 1 / 960, bounce_threshold=threshold)
    material = physx.PhysxMaterial(0.0, 0.0, 1.0)
    row = [
        solid(scene, physx.PhysxCollisionShapeSphere(0.02, material), ((0.04 + gaps) * k - 0.03 * (k == 0), 0.0, 0.0), 0.1)[0]
        for k in range(balls)
    ]
    row[0].set_linear_velocity([speed, 0.0, 0.0])
    for _ in range(round(0.125 / speed * 960)):
        system.step()
    return [float(ball.linear_velocity[0]) for ball in row]


def test_nothing_rebounds_that_closes_at_less_than_two_metres_a_second() -> None:
    """Below the threshold a cradle goes on as one; a gas at 1 m/s loses energy at each impact."""
    assert struck(1e-3, threshold=2.0) == pytest.approx([0.1] * 5, abs=1e-4)
    assert struck(1e-3, threshold=1e-3) == pytest.approx([0.0] * 4 + [0.5], abs=1e-4)
    assert struck(1e-3, threshold=2.0, balls=2, speed=1.9) == pytest.approx([0.95, 0.95], abs=1e-4)
    assert struck(1e-3, threshold=2.0, balls=2, speed=2.1) == pytest.approx([0.0, 2.1], abs=1e-4)


def thrown(gap: float, tgs: bool, contact_offset: float, threshold: float = 1e-3) -> tuple[float, float]:
    """Velocity [m/s], along and up, of a rough ball that met the ground at 1 m/s along and 2 m/s down."""
    scene, system = world((0.0, 0.0, 0.0), enable_tgs=tgs, bounce_threshold=threshold)
    physx.set_shape_config(contact_offset=contact_offset)
    material = physx.PhysxMaterial(0.3, 0.3, 0.6)
    floor(scene, material)
    ball, _ = solid(scene, physx.PhysxCollisionShapeSphere(0.2, material), (0.0, 0.0, 0.2 + gap), moments=0.016)
    ball.set_linear_velocity([1.0, 0.0, -2.0])
    for _ in range(24):
        system.step()
    return float(ball.linear_velocity[0]), float(ball.linear_velocity[2])


def test_a_ball_that_is_turned_before_it_touches_meets_no_friction() -> None:
    """Ground that grips leaves 5/7 of the speed along. Contacts are found a hundredth of a metre away; a ball that has 8 mm to
    go rebounds in that step, and its skin never touches."""
    assert thrown(0.05, tgs=True, contact_offset=0.01) == pytest.approx((1.0, 1.2), abs=1e-3)
    assert thrown(0.05, tgs=False, contact_offset=0.01) == pytest.approx((1.0, 1.2), abs=1e-3)
    for gap in (0.05, 0.0517, 0.0533, 0.055):
        assert thrown(gap, tgs=False, contact_offset=1e-6) == pytest.approx((5 / 7, 1.2), abs=0.02)
    assert thrown(0.05, tgs=False, contact_offset=1e-6, threshold=2.01)[1] < 0.01


def met(gap: float, tgs: bool, contact_offset: float) -> float:
    """By how much [m/s] a ball errs, by Newton's law, that came at 1 m/s on one of a thousand times its mass, e = .5."""
    scene, system = world((0.0, 0.0, 0.0), enable_tgs=tgs, bounce_threshold=1e-3)
    solved(50)
    physx.set_shape_config(contact_offset=contact_offset)
    material, ratio = physx.PhysxMaterial(0.0, 0.0, 0.5), 1000.0
    light, _ = solid(scene, physx.PhysxCollisionShapeSphere(0.1, material), (0.0, 0.0, 0.0))
    solid(scene, physx.PhysxCollisionShapeSphere(0.1, material), (0.2 + gap, 0.0, 0.0), ratio, 10.0)
    light.set_linear_velocity([1.0, 0.0, 0.0])
    for _ in range(24):
        system.step()
    return abs(float(light.linear_velocity[0]) - (1.0 - ratio * 0.5) / (1.0 + ratio))


def test_under_pgs_a_rebound_is_exact_where_contacts_begin_at_a_touch() -> None:
    """What PGS foresees it turns by too much, or too little."""
    gaps = [0.02 + 1e-3 * k for k in range(5)]
    assert max(met(gap, tgs=False, contact_offset=1e-6) for gap in gaps) < 1e-6
    assert max(met(gap, tgs=False, contact_offset=0.01) for gap in gaps) > 0.01


def rebounded(restitution: float, tgs: bool) -> tuple[float, float, float]:
    """Of a ball dropped from a metre: its gap [m] to the ground and speed [m/s] before it turns, and how high it comes then."""
    scene, system = world(enable_tgs=tgs, bounce_threshold=2.0)
    material = physx.PhysxMaterial(0.0, 0.0, restitution)
    floor(scene, material)
    ball, entity = solid(scene, physx.PhysxCollisionShapeSphere(0.1, material), (0.0, 0.0, 1.1))
    gap, speed = 1.0, 0.0
    while ball.linear_velocity[2] <= 0:
        gap, speed = float(entity.pose.p[2]) - 0.1, -float(ball.linear_velocity[2])
        system.step()
    highest = 0.0
    while ball.linear_velocity[2] > 0:
        highest = max(highest, float(entity.pose.p[2]) - 0.1)
        system.step()
    return gap, speed, highest


@pytest.mark.parametrize("e", [0.5, 0.8, 0.95, 1.0])
def test_a_ball_is_turned_a_step_before_it_touches_and_under_tgs_what_that_costs_cancels(e: float) -> None:
    """TGS ends that step at e times the gap that it began with, PGS at the gap and a step's way up. With semi-implicit Euler's
    energy, v^2/2 + g z - g v dt/2, and a rebound of e (v + g dt), the heights follow."""
    gap, speed, highest = rebounded(e, tgs=True)
    way = speed / 240
    assert 0.0 < gap < way
    assert highest - e**2 == pytest.approx(e * (1 - e) * (gap - way / 2), abs=1e-4)
    gap, speed, highest = rebounded(e, tgs=False)
    assert highest - e**2 == pytest.approx((1 - e**2) * gap + e * (1 + e) * way / 2, abs=2e-4)


# Turning


def turned(moments: Sequence[float], spin: Sequence[float], dt: float, steps: int) -> np.ndarray:
    """Angular momenta (steps, 3) of a free body under PGS, in single precision."""
    scene, system = world((0.0, 0.0, 0.0), dt, enable_tgs=False)
    body = physx.PhysxRigidDynamicComponent()
    entity = put(scene, body, (0.0, 0.0, 0.0))
    body.inertia, body.max_angular_velocity = list(moments), 1e16
    body.set_angular_velocity(list(spin))
    momenta = []
    for _ in range(steps):
        system.step()
        there = np.array(entity.pose.to_transformation_matrix()[:3, :3], dtype=np.float64)
        momenta.append(there @ (np.array(moments) * (there.T @ np.array(body.angular_velocity, dtype=np.float64))))
    return np.array(momenta)


def stepped(moments: Sequence[float], spin: Sequence[float], dt: float, steps: int) -> np.ndarray:
    """The same in double precision: Euler's step L - (w x L) dt in the body, brought back to the length of L, then the turn."""
    inertia, there, w, momenta = np.array(moments), np.eye(3), np.array(spin), []
    for _ in range(steps):
        inside = there.T @ w
        before = inertia * inside
        after = before - np.cross(inside, before) * dt
        w = there @ (after * np.linalg.norm(before) / np.linalg.norm(after) / inertia)
        (x, y, z), angle = w / np.linalg.norm(w), np.linalg.norm(w) * dt
        k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        there = (np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * (k @ k)) @ there
        momenta.append(there @ (inertia * (there.T @ w)))
    return np.array(momenta)


PLATE = ((4.25e-6, 9.25e-6, 1.3e-5), (80.2, 10.0, 58.9))
RACKET = ((1.0, 2.0, 2.5), (0.1, 1.5, 0.6))


@pytest.mark.parametrize(("body", "seconds", "drift"), [(PLATE, 2.0, 0.43), (RACKET, 20.0, 3.1e-3)])
def test_a_spin_is_stepped_by_euler_in_the_body_and_keeps_the_size_of_its_momentum_alone(
    body: tuple[tuple[float, ...], tuple[float, ...]], seconds: float, drift: float
) -> None:
    """Its direction goes astray by the first order of the step, which is .4 rad for a fast plate."""
    start = np.array(body[0]) * np.array(body[1])
    size = float(np.linalg.norm(start))
    momenta = turned(*body, 1 / 240, round(240 * seconds))
    assert np.abs(np.linalg.norm(momenta, axis=1) / size - 1).max() < 1e-4
    assert np.linalg.norm(momenta - start, axis=1).max() / size == pytest.approx(drift, rel=0.05)
    short = round(24 * seconds)
    assert np.abs(momenta[:short] - stepped(*body, 1 / 240, short)).max() / size < 1e-5
    finer = np.linalg.norm(turned(*body, 1 / 960, round(960 * seconds)) - start, axis=1).max() / size
    assert finer < 0.35 * drift


# Joints


def circled(constraint: bool, dt: float = 1 / 240) -> float:
    """By what share the radius of a conical pendulum of a metre at 30 degrees is off within ten seconds, at 50 iterations.

    Args: constraint: hangs it on a ball, which is one, or on two hinges of an articulation, a yoke of a milligram between?
    """
    scene, system = world(dt=dt)
    solved(50)
    tilt, inertia = math.radians(30.0), 1e-3
    rate, at = math.sqrt(G / math.cos(tilt)), (math.sin(tilt), 0.0, -math.cos(tilt))
    from_bob = [-at[0], 0.0, -at[2]]
    if constraint:
        bob = physx.PhysxRigidDynamicComponent()
        entity = put(scene, bob, at, moments=inertia)
        ball = physx.PhysxDriveComponent(bob)
        ball.pose_in_child = sapien.Pose(from_bob)
        for lock in (ball.set_limit_x, ball.set_limit_y, ball.set_limit_z):
            lock(0.0, 0.0)
        entity.add_component(ball)
        bob.set_linear_velocity([0.0, rate * math.sin(tilt), 0.0])
        bob.set_angular_velocity([0.0, 0.0, rate])
    else:
        root = physx.PhysxArticulationLinkComponent(None)
        yoke = physx.PhysxArticulationLinkComponent(root)
        bob = physx.PhysxArticulationLinkComponent(yoke)
        entities = [sapien.Entity() for _ in range(3)]
        root.joint.type = "fixed"
        for link, axis, end in ((yoke, UPRIGHT, [0.0] * 3), (bob, ACROSS, from_bob)):
            link.joint.type, link.joint.limit = "revolute_unwrapped", FREE
            link.joint.set_friction(0.0)
            link.joint.pose_in_parent, link.joint.pose_in_child = sapien.Pose([0.0] * 3, axis), sapien.Pose(end, axis)
        for link, entity, mass, moments in zip(
            (root, yoke, bob), entities, (1.0, 1e-6, 1.0), (1.0, 1e-9, inertia), strict=True
        ):
            link.mass, link.inertia = mass, [moments] * 3
            link.linear_damping = link.angular_damping = 0.0
            entity.add_component(link)
        for entity in entities:
            scene.add_entity(entity)
        root.articulation.set_qvel(np.array([rate, 0.0], dtype=np.float32))
    off = 0.0
    for _ in range(round(10 / dt)):
        system.step()
        off = max(off, abs(math.hypot(*entity.pose.p[:2]) / math.sin(tilt) - 1))
    return off


def test_a_ball_joint_is_a_constraint_of_first_order_where_hinges_of_an_articulation_circle_to_rounding() -> None:
    assert circled(constraint=True) == pytest.approx(2.96e-3, rel=0.05)
    assert circled(constraint=True, dt=1 / 480) == pytest.approx(1.48e-3, rel=0.05)
    assert circled(constraint=False) < 1e-5
    root = physx.PhysxArticulationLinkComponent(None)
    link = physx.PhysxArticulationLinkComponent(root)
    with pytest.raises(RuntimeError, match="spherical joint is not supported"):
        link.joint.type = "spherical"


COLUMN: tuple[
    tuple[float, tuple[float, float], tuple[float, float, float], tuple[float, float], list[float], float, float], ...
]
COLUMN = (
    (1.3, (0.05, 0.033), (3e-3, 5e-3, 6e-3), (0.0, 0.0), ACROSS, 0.0, 0.0),
    (0.6, (0.0, 0.066), (6e-4, 6e-4, 6e-4), (0.0, 0.066), [1.0, 0.0, 0.0, 0.0], 3000.0, 200.0),
    (6.0, (0.06, 0.3), (0.09, 0.09, 0.01), (0.0, 0.066), ACROSS, 3000.0, 200.0),
    (19.0, (0.08, 0.66), (0.27, 0.27, 0.05), (0.084, 0.48), ACROSS, 4000.0, 30.0),
    (2.0, (0.045, 0.88), (2e-3, 2e-3, 2e-3), (0.045, 0.88), ACROSS, 4000.0, 30.0),
    (41.0, (0.04, 1.2), (2.0, 2.0, 0.5), (0.045, 0.88), [1.0, 0.0, 0.0, 0.0], 1200.0, 10.0),
)
"""Foot, ankle, shank, thigh, hip and trunk of a column of 70 kg: mass [kg], x and z of its centre [m], moments [kg m2], x and z
of the hinge to what is below, the turn of its axis, stiffness and damping of its drive [N m/rad, N m s/rad]."""


def column(iterations: int, foot: float = 1.0, dt: float = 1 / 240) -> float:
    """How far [mm] the trunk is after three seconds under PGS, of drives whose targets make up for the weight.

    Args: foot: what the foot's moments of inertia are multiplied by.
    """
    scene, system = world(dt=dt, enable_tgs=False)
    solved(iterations)
    rough = physx.PhysxMaterial(0.8, 0.8, 0.0)
    floor(scene, rough)
    links: list[Any] = []
    entities: list[Any] = []
    centres = [np.array([part[1][0], 0.0, part[1][1]]) for part in COLUMN]
    for k, (mass, _, moments, (x, z), axis, stiffness, damping) in enumerate(COLUMN):
        link, entity = physx.PhysxArticulationLinkComponent(links[-1] if links else None), sapien.Entity()
        link.mass, link.inertia = mass, [(foot if k == 0 else 1.0) * moment for moment in moments]
        link.linear_damping = link.angular_damping = 0.0
        if k == 0:
            link.joint.type = "undefined"
            sole = weightless(physx.PhysxCollisionShapeBox([0.125, 0.15, 0.033], rough))
            sole.local_pose = sapien.Pose([0.07 - centres[0][0], 0.0, 0.0])
            link.attach(sole)
        else:
            hinge, at = link.joint, np.array([x, 0.0, z])
            hinge.type, hinge.limit = "revolute_unwrapped", FREE
            hinge.pose_in_parent = sapien.Pose((at - centres[k - 1]).tolist(), axis)
            hinge.pose_in_child = sapien.Pose((at - centres[k]).tolist(), axis)
            hinge.set_friction(0.0)
            hinge.set_drive_property(stiffness, damping, 3e38, "force")
            tips = sum(part[0] * G * (part[1][0] - x) for part in COLUMN[k:]) if axis is ACROSS else 0.0
            hinge.set_drive_target(-tips / stiffness)
        entity.add_component(link)
        entity.pose = sapien.Pose(centres[k].tolist())
        links.append(link)
        entities.append(entity)
    for entity in entities:
        scene.add_entity(entity)
    for _ in range(round(3 / dt)):
        system.step()
    return 1e3 * math.dist(entities[-1].pose.p, centres[-1])


def test_fifty_iterations_have_not_converged_where_a_light_foot_bears_a_man() -> None:
    assert column(50) == pytest.approx(3.7, rel=0.1)
    assert column(200) == pytest.approx(0.72, rel=0.1)
    assert column(50, foot=5.0) == pytest.approx(0.65, rel=0.1)
    assert column(200, foot=5.0) < 0.05
    assert column(50, dt=1 / 960) < 0.3


# Contacts


def trembled(ground: str, sleep_threshold: float = 0.0) -> float:
    """Most change of velocity from step to step [m/s] of the third second of a box at rest, at 50 iterations of PGS.

    Args: ground: 'plane', turned upright; 'plane along x', with gravity along its own normal; 'box'.
    """
    along = 0 if ground == "plane along x" else 2
    scene, system = world((-G, 0.0, 0.0) if along == 0 else (0.0, 0.0, -G), enable_tgs=False)
    solved(50, sleep_threshold)
    smooth = physx.PhysxMaterial(0.0, 0.0, 0.0)
    if ground == "box":
        floor(scene, smooth)
    else:
        plane, entity = physx.PhysxRigidStaticComponent(), sapien.Entity()
        plane.attach(physx.PhysxCollisionShapePlane(smooth))
        entity.add_component(plane)
        entity.pose = sapien.Pose([0.0] * 3, UPRIGHT if along == 2 else [1.0, 0.0, 0.0, 0.0])
        scene.add_entity(entity)
    shape = physx.PhysxCollisionShapeBox([0.1, 0.1, 0.1], smooth)
    box, _ = solid(scene, shape, (0.1, 0.0, 0.0) if along == 0 else (0.0, 0.0, 0.1), moments=1 / 150)
    velocities = []
    for step in range(720):
        system.step()
        if step >= 480:
            velocities.append([*box.linear_velocity, *(0.1 * box.angular_velocity)])
    return float(np.abs(np.diff(velocities, axis=0)).max())


def test_a_box_at_rest_trembles_on_a_plane_since_the_turn_of_its_normal_is_rounded() -> None:
    """The root of a half is off by 2e-8 of itself in single precision."""
    assert 1e-7 < trembled("plane") < 1e-5
    assert trembled("plane along x") < 1e-8
    assert trembled("box") < 1e-8
    assert trembled("plane", sleep_threshold=5e-3) == 0.0


def piled(iterations: int, tgs: bool = True) -> float:
    """How deep [m] a ball sinks into four others that lie in a tray, and these into each other and the tray, in a second."""
    scene, system = world(enable_tgs=tgs)
    solved(iterations)
    r, rough = 0.05, physx.PhysxMaterial(0.5, 0.5, 0.0)
    floor(scene, rough)
    for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        wall = physx.PhysxRigidStaticComponent()
        wall.attach(physx.PhysxCollisionShapeBox([0.1 if x else 0.5, 0.1 if y else 0.5, 0.5], rough))
        put(scene, wall, (x * (2 * r + 0.1), y * (2 * r + 0.1), 0.5))
    places = [(x * r, y * r, r) for x in (-1, 1) for y in (-1, 1)] + [(0.0, 0.0, r * (1 + math.sqrt(2.0)))]
    balls = [solid(scene, physx.PhysxCollisionShapeSphere(r, rough), place, 0.5, 5e-4)[1] for place in places]
    for _ in range(240):
        system.step()
    p = np.array([ball.pose.p for ball in balls], dtype=np.float64)
    apart = [2 * r - np.linalg.norm(a - b) for k, a in enumerate(p) for b in p[:k]]
    return float(max(*apart, (r - p[:, 2]).max(), (np.abs(p[:4, :2]) - r).max()))


def test_what_is_piled_sinks_by_what_iterations_leave_and_by_no_spring() -> None:
    """From 10 to 50 iterations depths fall to the roundings of single precision."""
    assert piled(1) > 1e-4
    assert piled(10) < 2e-5
    assert piled(50, tgs=False) < 1e-7


def arched(iterations: int) -> float:
    """How far [m] the crown of an arch of nine voussoirs of a metre has sunk after two seconds; infinite where it fell."""
    scene, system = world()
    solved(iterations)
    rough, half = physx.PhysxMaterial(0.8, 0.8, 0.0), math.pi / 18
    floor(scene, rough)
    (a, low), (b, high) = ((r * math.sin(half), r * math.cos(half)) for r in (0.9, 1.1))
    away = low + (high - low) * (a + 2 * b) / (3 * (a + b))
    section = ((-a, low - away), (a, low - away), (b, high - away), (-b, high - away))
    corners = np.array([(x, y, z) for x, z in section for y in (-0.2, 0.2)], dtype=np.float32)
    blocks = []
    for k in range(9):
        turn = math.pi * ((k + 0.5) / 9 - 0.5)
        block = physx.PhysxRigidDynamicComponent()
        block.attach(weightless(physx.PhysxCollisionShapeConvexMesh(corners, [1.0] * 3, rough)))
        at = (away * math.sin(turn), 0.0, away * math.cos(turn))
        entity = put(scene, block, at, 56.0, 1.0)
        entity.pose = sapien.Pose(list(at), [math.cos(turn / 2), 0.0, math.sin(turn / 2), 0.0])
        blocks.append(entity)
    for _ in range(480):
        system.step()
    sunk = away - float(blocks[4].pose.p[2])
    return sunk if sunk < 0.1 else math.inf


def test_an_arch_sinks_by_what_iterations_leave() -> None:
    assert 1e-3 < arched(10) < 2e-3
    assert 3 * arched(10) < arched(1) < 1e-2
    assert arched(50) < arched(10) / 3


# Friction


def slid(angle: float, turn: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> np.ndarray:
    """Where [m] a box stops that slid off at 2 m/s, seen from its floor. Args: turn: of floor, box and gravity [rad]."""
    size = float(np.linalg.norm(turn))
    axis = np.array(turn) / size if size else np.zeros(3)
    stage = sapien.Pose([0.0] * 3, [math.cos(size / 2), *(math.sin(size / 2) * axis)])
    there = stage.to_transformation_matrix()[:3, :3]
    scene, system = world(tuple((there @ [0.0, 0.0, -G]).tolist()))
    material = physx.PhysxMaterial(0.3, 0.3, 0.0)
    ground = physx.PhysxRigidStaticComponent()
    ground.attach(physx.PhysxCollisionShapeBox([5.0, 5.0, 0.5], material))
    put(scene, ground, (0.0, 0.0, 0.0)).pose = stage * sapien.Pose([0.0, 0.0, -0.5])
    box, entity = solid(scene, physx.PhysxCollisionShapeBox([0.1, 0.1, 0.05], material), (0.0, 0.0, 0.0), moments=0.005)
    entity.pose = stage * sapien.Pose([0.0, 0.0, 0.05])
    box.set_linear_velocity((there @ [2 * math.cos(angle), 2 * math.sin(angle), 0.0]).tolist())
    for _ in range(240):
        system.step()
    return np.array((stage.inv() * entity.pose).p, dtype=np.float64)


def test_friction_knows_no_axes() -> None:
    """Of a box that slides, and of the world: two fixed axes of friction would stop it sooner or later by up to 1.4 times."""
    way = 4.0 / (2 * 0.3 * G) - 1 / 240
    for angle in np.linspace(0.0, math.pi, 13):
        right = way * np.array([math.cos(angle), math.sin(angle), 0.0]) + [0.0, 0.0, 0.05]
        for turn in ((0.0, 0.0, 0.0), (0.26, 0.52, 0.4)):
            assert np.linalg.norm(slid(float(angle), turn) - right) < 5e-5


def passed(dt: float) -> float:
    """Way [m] in a second from rest, on a slope of .75, with a friction of .5."""
    lean = math.atan(0.75)
    scene, system = world((G * math.sin(lean), 0.0, -G * math.cos(lean)), dt)
    material = physx.PhysxMaterial(0.5, 0.5, 0.0)
    floor(scene, material)
    _, entity = solid(scene, physx.PhysxCollisionShapeBox([0.1, 0.1, 0.025], material), (0.0, 0.0, 0.025))
    for _ in range(round(1 / dt)):
        system.step()
    return float(entity.pose.p[0])


@pytest.mark.parametrize("dt", [1 / 240, 1 / 960])
def test_a_box_that_slides_errs_by_the_step_alone(dt: float) -> None:
    """Semi-implicit Euler goes a (1 + dt)/2 in a second, with a = g (.6 - .4)."""
    assert passed(dt) == pytest.approx(0.2 * G * (1 + dt) / 2, abs=2e-5)
