"""The processes that come off fork servers: some servers have the numeric libraries alone, some an engine that loads slowly.

A version of an engine that has an environment of its own has servers on the interpreter of that one.

Off such a server a process starts in milliseconds, where loading an engine takes up to two tenths of a second. An engine is in
its own server alone: a library may set the mode of floating-point arithmetic, or take signals, when it is loaded, and no other
engine is to feel that.

What comes off one server has everything at the same place in memory, in another run of the study at another. An engine's speed
can feel that: MuJoCo's and DART's steps of a pendulum were spread by 2 % over eight interpreters and under 1 % over eight
forks of one. What is to show such chance, clocks and repetitions, therefore asks for processes off several servers.

Environment variables that libraries read as they are loaded act on processes off a server that was born with them.
"""

import atexit
import os
import pickle
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from typing import Any

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.case.alteration import Variables
from plumbline.harness.intake.bounded import absolute, end_with_started
from plumbline.harness.scene import Imu
from plumbline.harness.study import plugins, sources
from plumbline.harness.study.environments import Environment, project_folders

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
_PRELOAD = ("plumbline.harness.cli.main", "plumbline.harness.run.timing_protocol", "plumbline.harness.run.isolated", "numpy")
_TRIES = 2
"""Servers that a process is asked of, one after the other, where they die."""
_LEAVES = 3.0
"""Seconds that a process may take to end after its last word."""

WORTH_A_SERVER = 10
"""Processes of an engine from which on a server of its own saves more than it costs.

CPU seconds to start one, over what each process then saves: MuJoCo's 0.65 / 0.09, DART's 0.6 / 0.04, our own 0.95 / 0.35.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """The fork server that a process is to come off.

    Terms: modules: of an engine, that it has loaded. number: another number, another layout in memory. only: whose server it
    is, beside that of all others; '' for theirs. environment: whose interpreter it is on; None for this one. variables: that it
    was born with, beside those of this process.
    """

    modules: tuple[str, ...] = ()
    number: int = 0
    only: str = ""
    environment: Environment | None = None
    variables: Variables = ()


@dataclass(slots=True)
class Forked:
    """A process off a fork server, as seen from here.

    Terms: server: the number of its fork server, of this origin. pipe: to it and from it. status: here its server says how it
    ended. code: its exit code, below zero for the signal that killed it; None as long as that is unknown. lost: its server died
    before it told.
    """

    pid: int
    server: int
    origin: Origin
    pipe: Connection
    status: Connection
    code: int | None = None
    lost: bool = False

    def join(self, seconds: float | None) -> bool:
        """Has it ended within so many seconds, or, with None, at last?"""
        if self.code is None and not self.lost and self.status.poll(seconds):
            try:
                self.code = int(self.status.recv_bytes())
            except (EOFError, ConnectionError):
                self.lost = True
        return self.code is not None or self.lost

    def exit_code(self) -> int | None:
        """Its code once it has said its last word; a process that lives on is ended. None where it is lost."""
        if not self.join(_LEAVES):
            self.end()
        return self.code

    def kill(self) -> None:
        """End the process, however deaf it is."""
        if not self.join(0.0):
            with suppress(ProcessLookupError):
                os.kill(self.pid, signal.SIGKILL)

    def end(self) -> None:
        """End the process, every other one that was started in it, and a server that it has for itself.

        Where it has ended by itself, those that left its group have escaped; `end_started` is for them.
        """
        end_with_started(self.pid, running=not self.join(0.0))
        self.join(None)
        if self.origin.only:
            end_servers([self.origin])


class ForkServer:
    """A fork server, as seen from here; several threads may order at once."""

    def __init__(self, origin: Origin) -> None:
        """Raises: OSError."""
        self._origin, self._ordering = origin, threading.Lock()
        self._orders, theirs = socket.socketpair()
        with theirs:
            self._process = _born(origin, theirs)

    def fork(self, function: Callable[..., object], arguments: Sequence[object]) -> Forked:
        """A process in which a function of a module is called, with a pipe and these arguments. Raises: ConnectionError."""
        (pipe, theirs), (status, tells) = Pipe(), Pipe()  # sockets: a pipe could be opened by its child, under /proc
        with theirs, tells, self._ordering:
            if self._orders.fileno() < 0:
                raise ConnectionError("a fork server was ended")
            socket.send_fds(self._orders, [b"f"], [theirs.fileno(), tells.fileno()])
        try:
            process = Forked(int(status.recv_bytes()), self._process.pid, self._origin, pipe, status)
        except EOFError:
            raise ConnectionError("a fork server died") from None
        with suppress(ConnectionError):  # one that has died says so by its end
            pipe.send_bytes(pickle.dumps((_here(), _path(self._origin), pickle.dumps((function, arguments)))))
        return process

    def end(self) -> None:
        """End it; its processes end with it."""
        self._process.kill()
        self._process.wait()
        with self._ordering:
            self._orders.close()


def expect(modules: Sequence[str]) -> None:
    """Have these loaded in every server that starts from now on: what a run's processes would load one by one."""
    _expected[:] = modules


_expected: list[str] = []
_listed = threading.RLock()
"""Held by who looks for a server, or takes one off the list."""
_servers: dict[Origin, ForkServer] = {}
_deadly: set[Origin] = set()
"""Those whose modules kill a server."""


