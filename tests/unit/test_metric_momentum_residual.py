"""The momentum residual on forces made by hand: a clean blow has none, and each fault of a force shows in its size."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.contacts import momentum_residual
from plumbline.harness.scene import WORLD, Ball, Body, Scene
from plumbline.harness.trajectory import Contacts, Floats, Trajectory

DT, MASS, G = 0.01, 2.0, 9.81
STAGE = Scene(bodies=(Body(name="ground", motion="static"), Body(name="ball", mass=MASS)))
ROUNDING = 1e-14  # of a momentum of some kg m/s, over one of 4 kg m/s


def blow(force: Floats | None = None, every: int = 1) -> Trajectory:
    """Six steps of a ball that falls, meets the ground in the fourth step askew, and flies on."""
    forces = np.zeros((7, 3))
    forces[4] = (-40.0, 0.0, 400.0)
    run = replace(Trajectory.of(np.arange(7) * DT, 2), dt=DT)
    gained = (forces / MASS + np.array([0.0, 0.0, -G])) * DT
    gained[0] = 0.0
    run.v_WB[:, 1] = np.cumsum(gained, axis=0)
    said = forces if force is None else force
    contacts = tuple(
        Contacts.of([0], [1], np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), [0.0], f[None]) if f.any() else Contacts.none()
        for f in said
    )
    keep = slice(None, None, every)
    return replace(run, contacts=contacts[keep], time=run.time[keep], p_WB=run.p_WB[keep], v_WB=run.v_WB[keep])


def spoilt(change: tuple[float, float, float], late: int = 0) -> float:
    forces = np.zeros((7, 3))
    forces[4 + late] = np.array([-40.0, 0.0, 400.0]) * change
    return momentum_residual(STAGE, blow(forces))


def test_forces_that_move_the_body_leave_no_residual() -> None:
    assert momentum_residual(STAGE, blow()) == pytest.approx(0.0, abs=ROUNDING)


def test_the_first_body_feels_the_force_the_other_way() -> None:
    turned = replace(STAGE, bodies=STAGE.bodies[::-1])
    run = blow()
    swapped = replace(run, v_WB=run.v_WB[:, ::-1], contacts=tuple(
        replace(c, body_A=c.body_A, normal_W=-c.normal_W, force_W=-c.force_W) for c in run.contacts or ()
    ))  # fmt: skip
    assert momentum_residual(turned, swapped) == pytest.approx(0.0, abs=ROUNDING)


def test_each_fault_of_a_force_has_its_size() -> None:
    # The blow changes the momentum by |(-.4, 0, 4 - .196)| = 3.825 N s, the greatest of all steps.
    greatest = float(np.linalg.norm([-0.4, 0.0, 4.0 - MASS * G * DT]))
    assert spoilt((0.0, 1.0, 1.0)) == pytest.approx(0.4 / greatest)
    assert spoilt((-1.0, 1.0, 1.0)) == pytest.approx(0.8 / greatest)
    assert spoilt((1.0, 1.0, 0.5)) == pytest.approx(2.0 / greatest)
    assert spoilt((1.0, 1.0, 1.0), late=1) == pytest.approx(np.hypot(0.4, 4.0) / greatest)


def test_what_cannot_be_measured_is_said() -> None:
    with pytest.raises(NotMeasurable, match="no contacts"):
        momentum_residual(STAGE, replace(blow(), contacts=None))
    with pytest.raises(NotMeasurable, match="one step apart"):
        momentum_residual(STAGE, blow(every=2))
    hung = replace(STAGE, joints=(Ball(name="pin", parent=WORLD, child="ball", anchor_W=(0, 0, 0)),))
    with pytest.raises(NotMeasurable, match="contacts and gravity alone"):
        momentum_residual(hung, blow())


def test_a_number_that_is_none_is_not_swallowed() -> None:
    run = blow()
    run.v_WB[3, 1, 0] = np.nan
    assert np.isnan(momentum_residual(STAGE, run))
