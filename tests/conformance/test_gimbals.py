"""A wheel in a gimbal on Bullet and on DART: on tuned a constraint in sub-steps carries it, and what does not is told."""

from dataclasses import replace
from typing import Any

import pytest

from plumbline.harness.adapter import Adapter, Settings
from plumbline.harness.adapter.fast_rotors import fast_rotors
from plumbline.harness.scene import Drive, Scene
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import State
from tests.gimbals import energy, gimbal

ENGINES = pytest.mark.parametrize("engine", ["bullet", "dart"])


def installed(engine: str) -> Adapter:
    pytest.importorskip({"bullet": "pybullet", "dart": "dartpy"}[engine])
    return plugins.adapters()[engine]


def kept(adapter: Adapter, scene: Scene, settings: Settings, seconds: float = 2.0) -> tuple[float, float, Any]:
    """The least and the greatest share of the energy at the start, and the simulation, closed."""
    simulation, state, shares = adapter.build(scene, settings), State.empty(len(scene.bodies)), []
    try:
        simulation.state(state)
        start = energy(scene, state)
        for _ in range(round(seconds / settings.dt)):
            simulation.step()
            simulation.state(state)
            shares.append(energy(scene, state) / start)
        return min(shares), max(shares), (simulation.resolved, [str(notice) for notice in simulation.warnings()])
    finally:
        simulation.close()


@ENGINES
@pytest.mark.parametrize("spin", [75.0, 120.0, 150.0, 187.5])
@pytest.mark.parametrize("dt", [1 / 240, 1e-3])
def test_a_gimbal_keeps_its_energy_on_tuned_without_a_word(engine: str, spin: float, dt: float) -> None:
    adapter = installed(engine)
    least, most, (resolved, told) = kept(adapter, gimbal(spin), adapter.tracks["tuned"].with_dt(dt))
    # The wobble has the energy of the rings and the wheel across, 1e-3 of the wheel's, which explicit steps may take or give.
    assert 0.999 < least <= most < 1.001
    assert resolved.substeps == (4 if dt == 1 / 240 else 1)
    assert not told


@ENGINES
@pytest.mark.parametrize("held", ["by default", "on a driven hinge"])
def test_where_a_rotor_is_a_coordinate_the_growth_of_its_wobble_is_told(engine: str, held: str) -> None:
    adapter = installed(engine)
    scene = gimbal() if held == "by default" else gimbal(drive=Drive(damping=1e-6, target_velocity=150.0))
    settings = adapter.tracks["default" if held == "by default" else "tuned"].with_dt(1e-3)
    simulation = adapter.build(scene, settings)
    try:
        told = [str(notice) for notice in simulation.warnings()]
        h = settings.dt / (simulation.resolved.substeps or 1)
    finally:
        simulation.close()
    growth = f"e^{fast_rotors(scene).growth(h):.2g} a second"
    assert sum("fast rotor on joint 'c'" in text and growth in text for text in told) == 1


@ENGINES
def test_in_coordinates_the_energy_grows_as_is_told(engine: str) -> None:
    adapter, links = installed(engine), {"bullet": "links", "dart": "coordinates"}[engine]
    tuned = adapter.tracks["tuned"]
    settings = replace(tuned, options={**tuned.options, "joints": links}).with_dt(1e-3)
    _, most, (_, told) = kept(adapter, gimbal(), settings, 1.0)
    # e^(W^2 h/2) = e^11 a second of a wobble that has 1e-4 of the energy at first: it is all over the place within one.
    assert most > 1.5
    assert len(told) == 1


@ENGINES
def test_a_rotor_uneven_across_its_axis_stays_finite_and_is_told(engine: str) -> None:
    adapter = installed(engine)
    scene = gimbal(wheel=(0.2e-3, 0.8e-3, 0.9e-3))
    _, most, (_, told) = kept(adapter, scene, adapter.tracks["tuned"].with_dt(1 / 240))
    assert most < 1.001
    assert any("uneven" in text for text in told)
