"""Newton as it comes: its modules loaded late and without their greetings, transforms in its words."""

import importlib
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.adapter import Unavailable
from plumbline.harness.scene import Quaternion, Vector3


@dataclass(frozen=True, slots=True)
class Vendor:
    """Newton, and Warp, which compiles and runs its kernels."""

    newton: Any
    warp: Any

    def transform(self, p: Vector3, q: Quaternion) -> Any:
        """The pose of origin p [m], turned by the unit quaternion q = (w, x, y, z)."""
        w, x, y, z = q
        return self.warp.transform(tuple(p), self.warp.quat(x, y, z, w))


def load() -> Vendor:
    """The modules newton and warp, on the processor. Raises: Unavailable."""
    try:
        warp = importlib.import_module("warp")
        warp.config.log_level = warp.LOG_ERROR
        # Nobody asks for gradients here, and each kernel's adjoint doubles what is compiled.
        warp.config.enable_backward = False
        with _unheard():
            warp.init()
        newton = importlib.import_module("newton")
    except ImportError as error:
        raise Unavailable(f"newton cannot be imported ({error}); install newton 1.8 with mujoco-warp 4.0 or later") from error
    return Vendor(newton, warp)


@contextmanager
def _unheard() -> Iterator[None]:
    """What native code says on standard error goes nowhere: that no graphics card has a driver, which nothing asks for."""
    stderr, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(stderr, 2)
        os.close(stderr)
        os.close(nowhere)


def mujoco_solver(newton: Any, model: Any, **options: Any) -> Any:
    """Newton's solver over MuJoCo-Warp. Newton 1.8 asks for 3.17 of it, and warns of each other version."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return newton.solvers.SolverMuJoCo(model, **options)


def view(array: Any) -> Any:
    """An array of Warp on the processor as one of numpy that shares its memory."""
    return np.asarray(array.numpy())
