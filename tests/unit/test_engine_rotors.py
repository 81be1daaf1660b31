"""Rotors and dry friction in joints of the reference engine: beside contacts, in islands, in space, and beside far stops."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline import engine
from plumbline.harness.scene import Scene
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import State
from tests.unit.test_importers_exactness import at_a_state, random_tree, rotors

pytestmark = pytest.mark.usefixtures("both_coordinates")

G, ROTOR, LOSS = 9.81, 3.0, 1.5


def _hung(name: str, y: float, **along: float) -> tuple[engine.Body, engine.Revolute]:
    """A rod of 1 m and 2 kg, moment .2 kg m2, let go level about the axis y; its centre at its end."""
    body = engine.Body(name=name, mass=2.0, inertia=0.2 * np.eye(3), p_WB=(1.0, y, 2.0))
    pin = engine.Revolute(
        name=f"pin {name}", parent=engine.WORLD, child=name, anchor_W=(0.0, y, 2.0), axis_W=(0.0, 1.0, 0.0), **along
    )
    return body, pin


@pytest.mark.parametrize("rods", [1, 2], ids=["one machine", "islands"])
def test_rotors_and_dry_friction_keep_their_laws_in_a_world_with_contacts(rods: int) -> None:
    """(I + m l^2 + A) a'' = m g l cos a - f from level, beside a ball that rests: by sub-steps of 1/960 s, which err by half
    a step of motion, 3 m/s / 1920."""
    ground = engine.Body(name="ground", motion="static", shapes=(engine.Placed(engine.Plane()),))
    ball = engine.Body(name="ball", p_WB=(5.0, 5.0, 0.1), shapes=(engine.Placed(engine.Sphere(0.1)),))
    hung = [_hung(f"rod{k}", float(k), armature=ROTOR, friction_loss=LOSS) for k in range(rods)]
    world = engine.World(
        [ground, ball, *(body for body, _ in hung)],
        [pin for _, pin in hung],
        {("default", "default"): engine.Surface()},
        options=engine.Options(),
    )
    world.step(120)

    def rate(_time: float, y: np.ndarray) -> tuple[float, float]:
        return y[1], (2.0 * G * math.cos(y[0]) - LOSS) / (2.2 + ROTOR)

    angle, speed = solve_ivp(rate, (0, 0.5), (0.0, 0.0), rtol=1e-11, atol=1e-12).y[:, -1]
    for state in world.state()[2:]:
        assert state[[0, 2]] == pytest.approx((math.cos(angle), 2.0 - math.sin(angle)), abs=3 / 1920)
        assert state[11] == pytest.approx(speed, abs=0.01)


def _end(scene: Scene, track: str, **settings: object) -> np.ndarray:
    adapter = plugins.adapter("reference")
    simulation = adapter.build(scene, chosen := replace(adapter.tracks[track], **settings))  # type: ignore[arg-type]
    simulation.step(round(0.25 / chosen.dt))
    out = State.empty(len(scene.bodies))
    simulation.state(out)
    return out.p_WB


@pytest.mark.parametrize("rotor", [0.2, 20.0])
def test_rotors_in_space_converge_at_first_order_under_shake_however_heavy(tmp_path: Path, rotor: float) -> None:
    """Against Runge-Kutta, exact to 1e-9 here; the tree has slides on turning links, and stops far from where it goes."""
    path = tmp_path / "tree.urdf"
    path.write_text(random_tree(11))
    scene = rotors(at_a_state(path, np.random.default_rng(2))[0], rotor)
    truth = _end(scene, "tuned", integrator="rk4", dt=1 / 4000)
    coarse, fine = (float(np.abs(_end(scene, "default", dt=1 / n) - truth).max()) for n in (240, 480))
    # An order of one halves the error; the next term is a share of a per cent of it here.
    assert fine == pytest.approx(coarse / 2, rel=0.05)


def test_runge_kutta_is_refused_beside_dry_friction() -> None:
    body, pin = _hung("rod", 0.0, friction_loss=LOSS)
    with pytest.raises(engine.NotSupported, match="dry friction in a joint"):
        engine.World([body], [pin], options=engine.Options(integrator="rk4"))


@pytest.mark.parametrize("field", ["armature", "friction_loss"])
def test_a_negative_rotor_or_dry_friction_is_refused(field: str) -> None:
    with pytest.raises(ValueError, match=field):
        _hung("rod", 0.0, **{field: -1.0})
