"""Joint coordinates of the reference engine: against Pinocchio on random trees, and against bodies' own coordinates."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numba import njit
from scipy.spatial.transform import Rotation

from plumbline import engine
from plumbline.engine.articulated import tables as to
from plumbline.engine.articulated.forest import Forest, NoForest, forest_of
from plumbline.engine.articulated.mixing import DEPTH, mix
from tests.random_trees import Tree, pin, random_tree, table, world_of


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
        along, largest = table(world, to.ALONG), np.abs(wanted).max()
        names = [body.name for body in tree.bodies]
        compared = 0
        for link in kinds:
            body, first, count = link[to.ROW], link[to.FIRST], link[to.COLUMNS]
            got = along[first : first + count, to.CHANGE]
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
    point = engine.Body(name="bob", inertia=1e-20 * np.eye(3), p_WB=(0.0, 0.0, -1.0))
    hook = engine.Ball(name="hook", parent=engine.WORLD, child="bob", anchor_W=(0.0, 0.0, 0.0))
    assert not engine.World([point], [hook]).in_joint_coordinates
    with pytest.raises(engine.NotSupported, match=r"'bob'.*1e-20 kg m2, and what ball joint 'hook' leaves of it .* 1e-12"):
        engine.World([point], [hook], options=engine.Options(coordinates="joint"))
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


@pytest.mark.parametrize(("spin", "rate"), [(500.0, 960), (5000.0, 960), (5000.0, 240)])
def test_implicit_midpoint_follows_a_top_that_turns_far_in_a_step(spin: float, rate: int) -> None:
    """By half a radian to 21 rad a step it precesses steadily, which it starts to do, and keeps its tilt and angular momentum.

    A disc on a ball joint, I1 cos(tilt) W^2 - I3 spin W + m g l = 0 (Goldstein, Classical Mechanics, section 5.7). Gravity's
    torque of a step that comes half a step early or late nutates with m g l sin(tilt) h / (I3 spin), both ways.
    """
    tilt, along, across, pull = np.radians(30.0), 5e-3, 1.25e-2, 0.981
    b = along * spin
    precession = 2 * pull / (b + np.sqrt(b * b - 4 * across * np.cos(tilt) * pull))
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    w = (spin - precession * np.cos(tilt)) * axis + (0.0, 0.0, precession)
    disc = engine.Body(
        name="disc", inertia=np.diag([across - 0.01, across - 0.01, along]), p_WB=tuple(0.1 * axis),
        q_WB=(np.cos(tilt / 2), 0.0, np.sin(tilt / 2), 0.0), v_WB=tuple(np.cross(w, 0.1 * axis)), w_WB=tuple(w),
    )  # fmt: skip
    tip = engine.Ball(name="tip", parent="world", child="disc", anchor_W=(0.0, 0.0, 0.0))
    options = engine.Options(dt=1 / rate, substeps=1, integrator="implicit_midpoint")
    world = engine.World([disc], [tip], gravity=(0.0, 0.0, -9.81), options=options)

    def about_the_vertical() -> float:
        """Angular momentum about the tip along gravity [kg m2/s], which nothing changes."""
        state = world.state()[0]
        turn = Rotation.from_quat(state[3:7], scalar_first=True).as_matrix()
        spinning = turn @ np.asarray(disc.inertia) @ turn.T @ state[10:13]
        return float((spinning + np.cross(state[:3], state[7:10]))[2])

    before = about_the_vertical()
    world.step(2 * rate)
    x, y, z = world.state()[0, :3] / 0.1
    nutation = pull * np.sin(tilt) / rate / (along * spin)
    assert np.arccos(z) == pytest.approx(tilt, abs=nutation)
    assert np.arctan2(y, x) == pytest.approx(2 * precession, abs=nutation / np.sin(tilt))
    assert about_the_vertical() == pytest.approx(before, rel=1e-9)


@pytest.mark.parametrize("slope", [0.9, 3.0, 50.0])
def test_mixed_rounds_end_after_as_many_as_there_are_unknowns(slope: float) -> None:
    """One more: x <- A x + b in four unknowns, of any slope, where plain rounds take hundreds, or leave for ever."""
    rng = np.random.default_rng(1)
    basis, _ = np.linalg.qr(rng.normal(size=(4, 4)))
    turn = np.kron(np.eye(2), np.array([[0.0, -slope], [0.6 * slope, 0.0]]))
    a, b = basis @ turn @ basis.T, rng.normal(size=4)
    guess, step, work = np.zeros((DEPTH + 1, 4)), np.zeros((DEPTH + 1, 4)), np.zeros((2, DEPTH + 1, 4))
    mixed, x = njit(lambda *given: mix(*given)), np.zeros(4)
    for done in range(5):
        guess[1:], step[1:] = guess[:-1].copy(), step[:-1].copy()
        guess[0], step[0] = x, a @ x + b - x
        mixed(guess, step, work[0], work[1], min(done, DEPTH) + 1)
        x = work[0, DEPTH].copy()
    assert x == pytest.approx(np.linalg.solve(np.eye(4) - a, b), rel=1e-8)
