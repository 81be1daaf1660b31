"""What happened in a run: motions made by hand, each with one thing that happens in it, and none that does not."""

import math

import numpy as np
import pytest

from plumbline.harness.findings.agreement.happened import Happened, alike, body_words, happened_words
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.scene import Body, Box, Drive, Plane, Prismatic, Revolute, Scene, Surface
from plumbline.harness.scene.joint import Limits
from plumbline.harness.search.own_limits import OwnLimit
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.events import Event, Swing, Touched, happened, swing
from plumbline.harness.trajectory.parting import NOTHING

TIME = np.arange(181) / 60
R, G = 0.05, 9.81
LAW = Surface(between=("default", "default"), static_friction=0.5, kinetic_friction=0.5)
BALL = Scene(bodies=(Body.ground("default"), Body.ball("ball", R, p_WB=(0, 0, R))), surfaces=(LAW,))
CUBE = Scene(bodies=(Body.ground("default"), Body.box("cube", (R, R, R), p_WB=(0, 0, R))), surfaces=(LAW,))


def moved(scene: Scene, p: Floats, q: Floats | None = None, w: Floats | None = None) -> Trajectory:
    """The last body of a scene on a path (t, 3), all others where they start."""
    run = Trajectory.of(TIME, len(scene.bodies))
    run.p_WB[:] = [body.p_WB for body in scene.bodies]
    run.p_WB[:, -1] = p
    run.v_WB[:, -1] = np.gradient(p, TIME, axis=0)
    if q is not None:
        run.q_WB[:, -1] = q
    if w is not None:
        run.w_WB[:, -1] = w
    return run


def path(x: Floats | float = 0.0, z: Floats | float = R) -> Floats:
    return np.stack(np.broadcast_arrays(x + 0 * TIME, 0 * TIME, z + 0 * TIME), axis=1)


def touched(samples: Floats, first: int = 0, second: int = 1) -> Touched:
    places = np.flatnonzero(samples)
    return Touched(places, np.full(len(places), first), np.full(len(places), second))


ALWAYS = touched(np.ones(len(TIME), bool))


def about_y(angle: Floats) -> Floats:
    return np.stack([np.cos(angle / 2), 0 * angle, np.sin(angle / 2), 0 * angle], axis=1)


def named(events: tuple[Event, ...]) -> list[str]:
    return [event.kind for event in events]


def test_what_stays_is_at_rest_and_nothing_else() -> None:
    for scene in (BALL, CUBE):
        (event,) = happened(scene, moved(scene, path()), ALWAYS)
        assert (event.kind, event.time) == ("at rest", 0.0)
    assert body_words([event]) == "'cube' stays where it is"


def test_bounces_are_counted_with_the_height_of_the_first() -> None:
    """Parabolas of 0.8, 0.4 and 0.2 s between blows, then rest: g T^2 / 8 high, the first 785 mm."""
    z, begin = np.full(len(TIME), R), 0.2
    for span in (0.8, 0.4, 0.2):
        t = TIME - begin
        z = np.where((t >= 0) & (t <= span), R + G * t * (span - t) / 2, z)
        begin += span
    z = np.where(TIME < 0.2, R + G * (0.2**2 - TIME**2) / 2, z)
    events = happened(BALL, moved(BALL, path(z=z)), touched(np.isclose(z, R)))
    assert named(events) == ["bounced", "at rest"]
    assert events[0].count == 3
    assert events[0].value == pytest.approx(G * 0.8**2 / 8, rel=0.02)  # samples meet neither the top nor the blow itself
    assert events[0].time == pytest.approx(0.2, abs=2 / 60)
    assert events[1].time == pytest.approx(1.6, abs=3 / 60)


def test_a_smooth_fall_and_rise_is_no_bounce() -> None:
    """A swing up and down within g: turned round by no blow."""
    z = 1.0 + 0.2 * np.cos(5.0 * TIME)
    assert "bounced" not in named(happened(BALL, moved(BALL, path(z=z)), None))


