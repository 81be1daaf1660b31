"""An engine's functions that are files: compiling one writes it, unless it is to fail or to take its process down."""

import os
import signal
from collections.abc import Callable
from functools import partial
from pathlib import Path

from plumbline.harness.adapter.kernels import KernelGroup, Kernels

__all__ = ["NAMES", "kernels_in", "needed_first"]

NAMES = ("step", "search", "rays")


def needed_first(folder: Path) -> Kernels:
    """All of `NAMES`, the last of which comes first."""
    return kernels_in(folder, NAMES, first=NAMES[-1:])


def kernels_in(folder: Path, names: tuple[str, ...] = NAMES, first: tuple[str, ...] = ()) -> Kernels:
    """Functions stored in a folder; 'broken' raises, and 'deadly' kills its process."""
    groups = tuple(
        KernelGroup(
            names=(name,), compile=_compiler(folder, name), is_stored=(folder / name).exists, family=name, first=name in first
        )
        for name in names
    )
    return Kernels(groups=groups, folder=str(folder), notes=("slow today",))


def _compiler(folder: Path, name: str) -> Callable[[], None]:
    return partial({"broken": _fail, "deadly": _die}.get(name, _write), folder / name)


def _write(path: Path) -> None:
    path.write_text(str(os.getpid()))


def _fail(path: Path) -> None:
    raise RuntimeError(f"{path.name} has no types")


def _die(_path: Path) -> None:
    os.kill(os.getpid(), signal.SIGKILL)
