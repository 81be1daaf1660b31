"""A metric whose name says that something happened counts that, and no near miss: each has one of either planted here.

A new metric with such a name, or one renamed to a stronger word, fails until a near miss and a hit are planted for it.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from plumbline.harness.metrics.statics import _stacks, frame_friction_error, overhang_limit_error
from plumbline.harness.scene import Body, Box, PlacedShape, Plane, Scene, Sphere, Surface, axis_angle, box_inertia
from plumbline.harness.study import plugins
from plumbline.harness.study.foreseen_cost import scene_at
from plumbline.harness.trajectory import Contacts, Trajectory
from tests.all_metrics import all_metrics

WORDS = re.compile(
    "collapse|tunnel|passage|eject|escape|stand|flip|threshold|penetrat|tipping|overhang|fate|stuck|stick|lift|lost_start|met$"
    "|diverge|frame|fall|break|broke|hold"
)
"""Parts of names that say that something happened. 'hold' and the like are listed so that none gets in unseen."""
MEASURES = ("overhang_limit_error", "held_energy_gain_max")
TIME = np.linspace(0.0, 1.0, 11)


@dataclass(frozen=True)
class Plant:
    """A clean run, one that nearly did what the metric's name says, and one that did. Terms: truth: where it needs one."""

    scene: Scene
    clean: Trajectory
    near: Trajectory
    hit: Trajectory
    truth: Trajectory | None = None


def still(scene: Scene) -> Trajectory:
    run = Trajectory.of(TIME, len(scene.bodies))
    run.p_WB[:] = [body.p_WB for body in scene.bodies]
    run.q_WB[:] = [body.q_WB for body in scene.bodies]
    run.v_WB[:] = [body.v_WB for body in scene.bodies]
    run.w_WB[:] = [body.w_WB for body in scene.bodies]
    return replace(run, dt=0.1)


def ended(run: Trajectory, place: int, way: tuple[float, float, float]) -> Trajectory:
    """The run with a body moved by a way [m] in its second half."""
    moved = replace(run, p_WB=run.p_WB.copy())
    moved.p_WB[6:, place] += way
    return moved


def box(name: str, half: tuple[float, float, float], where: tuple[float, float, float], **more: object) -> Body:
    shape = (PlacedShape(shape=Box(half_extents=half)),)
    return Body(name=name, inertia=box_inertia(1.0, half), collision=shape, p_WB=where, **more)  # type: ignore[arg-type]


GROUND = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
GRIP = (Surface(static_friction=0.5, kinetic_friction=0.5),)


def pile() -> Plant:
    """Two towers of which one may fall; a thin tile between neither. The near miss is the fall of a lower body beside them."""
    half = (0.1, 0.1, 0.1)
    bodies = (GROUND, box("a", half, (0.0, 0.0, 0.9)), box("b", half, (2.0, 0.0, 0.9)), box("low", half, (4.0, 0.0, 0.4)))
    scene = Scene(bodies=bodies, surfaces=GRIP)
    run = still(scene)
    return Plant(scene, run, ended(run, 3, (0.0, 0.0, -0.3)), ended(run, 2, (0.0, 0.0, -0.6)))


def pressed() -> Plant:
    """Thick boxes beside a thin tile: deeper than half the tile, which is not in it, and deeper than half of themselves."""
    thick = (0.1, 0.1, 0.1)
    high = box("high", thick, (2.0, 0.0, 0.9))
    bodies = (GROUND, box("thick", thick, (0.0, 0.0, 0.1)), high, box("tile", (0.1, 0.1, 0.001), (1.0, 0.0, 0.001)))
    scene = Scene(bodies=bodies, surfaces=GRIP)

    return Plant(scene, still(scene), ended(still(scene), 1, (0.0, 0.0, -0.09)), ended(still(scene), 1, (0.0, 0.0, -0.11)))


def sunk() -> Plant:
    """A box that touches, one that the engine says is deep and that touches all the same, and one that is deep."""
    scene = Scene(bodies=(GROUND, box("box", (0.1, 0.1, 0.1), (0.0, 0.0, 0.1))), surfaces=GRIP)
    deep = Contacts.of([0], [1], [[0.0] * 3], [[0.0, 0.0, 1.0]], [-0.05], [[0.0, 0.0, 9.8]])
    run = still(scene)
    return Plant(scene, run, replace(run, contacts=(deep,) * len(TIME)), ended(run, 1, (0.0, 0.0, -0.001)))


