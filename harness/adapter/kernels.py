"""The functions that an engine compiles itself, told so that they can be compiled before a trial needs them."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class KernelGroup:
    """Functions that one process compiles together.

    Terms:
        names: of the functions. compile: compiles them for the types of arguments that trials call them with, or loads them.
        is_stored: does the engine's cache hold them all? family: groups of one family are made of much the same parts, so that
        a process which has compiled one is quicker with the next. first: compiled before all others, since most scenes need it.
    """

    names: tuple[str, ...]
    compile: Callable[[], None]
    is_stored: Callable[[], bool]
    family: str = ""
    first: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Kernels:
    """All functions that an engine compiles for the trials of studies.

    Terms: groups: in the order in which they are compiled. folder: the cache. notes: what makes compiling slower than it could
    be, or needless, each as a line.
    """

    groups: tuple[KernelGroup, ...] = ()
    folder: str = ""
    notes: tuple[str, ...] = ()
