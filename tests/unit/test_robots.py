"""The robots: masses, symmetry, support, hinges, and that the targets of their drives make an equilibrium."""

from itertools import pairwise

import numpy as np
import pytest

from plumbline.cases import stand_humanoid, stand_quadruped
from plumbline.harness.case import Case
from plumbline.harness.props.robots.humanoid import FOOT, MASS, STATURE, humanoid
from plumbline.harness.props.robots.quadruped import LEG, quadruped
from plumbline.harness.props.robots.robot import RobotOnFeet, bearing, copy_of, loads
from plumbline.harness.scene import EARTH_GRAVITY, Body, Box, Revolute, Scene, Sphere, Vector3, rotate
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import joint_coordinate, joint_rate

MACHINES = [quadruped(), humanoid()]
BOTH = pytest.mark.parametrize("machine", MACHINES, ids=["quadruped", "humanoid"])


def mirrored(name: str) -> str:
    """The name of a part on the other side."""
    return name.replace("left", "*").replace("right", "left").replace("*", "right")


def test_masses_and_numbers_of_hinges_are_those_described() -> None:
    assert [machine.mass for machine in MACHINES] == pytest.approx([15.0, MASS], rel=1e-12)
    assert [len(machine.hinges) for machine in MACHINES] == [12, 30]
    # A tree: each hinge adds one body, and one body is the root.
    assert all(len(machine.bodies) == len(machine.hinges) + 1 for machine in MACHINES)


@BOTH
def test_left_is_the_mirror_image_of_right(machine: RobotOnFeet) -> None:
    bodies = {body.name: body for body in machine.bodies}
    for body in machine.bodies:
        other = bodies[mirrored(body.name)]
        assert other.mass == body.mass
        assert other.inertia == body.inertia
        assert np.array(other.p_WB) == pytest.approx(np.array(body.p_WB) * [1, -1, 1], abs=1e-15)
    hinges = {hinge.name: hinge for hinge in machine.hinges}
    for hinge in machine.hinges:
        pair = hinges[mirrored(hinge.name)]
        assert (pair.axis_W, pair.drive) == (hinge.axis_W, hinge.drive)
        assert np.array(pair.anchor_W) == pytest.approx(np.array(hinge.anchor_W) * [1, -1, 1], abs=1e-15)


def test_the_humanoid_has_the_heights_and_the_shares_of_a_person() -> None:
    """The stature to a twentieth (it crouches a little); trunk and legs have their share of the mass."""
    machine = humanoid()
    top = max(body.p_WB[2] for body in machine.bodies) + 0.5 * 0.2429 * STATURE / 1.741
    assert 0.95 * STATURE < top < 1.05 * STATURE
    assert 0.54 * STATURE < machine.centre[2] < 0.60 * STATURE  # Winter, section 4.1: about 0.57 standing
    masses = {body.name: body.mass for body in machine.bodies}
    trunk = sum(masses[name] for name in ("pelvis", "waist roll", "waist", "chest"))
    assert trunk / MASS == pytest.approx(0.4346, abs=1e-3)
    leg = sum(mass for name, mass in masses.items() if name.split()[0] == "left" and name.split()[1] in LEG_PARTS)
    assert leg / MASS == pytest.approx(0.1416 + 0.0433 + 0.0137, abs=1e-3)


LEG_PARTS = ("hip", "thigh", "shank", "ankle", "foot")


@BOTH
def test_the_centre_of_mass_lies_over_the_soles_with_room(machine: RobotOnFeet) -> None:
    points = np.array(list(machine.soles.values()))
    if len(points) == 2:
        # Two feet: each is a box of FOOT.long, whose edges are no nearer than a quarter of it.
        feet = [body for body in machine.bodies if body.name in machine.soles]
        for foot in feet:
            heel = foot.p_WB[0] - FOOT.centre * FOOT.long
            assert 0.25 < (machine.centre[0] - heel) / FOOT.long < 0.75
        assert points[0, 1] > machine.centre[1] > points[1, 1]
    else:
        assert (points.min(axis=0)[:2] < machine.centre[:2]).all()
        assert (machine.centre[:2] < points.max(axis=0)[:2]).all()


@BOTH
def test_ground_forces_carry_the_weight_without_a_moment(machine: RobotOnFeet) -> None:
    forces = loads(machine, EARTH_GRAVITY)
    total = np.sum(list(forces.values()), axis=0)
    moment = sum(np.cross(np.subtract(machine.soles[foot], machine.centre), force) for foot, force in forces.items())
    assert total == pytest.approx([0, 0, machine.mass * 9.81], rel=1e-12, abs=1e-9)
    assert moment == pytest.approx(np.zeros(3), abs=1e-9)
    assert all(force[2] > 0 for force in forces.values())


def test_a_machine_that_leans_over_its_soles_is_refused() -> None:
    machine = quadruped()
    shifted = RobotOnFeet(
        bodies=machine.bodies, hinges=machine.hinges, soles={foot: (x + 0.5, y, z) for foot, (x, y, z) in machine.soles.items()}
    )
    with pytest.raises(ValueError, match="does not lie over its soles"):
        bearing(shifted, EARTH_GRAVITY)


def potential(scene: Scene, machine: RobotOnFeet, hinge: int, turn: float) -> float:
    """Energy [J] of weights and ground forces beyond a hinge that is turned by `turn` [rad], all else at rest."""
    joint = machine.hinges[hinge]
    axis, anchor = np.array(joint.axis_W), np.array(joint.anchor_W)
    ground = loads(machine, EARTH_GRAVITY)

    def turned(point: Vector3) -> Floats:
        arm = np.array(point) - anchor
        along = axis * (axis @ arm)
        found: Floats = anchor + along + np.cos(turn) * (arm - along) + np.sin(turn) * np.cross(axis, arm)
        return found

    energy = 0.0
    for body in machine.beyond(joint):
        energy -= float(body.mass * np.array(EARTH_GRAVITY) @ turned(body.p_WB))
        if body.name in ground:
            energy -= float(np.array(ground[body.name]) @ turned(machine.soles[body.name]))
    return energy


