"""Shared fork servers with the numeric libraries, and one for each engine that loads slowly.

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
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import forkserver, resource_tracker, spawn
from multiprocessing.context import ForkServerContext
from multiprocessing.process import BaseProcess
from typing import Any

from plumbline.harness.case.alteration import Variables
from plumbline.harness.study.environments import Environment, project_folders

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
_PRELOAD = ("plumbline.harness.cli.main", "plumbline.harness.run.timing_protocol", "plumbline.harness.run.isolated", "numpy")
_FIRST, _LAST = "plumbline.harness.run.gc_off", "plumbline.harness.run.gc_freeze"
_TRIES = 2
"""Servers that a process is asked of, one after the other, where they die."""
_UNTOLD = 255
"""What Python says where a server died before it told how a process of its ended."""
_FALLS = 1.0
"""Seconds that a server which was killed may take to be gone."""

WORTH_A_SERVER = 10
"""Processes of an engine from which on a server of its own saves more than it costs.

CPU seconds to start one, over what each process then saves: MuJoCo's 0.65 / 0.09, DART's 0.6 / 0.04, our own 0.95 / 0.35.
"""


def context() -> ForkServerContext:
    """Processes off the server that knows no engine, to be started by `start_loaded` or `start_apart`."""
    plain = multiprocessing.get_context("forkserver")
    plain.set_forkserver_preload(_preload(()))
    return plain


def expect(modules: Sequence[str]) -> None:
    """Have these loaded in every server that starts from now on: what a run's processes would load one by one."""
    _expected[:] = modules


_expected: list[str] = []


def _preload(modules: Sequence[str]) -> list[str]:
    """All that a server loads, these of its own among it."""
    return [_FIRST, *_PRELOAD, *_expected, *modules, _LAST]


@dataclass(frozen=True, slots=True)
class Server:
    """A server as it was when a process came off it. Terms: pid: of the server."""

    pid: int

    @property
    def ended(self) -> bool:
        """Is it gone? Whoever starts processes buries it; here it is only looked at."""
        try:
            return os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
        except ChildProcessError:
            return True

    def took_along(self, process: BaseProcess) -> bool:
        """Has this process, which has ended, ended with the server? Nobody knows its exit code then."""
        return process.exitcode == _UNTOLD and self._ends(_FALLS)

    def _ends(self, seconds: float) -> bool:
        """Is it gone within so many seconds?"""
        until = time.monotonic() + seconds
        while not self.ended:
            if time.monotonic() > until:
                return False
            time.sleep(0.01)
        return True


def start_loaded(
    process: BaseProcess, modules: tuple[str, ...], foreseen: int, environment: Environment | None = None
) -> Server:
    """Start a process of `context` in which these modules are loaded already, where that can be done and pays.

    Args: foreseen: how many processes will want them; few start off the plain server, unless theirs is there.
    environment: whose interpreter it is to run on; None for this one.
    A server that dies of its modules is given up: its processes start off the plain one, and meet what is wrong themselves.
    Raises: OSError.
    """
    key = environment, modules
    if modules and (key in _servers or foreseen >= WORTH_A_SERVER):
        if key not in _servers:
            _servers[key] = _new_server(modules)
        server = _servers[key]
        try:
            if server is not None:
                return _start(process, server, environment)
        except ConnectionError:
            _servers[key] = None
    return start_apart(process, 0, environment=environment)


def start_apart(
    process: BaseProcess, number: int, only: str = "", environment: Environment | None = None, variables: Variables = ()
) -> Server:
    """Start a process of `context` off the server of this number, which knows no engine: another number, another layout.

    Args: number: 0 for the one that `context` has anyway. only: whose server it is, beside that of all others; '' for theirs.
    environment: as for `start_loaded`. variables: that the server was born with, beside those of this process.
    Raises: OSError.
    """
    if number == 0 and not only and environment is None and not variables:
        return _start(process, _PLAIN, None)
    key = environment, number, only, variables
    if key not in _apart:
        _apart[key] = _new_server(())
    return _start(process, _apart[key], environment, variables)


