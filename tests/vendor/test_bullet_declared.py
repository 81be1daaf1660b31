"""What is declared that Bullet lacks or refuses, tried as its advocate would: by every word of pybullet that might say it."""

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

G = 9.81
DT = 1 / 240
CUBE = [list(corner) for corner in itertools.product((-0.1, 0.1), repeat=3)]


def slide(world: World, mass: float) -> int:
    """A slide along x that nothing drives, with its own mass [kg], without damping."""
    number: int = world.createMultiBody(
        0.0, -1, -1, linkMasses=[mass], linkCollisionShapeIndices=[-1], linkVisualShapeIndices=[-1],
        linkPositions=[[0, 0, 0]], linkOrientations=[[0, 0, 0, 1]], linkInertialFramePositions=[[0, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]], linkParentIndices=[0], linkJointTypes=[pybullet.JOINT_PRISMATIC],
        linkJointAxis=[[1, 0, 0]],
    )  # fmt: skip
    world.release(number, MULTIBODY)
    world.setJointMotorControl2(number, 0, pybullet.VELOCITY_CONTROL, force=0)
    return number


def pd(world: World, stiffness: float, damping: float, seconds: float) -> float:
    """Where a slide of 2 kg is [m] that PD_CONTROL pulls to 0 from 0.1 m."""
    number = slide(world, 2.0)
    world.resetJointState(number, 0, 0.1)
    world.setJointMotorControl2(
        number, 0, pybullet.PD_CONTROL, targetPosition=0, targetVelocity=0, positionGain=stiffness, velocityGain=damping,
        force=1e9,
    )  # fmt: skip
    for _ in range(round(seconds / DT)):
        world.stepSimulation()
    return float(world.getJointState(number, 0)[0])


def test_pd_control_is_a_spring_in_newtons_per_metre_with_the_force_of_the_step_s_start(world: World) -> None:
    """v' = v - h (k x + d v)/m, x' = x + h v', to rounding, told once: the manual does not name this mode."""
    x, v = 0.1, 0.0
    for _ in range(240):
        v -= DT * (50.0 * x + 1.0 * v) / 2.0
        x += DT * v
    assert pd(world, 50.0, 1.0, 1.0) == pytest.approx(x, abs=1e-9)


def test_pd_control_blows_up_where_a_step_is_long_for_it(world: World) -> None:
    """h^2 k/m = 5 is beyond the 4 that such a scheme bears: k 5.8e5 N/m on 2 kg."""
    assert abs(pd(world, 5 * 2.0 / DT**2, 0.0, 0.2)) > 100.0


def test_stable_pd_control_is_a_name_alone(world: World) -> None:
    number = slide(world, 2.0)
    with pytest.raises(pybullet.error, match="Illegal control mode"):
        world.setJointMotorControl2(number, 0, pybullet.STABLE_PD_CONTROL, targetPosition=0, positionGain=1, velocityGain=1)


def test_a_prismatic_constraint_holds_a_body_on_a_line_of_the_world(world: World) -> None:
    """Under 2 N and gravity along x alone: f t (t + h)/(2 m)."""
    world.setGravity(0, 0, -G)
    box = world.createMultiBody(2.0, world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.1, 0.2, 0.3]))
    world.changeDynamics(box, -1, linearDamping=0.0, angularDamping=0.0)
    held = world.createConstraint(box, -1, -1, -1, pybullet.JOINT_PRISMATIC, [1, 0, 0], [0, 0, 0], [0, 0, 0])
    world.changeConstraint(held, maxForce=1e6)
    for _ in range(240):
        world.applyExternalForce(box, -1, [2, 0, 0], world.getBasePositionAndOrientation(box)[0], pybullet.WORLD_FRAME)
        world.stepSimulation()
    place, turn = world.getBasePositionAndOrientation(box)
    assert place == pytest.approx((2.0 / 2 / 2.0 * (1 + DT), 0, 0), abs=1e-9)
    assert turn == pytest.approx((0, 0, 0, 1), abs=1e-9)