def test_a_ball_that_turns_as_it_goes_rolls_and_a_cube_slides() -> None:
    x = 0.3 * TIME
    spin = np.stack([0 * TIME, np.full(len(TIME), 0.3 / R), 0 * TIME], axis=1)
    (rolled,) = happened(BALL, moved(BALL, path(x), about_y(x / R), spin), ALWAYS)
    assert (rolled.kind, rolled.value) == ("rolled", pytest.approx(0.9))
    (slid,) = happened(CUBE, moved(CUBE, path(x)), ALWAYS)
    assert (slid.kind, slid.value) == ("slid", pytest.approx(0.9))
    (ball,) = happened(BALL, moved(BALL, path(x)), ALWAYS)
    assert ball.kind == "slid"


def test_what_turns_only_while_it_touches_nothing_has_slid() -> None:
    x = 0.3 * TIME
    late = TIME > 2.0
    spin = np.stack([0 * x, np.where(late, 0.3 / R, 0.0) * 4, 0 * x], axis=1)
    (slid,) = happened(BALL, moved(BALL, path(x), w=spin), touched(~late))
    assert (slid.kind, slid.value) == ("slid", pytest.approx(0.9))
    (rolled,) = happened(BALL, moved(BALL, path(x), w=spin), ALWAYS)
    assert rolled.kind == "rolled"


def test_what_flies_neither_rolls_nor_slides() -> None:
    off = Touched(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.int64))
    assert happened(CUBE, moved(CUBE, path(2.0 * TIME, 1.0 + 20 * TIME)), off) == ()


def test_a_cube_on_its_side_has_tipped_when_it_leant_by_half_a_right_angle() -> None:
    angle = np.clip(TIME - 1.0, 0.0, math.pi / 2)
    events = happened(CUBE, moved(CUBE, path(), about_y(angle)), ALWAYS)
    assert named(events) == ["tipped", "at rest"]
    assert events[0].time == pytest.approx(1.0 + math.pi / 4, abs=1.1 / 60)
    assert events[0].value == pytest.approx(math.pi / 2)


def test_what_ends_below_a_plane_or_behind_a_wall_has_passed_through() -> None:
    events = happened(BALL, moved(BALL, path(z=0.5 - 0.5 * TIME)), None)
    assert named(events) == ["passed through"]
    assert events[0].time == pytest.approx(1.1, abs=1 / 60)  # its centre lies a radius below z = 0
    wall = Body.fixed("wall", Box(half_extents=(0.01, 1.0, 1.0)), p_WB=(1.0, 0.0, 0.0))
    scene = Scene(bodies=(wall, Body.ball("ball", R)), surfaces=(LAW,), gravity=(0.0, 0.0, -1e-9))
    (event,) = happened(scene, moved(scene, path(TIME, 0.0)), None)
    assert (event.kind, event.other) == ("passed through", "wall")
    beside = moved(scene, path(TIME, 1.5))
    assert happened(scene, beside, None) == ()
    back = moved(scene, path(0.9 - np.abs(TIME - 0.9), 0.0))
    assert "passed through" not in named(happened(scene, back, None))


def test_what_rises_from_the_ground_leaves_it_and_what_sinks_from_a_table_falls_off() -> None:
    z = R + 0.15 * np.clip(TIME - 1.0, 0.0, 1.0)
    (left, rest) = happened(CUBE, moved(CUBE, path(z=z)), touched(TIME <= 1.0))
    assert (left.kind, left.value, rest.kind) == ("left the ground", pytest.approx(0.15), "at rest")
    assert left.time == pytest.approx(1.0, abs=3 / 60)
    table = Body.fixed("table", Box(half_extents=(0.2, 0.2, 0.5)), p_WB=(0.0, 0.0, 0.5))
    scene = Scene(bodies=(table, Body.box("cube", (R, R, R), p_WB=(0.15, 0, 1 + R))), surfaces=(LAW,))
    fall = np.clip(1.05 - G * np.clip(TIME - 1, 0, None) ** 2 / 2, R, None)
    events = happened(scene, moved(scene, path(0.15 + 0.1 * TIME, fall)), touched(TIME <= 1.0))
    (off,) = [event for event in events if event.kind == "fell off"]
    assert (off.other, off.time, off.value) == ("table", pytest.approx(1.0), pytest.approx(1.0))
    # What slides down a ramp to the end, far below its start, has fallen off nothing.
    down = moved(scene, path(0.15 + 0.5 * TIME, 1.05 - 0.3 * TIME))
    assert "fell off" not in named(happened(scene, down, touched(TIME[-1] >= TIME)))


