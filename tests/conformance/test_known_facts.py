"""What is known of the engines comes out of the cases by itself, with the size that its cause gives it.

Each fact has a cause that says how large it has to be; a case that did not show it, or an engine that no longer has it, fails.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.harness.adapter import Settings
from plumbline.harness.scene import principal_inertia
from plumbline.harness.study import plugins
from plumbline.harness.trajectory.kinematics import rotate_back
from tests.conformance.engines import why_unavailable
from tests.conformance.put import Answer, put


def ask(name: str, engine: str, settings: Settings | str, dt: float, **parameters: object) -> Answer:
    """The answer of an engine on a track, or under settings of its own."""
    if missing := why_unavailable(engine):
        pytest.skip(missing)
    adapter = plugins.adapter(engine)
    chosen = adapter.tracks[settings] if isinstance(settings, str) else settings
    answer = put(plugins.case(name), adapter, chosen.with_dt(dt), parameters=parameters)
    assert answer.broke is None, answer.broke
    return answer


def askew(answer: Answer) -> float:
    """How far boxes slide that are pushed at 45 degrees, over those pushed along an axis."""
    way = np.linalg.norm(answer.actual.p_WB[-1, 1:, :2] - answer.actual.p_WB[0, 1:, :2], axis=1)
    return float(way[len(way) // 2] / way[0])


@pytest.mark.parametrize(("engine", "ratio"), [("mujoco", 2**0.5), ("dart", 0.5**0.5)])
def test_pyramids_and_boxes_of_friction_are_anisotropic_and_their_tuned_tracks_are_not(engine: str, ratio: float) -> None:
    """MuJoCo's pyramid stands inside the cone with its edges on the axes: at 45 degrees it holds 1/sqrt(2) of mu N. DART bounds
    both axes apart: sqrt(2) of mu N. The way goes with the inverse; each is uncertain by v0 dt, half a per cent at 1/480 s on
    0.41 m, and the soft contact of the start."""
    default, tuned = (ask("friction_isotropy", engine, track, 1 / 480) for track in ("default", "tuned"))
    assert askew(default) == pytest.approx(ratio, rel=0.02)
    assert "polar_spread" in default.broken
    assert askew(tuned) == pytest.approx(1.0, abs=1e-3)
    # What MuJoCo's soft friction misses of mu N beneath a landing corner is another matter, and declared.
    assert tuned.broken.keys() <= {"dissipation_residual"}


def test_the_damping_that_bullet_has_by_default_shows_in_flight_and_in_a_pendulum() -> None:
    """Bullet's multibodies feel a drag of 0.04 (1 + |v|) v per mass unless told otherwise: the thrown ball follows that
    equation's solution, to the first order of its integrator, and a pendulum loses energy that its tuned track keeps."""
    thrown, kept = (ask("flight_projectile", "bullet", track, 1 / 240) for track in ("default", "tuned"))
    time, v = thrown.actual.time, thrown.actual.v_WB[:, 0]
    gravity = np.array(thrown.scene.gravity)
    dragged = solve_ivp(
        lambda _, now: gravity - 0.04 * (1 + np.linalg.norm(now)) * now, (0.0, time[-1]), v[0], t_eval=time, rtol=1e-9
    )
    # A step of drag and gravity may be off by their change over one step: g dt, and 4 % of it.
    assert np.abs(v - dragged.y.T).max() < 9.81 / 240
    assert np.abs(v[-1] - dragged.y[:, -1]).max() < 0.02 * np.abs(v[-1] - kept.actual.v_WB[-1, 0]).max()
    assert {"position_error_max", "velocity_error_max"} <= set(thrown.broken)
    assert not kept.broken
    swung, free = (ask("joint_pendulum", "bullet", track, 1 / 240) for track in ("default", "tuned"))
    assert swung["energy_drift_final"] > 0.25
    assert free["energy_drift_final"] < 0.01
    assert not free.broken


def test_the_creep_of_mujoco_falls_with_the_ratio_of_friction_to_normal_impedance() -> None:
    """A friction constraint under a steady load creeps at a speed that goes with its regularisation, which impratio divides."""
    speeds = [
        ask("friction_creep", "mujoco", Settings(options={"cone": "elliptic", "impratio": ratio}), 1 / 480)["creep_speed"]
        for ratio in (1.0, 10.0, 100.0)
    ]
    assert speeds[0] > 1e-4
    assert speeds[0] / speeds[1] == pytest.approx(10.0, rel=0.1)
    assert speeds[1] / speeds[2] == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize("speed", [50.0, 200.0])
def test_mujoco_tunnels_by_default_where_its_speculative_contacts_do_not(speed: float) -> None:
    """At 240 Hz the ball goes 21 or 83 cm a step and overlaps the wall on 11 cm of its way: half of the shots or more are never
    seen. Speculative contacts see them coming."""
    default = ask("tunnel_sphere_wall", "mujoco", "default", 1 / 240, speed=speed, phases=16)
    flagged = ask("tunnel_sphere_wall", "mujoco", Settings(options={"speculative": True}), 1 / 240, speed=speed, phases=16)
    assert default["tunnel_probability"] > 0.4
    assert flagged["tunnel_probability"] == 0.0


@pytest.mark.parametrize(
    ("engine", "settings", "sign"),
    [
        ("mujoco", Settings(integrator="euler"), 1),
        ("bullet", Settings(options={"damping": "scene"}), 1),
        ("dart", "default", 1),
        ("mujoco", Settings(integrator="implicitfast"), -1),
        ("bullet", "tuned", -1),
    ],
    ids=lambda value: value if isinstance(value, str) else None,
)
def test_explicit_gyroscopic_terms_give_and_implicit_ones_take_about_seven_per_cent_of_a_top_s_energy(
    engine: str, settings: Settings | str, sign: int
) -> None:
    """A step w + h w' has the energy E + h^2/2 w'.I w', since w.I w' = 0; taken implicitly the square comes with a minus. Over
    a run that is h/2 times the integral of w'.I w' along the way that the engine takes; sampling it 60 times a second and the
    end of a step for its start leave a few per cent of that."""
    moments, spin, dt = (1.0, 2.0, 3.0), (1.2, 1.68, 2.88), 1 / 240
    top = ask("spin_asymmetric_top", engine, settings, dt, moments=moments, spin=spin)
    inertia = np.diag(np.asarray(principal_inertia(*moments)))
    w = rotate_back(top.actual.q_WB[:, 0], top.actual.w_WB[:, 0])
    energy = 0.5 * (w * w) @ inertia
    rate = np.cross(w * inertia, w) / inertia
    expected = dt / 2 * float(np.trapezoid((rate * rate) @ inertia, top.actual.time))
    change = sign * float(energy[-1] - energy[0])
    assert change == pytest.approx(expected, rel=0.05)
    assert 0.05 < change / energy[0] < 0.1


def test_runge_and_kutta_keep_the_energy_that_first_order_methods_lose() -> None:
    for engine in ("mujoco", "reference"):
        tuned = plugins.adapter(engine).tracks["tuned"]
        assert ask("spin_asymmetric_top", engine, replace(tuned, integrator="rk4"), 1 / 240)["energy_drift_max"] < 1e-9
