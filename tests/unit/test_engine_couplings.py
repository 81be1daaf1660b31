"""Coupled joints of the reference engine: closed forms, and what is left of the dense equations of all coordinates."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbline import engine
from plumbline.engine.articulated import tables as to
from tests.branches import branches, joint_rows, mass_matrix
from tests.random_trees import LINKS, Tree, pin, random_tree, table, world_of
from tests.unit.test_engine_joint_coordinate_laws import LAWS, allowed, needed_forces

G = 9.81
INTEGRATORS = ("semi_implicit_euler", "rk4", "implicit_midpoint", "dormand_prince")
NOTHING = (0.0, 0.0, 0.0)


def body(name: str, p: Any = NOTHING, mass: float = 2.0, moment: float = 0.3, **more: Any) -> engine.Body:
    """A body with the same moment of inertia about all axes."""
    return engine.Body(name=name, mass=mass, inertia=moment * np.eye(3), p_WB=p, **more)


def hinge(name: str, child: str, anchor: Any = NOTHING, parent: str = engine.WORLD, **more: Any) -> engine.Revolute:
    """A hinge about y."""
    return engine.Revolute(name=name, parent=parent, child=child, anchor_W=anchor, axis_W=(0.0, 1.0, 0.0), **more)


def drop(name: str, child: str, anchor: Any = NOTHING, **more: Any) -> engine.Prismatic:
    """A slide downwards."""
    return engine.Prismatic(name=name, parent=engine.WORLD, child=child, anchor_W=anchor, axis_W=(0.0, 0.0, -1.0), **more)


def tie(joint: str, ratio: float, offset: float = 0.0) -> engine.Coupling:
    """x = ratio y + offset."""
    return engine.Coupling(joint=joint, ratio=ratio, offset=offset)


def machine(heavy: Any = None, light: Any = None, axle: Any = None, more: Any = (), **options: Any) -> engine.World:
    """Atwood's: 3 and 1 kg on a cord over a pulley of .3 kg m2 and .5 m radius. Args: heavy, light, axle: of the joints."""
    bodies = [body("pulley"), body("heavy", (1.0, 0.0, 0.0), 3.0), body("light", (-1.0, 0.0, 0.0), 1.0)]
    joints: list[engine.Joint] = [
        hinge("axle", "pulley", **(axle or {})),
        drop("down", "heavy", bodies[1].p_WB, coupling=tie("axle", 0.5), **(heavy or {})),
        drop("up", "light", bodies[2].p_WB, coupling=tie("down", -1.0), **(light or {})),
    ]
    chosen = engine.Options(**{"dt": 0.01, "substeps": 1, **options})
    return engine.World([*bodies, *more], joints, options=chosen)


WEIGHT = 3.0 + 1.0 + 0.3 / 0.5**2
"""What falls with the heavy body of the machine, along its way [kg]."""


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_atwoods_machine_falls_as_its_closed_form_and_its_cords_carry_what_they_must(integrator: str) -> None:
    """a = (M - m) g / (M + m + I / r^2) is constant: every integrator is exact but semi-implicit Euler, whose way is
    a t (t + dt) / 2. Cords carry M (g - a) and m (g + a). Round-off of some hundred operations a step, of ways below 1 m."""
    world, t, dt = machine(integrator=integrator), 0.4, 0.01
    world.step(40)
    a = 2.0 * G / WEIGHT
    way = 0.5 * a * t * (t + (dt if integrator == "semi_implicit_euler" else 0.0))
    expected = {"down": (way, a * t), "up": (-way, -a * t), "axle": (2 * way, 2 * a * t)}
    for name, motion in expected.items():
        assert world.joint_motion(name) == pytest.approx(motion, abs=1e-11)
    assert world.reaction("down")[2] == pytest.approx(3.0 * (G - a), abs=1e-9)
    assert world.reaction("up")[2] == pytest.approx(1.0 * (G + a), abs=1e-9)
    assert world.state()[1, 2] == pytest.approx(-way, abs=1e-11)