def test_a_joint_hits_its_stop_where_it_had_been_away_from_it() -> None:
    def door(position: float) -> Scene:
        hinge = Revolute(
            name="hinge", parent="world", child="door", anchor_W=(0, 0, 0), axis_W=(0, 1, 0), position=position,
            limits=Limits(lower=-0.1, upper=1.4), drive=Drive(damping=1.0),
        )  # fmt: skip
        return Scene(bodies=(Body.box("door", (0.4, 0.02, 1.0), touches=False),), joints=(hinge,))

    angle = np.clip(TIME, 0.0, 1.4)
    run = moved(door(0.0), path(z=0.0), about_y(angle))
    (turned, hit, rest) = happened(door(0.0), run, None)
    assert (turned.kind, turned.value) == ("turned", pytest.approx(1.4))
    assert (hit.kind, hit.other, hit.body) == ("hit the stop", "hinge", "door")
    assert hit.time == pytest.approx(1.4, abs=2 / 60)
    assert rest.kind == "at rest"
    resting = moved(door(1.4), path(z=0.0))
    assert named(happened(door(1.4), resting, None)) == ["at rest"]


def test_a_machine_is_told_by_its_heaviest_body() -> None:
    wheel = Revolute(name="axle", parent="car", child="wheel", anchor_W=(0, 0, R), axis_W=(0, 1, 0))
    bodies = (Body.ground("default"), Body.ball("wheel", R, 0.1, p_WB=(0, 0, R)), Body.box("car", (R, R, R), p_WB=(0, 0, R)))
    scene = Scene(bodies=bodies, joints=(wheel,), surfaces=(LAW,))
    run = moved(scene, path(TIME))
    run.p_WB[:, 1] += path(TIME, 0.0)
    (event,) = happened(scene, run, touched(np.ones(len(TIME), bool), 0, 1))
    assert (event.body, event.kind, event.value) == ("car", "moved", pytest.approx(3.0))


def test_events_are_alike_within_a_tenth() -> None:
    bounce = Event(body="ball", kind="bounced", time=0.3, value=0.24, count=9)
    assert alike([bounce], [Event(body="ball", kind="bounced", time=0.31, value=0.25, count=8)], 3.0, BALL)
    assert not alike([bounce], [Event(body="ball", kind="bounced", time=0.3, value=0.20, count=9)], 3.0, BALL)
    assert not alike([bounce], [Event(body="ball", kind="bounced", time=0.3, value=0.24, count=7)], 3.0, BALL)
    assert not alike([bounce], [Event(body="ball", kind="bounced", time=0.7, value=0.24, count=9)], 3.0, BALL)
    assert not alike([bounce], [], 3.0, BALL)


def test_what_happens_on_most_engines_is_told_first_and_then_what_others_do_or_do_not() -> None:
    nothing = OwnLimit(kind="converges", horizons={}, rungs=())
    sides = [
        Side(engine=engine, track=track, ours=False, word="converges", why="", limit=nothing)
        for engine in ("a", "b")
        for track in ("default", "tuned")
    ]
    agreement = Agreement(case="c", where="", duration=3.0, scale=NOTHING, granted=0.0, sides=tuple(sides), differences=())
    bounce = Event(body="ball", kind="bounced", time=0.32, value=0.24, count=7)
    rest, sooner = (Event(body="ball", kind="at rest", time=time) for time in (1.7, 0.3))
    most = Happened(sides=(("a", "default"), ("a", "tuned"), ("b", "tuned")), events=(bounce, rest))
    few = Happened(sides=(("b", "default"),), events=(sooner,))
    first, second = happened_words([most, few], agreement, {"a": "Engine A", "b": "Engine B"})
    who, what = first.split(": ", 1)
    assert who == "What happens on Engine A and Engine B (tuned)"
    assert what == "'ball' bounces 7 times, first by 240 mm at 0.32 s, is at rest from 1.7 s on."
    assert second == "Otherwise on Engine B (default): 'ball' is at rest from 0.3 s on; 'ball' does not bounce."
    (alone,) = happened_words([most], agreement, {})
    assert alone.startswith("What happens: 'ball' bounces")


