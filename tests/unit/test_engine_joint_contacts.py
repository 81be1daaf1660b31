"""Contacts and loops of the engine in joint coordinates: against dense equations, statics, and bodies' own coordinates."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbline import engine
from tests.branches import branches, joint_rows, mass_matrix
from tests.four_bar import Linkage, angles_of, falls, no_torque, widest_gap

G = 9.81
FLOOR = engine.Body(name="floor", motion="static", shapes=[engine.Placed(engine.Plane())])
NOTHING = (0.0, 0.0, 0.0)


def surface(friction: float = 0.0, restitution: float = 0.0) -> dict[tuple[str, str], engine.Surface]:
    """The law of everything that touches here."""
    law = engine.Surface(static_friction=friction, kinetic_friction=friction, restitution=restitution)
    return {("default", "default"): law}


def world(bodies: Any, joints: Any, *, law: Any = None, gravity: Any = (0.0, 0.0, -G), **options: Any) -> engine.World:
    """In joint coordinates unless told otherwise."""
    chosen = engine.Options(**{"coordinates": "joint", **options})
    return engine.World(bodies, joints, law or surface(), gravity=gravity, options=chosen)


@pytest.mark.parametrize("held", [False, True], ids=["free", "held"])
def test_a_struck_tree_answers_as_the_dense_equations_of_all_its_bodies(held: bool) -> None:
    """A ball in the way of the outermost link, and one in the way of a link of the other branch.

    Of all velocities that the joints allow those after the blows are the nearest in kinetic energy to those before with the
    given impulses (Gauss's principle): solved here for all bodies, with multipliers for the joints. Both err by round-off,
    1e-16 times the condition of the mass matrix, below 1e5; the step of 1e-7 s turns links by 1e-6, of which the separation at
    the struck points, that of the step's end, takes a share of the speed alike.
    """
    bodies, joints = branches(held)
    still: list[engine.Body] = []
    for k in (2, 4):
        body = bodies[k]
        way = np.array(body.v_WB) / np.linalg.norm(body.v_WB)
        radius, off = 0.01, np.cross(way, (0.0, 0.6, 0.8)) * 0.004
        place = np.array(body.p_WB) + 2 * radius * (way * math.sqrt(1 - 0.04 * float(off @ off) / 0.004**2) + 0.2 * off / 0.004)
        bodies[k] = engine.Body(
            name=body.name, mass=body.mass, inertia=body.inertia, p_WB=body.p_WB, q_WB=body.q_WB, v_WB=body.v_WB,
            w_WB=body.w_WB, shapes=[engine.Placed(engine.Sphere(radius))],
        )  # fmt: skip
        still.append(
            engine.Body(name=f"ball{k}", motion="static", p_WB=tuple(place), shapes=[engine.Placed(engine.Sphere(radius))])
        )
    dt = 1e-7
    made = world([*bodies, *still], joints, law=surface(0.3), gravity=NOTHING, dt=dt, substeps=1)
    before = np.array([(*body.v_WB, *body.w_WB) for body in bodies]).ravel()
    made.step()
    after, contacts = made.state()[: len(bodies), 7:].ravel(), made.contacts()
    assert len(contacts.gap) == 2
    push = np.zeros_like(before)
    for pair, point, force in zip(contacts.bodies, contacts.point, contacts.force, strict=True):
        k = int(pair.min())
        f = dt * force * (1.0 if pair[1] == k else -1.0)
        push[6 * k : 6 * k + 6] += np.concatenate((f, np.cross(point - bodies[k].p_WB, f)))
    assert np.abs(push).max() > 0.01
    J, inverse = joint_rows(bodies, joints), np.linalg.inv(mass_matrix(bodies))
    holds = np.linalg.lstsq(J @ inverse @ J.T, -J @ inverse @ push, rcond=1e-10)[0]
    expected = before + inverse @ (push + J.T @ holds)
    largest = np.abs(before).max()
    assert np.abs(after - expected).max() <= 1e-5 * largest
    for pair, point, normal in zip(contacts.bodies, contacts.point, contacts.normal, strict=True):
        k = int(pair.min())
        velocity = after[6 * k : 6 * k + 3] + np.cross(after[6 * k + 3 : 6 * k + 6], point - bodies[k].p_WB)
        assert abs(normal @ velocity) <= 1e-5 * largest


def rod(name: str, middle: Any, **more: Any) -> engine.Body:
    """A rod of 1 kg and .4 m along x."""
    return engine.Body(
        name=name, mass=1.0, inertia=np.diag((0.002, 0.0147, 0.0147)), p_WB=middle,
        shapes=[engine.Placed(engine.Box((0.2, 0.03, 0.03)))], **more,
    )  # fmt: skip


def test_a_rod_on_a_hinge_lies_on_a_stop_with_the_force_of_the_lever() -> None:
    """N times the stop's lever is the weight times its own: moments about the hinge. Settled: what moves is below 1e-6."""
    stop = engine.Body(name="stop", motion="static", p_WB=(0.1, 0.0, -0.05), shapes=[engine.Placed(engine.Sphere(0.02))])
    hinge = engine.Revolute(name="hinge", parent=engine.WORLD, child="rod", anchor_W=(-0.2, 0, 0), axis_W=(0, 1, 0))
    made = world([stop, rod("rod", (0.0, 0.0, 0.0))], [hinge], law=surface(0.4))
    made.step(240)
    contacts = made.contacts()
    assert np.abs(made.state()[1, 7:]).max() < 1e-6
    moment = np.cross(contacts.point - (-0.2, 0.0, 0.0), contacts.force * np.where(contacts.bodies[:, 1:] == 1, 1.0, -1.0))
    weight = np.cross(made.state()[1, :3] - (-0.2, 0.0, 0.0), (0.0, 0.0, -G))
    # Settled to 1e-6 m/s, of which a step of 1/240 s could make a force of 1 kg x 1e-6 x 240, on levers of half a metre.
    assert abs(moment.sum(axis=0)[1] + weight[1]) <= 2.4e-4
    force, torque = made.reaction("hinge")[:3], made.reaction("hinge")[3:]
    total = (contacts.force * np.where(contacts.bodies[:, 1:] == 1, 1.0, -1.0)).sum(axis=0)
    assert np.abs(force + total + (0.0, 0.0, -G)).max() <= 2.4e-4
    assert abs(torque[1]) <= 1e-9


STIFFEST = G / (2 * math.pi * 240) ** 2
"""How deep a body lies on a spring that turns by a quarter in a sub-step of 1/960 s."""


@pytest.mark.parametrize(
    ("held", "hertz", "depth"),
    [(True, None, STIFFEST / 100), (True, 60.0, 16 * STIFFEST), (False, None, STIFFEST), (False, 60.0, 16 * STIFFEST)],
)
def test_a_contact_gives_way_as_the_spring_that_is_asked_for_and_under_links_as_one_that_bears_machines(
    held: bool, hertz: float | None, depth: float
) -> None:
    """A ball lies g / omega^2 deep; under links, unless told, the spring is stiffer by a hundred. Overdamped at a ratio of 10,
    what is left falls with omega / 20 = 19/s at least and, as sub-steps take it, with more than 10/s: after two seconds by
    e^-20, of 7e-5 m. Mobilities have 1e-6 more than they should."""
    ball = engine.Body(
        name="ball", mass=2.0, inertia=np.diag((0.008,) * 3), p_WB=(5, 0, 0.1), shapes=[engine.Placed(engine.Sphere(0.1))]
    )
    hinge = engine.Revolute(name="hinge", parent=engine.WORLD, child="rod", anchor_W=(-0.2, 0, 1), axis_W=(0, 1, 0))
    rail = engine.Prismatic(name="rail", parent=engine.WORLD, child="ball", anchor_W=(5, 0, 0.1), axis_W=(0, 0, 1))
    joints = [hinge, rail] if held else [hinge]
    made = world([FLOOR, rod("rod", (0.0, 0.0, 1.0)), ball], joints, contact_hertz=hertz)
    made.step(480)
    assert made.in_joint_coordinates
    assert made.state()[2, 2] == pytest.approx(0.1 - depth, abs=1.01e-6 * depth + 1e-12)


@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_a_pendulum_rebounds_from_a_wall_as_its_restitution_says(restitution: float) -> None:
    """It falls from the horizontal by 1 rad onto a ball: w^2 / 2 = m g l sin(1) / (moment about the hinge).

    Euler's method is of the first order: its energy errs by up to h w of itself over a fall, h = 1/960 s in sub-steps.
    """
    reach, inertia = 0.2, 0.0147 + 0.2**2
    fastest = math.sqrt(2 * G * reach * math.sin(1.0) / inertia)
    # The wall is a ball in the way of the rod's tip, on the side that the rod comes from below.
    place = np.array((0.3 * math.cos(1.0) - 0.05 * math.sin(1.0), 0.0, -0.3 * math.sin(1.0) - 0.05 * math.cos(1.0)))
    wall = engine.Body(name="wall", motion="static", p_WB=tuple(place), shapes=[engine.Placed(engine.Sphere(0.02))])
    hinge = engine.Revolute(name="hinge", parent=engine.WORLD, child="rod", anchor_W=NOTHING, axis_W=(0, 1, 0))
    made = world([wall, rod("rod", (reach, 0.0, 0.0))], [hinge], law=surface(0.0, restitution))
    rates = []
    for _ in range(120):
        made.step()
        rates.append(made.joint_motion("hinge")[1])
    struck = int(np.argmin(rates)) if restitution > 0 else int(np.argmax(rates)) + 1
    assert max(rates) == pytest.approx(fastest, rel=fastest / 960 + G * reach / inertia / 240 / fastest)
    rebound = min(rates)
    if restitution > 0:
        # What gravity gives in the step that the blow falls into is not known better than one step.
        assert -rebound == pytest.approx(restitution * fastest, abs=G * reach / inertia / 240 + fastest**2 / 960)
        assert struck > 0
    else:
        assert abs(rates[-1]) < 1e-3


@pytest.mark.parametrize(("friction", "slides"), [(0.7, False), (0.3, True)])
def test_two_boxes_on_a_hinge_stick_to_a_slope_or_slide_down_it(friction: float, slides: bool) -> None:
    """At 30 degrees, tan = .577: below it they stay, above they slide with g (sin - mu cos), by Coulomb's law.

    A sliding start errs by a step's gravity, g sin / 240; what sticks creeps by less than a tenth of a millimetre in .25 s.
    """
    lean = math.radians(30)
    # Down the slope is +x: gravity leans instead of the floor.
    gravity = (G * math.sin(lean), 0.0, -G * math.cos(lean))
    half = (0.1, 0.1, 0.05)
    boxes = [
        engine.Body(
            name=f"box{k}", mass=1.0 + k, inertia=np.diag((0.00417, 0.00417, 0.00667)) * (1.0 + k), p_WB=(0.21 * k, 0, 0.05),
            shapes=[engine.Placed(engine.Box(half))],
        )
        for k in range(2)
    ]  # fmt: skip
    hinge = engine.Revolute(name="hinge", parent="box0", child="box1", anchor_W=(0.105, 0, 0.05), axis_W=(0, 1, 0))
    made = world([FLOOR, *boxes], [hinge], law=surface(friction), gravity=gravity)
    made.step(60)
    x, v = made.state()[1:, 0] - (0.0, 0.21), made.state()[1:, 7]
    total = made.contacts().force.sum(axis=0)
    assert abs(abs(total[2]) - 3.0 * G * math.cos(lean)) <= 0.01 * 3.0 * G
    if slides:
        speed = G * (math.sin(lean) - friction * math.cos(lean)) * 0.25
        assert v == pytest.approx([speed, speed], abs=G * math.sin(lean) / 240)
    else:
        assert np.abs(x).max() < 1e-4
        assert np.abs(v).max() < 1e-3


def chain(links: int, height: float, **options: Any) -> engine.World:
    """Capsules on balls in a row above the floor, beside a free box in the way."""
    bodies, joints = [FLOOR], []
    for k in range(links):
        bodies.append(
            engine.Body(
                name=f"link{k}", mass=0.5, inertia=np.diag((0.0005, 0.002, 0.002)), p_WB=(0.2 * k, 0.0, height),
                q_WB=(math.cos(math.pi / 4), 0, math.sin(math.pi / 4), 0), v_WB=(0.3, 0.0, 0.0),
                shapes=[engine.Placed(engine.Capsule(0.03, 0.06))],
            )
        )  # fmt: skip
        if k > 0:
            ends = {"parent": f"link{k - 1}", "child": f"link{k}", "anchor_W": (0.2 * k - 0.1, 0, height)}
            joints.append(engine.Revolute(name=f"hinge{k}", axis_W=(0, 1, 0), **ends))  # type: ignore[arg-type]
    box = engine.Body(
        name="box", mass=0.2, inertia=np.eye(3) * 2.1e-4, p_WB=(0.2 * links, 0, 0.04),
        shapes=[engine.Placed(engine.Box((0.04,) * 3))],
    )  # fmt: skip
    return world([*bodies, box], joints, law=surface(0.5), **options)


def test_a_chain_that_falls_beside_a_box_comes_to_lie_as_it_does_in_its_bodies_own_coordinates() -> None:
    """Both stop within the way that friction allows, v^2 / (2 mu g) = 9 mm, and where they touch down is a matter of a step.

    The floor bears the weight, to the speed of 1e-4 m/s over a step; each link lies a radius above it, less what a soft
    contact gives way, a hundredth of the margin of 1 mm.
    """
    mine, own = chain(4, 0.04), chain(4, 0.04, coordinates="maximal")
    assert mine.in_joint_coordinates
    assert not own.in_joint_coordinates
    for made in (mine, own):
        made.step(96)
    weight = (4 * 0.5 + 0.2) * G
    assert abs(mine.contacts().force[:, 2].sum()) == pytest.approx(weight, abs=2.2 * 1e-4 * 240)
    assert mine.state()[1:5, 2] == pytest.approx([0.03] * 4, abs=1e-5)
    assert np.abs(mine.state()[1:, 7:10]).max() < 1e-4
    apart = np.abs(mine.state()[1:, :3] - own.state()[1:, :3])
    assert apart[:, 2].max() <= 1e-5
    assert apart[:, 0].max() <= 0.3 / 240


def test_a_tree_and_a_box_that_meet_in_the_air_keep_their_momentum_and_lose_energy() -> None:
    """Momentum to round-off: contacts give both the same. Angular momentum errs where relaxing impulses, of a sub-step's drift,
    act on ways of a sub-step: by 1e-3 of what they exchange."""
    bodies, joints = branches(held=False)
    outer = bodies[4]
    bodies[4] = engine.Body(
        name=outer.name, mass=outer.mass, inertia=outer.inertia, p_WB=outer.p_WB, q_WB=outer.q_WB, v_WB=outer.v_WB,
        w_WB=outer.w_WB, shapes=[engine.Placed(engine.Sphere(0.05))],
    )  # fmt: skip
    way = np.array(outer.v_WB) / np.linalg.norm(outer.v_WB)
    box = engine.Body(
        name="box", mass=0.7, inertia=np.diag((0.003, 0.004, 0.005)), p_WB=tuple(np.array(outer.p_WB) + 0.2 * way),
        shapes=[engine.Placed(engine.Box((0.08, 0.09, 0.1)))],
    )  # fmt: skip
    made = world([*bodies, box], joints, law=surface(0.4), gravity=NOTHING)
    everyone = [*bodies, box]

    def measured() -> tuple[np.ndarray, np.ndarray, float]:
        state = made.state()
        linear, angular, energy = np.zeros(3), np.zeros(3), 0.0
        for body, row in zip(everyone, state, strict=True):
            turn = Rotation.from_quat(row[3:7], scalar_first=True).as_matrix()
            spin = turn @ np.array(body.inertia) @ turn.T @ row[10:]
            linear, angular = linear + body.mass * row[7:10], angular + spin + body.mass * np.cross(row[:3], row[7:10])
            energy += float(body.mass * row[7:10] @ row[7:10] + row[10:] @ spin) / 2
        return linear, angular, energy

    begin, touched = measured(), 0
    for _ in range(60):
        made.step()
        touched += len(made.contacts().gap) > 0
    end = measured()
    assert touched > 0
    assert np.linalg.norm(made.state()[-1, 7:10]) > 0.05
    scale = sum(body.mass * np.linalg.norm(body.v_WB) for body in everyone)
    assert np.abs(end[0] - begin[0]).max() <= 1e-12 * scale
    assert np.abs(end[1] - begin[1]).max() <= 1e-3 * scale
    assert end[2] < begin[2]


def test_a_limit_and_the_floor_hold_an_arm_together() -> None:
    """Two rods, the inner one on a hinge to the world and on a block, the outer one at its limit on the inner one's end.

    The hinge between them bears the outer rod's weight by its limit: moment m g l / 2, to what moves at 1e-6 m/s.
    """
    rods = [rod("inner", (0.2, 0.0, 0.1)), rod("outer", (0.6, 0.0, 0.1))]
    joints = [
        engine.Revolute(name="shoulder", parent=engine.WORLD, child="inner", anchor_W=(0, 0, 0.1), axis_W=(0, 1, 0)),
        engine.Revolute(
            name="elbow",
            parent="inner",
            child="outer",
            anchor_W=(0.4, 0, 0.1),
            axis_W=(0, 1, 0),
            limits=engine.Limits(lower=-0.5, upper=0.0),
        ),
    ]
    # A block under the inner rod's end, so that the outer one hangs free beyond it.
    block = engine.Body(
        name="block", motion="static", p_WB=(0.35, 0.0, 0.03), shapes=[engine.Placed(engine.Box((0.03, 0.1, 0.03)))]
    )
    made = world([block, *rods], joints, law=surface(0.5))
    made.step(240)
    angle, rate = made.joint_motion("elbow")
    assert abs(angle) <= 1e-9
    assert abs(rate) <= 1e-6
    lean = made.joint_motion("shoulder")[0]
    torque = made.reaction("elbow")[4]
    assert abs(torque) == pytest.approx(G * 0.2 * math.cos(lean), abs=1e-3)


def test_a_linkage_in_joint_coordinates_falls_as_its_one_angle_does() -> None:
    """Errors halve with the step, as Euler's do, to 1/4 of themselves; the loop's gap falls with its square."""
    seconds = 0.2
    angle, _, pose = falls(seconds, no_torque, {})
    truth, errors, gaps = np.array((angle, pose.coupler, pose.rocker)), [], []
    for dt in (0.01, 0.005):
        made = Linkage().world("semi_implicit_euler", dt, coordinates="joint")
        assert made.in_joint_coordinates
        made.step(round(seconds / dt))
        errors.append(np.abs(angles_of(made) - truth).max())
        gaps.append(widest_gap(made))
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.25)
    assert errors[1] < 0.01
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.25)
    assert gaps[1] < 1e-4


