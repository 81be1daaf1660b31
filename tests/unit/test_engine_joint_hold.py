"""Joints hold bodies of any mass and inertia, say by name when they cannot, and refuse velocities that they forbid."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from plumbline import engine
from plumbline.harness.adapter import Settings, Unsupported
from plumbline.harness.scene import Body, Revolute, Scene

TREES = pytest.mark.usefixtures("both_coordinates")
"""Joints that make trees, in coordinates of either kind; loops have those of bodies whatever is asked for."""

G = 9.81
TRACKS = pytest.mark.parametrize("integrator", ["rk4", "semi_implicit_euler"])
FIRST = pytest.mark.parametrize("integrator", [pytest.param("rk4", marks=pytest.mark.slow), "semi_implicit_euler"])


def lasts(*seconds: float) -> pytest.MarkDecorator:
    """The shortest run that shows what is asked, and longer ones in which round-off would add up."""
    return pytest.mark.parametrize("seconds", [seconds[0], *(pytest.param(s, marks=pytest.mark.slow) for s in seconds[1:])])


def _world(bodies: list[engine.Body], joints: list[engine.Joint], integrator: str, **options: float) -> engine.World:
    return engine.World(bodies, joints, options=engine.Options(integrator=integrator, **{"dt": 1e-3, **options}))  # type: ignore[arg-type]


def _gap(world: engine.World, bodies: list[engine.Body], joints: list[engine.Joint]) -> float:
    """The widest gap [m] of the anchors of joints with one, from the poses alone."""
    index = {body.name: k for k, body in enumerate(bodies)}

    def place(name: str, anchor: np.ndarray) -> np.ndarray:
        if name == engine.WORLD:
            return anchor
        row, start = world.state()[index[name]], bodies[index[name]]
        return np.asarray(row[:3] + Rotation.from_quat(row[3:7], scalar_first=True).apply(anchor - start.p_WB))

    ends = [
        (place(j.parent, np.array(j.anchor_W)), place(j.child, np.array(j.anchor_W))) for j in joints if hasattr(j, "anchor_W")
    ]
    return max(float(np.linalg.norm(b - a)) for a, b in ends)


KINDS = ("ball", "revolute", "arm and fixed tip")
THIN = [*(pytest.param(kind, 1e-20) for kind in KINDS), pytest.param("ball", 1e-8)]
"""The thinnest on each joint, and one that is merely thin; what lies between is as easy as its neighbours."""
LESS_THIN = [
    pytest.param(kind, i, marks=pytest.mark.slow) for i in (1e-8, 1e-12, 1e-16) for kind in KINDS if (kind, i) != ("ball", 1e-8)
]


@TREES
@TRACKS
@lasts(1.0, 5.0)
@pytest.mark.parametrize(("kind", "inertia"), [*THIN, *LESS_THIN])
def test_a_pendulum_of_hardly_any_inertia_stays_on_its_anchor(
    kind: str, inertia: float, integrator: str, seconds: float
) -> None:
    """The bound is that of the task; round-off of a place at 1 m is 1e-16, of some tens of sums 1e-14.

    Runge-Kutta also keeps the swing: (w dt)^4 / 120 with w = 4.5/s and dt = 1e-3 s is 3e-12 a radian, some 20 of them in 5 s.
    Nothing turns it about its own arm but round-off, by 2e-4 g / l at most where coordinates are those of a tree (`THINNEST`).
    """
    point = np.array([0.6, 0.0, -0.8])
    bodies = [engine.Body(name="bob", inertia=inertia * np.eye(3), p_WB=point)]
    joints: list[engine.Joint] = [engine.Ball(name="hook", parent=engine.WORLD, child="bob", anchor_W=(0, 0, 0))]
    if kind != "ball":
        joints = [engine.Revolute(name="hook", parent=engine.WORLD, child="bob", anchor_W=(0, 0, 0), axis_W=(0, 1, 0))]
    if kind == "arm and fixed tip":
        bodies.append(engine.Body(name="tip", inertia=inertia * np.eye(3), p_WB=1.5 * point))
        joints.append(engine.Fixed(name="glue", parent="bob", child="tip"))
    world, worst = _world(bodies, joints, integrator), 0.0
    for _ in range(round(10 * seconds)):
        world.step(100)
        worst = max(worst, _gap(world, bodies, joints))
        if kind == "arm and fixed tip":
            worst = max(worst, float(np.linalg.norm(world.state()[1, :3] - 1.5 * world.state()[0, :3])))
    assert worst < 1e-9
    if kind == "ball":
        assert abs(world.state()[0, 10:13] @ world.state()[0, :3]) < seconds * 2e-4 * G
    if integrator == "rk4":
        moment, load = (1.0 + inertia, 1.0) if len(bodies) == 1 else (3.25 + 2 * inertia, 2.5)
        end = solve_ivp(
            lambda _, y: [y[1], -G * load * math.sin(y[0]) / moment], (0, seconds), [math.atan2(0.6, 0.8), 0.0], "DOP853",
            rtol=1e-13, atol=1e-14,
        ).y[0, -1]  # fmt: skip
        x, _, z = world.state()[0, :3]
        assert math.atan2(x, -z) == pytest.approx(end, abs=1e-9)


@TREES
@FIRST
@pytest.mark.parametrize("inertia", [1e-10, *(pytest.param(i, marks=pytest.mark.slow) for i in (1e-11, 1e-12)), 1e-13])
@pytest.mark.parametrize("links", [2, 3])
def test_a_chain_of_thin_links_on_skew_axes_holds(links: int, inertia: float, integrator: str) -> None:
    """Just where floats still carry the system, closing a gap of 1e-11 m takes turns of whole radians by rows that cancel.

    Round-off of places and of sums as in the pendulum. With Runge-Kutta energy stays: (w dt)^4 / 120 with w = 10/s is 1e-10 a
    radian, but of the rates only five digits are right.
    """
    corners = np.array([(0.3 * k, 0.1 * k, -0.2 * k) for k in range(links + 1)])
    bodies = [
        engine.Body(name=f"link{k}", inertia=inertia * np.eye(3), p_WB=corners[k : k + 2].mean(axis=0)) for k in range(links)
    ]
    names, axes = [engine.WORLD, *(body.name for body in bodies)], [(0, 1, 0.2), (1, 0.3, 0), (0.2, 1, 0.5)]
    joints: list[engine.Joint] = [
        engine.Revolute(name=f"pin{k}", parent=names[k], child=names[k + 1], anchor_W=corners[k], axis_W=axes[k])
        for k in range(links)
    ]
    world = _world(bodies, joints, integrator)

    def energy() -> float:
        s = world.state()
        return float(0.5 * (s[:, 7:10] ** 2).sum() + G * s[:, 2].sum())

    start = energy()
    for _ in range(10):
        world.step(50)
        assert _gap(world, bodies, joints) < 1e-9
        if integrator == "rk4":
            assert energy() == pytest.approx(start, abs=1e-4)


@TREES
def test_a_rod_too_thin_for_joints_is_refused_by_name() -> None:
    """Its inverse inertia, in axes that it lies askew to, has no digits left across it; one on the safe side is held."""
    turn = Rotation.from_euler("xyz", (0.4, 0.5, 0.6))

    def world(thin: float, **options: str) -> engine.World:
        rod = engine.Body(name="rod", inertia=np.diag((0.1, 0.1, thin)), q_WB=turn.as_quat(scalar_first=True))
        hook = engine.Ball(name="hook", parent=engine.WORLD, child="rod", anchor_W=turn.apply((0, 0, 0.5)))
        return engine.World([rod], [hook], options=engine.Options(dt=1e-3, **options))  # type: ignore[arg-type]

    with pytest.raises(engine.NotSupported, match=r"joints on body 'rod': .* from 9e-12 to 0.1 kg m2, expected at most 1e\+10"):
        world(0.9e-11)
    ends = []
    for thin in (1e-4, 1.1e-11):
        rod = world(thin, integrator="rk4")
        rod.step(300)
        ends.append(rod.state()[0, :3].copy())
    # A rod that turns about no more than its middle: its thickness is no part of how it swings but by thin / 0.35.
    assert ends[0] == pytest.approx(ends[1], abs=1e-3)


@TREES
@FIRST
def test_a_slider_of_hardly_any_inertia_stays_on_its_rail(integrator: str) -> None:
    """Down a rail at slope 4/5 it goes 1/2 g 4/5 t^2, under semi-implicit Euler t h / 2 g 4/5 more; across, round-off."""
    way = np.array([0.6, 0.0, -0.8])
    bodies = [engine.Body(name="slider", inertia=1e-16 * np.eye(3), p_WB=(0.0, 0.0, 1.0))]
    joints = [engine.Prismatic(name="rail", parent=engine.WORLD, child="slider", anchor_W=(3.0, 0.0, 0.0), axis_W=way)]
    world = _world(bodies, list(joints), integrator)
    world.step(1000)
    moved = world.state()[0, :3] - (0.0, 0.0, 1.0)
    assert float(np.linalg.norm(moved - (moved @ way) * way)) < 1e-12
    assert moved @ way == pytest.approx(0.5 * G * 0.8, abs=1e-9 if integrator == "rk4" else G * 1e-3)


@TREES
@FIRST
@lasts(2.0, 10.0)
def test_lines_of_10_km_and_links_under_heavy_bobs_hold(integrator: str, seconds: float) -> None:
    """A centimetre's ball on a line of 10 km, and a link of 1e-6 kg under a bob of 1e6 kg: round-off of 1e4 m is 2e-12 m."""
    line = [engine.Body(name="ball", inertia=0.4e-4 * np.eye(3), p_WB=(6000.0, 0.0, -8000.0))]
    hook = [engine.Ball(name="hook", parent=engine.WORLD, child="ball", anchor_W=(0, 0, 0))]
    link = engine.Body(name="link", mass=1e-6, inertia=1e-8 * np.eye(3), p_WB=(0.3, 0.0, -0.4))
    bob = engine.Body(name="bob", mass=1e6, inertia=4e4 * np.eye(3), p_WB=(0.6, 0.0, -0.8))
    hooks = [
        engine.Ball(name="upper", parent=engine.WORLD, child="link", anchor_W=(0, 0, 0)),
        engine.Ball(name="lower", parent="link", child="bob", anchor_W=(0.6, 0.0, -0.8)),
    ]
    for bodies, joints in ((line, list(hook)), ([link, bob], list(hooks))):
        world = _world(bodies, joints, integrator)
        for _ in range(round(seconds)):
            world.step(1000)
            assert _gap(world, bodies, joints) < 1e-9
    assert np.linalg.norm(world.state()[0, :3]) == pytest.approx(0.5, abs=1e-9)