def test_contacts_that_do_not_press_do_not_touch() -> None:
    arrays = {
        "contacts_count": np.array([1, 2, 0]), "contacts_gap": np.array([1e-3, -1e-6, 1e-3]),
        "contacts_force_W": np.array([[0, 0, 0], [0, 0, 0], [0, 0, 2.0]]), "contacts_body_A": np.array([0, 0, 0]),
        "contacts_body_B": np.array([1, 1, 2]),
    }  # fmt: skip
    found = Touched.of(arrays)
    assert found is not None
    assert found.sample.tolist() == [1, 1]
    assert Touched.of({}) is None
    assert Plane().normal == (0.0, 0.0, 1.0)


def struck_at(blow: float, before: Floats, after: Floats) -> Floats:
    """Velocities (t, 3) of what a blow [s] turns from one velocity to another between two samples."""
    return np.where((blow > TIME)[:, None], before, after)


def flown(scene: Scene, **velocities: Floats) -> Trajectory:
    """Bodies at constant velocities between blows, in no gravity, from where the scene has them."""
    run = Trajectory.of(TIME, len(scene.bodies))
    run.p_WB[:] = [body.p_WB for body in scene.bodies]
    for name, v in velocities.items():
        index = scene.index(name)
        run.v_WB[:, index] = v
        run.p_WB[:, index] += np.vstack([np.zeros(3), np.cumsum(v[:-1] / 60, axis=0)])
    return run


WALL = Body.fixed("wall", Box(half_extents=(0.01, 1.0, 1.0)), p_WB=(1.06, 0.0, 0.0))
FLOATING = (0.0, 0.0, 0.0)


def test_a_blow_between_two_samples_is_told_by_the_jump_that_it_leaves_with_the_wall_that_is_nearest() -> None:
    """2 m/s to the wall and 1.5 m/s back: no sample has a contact, and the ball comes back where no word told of it before."""
    far = Body.fixed("far", Box(half_extents=(0.01, 1.0, 1.0)), p_WB=(3.0, 0.0, 0.0))
    scene = Scene(bodies=(far, WALL, Body.ball("ball", R)), surfaces=(LAW,), gravity=FLOATING)
    run = flown(scene, ball=struck_at(0.509, np.array([2.0, 0, 0]), np.array([-1.5, 0, 0])))
    never = Touched(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.int64))
    for contacts in (None, never):
        (event,) = happened(scene, run, contacts)
        assert (event.body, event.kind, event.other, event.count) == ("ball", "collided", "wall", 1)
        assert event.time == pytest.approx(0.509, abs=1 / 60)
    assert body_words([event]) == f"'ball' collides with 'wall' at {event.time:.3g} s"


def test_of_two_balls_that_hit_each_other_one_blow_is_told() -> None:
    """A cradle: the velocity goes over from the first to the second, 2 kg m/s each, and the third is far away."""
    bodies = (
        Body.ball("first", R, 1.0),
        Body.ball("second", R, 1.0, p_WB=(1, 0, 0)),
        Body.ball("third", R, 1.0, p_WB=(0, 9, 0)),
    )
    scene = Scene(bodies=bodies, surfaces=(LAW,), gravity=FLOATING)
    going, still = np.array([2.0, 0, 0]), np.zeros(3)
    run = flown(scene, first=struck_at(0.45, going, still), second=struck_at(0.45, still, going))
    (hit, rest) = (event for event in happened(scene, run, None) if event.kind == "collided" or event.body == "third")
    assert (hit.body, hit.kind, hit.other) == ("first", "collided", "second")
    assert (rest.body, rest.kind) == ("third", "at rest")


def test_friction_that_begins_a_push_that_lasts_and_a_landing_are_no_collision() -> None:
    slowing = 2.0 - 5 * G * np.clip(TIME - 0.5, 0.0, 2.0 / (5 * G))  # of a coefficient of 5, from one sample to the next
    x = np.concatenate([[0.0], np.cumsum(slowing[:-1] / 60)])
    assert "collided" not in named(happened(CUBE, moved(CUBE, path(x)), ALWAYS))
    z = np.maximum(R, 1.0 - G * TIME**2 / 2)
    assert "collided" not in named(happened(CUBE, moved(CUBE, path(z=z)), touched(z <= R)))


