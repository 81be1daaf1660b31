"""What a planted fault is: an engine broken in one way, and what has to see it.

A fault is one class or one function, by its own name, and its docstring says in words what is broken:

* a class around a simulation overrides the calls that it spoils, see `planting.Wrapped`;
* a function changes what its argument is: an `Adapter`, a `Scene`, each `Body`, `PlacedShape`, `Surface`, `Joint`, joint with a
  coordinate (`Revolute | Prismatic`) or `Imu` of it; a recorded `Trajectory`; or each law of inertial noise (`AxisNoise`) as
  the readers of sensors are told it, while the case judges by its own.
"""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

from plumbline.harness.adapter import Adapter, Feature
from plumbline.harness.scene import AxisNoise, Body, Imu, Joint, PlacedShape, Prismatic, Revolute, Scene, Surface
from plumbline.harness.trajectory import Trajectory
from tests.planted_faults.planting import (
    every_body,
    every_coordinate,
    every_imu,
    every_joint,
    every_noise,
    every_shape,
    every_surface,
    plant,
)

SLIDES = (
    "friction_backspin", "friction_roll_incline", "friction_slip_to_roll", "friction_spinning", "friction_static_kinetic",
    "friction_stop", "friction_threshold", "friction_wall_pinch",
)  # fmt: skip
"""Cases in which something slides: they notice the same faults."""


def _same(unchanged: Any) -> Any:
    return unchanged


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """One planted fault.

    Terms:
        name, words: what is broken, in snake case and in words. seen_by: the conformance checks that must fail, each of which
        passes on the sound engine. needs: features without which the fault cannot show. cases: patterns of case names that
        should notice it as well.
        plant: the adapter with the fault. spoil: the same for a recorded trajectory, for faults behind the engine.
        sensors: the same for the scene that the readers of sensors are told.
    """

    name: str
    words: str
    seen_by: tuple[str, ...]
    needs: Feature
    cases: tuple[str, ...]
    plant: Callable[[Adapter], Adapter] = _same
    spoil: Callable[[Trajectory], Trajectory] = _same
    sensors: Callable[[Scene], Scene] = _same

    @property
    def on_trajectory(self) -> bool:
        """Does the fault lie behind the engine, in recorded streams?"""
        return not self.seen_by or self.seen_by == ("noise_axes_are_independent",)


FAULTS: list[Fault] = []
"""Every fault that is defined so far, in the order of definition."""

_OF_SCENES: tuple[tuple[Any, Callable[[Any], Callable[[Scene], Scene]]], ...] = (
    (Scene, _same),
    (Body, every_body),
    (PlacedShape, every_shape),
    (Surface, every_surface),
    (Joint, every_joint),
    (Revolute | Prismatic, every_coordinate),
    (Imu, every_imu),
)


def _planted(broken: Any) -> dict[str, Callable[[Any], Any]]:
    """How a class or function is planted, by the field of `Fault` that it fills."""
    if isinstance(broken, type):
        return {"plant": partial(plant, simulation=broken)}
    changed = next(iter(inspect.signature(broken).parameters.values())).annotation
    if changed is Adapter:
        return {"plant": broken}
    if changed is Trajectory:
        return {"spoil": broken}
    if changed is AxisNoise:
        return {"sensors": every_noise(broken)}
    (every,) = (every for kind, every in _OF_SCENES if kind == changed)
    return {"plant": partial(plant, scene=every(broken))}


Defined = TypeVar("Defined", bound=Callable[..., Any])


def fault(
    *seen_by: str, needs: Feature = Feature.NONE, cases: tuple[str, ...] = (), name: str = "", **more: Callable[[Any], Any]
) -> Callable[[Defined], Defined]:
    """Define a class or a function as a fault. Args: seen_by: checks. more: another field of `Fault` that it needs."""

    def define(broken: Defined) -> Defined:
        words = inspect.getdoc(broken).partition("\n\n")[0].replace("\n", " ")
        named = name or broken.__name__
        FAULTS.append(Fault(name=named, words=words, seen_by=seen_by, needs=needs, cases=cases, **_planted(broken), **more))
        return broken

    return define