def _cranks(inertia: float) -> tuple[list[engine.Body], list[engine.Joint]]:
    """A coupler on three equal cranks, one too many, upright and falling: 23 of 30 rows are independent, where flat 22."""
    bodies = [engine.Body(name="coupler", inertia=inertia * np.eye(3), p_WB=(1, 0, 1), v_WB=(1, 0, 0))]
    joints: list[engine.Joint] = []
    for k in range(3):
        crank = f"crank{k}"
        bodies.append(engine.Body(name=crank, inertia=inertia * np.eye(3), p_WB=(k, 0, 0.5), v_WB=(0.5, 0, 0), w_WB=(0, 1, 0)))
        joints += [
            engine.Revolute(name=f"foot{k}", parent=engine.WORLD, child=crank, anchor_W=(k, 0, 0), axis_W=(0, 1, 0)),
            engine.Revolute(name=f"head{k}", parent=crank, child="coupler", anchor_W=(k, 0, 1), axis_W=(0, 1, 0)),
        ]
    return bodies, joints


@lasts(0.7, 2.5)
@pytest.mark.parametrize("inertia", [1e-2, 1e-14])
def test_a_loop_with_a_crank_too_many_turns_through_its_flat_pose_with_its_energy(inertia: float, seconds: float) -> None:
    """Runge-Kutta at w dt = 7e-3: (w dt)^4 / 120 = 2e-11 a radian of some 15; singular poses cost digits, not all."""
    bodies, joints = _cranks(inertia)
    world = _world(bodies, joints, "rk4")

    def energy() -> float:
        s = world.state()
        return float(0.5 * (s[:, 7:10] ** 2).sum() + 0.5 * inertia * (s[:, 10:] ** 2).sum() + G * s[:, 2].sum())

    start = energy()
    turned = []
    for _ in range(round(10 * seconds)):
        world.step(100)
        assert _gap(world, bodies, joints) < 1e-9
        assert energy() == pytest.approx(start, rel=1e-5)
        turned.append(world.state()[0, 2] < 0.0)
    assert any(turned)


