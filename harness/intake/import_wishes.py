"""What a user asks of an import on the command line or from Python, beside what the companion file says."""

from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Literal, cast

from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted

Drop = Literal[
    "actuator",
    "adhesion",
    "armature",
    "ball_spring",
    "equality",
    "flex",
    "fluid",
    "friction_loss",
    "gravity_compensation",
    "height_field",
    "mimic",
    "nonlinear",
    "plugin",
    "self_collision",
    "tendon",
]
"""What changes the motion: refused by name, where a scene has no word for it, unless the user leaves it out.

A scene has words for the rotors and the dry friction of hinges and slides, for mimics, and for contacts between links; not
every engine does, or not with each other's friction, so that leaving them out may be the only way to compare all.
"""

DROPPABLE: Mapping[Drop, str] = {
    "actuator": "actuators that are no law of one joint, affine in its coordinate and rate",
    "adhesion": "contacts that pull",
    "armature": "rotor inertia about a joint",
    "ball_spring": "springs, dampers and limits of ball and free joints",
    "equality": "equations between joints or tendons, and those between bodies that are neither joints nor welds",
    "flex": "deformable bodies",
    "fluid": "drag and lift of the medium",
    "friction_loss": "dry friction in a joint",
    "gravity_compensation": "bodies that gravity pulls less",
    "height_field": "terrain as heights, and shapes given by a distance function",
    "mimic": "joints that follow another one, and linear equalities of two joints",
    "nonlinear": "springs and dampers with terms of higher order",
    "plugin": "an engine's own plug-ins",
    "self_collision": "contacts between links of the robot",
    "tendon": "tendons with a spring, a damper, friction or limits",
}

OF_JOINTS: tuple[Drop, ...] = ("armature", "ball_spring", "friction_loss", "mimic", "nonlinear")
"""Kinds that joints have, which `KIND@PATTERN` leaves out of some of them."""


@dataclass(frozen=True, slots=True)
class Omissions:
    """What is left out. Terms: whole: kinds, wherever they are. of_joints: kind and pattern of the names of joints."""

    whole: frozenset[Drop] = frozenset()
    of_joints: frozenset[tuple[Drop, str]] = frozenset()

    @classmethod
    def of(cls, texts: Iterable[str], where: str = "drop") -> "Omissions":
        """From texts KIND or KIND@PATTERN, * and ? in a pattern meeting any characters and any one. Raises: RobotError."""
        whole, of_joints = set[Drop](), set[tuple[Drop, str]]()
        for text in texts:
            kind, at, pattern = text.partition("@")
            if kind not in DROPPABLE:
                raise RobotError(
                    f"{where}: {quoted(kind, 80)}, expected one of {', '.join(DROPPABLE)}{did_you_mean(kind, DROPPABLE)}"
                )
            if at and (kind not in OF_JOINTS or not pattern):
                raise RobotError(
                    f"{where}: {quoted(text, 80)}, expected KIND@PATTERN, KIND being one of {', '.join(OF_JOINTS)}"
                )
            if at:
                of_joints.add((cast("Drop", kind), pattern))
            else:
                whole.add(cast("Drop", kind))
        return cls(frozenset(whole), frozenset(of_joints))

    def takes(self, kind: Drop, joint: str | None = None) -> bool:
        """Is an element of this kind left out? Args: joint: whose it is; None for no joint's."""
        patterns = () if joint is None else (pattern for of, pattern in self.of_joints if of == kind)
        return kind in self.whole or any(fnmatchcase(str(joint), pattern) for pattern in patterns)

    def check(self, joints: Iterable[str], source: str) -> None:
        """Refuse a pattern that no joint meets. Raises: RobotError."""
        names = list(joints)
        for kind, pattern in sorted(self.of_joints):
            if not any(fnmatchcase(joint, pattern) for joint in names):
                raise RobotError(
                    f"{source}: drop: {quoted(f'{kind}@{pattern}', 80)}: no joint is called so, "
                    f"expected some of {listed(names, 12) or 'none'}"
                )

    def restored(self, kinds: Container[Drop]) -> "Omissions":
        """What is left out where elements of these kinds are not."""
        return Omissions(
            frozenset(kind for kind in self.whole if kind not in kinds),
            frozenset(pair for pair in self.of_joints if pair[0] not in kinds),
        )

    @property
    def kinds(self) -> frozenset[Drop]:
        """The kinds of which anything is left out."""
        return self.whole | {kind for kind, _ in self.of_joints}

    @property
    def texts(self) -> tuple[str, ...]:
        """As the user writes them, in order."""
        return tuple(sorted([*self.whole, *(f"{kind}@{pattern}" for kind, pattern in self.of_joints)]))


NOTHING = Omissions()

Root = Literal["fixed", "floating"]
Scenario = Literal["drop", "hold", "swing", "sweep"]
Start = Literal["zero", "middle", "inside"]
STARTS: tuple[Start, ...] = ("zero", "middle", "inside")
SCENARIOS: tuple[Scenario, ...] = ("drop", "hold", "swing", "sweep")


@dataclass(frozen=True, slots=True, kw_only=True)
class Wishes:
    """What is wanted.

    Terms:
        drop: what may be left out, KIND or KIND@PATTERN. packages: folder by the name of a package. root: how the root is held.
        one_friction: static friction is taken to be the kinetic one. convex: the most convex pieces that a collision mesh is
        taken apart into, None for its hull. scenario: what happens to the robot. start: where joints start, None for what the
        companion says. strict: refuse every word that a format does not have. looks: read how it looks too, for pictures.
        tell: is told, in a sentence, of what takes long.
    """

    drop: frozenset[str] = frozenset()
    packages: Mapping[str, Path] = field(default_factory=dict)
    root: Root | None = None
    one_friction: bool = False
    convex: int | None = None
    scenario: Scenario | None = None
    start: Start | None = None
    strict: bool = False
    looks: bool = False
    tell: Callable[[str], object] | None = None

    @property
    def omissions(self) -> Omissions:
        """What is left out. Raises: RobotError."""
        return Omissions.of(self.drop)


def package_roots(given: "tuple[str, ...]") -> dict[str, Path]:
    """Folders by the names of packages, from texts NAME=DIR. Raises: RobotError."""
    roots: dict[str, Path] = {}
    for text in given:
        name, equals, folder = text.partition("=")
        if not equals or not name or not folder or "/" in name:
            raise RobotError(f"--package: {quoted(text)}, expected NAME=DIR")
        if name in roots:
            raise RobotError(f"--package: {quoted(name)} is given twice, expected once")
        if not Path(folder).is_dir():
            raise RobotError(f"--package: {quoted(name)} is {quoted(folder)}, expected a folder that is there")
        roots[name] = Path(folder)
    return roots