def test_a_ball_that_flies_against_a_ceiling_collides_with_it() -> None:
    roof = Body.fixed("roof", Box(half_extents=(1.0, 1.0, 0.01)), p_WB=(0.0, 0.0, 1.06))
    scene = Scene(bodies=(roof, Body.ball("ball", R)), surfaces=(LAW,))
    run = flown(scene, ball=struck_at(0.3, np.array([0, 0, 5.0]), np.array([0, 0, -3.0])))
    run.v_WB[:, 1, 2] -= G * TIME
    run.p_WB[:, 1, 2] -= G * TIME**2 / 2
    (event,) = [event for event in happened(scene, run, None) if event.kind == "collided"]
    assert (event.body, event.other) == ("ball", "roof")


def hinged(angle: Floats, held: bool = True) -> tuple[Event, ...]:
    hinge = Revolute(name="hinge", parent="world" if held else "base", child="bob", anchor_W=(0, 0, 0), axis_W=(0, 1, 0))
    base = () if held else (Body.box("base", (R, R, R), mass=9.0, touches=False),)
    scene = Scene(bodies=(*base, Body.box("bob", (R, R, R), touches=False)), joints=(hinge,))
    return happened(scene, moved(scene, path(z=0.0), about_y(angle)), None)


def test_a_pendulum_swings_to_and_fro_until_it_only_settles() -> None:
    """From 1 rad with a period of 0.8 s and a decay of 1 /s: every half period it turns back, the first time after 0.4 s."""
    events = hinged(np.exp(-TIME) * np.cos(2 * np.pi * TIME / 0.8) - 1.0)
    (swung,) = [event for event in events if event.kind == "swung"]
    assert (swung.body, swung.other) == ("bob", "hinge")
    assert swung.value == pytest.approx(1 + math.exp(-0.4), rel=0.02)
    # A half swing is (1 + e^-.4) e^(-.4 k); more than a tenth of the first for k up to 5, and 7 halves fit into 3 s.
    assert swung.count == 5
    degrees = math.degrees(swung.value)
    assert body_words([swung]) == f"'bob' swings to and fro by {degrees:.3g} degrees about 'hinge', turning back 5 times"


def test_a_joint_that_goes_one_way_turns_where_its_machine_is_held() -> None:
    overshoot = 1.5 * (1 - np.exp(-5 * TIME) * np.cos(4 * TIME))  # past its target by 2 %, which only settles
    assert named(hinged(overshoot)) == ["turned", "at rest"]
    assert hinged(overshoot)[0].value == pytest.approx(1.5, abs=1e-4)  # to where it stops, and not to where it overshot
    assert hinged(np.minimum(TIME, 2.0 - TIME))[0].value == pytest.approx(2.0, abs=0.02)  # out by 1 rad and back to -1
    back = hinged(np.where(TIME < 1.5, TIME, 3.0 - TIME))[0]
    assert (back.kind, back.value) == ("turned", pytest.approx(1.5, abs=0.02))  # out and home again
    assert named(hinged(40.0 * TIME)) == ["turned"]
    assert body_words(hinged(40.0 * TIME)) == "'bob' turns by 19.1 turns about 'hinge'"
    assert named(hinged(overshoot, held=False)) == ["at rest"]
    assert named(hinged(0.004 * np.sin(9 * TIME))) == ["at rest"]


def test_a_slider_goes_to_and_fro_along_its_axis() -> None:
    slider = Prismatic(name="rail", parent="world", child="cart", anchor_W=(0, 0, 0), axis_W=(1, 0, 0))
    scene = Scene(bodies=(Body.box("cart", (R, R, R), touches=False),), joints=(slider,))
    (event,) = happened(scene, moved(scene, path(0.2 * np.sin(4 * TIME), 0.0)), None)
    assert (event.kind, event.other, event.value) == ("shuttled", "rail", pytest.approx(0.4, rel=0.01))
    assert body_words([event]).startswith("'cart' goes to and fro by 4")


def test_of_many_bodies_the_first_few_are_told_and_the_rest_are_counted() -> None:
    events = [Event(body=f"b{k}", kind="slid", time=0.1, value=0.1 + k / 100) for k in range(9)]
    said = body_words(events)
    assert said.count("slides by") == 6
    assert said.endswith("; and 3 more like these")