@TRACKS
@lasts(0.3, 1.5)
@pytest.mark.parametrize("inertia", [pytest.param(1e-10, marks=pytest.mark.slow), 1e-18])
def test_a_four_bar_of_thin_links_stays_closed(inertia: float, integrator: str, seconds: float) -> None:
    """Its three redundant rows are left out and no other; as in the pendulum, round-off is 1e-14 m."""
    corners = np.array([(0, 0, 0), (0.3, 0, 0.4), (1.3, 0, 0.4), (1, 0, 0)])
    bodies = [engine.Body(name=f"link{k}", inertia=inertia * np.eye(3), p_WB=corners[k : k + 2].mean(axis=0)) for k in range(3)]
    names = [engine.WORLD, "link0", "link1", "link2", engine.WORLD]
    joints: list[engine.Joint] = [
        engine.Revolute(name=f"pin{k}", parent=names[k], child=names[k + 1], anchor_W=corners[k], axis_W=(0, 1, 0))
        for k in range(4)
    ]
    world = _world(bodies, joints, integrator)
    for _ in range(round(10 * seconds)):
        world.step(100)
        assert _gap(world, bodies, joints) < 1e-9


def _sarrus(angle: float, inertia: float) -> tuple[list[engine.Body], list[engine.Joint]]:
    """A platform on two knees at right angles to each other, of links [1 m, 1 kg] at `angle` [rad] from the vertical."""
    bodies = [engine.Body(name="platform", mass=2.0, inertia=np.eye(3), p_WB=(0, 0, 2 * math.cos(angle)))]
    joints: list[engine.Joint] = []
    for name, out, axis in (("x", np.array([1.0, 0, 0]), (0, 1, 0)), ("y", np.array([0, 1.0, 0]), (1, 0, 0))):
        foot, knee = 0.3 * out, 0.3 * out + math.sin(angle) * out + np.array([0, 0, math.cos(angle)])
        hip = foot + np.array([0, 0, 2 * math.cos(angle)])
        for part, low, high in (("shin", foot, knee), ("thigh", knee, hip)):
            bodies.append(engine.Body(name=name + part, inertia=inertia * np.eye(3), p_WB=(low + high) / 2))
        chain = [engine.WORLD, name + "shin", name + "thigh", "platform"]
        for parent, child, anchor in zip(chain, chain[1:], (foot, knee, hip), strict=False):
            joints.append(engine.Revolute(name=parent + child, parent=parent, child=child, anchor_W=anchor, axis_W=axis))
    return bodies, joints


