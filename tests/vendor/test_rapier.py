"""What Rapier's adapter says of the engine, in rapier3d's own words."""

import math

import numpy as np
import pytest

from tests.vendor.rapier_world import G, rapier, solid, world

pytestmark = pytest.mark.rapier


def stack(boxes: int, stiff: bool, substeps: int) -> float:
    """Height [m] that a stack of boxes of 0.2 m and 1 kg loses in 4 s."""
    here = world(substeps=substeps)
    if stiff:
        spring = rapier.SpringCoefficients(substeps / 4 * 240, 10.0)
        here.integration_parameters.contact_softness = here.integration_parameters.static_contact_softness = spring
    here.add_body(rapier.RigidBody.fixed(), [rapier.Collider.halfspace((0.0, 0.0, 1.0))])
    for k in range(boxes):
        box = solid(1.0, (1 / 150,) * 3, (0.0, 0.0, 0.1 + 0.2 * k))
        top = here.add_body(box, [rapier.Collider.cuboid(0.1, 0.1, 0.1).density(0.0)])
    for _ in range(960):
        here.step()
    return 0.2 * boxes - 0.1 - here.rigid_bodies[top].translation.z


def test_ten_boxes_sag_by_2_cm_on_springs_that_no_step_stiffens_and_hardly_where_they_are_told_to() -> None:
    assert 0.020 < stack(10, False, 4) < 0.030
    assert 0.020 < stack(10, False, 16) < 0.030
    assert stack(10, True, 12) < 1e-3


def pendulum(reduced: bool) -> float:
    """What a pendulum of 1 m that is let go at 60 degrees loses of m g l in 10 s, in 4 sub-steps of 1/240 s."""
    here = world()
    start = (math.sin(math.pi / 3), 0.0, -0.5)
    anchor = here.add_body(rapier.RigidBody.fixed(), [])
    bob = here.add_body(solid(1.0, (1e-2,) * 3, start), [])
    turned = rapier.Rotation3(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
    build = rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_REVOLUTE_AXES)
    joint = build.local_frame1(rapier.Isometry3((0.0, 0.0, 0.0), turned))
    joint = joint.local_frame2(rapier.Isometry3(tuple(-x for x in start), turned)).build()
    joints = here.multibody_joints if reduced else here.impulse_joints
    handle = joints.insert(anchor, bob, joint)
    if reduced:
        tree = joints.multibody(handle)
        tree.set_damping([0.0] * tree.ndofs)
    body = here.rigid_bodies[bob]

    def energy() -> float:
        v, w = np.array(body.linvel.to_tuple()), np.array(body.angvel.to_tuple())
        return 0.5 * float(v @ v) + 0.5e-2 * float(w @ w) + G * body.translation.z

    before = energy()
    for _ in range(2400):
        here.step()
    return (before - energy()) / G


def test_a_pendulum_on_an_impulse_joint_loses_energy_where_one_in_coordinates_keeps_it() -> None:
    assert 0.008 < pendulum(False) < 0.03
    assert abs(pendulum(True)) < 0.004


def test_speeds_are_cut_at_400_m_s_and_turns_at_45_degrees_a_step() -> None:
    here = world(0.0)
    fast = here.add_body(solid(1.0, (0.1,) * 3, (0.0, 0.0, 0.0)).linvel((1000.0, 0.0, 0.0)).angvel((0.0, 0.0, 300.0)), [])
    for _ in range(24):
        here.step()
    body = here.rigid_bodies[fast]
    assert body.linvel.x == pytest.approx(400.0)
    assert body.angvel.z == pytest.approx(math.pi / 4 * 240, rel=1e-3)