@BOTH
def test_drives_balance_weights_and_ground_forces(machine: RobotOnFeet) -> None:
    """By another route than moments: the torque of each drive is the slope of the energy of what it carries."""
    held = bearing(machine, EARTH_GRAVITY)
    scene = Scene(bodies=machine.bodies, apart=(("machine", "machine"),))
    loaded = 0
    for place, joint in enumerate(held.hinges):
        assert joint.drive is not None
        torque = joint.drive.stiffness * (joint.drive.target - joint.position)
        step = 1e-4
        slope = (potential(scene, machine, place, step) - potential(scene, machine, place, -step)) / (2 * step)
        # The central difference of a sine errs by step^2/6 of it, and rounding of 1e3 J by 1e-13/step.
        assert torque == pytest.approx(slope, rel=1e-7, abs=1e-7)
        loaded += abs(torque) > 0.5
    assert loaded >= 4


def test_a_stiffer_machine_has_the_same_torques_and_damping_ratios() -> None:
    soft, stiff = bearing(humanoid(1.0), EARTH_GRAVITY), bearing(humanoid(16.0), EARTH_GRAVITY)
    for a, b in zip(soft.hinges, stiff.hinges, strict=True):
        assert a.drive is not None
        assert b.drive is not None
        assert b.drive.stiffness == pytest.approx(16 * a.drive.stiffness)
        assert b.drive.damping == pytest.approx(4 * a.drive.damping)
        torques = [one.drive.stiffness * (one.drive.target - one.position) for one in (a, b) if one.drive is not None]
        assert torques[1] == pytest.approx(torques[0], abs=1e-9)


def lowest(body: Body) -> float:
    """The height [m] of the lowest point of a ball, or of boxes and balls that stand upright."""
    heights = []
    for placed in body.collision:
        middle = body.p_WB[2] + rotate(body.q_WB, placed.p_BS)[2]
        match placed.shape:
            case Sphere(radius=radius):
                heights.append(middle - radius)
            case Box(half_extents=half):
                assert body.q_WB[0] == 1
                heights.append(middle - half[2])
            case _:
                heights.append(middle - 0.2)
    return min(heights)


@BOTH
def test_feet_touch_the_ground_and_nothing_else_does(machine: RobotOnFeet) -> None:
    for body in machine.bodies:
        if body.name in machine.soles:
            assert lowest(body) == pytest.approx(0.0, abs=1e-12)
        elif body.collision:
            assert lowest(body) > 0.1


@BOTH
def test_hinges_connect_what_hangs_together(machine: RobotOnFeet) -> None:
    """Parents come before children, and each anchor lies within a part's reach of both bodies."""
    seen = {machine.bodies[0].name}
    place = {body.name: np.array(body.p_WB) for body in machine.bodies}
    for joint in machine.hinges:
        assert joint.parent in seen
        seen.add(joint.child)
        for end in (joint.parent, joint.child):
            assert np.linalg.norm(place[end] - np.array(joint.anchor_W)) < 0.35
    assert seen == set(place)


def test_a_copy_stands_elsewhere_and_is_called_by_its_name() -> None:
    scene = stand_quadruped.scene(stand_quadruped.P(n=5))
    trunks = [np.array(body.p_WB) for body in scene.bodies if body.name.endswith("trunk")]
    assert len(trunks) == 5
    assert all(np.linalg.norm(a - b) >= 1.0 for a, b in pairwise(trunks))
    assert copy_of(quadruped(), "a", (0.0, 0.0, 0.0)).hinges[0].parent == "a trunk"


def test_a_hinge_turned_by_hand_has_that_angle_and_rate() -> None:
    """The lower part of a leg swings about its knee: the joint's coordinate grows by the angle, its rate is the spin."""
    scene = stand_quadruped.scene(stand_quadruped.P())
    joint = next(one for one in scene.joints if one.name == "0 front left shank")
    assert isinstance(joint, Revolute)
    time = np.linspace(0.0, 1.0, 11)
    run = Trajectory.of(time, len(scene.bodies))
    run.p_WB[:] = [body.p_WB for body in scene.bodies]
    run.q_WB[:] = [body.q_WB for body in scene.bodies]
    k = scene.index(joint.child)
    knee, spin = np.array(joint.anchor_W), 0.3
    for i, t in enumerate(time):
        angle = -0.6 + spin * t
        run.q_WB[i, k] = [np.cos(angle / 2), 0.0, np.sin(angle / 2), 0.0]
        run.p_WB[i, k] = knee - LEG / 2 * np.array([np.sin(angle), 0.0, np.cos(angle)])
        run.w_WB[i, k] = [0.0, spin, 0.0]
    assert joint_coordinate(scene, joint, run) == pytest.approx(-1.2 + spin * time, abs=1e-12)
    assert joint_rate(scene, joint, run) == pytest.approx(np.full(11, spin), abs=1e-12)


@pytest.mark.parametrize("case", [stand_quadruped.CASE, stand_humanoid.CASE])
def test_other_parameters_make_scenes_too(case: Case) -> None:
    for stiffness in (0.5, 7.0):
        scene = case.scene(case.at(stiffness=stiffness, friction=0.4))
        assert scene.surfaces[0].static_friction == 0.4
