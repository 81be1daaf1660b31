"""What an engine's own loader made of a robot file: its links gathered to facts, and how well its own mass matrix agrees."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.harness.intake.import_wishes import Root
from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.importers.robot import Solid
from plumbline.harness.scene.importers.solids import together
from plumbline.harness.scene.parity.facts import FIXED, JointFacts, Law, MassFacts, RobotFacts
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoadedLink:
    """One link of an engine's model, all coordinates at 0.

    Terms: parent: the link above, None for the world. joints: those between the two, from the parent on; none where it is
    fixed; their parents are filled in. mass [kg], centre [m] in W, inertia [kg m2] about it in W's axes.
    """

    name: str
    parent: str | None
    joints: tuple[JointFacts, ...]
    mass: float
    centre: Array
    inertia: Array


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
    """Terms: facts: by the engine's own means. matrix_gap: the largest difference between the engine's own mass matrix and
    that of the facts, relative to its largest entry, at three poses; None where the engine gives none. notes: in words. own: of
    a URDF, what its shapes are given that the format has no word for."""

    facts: RobotFacts
    matrix_gap: float | None = None
    notes: tuple[str, ...] = ()
    own: tuple[Own, ...] = ()


def gathered(
    source: str,
    links: Sequence[LoadedLink],
    laws: tuple[Law, ...] = (),
    wordless: frozenset[str] = frozenset(),
) -> RobotFacts:
    """The facts of an engine's links, parents before children; what fixed joints hold together is merged."""
    last: dict[str, str] = {}
    joints: list[JointFacts] = []
    solids: dict[str, list[Solid]] = {}
    members: dict[str, list[str]] = {}
    for link in links:
        above = FIXED if link.parent is None else last[link.parent]
        for joint in link.joints:
            joints.append(_under(joint, above))
            above = joint.name
        last[link.name] = above
        if above != FIXED:
            members.setdefault(above, []).append(link.name)
            if link.mass > 0 or link.inertia.any():  # a tensor without a mass counts where it is fixed to one
                solids.setdefault(above, []).append(Solid(link.mass, link.centre, link.inertia))
    masses = {}
    for name, held in solids.items():
        whole = together(held)
        assert whole.inertia is not None
        masses[name] = MassFacts(
            joint=name, members=tuple(members[name]), mass=whole.mass, centre=whole.centre, inertia=whole.inertia
        )
    return RobotFacts(source=source, joints=tuple(joints), masses=masses, laws=laws, wordless=wordless | UNTOLD)


def _under(joint: JointFacts, parent: str) -> JointFacts:
    return replace(joint, parent=parent)


def matrix_gap(robot: RobotFacts, matrix: Callable[[dict[str, float]], Array | None]) -> float | None:
    """See Loaded. Axes are taken as directions.

    Args: matrix: the engine's own mass matrix in the order of the facts' joints, by the joints' positions.
    """
    robot = replace(robot, joints=tuple(replace(joint, axis=joint.axis / np.linalg.norm(joint.axis)) for joint in robot.joints))
    if not robot.joints or any(joint.kind not in ("revolute", "prismatic") for joint in robot.joints):
        return None
    rng, gap = np.random.default_rng(0), 0.0
    for _ in range(3):
        q = rng.uniform(-0.5, 0.5, len(robot.joints))
        engine = matrix({joint.name: float(x) for joint, x in zip(robot.joints, q, strict=True)})
        if engine is None:
            return None
        ours = dynamics(robot, Configuration(q, {}, np.zeros_like(q)), np.zeros(3)).M
        ours = ours + np.diag([joint.armature for joint in robot.joints])
        gap = max(gap, float(np.abs(engine - ours).max() / np.abs(ours).max()))
    return gap


def stored(loaded: Loaded) -> dict[str, Any]:
    """As JSON takes it."""

    def plain(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return value.tolist()
        if isinstance(value, dict):
            return {key: plain(each) for key, each in value.items()}
        if isinstance(value, list | tuple):
            return [plain(each) for each in value]
        return sorted(value) if isinstance(value, frozenset) else value

    table: dict[str, Any] = plain(asdict(loaded))
    return table


def restored(table: dict[str, Any]) -> Loaded:
    """What `stored` has made plain."""
    facts = table["facts"]
    joints = (
        JointFacts(**{**joint, "axis": np.array(joint["axis"]), "anchor": np.array(joint["anchor"])})
        for joint in facts["joints"]
    )
    masses = {
        name: MassFacts(
            joint=name,
            members=tuple(solid["members"]),
            mass=solid["mass"],
            centre=np.array(solid["centre"]),
            inertia=np.array(solid["inertia"]),
        )
        for name, solid in facts["masses"].items()
    }
    laws = tuple(
        Law(**{**law, "partners": tuple(law["partners"]), "points": law["points"] and tuple(map(tuple, law["points"]))})
        for law in facts["laws"]
    )
    robot = RobotFacts(
        source=facts["source"], joints=tuple(joints), masses=masses, laws=laws, wordless=frozenset(facts["wordless"])
    )
    own = tuple(Own(**{**each, "values": tuple(each["values"])}) for each in table["own"])
    return Loaded(facts=robot, matrix_gap=table["matrix_gap"], notes=tuple(table["notes"]), own=own)