def test_between_two_bodies_it_lets_one_turn_against_the_other(world: World) -> None:
    """One turns at 1 rad/s: held to it by a slide the other would turn along."""
    pair = [world.createMultiBody(2.0) for _ in range(2)]
    for body in pair:
        world.changeDynamics(body, -1, linearDamping=0.0, angularDamping=0.0)
    held = world.createConstraint(pair[0], -1, pair[1], -1, pybullet.JOINT_PRISMATIC, [1, 0, 0], [0, 0, 0], [0, 0, 0])
    world.changeConstraint(held, maxForce=1e6)
    world.resetBaseVelocity(pair[0], [1, 1, 0], [0, 0, 1])
    for _ in range(240):
        world.stepSimulation()
    turns = [world.getBaseVelocity(body)[1][2] for body in pair]
    assert turns == pytest.approx([1.0, 0.0], abs=1e-6)


def test_a_prismatic_constraint_of_a_body_in_maximal_coordinates_is_refused(world: World) -> None:
    box = world.createMultiBody(2.0, world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.1] * 3),
                                useMaximalCoordinates=MAXIMAL)  # fmt: skip
    with pytest.raises(pybullet.error):
        world.createConstraint(box, -1, -1, -1, pybullet.JOINT_PRISMATIC, [1, 0, 0], [0, 0, 0], [0, 0, 0])


@pytest.mark.parametrize(("friction", "slope", "holds"), [(8, 7, True), (8, 9, False), (20, 9, True), (20, 11, False)])
def test_friction_of_more_than_10_is_10(world: World, friction: float, slope: float, holds: bool) -> None:
    """A thin plate on a steep slope, by the tangent of its angle; what holds creeps by the first step at most."""
    angle = math.atan(slope)
    world.setGravity(G * math.sin(angle), 0, -G * math.cos(angle))
    ground = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[50, 50, 0.5])
    plate = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.3, 0.3, 0.005])
    world.changeDynamics(world.createMultiBody(0, ground, basePosition=[0, 0, -0.5]), -1, lateralFriction=1)
    mover = world.createMultiBody(1, plate, basePosition=[0, 0, 0.005])
    world.changeDynamics(mover, -1, lateralFriction=friction, linearDamping=0.0, angularDamping=0.0)
    for _ in range(480):
        world.stepSimulation()
    assert (world.getBasePositionAndOrientation(mover)[0][0] < 1e-3) == holds


@pytest.mark.parametrize("margin", [None, 0.0])
def test_a_hull_on_a_link_stands_a_millimetre_high_whatever_margin_it_is_told(world: World, margin: float | None) -> None:
    """A cube of 0.2 m as the hull of its corners, on a vertical slide."""
    world.setGravity(0, 0, -G)
    hull = world.createCollisionShape(pybullet.GEOM_MESH, vertices=CUBE)
    ground = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[5, 5, 0.5])
    world.createMultiBody(0, ground, basePosition=[0, 0, -0.5])
    lift = world.createMultiBody(
        0.0, -1, -1, [0, 0, 0.11], linkMasses=[1], linkCollisionShapeIndices=[hull], linkVisualShapeIndices=[-1],
        linkPositions=[[0, 0, 0]], linkOrientations=[[0, 0, 0, 1]], linkInertialFramePositions=[[0, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]], linkParentIndices=[0], linkJointTypes=[pybullet.JOINT_PRISMATIC],
        linkJointAxis=[[0, 0, 1]],
    )  # fmt: skip
    world.setJointMotorControl2(lift, 0, pybullet.VELOCITY_CONTROL, force=0)
    if margin is not None:
        world.changeDynamics(lift, 0, collisionMargin=margin)
    for _ in range(480):
        world.stepSimulation()
    assert world.getLinkState(lift, 0)[0][2] - 0.1 == pytest.approx(1e-3, abs=5e-5)


BRIDGE = [(-0.3, -0.2), (-0.2, -0.2), (-0.2, 0.1), (0.2, 0.1), (0.2, -0.2), (0.3, -0.2), (0.3, 0.2), (-0.3, 0.2)]
"""The outline (x, z) of a bridge: two legs of 0.3 m below a deck of 0.1 m."""


def bridge(folder: Path) -> str:
    """An OBJ file of a bridge 0.3 m deep, not convex."""
    count = len(BRIDGE)
    corners = [(x, y, z) for y in (-0.15, 0.15) for x, z in BRIDGE]
    face = [(0, 1, 2), (0, 2, 7), (2, 3, 6), (2, 6, 7), (3, 4, 5), (3, 5, 6)]
    faces = face + [(a + count, c + count, b + count) for a, b, c in face]
    for i in range(count):
        j = (i + 1) % count
        faces += [(i, i + count, j + count), (i, j + count, j)]
    path = folder / "bridge.obj"
    path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners)
                    + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces))  # fmt: skip
    return str(path)


