"""What processes that a test starts say of themselves: a module that loads nothing else, since each of them loads it."""

import ctypes
import importlib.util
import math
import os
import resource
import signal
import sys
import time
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

__all__ = ["end", "show_flags", "show_libraries", "show_place", "show_threads", "show_where", "tamper", "tell"]


def tell(pipe: Connection, name: str) -> None:
    pipe.send(name in sys.modules)


def show_threads(pipe: Connection) -> None:
    pipe.send([os.environ.get(name) for name in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS")])


def show_where(pipe: Connection, name: str) -> None:
    """Send the file that a module is found in, None where it is nowhere."""
    found = importlib.util.find_spec(name)
    pipe.send(None if found is None else found.origin)


def show_flags(pipe: Connection) -> None:
    """Does Python write no bytecode here, and what becomes of an interrupt?"""
    pipe.send((sys.dont_write_bytecode, signal.getsignal(signal.SIGINT)))


def show_place(pipe: Connection) -> None:
    pipe.send(ctypes.cast(ctypes.pythonapi.Py_GetVersion, ctypes.c_void_p).value)


def show_libraries(pipe: Connection) -> None:
    """Send the kernels of BLAS, the code of NumPy's exponential, and sines of the C library."""
    from numpy.lib import introspect  # late: the other processes need none of it
    from threadpoolctl import threadpool_info

    kernels = {library["architecture"] for library in threadpool_info() if library["internal_api"] == "openblas"}
    code = introspect.opt_func_info("^exp$", "float64")["exp"]["dd"]["current"]
    pipe.send((kernels, code, [math.sin(0.001 * k) for k in range(10_000)]))


def end(_pipe: Connection, code: int) -> None:
    os._exit(code)


def tamper(_pipe: Connection, how: str) -> None:
    """What an engine may do to the server that it came off."""
    if how == "writes into every pipe":
        for descriptor in Path(f"/proc/{os.getppid()}/fd").iterdir():
            with suppress(OSError):
                pipe = os.open(descriptor, os.O_WRONLY | os.O_NONBLOCK)
                os.write(pipe, b"\0\0\0\5never" * 2)
    elif how == "takes its files":
        resource.prlimit(os.getppid(), resource.RLIMIT_NOFILE, (3, 3))
    elif how == "closes everything":
        os.closerange(0, 256)
    elif how == "waits":
        time.sleep(600)
