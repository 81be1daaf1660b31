"""How a trial departs from its case: effects of the scene switched on, off, or faintly there, damping added, what its user left
out put back, or environment variables that its process starts with.

The case stays what it is, its truth and its checks too; what the departure does to the answer is what a study asks.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, TypeAlias

from plumbline.harness.case.starts import perturbed
from plumbline.harness.case.symmetries import Retelling, nudged, reordered, restored
from plumbline.harness.scene import Effect, Scene

Variables: TypeAlias = tuple[tuple[str, str], ...]
"""Environment variables, each with its value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Alteration:
    """A departure from a scene, by a name that tables show.

    Terms:
        widen, narrow: effects switched on or off whatever the scene says; where one is in both, it is off.
        present: effects that the scene lacks, made present so weakly (`FAINT`) that they change nothing but the work.
        linear_damping, angular_damping [1/s]: added to what each movable body has.
        told: run this retelling of the scene in place of it: 'restored' (half-way), 'reordered', 'nudged' (by one bit).
        start: run this one of the scene's perturbed starts (`harness.case.starts.perturbed`), 0 for its own.
        every_step: record every step, whatever the case says.
        undropped: kinds of elements that the case's user left out and this run has: its scene is `Case.undropped`.
        variables: environment variables that the process of this run starts with.
    """

    name: str = ""
    widen: Effect = Effect.NONE
    narrow: Effect = Effect.NONE
    present: Effect = Effect.NONE
    linear_damping: float = 0.0
    angular_damping: float = 0.0
    told: Literal["", "restored", "reordered", "nudged"] = ""
    start: int = 0
    every_step: bool = False
    undropped: tuple[str, ...] = ()
    variables: Variables = ()

    @property
    def same_scene(self) -> bool:
        """Is the scene as it is, however often and wherever it is run?"""
        return self == Alteration(name=self.name, told=self.told, every_step=self.every_step, variables=self.variables)

    @property
    def clocked(self) -> bool:
        """Does a timing run clock it, if its experiment has one?"""
        return self.name not in (*REFINED, TURNED) and not (self.start or self.undropped or self.variables)

    def of(self, scene: Scene) -> Scene:
        """The scene as it is under this alteration; the very same one where nothing departs."""
        if replace(self, undropped=()).same_scene:
            return scene
        if self.start:
            scene = perturbed(scene, self.start)
        if self.present:
            scene = _with(scene, self.present)
        bodies = scene.bodies
        if self.linear_damping or self.angular_damping:
            bodies = tuple(
                replace(
                    body,
                    linear_damping=body.linear_damping + self.linear_damping,
                    angular_damping=body.angular_damping + self.angular_damping,
                )
                if body.movable
                else body
                for body in bodies
            )
        return replace(
            scene,
            bodies=bodies,
            widen=(scene.widen | self.widen) & ~self.narrow,
            narrow=(scene.narrow & ~self.widen) | self.narrow,
        )

    @property
    def single(self) -> Effect:
        """The effects that are left out, or taken in; none where nothing but others are faintly there, or the step is finer."""
        return self.narrow | self.widen

    def retelling(self, scene: Scene, duration: float) -> Retelling | None:
        """How a scene, altered already, is told in a run of `duration` [s]; None as it is."""
        match self.told:
            case "restored":
                return restored(scene, duration / 2)
            case "reordered":
                return reordered(scene)
            case "nudged":
                return nudged(scene)
            case "":
                return None

    def plain(self) -> dict[str, Any]:
        """What departs, as a JSON-ready mapping; empty where nothing does. `from_plain` reads it back."""
        departing: dict[str, Any] = {}
        for field in fields(self):
            value = getattr(self, field.name)
            if value != field.default:
                departing[field.name] = _plain(field.name, value)
        return departing

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Alteration":
        """Read back what `plain` wrote."""
        kinds, variables = tuple(plain.get(_KINDS, ())), tuple(plain.get(_VARIABLES, {}).items())
        values: dict[str, Any] = {
            name: _effects(v) if isinstance(v, list) else v for name, v in plain.items() if name not in (_KINDS, _VARIABLES)
        }
        return cls(**values, undropped=kinds, variables=variables)


