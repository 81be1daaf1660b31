"""Truths of the tunnelling cases against event searches, their phases against uniformity, their checks against leaky bodies."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from scipy.stats import kstest

from plumbline.cases import tunnel_dynamic_pair, tunnel_rod, tunnel_thin_mesh
from plumbline.harness.case import Case
from plumbline.harness.scene import Effect, TriangleMesh
from plumbline.harness.trajectory import Floats, Trajectory

G = 9.81


def clock(steps: int, dt: float) -> Floats:
    """The ends of `steps` steps, from 0 on, (steps + 1,) s."""
    time: Floats = np.arange(steps + 1, dtype=np.float64) * dt
    return time


def verdicts(case: Case, run: Trajectory, **parameters: object) -> dict[str, bool]:
    chosen = {**case.parameters, **parameters}
    truth = case.truth_at(run.time, chosen)
    assert isinstance(truth, Trajectory)
    scene = case.scene(case.at(**chosen))
    return {c.metric.name: c.passes(c.metric(scene, run, truth), run.dt, case.parameters) for c in case.checks}


def meeting(gap: object, until: float) -> float:
    """The first instant [s] at which gap(t) is zero, by an event search."""

    def touch(t: float, _y: Floats) -> float:
        return float(gap(t))  # type: ignore[operator]

    touch.terminal = True  # type: ignore[attr-defined]
    run = solve_ivp(lambda *_: [0.0], (0, until), [0.0], events=touch, max_step=until / 500, rtol=1e-12, atol=1e-12)
    return float(run.t_events[0][0])


# --- tunnel_dynamic_pair --------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [1.0, 50.0, 500.0])
def test_pairs_meet_when_an_event_search_says_and_then_rest(speed: float) -> None:
    stage = tunnel_dynamic_pair.scene(tunnel_dynamic_pair.P(speed=speed, phases=5, seed=3))
    for a in range(0, 10, 2):
        x = [stage.bodies[a + k].p_WB[0] for k in (0, 1)]
        v = [stage.bodies[a + k].v_WB[0] for k in (0, 1)]
        hit = meeting(lambda t, x=x, v=v: x[1] + v[1] * t - x[0] - v[0] * t - 2 * tunnel_dynamic_pair.RADIUS, 0.2)
        assert hit < tunnel_dynamic_pair.DURATION / 2
        truth = tunnel_dynamic_pair.expected(
            np.array([0.0, hit * 0.999, hit * 1.001, 0.25]), tunnel_dynamic_pair.P(speed=speed, phases=5, seed=3)
        )
        np.testing.assert_allclose(truth.p_WB[1, a : a + 2, 0], np.array(x) + 0.999 * hit * np.array(v), atol=1e-9)
        np.testing.assert_allclose(np.diff(truth.p_WB[2:, a : a + 2, 0], axis=1), 2 * tunnel_dynamic_pair.RADIUS, atol=1e-9)
        np.testing.assert_array_equal(truth.v_WB[2:, a : a + 2], 0.0)


@pytest.mark.parametrize("dt", tunnel_dynamic_pair.CASE.ladder)
def test_pairs_meet_at_phases_that_are_uniform_over_a_step(dt: float) -> None:
    ways = tunnel_dynamic_pair._ways(50.0, 400, 11)
    assert kstest(np.mod(ways / 50.0 / dt, 1.0), "uniform").pvalue > 1e-3


def discrete_pairs(dt: float) -> Trajectory:
    """What a test of places at the ends of steps gives: a pair that overlaps there stands still, in touch; another flies on."""
    stage = tunnel_dynamic_pair.scene(tunnel_dynamic_pair.P())
    run = replace(Trajectory.of(clock(round(0.25 / dt), dt), len(stage.bodies)), dt=dt)
    p = np.array([b.p_WB for b in stage.bodies])
    v = np.array([b.v_WB for b in stage.bodies])
    for k in range(len(run)):
        run.p_WB[k], run.v_WB[k] = p, v
        p = p + dt * v
        for a in range(0, len(p), 2):
            gap = p[a + 1, 0] - p[a, 0]
            if v[a].any() and abs(gap) < 2 * tunnel_dynamic_pair.RADIUS and gap > 0:
                p[a, 0], p[a + 1, 0] = -tunnel_dynamic_pair.RADIUS, tunnel_dynamic_pair.RADIUS
                v[a : a + 2] = 0.0
    return run


@pytest.mark.parametrize("dt", [1 / 60, pytest.param(1 / 240, marks=pytest.mark.slow), 1 / 480])
def test_a_discrete_test_of_pairs_misses_with_the_probability_of_its_blind_way(dt: float) -> None:
    """It sees the overlap of 2 r before the centres cross; a step closes 2 v dt, so it misses 1 - r/(v dt)."""
    run = discrete_pairs(dt)
    scene, truth = (
        tunnel_dynamic_pair.scene(tunnel_dynamic_pair.P()),
        tunnel_dynamic_pair.expected(run.time, tunnel_dynamic_pair.P()),
    )
    low, high = (m(scene, run, truth) for m in tunnel_dynamic_pair.CASE.observe[:2])
    assert low <= 1 - tunnel_dynamic_pair.RADIUS / (50.0 * dt) <= high
    assert not verdicts(tunnel_dynamic_pair.CASE, run)["passage_probability"]


def test_pairs_are_stopped_where_a_step_is_shorter_than_a_radius() -> None:
    assert all(verdicts(tunnel_dynamic_pair.CASE, discrete_pairs(1 / 1920)).values())


# --- tunnel_rod -----------------------------------------------------------------------------------


def rod_gap(angle: float) -> float:
    """Distance [m] between the surfaces of a post at (LEVER, 0) and of a rod at an azimuth, from segment to point."""
    along = np.array([np.cos(angle), np.sin(angle)])
    post = np.array([tunnel_rod.LEVER, 0.0])
    foot = np.clip(post @ along, -tunnel_rod.HALF_LENGTH, tunnel_rod.HALF_LENGTH) * along
    return float(np.linalg.norm(post - foot)) - tunnel_rod.RADIUS - tunnel_rod.POST_RADIUS


@pytest.mark.parametrize("spin", [5.0, 60.0, 500.0])
def test_rods_meet_their_posts_when_an_event_search_says(spin: float) -> None:
    stage = tunnel_rod.scene(tunnel_rod.P(spin=spin, phases=5, seed=4))
    for place, body in enumerate(stage.bodies[2:], start=2):
        axis = Rotation.from_quat(body.q_WB, scalar_first=True).apply([0.0, 0.0, 1.0])
        assert axis[2] == pytest.approx(0.0, abs=1e-12)
        start = float(np.arctan2(axis[1], axis[0]))
        hit = meeting(lambda t, start=start: rod_gap(start + spin * t), 2.5 / spin)
        truth = tunnel_rod.expected(np.array([hit * 0.999, hit * 1.001, 0.25]), tunnel_rod.P(spin=spin, phases=5, seed=4))
        np.testing.assert_array_equal(truth.w_WB[:, place, 2], [spin, 0.0, 0.0])
        ends = Rotation.from_quat(truth.q_WB[:, place], scalar_first=True).apply([0.0, 0.0, 1.0])
        assert rod_gap(float(np.arctan2(ends[0, 1], ends[0, 0]))) > 0
        assert rod_gap(float(np.arctan2(ends[2, 1], ends[2, 0]))) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("dt", tunnel_rod.CASE.ladder)
def test_rods_arrive_at_phases_that_are_uniform_over_a_step(dt: float) -> None:
    assert kstest(np.mod(tunnel_rod._angles(60.0, 400, 11) / 60.0 / dt, 1.0), "uniform").pvalue > 1e-3


def test_both_blows_stop_a_rod_dead() -> None:
    """Two impulses J at the levers +R and -R, against each other: no net force, and 2 J R = I w stops it."""
    w, lever, moment = 60.0, tunnel_rod.LEVER, tunnel_rod.scene(tunnel_rod.P()).bodies[2].inertia[0][0]
    mass = tunnel_rod.MASS
    # Unknown impulses at both ends that leave no speed of approach at either.
    system = np.array([[1 / mass + lever**2 / moment, -1 / mass + lever**2 / moment]] * 2)
    system[1] = system[1][::-1]
    impulses = np.linalg.solve(system, [w * lever, w * lever])
    assert impulses[0] == pytest.approx(impulses[1])
    assert lever * impulses.sum() == pytest.approx(moment * w)


def rods(dt: float, seen: bool) -> Trajectory:
    """Rods tested for overlap at the ends of steps, or that see nothing at all."""
    stage = tunnel_rod.scene(tunnel_rod.P())
    truth = tunnel_rod.expected(np.array([0.0]), tunnel_rod.P())
    run = replace(Trajectory.of(clock(round(0.25 / dt), dt), len(stage.bodies)), dt=dt)
    run.p_WB[:] = truth.p_WB[0]
    run.q_WB[:] = truth.q_WB[0]
    for place, angle in enumerate(tunnel_rod._angles(60.0, 64, 0), start=2):
        turned, moving = np.zeros(len(run)), True
        meets = float(np.arcsin((tunnel_rod.RADIUS + tunnel_rod.POST_RADIUS) / tunnel_rod.LEVER))
        for k in range(1, len(run)):
            turned[k] = turned[k - 1] + 60.0 * dt * moving
            if seen and angle <= turned[k] < angle + meets:
                turned[k], moving = angle, False
        turn = Rotation.from_rotvec(np.outer(turned, [0.0, 0.0, 1.0]))
        first = Rotation.from_quat(stage.bodies[place].q_WB, scalar_first=True)
        run.q_WB[:, place] = (turn * first).as_quat(scalar_first=True)
    return run


@pytest.mark.parametrize("dt", [1 / 240, pytest.param(1 / 480, marks=pytest.mark.slow), 1 / 960])
def test_a_discrete_test_of_rods_misses_with_the_probability_of_its_blind_angle(dt: float) -> None:
    run = rods(dt, seen=True)
    scene, truth = tunnel_rod.scene(tunnel_rod.P()), tunnel_rod.expected(run.time, tunnel_rod.P())
    low, high = (m(scene, run, truth) for m in tunnel_rod.CASE.observe[:2])
    meets = float(np.arcsin((tunnel_rod.RADIUS + tunnel_rod.POST_RADIUS) / tunnel_rod.LEVER))
    # A rod that misses one post may be caught by the next, half a turn on: it has passed all the same.
    assert low <= max(0.0, 1 - meets / (60.0 * dt)) <= high
    assert verdicts(tunnel_rod.CASE, run)["passage_probability"] == (60.0 * dt < meets)


def test_rods_that_see_nothing_all_pass() -> None:
    run = rods(1 / 240, seen=False)
    assert (
        tunnel_rod.CASE.checks[1].metric(tunnel_rod.scene(tunnel_rod.P()), run, tunnel_rod.expected(run.time, tunnel_rod.P()))
        == 1.0
    )


@pytest.mark.parametrize("spin", [0.5, 700.0])
def test_a_spin_too_slow_or_too_fast_is_refused(spin: float) -> None:
    with pytest.raises(ValueError, match=r"spin .* rad/s, expected"):
        tunnel_rod.scene(tunnel_rod.P(spin=spin))


# --- tunnel_thin_mesh -----------------------------------------------------------------------------


def test_the_slab_is_closed_convex_and_level_with_its_edges_where_balls_slide() -> None:
    slab = tunnel_thin_mesh.scene(tunnel_thin_mesh.P()).bodies[1].collision[0].shape
    assert isinstance(slab, TriangleMesh)
    points, faces = np.array(slab.vertices), np.array(slab.faces)
    edges = [(f[i], f[(i + 1) % 3]) for f in slab.faces for i in range(3)]
    # Every edge is walked once each way: closed and turned one way throughout.
    assert len(set(edges)) == len(edges)
    assert {(b, a) for a, b in edges} == set(edges)
    a, b, c = (points[faces[:, i]] for i in range(3))
    volume = float(np.sum(np.einsum("ij,ij->i", a, np.cross(b, c)))) / 6
    assert volume == pytest.approx(ConvexHull(points).volume)
    top = np.cross(b - a, c - a)[(a[:, 2] == 0) & (b[:, 2] == 0) & (c[:, 2] == 0)]
    assert (top[:, 2] > 0).all()


@pytest.mark.parametrize("speed", [1.0, 20.0, 200.0])
def test_balls_land_when_an_event_search_of_the_fall_says(speed: float) -> None:
    stage = tunnel_thin_mesh.scene(tunnel_thin_mesh.P(speed=speed, phases=3, seed=2))
    for place, body in enumerate(stage.bodies[2:], start=2):

        def ground(_t: float, y: Floats) -> float:
            return float(y[0] - tunnel_thin_mesh.RADIUS)

        ground.terminal = True  # type: ignore[attr-defined]
        start = [body.p_WB[2], body.v_WB[2]]
        run = solve_ivp(lambda _, y: [y[1], -G], (0, 1), start, "DOP853", events=ground, rtol=1e-12, atol=1e-12)
        hit = float(run.t_events[0][0])
        truth = tunnel_thin_mesh.expected(
            np.array([0.999 * hit, 1.001 * hit, 0.5]), tunnel_thin_mesh.P(speed=speed, phases=3, seed=2)
        )
        assert truth.v_WB[0, place, 2] == pytest.approx(-speed - G * 0.999 * hit)
        np.testing.assert_allclose(truth.p_WB[1:, place, 2], tunnel_thin_mesh.RADIUS, atol=1e-9)
        np.testing.assert_array_equal(truth.v_WB[1:, place], [[tunnel_thin_mesh.SLIDE, 0.0, 0.0]] * 2)


def test_every_other_ball_over_the_mesh_runs_along_an_edge_and_none_leaves_the_ground() -> None:
    stage = tunnel_thin_mesh.scene(tunnel_thin_mesh.P())
    for body in stage.bodies[2:]:
        on_mesh = body.p_WB[1] > stage.bodies[1].p_WB[1] - 1
        cells = (body.p_WB[1] - on_mesh * stage.bodies[1].p_WB[1]) / tunnel_thin_mesh.CELL
        row = int(body.name.removeprefix("ball_")) % tunnel_thin_mesh.PHASES
        assert cells == pytest.approx(row + (tunnel_thin_mesh.OFF_EDGE if row % 2 else 0.0))
        end = body.p_WB[0] + tunnel_thin_mesh.SLIDE * tunnel_thin_mesh.DURATION
        assert tunnel_thin_mesh.ALONG[0] + 1 <= body.p_WB[0] / tunnel_thin_mesh.CELL
        assert end / tunnel_thin_mesh.CELL < tunnel_thin_mesh.ALONG[1] - 0.5


def landed(dt: float) -> Trajectory:
    return replace(tunnel_thin_mesh.expected(clock(round(0.5 / dt), dt), tunnel_thin_mesh.P()), dt=dt)


def test_balls_that_land_and_slide_pass_and_one_that_falls_through_or_is_kicked_fails() -> None:
    assert all(verdicts(tunnel_thin_mesh.CASE, landed(1 / 240)).values())
    # The middle of the ground lies 0.055 m below a ball's centre.
    deep, through = landed(1 / 240), landed(1 / 240)
    deep.p_WB[-1, 7, 2] -= 0.054
    assert verdicts(tunnel_thin_mesh.CASE, deep)["passage_probability"]
    through.p_WB[-1, 7, 2] -= 0.056
    assert not verdicts(tunnel_thin_mesh.CASE, through)["passage_probability"]
    kicked = landed(1 / 240)
    kicked.v_WB[-1, 40, 1] += 1e-3
    found = verdicts(tunnel_thin_mesh.CASE, kicked)
    assert not found["lateral_kick"]
    assert found["passage_probability"]
    bouncing = landed(1 / 240)
    bouncing.v_WB[-1, 40, 2] += 0.1
    assert not verdicts(tunnel_thin_mesh.CASE, bouncing)["rest_speed"]


@pytest.mark.parametrize(
    ("case", "effects"),
    [
        (tunnel_dynamic_pair, {"contact", "continuous_collision"}),
        (tunnel_rod, {"contact", "continuous_collision"}),
        (tunnel_thin_mesh, {"gravity", "contact", "continuous_collision"}),
    ],
)
def test_continuous_detection_is_called_for_unless_it_is_declined(case: object, effects: set[str]) -> None:
    scene, P = case.scene, case.P  # type: ignore[attr-defined]
    assert set(scene(P()).effects.names) == effects
    assert Effect.CONTINUOUS_COLLISION not in scene(P(continuous=False)).effects
    assert scene(P(seed=1)) == scene(P(seed=1)) != scene(P(seed=2))
