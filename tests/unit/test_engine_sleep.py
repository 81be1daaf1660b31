"""Sleep: what stands still stays as it is to the last bit, keeps its forces, and wakes when something reaches it."""

import numpy as np
import pytest

from plumbline import engine

G = 9.81
ROUGH = {("default", "default"): engine.Surface(static_friction=0.5, kinetic_friction=0.5)}
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
SEARCH = {"broad_phase": "brute_force"}
"""The broad phase of `_world`: so few shapes are searched inside the step by brute force, and before it by any other."""


@pytest.fixture(autouse=True, params=["brute_force", "uniform_grid"])
def _search(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every test with pairs found inside the step, where who sleeps is known, and before it, where they must be found anew."""
    monkeypatch.setitem(SEARCH, "broad_phase", request.param)


def _box(name: str, half: tuple[float, float, float] = (0.1, 0.1, 0.1), **state: object) -> engine.Body:
    a, b, c = (4 * h * h for h in half)
    inertia = np.diag([b + c, a + c, a + b]) / 12
    return engine.Body(name=name, inertia=inertia, shapes=[engine.Placed(engine.Box(half))], **state)  # type: ignore[arg-type]


def _world(bodies: list[engine.Body], **options: object) -> engine.World:
    chosen = {"sleeping": True, "sleep_time": 0.25, **SEARCH, **options}
    return engine.World([GROUND, *bodies], surfaces=ROUGH, options=engine.Options(**chosen))  # type: ignore[arg-type]


def _stack() -> list[engine.Body]:
    return [_box(f"box{k}", p_WB=(0, 0, 0.1 + 0.2 * k)) for k in range(3)]


def _asleep(bodies: list[engine.Body], **options: object) -> engine.World:
    """A world two seconds after its start, with all bodies but the ground and kinematic ones asleep."""
    world = _world(bodies, **options)
    world.step(480)
    movable = [body.motion == "dynamic" for body in (GROUND, *bodies)]
    assert np.array_equal(world.asleep(), movable)
    return world


def test_a_sleeping_stack_does_not_move_by_one_bit_and_gravity_never_wakes_it() -> None:
    """A hundred seconds in one call, and a few steps one by one."""
    world = _asleep(_stack())
    before = world.state().copy()
    world.step(24_000)
    for _ in range(5):
        world.step()
    assert np.array_equal(world.state(), before)
    assert not world.state()[:, 7:].any()
    assert world.asleep()[1:].all()
    assert world.steps == 480 + 24_000 + 5


def test_the_contacts_of_a_sleeping_stack_still_carry_it() -> None:
    """The forces are those of the last step awake: three boxes on the ground, two on the first, one on the second.

    They differ from the weight by what accelerates bodies slower than 1 mm/s; the contact damps within milliseconds, so that
    after a quarter of a second that is far below 1e-3 of the weight.
    """
    world = _asleep(_stack())
    world.step(100)
    found = world.contacts()
    for low, carried in ((0, 3), (1, 2), (2, 1)):
        pair = (np.sort(found.bodies, axis=1) == (low, low + 1)).all(axis=1)
        assert pair.sum() == 4
        assert np.abs(found.force[pair, 2]).sum() == pytest.approx(carried * G, rel=1e-3)


def test_without_the_option_nothing_sleeps() -> None:
    world = _world(_stack(), sleeping=False)
    world.step(480)
    assert not world.asleep().any()


def test_a_body_that_moves_does_not_sleep() -> None:
    """The slide lasts 1.5 / (mu g) = .3 s; the ball rolls on for ever."""
    ball = engine.Body(
        name="ball", inertia=0.004 * np.eye(3), shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(0, 2, 0.1), v_WB=(1.0, 0, 0)
    )
    world = _world([_box("box", p_WB=(0, 0, 0.1), v_WB=(1.5, 0, 0)), ball])
    world.step(60)
    assert not world.asleep().any()
    world.step(420)
    assert world.asleep().tolist() == [False, True, False]
    assert world.state()[1, 0] == pytest.approx(1.5**2 / (2 * 0.5 * G), rel=5e-3)


def test_a_ball_wakes_the_stack_that_it_hits_and_hits_it_as_if_it_had_never_slept() -> None:
    """The stack slept as it stood, with its impulses: the blow is the same but for the speeds below 1 mm/s that sleep stopped.

    A blow away from the edges of friction maps velocities linearly and lengthens none in the norm of energy: they agree to
    1 mm/s, at a lever of .1 m to .01 rad/s; places to 1 mm/s over the second of sleep.
    """
    ball = engine.Body(
        name="ball", inertia=0.004 * np.eye(3), shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(0.03, 0.02, 9.0)
    )
    states = []
    for sleeping in (True, False):
        world = _world([*_stack(), ball], sleeping=sleeping)
        world.step(300)
        assert world.asleep()[1:4].all() == sleeping
        assert not world.asleep()[4]
        world.step(15)
        states.append(world.state().copy())
        assert not world.asleep().any()
    assert np.abs(states[0][4, 9]) < 10.0
    assert np.abs(states[1][1:4, 7:10]).max() > 0.1
    assert states[0][:, :7] == pytest.approx(states[1][:, :7], abs=1e-3)
    assert states[0][:, 7:10] == pytest.approx(states[1][:, 7:10], abs=1e-3)
    assert states[0][:, 10:] == pytest.approx(states[1][:, 10:], abs=1e-2)


def test_a_row_of_sleeping_dominoes_wakes_one_by_one_and_falls() -> None:
    """Each stands alone, an island of its own; a push on the first has to reach the last."""
    row = [_box(f"d{k}", (0.02, 0.1, 0.2), p_WB=(0.2 * k, 0, 0.2)) for k in range(6)]
    world = _asleep(row)
    push, none = np.zeros((7, 3)), np.zeros((7, 3))
    push[1, 0] = 4.0
    tilt = none.copy()
    tilt[1, 1] = 0.8
    world.set_load(push, tilt)
    world.step(24)
    assert world.asleep()[4:].all()
    world.set_load(none, none)
    woken = []
    for _ in range(480):
        world.step()
        woken += [b for b in range(1, 7) if not world.asleep()[b] and b not in woken]
    assert woken == [1, 2, 3, 4, 5, 6]
    assert (world.state()[1:, 2] < 0.15).all()


def test_a_kinematic_plate_lifts_the_boxes_that_sleep_on_it() -> None:
    """At rest the plate lets them sleep; set moving at .5 m/s it carries them at .5 m/s, and they sleep again when it stops."""
    plate = _box("plate", (0.5, 0.5, 0.05), p_WB=(0, 0, 1.0), motion="kinematic")
    boxes = [_box(f"box{k}", p_WB=(0.3 * k - 0.15, 0, 1.15)) for k in range(2)]
    world = _asleep([plate, *boxes])
    before = world.state().copy()
    world.state()[1, 9] = 0.5
    world.step(240)
    assert not world.asleep().any()
    assert world.state()[2:, 2] - before[2:, 2] == pytest.approx([0.5, 0.5], abs=1e-3)
    assert world.state()[2:, 9] == pytest.approx([0.5, 0.5], abs=1e-4)
    world.state()[1, 9] = 0.0
    world.step(240)
    assert world.asleep().tolist() == [False, False, True, True]


def test_a_kinematic_body_that_arrives_pushes_the_sleeping_box_away() -> None:
    """Seen from .7 m away it comes at .5 m/s; from then on the box is no slower than the pusher."""
    pusher = _box("pusher", (0.05, 0.05, 0.05), p_WB=(-0.85, 0, 0.1), motion="kinematic")
    world = _asleep([pusher, _box("box", p_WB=(0, 0, 0.1))])
    world.state()[1, 7] = 0.5
    world.step(480)
    assert not world.asleep().any()
    assert world.state()[2, 0] - world.state()[1, 0] == pytest.approx(0.15, abs=1e-3)


def test_a_sleeping_box_falls_when_its_support_is_taken_away() -> None:
    """The plate is gone from one step to the next: g t^2 / 2 from then on, to the first order of semi-implicit Euler."""
    plate = _box("plate", (0.5, 0.5, 0.05), p_WB=(0, 0, 3.0), motion="kinematic")
    world = _asleep([plate, _box("box", p_WB=(0, 0, 3.15))])
    height = world.state()[2, 2]
    world.state()[1, 0] = 50.0
    world.step(120)
    assert world.state()[2, 2] == pytest.approx(height - 0.5 * G * 0.5**2 - 0.5 * G * 0.5 / 960, abs=1e-6)


def test_a_change_of_load_wakes_and_the_same_load_does_not() -> None:
    """3 N against mu m g = 4.9 N holds and lets sleep; 6 N slides at (6 - 4.9) m/s2."""
    world = _asleep([_box("box", p_WB=(0, 0, 0.1)), _box("other", p_WB=(1, 5, 0.1))])
    force, none = np.zeros((3, 3)), np.zeros((3, 3))
    force[1, 0] = 3.0
    world.set_load(force, none)
    world.step(1)
    assert world.asleep().tolist() == [False, False, True]
    world.step(479)
    assert world.asleep().tolist() == [False, True, True]
    world.set_load(force, none)
    world.step(1)
    assert world.asleep()[1]
    force[1, 0] = 6.0
    world.set_load(force, none)
    world.step(240)
    assert world.asleep().tolist() == [False, False, True]
    assert world.state()[1, 7] == pytest.approx(6.0 - 0.5 * G, rel=0.01)


def test_a_torque_alone_wakes() -> None:
    """1 N m about z against mu m g r: friction of four corners .1 sqrt(2) m out holds .69 N m at most, so the box turns."""
    world = _asleep([_box("box", p_WB=(0, 0, 0.1)), _box("other", p_WB=(1, 5, 0.1))])
    torque, none = np.zeros((3, 3)), np.zeros((3, 3))
    torque[1, 2] = 1.0
    world.set_load(none, torque)
    world.step(24)
    assert world.asleep().tolist() == [False, False, True]
    # (1 - .5 g .1 sqrt(2)) / (m (.2^2 + .2^2) / 12) = 46 rad/s2 over a tenth of a second.
    assert world.state()[1, 12] == pytest.approx((1 - 0.5 * G * 0.1 * 2**0.5) / (0.08 / 12) * 0.1, rel=0.05)


def test_a_sleeping_body_moved_by_hand_wakes() -> None:
    world = _asleep([_box("box", p_WB=(0, 0, 0.1))])
    world.state()[1, 2] = 1.0
    world.step(24)
    assert world.state()[1, 9] == pytest.approx(-G * 0.1, rel=1e-9)


def test_the_error_of_sleep_is_the_motion_that_it_stops() -> None:
    """Without gravity a body at .9 mm/s sleeps after .25 s and stays there, one at 1.1 mm/s goes on: the stated bound."""
    slow = engine.Body(name="slow", shapes=[engine.Placed(engine.Sphere(0.1))], v_WB=(9e-4, 0, 0), p_WB=(0, 0, 5))
    fast = engine.Body(name="fast", shapes=[engine.Placed(engine.Sphere(0.1))], v_WB=(1.1e-3, 0, 0), p_WB=(0, 9, 5))
    options = engine.Options(sleeping=True, sleep_time=0.25, sleep_speed=1e-3)
    world = engine.World([GROUND, slow, fast], surfaces=ROUGH, gravity=(0, 0, 0), options=options)
    world.step(240)
    assert world.asleep().tolist() == [False, True, False]
    assert world.state()[1, 0] == pytest.approx(9e-4 * 0.25, rel=0.02)
    assert world.state()[2, 0] == pytest.approx(1.1e-3, rel=1e-9)


def test_a_saved_sleeper_wakes_bit_for_bit_the_same() -> None:
    world = _asleep(_stack())
    saved = world.save()
    ends = []
    for _ in range(2):
        world.restore(saved)
        world.state()[3, 7] = 1.0
        world.step(100)
        ends.append(world.state().copy())
    assert np.array_equal(ends[0], ends[1])
    assert not np.array_equal(ends[0], saved[0][: ends[0].size].reshape(ends[0].shape))


def test_islands_sleep_and_wake_alike_on_two_threads() -> None:
    """The bits of the whole history, with a push in between."""
    ends = []
    for threads in (1, 2):
        world = _world([_box(f"b{k}", p_WB=(0.5 * k, 0, 0.1 + 0.01 * k)) for k in range(5)], threads=threads)
        world.step(300)
        world.state()[2, 7] = 3.0
        world.step(100)
        ends.append(world.state().copy())
        assert world.asleep().sum() == 3
    assert np.array_equal(ends[0], ends[1])


def test_contacts_of_more_sleepers_than_an_arena_first_has_room_for_are_kept() -> None:
    """Balls in a heap go to sleep and are woken in turns; at every moment the ground carries all of them."""
    balls = [
        engine.Body(
            name=f"b{k}", inertia=0.004 * np.eye(3), shapes=[engine.Placed(engine.Box((0.1, 0.1, 0.1)))],
            p_WB=(0.35 * (k % 4), 0.35 * (k // 4), 0.1),
        )
        for k in range(16)
    ]  # fmt: skip
    world = _asleep(balls)
    for b in (3, 7, 16):
        world.state()[b, 9] = 0.5
        world.step(240)
    assert world.asleep()[1:].all()
    assert np.abs(world.contacts().force[:, 2].sum()) == pytest.approx(16 * G, rel=1e-3)
