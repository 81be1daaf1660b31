"""The way out of an engine: what a simulation hands back in an accuracy run is checked here, once for all adapters.

An array of the wrong shape or kind, a body that is none, or a list of rays that was changed is a broken contract. A number that
is not finite, or so large that its square is not, says that the engine has diverged. Nothing of this stands under the clock.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from plumbline.harness.adapter import Diverged, Notice, Settings, Simulation
from plumbline.harness.adapter.notice import as_notices
from plumbline.harness.scene import Camera, Scene
from plumbline.harness.trajectory import UNSHARED, Contacts, Floats, Hits, Image, State
from plumbline.harness.trajectory.joint_states import JointStates

LARGEST = 1e100
"""What no position, velocity or force may exceed, in SI units; the square of a number beyond 1e154 is infinite."""
_UNIT = 1e-3
"""By how much the length of a normal may differ from 1: for engines in single precision, after a few operations."""


class BrokenContract(Exception):
    """An engine's answer is none: not of the kind that its adapter promises."""


def sane(values: Floats) -> bool:
    """Are all numbers finite and none beyond `LARGEST`?"""
    # A sum of squares that is small enough says so of each of them, in one call; asked in every sample of every trial.
    few = values.size <= UNSHARED
    return (few and bool(np.vdot(values, values) <= LARGEST**2)) or bool((np.abs(values) <= LARGEST).all())


def _array(where: str, value: Any, shape: tuple[int, ...], kind: str) -> None:
    """Raises: BrokenContract, where it is no array of that shape and kind ('f' or 'i', as of `numpy.dtype.kind`)."""
    if isinstance(value, np.ndarray) and value.shape == shape and value.dtype.kind == kind:
        return
    got = f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__
    raise BrokenContract(f"{where}: got {got}, expected an array {shape} of {'floats' if kind == 'f' else 'integers'}")


def _numbers(where: str, value: Any, shape: tuple[int, ...], unbounded: bool = False) -> None:
    """Numbers; where they are unbounded, infinity says that there is nothing. Raises: BrokenContract, Diverged."""
    _array(where, value, shape, "f")
    if value.size == 0:
        return
    held = value[value != np.inf] if unbounded else value
    if not sane(held):
        raise Diverged(f"{where}: got {held[~(np.abs(held) <= LARGEST)][0]}")
    if unbounded and held.size and held.min() < 0:
        raise BrokenContract(f"{where}: got {held.min()}, expected none below 0")


def _places(where: str, value: Any, shape: tuple[int, ...], least: int, bodies: int) -> None:
    _array(where, value, shape, "i")
    if value.size and not (least <= value.min() and value.max() < bodies):
        worst = value.min() if value.min() < least else value.max()
        raise BrokenContract(f"{where}: got body {worst}, expected {least}..{bodies - 1}")


def _kind(where: str, value: Any, of: type) -> None:
    if not isinstance(value, of):
        raise BrokenContract(f"{where}: got {type(value).__name__}, expected {of.__name__}")


def _felt(read: Callable[[str], Any], name: str) -> tuple[Floats, Floats]:
    """What the engine's own accelerometer and gyroscope say. Raises: BrokenContract, Diverged."""
    sample = read(name)
    if not isinstance(sample, tuple) or len(sample) != 2:
        raise BrokenContract(f"inertial('{name}'): got {type(sample).__name__}, expected two arrays")
    for what, value in zip(("accelerometer", "gyroscope"), sample, strict=True):
        _numbers(f"inertial('{name}'): {what}", value, (3,))
    return sample


def _joints(read: Callable[[], JointStates], joints: int) -> JointStates:
    """What the engine holds of its joints; NaN says that it holds nothing. Raises: BrokenContract, Diverged."""
    states = read()
    _kind("joint_states()", states, JointStates)
    for name, shape in (("coordinate", (joints,)), ("rate", (joints,)), ("reaction", (joints, 6))):
        value = getattr(states, name)
        _array(f"joint_states().{name}", value, shape, "f")
        _numbers(f"joint_states().{name}", np.nan_to_num(value, nan=0.0, posinf=np.inf, neginf=-np.inf), shape)
    return states