def heavy(world: World, shape: int, place: tuple[float, float, float], coordinates: int) -> int:
    """A free body of 1 kg."""
    body: int = world.createMultiBody(1.0, shape, basePosition=place, useMaximalCoordinates=coordinates)
    world.changeDynamics(body, -1, mass=1.0, localInertiaDiagonal=[0.02, 0.03, 0.03])
    return body


@pytest.mark.parametrize("coordinates", [MULTIBODY, MAXIMAL])
@pytest.mark.parametrize(("flag", "height"), [("GEOM_FORCE_CONCAVE_TRIMESH", 0.5), (None, 0.801)])
def test_a_moving_mesh_that_is_not_convex_stands_on_a_box_between_its_legs(
    world: World, coordinates: int, flag: str | None, height: float, tmp_path: Path
) -> None:
    """A box of 0.6 m in the gap bears the deck, at 0.5 m; the hull of the mesh stands on it at 0.8, and a margin of 1 mm."""
    world.setGravity(0, 0, -G)
    for half, z in (((5, 5, 0.5), -0.5), ((0.05, 0.4, 0.3), 0.3)):
        world.createMultiBody(0, world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half), basePosition=[0, 0, z])
    flags = getattr(pybullet, flag) if flag else 0
    mover = heavy(world, world.createCollisionShape(pybullet.GEOM_MESH, fileName=bridge(tmp_path), flags=flags),
                  (0, 0, 0.62), coordinates)  # fmt: skip
    for _ in range(480):
        world.stepSimulation()
    assert world.getBasePositionAndOrientation(mover)[0][2] == pytest.approx(height, abs=2e-4)


def test_two_such_meshes_pass_through_each_other(world: World, tmp_path: Path) -> None:
    world.setGravity(0, 0, -G)
    path, flag = bridge(tmp_path), pybullet.GEOM_FORCE_CONCAVE_TRIMESH
    shapes = [world.createCollisionShape(pybullet.GEOM_MESH, fileName=path, flags=flag) for _ in range(2)]
    world.createMultiBody(0, shapes[0], basePosition=[0, 0, 0.2])
    mover = heavy(world, shapes[1], (0, 0, 0.7), MULTIBODY)
    for _ in range(240):
        world.stepSimulation()
    assert world.getBasePositionAndOrientation(mover)[0][2] < -1.0


def grid(count: int) -> tuple[Any, Any]:
    """A level square of 10 m, count x count vertices: (n, 3) [m], and its triangles (m, 3)."""
    line = np.linspace(-5, 5, count)
    x, y = np.meshgrid(line, line, indexing="ij")
    number = np.arange(count * count).reshape(count, count)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), faces


@pytest.mark.slow
def test_a_mesh_of_200_000_vertices_is_refused_from_memory_and_read_whole_from_a_file(world: World, tmp_path: Path) -> None:
    vertices, faces = grid(450)
    flag = pybullet.GEOM_FORCE_CONCAVE_TRIMESH
    with pytest.raises(pybullet.error):
        world.createCollisionShape(pybullet.GEOM_MESH, vertices=vertices.tolist(), indices=faces.ravel().tolist(), flags=flag)
    path = tmp_path / "grid.obj"
    path.write_text("".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in vertices)
                    + "".join(f"f {a} {b} {c}\n" for a, b, c in faces + 1))  # fmt: skip
    world.createMultiBody(0, world.createCollisionShape(pybullet.GEOM_MESH, fileName=str(path), flags=flag))
    ends = [(x, y) for x in (-4.9, 0.01, 4.9) for y in (-4.9, 0.02, 4.9)]
    hits = world.rayTestBatch([[x, y, 1] for x, y in ends], [[x, y, -1] for x, y in ends])
    assert [hit[2] for hit in hits] == pytest.approx([0.5] * len(ends), abs=1e-6)


def pile(world: World, coordinates: int) -> list[int]:
    """Four cubes above each other, askew."""
    world.setGravity(0, 0, -G)
    ground = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[5, 5, 0.5])
    cube = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.1] * 3)
    world.createMultiBody(0, ground, basePosition=[0, 0, -0.5], useMaximalCoordinates=coordinates)
    turns = [pybullet.getQuaternionFromEuler([0.1 * k, 0.2, 0.05]) for k in range(4)]
    return [world.createMultiBody(1, cube, basePosition=[0.02 * k, 0, 0.15 + 0.25 * k], baseOrientation=turns[k],
                                  useMaximalCoordinates=coordinates) for k in range(4)]  # fmt: skip


