"""The scene as a whole: all its parts, the rules between them, the effects that it calls for, and how pairs touch."""

from collections import Counter
from collections.abc import Iterable, Iterator
from enum import Flag, auto
from functools import wraps
from typing import Annotated, Any, Self

import numpy as np
from pydantic import TypeAdapter, ValidationError, WithJsonSchema, field_serializer, field_validator
from pydantic.dataclasses import dataclass

from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.typed_fields import worded
from plumbline.harness.scene.body import Body, Sun
from plumbline.harness.scene.joint import WORLD, Joint, Prismatic, Revolute, Tendon
from plumbline.harness.scene.sensor import Sensor
from plumbline.harness.scene.values import FROZEN, Name, NonNegative, Probability, Vector3


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Surface:
    """What happens where two materials touch: a value per pair, so that no engine's combination rule decides.

    Terms:
        between: the two materials; order does not matter.
        static_friction, kinetic_friction [1]: Coulomb's coefficients, static >= kinetic.
        restitution [1]: normal speed after an impact over the speed before it, 0..1.
        rolling_friction, torsional_friction [m]: greatest moment over normal force, about axes in and across the plane.
    """

    between: tuple[Name, Name] = ("default", "default")
    static_friction: NonNegative = 0.0
    kinetic_friction: NonNegative = 0.0
    restitution: Probability = 0.0
    rolling_friction: NonNegative = 0.0
    torsional_friction: NonNegative = 0.0

    @classmethod
    def rough(cls, friction: float, between: tuple[str, str] = ("default", "default"), **fields: float) -> Self:
        """A surface with one coefficient, static and kinetic. Args: fields: the others of a surface."""
        return cls(between=between, static_friction=friction, kinetic_friction=friction, **fields)

    def __post_init__(self) -> None:
        if self.static_friction < self.kinetic_friction:
            raise ValueError(
                f"surface {self.between[0]}/{self.between[1]}: static_friction {self.static_friction} "
                f"lies below kinetic_friction {self.kinetic_friction}"
            )

    @property
    def pair(self) -> frozenset[str]:
        """The two materials without order."""
        return frozenset(self.between)


class Effect(Flag):
    """One bit for each piece of physics that can be left out."""

    NONE = 0
    GRAVITY = auto()
    CONTACT = auto()
    FRICTION = auto()
    RESTITUTION = auto()
    ROLLING_FRICTION = auto()
    TORSIONAL_FRICTION = auto()
    CONTINUOUS_COLLISION = auto()
    GYROSCOPIC = auto()
    JOINTS = auto()
    DRIVES = auto()
    LINEAR_DAMPING = auto()
    ANGULAR_DAMPING = auto()
    SENSING = auto()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the bits that are set, in lower case, in the order of definition."""
        return tuple(effect.name.lower() for effect in Effect if effect in self and effect.name is not None)


EARTH_GRAVITY = (0.0, 0.0, -9.81)
"""The gravity of every case that does not say otherwise [m/s2]."""


_EFFECT_NAMES = WithJsonSchema({"type": "array", "items": {"enum": list(Effect(~0).names)}})


_FREEDOMS = 6
"""Ways that a body moves in."""
_ALIKE = 1e-6
"""The least singular value of the motions of a chain at unit rates [1 and m]: below, one is all but made of the others."""

_TIED = 1e-9
"""What positions of coupled joints may differ by at the start [rad or m, relative above 1]: rounding of a file's digits."""


class SceneError(PlumblineError, ValueError):
    """A scene or scene file that breaks a rule; the message names element, field, value and expectation."""


def _unique(kind: str, names: Iterator[str]) -> None:
    for name, count in Counter(names).items():
        if count > 1:
            raise ValueError(f"{kind} '{name}': name stands {count} times, expected once")