def test_what_gives_way_under_a_body_lets_it_sink_and_what_stays_is_another_answer() -> None:
    """3 mm into the floor within .1 s, of a size of 2 sqrt(3) 50 mm: more than a hundredth, and soon at rest."""
    sinking = happened(CUBE, moved(CUBE, path(z=R - 0.03 * np.clip(TIME, 0.0, 0.1))), ALWAYS)
    staying = happened(CUBE, moved(CUBE, path()), ALWAYS)
    assert named(sinking) == ["sank", "at rest"]
    assert body_words(sinking).startswith("'cube' sinks by 3 mm, is at rest from ")
    assert not alike(sinking, staying, 3.0, CUBE)
    moves_first, stays = (Event(body="cube", kind="at rest", time=time) for time in (0.05, 0.0))
    assert not alike([moves_first], [stays], 3.0, CUBE)
    settling = happened(CUBE, moved(CUBE, path(z=R - 0.01 * np.clip(TIME, 0.0, 0.1))), ALWAYS)
    assert named(settling) == ["at rest"]


def test_a_ball_that_touches_now_and_again_rolls_and_never_tips_over() -> None:
    """Its contact is recorded at every third sample, as of a ball that hops by micrometres; half a turn leans it by pi."""
    x = np.clip(0.3 * TIME, 0.0, 0.5 * math.pi * R * 2)
    spin = np.stack([0 * TIME, np.where(x[-1] / 0.3 > TIME, 0.3 / R, 0.0), 0 * TIME], axis=1)
    flicker = touched(np.arange(len(TIME)) % 3 == 0)
    events = happened(BALL, moved(BALL, path(x), about_y(x / R), spin), flicker)
    assert named(events) == ["rolled", "at rest"]
    flying = happened(BALL, moved(BALL, path(x, R + 0.5), about_y(x / R), spin), touched(TIME == 0.0))
    assert "tipped" not in named(flying)


def test_the_partner_of_a_blow_is_what_is_thrown_back_and_not_the_floor_that_is_touched_again() -> None:
    """A ball that rolls over a floor, which it touches now and again, against another: the floor is in no collision."""
    floor = Body.ground("default")
    balls = (Body.ball("cue", R, 1.0, p_WB=(0, 0, R)), Body.ball("red", R, 1.0, p_WB=(1, 0, R)))
    scene = Scene(bodies=(floor, *balls), surfaces=(LAW,))
    going, still = np.array([2.0, 0, 0]), np.zeros(3)
    run = flown(scene, cue=struck_at(0.45, going, still), red=struck_at(0.45, still, going))
    places = np.array([12, 27, 28, 60])  # of the floor under the cue ball: not at the samples just before the blow
    contacts = Touched(places, np.zeros(4, np.int64), np.ones(4, np.int64))
    (hit,) = [event for event in happened(scene, run, contacts) if event.kind == "collided"]
    assert (hit.body, hit.other) == ("cue", "red")
    # A ball that bounces has left the floor as often as it does so: that is told once.
    z = np.maximum(R, R + np.abs(np.sin(4 * TIME)) * 0.3)
    assert "left the ground" not in named(happened(BALL, moved(BALL, path(z=z)), touched(z <= R + 0.02)))


def test_what_falls_back_from_its_edge_rocks_over_and_does_not_slide() -> None:
    """40 degrees about an edge take the centre of a cube R (sin 85 - sin 45) 2^.5 to the side: less than the turn times the
    radius of the ball that holds it, 3^.5 R. The same turn with a metre of way is a slide."""
    angle = math.radians(40) * np.clip(TIME / 0.3, 0.0, 1.0)
    x = math.sqrt(2) * R * (np.sin(angle + math.pi / 4) - math.sin(math.pi / 4))
    (rocked, rest) = happened(CUBE, moved(CUBE, path(x), about_y(angle)), ALWAYS)
    assert (rocked.kind, rest.kind) == ("rocked", "at rest")
    assert body_words([rocked]) == "'cube' rocks over by 40 degrees"
    assert "slid" in named(happened(CUBE, moved(CUBE, path(np.minimum(TIME, 1.0)), about_y(angle)), ALWAYS))


def test_a_swing_about_its_start_that_goes_less_than_the_least_either_way_begins_where_its_range_is_more() -> None:
    """A robot of the zoo ended its report: from its start it went .8 of the least one way and .8 the other."""
    assert swing(np.array([0.0, 0.8, 0.0, -0.8, 0.0]), 1.0) == Swing(0, 1.6, 1.6, 3)
    assert swing(np.array([0.0, 0.5, 1.5]), 1.0) == Swing(0, 1.5, 1.5, 2)
    assert swing(np.array([0.0, 0.5, 1.0]), 1.0) is None