def seen(world: World, bodies: list[int]) -> Any:
    """Poses and velocities, a row a body."""
    return np.array([sum(world.getBasePositionAndOrientation(b), ()) + sum(world.getBaseVelocity(b), ()) for b in bodies])


@pytest.mark.parametrize(("coordinates", "same"), [(MULTIBODY, True), (MAXIMAL, False)])
@pytest.mark.parametrize("warm", [None, 0.0])
def test_a_restored_state_goes_on_bit_for_bit_in_multibody_coordinates_alone(
    world: World, coordinates: int, same: bool, warm: float | None
) -> None:
    """Saved in the fall of a pile, and restored in the same world; without warm starting maximal coordinates part as well."""
    bodies = pile(world, coordinates)
    if warm is not None:
        world.setPhysicsEngineParameter(warmStartingFactor=warm)
    world.setPhysicsEngineParameter(deterministicOverlappingPairs=1)
    for _ in range(50):
        world.stepSimulation()
    saved, after = world.saveState(), []
    for attempt in range(2):
        if attempt:
            world.restoreState(saved)
        for _ in range(100):
            world.stepSimulation()
        after.append(seen(world, bodies))
    assert np.array_equal(*after) == same


@pytest.mark.parametrize("coordinates", [MULTIBODY, MAXIMAL])
@pytest.mark.parametrize("count", [3, 7, 16, 100])
@pytest.mark.parametrize("dt", [1 / 60, 1 / 240, 1e-3, 0.0031])
def test_many_steps_in_one_call_are_those_of_as_many_calls_bit_for_bit(coordinates: int, count: int, dt: float) -> None:
    """By sub-steps of a step that is as many times as long."""
    states = []
    for calls, parts in ((count * (200 // count), 1), (200 // count, count)):
        with World() as world:
            bodies = pile(world, coordinates)
            world.setPhysicsEngineParameter(fixedTimeStep=parts * dt, numSubSteps=parts if parts > 1 else 0)
            for _ in range(calls):
                world.stepSimulation()
            states.append(seen(world, bodies))
    assert np.array_equal(*states)


@pytest.mark.parametrize(("light", "darkened"), [([0, 1, 3], 0.94), ([0, 0, 1], 0.0)])
def test_the_shadow_that_tiny_renderer_offers_falls_on_nearly_all_of_a_floor_or_on_nothing(
    world: World, light: list[float], darkened: float
) -> None:
    """A cube of 0.8 m floats over a floor of 4 m: a sixteenth of what the light sees lies in its shadow, a third seen askew."""
    for half, z in (([2, 2, 0.05], 0.0), ([0.4] * 3, 1.0)):
        look = world.createVisualShape(pybullet.GEOM_BOX, halfExtents=half, rgbaColor=[0.5, 0.5, 0.5, 1])
        world.createMultiBody(0, -1, look, basePosition=[0, 0, z])
    view = pybullet.computeViewMatrix([4, 0, 3], [0, 0, 0], [0, 0, 1])
    through = pybullet.computeProjectionMatrixFOV(60, 1, 0.1, 20)
    seen_of_floor = []
    for shadow in (0, 1):
        image = world.getCameraImage(
            128, 128, view, through, lightDirection=light, lightDistance=10, lightAmbientCoeff=0.2, lightDiffuseCoeff=0.8,
            lightSpecularCoeff=0, shadow=shadow, renderer=pybullet.ER_TINY_RENDERER,
        )  # fmt: skip
        floor = np.reshape(image[4], (128, 128)) == 0
        seen_of_floor.append(np.reshape(image[2], (128, 128, 4))[floor][:, 0].astype(int))
    top = seen_of_floor[0] > 50
    assert np.mean((seen_of_floor[1] < seen_of_floor[0])[top]) == pytest.approx(darkened, abs=0.02)


@pytest.mark.parametrize("more", [{}, {"reportHitNumber": 0}, {"fractionEpsilon": 0.0}, {"parentObjectUniqueId": -1}])
@pytest.mark.parametrize("shape", [{"shapeType": 3, "halfExtents": [1, 1, 1]}, {"shapeType": 2, "radius": 1.0}])
def test_a_ray_from_within_a_solid_meets_nothing_of_it(world: World, shape: dict[str, Any], more: dict[str, Any]) -> None:
    world.createMultiBody(0, world.createCollisionShape(**shape))
    assert world.rayTestBatch([[0, 0, 0]], [[5, 0, 0]], **more)[0][0] == -1
    assert world.rayTestBatch([[5, 0, 0]], [[0, 0, 0]], **more)[0][0] == 0


@pytest.mark.parametrize("coordinates", [MULTIBODY, MAXIMAL])
@pytest.mark.parametrize("turn", [0.5, 0.78, 1.0, math.pi / 2, math.pi])
def test_a_turn_of_more_than_45_degrees_a_step_is_shortened_and_the_rate_is_not(
    world: World, coordinates: int, turn: float
) -> None:
    """btTransformUtil::integrateTransform takes the sine and cosine of an eighth of a half turn, and the axis at its length."""
    ball = world.body(world.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1), 1.0, (0, 0, 0), coordinates)
    world.resetBaseVelocity(ball, [0, 0, 0], [0, 0, turn * 240])
    world.stepSimulation()
    (_, _, z, w), spin = world.getBasePositionAndOrientation(ball)[1], world.getBaseVelocity(ball)[1][2]
    told = turn if turn <= math.pi / 4 else 2 * math.atan(turn / (math.pi / 4) * math.tan(math.pi / 8))
    assert 2 * math.atan2(z, w) == pytest.approx(told, rel=1e-6)
    assert spin == pytest.approx(turn * 240, rel=1e-6)


@pytest.mark.parametrize(
    "word", ["static", "kinetic", "armature", "rotor", "spring", "ellipsoid", "distance", "kinematic", "tendon"]
)
def test_no_parameter_of_a_body_a_joint_or_a_constraint_has_such_a_name(word: str) -> None:
    """pybullet takes keywords alone that it knows, and says which it does not."""
    for call in (pybullet.changeDynamics, pybullet.createConstraint, pybullet.changeConstraint, pybullet.createMultiBody):
        with pytest.raises(TypeError):
            call(**{word: 1.0})
    assert not [name for name in dir(pybullet) if name.startswith(("GEOM_", "JOINT_")) and word in name.lower()]


@pytest.mark.parametrize(("rate", "holds"), [(240, False), (480, False), (1000, True)])
def test_a_grippers_tendon_by_torques_of_the_start_of_a_step_diverges_where_steps_are_long(
    world: World, rate: int, holds: bool
) -> None:
    """Two fingers of 0.005 kg m2 and the mean of their angles, driven to 0.4 rad by 100 N m/rad and 10 N m s/rad.

    The mean gives way by s = 2 0.5^2/0.005 = 100 a unit of torque: a damper of the start multiplies its rate by 1 - 10 s h in
    each step, which grows beyond h = 1/500 s.
    """
    world.setPhysicsEngineParameter(fixedTimeStep=1 / rate)
    fingers = []
    for x in (0.0, 1.0):
        finger = world.createMultiBody(
            basePosition=(x, 0, 0),
            linkMasses=[0.1],
            linkCollisionShapeIndices=[-1],
            linkVisualShapeIndices=[-1],
            linkPositions=[(0, 0, 0)],
            linkOrientations=[(0, 0, 0, 1)],
            linkInertialFramePositions=[(0, 0, 0)],
            linkInertialFrameOrientations=[(0, 0, 0, 1)],
            linkParentIndices=[0],
            linkJointTypes=[pybullet.JOINT_REVOLUTE],
            linkJointAxis=[(0, 1, 0)],
        )
        world.release(finger, MULTIBODY)
        world.changeDynamics(finger, 0, mass=0.1, localInertiaDiagonal=[0.005] * 3)
        world.setJointMotorControl2(finger, 0, pybullet.VELOCITY_CONTROL, force=0)
        fingers.append(finger)
    for _ in range(rate):
        states = [world.getJointState(finger, 0) for finger in fingers]
        mean, change = (sum(state[k] for state in states) / 2 for k in range(2))
        for finger in fingers:
            torque = 0.5 * (100.0 * (0.4 - mean) - 10.0 * change)
            world.setJointMotorControl2(finger, 0, pybullet.TORQUE_CONTROL, force=torque)
        world.stepSimulation()
    end = world.getJointState(fingers[0], 0)[0]
    assert (end == pytest.approx(0.4, abs=1e-3)) if holds else not abs(end) < 1e3