def loaded(modules: tuple[str, ...], foreseen: int, environment: Environment | None = None) -> Origin:
    """Where a process comes off in which these modules are loaded already, where that can be done and pays.

    Args: foreseen: how many processes will want them; few start off the plain server, unless theirs is there.
    """
    own = Origin(modules=modules, environment=environment)
    pays = own in _servers or (foreseen >= WORTH_A_SERVER and own not in _deadly)
    return own if modules and pays else replace(own, modules=())


def start(origin: Origin, function: Callable[..., object], *arguments: object) -> Forked:
    """Call a function of a module in a process of its own, with the process's end of a pipe and these arguments, pickled.

    A server that has died is followed by a new one. One that dies of its modules is given up: its processes come off the plain
    one, and meet what is wrong themselves.
    Raises: OSError; ConnectionError, where new servers die as well.
    """
    for _ in range(_TRIES):
        with _listed:
            server = _servers[origin] = _servers.get(origin) or ForkServer(origin)
        try:
            return server.fork(function, arguments)
        except ConnectionError:
            with _listed:
                if _servers.get(origin) is server:
                    end_servers([origin])
    if not origin.modules:
        raise ConnectionError(f"a process could not be started: its fork server died, {_TRIES} times")
    _deadly.add(origin)
    return start(replace(origin, modules=()), function, *arguments)


def end_servers(origins: Iterable[Origin]) -> None:
    """End these servers, where they are, with all that came off them."""
    for origin in origins:
        with _listed:
            server = _servers.pop(origin, None)
        if server is not None:
            server.end()


@atexit.register
def _end_all() -> None:
    """A process that was forked from this one has servers of its own."""
    if _ours == os.getpid():
        end_servers([*_servers])


_ours = os.getpid()


def _born(origin: Origin, orders: socket.socket) -> Any:
    """The process of a server. Numeric libraries use one thread in it."""
    environment, path = origin.environment, _path(origin)
    variables = os.environ | dict.fromkeys(_THREADS, "1") | dict(origin.variables)
    if sys.dont_write_bytecode:
        variables["PYTHONDONTWRITEBYTECODE"] = "1"
    if environment is not None:
        variables["PYTHONPATH"] = os.pathsep.join(project_folders())
    server = "from plumbline.harness.run.fork_server import main"
    command = f"import sys; sys.path[:] = {path!r}; {server}; main({orders.fileno()}, {_preload(origin)!r})"
    return subprocess.Popen(
        [sys.executable if environment is None else environment.executable, "-c", command],
        env=variables,
        stdin=subprocess.DEVNULL,
        pass_fds=[orders.fileno()],
    )


def _path(origin: Origin) -> list[str]:
    """Where a process of this origin looks for modules: as this one does, in an environment's own folders before."""
    path, environment = absolute(sys.path), origin.environment
    return path if environment is None else list(dict.fromkeys([*project_folders(), *environment.path, *path]))


def _preload(origin: Origin) -> list[str]:
    """All that a server loads."""
    return [*_PRELOAD, *_expected, *origin.modules]


def _here() -> Path:
    """The present folder, where it is still there."""
    with suppress(FileNotFoundError):
        return Path.cwd()
    return Path("/")


_QUESTIONS = (
    "plumbline.cases",
    "plumbline.harness.metric",
    "plumbline.harness.metrics",
    "plumbline.harness.props",
    "plumbline.harness.sensors",
    "plumbline.harness.truths",
)
"""Where SciPy is imported within functions, so that a listing need not wait for it, and where trials call them."""
_OWN_SCENE = "plumbline.harness.case.scene_file"
_NOISE = "plumbline.harness.sensors.imu"
"""What every scene of a user's own imports and inertial units alone call: its filter costs as much as all else together."""


def preloads(cases: Mapping[str, Case], engines: Mapping[str, Adapter]) -> tuple[str, ...]:
    """The modules of built-in cases and adapters, those of SciPy that the cases name, and the compiler of our own engine.

    A third party's modules are left to its processes: one that dies of them takes no server along. A vendor's package is in
    the server of its engine alone (`Adapter.loads`).
    """
    questions = [module for name in cases if (module := _built_in("cases", name))]
    adapters = [module for name in engines if (module := _built_in("adapters", name))]
    asked = [module for module in sources.closure(questions) if module.startswith(tuple(f"{room}." for room in _QUESTIONS))]
    scenes = (case.scene(case.parameters) for case in cases.values())
    if _NOISE in asked and not any(isinstance(sensor, Imu) for scene in scenes for sensor in scene.sensors):
        asked = [module for module in asked if module != _NOISE]
    compiled = any(module.startswith("plumbline.engine.") for engine in engines.values() for module in engine.loads)
    builders = [f"{module}.build" for module in adapters]
    return (*questions, *adapters, *builders, *sorted(sources.named(asked, "scipy")), *(["numba"] if compiled else []))


def _built_in(kind: str, name: str) -> str | None:
    """The module of a built-in plug-in; None for a third party's."""
    if name.startswith(plugins.SCENE_PREFIX):
        return _OWN_SCENE
    module = plugins.module_of(kind, name)
    return module if module is not None and module.startswith(f"plumbline.{kind}.") else None
