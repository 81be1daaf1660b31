"""A third party's plug-in: an engine whose error and whose price are both planted, so that the price of an error is known.

It flies bodies that nothing touches along their parabolas exactly and puts each answer off by `coefficient` * dt^`order` [m]
from the first step on. A step costs `spin` [us] of CPU time, burnt in a loop.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from plumbline.harness.adapter import Adapter, Feature, Settings, SettingsError, TradeOff, Unsupported
from plumbline.harness.scene import Effect, Scene
from plumbline.harness.trajectory import State

ASIDE = np.array([1.0, 0.0, 0.0])
"""Across gravity, so that the planted error does not enter the energy."""
COARSE, COARSE_ERROR = 1 / 60, 0.02
"""The step [s] at which every law of the tracks errs by so much [m]."""


def options(order: int, spin: float) -> Mapping[str, float]:
    return {"order": order, "coefficient": COARSE_ERROR / COARSE**order, "spin": spin}


class Spinning:
    """x = x0 + v0 t + g t^2/2 + (coefficient dt^order, 0, 0)."""

    def __init__(self, scene: Scene, settings: Settings) -> None:
        self._start, self._steps, self._dt = State.initial(scene), 0, settings.dt
        self._gravity = np.array(scene.gravity) * (Effect.GRAVITY in scene.effects)
        order, coefficient, spin = (settings.options[name] for name in ("order", "coefficient", "spin"))
        self.resolved = replace(settings, integrator=f"order_{order}")
        self._offset, self._spin = coefficient * settings.dt**order * ASIDE, 1e-6 * spin

    def step(self, count: int = 1) -> None:
        """The deadlines run on, so that a loop that ends late in one step ends early in the next: the mean is the spin.

        What is above it, once a call and not once a step, is the call itself and at most one look at the clock.
        """
        deadline = time.process_time()
        for _ in range(count):
            deadline += self._spin
            while time.process_time() < deadline:
                pass
        self._steps += count

    def state(self, out: State) -> None:
        t, off = self._steps * self._dt, self._offset * (self._steps > 0)
        out.p_WB[:] = self._start.p_WB + self._start.v_WB * t + self._gravity * t**2 / 2 + off
        out.v_WB[:] = self._start.v_WB + self._gravity * t
        out.q_WB[:], out.w_WB[:] = self._start.q_WB, 0.0

    def warnings(self) -> tuple[str, ...]:
        return ()

    def close(self) -> None:
        pass

    def __getattr__(self, name: str) -> Any:
        """Contacts, rays, images, drives, forces, saving."""
        if name.startswith("_"):
            raise AttributeError(name)

        def refuse(*_: object) -> None:
            raise Unsupported(name, "bodies only fly here")

        return refuse


@dataclass(frozen=True, kw_only=True)
class Spinner(Adapter):
    """The engine; `spin` [us] is what a step costs on its tracks, `tuned` the order of that track; 'default' has the first."""

    spin: float
    tuned: int = 2
    title: str = "planted error and price"
    distribution: str = "spinner"
    features: Feature = Feature.NONE
    tracks: Mapping[str, Settings] = field(init=False)
    orders: Mapping[str, int] = field(default_factory=lambda: {"order_1": 1, "order_2": 2, "order_4": 4})

    def __post_init__(self) -> None:
        tracks = {"default": Settings(options=options(1, self.spin)), "tuned": Settings(options=options(self.tuned, self.spin))}
        object.__setattr__(self, "tracks", tracks)

    def version(self) -> str:
        return "1.0"

    def build(self, scene: Scene, settings: Settings) -> Any:
        if settings.options.keys() != {"order", "coefficient", "spin"}:
            raise SettingsError(f"settings: options {sorted(settings.options)}, expected coefficient, order and spin")
        if scene.joints or any(body.collision or body.motion != "dynamic" or any(body.w_WB) for body in scene.bodies):
            raise Unsupported("shapes, joints, rotation", "bodies only fly here")
        return Spinning(scene, settings)


@dataclass(frozen=True, kw_only=True)
class Beaten(Spinner):
    """An engine whose track 'tuned' is beaten by planted turns of its knobs; the knob 'colour' is idle, 'shade' is refused."""

    offset: float = 0.0
    knobs: Mapping[str, tuple[Any, ...]] = field(
        default_factory=lambda: {
            "options.spin": (50.0, 20.0, 30.0, 45.0, 5000.0),
            "options.offset": (0.0, 0.001, 100.0),
            "options.colour": ("red", "blue"),
            "options.shade": ("dark",),
        }
    )
    trade_offs: tuple[TradeOff, ...] = (
        TradeOff(cases=("flight_projectile",), knob="options.spin", values=(30.0,), why="planted"),
        TradeOff(cases=("flight_projectile",), knob="options.shade", why="never needed"),
    )

    def __post_init__(self) -> None:
        tracks = {name: Settings(options={"spin": self.spin, "offset": self.offset}) for name in ("default", "tuned")}
        object.__setattr__(self, "tracks", tracks)

    def build(self, scene: Scene, settings: Settings) -> Any:
        if "shade" in settings.options:
            raise SettingsError("settings: option shade, expected none")
        planted = {"order": 0, "coefficient": settings.options["offset"], "spin": settings.options["spin"]}
        return super().build(scene, replace(settings, options=planted))


SPINNER = Spinner(name="spinner", spin=20.0)
LAGGARD = Spinner(name="laggard", spin=60.0)
DETUNED = Spinner(name="detuned", spin=20.0, tuned=0)
BEATEN = Beaten(name="beaten", spin=50.0)
FAILING = Beaten(name="failing", spin=50.0, offset=100.0)
