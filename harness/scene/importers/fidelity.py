"""What became of each element of a robot file: one typed row, and no sentence that anybody reads back."""

from dataclasses import asdict, dataclass
from typing import Any, Literal

from plumbline.harness.intake.error import listed

Outcome = Literal["exact", "approximated", "left_out"]
"""Carried over as it is; as something else, with an error; not at all."""
Names = str | tuple[str, ...] | list[str]


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
