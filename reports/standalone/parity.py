"""The page of a comparison of robot files: what an importer makes of a robot, or whether two files are the same one."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plumbline.harness.store.imported_scenes import ParityRecord, ParitySide, read
from plumbline.reports.charts.marks import looks
from plumbline.reports.html.policy import copy_style, guarded
from plumbline.reports.html.template import environment
from plumbline.reports.words.text import amount, unit_text

DERIVED = ("gravity torque", "mass matrix", "acceleration")


ParityRow = Mapping[str, Any]
"""A difference as recorded, in words. Terms: size: how it differs. torque: its consequence, '' where it has none. bar: share of
the worst torque of all sides, 0 to 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ParityPanel:
    """One side. Terms: causes: the worst first. derived: what follows from them. worst: the largest consequence, in words."""

    side: ParitySide
    causes: tuple[ParityRow, ...]
    derived: tuple[ParityRow, ...]
    worst: str

    @property
    def undocumented(self) -> int:
        """How many causes no documentation tells."""
        return sum(not row["documented"] for row in self.causes)


def write_page(folder: Path) -> Path:
    """`folder/index.html` and its style, from `folder/parity.json`."""
    record = read(folder)
    copy_style(folder)
    page = folder / "index.html"
    page.write_text(guarded(rendered(record)), encoding="utf-8", errors="backslashreplace", newline="\n")
    return page


def rendered(record: ParityRecord) -> str:
    """The page's text."""
    most = max((row["torque"] or 0.0 for side in record.sides for row in side.rows), default=0.0)
    panels = tuple(_panel(side, most) for side in record.sides)
    engines = sorted({side.engine for side in record.sides if side.engine})
    drawn, kinds = looks(dict.fromkeys(engines)), _kinds(panels)
    page = environment().get_template("parity.html")
    return page.render(record=record, panels=panels, audit=bool(engines), looks=drawn, kinds=kinds, navigation=())


def _panel(side: ParitySide, most: float) -> ParityPanel:
    causes = sorted((row for row in side.rows if row["quantity"] not in DERIVED), key=lambda row: -(row["torque"] or 0.0))
    derived = [row for row in side.rows if row["quantity"] in DERIVED]
    return ParityPanel(
        side=side,
        causes=tuple(_row(row, most) for row in causes),
        derived=tuple(_row(row, most) for row in derived),
        worst=_worst(side.rows),
    )


def _worst(rows: Sequence[Mapping[str, Any]]) -> str:
    row = max(rows, key=lambda candidate: float(candidate["torque"] or 0.0), default=None)
    return f"{amount(row['torque'])} {unit_text(row['torque_unit'])}" if row and row["torque"] else ""


def _row(row: dict[str, Any], most: float) -> ParityRow:
    size = "" if row["absolute"] is None else f"{amount(row['absolute'])} {unit_text(row['unit'])}".strip()
    if row["relative"] is not None:
        size += f" ({amount(row['relative'])} relative)" if size else f"{amount(row['relative'])} relative"
    followed = row["torque"] is not None
    return row | {
        "quantity": row["quantity"].replace("_", " "),
        "value_A": _shown(row["value_A"]),
        "value_B": _shown(row["value_B"]),
        "unit": unit_text(row["unit"]),
        "size": size,
        "torque": f"{amount(row['torque'])} {unit_text(row['torque_unit'])}" if followed else "",
        "words": "" if followed else row["words"],
        "bar": (row["torque"] or 0.0) / most if most > 0 else 0.0,
    }


def _shown(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, list):
        return ", ".join(amount(number, 5) for number in value)
    return amount(value, 6) if isinstance(value, float | int) else str(value)


def _kinds(panels: Sequence[ParityPanel]) -> list[tuple[str, list[tuple[int, bool]]]]:
    """Kinds of changes, the most frequent first: how many of each every side has, and whether all are documented."""
    names = Counter(row["kind"] for panel in panels for row in panel.causes if row["kind"])
    table = []
    for name in sorted(names, key=lambda kind: (-names[kind], kind)):
        cells = [[row for row in panel.causes if row["kind"] == name] for panel in panels]
        table.append((name, [(len(rows), bool(rows) and all(row["documented"] for row in rows)) for rows in cells]))
    return table