def end_varied() -> None:
    """End the servers that were born with variables of their own, which few processes want; the next of these has a new one."""
    for key in [key for key in _apart if key[-1]]:
        server = _apart.pop(key)
        if server._forkserver_pid is not None:
            with suppress(ProcessLookupError):
                os.kill(server._forkserver_pid, signal.SIGKILL)
            with suppress(ChildProcessError):
                server._stop()


_PLAIN: Any = forkserver._forkserver
"""The one behind every context."""
_servers: dict[tuple[Environment | None, tuple[str, ...]], Any] = {}
"""By environment and modules; None for those that kill a server."""
_apart: dict[tuple[Environment | None, int, str, Variables], Any] = {}
"""Those beside the plain one that know no engine, by environment, number, whose they are and variables."""


def _start(process: BaseProcess, server: Any, environment: Environment | None, variables: Variables = ()) -> Server:
    """Start it off a server, and off a new one where that has died. Raises: ConnectionError, where the new one dies as well."""
    for _ in range(_TRIES):
        try:
            with _through(server), _surroundings(_environ(environment) | dict(variables)), _prepared(environment):
                process.start()
            return Server(server._forkserver_pid)
        except (EOFError, ConnectionError):
            if server._forkserver_pid is not None:
                Server(server._forkserver_pid)._ends(_FALLS)
    raise ConnectionError(f"a process could not be started: its fork server died, {_TRIES} times")


def _environ(environment: Environment | None) -> dict[str, str]:
    """What the environment variables say that a server, if it is new, is born with: numeric libraries use one thread."""
    threads = dict.fromkeys(_THREADS, "1")
    return threads if environment is None else threads | {"PYTHONPATH": os.pathsep.join(project_folders())}


@contextmanager
def _surroundings(variables: dict[str, str]) -> Iterator[None]:
    """These environment variables, for once.

    Those of this process are as before afterwards: Numba refuses to compile once they say another number of threads than those
    that run.
    """
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


_MAIN = ("init_main_from_name", "init_main_from_path")
"""Under which Python tells a new process which script runs here, for it to be run again there."""


@contextmanager
def _prepared(environment: Environment | None) -> Iterator[None]:
    """For once, tell a new process nothing of the script that runs here, and of an environment its interpreter and modules.

    A script without `if __name__ == "__main__"` would start a run in each process of a run; nothing of ours lies in it.
    """
    library: Any = spawn
    usual = library.get_executable, library.get_preparation_data
    if environment is not None:
        resource_tracker.ensure_running()  # the one that serves all is on this interpreter
        ordered = list(dict.fromkeys([*project_folders(), *environment.path, *sys.path]))
        library.get_executable = lambda: os.fsencode(environment.executable)

    def prepared(name: str) -> dict[str, Any]:
        data = {key: value for key, value in usual[1](name).items() if key not in _MAIN}
        return data if environment is None else data | {"sys_path": ordered}

    library.get_preparation_data = prepared
    try:
        yield
    finally:
        library.get_executable, library.get_preparation_data = usual


@atexit.register
def _end_servers() -> None:
    """End all servers: one whose processes' processes live on would wait for those, and keep what it was given to write to."""
    for server in (_PLAIN, *_servers.values(), *_apart.values()):
        if server is not None and server._forkserver_pid is not None and _ours == os.getpid():
            with suppress(ProcessLookupError):
                os.kill(server._forkserver_pid, signal.SIGKILL)


_ours = os.getpid()
"""The process that starts servers; those that come off them have loaded this as well."""


def _new_server(modules: tuple[str, ...]) -> Any:
    """It starts with its first process."""
    server = forkserver.ForkServer()
    server.set_forkserver_preload(_preload(modules))
    return server


@contextmanager
def _through(server: Any) -> Iterator[None]:
    """Python starts the processes of all contexts off one server; for once, off this one."""
    library: Any = forkserver
    usual = library.connect_to_new_process
    library.connect_to_new_process = server.connect_to_new_process
    try:
        yield
    finally:
        library.connect_to_new_process = usual
