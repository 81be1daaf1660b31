"""Joint coordinates of the reference engine: against Pinocchio on random trees, against bodies' own coordinates, and laws."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import engine
from engine.articulated import tables as to
from engine.articulated.forest import Forest, NoForest, forest_of

pin: Any = pytest.importorskip("pinocchio", reason="the package pin holds Pinocchio")

KINDS = ("revolute", "prismatic", "ball", "fixed")
LINKS = 12
GRAVITY = (0.0, 0.0, -9.81)


@dataclass
class Tree:
    """A random tree in a random state: as Pinocchio's model, and as bodies and joints of ours."""

    model: Any
    q: np.ndarray
    v: np.ndarray
    bodies: list[engine.Body]
    joints: list[engine.Joint]


def random_tree(seed: int, floating: bool, kinds: tuple[str, ...] = KINDS, backwards: bool = True) -> Tree:
    """Twelve links on joints of these kinds in turn, some told from the outer body on; each turned, moved and moving."""
    rng = np.random.default_rng(seed)
    model, made = pin.Model(), []
    names: list[tuple[int, Any]] = []
    model.gravity.linear = np.array(GRAVITY)
    for k in range(LINKS):
        kind = "free" if floating and k == 0 else kinds[k % len(kinds)]
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        joint = {
            "free": pin.JointModelFreeFlyer,
            "ball": pin.JointModelSpherical,
            "revolute": lambda axis=axis: pin.JointModelRevoluteUnaligned(axis),
            "prismatic": lambda axis=axis: pin.JointModelPrismaticUnaligned(axis),
        }
        parent = int(rng.integers(max(0, k - 3), k)) if k > 0 else -1
        where = pin.SE3(Rotation.random(random_state=rng).as_matrix(), rng.normal(0, 0.3, 3))
        moments = np.diag(rng.uniform(0.02, 0.03, 3))
        turn = Rotation.random(random_state=rng).as_matrix()
        solid = pin.Inertia(rng.uniform(0.2, 3.0), rng.normal(0, 0.1, 3), turn @ moments @ turn.T)
        above, offset = names[parent] if parent >= 0 else (0, pin.SE3.Identity())
        if kind == "fixed":
            names.append((above, offset * where))
            model.appendBodyToJoint(above, solid, offset * where)
        else:
            number = model.addJoint(above, joint[kind](), offset * where, f"joint{k}")
            names.append((number, pin.SE3.Identity()))
            model.appendBodyToJoint(number, solid, pin.SE3.Identity())
        made.append((kind, parent, axis, solid, offset * where, above))
    q, v = pin.randomConfiguration(model, -np.ones(model.nq), np.ones(model.nq)), rng.normal(0, 2, model.nv)
    data = model.createData()
    pin.forwardKinematics(model, data, q, v)
    bodies: list[engine.Body] = []
    joints: list[engine.Joint] = []
    for k, (kind, parent, axis, solid, here, above) in enumerate(made):
        number, offset = names[k]
        pose, moves = data.oMi[number] * offset, pin.getVelocity(model, data, number, pin.LOCAL_WORLD_ALIGNED)
        centre = pose.act(solid.lever)
        bodies.append(
            engine.Body(
                name=f"link{k}", mass=solid.mass, inertia=solid.inertia, p_WB=tuple(centre),
                q_WB=tuple(Rotation.from_matrix(pose.rotation).as_quat(scalar_first=True)),
                v_WB=tuple(moves.linear + np.cross(moves.angular, centre - data.oMi[number].translation)),
                w_WB=tuple(moves.angular),
            )
        )  # fmt: skip
        ends: dict[str, Any] = {
            "name": f"joint{k}", "parent": f"link{parent}" if parent >= 0 else engine.WORLD, "child": f"link{k}"
        }  # fmt: skip
        frame = data.oMi[above] * here
        sign = 1.0
        if backwards and k % 3 == 2:
            # The outer body is the joint's parent: the way of the coordinate turns round.
            ends["parent"], ends["child"], sign = ends["child"], ends["parent"], -1.0
        line: dict[str, Any] = {
            "anchor_W": tuple(pose.translation),
            "axis_W": tuple(sign * (frame.rotation @ axis)),
            "position": 0.7,
        }
        if kind == "revolute":
            joints.append(engine.Revolute(**ends, **line))
        elif kind == "prismatic":
            joints.append(engine.Prismatic(**ends, **line))
        elif kind == "ball":
            joints.append(engine.Ball(**ends, anchor_W=tuple(pose.translation)))
        elif kind == "fixed":
            joints.append(engine.Fixed(**ends))
    return Tree(model, q, v, bodies, joints)


