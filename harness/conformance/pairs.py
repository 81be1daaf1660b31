"""Small scenes in which two things stand together that are each right alone, made from a list of nouns.

Each noun says what it adds; what it needs beside it (a coordinate for a drive) comes with it as a hinge. A scene is a body,
the parent, and another one that is joined to it; if both nouns are joints, a third hangs on the second. Each pair is tried on
another body that falls and turns, and on the world. Nothing touches, no limit is reached, and all turn and move from the
start, so that each law, each frame and each lever shows within a few steps.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.frames import ORIGIN, TURNED, symmetric, vector
from plumbline.harness.conformance.multibody import EndState, Multibody, matrix
from plumbline.harness.conformance.scenes import G, free, prismatic, tie
from plumbline.harness.scene.body import Body, PlacedShape
from plumbline.harness.scene.joint import WORLD, Ball, Drive, Joint, Limits, Prismatic, Revolute, Spring
from plumbline.harness.scene.motion import Prescribed, Shift, Sinusoid, Turn, axis_angle, multiply
from plumbline.harness.scene.scene import Scene
from plumbline.harness.scene.shape import Box, Sphere
from plumbline.harness.scene.values import Quaternion, Vector3

DURATION, STEP = 0.03, 1e-3
"""Seconds of motion, and the step that engines take it in."""
LENGTHS = (1.0, 0.5, 1.5, 1.25, 0.75)
"""Of uneven steps, in STEP: their mean is 1, and each is cut into `SUBSTEPS`."""
RUNGE_KUTTA = 4
"""Steps of the exact motion, of fourth order: off by less than 1e-6 of what engines are allowed, as tests find."""
SUBSTEPS, SAVED, ASTRAY = 2, 10, 7
"""Sub-steps of uneven steps; after how many steps a state is saved, and how many are taken before it is restored."""
WRENCHES: dict[str, tuple[Vector3, Vector3]] = {
    "child": ((4.0, -6.0, 5.0), (0.5, -0.4, 0.3)),
    "parent": ((-7.0, 3.0, 8.0), (-0.6, 0.9, 0.8)),
}
"""Forces [N] at the centres of mass, torques [N m]."""
_AXIS: Vector3 = (1 / 3, 2 / 3, 2 / 3)
_SECOND: Vector3 = (0.48, -0.6, 0.64)
_ANCHOR, _CHILD = np.array([0.2, 0.1, -0.1]), np.array([0.5, 0.3, -0.2])
_FURTHER, _THIRD = np.array([0.6, 0.5, -0.25]), np.array([0.8, 0.45, 0.05])
_ASKEW: Quaternion = multiply(axis_angle((0.0, 1.0, 0.0), -0.9), axis_angle((3.0, -1.0, 2.0), 0.6))
_RATE = 1.5
"""Of coordinates [rad/s]; of slides [m/s] a third of it."""


@dataclass(frozen=True, slots=True)
class PairPlan:
    """A scene in the making: bodies by name in their order, joints in theirs, and how it is run."""

    bodies: dict[str, Body]
    joints: tuple[Joint, ...]
    wrenches: bool = False
    uneven: bool = False
    restored: bool = False

    @property
    def scene(self) -> Scene:
        """What an engine is given."""
        return Scene(bodies=tuple(self.bodies.values()), joints=self.joints, gravity=(1.0, -2.0, -G))


@dataclass(frozen=True, slots=True)
class Task:
    """What an engine is asked, and the motion that follows from the laws alone."""

    plan: PairPlan
    scene: Scene
    expected: EndState


@dataclass(frozen=True, slots=True)
class Noun:
    """Something that stands in a scene.

    Terms:
        name: in words. needs: features without which there is none. add: to a plan whose joints stand. joint: the kind that it
        is itself. coordinate: does it belong to a joint of one coordinate? moved: must the parent be a body?
    """

    name: str
    needs: Feature
    add: Callable[[PairPlan], PairPlan] = lambda plan: plan
    joint: str = ""
    coordinate: bool = False
    moved: bool = False


def _body(plan: PairPlan, name: str, **fields: Any) -> PairPlan:
    """A plan with a body changed, where there is that body."""
    if name not in plan.bodies:
        return plan
    return replace(plan, bodies=plan.bodies | {name: replace(plan.bodies[name], **fields)})


def _axial(plan: PairPlan, fields: Callable[[Revolute | Prismatic], dict[str, Any]]) -> PairPlan:
    """A plan with its last joint of one coordinate changed."""
    last = max(k for k, joint in enumerate(plan.joints) if isinstance(joint, Revolute | Prismatic))
    joint = plan.joints[last]
    assert isinstance(joint, Revolute | Prismatic)
    return replace(plan, joints=(*plan.joints[:last], replace(joint, **fields(joint)), *plan.joints[last + 1 :]))


def _start_pose(plan: PairPlan) -> PairPlan:
    """The coordinate counts from elsewhere than the pose that the scene starts in; limits and targets go along."""

    def fields(joint: Revolute | Prismatic) -> dict[str, Any]:
        by, limits, drive = 0.7 - joint.position, joint.limits, joint.drive
        lower, upper = (None, None) if limits is None else (limits.lower, limits.upper)
        moved = [None if end is None else end + by for end in (lower, upper)]
        return {
            "position": 0.7,
            "limits": None if limits is None else Limits(lower=moved[0], upper=moved[1]),
            "drive": None if drive is None else replace(drive, target=drive.target + by),
        }

    return _axial(plan, fields)


def _drive(joint: Revolute | Prismatic) -> dict[str, Any]:
    stiffness, damping, ahead = (20.0, 1.0, 0.6) if isinstance(joint, Revolute) else (150.0, 6.0, 0.15)
    return {"drive": Drive(stiffness=stiffness, damping=damping, target=joint.position + ahead)}


def _limited(lower: float | None, upper: float | None, start: float) -> Callable[[PairPlan], PairPlan]:
    """Limits about a coordinate that starts within them, its zero outside: counted from there, one would be in its way."""
    return lambda plan: _axial(plan, lambda _: {"position": start, "limits": Limits(lower=lower, upper=upper)})


def _spring(plan: PairPlan) -> PairPlan:
    """A spring between points of parent and child, tied off their centres and off the joint, stretched, with a damper."""
    parent = "parent" if "parent" in plan.bodies else WORLD
    spring = Spring(stiffness=60.0, damping=1.5, rest=0.5)
    line = tie("line", "child", (-0.15, 0.25, 0.1), (0.6, 0.15, -0.05), parent=parent, spring=spring)
    return replace(plan, joints=(*plan.joints, line))


def _offset(plan: PairPlan) -> PairPlan:
    """Products of inertia, and a shape that is placed and turned off the centre of mass."""
    R = matrix(np.array(_ASKEW))
    inertia = R @ np.diag([0.05, 0.07, 0.06]) @ R.T
    shape = PlacedShape(shape=Box(half_extents=(0.04, 0.06, 0.05)), p_BS=(0.05, -0.1, 0.08), q_BS=_ASKEW)
    return _body(plan, "child", inertia=symmetric(inertia), collision=(shape, *plan.bodies["child"].collision))


def _compound(plan: PairPlan) -> PairPlan:
    """Two more shapes, of which none touches anything."""
    balls = tuple(PlacedShape(shape=Sphere(radius=0.03), p_BS=p) for p in ((0.1, 0.0, 0.05), (-0.1, 0.05, 0.0)))
    return _body(plan, "child", collision=(*plan.bodies["child"].collision, *balls))


def _prescribed(plan: PairPlan) -> PairPlan:
    """The parent is led: shaken along one direction while it turns about another, through a point of its own."""
    law = Prescribed(
        shifts=(Shift(axis_W=(0.6, 0.0, 0.8), motion=Sinusoid(amplitude=0.05, frequency=2.0, phase=0.5)),),
        turn=Turn(anchor_W=(0.1, -0.2, 0.1), axis_W=_SECOND, motion=Sinusoid(amplitude=0.4, frequency=1.0, phase=0.3)),
    )
    return _body(plan, "parent", motion="kinematic", prescribed=law, v_WB=ORIGIN, w_WB=ORIGIN)


def _second_joint(plan: PairPlan) -> PairPlan:
    """A slide before the last joint of one coordinate, with nothing that has mass between the two."""
    last = max(k for k, joint in enumerate(plan.joints) if isinstance(joint, Revolute | Prismatic))
    joint = plan.joints[last]
    assert isinstance(joint, Revolute | Prismatic)
    between = Body.between("between", (0.3, -0.2, 0.4))
    slide = prismatic("rail", "between", (0.1, 0.0, 0.3), (0.8, 0.0, -0.6), parent=joint.parent)
    joints = (*plan.joints[:last], slide, replace(joint, parent="between"), *plan.joints[last + 1 :])
    return replace(plan, bodies=plan.bodies | {"between": between}, joints=joints)


NOUNS = (
    Noun("wrench", Feature.WRENCH, lambda plan: replace(plan, wrenches=True)),
    Noun("hinge", Feature.REVOLUTE, joint="hinge"),
    Noun("slide", Feature.PRISMATIC, joint="slide"),
    Noun("ball", Feature.BALL, joint="ball"),
    Noun("distance spring", Feature.DISTANCE_SPRING, _spring),
    Noun("limit", Feature.LIMITS, _limited(0.2, 0.8, 0.5), coordinate=True),
    Noun("one-sided limit", Feature.LIMITS, _limited(None, -0.3, -0.5), coordinate=True),
    Noun("drive", Feature.DRIVES, lambda plan: _axial(plan, _drive), coordinate=True),
    Noun(
        "friction loss",
        Feature.FRICTION_LOSS,
        lambda plan: _axial(plan, lambda joint: {"friction_loss": 0.6 if isinstance(joint, Revolute) else 4.0}),
        coordinate=True,
    ),
    Noun("start pose", Feature.NONE, _start_pose, coordinate=True),
    Noun("second joint of a body", Feature.MASSLESS | Feature.PRISMATIC, _second_joint, coordinate=True),
    Noun("parent turned", Feature.NONE, lambda plan: _body(plan, "parent", q_WB=TURNED), moved=True),
    Noun("child turned", Feature.NONE, lambda plan: _body(plan, "child", q_WB=_ASKEW)),
    Noun("offset mass frame", Feature.FULL_INERTIA | Feature.BOX, _offset),
    Noun("compound", Feature.COMPOUND | Feature.SPHERE, _compound),
    Noun("uneven steps", Feature.STEP_LENGTHS, lambda plan: replace(plan, uneven=True)),
    Noun("restore", Feature.SAVE, lambda plan: replace(plan, restored=True)),
    Noun("prescribed body", Feature.PRESCRIBED_MOTION, _prescribed, moved=True),
)
"""All, in the order in which they are added to a plan."""


@dataclass(frozen=True, slots=True)
class Pair:
    """Two nouns in one scene. Terms: hung: on the world, not on a body. needs: all that the scene calls for."""

    nouns: tuple[Noun, Noun]
    hung: bool

    @property
    def kinds(self) -> tuple[str, ...]:
        """Of its joints, from the parent outwards; a hinge comes along with what needs a coordinate, or anything to hang on."""
        joints = sorted((noun.joint for noun in self.nouns if noun.joint), key=("ball", "hinge", "slide").index)
        if any(noun.coordinate for noun in self.nouns) and not {"hinge", "slide"} & set(joints):
            joints.append("hinge")
        lone = any(noun.name == "distance spring" for noun in self.nouns)
        return tuple(joints or ([] if lone else ["hinge"]))

    @property
    def needs(self) -> Feature:
        """All that the scene calls for."""
        kinds = {"hinge": Feature.REVOLUTE, "slide": Feature.PRISMATIC, "ball": Feature.BALL}
        total = self.nouns[0].needs | self.nouns[1].needs
        for kind in self.kinds:
            total |= kinds[kind]
        return total

    def plan(self) -> PairPlan:
        """The scene and how it is run."""
        bodies = {} if self.hung else {"parent": free("parent", mass=3.0, moments=(0.3, 0.2, 0.25))}
        child = free("child", mass=1.5, moments=(0.05, 0.07, 0.06), p=vector(_CHILD))
        bodies |= {"child": replace(child, v_WB=(0.4, -0.3, 0.5), w_WB=(0.9, 1.2, -0.7))}
        if not self.hung:
            bodies["parent"] = replace(bodies["parent"], v_WB=(0.2, 0.1, -0.3), w_WB=(0.3, -0.4, 0.5))
        joints: list[Joint] = []
        upper, anchor, axis = WORLD if self.hung else "parent", _ANCHOR, _AXIS
        for lower, kind in zip(("child", "third"), self.kinds, strict=False):
            if lower == "third":
                bodies["third"] = free("third", mass=0.8, moments=(0.03, 0.02, 0.04), p=vector(_THIRD))
            make = {"hinge": Revolute, "slide": Prismatic, "ball": Ball}[kind]
            along = {} if kind == "ball" else {"axis_W": axis}
            joints.append(make(name=kind, parent=upper, child=lower, anchor_W=vector(anchor), **along))
            upper, anchor, axis = lower, _FURTHER, _SECOND
        plan = PairPlan(bodies, tuple(joints))
        for noun in self.nouns:
            plan = noun.add(plan)
        return _set_going(plan)


def _set_going(plan: PairPlan) -> PairPlan:
    """Give what hangs on joints the velocities that these allow: those of the parent, and a rate along what is free."""
    for joint in plan.joints:
        if not isinstance(joint, Revolute | Prismatic | Ball):
            continue
        upper = plan.bodies.get(joint.parent)
        v, w = (np.zeros(3), np.zeros(3)) if upper is None else map(np.array, upper.velocity_at_start)
        start = np.zeros(3) if upper is None else np.array(upper.p_WB)
        lower = np.array(plan.bodies[joint.child].p_WB)
        spin = np.array([1.0, -0.8, 1.3]) if isinstance(joint, Ball) else np.zeros(3)
        # Towards a lower limit where there is one, else upwards.
        rate = -_RATE if not isinstance(joint, Ball) and joint.limits and joint.limits.lower is not None else _RATE
        if isinstance(joint, Revolute):
            spin = rate * np.array(joint.axis_W)
        anchor = np.array(joint.anchor_W)
        moving = v + np.cross(w, anchor - start) + np.cross(w + spin, lower - anchor)
        if isinstance(joint, Prismatic):
            moving = moving + rate / 3 * np.array(joint.axis_W)
        plan = _body(plan, joint.child, v_WB=vector(moving), w_WB=vector(w + spin))
    return plan


def _together(a: Noun, b: Noun) -> bool:
    """Can both stand in one scene? Two ranges of one coordinate cannot."""
    return not {a.name, b.name} >= {"limit", "one-sided limit"}


def all_pairs() -> Iterator[tuple[str, tuple[Pair, ...]]]:
    """By the name of their check: each two nouns, on a body that moves and, where they allow it, on the world."""
    for nouns in combinations(NOUNS, 2):
        if _together(*nouns):
            hung = (False,) if any(noun.moved for noun in nouns) else (False, True)
            name = "_and_".join(noun.name.replace(" ", "_").replace("-", "_") for noun in nouns)
            yield f"pair_{name}", tuple(Pair(nouns, hung=choice) for choice in hung)


@lru_cache(maxsize=512)
def task(pair: Pair) -> Task:
    """A pair worked out, once for all tracks and engines."""
    plan = pair.plan()
    wrenches: dict[str, tuple[Any, Any]] = {name: w for name, w in WRENCHES.items() if plan.wrenches and name in plan.bodies}
    return Task(plan, plan.scene, Multibody(plan.scene, wrenches).motion(DURATION, RUNGE_KUTTA))
