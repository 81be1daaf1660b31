"""Which compiled step advances a world, and which narrow phase: those that run just the stages that its contents call for."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, cast

from plumbline.engine.broad.choice import DropApart, FindPairs
from plumbline.engine.describe.errors import NotSupported
from plumbline.engine.describe.joints import Joint
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.options import ADAPTIVE, FREE_INTEGRATORS, GAUSS_SEIDEL, Options

Step = Callable[[Floats, Ints, int], tuple[int, int]]


@dataclass(frozen=True, slots=True)
class Kernels:
    """What advances a world: its step, and where that does not find its pairs, the search before it and the test after that;
    and whether its narrow phase is the one that knows meshes which forces move.
    """

    step: Step
    find_pairs: FindPairs | None
    drop_apart: DropApart | None
    moving_meshes: bool


def choose_step(touching: bool, jointed: bool, options: Options, spheres: bool, islands: bool, unsmooth: str) -> Step:
    """The compiled step that runs exactly the stages needed. Args: unsmooth: what of joints is not. Raises: NotSupported."""
    integrator = options.integrator
    if integrator in FREE_INTEGRATORS:
        if touching or jointed:
            raise NotSupported(
                f"integrator '{integrator}' with {'contacts' if touching else 'joints'}",
                "it advances what nothing ties or touches; semi_implicit_euler and rk4 know constraints",
            )
        return cast(Step, getattr(import_module(FREE_INTEGRATORS[integrator]), f"step_{integrator}"))
    if touching and options.solver == "sequential_impulses":
        if jointed:
            raise NotSupported("joints beside contacts", "sequential impulses know contacts only")
        return _entry("steps.sequential", "step_sequential_impulses")
    if touching and options.sweeps != GAUSS_SEIDEL:
        return _entry("steps.shared_sweeps", f"step_{'spheres' if spheres else 'contact'}_{options.sweeps}")
    if spheres:
        return _entry("steps.spheres", "step_spheres")
    if islands or touching:
        name = f"{'islands' if islands else 'contact'}{'_jointed' if jointed else ''}"
        return _entry(f"steps.{name}", f"step_{name}" + ("_parallel" if islands and options.threads > 1 else ""))
    if not jointed:
        return _entry("steps.smooth", "step_free")
    refuse_unsmooth(integrator, unsmooth)
    return _entry("steps.smooth", "step_jointed_runge_kutta" if integrator == "rk4" else "step_jointed_euler")


def _entry(module: str, name: str) -> Callable[..., Any]:
    """A compiled function of the engine, of which only what a world runs is loaded."""
    return cast(Callable[..., Any], getattr(import_module(f"plumbline.engine.{module}"), name))


def refuse_unsmooth(integrator: str, unsmooth: str) -> None:
    """Keep from an integrator of smooth forces what is not. Raises: NotSupported."""
    if unsmooth and integrator != "semi_implicit_euler":
        raise NotSupported(
            f"integrator '{integrator}' with {unsmooth} in a joint", "its stages are smooth; semi_implicit_euler knows it"
        )


IN_JOINT_COORDINATES = {
    "semi_implicit_euler": "euler",
    "rk4": "runge_kutta",
    "implicit_midpoint": "midpoint",
    ADAPTIVE: "adaptive",
}
"""How the step of an integrator in joint coordinates is called."""


def joint_coordinates_step(touching: bool, closing: bool, options: Options, unsmooth: str) -> Step:
    """The compiled step of trees in joint coordinates. Args: closing: whether joints close loops; unsmooth: as `choose_step`.

    Raises: NotSupported.
    """
    if touching or closing:
        held = "_and_".join(["touching"] * touching + ["closing"] * closing)
        return _entry("steps.joint_coordinates_held", f"step_joint_coordinates_{held}")
    refuse_unsmooth(options.integrator, unsmooth)
    return _entry("steps.joint_coordinates", f"step_joint_coordinates_{IN_JOINT_COORDINATES[options.integrator]}")


def unsmooth_of(joints: Sequence[Joint]) -> str:
    """What of the joints' laws has no place in smooth stages; empty where nothing."""
    if any(getattr(joint, "speed_limit", math.inf) < math.inf for joint in joints):
        return "a limit of speed"
    return "dry friction" if any(getattr(joint, "friction_loss", 0.0) > 0 for joint in joints) else ""


Collide = Callable[[Floats, Ints], None]


def load_collide(moving_meshes: bool) -> Collide:
    """That of convex shapes, or, where forces move triangle meshes, the one that knows these too."""
    name = "collide_meshes" if moving_meshes else "collide_convex"
    return _entry(f"contact.{name}", name)


def load_sorting(coloured: bool) -> Collide | None:
    """What sorts the pairs of a step by colours, where these are wanted."""
    return _entry("contact.colours", "sort_pairs") if coloured else None