def world_of(tree: Tree, **options: Any) -> engine.World:
    """The tree in joint coordinates; one step of semi-implicit Euler over a second, unless told otherwise."""
    chosen = {"dt": 1.0, "substeps": 1, "coordinates": "joint", **options}
    return engine.World(tree.bodies, tree.joints, gravity=GRAVITY, options=engine.Options(**chosen))


def table(world: engine.World, number: int) -> np.ndarray:
    """A table of the world's trees."""
    return to.float_view(*world.save(), number)


@pytest.mark.parametrize("floating", [False, True], ids=["held", "free"])
def test_random_trees_have_the_accelerations_of_pinocchio(floating: bool) -> None:
    """To 1e-10 of the largest: both err by round-off, 1e-16 times the condition of the mass matrix, below 1e5 here."""
    for seed in range(6):
        # A free tree is told from its root on: the root would be another body otherwise.
        tree = random_tree(seed, floating, backwards=not floating)
        data = tree.model.createData()
        wanted = pin.aba(tree.model, data, tree.q, tree.v, np.zeros(tree.model.nv))
        pin.forwardKinematics(tree.model, data, tree.q, tree.v, wanted)
        # So short a step that the accelerations of its last stage are those of its start.
        world = world_of(tree, dt=1e-16, integrator="rk4")
        kinds = to.int_view(world.save()[1], to.KIND)
        world.step(1)
        column, largest = table(world, to.COLUMN), np.abs(wanted).max()
        names = [body.name for body in tree.bodies]
        compared = 0
        for link in kinds:
            body, first, count = link[to.ROW], link[to.FIRST], link[to.COLUMNS]
            got = column[first : first + count, to.CHANGE]
            if count == 0:
                continue
            number = tree.model.getJointId(f"joint{body}")
            at = tree.model.idx_vs[number]
            if count == 1:
                want = wanted[at : at + 1]
            elif count == 3:
                # Ours turns in the axes of the parent, Pinocchio's in those of the child.
                inner = names[body]
                parent = next(j for j in tree.joints if inner in (j.parent, j.child) and j.name == f"joint{body}")
                other = parent.parent if parent.child == inner else parent.child
                turns = {b.name: Rotation.from_quat(b.q_WB, scalar_first=True).as_matrix() for b in tree.bodies}
                R = turns.get(other, np.eye(3)).T @ turns[inner]
                want = R @ wanted[at : at + 3]
            else:
                spatial = pin.getClassicalAcceleration(tree.model, data, number, pin.LOCAL_WORLD_ALIGNED)
                w = np.array(tree.bodies[body].w_WB)
                arm = np.array(tree.bodies[body].p_WB) - data.oMi[number].translation
                centre = spatial.linear + np.cross(spatial.angular, arm) + np.cross(w, np.cross(w, arm))
                want = np.concatenate((spatial.angular, centre))
            assert got == pytest.approx(want, abs=1e-10 * largest)
            compared += count
        assert compared == tree.model.nv


@pytest.mark.parametrize("floating", [False, True], ids=["held", "free"])
def test_a_world_starts_where_its_bodies_are_and_moves_as_they_do_in_their_own_coordinates(floating: bool) -> None:
    """Poses are those of the scene to round-off; over .04 s of rk4 the two differ by the errors of order four of either, a
    sixteenth of it at half the step."""
    tree = random_tree(11, floating)
    world = world_of(tree, dt=1e-16)
    start = world.state().copy()
    world.step()
    assert world.state() == pytest.approx(start, abs=1e-13)
    apart = []
    for dt in (1e-2, 5e-3):
        options = {"dt": dt, "integrator": "rk4"}
        ends = []
        for coordinates in ("joint", "maximal"):
            world = world_of(tree, coordinates=coordinates, **options)
            world.step(round(4e-2 / dt))
            ends.append(world.state().copy())
        apart.append(np.abs(ends[0] - ends[1]).max())
    assert 0 < apart[1] < apart[0] / 8


