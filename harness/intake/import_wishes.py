"""What a user asks of an import on the command line or from Python, beside what the companion file says."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from plumbline.harness.intake.refusal import RobotError
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
    "actuator": "actuators that are neither motors nor position servos of one joint",
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

Root = Literal["fixed", "floating"]
Scenario = Literal["drop", "hold", "swing", "sweep"]
Start = Literal["zero", "middle", "inside"]
STARTS: tuple[Start, ...] = ("zero", "middle", "inside")
SCENARIOS: tuple[Scenario, ...] = ("drop", "hold", "swing", "sweep")


@dataclass(frozen=True, slots=True, kw_only=True)
class Wishes:
    """What is wanted.

    Terms:
        drop: kinds of elements that may be left out. packages: folder by the name of a package. root: how the root is held.
        one_friction: static friction is taken to be the kinetic one. convex: the most convex pieces that a collision mesh is
        taken apart into, None for its hull. scenario: what happens to the robot. start: where joints start, None for what the
        companion says. strict: refuse every word that a format does not have. looks: read how it looks too, for pictures.
        tell: is told, in a sentence, of what takes long.
    """

    drop: frozenset[Drop] = frozenset()
    packages: Mapping[str, Path] = field(default_factory=dict)
    root: Root | None = None
    one_friction: bool = False
    convex: int | None = None
    scenario: Scenario | None = None
    start: Start | None = None
    strict: bool = False
    looks: bool = False
    tell: Callable[[str], object] | None = None


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