def listed(gap: float, force: float) -> Trajectory:
    scene = shot().scene
    one = Contacts.of([0], [1], [[0.0] * 3], [[0.0, 0.0, 1.0]], [gap], [[0.0, 0.0, force]])
    none = Contacts.of([0], [1], [[0.0] * 3], [[0.0, 0.0, 1.0]], [0.001], [[0.0] * 3])
    return replace(still(scene), contacts=tuple(one if k % 2 else none for k in range(len(TIME))))


def contacts(near: tuple[float, float], hit: tuple[float, float], clean: tuple[float, float] = (0.002, 0.0)) -> Plant:
    """Points that come and go: listed at a gap without a force, and touching with one."""
    return Plant(shot().scene, listed(*clean), listed(*near), listed(*hit))


def flipped() -> Plant:
    """A point that carries force in each sample, then one that is only listed in some, then one that carries it in some."""
    scene = shot().scene
    up, at = [0.0, 0.0, 1.0], [0.0] * 3
    bears = Contacts.of([0], [1], [at], [up], [0.0], [[0.0, 0.0, 9.8]])
    lists = Contacts.of([0, 0], [1, 1], [at, at], [up, up], [0.0, 0.001], [[0.0, 0.0, 9.8], at])
    twice = Contacts.of([0, 0], [1, 1], [at, at], [up, up], [0.0, 0.0], [[0.0, 0.0, 4.9]] * 2)

    def run(other: Contacts) -> Trajectory:
        return replace(still(scene), contacts=tuple(other if k % 2 else bears for k in range(len(TIME))))

    return Plant(scene, run(bears), run(lists), run(twice))


def shot() -> Plant:
    """A ball of 0.1 m shot at a wall of 4 cm whose face is x = 0: at rest at it, left 0.119 m deep in it, and through it."""
    wall = box("wall", (0.02, 5.0, 5.0), (0.02, 0.0, 0.0), motion="static")
    ball = Body(name="ball", collision=(PlacedShape(shape=Sphere(radius=0.1)),), p_WB=(-1.0, 0.0, 0.0), v_WB=(5.0, 0.0, 0.0))
    scene = Scene(bodies=(wall, ball), surfaces=GRIP, gravity=(0.0, 0.0, 0.0))
    truth = ended(still(scene), 1, (0.9, 0.0, 0.0))
    truth.v_WB[6:, 1] = 0.0
    return Plant(scene, truth, ended(truth, 1, (0.119, 0.0, 0.0)), ended(truth, 1, (0.121, 0.0, 0.0)), truth)


def thrown() -> Plant:
    """Two boxes that part aside and downwards are not ejected; one that is thrown up is."""
    scene = Scene(bodies=(GROUND, box("a", (0.1, 0.1, 0.1), (0.0, 0.0, 0.5))), surfaces=GRIP)
    run = still(scene)
    return Plant(scene, run, ended(run, 1, (0.4, 0.0, -0.2)), ended(run, 1, (0.0, 0.0, 0.01)), run)


def contained() -> Plant:
    """A ball whose centre is in a wall has not escaped; one beyond its outer face has."""
    sides = [(axis, side) for axis in range(3) for side in (-1.0, 1.0)]

    def wall(axis: int, side: float) -> PlacedShape:
        half, where = [1.1, 1.1, 1.1], [0.0, 0.0, 0.0]
        half[axis], where[axis] = 0.05, side * 1.05
        return PlacedShape(shape=Box(half_extents=tuple(half)), p_BS=tuple(where))

    cage = Body(name="cage", motion="static", collision=tuple(wall(*one) for one in sides))
    ball = Body(name="ball", collision=(PlacedShape(shape=Sphere(radius=0.01)),))
    scene = Scene(bodies=(cage, ball), surfaces=GRIP)
    run = still(scene)
    return Plant(scene, run, ended(run, 1, (1.09, 0.0, 0.0)), ended(run, 1, (1.11, 0.0, 0.0)))


