"""What processes that a test starts say of themselves: a module that loads nothing else, since each of them loads it."""

import ctypes
import math
import os
import signal
import sys
from multiprocessing.connection import Connection

__all__ = ["end", "show_flags", "show_libraries", "show_place", "show_threads", "tell"]


def tell(pipe: Connection, name: str) -> None:
    pipe.send(name in sys.modules)


def show_threads(pipe: Connection) -> None:
    pipe.send([os.environ.get(name) for name in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS")])


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