def test_reactions_are_those_of_bodies_in_their_own_coordinates() -> None:
    """What joints carry over one short step of rk4: the two ways differ by its fifth power, below 1e-8 of 1e2 N."""
    tree = random_tree(3, floating=False, kinds=("revolute", "prismatic", "ball"))
    told = []
    for coordinates in ("joint", "maximal"):
        world = world_of(tree, coordinates=coordinates, dt=1e-4, integrator="rk4")
        world.step(1)
        told.append(np.array([world.reaction(joint.name) for joint in tree.joints]))
    assert np.abs(told[1]).max() > 1.0
    assert told[0] == pytest.approx(told[1], abs=1e-6 * np.abs(told[1]).max())


@pytest.mark.parametrize("floating", [False, True], ids=["held", "free"])
@pytest.mark.parametrize("gyroscopic", [True, False], ids=["gyroscopic", "plain"])
def test_semi_implicit_euler_is_shake_to_round_off(floating: bool, gyroscopic: bool) -> None:
    """Both solve one equation for the poses at the end of a sub-step, one in coordinates, one by multipliers: after forty
    sub-steps they differ by round-off, 1e-16 times 2e3 of the mass matrix' condition and a tenth of it by growth."""
    tree = random_tree(11, floating)
    tree.bodies = [replace(body, linear_damping=0.3, angular_damping=0.2) for body in tree.bodies]
    ends, carried = [], []
    for coordinates in ("joint", "maximal"):
        world = world_of(tree, coordinates=coordinates, dt=2e-3, substeps=2, gyroscopic=gyroscopic)
        world.step(20)
        ends.append(world.state().copy())
        carried.append(np.array([world.reaction(joint.name) for joint in tree.joints]))
    assert ends[0][:, :7] == pytest.approx(ends[1][:, :7], abs=1e-12)
    assert ends[0][:, 7:] == pytest.approx(ends[1][:, 7:], abs=1e-10)
    assert carried[0] == pytest.approx(carried[1], abs=1e-8 * np.abs(carried[1]).max())


def apart(tree: Tree, truth: np.ndarray, **options: Any) -> float:
    """How far a run of .04 s ends from the truth, in any number of the state."""
    world = world_of(tree, **options)
    world.step(round(4e-2 / options["dt"]))
    return float(np.abs(world.state() - truth).max())


@pytest.mark.parametrize("floating", [False, True], ids=["held", "free"])
def test_implicit_midpoint_and_dormand_prince_come_to_where_runge_kutta_does(floating: bool) -> None:
    """The truth errs by (1e-3)^4, below 1e-8 here. Midpoint errs by dt^2, a quarter of it at half the step to a tenth of that;
    an adaptive step in proportion to its tolerance, whatever dt."""
    tree = random_tree(11, floating)
    truth = world_of(tree, dt=1e-3, integrator="rk4")
    truth.step(40)
    end = truth.state().copy()
    coarse, fine = (apart(tree, end, dt=dt, integrator="implicit_midpoint") for dt in (1e-2, 5e-3))
    assert coarse / fine == pytest.approx(4.0, rel=0.1)
    rough, precise = (
        apart(tree, end, dt=4e-2, integrator="dormand_prince", step_tolerance=tolerance) for tolerance in (1e-6, 1e-12)
    )
    assert precise < 1e-8 < rough < 1e-3


def momenta(tree: Tree, state: np.ndarray) -> np.ndarray:
    """Momentum and angular momentum about the origin (6,) of all bodies."""
    total = np.zeros(6)
    for body, row in zip(tree.bodies, state, strict=True):
        turn = Rotation.from_quat(row[3:7], scalar_first=True).as_matrix()
        momentum = body.mass * row[7:10]
        total[:3] += momentum
        total[3:] += np.cross(row[:3], momentum) + turn @ np.array(body.inertia) @ turn.T @ row[10:]
    return total


@pytest.mark.parametrize("integrator", ["semi_implicit_euler", "implicit_midpoint"])
def test_a_tree_that_nothing_pushes_keeps_momentum_and_angular_momentum(integrator: str) -> None:
    """Both integrators keep them but for round-off, and for what rounds leave, below 1e-12 of a step; in forty steps of 5e-3 s
    the joints move by half a radian, and Runge-Kutta's method loses 5e-7."""
    tree = random_tree(11, floating=True)
    options = engine.Options(dt=5e-3, substeps=1, coordinates="joint", integrator=integrator)
    world = engine.World(tree.bodies, tree.joints, gravity=(0.0, 0.0, 0.0), options=options)
    before = momenta(tree, world.state())
    world.step(40)
    assert momenta(tree, world.state()) == pytest.approx(before, abs=4e-11 * np.abs(before).max())


