"""What an engine's own loader made of a robot file: a robot, and how well its own mass matrix agrees."""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from plumbline.harness.intake.import_wishes import Root
from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.importers.robot import Closure, Link, Need, Robot, Solid
from plumbline.harness.scene.parity.canonical import SCALAR, canonical
from plumbline.harness.scene.parity.motion import Configuration, dynamics

_PACKAGED = re.compile(r"(?:package|model)://([^/]+)/(.+)", re.DOTALL)


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What a loader is asked.

    Terms:
        way: one of `Adapter.loaders`. root: how it is to hold a root of which the file says nothing. packages: folders by the
        names of package://.
    """

    way: str = ""
    root: Root = "fixed"
    packages: Mapping[str, Path] = field(default_factory=dict)


UNTOLD = frozenset(("drive", "shape", "touch"))
"""What is asked of no loader."""


def in_packages(reference: str, packages: Mapping[str, Path]) -> Path | None:
    """The file that a package:// reference names; None for another reference, or an unknown package."""
    parts = _PACKAGED.fullmatch(reference)
    return None if parts is None or parts[1] not in packages else packages[parts[1]] / parts[2]


@dataclass(frozen=True, slots=True)
class Own:
    """What a loader gives shapes of which a URDF says nothing. Terms: values: those that there are, ascending."""

    quantity: str
    values: tuple[float, ...]
    unit: str


def own_values(quantity: str, values: Iterable[float], unit: str) -> tuple[Own, ...]:
    """One row of all shapes; none where there is no shape."""
    distinct = tuple(sorted({float(value) for value in values}))
    return (Own(quantity, distinct, unit),) if distinct else ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loaded:
    """Terms: robot: by the engine's own means. matrix_gap: the largest difference between the engine's own mass matrix and
    that of the robot, relative to its largest entry, at three poses; None where the engine gives none. notes: in words. own: of
    a URDF, what its shapes are given that the format has no word for."""

    robot: Robot
    matrix_gap: float | None = None
    notes: tuple[str, ...] = ()
    own: tuple[Own, ...] = ()


def read_back(
    source: str, links: Iterable[Link], closures: Iterable[Closure] = (), needs: tuple[Need, ...] = (), *, wordless: str = ""
) -> Robot:
    """An engine's robot.

    Args: links: parents before children, with frames that are W's where all coordinates are at 0. wordless: what of a
    Coordinate the engine has no word for.
    """
    unsaid = UNTOLD | ({wordless} if wordless else set())
    return Robot(name="", links=tuple(links), closures=tuple(closures), needs=needs, wordless=unsaid, source=source)


def solid_of(mass: float, centre: Array, inertia: Array) -> Solid | None:
    """What a link weighs; a tensor without a mass counts where the link is fixed to one."""
    return Solid(mass, centre, inertia) if mass > 0 or inertia.any() else None


def matrix_gap(whole: Robot, matrix: Callable[[dict[str, float]], Array | None]) -> float | None:
    """See Loaded. Axes are taken as directions.

    Args: matrix: the engine's own mass matrix in the order of the robot's joints, by the joints' positions.
    """
    robot = canonical(whole, read_back=True)
    joints = [replace(joint, axis=joint.axis / np.linalg.norm(joint.axis)) for joint in robot.joints]
    if not joints or any(joint.kind not in SCALAR for joint in joints):
        return None
    straight = {joint.name: (joint,) for joint in joints}
    robot = replace(robot, links=tuple(replace(link, coordinates=straight.get(link.name, ())) for link in robot.links))
    rng, gap = np.random.default_rng(0), 0.0
    for _ in range(3):
        q = rng.uniform(-0.5, 0.5, len(joints))
        engine = matrix({joint.name: float(x) for joint, x in zip(joints, q, strict=True)})
        if engine is None:
            return None
        ours = dynamics(robot, Configuration(q, {}, np.zeros_like(q)), np.zeros(3)).M
        ours = ours + np.diag([joint.armature for joint in joints])
        gap = max(gap, float(np.abs(engine - ours).max() / np.abs(ours).max()))
    return gap
