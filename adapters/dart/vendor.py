"""The vendor's module: how it is loaded, what it prints, the one parameter that all of its worlds share."""

import contextlib
import importlib
import os
import re
import sys
import tempfile
from collections.abc import Iterator
from typing import Any

import numpy as np

from plumbline.harness.adapter import Unavailable
from plumbline.harness.scene import Quaternion, Vector3, rotation_matrix
from plumbline.harness.trajectory import Floats


def load() -> Any:
    """The module dartpy. Raises: Unavailable."""
    try:
        return importlib.import_module("dartpy")
    except ImportError as error:
        raise Unavailable(f"dartpy cannot be imported ({error}); install dartpy 6.20 or later") from error


@contextlib.contextmanager
def overheard(lines: list[str]) -> Iterator[None]:
    """Turn the vendor's console (file descriptors 1 and 2) into lines, so that it neither pollutes an output nor gets lost."""
    sys.stdout.flush()
    sys.stderr.flush()
    with tempfile.TemporaryFile() as heard:
        kept = os.dup(1), os.dup(2)
        os.dup2(heard.fileno(), 1)
        os.dup2(heard.fileno(), 2)
        try:
            yield
        finally:
            for descriptor, target in zip(kept, (1, 2), strict=True):
                os.dup2(descriptor, target)
                os.close(descriptor)
            heard.seek(0)
            text = re.sub(r"\x1b\[[0-9;]*m", "", heard.read().decode(errors="replace"))
            lines.extend(dict.fromkeys(line.strip() for line in text.splitlines() if line.strip()))


@contextlib.contextmanager
def correcting(dart: Any, share: float) -> Iterator[None]:
    """While a world steps, DART's one error reduction parameter is that world's share [1]; other worlds have their own."""
    constraint = dart.constraint.DynamicJointConstraint
    usual = constraint.getErrorReductionParameter()
    if usual == share:
        yield
        return
    constraint.setErrorReductionParameter(share)
    try:
        yield
    finally:
        constraint.setErrorReductionParameter(usual)


def body_of(collision_object: Any) -> int:
    """The place in the scene of the body that a collision object belongs to; the name of its shape begins with it."""
    return int(collision_object.getShapeFrame().getName().split("/", 1)[0])


def pose(dart: Any, p: Vector3 | Floats, q: Quaternion = (1.0, 0.0, 0.0, 0.0)) -> Any:
    """The Isometry3 that shifts by p [m] and turns by the unit quaternion q = (w, x, y, z)."""
    made = dart.math.Isometry3()
    made.set_rotation(np.array(rotation_matrix(q)))
    made.set_translation(np.asarray(p, dtype=np.float64))
    return made
