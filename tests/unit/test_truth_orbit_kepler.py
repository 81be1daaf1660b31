"""Kepler's ellipse: Kepler's equation against Newton's law by quadrature, the bounds against what must fail them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases.orbit_kepler import CASE, STRENGTH, P, eccentric_anomaly, expected, scene, textbook
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.periods import orbit_energy_drift_final, orbit_energy_drift_max, orbit_energy_drift_staggered_max
from plumbline.harness.trajectory import Floats, Trajectory

DT = 1 / 240


@pytest.mark.parametrize("eccentricity", [0.0, 0.2, 0.5, 0.9])
def test_the_ellipse_obeys_newtons_law(eccentricity: float) -> None:
    time = np.linspace(0.0, 3.0, 61)
    truth = expected(time, P(eccentricity))
    start = scene(P(eccentricity)).bodies[0]

    def change(_t: float, y: Floats) -> Floats:
        return np.concatenate([y[2:], -STRENGTH * y[:2] / np.hypot(*y[:2]) ** 3])

    found = solve_ivp(change, (0.0, 3.0), [*start.p_WB[:2], *start.v_WB[:2]], "DOP853", t_eval=time, rtol=1e-13, atol=1e-14).y
    # Per turn a relative 1e-13 a step grows with the phase, some hundredfold; the pericentre at e = 0.9 tenfold more.
    np.testing.assert_allclose(truth.p_WB[:, 0, :2], found[:2].T, atol=1e-9)
    np.testing.assert_allclose(truth.v_WB[:, 0, :2], found[2:].T, atol=1e-7)


def test_keplers_equation_is_solved_at_every_mean_anomaly() -> None:
    mean = np.linspace(-7.0, 700.0, 5003)
    for eccentricity in (0.0, 0.5, 0.9):
        found = eccentric_anomaly(mean, eccentricity)
        # The rounding of an angle of 700 rad, through a slope of at least 0.1.
        np.testing.assert_allclose(found - eccentricity * np.sin(found), mean, atol=1e-12)
        assert (np.diff(found) > 0).all()


def _verdicts(run: Trajectory) -> dict[str, bool]:
    truth = expected(run.time, P())
    return {c.metric.name: c.passes(c.metric(scene(P()), run, truth), run.dt, CASE.parameters) for c in CASE.checks}


def test_the_truth_passes() -> None:
    assert all(_verdicts(replace(expected(np.arange(6001) / 60, P()), dt=DT)).values())


@pytest.mark.parametrize("lead", [0.0, 0.625, *(pytest.param(lead, marks=pytest.mark.slow) for lead in (0.375, 0.5))])
def test_every_lead_that_engines_have_passes(lead: float) -> None:
    assert all(_verdicts(textbook(DT, lead, 100.0, 4, P())).values())


def test_a_force_held_from_the_wrong_instant_and_a_hidden_damping_fail() -> None:
    """A motion that is exact under a force held from the start of each step gains energy turn by turn."""
    body = scene(P()).bodies[0]
    run = replace(Trajectory.of(np.linspace(0.0, 100.0, 6001), 1), dt=DT)
    p, v = np.array(body.p_WB), np.array(body.v_WB)
    for k in range(round(100.0 / DT) + 1):
        if k % 4 == 0:
            run.p_WB[k // 4, 0], run.v_WB[k // 4, 0] = p, v
        a = -STRENGTH * p / np.linalg.norm(p) ** 3
        p, v = p + v * DT + a * DT**2 / 2, v + a * DT
    found = _verdicts(run)
    assert found["divergence"]
    assert not any(passed for name, passed in found.items() if name != "divergence")
    braked = textbook(DT, 0.5, 100.0, 4, P())
    braked.v_WB[:] *= np.exp(-0.0002 * braked.time)[:, None, None]
    assert not _verdicts(braked)["orbit_energy_drift_max"]


def test_half_a_step_between_position_and_velocity_is_seen_raw_and_gone_corrected() -> None:
    time, found = np.arange(601) / 120, []
    truth = expected(time, P())
    for dt in (1 / 480, 1 / 1920):
        staggered = replace(expected(time, P()), dt=dt)
        staggered.v_WB[:] = expected(time - dt / 2 + 1.0, P()).v_WB
        found.append([m(scene(P()), staggered, truth) for m in (orbit_energy_drift_max, orbit_energy_drift_staggered_max)])
    (raw, corrected), (raw_fine, corrected_fine) = found
    # (dt/2) v . a at its largest over the energy k/2a is of first order; what the correction leaves is of second.
    p = truth.p_WB[:, 0]
    pull = -STRENGTH * p / np.linalg.norm(p, axis=1)[:, None] ** 3
    power = np.abs(np.sum(truth.v_WB[:, 0] * pull, axis=1)).max()
    assert raw_fine == pytest.approx(power / (2 * 1920) / (STRENGTH / 2), rel=0.05)
    assert raw / raw_fine == pytest.approx(4.0, rel=0.1)
    assert corrected / corrected_fine == pytest.approx(16.0, rel=0.1)
    assert corrected_fine < 0.02 * raw_fine


def test_orbit_energy_sees_what_is_planted_and_swallows_nothing() -> None:
    time = np.arange(121) / 60
    truth, answer = expected(time, P()), replace(expected(time, P()), dt=DT)
    # k is fitted to the rounding of the truth.
    assert orbit_energy_drift_max(scene(P()), answer, truth) < 1e-12
    answer.v_WB[-1] *= 1.01
    won = (1.01**2 - 1) * float(np.square(truth.v_WB[-1]).sum()) / 2 / (STRENGTH / 2)
    assert orbit_energy_drift_final(scene(P()), answer, truth) == pytest.approx(won, rel=1e-9)
    answer.p_WB[3] = np.nan
    for metric in (orbit_energy_drift_max, orbit_energy_drift_final, orbit_energy_drift_staggered_max):
        assert not np.isfinite(metric(scene(P()), answer, truth))
    circle = expected(time, P(eccentricity=0.0))
    with pytest.raises(NotMeasurable, match="keeps its distance"):
        orbit_energy_drift_max(scene(P(0.0)), circle, circle)