@FIRST
@pytest.mark.parametrize("inertia", [1e-2, 1e-14])
def test_a_spatial_loop_with_a_constraint_too_many_moves_in_its_straight_line(inertia: float, integrator: str) -> None:
    """Sarrus's linkage: six hinges take thirty freedoms of thirty, and one is left, the angle of the links from the vertical.

    Round-off of some thousand steps of sums of metres: 1e3 * 1e-16, a hundred times over. Runge-Kutta follows Lagrange's
    equation: rates of up to 10/s give (w dt)^4 / 120 = 1e-10 a radian, ten times over.
    """
    start, m, M = 0.5, 1.0, 2.0
    bodies, joints = _sarrus(start, inertia)
    world = _world(bodies, joints, integrator)
    world.step(350)
    assert _gap(world, bodies, joints) < 1e-11
    assert np.abs(world.state()[0, [0, 1, 4, 5, 6]]).max() < 1e-11

    def slope(_: float, y: np.ndarray) -> list[float]:
        s, c = math.sin(y[0]), math.cos(y[0])
        A = 2 * (m / 4 + inertia) + 2 * (m * (c * c + 9 * s * s) / 4 + inertia) + 4 * M * s * s
        return [y[1], (-4 * (m + M) * s * c * y[1] ** 2 + G * s * (4 * m + 2 * M)) / A]

    end = solve_ivp(slope, (0, 0.35), [start, 0.0], method="DOP853", rtol=1e-13, atol=1e-14).y[0, -1]
    assert start + 0.4 < end < math.pi / 2
    fallen = math.acos(world.state()[0, 2] / 2)
    # Semi-implicit Euler: half a step of its rate, up to 5/s, in time, twice over.
    assert fallen == pytest.approx(end, abs=1e-9 if integrator == "rk4" else 5e-3)


def _walk(what: engine.World | engine.Batch, steps: int) -> None:
    """Step by step."""
    for _ in range(steps):
        what.step()


def _pulled() -> tuple[list[engine.Body], list[engine.Joint]]:
    """An arm of 1 m from the world to a hand that is carried away at .3 m/s."""
    bodies = [
        engine.Body(name="arm", inertia=0.1 * np.eye(3), p_WB=(0.5, 0.0, 0.0)),
        engine.Body(name="carrier", motion="kinematic", p_WB=(1.5, 0.0, 0.0), v_WB=(0.3, 0.0, 0.0)),
    ]
    hip = engine.Ball(name="hip", parent=engine.WORLD, child="arm", anchor_W=(0, 0, 0))
    rope = engine.Distance(name="rod", parent="arm", child="carrier", anchor_W=(1, 0, 0), child_anchor_W=(1, 0, 0.5))
    return bodies, [hip, rope]