LAWS: tuple[dict[str, Any], ...] = (
    {"limits": engine.Limits(lower=0.69, upper=0.72), "friction_loss": 3.0},
    {"drive": engine.Drive(stiffness=300.0, damping=5.0, target=0.2, limit=4.0), "armature": 0.3},
    {"spring": engine.Spring(stiffness=500.0, damping=2.0, rest=0.1), "friction_loss": 1.0, "speed_limit": 1.5},
    {"friction_loss": 20.0, "drive": engine.Drive(damping=3.0, target_velocity=2.0, limit=1.0)},
    {"speed_limit": 0.5, "limits": engine.Limits(lower=-1.0, upper=0.71)},
)


def allowed(joint: Any, v: float, h: float) -> tuple[float, float]:
    """The least and the largest force along a joint that its laws allow at the rate v at the end of a step, from x = .7."""
    x, low, high = 0.7, 0.0, 0.0
    if joint.spring is not None:
        low -= joint.spring.stiffness * (x + h * v - joint.spring.rest) + joint.spring.damping * v
    if joint.drive is not None:
        drive = joint.drive
        force = drive.stiffness * (drive.target - x - h * v) + drive.damping * (drive.target_velocity - v)
        low += np.clip(force, -drive.limit, drive.limit)
    high = low
    still = abs(v) < 1e-9
    low -= joint.friction_loss if still or v > 0 else -joint.friction_loss
    high += joint.friction_loss if still or v < 0 else -joint.friction_loss
    bounds = [(-joint.speed_limit, joint.speed_limit)]
    if joint.limits is not None:
        bounds.append(((joint.limits.lower - x) / h, (joint.limits.upper - x) / h))
    for least, most in bounds:
        assert least - 1e-9 <= v <= most + 1e-9
        high = np.inf if abs(v - least) < 1e-9 else high
        low = -np.inf if abs(v - most) < 1e-9 else low
    return low, high


def needed_forces(tree: Tree, before: np.ndarray, after: np.ndarray, h: float) -> np.ndarray:
    """What has to act along each coordinate (n,) for bodies to go from one state (n, 13) to the poses of another in h.

    By d'Alembert's principle along Pinocchio's Jacobians of the start: of what momenta gain, with the velocities from pose to
    pose and inertia as at the start, what gravity does not give.
    """
    data, forces = tree.model.createData(), np.zeros(tree.model.nv)
    pin.computeJointJacobians(tree.model, data, tree.q)
    for k, body in enumerate(tree.bodies):
        number = tree.model.getJointId(f"joint{k}")
        jacobian = pin.getJointJacobian(tree.model, data, number, pin.LOCAL_WORLD_ALIGNED)
        start, end = (Rotation.from_quat(state[k, 3:7], scalar_first=True) for state in (before, after))
        inertia = start.as_matrix() @ np.array(body.inertia) @ start.as_matrix().T
        gain = body.mass * ((after[k, :3] - before[k, :3]) / h - before[k, 7:10] - h * np.array(GRAVITY))
        spin = inertia @ ((end * start.inv()).as_rotvec() / h - before[k, 10:])
        arm = before[k, :3] - data.oMi[number].translation
        forces += (jacobian[:3].T @ gain + jacobian[3:].T @ (spin + np.cross(arm, gain))) / h
    return forces