def test_a_world_that_grows_and_one_that_is_restored_go_on_to_the_bit() -> None:
    """Steps in one call, one by one, from a state saved before it grew, and in a batch.

    So wide a margin makes contacts of all 190 pairs but those of neighbours, and there is room for 8 a body and 16.
    """

    def wide() -> engine.World:
        return chain(18, 0.035, margin=5.0)

    one, other = wide(), wide()
    start = one.save()
    one.step(4)
    assert len(one.save()[0]) > len(start[0])
    for _ in range(4):
        other.step()
    assert np.array_equal(one.state(), other.state())
    other.restore(start)
    other.step(4)
    assert np.array_equal(one.state(), other.state())
    batch = engine.Batch.replicate(wide(), 2)
    batch.step(4)
    assert np.array_equal(batch.state()[1], one.state())


def test_trees_that_touch_are_taken_by_themselves_unless_most_bodies_are_loose() -> None:
    assert chain(2, 0.04, coordinates="automatic").in_joint_coordinates
    assert chain(2, 0.04, coordinates=None).in_joint_coordinates
    assert not chain(2, 0.04, coordinates="maximal").in_joint_coordinates
    shapes = [engine.Placed(engine.Sphere(0.1))]
    link, *loose = [
        engine.Body(name=f"b{k}", mass=1.0, inertia=0.1 * np.eye(3), p_WB=(k, 0.0, 1.0), shapes=shapes) for k in range(3)
    ]
    hook = engine.Revolute(name="hook", parent=engine.WORLD, child=link.name, anchor_W=(0, 0, 1.5), axis_W=(0, 1, 0))
    for others, joint in ((loose[:1], True), (loose, False)):
        assert engine.World([link, *others], [hook]).in_joint_coordinates == joint


def test_what_contacts_and_loops_lack_in_joint_coordinates_is_refused_with_the_reason() -> None:
    for options, reason in (
        ({"solver": "exact"}, "contacts under the solver 'exact'"),
        ({"solver": "sequential_impulses"}, "contacts under the solver 'sequential_impulses'"),
        ({"integrator": "rk4"}, "contacts under the integrator 'rk4'"),
        ({"continuous": "swept"}, "contacts and swept collision"),
        ({"sleeping": True}, "contacts and sleep"),
    ):
        with pytest.raises(engine.NotSupported, match=reason):
            chain(2, 0.04, **options)
    for options in ({"solver": "exact"}, {"integrator": "rk4"}, {"sleeping": True}):  # which know joints beside contacts
        assert not chain(2, 0.04, **options, coordinates="automatic").in_joint_coordinates
    with pytest.raises(engine.NotSupported, match="joint 'rocker_pin' under the integrator 'rk4'"):
        Linkage().world("rk4", coordinates="joint")
    with pytest.raises(engine.NotSupported, match="closes a loop with a spring"):
        Linkage(spring=engine.Spring(stiffness=1.0)).world("semi_implicit_euler", coordinates="joint")