@FIRST
def test_a_joint_that_cannot_close_is_diverged_by_name(integrator: str) -> None:
    """The rod of .5 m lets the carrier go by .2 m or so; at .3 m/s no pose closes it after 3 s."""
    bodies, joints = _pulled()
    world = _world(bodies, joints, integrator)
    with pytest.raises(engine.Diverged, match=r"joint '(hip|rod)' stays open by .* after step"):
        _walk(world, 3000)
    batch = engine.Batch.replicate(_world(bodies, joints, integrator), 2)
    with pytest.raises(engine.Diverged, match=r"world 0: joint '(hip|rod)' stays open by"):
        _walk(batch, 3000)


def test_a_gap_beside_contacts_that_nothing_closes_is_diverged_by_name() -> None:
    """The same pull, and a ball that rolls about elsewhere: named once the gap is more than a thousandth of the rod's levers.

    Until it is stretched, at 1.38 s, the arm is in no one's way; then the carrier opens .3 mm in a step of 1e-3 s.
    """
    bodies, joints = _pulled()
    ground = engine.Body(name="ground", motion="static", shapes=(engine.Placed(engine.Plane()),), p_WB=(0, 0, -5))
    ball = engine.Body(
        name="ball", inertia=4e-3 * np.eye(3), p_WB=(5, 0, -4.9), v_WB=(0.3, 0, 0), shapes=(engine.Placed(engine.Sphere(0.1)),)
    )
    world = _world([*bodies, ground, ball], joints, "semi_implicit_euler")
    with pytest.raises(engine.Diverged, match=r"joint '(hip|rod)' stays open by 0\.00\d* m or rad after step 1[34]\d\d"):
        _walk(world, 3000)


FORBIDDEN = [
    (engine.Ball(name="hook", parent=engine.WORLD, child="bob", anchor_W=(0, 0, 0)), (0.0, 0.1, 0.0), (0.0, 0.0, 0.0), "m/s"),
    (
        engine.Revolute(name="hook", parent=engine.WORLD, child="bob", anchor_W=(0, 0, 0), axis_W=(0, 1, 0)),
        (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), "rad/s",
    ),
    (
        engine.Prismatic(name="hook", parent=engine.WORLD, child="bob", anchor_W=(0, 0, 0), axis_W=(1, 0, 0)),
        (0.3, 0.0, 0.1), (0.0, 0.0, 0.0), "m/s",
    ),
    (engine.Fixed(name="hook", parent=engine.WORLD, child="bob"), (0.0, 0.0, 0.0), (0.0, 0.2, 0.0), "rad/s"),
    (
        engine.Distance(name="hook", parent=engine.WORLD, child="bob", anchor_W=(0, 0, 0), child_anchor_W=(0, 0, -1)),
        (0.0, 0.0, 0.1), (0.0, 0.0, 0.0), "m/s",
    ),
]  # fmt: skip


@TREES
@pytest.mark.parametrize(("joint", "v", "w", "unit"), FORBIDDEN, ids=lambda one: type(one).__name__)
def test_velocities_that_a_joint_forbids_are_refused_by_name(
    joint: engine.Joint, v: tuple[float, float, float], w: tuple[float, float, float], unit: str
) -> None:
    """The bodies hang 1 m below the anchor; what is forbidden is .1 m/s or more, a hundred thousand times the tolerance."""
    bob = engine.Body(name="bob", p_WB=(0.0, 0.0, -1.0), v_WB=v, w_WB=w)
    with pytest.raises(engine.NotSupported, match=rf"joint 'hook': the initial velocities of 'world' and 'bob' .* {unit}"):
        engine.World([bob], [joint])


@TREES
def test_velocities_in_single_precision_that_a_joint_allows_pass() -> None:
    """w x r with every number rounded to 24 bits: off by some 1e-7 of the speed, below the bound of 1e-6."""
    arm, w = np.array([0.6, 0.1, -0.8]), np.array([0.3, 1.7, -0.2])
    single = [tuple(map(float, np.float32(one))) for one in (np.cross(w, arm), w)]
    bob = engine.Body(name="bob", p_WB=arm, v_WB=single[0], w_WB=single[1])
    engine.World([bob], [engine.Ball(name="hook", parent=engine.WORLD, child="bob", anchor_W=(0, 0, 0))])


@TREES
def test_the_adapter_refuses_them_as_the_others_do() -> None:
    from plumbline.adapters.reference import ADAPTER

    bob = Body(name="bob", p_WB=(0.0, 0.0, -1.0), v_WB=(0.0, 0.0, 0.5))
    hinge = Revolute(name="hinge", parent="world", child="bob", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0))
    with pytest.raises(Unsupported, match=r"joint 'hinge'.*break it by 0.5 m/s"):
        ADAPTER.build(Scene(bodies=(bob,), joints=(hinge,)), Settings())