_KINDS, _VARIABLES = "undropped", "variables"


def _plain(name: str, value: Any) -> Any:
    """The value of a field of this name as JSON has it."""
    if isinstance(value, Effect):
        return list(value.names)
    if name == _VARIABLES:
        return dict(value)
    return list(value) if isinstance(value, tuple) else value


FAINT = 1e-9
"""Coefficients [1], levers [m] and rates [1/s] of effects that are to be there and do nothing; what they do
after all is measured, as of every departure."""
_LAWS = {
    Effect.FRICTION: ("static_friction", "kinetic_friction"),
    Effect.RESTITUTION: ("restitution",),
    Effect.ROLLING_FRICTION: ("rolling_friction",),
    Effect.TORSIONAL_FRICTION: ("torsional_friction",),
}
_RATES = {Effect.LINEAR_DAMPING: "linear_damping", Effect.ANGULAR_DAMPING: "angular_damping"}


def _with(scene: Scene, present: Effect) -> Scene:
    """The scene with these effects faintly there, where they can be without a new body or joint."""
    fields_ = [name for effect, names in _LAWS.items() if effect in present for name in names]
    surfaces = tuple(
        replace(law, **{name: max(FAINT, getattr(law, name)) for name in fields_}) if fields_ else law for law in scene.surfaces
    )
    rates = [name for effect, name in _RATES.items() if effect in present]
    bodies = tuple(
        replace(body, **{name: max(FAINT, getattr(body, name)) for name in rates}) if rates and body.movable else body
        for body in scene.bodies
    )
    widened = present & (Effect.CONTINUOUS_COLLISION | Effect.GYROSCOPIC | Effect.GRAVITY)
    return replace(scene, bodies=bodies, surfaces=surfaces, widen=scene.widen | widened, narrow=scene.narrow & ~present)


def _effects(names: Collection[str]) -> Effect:
    total = Effect.NONE
    for name in names:
        total |= Effect[name.upper()]
    return total


AS_IT_IS = Alteration()
"""No departure."""

UNDROPPED = "nothing dropped"
"""Name: the scene with what its user left out."""
TURNED = "one setting turned"
"""Name: the scene as it is under a track with one setting at another value, to see what that setting does."""
ALONE = "alone"
"""Name: the run has the machine for itself, while all others run side by side."""
EVERYTHING, FINER, FINEST = "everything on", "half the step", "a quarter of the step"
"""Names: every other effect of the engine faintly present; the scene as it is, at half the time step and at half of that."""
REFINED = {FINER: 2, FINEST: 4}
"""By how much the time step is divided, by name."""
_ALWAYS = Effect.GRAVITY | Effect.FRICTION | Effect.GYROSCOPIC
"""What every engine has; the rest stands by the same name among an engine's features."""
_TOUCHING = _ALWAYS | Effect.ROLLING_FRICTION | Effect.TORSIONAL_FRICTION
_FREE = _ALWAYS | Effect.LINEAR_DAMPING | Effect.ANGULAR_DAMPING
"""What can be faintly there in a scene with contacts, and in one without. Restitution cannot: soft contacts rebound by more,
and others take so little for none. Bullet has rolling friction, or damping and continuous collision, not both; the latter is
a departure of its own."""


def departures(scene: Scene, features: Collection[str]) -> Iterator[Alteration]:
    """What the study of effects makes of a scene: everything on, each effect left out that it calls for, each one taken in that
    it leaves off. `features` are the names of what the engine can express."""
    declared = scene.effects
    on = _ALWAYS | _effects([name for name in features if name.upper() in Effect.__members__])
    others = _TOUCHING if Effect.CONTACT in declared else _FREE
    yield Alteration(name=EVERYTHING, present=others & on & ~declared)
    for effect in Effect:
        if effect in declared and effect != Effect.SENSING:
            yield Alteration(name=f"without {effect.names[0]}", narrow=effect)
    left_off = scene.content & ~declared
    if Effect.CONTACT in declared:
        left_off |= Effect.CONTINUOUS_COLLISION & ~declared
    for effect in Effect:
        if effect in left_off and effect != Effect.SENSING:
            yield Alteration(name=f"with {effect.names[0]}", widen=effect)
