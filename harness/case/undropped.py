"""What a robot's user left out of its scene (`--drop`): the scene that has it, and which kinds of elements those are.

The import keeps that scene beside the one that is run, as `NAME.undropped.toml`.
"""

from itertools import combinations
from pathlib import Path, PurePath

from plumbline.harness.scene import Prismatic, Revolute, Scene
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.scene.importers.reading import read

KINDS = {"armature": "armature", "friction_loss": "friction_loss", "coupling": "mimic"}
"""What `--drop` calls what a joint may lack, by the name of the joint's field."""


def beside(path: Path) -> Path:
    """Where the scene with nothing dropped lies, of a scene file."""
    return path.with_name(f"{path.stem}.undropped.toml")


def undropped_scene(path: Path) -> Scene | None:
    """The scene with nothing dropped that lies beside a scene file; None where none does. Raises: SceneError."""
    whole = beside(path)
    return read(whole, companion=Companion()).scene if whole.is_file() else None


def kinds_left_out(scene: Scene, undropped: Scene) -> tuple[str, ...]:
    """The kinds of elements that joints of the scene lack and the same ones of the other have, and contacts of links."""
    had = {joint.name: joint for joint in undropped.joints}
    pairs = [(joint, had[joint.name]) for joint in scene.joints if joint.name in had]
    contacts = ("self_collision",) if _touching(scene) != _touching(undropped) else ()
    tendons = ("tendon",) if scene.tendons != undropped.tendons else ()
    return (
        contacts
        + tendons
        + tuple(
            kind
            for field, kind in KINDS.items()
            if any(
                getattr(here, field) != getattr(there, field)
                for here, there in pairs
                if isinstance(here, Revolute | Prismatic) and isinstance(there, Revolute | Prismatic)
            )
        )
    )


def _touching(scene: Scene) -> set[frozenset[str]]:
    """The pairs of moving bodies that may touch."""
    movable = [body for body in scene.bodies if body.movable and body.collision]
    return {frozenset((a.name, b.name)) for a, b in combinations(movable, 2) if scene.collides(a, b)}


OWN = "scene:"
"""How the name of a case says that it lies in a file."""


def title_of(path: PurePath) -> str:
    """'My arm' of my_arm.toml."""
    words = " ".join(path.stem.replace("_", " ").replace("-", " ").split()) or path.stem
    return words[:1].upper() + words[1:]


def called(case: str) -> str:
    """The name of a case; of a scene of the user's own its title."""
    return title_of(PurePath(case.removeprefix(OWN))) if case.startswith(OWN) else case
