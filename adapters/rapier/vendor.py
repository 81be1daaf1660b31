"""rapier3d as it comes: the module loaded late, poses and turns in its words."""

import importlib
import os
from typing import Any

from plumbline.harness.adapter import Unavailable
from plumbline.harness.scene import Quaternion, Vector3


def load() -> Any:
    """The module rapier3d. Raises: Unavailable."""
    # Read when the module is loaded: its pool of threads would take every core, and hands over each step.
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    try:
        return importlib.import_module("rapier3d")
    except ImportError as error:
        raise Unavailable(f"rapier3d cannot be imported ({error}); install rapier3d 0.36 or later") from error


def pose(rapier: Any, p: Vector3, q: Quaternion) -> Any:
    """The isometry that turns by the unit quaternion q = (w, x, y, z) and shifts by p [m]."""
    return rapier.Isometry3(p, rapier.Rotation3(*q))