def test_a_yo_yo_falls_by_its_moment_over_the_square_of_its_radius() -> None:
    """A spool of 1.8 kg and I = 2e-3 kg m2 on a carriage of .2 kg that falls with it, r = 1 cm: a = g / (1 + I / (m r^2))."""
    bodies = [body("carriage", mass=0.2, moment=1e-3), body("spool", mass=1.8, moment=2e-3)]
    string = drop("string", "carriage", coupling=tie("spin", 0.01))
    joints: list[engine.Joint] = [string, hinge("spin", "spool", parent="carriage")]
    world = engine.World(bodies, joints, options=engine.Options(dt=0.01, integrator="rk4"))
    world.step(100)
    a = G / (1.0 + 2e-3 / (2.0 * 0.01**2))
    assert world.joint_motion("string") == pytest.approx((0.5 * a, a), rel=1e-11)
    assert world.joint_motion("spin") == pytest.approx((50 * a, 100 * a), rel=1e-11)


TIES = {5: (1, 0.7), 4: (1, -1.3), 9: (8, 2.0)}
"""In random trees, whose joints 0, 4, 8 are hinges and 1, 5, 9 slides: two follow one, across branches."""


def reduction(model: Any, ties: dict[int, tuple[int, float]]) -> np.ndarray:
    """R (n, m) with q' = R y', y' the rates of coordinates that follow no other."""
    full = np.eye(model.nv)
    at = {number: model.idx_vs[model.getJointId(f"joint{number}")] for number in {*ties, *(one for one, _ in ties.values())}}
    for number, (leader, ratio) in ties.items():
        full[at[number], at[leader]] = ratio
    return np.delete(full, [at[number] for number in ties], axis=1)


def equations(tree: Tree) -> tuple[np.ndarray, np.ndarray]:
    """M (n, n) and b (n,) of M q'' + b = 0, column by column from Pinocchio's inverse dynamics."""
    still = np.zeros(tree.model.nv)

    def force(v: np.ndarray, a: np.ndarray) -> np.ndarray:
        return np.array(pin.rnea(tree.model, tree.model.createData(), tree.q, v, a))

    weight = force(still, still)
    return np.array([force(still, unit) - weight for unit in np.eye(tree.model.nv)]).T, force(tree.v, still)


@pytest.mark.parametrize("floating", [False, True], ids=["held", "free"])
def test_tied_trees_have_the_accelerations_of_the_equations_that_are_left(floating: bool) -> None:
    """R^T M R y'' = -R^T b with Pinocchio's mass matrix M and forces b: to 1e-9 of the largest, round-off, 1e-16, times the
    condition of M, below 1e5, and of what ties take away of accelerations ten times as large."""
    for seed in range(6):
        tree = random_tree(seed, floating, backwards=not floating, ties=TIES)
        M, b = equations(tree)
        R = reduction(tree.model, TIES)
        wanted = R @ np.linalg.solve(R.T @ M @ R, -R.T @ b)
        free = np.linalg.solve(M, -b)
        world = world_of(tree, dt=1e-16, integrator="rk4")
        kinds = to.int_view(world.save()[1], to.KIND)
        world.step(1)
        along, largest = table(world, to.ALONG), np.abs(free).max()
        for link in kinds[kinds[:, to.COLUMNS] == 1]:
            at = tree.model.idx_vs[tree.model.getJointId(f"joint{link[to.ROW]}")]
            assert along[link[to.FIRST], to.CHANGE] == pytest.approx(wanted[at], abs=1e-9 * largest)
        assert np.abs(wanted - free).max() > 0.1


@pytest.mark.parametrize("floating", [False, True], ids=["held", "free"])
def test_integrators_converge_to_one_motion_of_a_tied_tree(floating: bool) -> None:
    """At half the step the errors against Dormand and Prince's, of 1e-12, are a half, a fourth and a sixteenth, to a quarter of
    that; ties hold to round-off, of coordinates near 1 and rates below 1e2. Semi-implicit Euler's velocities are those between
    poses, which keep to ties as they do to joints, by the order of a step."""
    tree = random_tree(11, floating, backwards=not floating, ties=TIES)
    truth = world_of(tree, dt=4e-2, integrator="dormand_prince", tolerance=1e-12)
    truth.step()
    for integrator, order in (("semi_implicit_euler", 1), ("implicit_midpoint", 2), ("rk4", 4)):
        errors = []
        for dt in (2e-3, 1e-3):
            world = world_of(tree, dt=dt, integrator=integrator)
            world.step(round(4e-2 / dt))
            errors.append(np.abs(world.state() - truth.state()).max())
            for number, (leader, ratio) in TIES.items():
                (x, rate), (y, led_by) = (world.joint_motion(f"joint{k}") for k in (number, leader))
                assert x == pytest.approx(0.7 + ratio * (y - 0.7), abs=1e-13)
                if integrator != "semi_implicit_euler":
                    assert rate == pytest.approx(ratio * led_by, abs=1e-11)
        assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25 * order)


