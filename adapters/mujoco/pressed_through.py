"""Which materials would be pressed through each other: by the speeds and widths that a scene starts with."""

import math
from collections.abc import Sequence

import numpy as np

from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.softness import time_constant
from plumbline.harness.adapter.touching_kinds import Kind, touching_kinds
from plumbline.harness.scene import Body, Capsule, Cylinder, PlacedShape, Plane, Sphere, rotate
from plumbline.harness.scene.shape import outer_radius, width
from plumbline.harness.trajectory import Floats


def give(constant: float, ratio: float) -> float:
    """How far [m] a contact is pressed in by a body that comes with 1 m/s.

    Equation: x'' = -2/tc x' - x/(tc z)^2 from x = 0 with x' = 1 reaches tc z exp(-z acosh(z)/sqrt(z^2 - 1)), below z = 1 with
    acos(z) and sqrt(1 - z^2), at 1 tc/e. Source: MuJoCo, "Modeling", solver parameters (solref), at impedance 1.
    """
    root = math.sqrt(abs(ratio**2 - 1))
    turn = 1.0 if root < 1e-6 else ratio * (math.acosh(ratio) if ratio > 1 else math.acos(ratio)) / root
    return constant * ratio * math.exp(-turn)


def pressed_through(plan: Plan) -> frozenset[frozenset[str]]:
    """The pairs of materials of which a body could come so fast that the usual contact stops it behind the other's middle.

    Beyond that a contact pushes out to the far side. A pair counts where the greatest closing speed of its bodies times what
    the contact gives and a step, in which it is found late, exceeds half of their least widths together.
    """
    options, scene = plan.options, plan.scene
    constant = time_constant(options.contact_steps, plan.h, options.slowest)
    late = give(constant, options.contact_damping_ratio or 1.0) + plan.h
    kinds: dict[Kind, list[Body]] = {}
    for body in scene.bodies:
        if body.collision:
            kinds.setdefault((body.material, body.movable), []).append(body)
    found = set[frozenset[str]]()
    for a, b in touching_kinds(scene):
        room = sum(min(width(placed.shape) for body in kinds[kind] for placed in body.collision) / 2 for kind in (a, b))
        if math.isfinite(room) and _closing(kinds[a], kinds[b]) * late > room:
            found.add(frozenset((a[0], b[0])))
    return frozenset(found)


def _closing(ones: Sequence[Body], others: Sequence[Body]) -> float:
    """A bound of the speed [m/s] by which a body of the ones and another come nearer, the same however all of them drift."""
    (c, spread), (other_c, other_spread) = _speeds(ones), _speeds(others)
    return float(np.linalg.norm(c - other_c)) + spread + other_spread


def _speeds(bodies: Sequence[Body]) -> tuple[Floats, float]:
    """The middle of these bodies' velocities (3,), and how far a shape's own velocity is from it at most [m/s]."""
    v = np.array([body.v_WB for body in bodies])
    middle = (v.min(axis=0) + v.max(axis=0)) / 2
    turning = np.array([_sweep(body) for body in bodies])
    return middle, float((np.linalg.norm(v - middle, axis=1) + turning).max())


def _sweep(body: Body) -> float:
    """The greatest speed [m/s] at which turning moves the outline of a body's shapes: none, where one turns on the spot."""
    w = float(np.linalg.norm(body.w_WB))
    return 0.0 if w == 0 else max(w * _arm(body, placed, np.array(body.w_WB) / w) for placed in body.collision)


def _arm(body: Body, placed: PlacedShape, axis: Floats) -> float:
    """How far [m] what turning moves of a shape's outline is from the axis at most, but for half its width."""
    shape = placed.shape
    if isinstance(shape, Plane):
        return 0.0
    own = float(np.linalg.norm(np.cross(axis, rotate(body.q_WB, placed.p_BS))))
    along = np.array(rotate(body.q_WB, rotate(placed.q_BS, (0.0, 0.0, 1.0))))
    if isinstance(shape, Sphere) or (isinstance(shape, Capsule | Cylinder) and abs(float(along @ axis)) > 1 - 1e-9):
        return own
    return own + outer_radius(shape) - width(shape) / 2
