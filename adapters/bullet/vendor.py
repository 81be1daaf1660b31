"""pybullet as it comes: the module loaded late and kept silent, a private world, and what all worlds of a process share."""

import contextlib
import ctypes
import importlib
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from plumbline.harness.adapter import Unavailable

LIFTED = 1e30
"""A velocity limit [m/s, rad/s] and a force limit [N] that nothing reaches."""
CONTACT_BREAKING = 0.02
"""The gap [m] at which pybullet 3.2.7 lets go of a point of contact, where it is told nothing."""
breaks = {"at": CONTACT_BREAKING}
"""The gap [m] at which Bullet lets go of a point of contact: one number for all worlds of a process."""


@contextlib.contextmanager
def silenced() -> Iterator[None]:
    """Keep C code from writing on the standard streams: pybullet greets its importer, and warns, through printf."""
    libc = ctypes.CDLL(None)
    sys.stdout.flush()
    sys.stderr.flush()
    libc.fflush(None)
    saved = os.dup(1), os.dup(2)
    void = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(void, 1)
        os.dup2(void, 2)
        yield
    finally:
        libc.fflush(None)
        os.dup2(saved[0], 1)
        os.dup2(saved[1], 2)
        for descriptor in (void, *saved):
            os.close(descriptor)


def pybullet_module() -> Any:
    """The module pybullet, imported at the first need. Raises: Unavailable."""
    loaded = sys.modules.get("pybullet")
    if loaded is not None:
        return loaded
    try:
        with silenced():
            return importlib.import_module("pybullet")
    except ImportError as error:
        raise Unavailable(
            f"pybullet cannot be imported ({error}); it publishes wheels for Python 3.10 and 3.11 only"
        ) from error


@dataclass(frozen=True, slots=True)
class Port:
    """A connection to one private world of Bullet."""

    bullet: Any
    client: int

    def call(self, name: str, *arguments: Any, **named: Any) -> Any:
        """One call of the binding, always with the client by keyword: in some functions its position means something else."""
        return getattr(self.bullet, name)(*arguments, **named, physicsClientId=self.client)


def connected(bullet: Any) -> Port:
    """A new private world. Raises: Unavailable."""
    client = bullet.connect(bullet.DIRECT)
    if client < 0:
        raise Unavailable("pybullet has no room for another world (1024 in one process); close some simulations")
    return Port(bullet, client)


def break_contacts_at(port: Port, gap: float) -> None:
    """Have points of contact let go at this gap [m] from now on, in this and every other world."""
    if breaks["at"] != gap:
        port.call("setPhysicsEngineParameter", contactBreakingThreshold=gap)
        breaks["at"] = gap
