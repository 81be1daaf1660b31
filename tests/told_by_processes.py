"""What processes that a test starts say of themselves: a module that loads nothing else, since each of them loads it."""

import ctypes
import os
import sys
from multiprocessing.connection import Connection

__all__ = ["show_place", "show_threads", "tell"]


def tell(pipe: Connection, name: str) -> None:
    pipe.send(name in sys.modules)


def show_threads(pipe: Connection) -> None:
    pipe.send([os.environ.get(name) for name in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS")])


def show_place(pipe: Connection) -> None:
    pipe.send(ctypes.cast(ctypes.pythonapi.Py_GetVersion, ctypes.c_void_p).value)