def test_laws_along_coordinates_hold_at_the_end_of_every_step() -> None:
    """The forces that the step needs by d'Alembert's principle are such as all joints' laws allow at the rates that it took:
    limits, friction, drives at their limit, springs and rotors at once. Forces of 1e3 N; poses' round-off of 1e-15 m over
    the square of 1e-2 s is 1e-10 N a kilogramme, and the rounds leave 1e-12 of forces of 1e3 N/1e-2 s."""
    held, seen = set(), 0
    for seed in range(12):
        tree = random_tree(20 + seed, floating=False, kinds=("revolute", "prismatic"), backwards=False)
        fields = [LAWS[(k + seed) % len(LAWS)] for k in range(LINKS)]
        tree.joints = [
            type(j)(name=j.name, parent=j.parent, child=j.child, anchor_W=j.anchor_W, axis_W=j.axis_W, position=0.7, **field)
            for j, field in zip(tree.joints, fields, strict=True)
            if isinstance(j, engine.Revolute | engine.Prismatic)
        ]
        h = 1e-2
        world = world_of(tree, dt=h)
        start = world.state().copy()
        kinds = to.int_view(world.save()[1], to.KIND)
        world.step(1)
        rates = np.zeros(LINKS)
        for link in kinds:
            at = tree.model.idx_vs[tree.model.getJointId(f"joint{link[to.ROW]}")]
            rates[at] = table(world, to.COLUMN)[link[to.FIRST], to.RATE]
        change = (rates - tree.v) / h
        forces = needed_forces(tree, start, world.state(), h)
        for joint in tree.joints:
            assert isinstance(joint, engine.Revolute | engine.Prismatic)
            at = tree.model.idx_vs[tree.model.getJointId(joint.name)]
            force = forces[at] + joint.armature * change[at]
            low, high = allowed(joint, rates[at], h)
            assert low - 1e-6 <= force <= high + 1e-6
            seen += 1
            held.add((low < high, abs(rates[at]) < 1e-9))
    assert seen == 12 * LINKS
    assert held == {(True, True), (True, False), (False, False)}


TURNED = (0.0, 0.2, 0.0), (0.0, 0.0, 3.0)
"""Velocities that a base is told on the way."""


def carried_rod(coordinates: str, integrator: str, told: bool) -> np.ndarray:
    """Where a hinged rod with damping ends on a base that turns, and a body beside it, after .3 s."""
    rod: dict[str, Any] = {"mass": 2.0, "inertia": 0.2 * np.eye(3), "linear_damping": 0.5, "angular_damping": 0.3}
    bodies = [
        engine.Body(name="base", motion="kinematic", w_WB=(0.0, 0.0, 2.0), v_WB=(0.1, 0.0, 0.0)),
        engine.Body(name="rod", p_WB=(1.0, 0.0, 0.0), v_WB=(0.1, 2.0, 0.0), w_WB=(0.0, 0.0, 2.0), **rod),
        engine.Body(name="flies", p_WB=(5.0, 0.0, 0.0), v_WB=(0.0, 1.0, 0.0), w_WB=(1.0, 2.0, 0.5), **rod),
    ]
    bodies.append(engine.Body(name="slides", p_WB=(0.0, 1.0, 0.0), v_WB=(-1.9, 0.0, 0.0), w_WB=(0.0, 0.0, 2.0), **rod))
    joints: list[engine.Joint] = [
        engine.Revolute(name="pin", parent="base", child="rod", anchor_W=(0.5, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0)),
        engine.Prismatic(name="rail", parent="base", child="slides", anchor_W=(0.0, 1.0, 0.0), axis_W=(0.0, 1.0, 0.0)),
    ]
    options = engine.Options(dt=1e-3, integrator=integrator, coordinates=coordinates, substeps=1)
    world = engine.World(bodies, joints, options=options)
    world.step(150)
    if told:
        world.prescribe(0, *TURNED)
    world.step(150)
    return world.state().copy()


def test_damping_and_free_bodies_beside_trees_are_as_in_their_own_coordinates() -> None:
    """By rk4 the two ways agree to its error, by Euler to round-off, and Dormand-Prince agrees with rk4."""
    truth = carried_rod("maximal", "rk4", told=False)
    for integrator in ("rk4", "dormand_prince"):
        assert carried_rod("joint", integrator, told=False) == pytest.approx(truth, abs=1e-9)
    euler = (carried_rod(coordinates, "semi_implicit_euler", told=False) for coordinates in ("joint", "maximal"))
    assert next(euler) == pytest.approx(next(euler), abs=1e-12)


def test_a_base_that_is_told_another_velocity_is_one_under_every_integrator() -> None:
    """Against rk4: Dormand-Prince to the error of rk4; midpoint to (w dt)^2 / 12 of a radian a radian, and the damping of a
    free body, 1e-6 in all; Euler to 2 w dt of a radian, .012."""
    truth = carried_rod("joint", "rk4", told=True)
    assert np.abs(truth - carried_rod("joint", "rk4", told=False)).max() > 0.1
    for integrator, error in (("dormand_prince", 1e-9), ("implicit_midpoint", 5e-6), ("semi_implicit_euler", 1.2e-2)):
        assert carried_rod("joint", integrator, told=True) == pytest.approx(truth, abs=error)