def _line(joint: Joint, origin: Joint) -> list[float]:
    """The motion (6,) of a joint with one coordinate at unit rate, angular before linear, about the anchor of another."""
    assert isinstance(joint, Revolute | Prismatic)
    assert isinstance(origin, Revolute | Prismatic)
    axis = np.array(joint.axis_W)
    if isinstance(joint, Prismatic):
        return [0.0, 0.0, 0.0, *axis.tolist()]
    return [*axis.tolist(), *np.cross(np.subtract(joint.anchor_W, origin.anchor_W), axis).tolist()]


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Scene:
    """Everything that an engine is told, apart from how to solve it.

    Terms:
        gravity [m/s2] in W. sun: the light that cameras see by. widen, narrow: effects switched on or off against what the
        content says. tendons: along combinations of joints' coordinates; None: none.
        apart: pairs of materials whose bodies pass through each other (both may be the same), so that they need no surface.
    """

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...] = ()
    surfaces: tuple[Surface, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    gravity: Vector3 = EARTH_GRAVITY
    sun: Sun = Sun()
    widen: Annotated[Effect, _EFFECT_NAMES] = Effect.NONE
    narrow: Annotated[Effect, _EFFECT_NAMES] = Effect.NONE
    apart: tuple[tuple[Name, Name], ...] = ()
    tendons: tuple[Tendon, ...] | None = None

    @field_validator("widen", "narrow", mode="before")
    @classmethod
    def _effects_by_name(cls, value: object) -> object:
        if isinstance(value, list | tuple):
            total = Effect.NONE
            for name in value:
                if not isinstance(name, str) or name.upper() not in Effect.__members__:
                    raise ValueError(f"unknown effect {name!r}, expected some of {', '.join(Effect(~0).names)}")
                total |= Effect[name.upper()]
            return total
        return value

    @field_serializer("widen", "narrow")
    def _effects_as_names(self, value: Effect) -> list[str]:
        return list(value.names)

    def __post_init__(self) -> None:
        if not self.bodies:
            raise ValueError("scene: bodies is empty, expected at least one")
        _unique("body", (b.name for b in self.bodies))
        _unique("joint", (j.name for j in self.joints))
        _unique("sensor", (s.name for s in self.sensors))
        _unique("surface", ("/".join(sorted(s.between)) for s in self.surfaces))
        names = {b.name for b in self.bodies}
        if WORLD in names:
            raise ValueError(f"body '{WORLD}': name is taken by the world frame, expected another")
        self._check_joints(names)
        for sensor in self.sensors:
            if sensor.body not in names | {WORLD}:
                raise ValueError(f"sensor '{sensor.name}': body '{sensor.body}' is not in the scene")
        laws = {s.pair for s in self.surfaces}
        materials = {b.material for b in self.bodies}
        for a, b in self.apart:
            if not {a, b} <= materials:
                raise ValueError(f"apart {a}/{b}: no body is of material '{a if a not in materials else b}'")
            if frozenset((a, b)) in laws:
                raise ValueError(f"surface {a}/{b}: these materials are apart; expected no law between them")
        for a, b in self._material_pairs():
            if frozenset((a, b)) not in laws:
                raise ValueError(f"surface {a}/{b}: missing; bodies of these materials can touch, expected their law")

    def _check_joints(self, names: set[str]) -> None:
        movable = {body.name: body.movable for body in self.bodies}
        for joint in self.joints:
            for end, name in (("parent", joint.parent), ("child", joint.child)):
                if name not in names and not (end == "parent" and name == WORLD):
                    raise ValueError(f"joint '{joint.name}': {end} '{name}' is not a body of the scene")
            if joint.parent == joint.child:
                raise ValueError(f"joint '{joint.name}': parent and child are both '{joint.child}'")
            if not movable.get(joint.parent, False) and not movable[joint.child]:
                raise ValueError(f"joint '{joint.name}': neither '{joint.parent}' nor '{joint.child}' can move")
        self._check_massless()
        self._check_couplings()
        self._check_tendons()

    def _check_tendons(self) -> None:
        """Tendons have names of their own and pull at joints that have one coordinate."""
        _unique("tendon", (tendon.name for tendon in self.tendons or ()))
        scalar = {joint.name for joint in self.joints if isinstance(joint, Revolute | Prismatic)}
        for tendon in self.tendons or ():
            if lacking := next((arm.joint for arm in tendon.arms if arm.joint not in scalar), None):
                raise ValueError(f"tendon '{tendon.name}': '{lacking}' is no joint with one coordinate")

    def _check_massless(self) -> None:
        """A body without mass stands between two joints with one coordinate, and none of the axes before the next body with
        mass does what others do together: there its coordinates would be without inertia."""
        massless = {body.name for body in self.bodies if body.massless}
        if not massless:
            return
        hung = {joint.child: joint for joint in self.joints if joint.child in massless}
        for name in sorted(massless):
            ends = [joint for joint in self.joints if name in (joint.parent, joint.child)]
            if [joint.parent == name for joint in ends] not in ([True, False], [False, True]) or not all(
                isinstance(joint, Revolute | Prismatic) for joint in ends
            ):
                raise ValueError(
                    f"body '{name}': mass is 0 kg, expected two revolute or prismatic joints, one that it hangs on and one "
                    f"that hangs on it, got {', '.join(f'{joint.type} {joint.name!r}' for joint in ends) or 'none'}"
                )
        for joint in self.joints:
            if joint.parent not in massless or joint.child in massless:
                continue
            chain = [joint]
            while chain[-1].parent in hung:
                chain.append(hung[chain[-1].parent])
            lines = np.array([_line(each, joint) for each in chain])
            if len(lines) > _FREEDOMS or np.linalg.svd(lines)[1][-1] < _ALIKE:
                raise ValueError(
                    f"body '{joint.child}': hangs on joints {', '.join(repr(each.name) for each in reversed(chain))} with no "
                    "mass between them, of which one moves it as others do; expected axes that each move it another way"
                )
        for sensor in self.sensors:
            if sensor.body in massless:
                raise ValueError(f"sensor '{sensor.name}': body '{sensor.body}' has no mass, expected another")

    def _check_couplings(self) -> None:
        """A coupled joint follows another one that has a coordinate, none follows itself, and all start where they are tied."""
        scalar = {joint.name: joint for joint in self.joints if isinstance(joint, Revolute | Prismatic)}
        for joint in scalar.values():
            followed, tie = {joint.name}, joint.coupling
            while tie is not None:
                if tie.joint not in scalar:
                    raise ValueError(f"joint '{joint.name}': coupling to '{tie.joint}', which is no joint with one coordinate")
                if tie.joint in followed:
                    raise ValueError(f"joint '{joint.name}': couplings lead from '{tie.joint}' back to it, expected an end")
                followed.add(tie.joint)
                tie = scalar[tie.joint].coupling
            if (tie := joint.coupling) is not None:
                tied = tie.ratio * scalar[tie.joint].position + tie.offset
                if abs(joint.position - tied) > _TIED * max(1.0, abs(joint.position), abs(tie.offset)):
                    raise ValueError(
                        f"joint '{joint.name}': position {joint.position:g}, expected {tied:g} by its coupling to '{tie.joint}'"
                    )

    def _material_pairs(self) -> Iterator[tuple[str, str]]:
        """Pairs of materials of which two bodies could touch: one of them is movable, and they are not apart.

        One after the other, some twice: where most have no law, the first one without says enough.
        """
        kinds = sorted({(b.material, b.movable) for b in self.bodies if b.collision})
        counts = Counter(b.material for b in self.bodies if b.collision and b.movable)
        apart = {frozenset(pair) for pair in self.apart}
        for a in sorted(counts):
            for b, movable in kinds:
                if (a != b or not movable or counts[a] > 1) and frozenset((a, b)) not in apart:
                    yield min(a, b), max(a, b)

    def body(self, name: str) -> Body:
        """The body of that name; KeyError where there is none."""
        for body in self.bodies:
            if body.name == name:
                return body
        raise KeyError(name)

    def index(self, name: str) -> int:
        """The place of the body of that name in `bodies` and so in every state; KeyError where there is none."""
        for place, body in enumerate(self.bodies):
            if body.name == name:
                return place
        raise KeyError(name)

    def surface(self, a: Body, b: Body) -> Surface:
        """The law between the materials of two bodies; KeyError where the scene has none."""
        pair = frozenset((a.material, b.material))
        for surface in self.surfaces:
            if surface.pair == pair:
                return surface
        raise KeyError(f"{a.material}/{b.material}")

    def joined(self) -> frozenset[frozenset[str]]:
        """The pairs of bodies that a joint keeps from colliding."""
        return frozenset(frozenset((j.parent, j.child)) for j in self.joints if not j.collide)

    def collides(self, a: Body, b: Body) -> bool:
        """Can these two bodies touch? One must be movable, both have shapes, and no joint or `apart` stands between them."""
        if a.name == b.name or not (a.movable or b.movable) or not (a.collision and b.collision):
            return False
        if (a.material, b.material) in self.apart or (b.material, a.material) in self.apart:
            return False
        return not any({j.parent, j.child} == {a.name, b.name} for j in self.joints if not j.collide)

    @property
    def content(self) -> Effect:
        """The effects read off the content alone."""
        called = Effect.NONE
        movable = [b for b in self.bodies if b.movable]
        if any(self.gravity) and movable:
            called |= Effect.GRAVITY
        pairs = {frozenset(pair) for pair in self._material_pairs()}
        touching = [s for s in self.surfaces if s.pair in pairs]
        if touching:
            called |= Effect.CONTACT
            for effect, field in (
                (Effect.FRICTION, "static_friction"),
                (Effect.RESTITUTION, "restitution"),
                (Effect.ROLLING_FRICTION, "rolling_friction"),
                (Effect.TORSIONAL_FRICTION, "torsional_friction"),
            ):
                if any(getattr(s, field) > 0 for s in touching):
                    called |= effect
        if self.joints:
            called |= Effect.JOINTS
        if any(getattr(j, "drive", None) is not None for j in (*self.joints, *(self.tendons or ()))):
            called |= Effect.DRIVES
        if any(b.linear_damping > 0 for b in movable):
            called |= Effect.LINEAR_DAMPING
        if any(b.angular_damping > 0 for b in movable):
            called |= Effect.ANGULAR_DAMPING
        if self.sensors:
            called |= Effect.SENSING
        turning = [b for b in movable if any(b.w_WB) or (b.collision and touching) or self.joints]
        if turning:
            moments = np.linalg.eigvalsh(np.array([b.inertia for b in turning]))
            if (moments[:, 2] - moments[:, 0] > 1e-12 * moments[:, 2]).any():
                called |= Effect.GYROSCOPIC
        return called

    @property
    def effects(self) -> Effect:
        """The effects that the scene calls for: its content, widened and narrowed as it says."""
        return (self.content | self.widen) & ~self.narrow


def refuse_in_words(nouns: Iterable[type]) -> None:
    """Have the constructors of these pydantic dataclasses raise `SceneError`, with element, field, value and expectation."""
    for noun in nouns:
        noun.__init__ = _in_words(noun, noun.__init__)  # type: ignore[misc]


def _in_words(noun: type, construct: Any) -> Any:
    @wraps(construct)
    def __init__(self: Any, *arguments: Any, **fields: Any) -> None:  # noqa: N807  # it takes the place of one
        try:
            construct(self, *arguments, **fields)
        except ValidationError as error:
            name = fields.get("name")
            source = noun.__name__.lower() + (f" {quoted(name, 80)}" if isinstance(name, str) else "")
            raise SceneError(worded(TypeAdapter(noun), fields, source, error)) from None

    return __init__
