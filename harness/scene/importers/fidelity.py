"""What became of a robot file: its scene, and of each element one typed row, no sentence that anybody reads back."""

import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from plumbline.harness.intake.error import listed
from plumbline.harness.scene import PlacedShape, Scene

Outcome = Literal["exact", "approximated", "left_out"]
"""Carried over as it is; as something else, with an error; not at all."""
Names = str | tuple[str, ...] | list[str]
FATES: dict[str, list[Any]] = tomllib.loads(Path(__file__).with_name("fidelity.toml").read_text(encoding="utf-8"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Fidelity:
    """One element of a file, or all of a kind that share a fate.

    Terms:
        element: its kind in the format's own word. name: whose, several joined. count: how many. becomes: what it is in the
        scene, '' for nothing. consequence: what that may change, in words. value [unit]: the size of that, where it can be
        worked out.
    """

    element: str
    name: str
    outcome: Outcome
    becomes: str = ""
    consequence: str = ""
    value: float | None = None
    unit: str = ""
    count: int = 1

    @classmethod
    def of(cls, outcome: Outcome, element: str, names: Names, becomes: str = "", **fields: Any) -> "list[Fidelity]":
        """The row of all these names, with the other fields; none for a list without names. Args: names: a text is one name."""
        if not isinstance(names, str):
            fields["count"] = len(names)
        name = names if isinstance(names, str) else listed(names)
        return [cls(element=element, name=name, outcome=outcome, becomes=becomes, **fields)] if fields.get("count", 1) else []

    @classmethod
    def exact(cls, element: str, names: Names, becomes: str = "", **fields: Any) -> "list[Fidelity]":
        """What is carried over as it is."""
        return cls.of("exact", element, names, becomes, **fields)

    @classmethod
    def approximated(cls, element: str, names: Names, becomes: str, **fields: Any) -> "list[Fidelity]":
        """What becomes something else."""
        return cls.of("approximated", element, names, becomes, **fields)

    @classmethod
    def left_out(cls, element: str, names: Names, consequence: str, **fields: Any) -> "list[Fidelity]":
        """What is not carried over."""
        return cls.of("left_out", element, names, consequence=consequence, **fields)

    @classmethod
    def told(cls, fate: str, names: Names, value: float | None = None, count: int = 1, **holes: Any) -> "list[Fidelity]":
        """The row of a fate that fidelity.toml tells, what is in its braces filled in."""
        outcome, element, *texts = FATES[fate]
        unit, becomes, consequence = (text.format(**holes) for text in texts)
        return cls.of(outcome, element, names, becomes, consequence=consequence, value=value, unit=unit, count=count)


COLUMNS = ("element", "name", "count", "outcome", "becomes", "consequence", "value", "unit")
BRIEF = ("element", "name", "outcome", "becomes", "consequence")


def plain(row: Fidelity) -> dict[str, Any]:
    """The row as a flat dictionary with the keys COLUMNS."""
    fields = asdict(row)
    return {name: fields[name] for name in COLUMNS}


def brief(row: dict[str, Any]) -> list[object]:
    """The cells of a plain row that a terminal has room for, the number behind its consequence."""
    value = "" if row["value"] is None else f": {row['value']:.3g}{'' if row['unit'] == '1' else ' ' + row['unit']}"
    return [row["element"], row["name"], row["outcome"].replace("_", " "), row["becomes"], f"{row['consequence']}{value}"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Imported:
    """A scene and where it comes from.

    Terms:
        name: of the robot or the scene. source: the file, in words. fidelity: what became of each element. coordinates: by the
        name of each joint of the file, its value at the start [rad or m]; joints that were merged away are not among them.
        links: by the name of each link, the body that it is part of. dropped: what the user left out.
        undropped: the scene with those of them that a scene has words for; None where none of the robot's is among them.
        looks: by body, what is drawn of it where that is not in the scene itself; empty unless asked for.
        duration [s], dt [s], look_at, seed: what the companion says of the run.
    """

    name: str
    scene: Scene
    source: str
    fidelity: tuple[Fidelity, ...] = ()
    coordinates: Mapping[str, float] = field(default_factory=dict)
    links: Mapping[str, str] = field(default_factory=dict)
    dropped: tuple[str, ...] = ()
    undropped: Scene | None = None
    looks: Mapping[str, tuple[PlacedShape, ...]] = field(default_factory=dict)
    duration: float | None = None
    dt: float | None = None
    look_at: tuple[str, ...] = ()
    seed: int | None = None