def passing(recycled: bool) -> float:
    """The speed [m/s] that a ball at rest is given by one that passes at 4 mm and 2 m/s."""
    here = world(0.0)
    here.integration_parameters.contact_recycling = recycled
    rest, moving = (
        here.add_body(solid(1.0, (4e-3,) * 3, p).linvel(v), [rapier.Collider.ball(0.1).density(0.0)])
        for p, v in (((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), ((-0.5, 0.204, 0.0), (2.0, 0.0, 0.0)))
    )
    for _ in range(120):
        here.step()
    assert here.rigid_bodies[moving].translation.x > 0.3
    return float(np.linalg.norm(here.rigid_bodies[rest].linvel.to_tuple()))


def test_recycled_contacts_kick_a_ball_that_is_passed_at_4_mm() -> None:
    assert passing(True) > 0.1
    assert passing(False) < 1e-6


def test_rays_meet_a_cylinder_by_an_iteration_that_stops_short() -> None:
    """Rays from all around 3 m off into a cylinder of 0.4 m by 1.2 m, against its closed form."""
    here = world()
    here.add_body(rapier.RigidBody.fixed(), [rapier.Collider.cylinder(0.6, 0.4)])
    here.update_query_pipeline()
    draw = np.random.default_rng(3)
    starts = draw.normal(size=(400, 3))
    starts *= 3.0 / np.linalg.norm(starts, axis=1)[:, None]
    ways = draw.uniform(-0.3, 0.3, (400, 3)) - starts
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    worst = 0.0
    for start, way in zip(starts, ways, strict=True):
        hit = here.query_pipeline.cast_ray(rapier.Ray(tuple(start), tuple(way)), 9.0, True)
        across, flat = way[[0, 2]], start[[0, 2]]
        a, b, c = across @ across, flat @ across, flat @ flat - 0.16
        mantle = (-b - math.sqrt(b * b - a * c)) / a if b * b > a * c else math.inf
        cap = (math.copysign(0.6, start[1]) - start[1]) / way[1]
        ends = ((mantle, abs(start[1] + mantle * way[1]) <= 0.6), (cap, np.linalg.norm(flat + cap * across) <= 0.4))
        meets = [distance for distance, on in ends if on]
        if meets and hit is not None:
            worst = max(worst, abs(hit[1] - min(meets)))
    assert 1e-5 < worst < 5e-3


ACROSS = rapier.Rotation3(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
BARS = {"left": (0.0, 0.0, 0.5), "top": (0.5, 0.0, 1.0), "right": (1.0, 0.0, 0.5)}


def hinge(pin: tuple[float, float, float], first: str, second: str) -> rapier.GenericJoint:
    """A hinge about y at a pin; '' is the world."""
    frames = [
        rapier.Isometry3(tuple(a - b for a, b in zip(pin, BARS.get(name, (0.0, 0.0, 0.0)), strict=True)), ACROSS)
        for name in (first, second)
    ]
    build = rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_REVOLUTE_AXES)
    return build.local_frame1(frames[0]).local_frame2(frames[1]).build()


def crank_speed(closed: str, steps: int = 10) -> float:
    """The rate [rad/s] of a crank of a parallelogram after so many ms, told 1 rad/s at both cranks. Args: closed: by what."""
    here = world(0.0, dt=1e-3)
    ground = [here.add_body(rapier.RigidBody.fixed(), []) for _ in range(2)]
    bars = {name: here.add_body(solid(1.0, (0.1,) * 3, p), []) for name, p in BARS.items()}
    trees = here.multibody_joints
    trees.insert(ground[0], bars["left"], hinge((0.0, 0.0, 0.0), "", "left"))
    left = trees.insert(bars["left"], bars["top"], hinge((0.0, 0.0, 1.0), "left", "top"))
    right = trees.insert(ground[1], bars["right"], hinge((1.0, 0.0, 0.0), "", "right"))
    if closed == "hinge":
        here.impulse_joints.insert(bars["top"], bars["right"], hinge((1.0, 0.0, 1.0), "top", "right"))
    elif closed:
        mask = rapier.JointAxesMask
        axes = mask.LOCKED_SPHERICAL_AXES if closed == "ball" else mask.LIN_X | mask.LIN_Z
        ends = [tuple(a - b for a, b in zip((1.0, 0.0, 1.0), BARS[name], strict=True)) for name in ("top", "right")]
        still = rapier.Rotation3(1.0, 0.0, 0.0, 0.0)
        first, second = (rapier.Isometry3(end, still) for end in ends)
        joint = rapier.GenericJoint.builder(axes).local_frame1(first).local_frame2(second)
        here.impulse_joints.insert(bars["top"], bars["right"], joint.build())
    here.integration_parameters.dt = 1e-9
    here.step()
    here.integration_parameters.dt = 1e-3
    for handle, rates in ((left, [1.0, -1.0]), (right, [1.0])):
        tree = trees.multibody(handle)
        tree.set_damping([0.0] * tree.ndofs)
        tree.set_generalized_velocity(rates)
    for _ in range(steps):
        here.step()
    return float(here.rigid_bodies[bars["left"]].angvel.y)


def test_a_hinge_that_closes_a_loop_of_hinges_stops_multibodies_dead_and_a_ball_or_a_point_of_the_plane_does_not() -> None:
    """The hinge locks what the others lock already."""
    assert crank_speed("") == pytest.approx(1.0, abs=0.01)
    assert abs(crank_speed("hinge")) < 0.1
    for closed in ("ball", "plane"):
        assert crank_speed(closed) == pytest.approx(1.0, abs=1e-4)


def test_a_ball_that_closes_the_loop_brakes_it_within_a_second_and_a_point_of_the_plane_stops_it_where_it_lies_flat() -> None:
    """Cranks and coupler lie in a line after 1.57 s."""
    assert crank_speed("ball", 1000) == pytest.approx(0.923, abs=0.02)
    assert abs(crank_speed("ball", 1700)) < 0.3
    assert crank_speed("plane", 1400) == pytest.approx(1.0, abs=5e-3)
    assert abs(crank_speed("plane", 1700)) < 0.05


def rolled(dt: float) -> tuple[float, float, float]:
    """Height over the ground [m], and velocity along x and up [m/s], of a ball of .1 m that slid into rolling from 5 m/s."""
    here = world(dt=dt)
    here.add_body(rapier.RigidBody.fixed(), [rapier.Collider.halfspace((0.0, 0.0, 1.0)).friction(0.3)])
    start = solid(1.0, (4e-3,) * 3, (0.0, 0.0, 0.1)).linvel((5.0, 0.0, 0.0)).gyroscopic_forces(False)
    ball = here.add_body(start, [rapier.Collider.ball(0.1).density(0.0).friction(0.3)])
    for _ in range(round(2.0 / dt)):
        here.step()
    body = here.rigid_bodies[ball]
    return body.translation.z - 0.1, body.linvel.x, body.linvel.z


def test_a_ball_that_rolls_level_reports_that_it_sinks_by_an_amount_of_first_order_in_the_step() -> None:
    """Points of a contact are found once a step and turn with the ball: it falls after them, and is put back in the next."""
    (high, along, up), (finer_high, _, finer) = rolled(1 / 240), rolled(1 / 960)
    assert along == pytest.approx(25 / 7, abs=5e-3)
    assert max(abs(high), abs(finer_high)) < 1e-3
    assert -0.05 < up < -0.01
    assert finer / up < 0.5


def swung(armature: float | None) -> float:
    """The rate of fall [m/s] after 0.1 s of a bob of 1 kg, a metre from its hinge. Args: armature: of its rotor [kg m2]."""
    here = world()
    anchor, bob = here.add_body(rapier.RigidBody.fixed(), []), here.add_body(solid(1.0, (1e-2,) * 3, (1.0, 0.0, 0.0)), [])
    turned = rapier.Rotation3(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
    joint = rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_REVOLUTE_AXES)
    joint = joint.local_frame1(rapier.Isometry3((0.0, 0.0, 0.0), turned)).local_frame2(
        rapier.Isometry3((-1.0, 0.0, 0.0), turned)
    )
    tree = here.multibody_joints.multibody(here.multibody_joints.insert(anchor, bob, joint.build()))
    tree.set_damping([0.0] * tree.ndofs)
    if armature is not None:
        tree.set_armature([armature] * tree.ndofs)
    for _ in range(24):
        here.step()
    return -float(here.rigid_bodies[bob].linvel.z)


def test_a_joint_of_a_multibody_has_a_rotor_and_an_impulse_joint_has_none() -> None:
    """m g t/(m l^2 + I + A); the first sub-step of 96 is lost, as a root that stands still is not known as such before."""
    for armature in (None, 1.0, 10.0):
        due = 0.1 * G / (1.01 + (armature or 0.0))
        assert swung(armature) == pytest.approx(due * 95 / 96, rel=4e-3)
    assert not [name for name in dir(rapier.ImpulseJoint) if "armature" in name]


def test_a_rope_has_no_least_length() -> None:
    rope = rapier.RopeJoint.builder(2.0).build()
    assert rope.min_distance == 0.0
    with pytest.raises(AttributeError):
        rope.min_distance = 0.5


@pytest.mark.parametrize(("model", "told"), [("SIMPLIFIED", 0.0), ("COULOMB", 3.0 / 240)])
def test_friction_is_told_by_the_coulomb_model_alone_and_along_directions_that_it_does_not_tell(
    model: str, told: float
) -> None:
    """A box that is pushed by 3 N and held: the sums of both tangent numbers over its points, and no word of a way."""
    here = world()
    here.integration_parameters.friction_model = getattr(rapier.FrictionModel, model)
    here.add_body(rapier.RigidBody.fixed(), [rapier.Collider.halfspace((0.0, 0.0, 1.0)).friction(0.5)])
    shape = rapier.Collider.cuboid(0.1, 0.1, 0.1).density(0.0).friction(0.5)
    box = here.add_body(solid(1.0, (1 / 150,) * 3, (0.0, 0.0, 0.1)), [shape])
    for _ in range(480):
        here.rigid_bodies[box].reset_forces(True)
        here.rigid_bodies[box].add_force((3.0, 0.0, 0.0), True)
        here.step()
    points = [p for pair in here.narrow_phase.contact_pairs() for m in pair.manifolds for p in m.points]
    sums = np.array([p.tangent_impulse for p in points]).sum(axis=0)
    assert float(np.hypot(*sums)) == pytest.approx(told, rel=0.02, abs=1e-9)
    assert not [name for name in dir(rapier.ContactData) if "direction" in name or "basis" in name]
    assert not [name for name in dir(rapier.ContactManifold) if "tangent" in name]


@pytest.mark.parametrize(
    "word", ["rolling", "torsion", "ellipsoid", "static_friction", "gear", "mimic", "max_velocity", "camera"]
)
def test_nothing_in_the_package_has_such_a_name(word: str) -> None:
    kinds = (rapier, rapier.Collider, rapier.ColliderBuilder, rapier.RigidBody, rapier.GenericJoint, rapier.Multibody,
             rapier.IntegrationParameters, rapier.PhysicsWorld)  # fmt: skip
    assert not [name for kind in kinds for name in dir(kind) if word in name.lower()]


def test_a_step_is_four_of_a_quarter_of_its_length_as_it_comes() -> None:
    """So what flies errs a quarter as much as one step of semi-implicit Euler would have it, g dt t / 2."""
    off = {}
    for substeps in (1, 4):
        here = world(substeps=substeps)
        body = here.rigid_bodies[here.add_body(solid(1.0, (1e-2,) * 3, (0.0, 0.0, 0.0)), [])]
        for _ in range(240):
            here.step()
        off[substeps] = abs(body.translation.z + G / 2)
    assert off[1] == pytest.approx(G / 480, rel=1e-3)
    assert off[4] == pytest.approx(G / 480 / 4, rel=1e-2)
    assert rapier.IntegrationParameters().num_solver_iterations == 4