@pytest.mark.parametrize("seeds", [range(6), pytest.param(range(6, 60), marks=pytest.mark.slow)], ids=["few", "many"])
def test_laws_of_tied_coordinates_hold_together_at_the_end_of_every_step(seeds: range) -> None:
    """What acts along the coordinate that leads, with ratio times what acts along those that follow, is what all their laws
    allow at the rates that were taken: limits, friction, clipped drives, springs and rotors. Tolerances: as without ties."""
    ties = {4: (1, -1.3), 6: (3, 0.5), 10: (8, 2.0), 11: (8, -1.0)}
    held = set()
    for seed in seeds:
        tree = random_tree(seed, floating=False, kinds=("revolute", "prismatic"), backwards=False, ties=ties)
        tree.joints = [replace(joint, **LAWS[(k + seed) % len(LAWS)]) for k, joint in enumerate(tree.joints)]
        h = 1e-2
        world = world_of(tree, dt=h)
        start = world.state().copy()
        kinds = to.int_view(world.save()[1], to.KIND)
        world.step(1)
        rates = np.zeros(LINKS)
        for link in kinds:
            at = tree.model.idx_vs[tree.model.getJointId(f"joint{link[to.ROW]}")]
            rates[at] = table(world, to.COLUMN)[link[to.FIRST], to.RATE]
        change, forces = (rates - tree.v) / h, needed_forces(tree, start, world.state(), h)
        for leader in range(LINKS):
            if leader in ties:
                continue
            low, high, force = 0.0, 0.0, 0.0
            for k, ratio in [(leader, 1.0), *((k, ratio) for k, (one, ratio) in ties.items() if one == leader)]:
                joint, at = tree.joints[k], tree.model.idx_vs[tree.model.getJointId(f"joint{k}")]
                force += ratio * (forces[at] + joint.armature * change[at])  # type: ignore[union-attr]
                ends = sorted(ratio * bound for bound in allowed(joint, rates[at], h))
                low, high = low + ends[0], high + ends[1]
            assert low - 1e-6 <= force <= high + 1e-6
            held.add((low < high, bool(abs(rates[tree.model.idx_vs[tree.model.getJointId(f"joint{leader}")]]) < 1e-9)))
    assert held >= {(True, True), (True, False), (False, False)}


def test_a_limit_on_a_coordinate_that_follows_stops_the_whole_machine() -> None:
    """The light weight may rise by .2 m: there all stand, and its cord carries what the heavy one weighs: 3 g, less its own
    weight that the stop would have to hold. At the limit to round-off."""
    world = machine(light={"limits": engine.Limits(lower=-0.2)})
    world.step(100)
    assert world.joint_motion("up") == pytest.approx((-0.2, 0.0), abs=1e-12)
    assert world.joint_motion("axle") == pytest.approx((0.4, 0.0), abs=1e-12)
    # The stop pushes the light weight down by what the machine would fall with, 2 g; the cord holds both.
    assert world.reaction("down")[2] == pytest.approx(3.0 * G, abs=1e-8)


