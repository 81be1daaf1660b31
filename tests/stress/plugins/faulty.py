"""A third party's plug-ins: a sound engine that knows free fall, the same engine with one way of dying each, and a case."""

import ctypes
import os
import pickle
import signal
import struct
import subprocess
import sys
import time
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from plumbline.harness.adapter import Adapter, Feature, Settings, Unavailable, Unsupported
from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.metrics import errors
from plumbline.harness.scene import Body, Camera, Scene
from plumbline.harness.trajectory import Contacts, Floats, Hits, Image, State, Trajectory

POSITION = errors.position_error_max


SLEEP = "86399.25"
"""Seconds that the process sleeps which an engine leaves behind: by them it is found."""


class _Command:
    """What runs a command in whoever opens its pickle."""

    def __reduce__(self) -> tuple[Any, ...]:
        return os.system, (f"touch {os.environ.get('PICKLED', '/dev/null')}",)


def _framed(content: bytes) -> bytes:
    """As Python's own pipes put a pickle."""
    return struct.pack("!i", len(content)) + content


TOLD: dict[str, bytes] = {
    "garbage": b"\x80\x05\x95 no pickle\n\xff\xfe\n",
    "pickle": _framed(pickle.dumps(_Command())),
    "pickle_line": pickle.dumps(_Command(), protocol=0).replace(b"\n", b" ") + b"\n",
    "long_line": b"1" * (5 * 2**20),
    "half_a_line": b'{"record": ',
    "deep": b"[" * 100_000 + b"\n",
    "other_kind": b'{"steps": 5}\n',
    "no_status": b'{"record": {"status": "splendid", "reason": "trust me"}}\n',
    "long_number": b'{"record": ' + b"9" * 6000 + b"}\n",
    "two_kinds": b'{"record": {}, "sample": {}}\n',
}
"""What an engine tells the process that started it, in the adapter's name."""


def _pipe_to_main() -> Connection:
    """The end of the pipe that the harness's own frames hold."""
    frame: Any = sys._getframe()
    while not isinstance(frame.f_locals.get("pipe"), Connection):
        frame = frame.f_back
    pipe: Connection = frame.f_locals["pipe"]
    return pipe


def busy_for(seconds: float) -> None:
    """Take so much CPU time."""
    until = time.process_time() + seconds
    while time.process_time() < until:
        pass


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
        elif self._fault == "surrogate":
            raise RuntimeError("half a letter: \udc80, a colour: \x1b[31m")
        elif self._fault == "real_time":
            os.kill(os.getpid(), signal.SIGRTMIN + 3)
        elif self._fault == "orphan":
            subprocess.Popen(["sleep", SLEEP], stdin=subprocess.DEVNULL)
        elif self._fault == "round":
            self._state.v_WB[0, 2] = np.nextafter(self._state.v_WB[0, 2], 0.0)
        elif self._fault == "norm_3":
            self._state.q_WB[0] = (3.0, 0.0, 0.0, 0.0)
        elif self._fault == "norm_0":
            self._state.q_WB[0] = 0.0
        elif self._fault == "count":
            self.resolved = replace(self.resolved, iterations=np.int64(5))
        elif self._fault == "slow":
            time.sleep(0.4)
        elif self._fault == "work":
            busy_for(2.1)
        elif self._fault == "patricide":
            os.kill(os.getppid(), signal.SIGKILL)
            time.sleep(60)
        elif self._fault in TOLD:
            os.write(_pipe_to_main().fileno(), TOLD[self._fault])
            if self._fault == "half_a_line":
                time.sleep(600)

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

    def warnings(self) -> tuple[Any, ...]:
        return (b"bytes", 5) if self._fault == "warning" else ()

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


@dataclass(frozen=True, kw_only=True)
class Swayed(Faulty):
    """The falling engine whose fault an environment variable names, as other variables name the code of a library."""

    def build(self, scene: Scene, settings: Settings) -> Any:
        return Falling(scene, settings, os.environ.get("SWAYED", ""))


SOUND = Faulty(name="sound")
SWAYED = Swayed(name="swayed")
SEGFAULT = Faulty(name="segfault", fault="segfault")
ABORT = Faulty(name="abort", fault="abort")
VANISH = Faulty(name="vanish", fault="vanish")
HANG = Faulty(name="hang", fault="hang")
HOARD = Faulty(name="hoard", fault="hoard")
RAISE = Faulty(name="raise", fault="raise")
FLOOD = Faulty(name="flood", fault="flood")
NAN = Faulty(name="nan", fault="nan")
COMPILE = Faulty(name="compile", compilation=5.0, compile_allowance=60.0)
LOADING_SLOWLY = Faulty(name="loading_slowly", fault="work", loads=("slow_to_load",))
COMPILE_HANG = Faulty(name="compile_hang", fault="hang", compilation=1.0, compile_allowance=60.0)
ABSENT = Faulty(name="absent", fault="absent")
SURROGATE = Faulty(name="surrogate", fault="surrogate")
REAL_TIME = Faulty(name="real_time", fault="real_time")
ORPHAN = Faulty(name="orphan", fault="orphan")
NORM_3 = Faulty(name="norm_3", fault="norm_3")
NORM_0 = Faulty(name="norm_0", fault="norm_0")
COUNT = Faulty(name="count", fault="count")
WARNING = Faulty(name="warning", fault="warning")
GARBAGE = Faulty(name="garbage", fault="garbage")
PICKLE = Faulty(name="pickle", fault="pickle")
PICKLE_LINE = Faulty(name="pickle_line", fault="pickle_line")
LONG_LINE = Faulty(name="long_line", fault="long_line")
HALF_A_LINE = Faulty(name="half_a_line", fault="half_a_line")
DEEP = Faulty(name="deep", fault="deep")
OTHER_KIND = Faulty(name="other_kind", fault="other_kind")
NO_STATUS = Faulty(name="no_status", fault="no_status")
LONG_NUMBER = Faulty(name="long_number", fault="long_number")
TWO_KINDS = Faulty(name="two_kinds", fault="two_kinds")
SLOW = Faulty(name="slow", fault="slow")
LOADING = Faulty(name="loading", fault="slow", loads=("xml.dom.pulldom",))
PATRICIDE = Faulty(name="patricide", fault="patricide")
SEGFAULT_AGAIN = Faulty(name="segfault_again", fault_again="segfault")
HANG_AGAIN = Faulty(name="hang_again", fault_again="hang")
RAISE_AGAIN = Faulty(name="raise_again", fault_again="raise")


def _scene(_: Parameters) -> Scene:
    return Scene(bodies=(Body(name="ball", v_WB=(1.0, 0.0, 0.0)),))


def _truth(time: Floats, _: Parameters) -> Trajectory:
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
            at_most=lambda dt, _: 9.81 * dt * 0.5 / 2 * 1.001,
            because="semi-implicit Euler errs by g dt t/2 at t = 0.5 s; a thousandth on top for rounding",
        ),
    ),
    duration=0.5,
    headline="position_error_max",
)
