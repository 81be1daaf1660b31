"""A third party's plug-ins: a sound engine that knows free fall, the same engine with one way of dying each, and a case."""

import ctypes
import os
import sys
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from harness.adapter import Adapter, Feature, Settings, Unavailable, Unsupported
from harness.case import Case, Check
from harness.metrics import position
from harness.scene import Body, Camera, Scene
from harness.trajectory import Contacts, Floats, Hits, Image, State, Trajectory

POSITION = next(metric for metric in position.METRIC if metric.name == "position_error_max")


class Falling:
    """Semi-implicit Euler of bodies in free fall; at `fatal_step` it does what `fault` says."""

    def __init__(self, scene: Scene, settings: Settings, fault: str, fatal_step: int = 20) -> None:
        self.resolved, self._dt, self._gravity = settings, settings.dt, np.array(scene.gravity)
        self._state, self._fault, self._fatal, self._steps = State.initial(scene), fault, fatal_step, 0

    def step(self, count: int = 1) -> None:
        for _ in range(count):
            self._steps += 1
            if self._steps == self._fatal:
                self._die()
            self._state.v_WB[:] += self._gravity * self._dt
            self._state.p_WB[:] += self._state.v_WB * self._dt

    def _die(self) -> None:
        if self._fault == "segfault":
            print("about to read address zero", file=sys.stderr, flush=True)
            ctypes.string_at(0)
        elif self._fault == "abort":
            os.abort()
        elif self._fault == "vanish":
            os._exit(0)
        elif self._fault == "hang":
            ctypes.PyDLL(None).sleep(600)
        elif self._fault == "hoard":
            self._hoard = [np.ones(2**27) for _ in range(64)]
        elif self._fault == "raise":
            raise RuntimeError("the engine's own exception")
        elif self._fault == "flood":
            line = b"the same line again\n" * 50_000
            for _ in range(1000):
                os.write(2, line)
            os.abort()
        elif self._fault == "nan":
            self._state.v_WB[0, 0] = np.nan

    def state(self, out: State) -> None:
        for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
            getattr(out, name)[:] = getattr(self._state, name)

    def contacts(self) -> Contacts:
        raise Unsupported("contacts", "nothing touches here")

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        raise Unsupported("rays", "there is no geometry")

    def render(self, camera: Camera, colour: bool = True) -> Image:
        raise Unsupported("images", "there is no geometry")

    def command(self, targets: dict[str, float]) -> None:
        raise Unsupported("drives", "there are no joints")

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        raise Unsupported("forces", "bodies only fall")

    def warnings(self) -> tuple[str, ...]:
        return ()

    def save(self) -> object:
        raise Unsupported("saving", "not needed here")

    def restore(self, saved: object) -> None:
        raise Unsupported("saving", "not needed here")

    def close(self) -> None:
        pass


_built: set[str] = set()
"""Engines that this process has built once already."""


@dataclass(frozen=True, kw_only=True)
class Faulty(Adapter):
    """The falling engine with one fault, or with one that a process meets when it builds it again."""

    title: str = "falling bodies"
    distribution: str = "faulty"
    features: Feature = Feature.NONE
    tracks: dict[str, Settings] = field(default_factory=lambda: {"default": Settings(), "tuned": Settings()})
    fault: str = ""
    fault_again: str = ""
    compilation: float = 0.0

    def version(self) -> str:
        if self.fault == "absent":
            raise Unavailable("not installed: pip install nothing")
        return "1.0"

    def compile(self, scene: Scene, settings: Settings) -> None:
        time.sleep(self.compilation)

    def build(self, scene: Scene, settings: Settings) -> Any:
        fault = self.fault_again if self.name in _built else self.fault
        _built.add(self.name)
        return Falling(scene, settings, fault)


SOUND = Faulty(name="sound")
SEGFAULT = Faulty(name="segfault", fault="segfault")
ABORT = Faulty(name="abort", fault="abort")
VANISH = Faulty(name="vanish", fault="vanish")
HANG = Faulty(name="hang", fault="hang")
HOARD = Faulty(name="hoard", fault="hoard")
RAISE = Faulty(name="raise", fault="raise")
FLOOD = Faulty(name="flood", fault="flood")
NAN = Faulty(name="nan", fault="nan")
COMPILE = Faulty(name="compile", compilation=5.0, compile_allowance=60.0)
COMPILE_HANG = Faulty(name="compile_hang", fault="hang", compilation=1.0, compile_allowance=60.0)
ABSENT = Faulty(name="absent", fault="absent")
SEGFAULT_AGAIN = Faulty(name="segfault_again", fault_again="segfault")
HANG_AGAIN = Faulty(name="hang_again", fault_again="hang")
RAISE_AGAIN = Faulty(name="raise_again", fault_again="raise")


def _scene() -> Scene:
    return Scene(bodies=(Body(name="ball", v_WB=(1.0, 0.0, 0.0)),))


def _truth(time: Floats) -> Trajectory:
    truth = Trajectory.of(time, 1)
    truth.p_WB[:, 0, 0] = time
    truth.p_WB[:, 0, 2] = -9.81 * time**2 / 2
    truth.v_WB[:, 0, 0] = 1.0
    truth.v_WB[:, 0, 2] = -9.81 * time
    return truth


CASE = Case(
    name="stress_fall",
    title="Free fall of a ball",
    question="Does a ball fall half g t squared?",
    source="Galilei",
    truth="closed form",
    scene=_scene,
    expected=_truth,
    checks=(
        Check(
            metric=POSITION,
            at_most=lambda dt: 9.81 * dt * 0.5 / 2 * 1.001,
            because="semi-implicit Euler errs by g dt t/2 at t = 0.5 s; a thousandth on top for rounding",
        ),
    ),
    duration=0.5,
    headline="position_error_max",
)