def test_limits_of_both_fingers_of_a_gripper_are_one() -> None:
    """Both end at the same place, told in digits that round apart, and are driven there from either side."""
    for target, end in ((1.0, 0.04), (-1.0, 0.01)):
        fingers = [body("left", (0.0, 0.1, 0.0), 0.1, 1e-4), body("right", (0.0, -0.1, 0.0), 0.1, 1e-4)]
        drive, limits = (
            engine.Drive(stiffness=50.0, damping=1.0, target=target, limit=5.0),
            engine.Limits(lower=0.01, upper=0.04),
        )
        joints = [
            engine.Prismatic(name="a", parent=engine.WORLD, child="left", anchor_W=(0.0, 0.1, 0.0), axis_W=(0.0, 1.0, 0.0),
                             position=0.03, drive=drive, limits=limits),
            engine.Prismatic(name="b", parent=engine.WORLD, child="right", anchor_W=(0.0, -0.1, 0.0), axis_W=(0.0, -1.0, 0.0),
                             position=0.009, coupling=tie("a", 0.3), limits=engine.Limits(lower=0.3 * 0.01, upper=0.3 * 0.04)),
        ]  # fmt: skip
        world = engine.World(fingers, joints, options=engine.Options(dt=1e-3, substeps=1))
        world.step(300)
        assert world.joint_motion("a") == pytest.approx((end, 0.0), abs=1e-12)
        assert world.joint_motion("b") == pytest.approx((0.3 * end, 0.0), abs=1e-12)


def test_dry_friction_of_all_tied_joints_adds_up_by_their_ratios() -> None:
    """The weights pull with 2 g = 19.62 N along the cord; friction of 10 N there and of 5 N m on the axle, over .5 m 10 N, hold
    them; with 9.5 N they slip by a = .12 N / 5.2 kg. Semi-implicit Euler, as above; round-off of the balance, 1e-13 N."""
    holds = machine(heavy={"friction_loss": 10.0}, axle={"friction_loss": 5.0})
    holds.step(50)
    assert holds.joint_motion("down") == pytest.approx((0.0, 0.0), abs=1e-12)
    slips = machine(heavy={"friction_loss": 9.5}, axle={"friction_loss": 5.0})
    slips.step(50)
    a = (2.0 * G - 19.5) / WEIGHT
    assert slips.joint_motion("down") == pytest.approx((0.5 * a * 0.5 * 0.51, 0.5 * a), rel=1e-9)


def test_a_limit_of_speed_on_one_is_one_on_all() -> None:
    """1.2 rad/s at the axle are .6 m/s of the weights, reached after .6 / a."""
    world = machine(axle={"speed_limit": 1.2})
    world.step(100)
    assert world.joint_motion("down")[1] == pytest.approx(0.6, abs=1e-12)
    assert world.joint_motion("up")[1] == pytest.approx(-0.6, abs=1e-12)


def coordinate_row(bodies: list[engine.Body], joint: Any) -> np.ndarray:
    """The rate of a joint's coordinate as a row on (v, w) of all bodies."""
    number, axis = {one.name: k for k, one in enumerate(bodies)}, np.array(joint.axis_W)
    row = np.zeros(6 * len(bodies))
    for name, sign in ((joint.child, 1.0), (joint.parent, -1.0)):
        if name in number:
            k = 6 * number[name]
            if isinstance(joint, engine.Revolute):
                row[k + 3 : k + 6] = sign * axis
            else:
                row[k : k + 3] = sign * axis
                row[k + 3 : k + 6] = sign * np.cross(np.array(joint.anchor_W) - bodies[number[name]].p_WB, axis)
    return row