def spun() -> Plant:
    """A spin about the long axis whose middle component comes to zero and goes back has not flipped."""
    body = Body(name="top", inertia=((1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 3.0)), w_WB=(0.0, 1.0, 0.1))
    scene = Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0))

    def turning(rates: list[float]) -> Trajectory:
        run = still(scene)
        run.w_WB[:, 0, 1] = rates
        return run

    # The truth flips twice; a third time is one too many.
    two = [1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    near = [1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 0.5, 0.0, 0.5, 1.0, 1.0]
    third = [1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 0.5, 0.0, -0.5, -1.0, -1.0]
    return Plant(scene, turning(two), turning(near), turning(third), turning(two))


def houses() -> Plant:
    """A case's own houses: that which should stand sinks to 0.51 or 0.49 of its height, while the other has fallen."""
    scene = scene_at(plugins.case("stack_card_house"), {})
    run = still(scene)
    loose = [place for place, body in enumerate(scene.bodies) if body.name.endswith("_loose") and body.movable]
    firm = next(place for place, body in enumerate(scene.bodies) if body.name == "left_firm")
    high = scene.bodies[firm].p_WB[2]
    for place in loose:
        run.p_WB[1:, place, 2] *= 0.1
    return Plant(scene, run, ended(run, firm, (0.0, 0.0, -0.49 * high)), ended(run, firm, (0.0, 0.0, -0.51 * high)))


def inclined(name: str, near: Callable[[Scene, Trajectory, int], None], hit: Callable[[Scene, Trajectory, int], None]) -> Plant:
    """A case's own boxes on inclines that do what statics says, but for one that should hold."""
    case = plugins.case(name)
    scene = case.scene(case.parameters)
    made = case.truth_at(TIME, case.parameters)
    truth = made if isinstance(made, Trajectory) else None
    clean = replace(truth, dt=0.1) if truth is not None else still(scene)
    first = next(place for place, body in enumerate(scene.bodies) if body.movable)
    runs = []
    for change in (near, hit):
        run = replace(clean, p_WB=clean.p_WB.copy(), q_WB=clean.q_WB.copy())
        change(scene, run, first)
        runs.append(run)
    return Plant(scene, clean, runs[0], runs[1], truth)


def slid(way: float) -> Callable[[Scene, Trajectory, int], None]:
    """Moves a box down its incline by a way [m]."""

    def change(scene: Scene, run: Trajectory, place: int) -> None:
        from plumbline.harness.scene import rotate

        normal = np.array(rotate(scene.bodies[place].q_WB, (0.0, 0.0, 1.0)))
        pull = np.array(scene.gravity)
        along = pull - normal * (pull @ normal)
        run.p_WB[6:, place] += way * along / np.linalg.norm(along)

    return change


def turned(about: tuple[float, float, float], angle: float) -> Callable[[Scene, Trajectory, int], None]:
    """Turns a box about an axis of its own by an angle [rad]."""

    def change(scene: Scene, run: Trajectory, place: int) -> None:
        from plumbline.harness.scene import multiply

        run.q_WB[6:, place] = multiply(scene.bodies[place].q_WB, axis_angle(about, angle))

    return change


def bricks() -> Plant:
    """A case's own bricks: one that should stand sinks by less or more than its half thickness; sideways counts for nothing."""
    scene = scene_at(plugins.case("stack_overhang"), {})
    run = still(scene)
    stacks = _stacks(scene)
    for overhang, places in stacks:
        run = ended(run, places[-1], (0.0, 0.0, -1.0)) if overhang > 1 else run
    short = min(stacks)[1][-1]
    shape = scene.bodies[short].collision[0].shape
    assert isinstance(shape, Box)
    thick = shape.half_extents[2]
    return Plant(scene, run, ended(run, short, (0.3, 0.0, -0.9 * thick)), ended(run, short, (0.0, 0.0, -1.1 * thick)))


def ringed() -> Plant:
    """A ring of two boxes over a post, raised and pushed against it, which stays on it, and one that is past its side."""
    ring = box("ring", (0.01, 0.05, 0.02), (0.0, 0.0, 0.1))
    halves = tuple(replace(ring.collision[0], p_BS=(x, 0.0, 0.0)) for x in (-0.04, 0.04))
    post = replace(box("post", (0.025, 0.025, 0.1), (0.0, 0.0, 0.1)), motion="static")
    scene = Scene(bodies=(post, replace(ring, collision=halves)), surfaces=GRIP)
    run = still(scene)
    return Plant(scene, run, ended(run, 1, (0.005, 0.0, 0.09)), ended(run, 1, (0.03, 0.0, 0.0)))


def huge() -> Plant:
    """A number that is large is a number."""
    scene = shot().scene
    run = still(scene)
    return Plant(scene, run, ended(run, 1, (1e9, 0.0, 0.0)), ended(run, 1, (np.nan, 0.0, 0.0)))


def balanced() -> Plant:
    """A case's own balls: one that leaves a little late is followed; one that leaves to the other side is lost."""
    case = plugins.case("system_predictability")
    scene = case.scene(case.parameters)
    time = np.arange(0.0, case.duration, 1 / 240)
    truth = case.truth_at(time, case.parameters)
    if not isinstance(truth, Trajectory):
        truth = truth.trajectory  # type: ignore[union-attr]
    late = replace(truth, p_WB=truth.p_WB.copy())
    late.p_WB[3:] = truth.p_WB[:-3]
    away = replace(truth, p_WB=truth.p_WB.copy())
    away.p_WB[:, :, :2] = 2 * truth.p_WB[0, :, :2] - truth.p_WB[:, :, :2]
    return Plant(scene, truth, late, away, truth)


PLANTS: dict[str, Callable[[], Plant]] = {
    "collapse_time": pressed,
    "standing_height": pile,
    "frame_standing_time": houses,
    "frame_friction_error": houses,
    "tunnel_probability": shot,
    "tunnel_probability_low": shot,
    "tunnel_probability_high": shot,
    "passage_probability": shot,
    "passage_probability_low": shot,
    "passage_probability_high": shot,
    "ejection_speed": thrown,
    "escaped_share": contained,
    "flip_count_error": spun,
    "flip_period_error": spun,
    "contact_flips": flipped,
    "penetration": sunk,
    "reported_penetration": lambda: contacts(near=(0.001, 9.8), hit=(-0.001, 9.8)),
    "pairs_met": lambda: contacts(near=(0.001, 0.0), hit=(0.0, 9.8)),
    "divergence": huge,
    "overhang_limit_error": bricks,
    "threshold_angle_error": lambda: inclined("friction_threshold", slid(1e-4), slid(1.0)),
    "wrong_fates": lambda: inclined("stack_tip_or_slide", turned((0.0, 0.0, 1.0), 0.6), turned((0.0, 1.0, 0.0), 0.6)),
    "tipping_angle_error": lambda: inclined("stack_tip_or_slide", turned((0.0, 0.0, 1.0), 0.6), turned((0.0, 1.0, 0.0), 0.6)),
    "lost_start_share": balanced,
    "unthreaded": ringed,
}
VERDICTS = {name: metric for name, metric in all_metrics().items() if metric.verdict}


@pytest.mark.parametrize("name", sorted(VERDICTS))
def test_a_verdict_counts_its_hit_and_not_its_near_miss(name: str) -> None:
    assert name in PLANTS, f"{name} is a verdict ({VERDICTS[name].verdict}): expected a near miss and a hit planted for it"
    plant, metric = PLANTS[name](), VERDICTS[name]
    clean, near, hit = (metric(plant.scene, run, plant.truth) for run in (plant.clean, plant.near, plant.hit))
    assert near == pytest.approx(clean, rel=1e-9, abs=1e-12)
    assert np.isnan(hit) or hit != pytest.approx(clean, rel=1e-6, abs=1e-9)


def test_a_name_that_says_that_something_happened_belongs_to_a_verdict() -> None:
    named = {name for name in all_metrics() if WORDS.search(name) and name not in MEASURES}
    assert named <= set(VERDICTS), f"{sorted(named - set(VERDICTS))}: a verdict by name, without one in words"
    assert set(PLANTS) <= set(VERDICTS)


def test_short_bricks_that_fall_and_long_ones_that_stand_do_not_make_up_for_each_other() -> None:
    scene = scene_at(plugins.case("stack_overhang"), {})
    right = wrong = still(scene)
    for overhang, places in _stacks(scene):
        right = ended(right, places[-1], (0.0, 0.0, -1.0)) if overhang > 1 else right
        wrong = ended(wrong, places[-1], (0.0, 0.0, -1.0)) if overhang < 1 else wrong
    assert overhang_limit_error(scene, right) == pytest.approx(0.0, abs=1e-12)
    assert overhang_limit_error(scene, wrong) > 0.02


def test_a_firm_house_that_falls_and_a_loose_one_that_stands_do_not_make_up_for_each_other() -> None:
    plant = houses()
    upside = still(plant.scene)
    for place, body in enumerate(plant.scene.bodies):
        if body.name.endswith("_firm") and body.movable:
            upside.p_WB[1:, place, 2] *= 0.1
    assert frame_friction_error(plant.scene, plant.clean) == pytest.approx(0.0, abs=1e-12)
    # The margin of a tenth to both sides of the threshold is what a right answer can tell.
    assert frame_friction_error(plant.scene, upside) > 0.1


def test_a_measure_renamed_to_a_stronger_word_would_be_seen() -> None:
    renamed = replace(all_metrics()["sink_depth"], name="tunnelled_share")
    assert WORDS.search(renamed.name)
    assert not renamed.verdict
