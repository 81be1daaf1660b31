"""Which compiled step advances a world, and which narrow phase: those that run just the stages that its contents call for."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import cast

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
        from plumbline.engine.steps.sequential import step_sequential_impulses

        return step_sequential_impulses
    if touching and options.sweeps != GAUSS_SEIDEL:
        return _named("shared_sweeps", f"{'spheres' if spheres else 'contact'}_{options.sweeps}")
    if spheres:
        from plumbline.engine.steps.spheres import step_spheres

        return step_spheres
    if islands:
        name = "islands_jointed" if jointed else "islands"
        return _named(name, name + ("_parallel" if options.threads > 1 else ""))
    if touching and jointed:
        from plumbline.engine.steps.contact_jointed import step_contact_jointed

        return step_contact_jointed
    if touching:
        from plumbline.engine.steps.contact import step_contact

        return step_contact
    from plumbline.engine.steps import smooth

    if not jointed:
        return smooth.step_free
    refuse_unsmooth(integrator, unsmooth)
    return smooth.step_jointed_runge_kutta if integrator == "rk4" else smooth.step_jointed_euler


def _named(module: str, name: str) -> Step:
    """A step of a module of this package."""
    return cast(Step, getattr(import_module(f"plumbline.engine.steps.{module}"), f"step_{name}"))


def refuse_unsmooth(integrator: str, unsmooth: str) -> None:
    """Keep from an integrator of smooth forces what is not. Raises: NotSupported."""
    if unsmooth and integrator != "semi_implicit_euler":
        raise NotSupported(
            f"integrator '{integrator}' with {unsmooth} in a joint", "its stages are smooth; semi_implicit_euler knows it"
        )


def joint_coordinates_step(touching: bool, closing: bool, options: Options, unsmooth: str) -> Step:
    """The compiled step of trees in joint coordinates. Args: closing: whether joints close loops; unsmooth: as `choose_step`.

    Raises: NotSupported.
    """
    if touching or closing:
        from plumbline.engine.steps import joint_coordinates_held as held

        if not touching:
            return held.step_joint_coordinates_closing
        return held.step_joint_coordinates_touching_and_closing if closing else held.step_joint_coordinates_touching
    refuse_unsmooth(options.integrator, unsmooth)
    from plumbline.engine.steps import joint_coordinates as steps

    return {
        "semi_implicit_euler": steps.step_joint_coordinates_euler,
        "rk4": steps.step_joint_coordinates_runge_kutta,
        "implicit_midpoint": steps.step_joint_coordinates_midpoint,
        ADAPTIVE: steps.step_joint_coordinates_adaptive,
    }[options.integrator]


def unsmooth_of(joints: Sequence[Joint]) -> str:
    """What of the joints' laws has no place in smooth stages; empty where nothing."""
    if any(getattr(joint, "speed_limit", math.inf) < math.inf for joint in joints):
        return "a limit of speed"
    return "dry friction" if any(getattr(joint, "friction_loss", 0.0) > 0 for joint in joints) else ""


Collide = Callable[[Floats, Ints], None]


def load_collide(moving_meshes: bool) -> Collide:
    """That of convex shapes, or, where forces move triangle meshes, the one that knows these too."""
    if moving_meshes:
        from plumbline.engine.contact.collide_meshes import collide_meshes

        return collide_meshes
    from plumbline.engine.contact.collide_convex import collide_convex

    return collide_convex


def load_sorting(coloured: bool) -> Collide | None:
    """What sorts the pairs of a step by colours, where these are wanted."""
    if not coloured:
        return None
    from plumbline.engine.contact.colours import sort_pairs

    return sort_pairs