@pytest.mark.parametrize("apart", [False, True], ids=["one tree", "two trees"])
def test_struck_links_of_tied_trees_answer_as_the_dense_equations_of_all_bodies(apart: bool) -> None:
    """As without ties (test_engine_joint_contacts), with a row for each tie among those of the joints: one within a tree, or
    between two, of which one is struck and the other's bodies are looked at too. Round-off, and a turn of 1e-6 in a step."""
    bodies, joints = branches(held=True)
    if apart:
        others, hooks = branches(held=True, seed=8)
        shift = np.array((9.0, 0.0, 0.0))
        bodies += [replace(one, name="other " + one.name, p_WB=tuple(np.array(one.p_WB) + shift)) for one in others]
        for one in hooks:
            parent = one.parent if one.parent == engine.WORLD else "other " + one.parent
            place: dict[str, Any] = {"anchor_W": tuple(np.array(one.anchor_W) + shift)}  # type: ignore[union-attr]
            joints.append(replace(one, name="other " + one.name, parent=parent, child="other " + one.child, **place))
    ties = {"joint1": ("other joint4" if apart else "joint4", -1.7), "joint3": ("joint0", 0.4)}
    named = {joint.name: joint for joint in joints}
    rows = [coordinate_row(bodies, named[a]) - ratio * coordinate_row(bodies, named[b]) for a, (b, ratio) in ties.items()]
    J = np.vstack((joint_rows(bodies, joints), rows))
    inverse = np.linalg.inv(mass_matrix(bodies))
    before = np.array([(*one.v_WB, *one.w_WB) for one in bodies]).ravel()
    before -= inverse @ J.T @ np.linalg.lstsq(J @ inverse @ J.T, J @ before, rcond=1e-10)[0]
    bodies = [
        replace(one, v_WB=tuple(before[6 * k : 6 * k + 3]), w_WB=tuple(before[6 * k + 3 : 6 * k + 6]))
        for k, one in enumerate(bodies)
    ]
    joints = [replace(j, coupling=tie(*ties[j.name])) if j.name in ties else j for j in joints]  # type: ignore[arg-type]
    still: list[engine.Body] = []
    for k in (2, 4):
        way = np.array(bodies[k].v_WB) / np.linalg.norm(bodies[k].v_WB)
        aside = np.cross(way, (0.0, 0.6, 0.8))
        centre = np.array(bodies[k].p_WB) + 0.02 * (math.sqrt(0.96) * way + 0.2 * aside / np.linalg.norm(aside))
        bodies[k] = replace(bodies[k], shapes=[engine.Placed(engine.Sphere(0.01))])
        still.append(
            engine.Body(name=f"ball{k}", motion="static", p_WB=tuple(centre), shapes=[engine.Placed(engine.Sphere(0.01))])
        )
    dt = 1e-7
    law = {("default", "default"): engine.Surface(static_friction=0.3, kinetic_friction=0.3)}
    options = engine.Options(dt=dt, substeps=1, iterations=50)
    world = engine.World([*bodies, *still], joints, law, gravity=NOTHING, options=options)
    world.step()
    after, contacts = world.state()[: len(bodies), 7:].ravel(), world.contacts()
    push = np.zeros_like(before)
    for pair, point, force in zip(contacts.bodies, contacts.point, contacts.force, strict=True):
        k = int(pair.min())
        f = dt * force * (1.0 if pair[1] == k else -1.0)
        push[6 * k : 6 * k + 6] += np.concatenate((f, np.cross(point - bodies[k].p_WB, f)))
    assert np.abs(push).max() > 0.01
    holds = np.linalg.lstsq(J @ inverse @ J.T, -J @ inverse @ push, rcond=1e-10)[0]
    largest = np.abs(before).max()
    assert np.abs(after - before - inverse @ (push + J.T @ holds)).max() <= 1e-5 * largest
    for pair, point, normal in zip(contacts.bodies, contacts.point, contacts.normal, strict=True):
        k = int(pair.min())
        velocity = after[6 * k : 6 * k + 3] + np.cross(after[6 * k + 3 : 6 * k + 6], point - bodies[k].p_WB)
        assert abs(normal @ velocity) <= 1e-5 * largest


def test_a_machine_lets_its_heavy_weight_down_on_the_floor() -> None:
    """The floor carries what the cord does not: 2 g, and the light weight hangs still; to what soft contacts sink by."""
    floor = engine.Body(
        name="floor", motion="static", p_WB=(1.0, 0.0, -0.3), shapes=[engine.Placed(engine.Box((0.5, 0.5, 0.1)))]
    )
    bodies = [
        body("pulley"),
        body("heavy", (1.0, 0.0, 0.0), 3.0, shapes=[engine.Placed(engine.Sphere(0.1))]),
        body("light", (-1.0, 0.0, 0.0), 1.0),
        floor,
    ]
    joints: list[engine.Joint] = [
        hinge("axle", "pulley"),
        drop("down", "heavy", bodies[1].p_WB, coupling=tie("axle", 0.5)),
        drop("up", "light", bodies[2].p_WB, coupling=tie("down", -1.0)),
    ]
    law = {("default", "default"): engine.Surface()}
    world = engine.World(bodies, joints, law, options=engine.Options(dt=1e-2, substeps=4))
    world.step(200)
    assert abs(world.contacts().force[:, 2].sum()) == pytest.approx(2.0 * G, rel=1e-3)
    assert world.state()[:3, 2] == pytest.approx((0.0, -0.1, 0.1), abs=1e-4)
    assert np.abs(world.state()[:3, 7:]).max() < 1e-6


