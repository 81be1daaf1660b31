"""What a planted fault does: to an answer, to its process, to the machine around it."""

import ctypes
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plumbline.harness.trajectory import State

SLEEP = "86398.75"
"""Seconds that a process sleeps which the engine leaves behind: by them it is found."""
NAN, INF, HUGE = float("nan"), float("inf"), 1e200
MIDDLE = 25
"""The step, of fifty, at which most faults come."""


@dataclass(frozen=True)
class Fault:
    """One fault. Terms: method: that that is wrong. change: of its answer. status, reason: what has to come of it."""

    family: str
    name: str
    place: str
    change: Callable[..., Any]
    status: str
    reason: str

    @property
    def variant(self) -> str:
        """Its name as a variant of the study."""
        return f"{self.family}_{self.name}"


def told(attribute: str, value: Any) -> Callable[[Any], Any]:
    """An answer with another value in one attribute."""
    return lambda answer: replace(answer, **{attribute: value})


def marred(attribute: str, value: float) -> Callable[[Any], Any]:
    """An answer with one number of an array changed."""

    def change(answer: Any) -> Any:
        array = np.array(getattr(answer, attribute))
        array.flat[0] = value
        return replace(answer, **{attribute: array})

    return change


def state(name: str, value: Any, row: int = 0, first: int = MIDDLE, last: int = 10**9) -> Callable[[State, int], None]:
    """A number of the state from one step on, or up to another."""

    def change(out: State, step: int) -> None:
        if first <= step <= last:
            getattr(out, name)[row] = value

    return change


def raising(error: BaseException) -> Callable[..., Any]:
    """Raise it."""

    def change(*_: Any) -> Any:
        raise error

    return change


def die(number: int) -> Callable[..., Any]:
    """Die of a signal."""

    def change(*_: Any) -> Any:
        signal.signal(number, signal.SIG_DFL) if number not in (signal.SIGKILL, signal.SIGSTOP) else None
        os.kill(os.getpid(), number)
        time.sleep(60)

    return change


def doing(*deeds: Callable[[], Any]) -> Callable[..., Any]:
    """Do something, one after the other, and go on."""

    def change(answer: Any = None, *_: Any) -> Any:
        for deed in deeds:
            deed()
        return answer

    return change


class Mute(Exception):
    """An exception that cannot be told."""

    def __str__(self) -> str:
        raise RuntimeError("no words")


class Endless(BaseException):
    """What no `except Exception` catches."""


def deaf() -> None:
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)


def child(**more: Any) -> Callable[[], Any]:
    return lambda: subprocess.Popen(["sleep", SLEEP], stdin=subprocess.DEVNULL, **more)


def daemon() -> None:
    """A process whose parent is gone, in a session of its own."""
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            os.execvp("sleep", ["sleep", SLEEP])
        os._exit(0)
    os.wait()


def held() -> None:
    ctypes.PyDLL(None).sleep(600)


def malloc(piece: int, most: int) -> Callable[[], None]:
    """Take memory in C, piece by piece, never to be used; abort where there is none."""

    def take() -> None:
        libc = ctypes.CDLL(None)
        libc.malloc.restype = ctypes.c_void_p
        for _ in range(most):
            if libc.malloc(ctypes.c_size_t(piece)) is None:
                os.abort()
        time.sleep(5)

    return take


def filled() -> None:
    libc = ctypes.CDLL(None)
    libc.malloc.restype = ctypes.c_void_p
    while True:
        place = libc.malloc(ctypes.c_size_t(2**26))
        ctypes.memset(place, 1, 2**26)


def hungry_child() -> None:
    script = "import time; hoard = [bytearray(b'1' * 2**24) for _ in range(40)]; time.sleep(60)"
    subprocess.Popen([sys.executable, "-c", script], stdin=subprocess.DEVNULL)
    time.sleep(30)


def worded(text: str) -> Callable[[], None]:
    """Say something on standard error and abort."""

    def speak() -> None:
        os.write(2, text.encode())
        os.abort()

    return speak


def linger() -> None:
    threading.Thread(target=time.sleep, args=(60,), daemon=False).start()


def twin() -> None:
    """From here on there are two of this process, and both answer."""
    os.fork()


def loop() -> dict[str, Any]:
    found: dict[str, Any] = {}
    found["itself"] = found
    return found


def deep() -> None:
    deep()
