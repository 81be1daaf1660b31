"""What bodies gave each other in every step, summed up from sample to sample: the balance of momentum, to rounding."""

import numpy as np
import pytest

from plumbline.harness.metric.contact_impulses import STAMPS, forces_between
from plumbline.harness.scene import Body, PlacedShape, Plane, Scene, Sphere, Surface
from plumbline.harness.study import plugins
from plumbline.harness.trajectory.pace import Pace
from plumbline.harness.trial.equivalent_runs import paced
from plumbline.harness.trial.simulate import simulate

DT, G, MASS, RADIUS = 1 / 240, 9.81, 2.0, 0.1


@pytest.mark.parametrize("name", ["", "loaded"])
def test_the_impulse_between_two_samples_is_the_change_of_momentum_and_the_weight(name: str) -> None:
    """A ball lands and comes to rest, its forces another in each step: of eight, seven would go unseen."""
    ball = Body(
        name="ball", mass=MASS, inertia=np.eye(3) * 0.4 * MASS * RADIUS**2, p_WB=(0.0, 0.0, RADIUS + 0.05),
        collision=(PlacedShape(shape=Sphere(radius=RADIUS)),),
    )  # fmt: skip
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    scene = Scene(bodies=(ground, ball), surfaces=(Surface(static_friction=0.5, kinetic_friction=0.5),))
    engine, pace = plugins.adapter("reference"), Pace.of(name, DT)
    simulation = paced(engine.build(scene, engine.tracks["default"].with_dt(DT)), pace)
    run, broke = simulate(
        simulation, scene, pace=pace, duration=0.5, sample_interval=8 * DT, with_contacts=True, seed=0,
        with_impulses=True,
    )  # fmt: skip
    simulation.close()
    assert broke is None
    assert run.streams[STAMPS] == pytest.approx(run.time[1:], abs=0.0)
    gained = MASS * np.diff(run.v_WB[:, 1, 2]) + MASS * G * np.diff(run.time)
    assert gained.max() > 4 * MASS * G * DT, "the ball lands in this time"
    # Each of eight steps in four sub-steps rounds a sum of momenta of some kg m/s.
    assert run.streams["contacts/0:1"][:, 2] == pytest.approx(gained, abs=1e-13)
    assert run.contacts is not None
    seen = np.array([forces_between(contacts, 2)[0, 1, 2] for contacts in run.contacts[1:]]) * np.diff(run.time)
    assert np.abs(seen - gained).max() > MASS * G * DT, "samples alone tell another impulse"