def test_what_knows_no_couplings_refuses_them_by_name() -> None:
    """Bodies' own coordinates, integrators of stages that trees lack, solvers of contacts without trees, loops, and starts."""
    ball: dict[str, Any] = {"shapes": [engine.Placed(engine.Sphere(0.1))]}
    loose = [body("a", (5.0, 0.0, 0.0), **ball), body("b", (7.0, 0.0, 0.0), **ball)]
    for options, why in (
        ({"coordinates": "maximal"}, "coupled joint 'down' with bodies' own coordinates"),
        ({"integrator": "velocity_verlet"}, "coupled joint 'down' with the integrator 'velocity_verlet'"),
    ):
        with pytest.raises(engine.NotSupported, match=why):
            machine(**options)
    for options, why in (
        ({"integrator": "rk4"}, "with contacts under the integrator 'rk4'"),
        ({"solver": "exact"}, "with contacts under the solver 'exact'"),
        ({"continuous": "swept"}, "with contacts and swept collision"),
    ):
        with pytest.raises(engine.NotSupported, match=why):
            machine(more=loose, **options)
    assert machine(more=loose).in_joint_coordinates
    with pytest.raises(ValueError, match="coupling to 'none': 'none' has no coordinate"):
        machine(axle={"coupling": tie("none", 1.0)})
    with pytest.raises(ValueError, match="follows itself"):
        machine(axle={"coupling": tie("up", 1.0)})
    with pytest.raises(ValueError, match=r"position 0.1, expected 0"):
        machine(light={"position": 0.1})
    drives = {"drive": engine.Drive(damping=1.0, limit=1.0)}
    with pytest.raises(ValueError, match="at most 2 drives with a limit"):
        machine(drives, drives, drives)
    with pytest.raises(ValueError, match="ratio 0"):
        tie("axle", 0.0)
    bodies = [body("pulley", w_WB=(0.0, 1.0, 0.0)), body("heavy", (1.0, 0.0, 0.0), v_WB=(0.0, 0.0, -0.4))]
    joints: list[engine.Joint] = [hinge("axle", "pulley"), drop("down", "heavy", bodies[1].p_WB, coupling=tie("axle", 0.5))]
    with pytest.raises(engine.NotSupported, match=r"its initial rate is 0.4, expected 0.5 by its coupling to 'axle'"):
        engine.World(bodies, joints)
    ring = [body("one", (1.0, 0.0, 0.0)), body("two", (2.0, 0.0, 0.0))]
    closes = [hinge("p", "one"), hinge("q", "two", (1.5, 0.0, 0.0), "one"), hinge("r", "two", (3.0, 0.0, 0.0))]
    with pytest.raises(engine.NotSupported, match="it closes a loop, and couplings tie coordinates of trees"):
        engine.World(ring, [replace(closes[0], coupling=tie("r", 1.0)), *closes[1:]])


def test_a_saved_tied_world_goes_on_as_it_was_and_turns_are_counted() -> None:
    """Bit for bit; and a pulley turns on beyond half a turn without its weights losing it."""
    world = machine(integrator="rk4")
    world.step(80)
    kept = world.save()
    world.step(20)
    end = world.state().copy()
    world.restore(kept)
    world.step(20)
    assert np.array_equal(world.state(), end)
    way, turn = world.joint_motion("down")[0], world.joint_motion("axle")[0]
    assert way == pytest.approx(0.5 * turn, abs=1e-12)
    assert turn > math.pi
    turned = Rotation.from_quat(end[0, 3:7], scalar_first=True).as_rotvec()
    assert turned[1] == pytest.approx(math.remainder(turn, 2 * math.pi), abs=1e-12)