def test_many_steps_in_one_call_are_the_same_bits_as_one_by_one_and_a_saved_state_goes_on() -> None:
    tree = random_tree(2, floating=True)
    for integrator in ("semi_implicit_euler", "rk4", "implicit_midpoint", "dormand_prince"):
        options = {"dt": 1e-3, "integrator": integrator, "substeps": 2}
        at_once, singly = world_of(tree, **options), world_of(tree, **options)
        at_once.step(7)
        for _ in range(3):
            singly.step()
        saved = singly.save()
        singly.step(40)
        singly.restore(saved)
        singly.step(4)
        assert np.array_equal(at_once.state(), singly.state())
        batch = engine.Batch.replicate(world_of(tree, **options), 3)
        batch.step(7)
        assert np.array_equal(batch.state()[2], at_once.state())


def test_coordinates_count_turns_and_what_has_none_tells_none() -> None:
    """A wheel that turns by 9 rad/s for a second; a ball has not one coordinate, nor has a joint of bodies with their own."""
    wheel = engine.Body(name="wheel", w_WB=(0.0, 0.0, 9.0))
    axle = engine.Revolute(
        name="axle", parent="wheel", child=engine.WORLD, anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 0.0, -1.0), position=0.5
    )
    hung = engine.Body(name="hung", p_WB=(9.0, 0.0, 0.0))
    ball = engine.Ball(name="ball", parent=engine.WORLD, child="hung", anchor_W=(9.0, 0.0, 0.0))
    world = engine.World([wheel, hung], [axle, ball], options=engine.Options(dt=0.01, coordinates="joint"))
    world.step(100)
    assert world.joint_motion("axle") == pytest.approx((9.5, 9.0), rel=1e-12)
    assert np.isnan(world.joint_motion("ball")).all()
    own = engine.World([wheel], [axle], options=engine.Options(coordinates="maximal"))
    assert np.isnan(own.joint_motion("axle")).all()


def test_loops_are_taken_where_they_are_asked_for_and_what_is_no_tree_is_refused_with_the_reason() -> None:
    bodies = [engine.Body(name=name, p_WB=(k, 0.0, 0.0)) for k, name in enumerate("abc")]
    ring = [engine.Ball(name=f"{one}{two}", parent=one, child=two, anchor_W=(0.0, 0.0, 1.0)) for one, two in ("ab", "bc", "ca")]
    answer = forest_of(bodies, ring)
    assert isinstance(answer, Forest)
    assert len(answer.links) == 3
    assert len(answer.closing) == 1
    assert engine.World(bodies, ring, options=engine.Options(coordinates="joint")).in_joint_coordinates
    rope = engine.Distance(name="rope", parent="a", child="b", anchor_W=(0, 0, 0), child_anchor_W=(1, 0, 0))
    assert forest_of(bodies, [*ring[:2], rope]).closing == (2,)  # type: ignore[union-attr]
    assert isinstance(forest_of(bodies, [rope]), NoForest)
    with pytest.raises(engine.NotSupported, match="the distance of two anchors is no coordinate"):
        engine.World(bodies, [rope], options=engine.Options(coordinates="joint"))
    assert not engine.World(bodies, ring, options=engine.Options(coordinates="automatic")).in_joint_coordinates
    assert engine.World(bodies, ring[:2], options=engine.Options(coordinates="automatic")).in_joint_coordinates
    assert not engine.World(bodies, ring[:2], options=engine.Options(coordinates="maximal")).in_joint_coordinates
    assert engine.World(bodies, ring[:2]).in_joint_coordinates
    assert not engine.World(bodies, ring[:2], options=engine.Options(integrator="rk4")).in_joint_coordinates
    with pytest.raises(ValueError, match="in the same coordinates"):
        engine.World(bodies, ring[:2], options=engine.Options(coordinates="joint")).restore(
            engine.World(bodies, ring[:2], options=engine.Options(coordinates="maximal")).save()
        )
    with pytest.raises(ValueError, match="coordinates 'reduced'"):
        engine.Options(coordinates="reduced")