class Answering:
    """A simulation of a scene whose answers are checked; in all else it is the simulation itself."""

    def __init__(self, simulation: Simulation, scene: Scene) -> None:
        self._simulation, self._names = simulation, [body.name for body in scene.bodies]
        self._bodies, self._joints = len(self._names), len(scene.joints)

    def __getattr__(self, name: str) -> Any:
        """What is not checked, and what not every engine has. Raises: AttributeError."""
        if name.startswith("_"):
            raise AttributeError(name)
        attribute = getattr(self._simulation, name)
        if name == "joint_states":
            return partial(_joints, attribute, self._joints)
        return partial(_felt, attribute) if name == "inertial" else attribute

    @property
    def resolved(self) -> Settings:
        """The settings that are used."""
        settings = self._simulation.resolved
        _kind("resolved", settings, Settings)
        return settings

    def warnings(self) -> tuple[Notice, ...]:
        """What there is to say."""
        warnings = self._simulation.warnings()
        _kind("warnings()", warnings, tuple)
        for number, warning in enumerate(warnings):
            if not isinstance(warning, str | Notice):
                raise BrokenContract(
                    f"warnings()[{number}]: got {warning!r:.80} of {type(warning).__name__}, expected a text or Notice"
                )
        return as_notices(warnings)

    def state(self, out: State) -> None:
        """The present state; what the engine leaves out is not finite. Raises: Diverged."""
        arrays = out.p_WB, out.q_WB, out.v_WB, out.w_WB
        for array in arrays:
            array.fill(np.nan)
        self._simulation.state(out)
        # As in `sane`, of all arrays at once.
        if out.size <= LARGEST**2:
            return
        for name, array in zip(("p_WB", "q_WB", "v_WB", "w_WB"), arrays, strict=True):
            if not sane(array):
                row, column = np.argwhere(~(np.abs(array) <= LARGEST))[0]
                value, body = array[row, column], self._names[row]
                what = f"beyond {LARGEST:g}" if np.isfinite(value) else "not finite"
                raise Diverged(f"the state is {what}: {name} of body '{body}': {value}")

    def contacts(self) -> Contacts:
        """The contacts of the last step."""
        contacts = self._simulation.contacts()
        _kind("contacts()", contacts, Contacts)
        count = len(contacts.gap) if isinstance(contacts.gap, np.ndarray) and contacts.gap.ndim else 0
        for name in ("gap", "point_W", "normal_W", "force_W"):
            _numbers(f"contacts().{name}", getattr(contacts, name), (count,) if name == "gap" else (count, 3))
        for name in ("body_A", "body_B"):
            _places(f"contacts().{name}", getattr(contacts, name), (count,), 0, self._bodies)
        if count == 0:
            return contacts
        if not (contacts.body_A < contacts.body_B).all():
            raise BrokenContract("contacts(): got a pair with A >= B, expected A < B")
        if not np.abs(np.linalg.norm(contacts.normal_W, axis=1) - 1).max() <= _UNIT:
            raise BrokenContract("contacts().normal_W: got a normal whose length is not 1")
        return contacts

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hits; the rays are as before."""
        before, rays = directions.copy(), len(directions)
        hits = self._simulation.cast(origins, directions, max_range)
        if not np.array_equal(before, directions):
            raise BrokenContract("cast(): got directions that were changed, expected them left alone")
        _kind("cast()", hits, Hits)
        _numbers("cast().distance", hits.distance, (rays,), unbounded=True)
        _places("cast().body", hits.body, (rays,), -1, self._bodies)
        _numbers("cast().normal_W", hits.normal_W, (rays, 3))
        return hits

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """A picture."""
        image = self._simulation.render(camera, colour)
        _kind("render()", image, Image)
        shape = camera.height, camera.width
        _numbers("render().depth", image.depth, shape, unbounded=True)
        _places("render().body", image.body, shape, -1, self._bodies)
        if image.colour is not None:
            _numbers("render().colour", image.colour, (*shape, 3))
        return image
