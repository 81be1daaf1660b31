"""Targets of joints over time from a CSV file: a column of times [s], then one column a joint [rad or m]."""

import csv
import math
from pathlib import Path

from plumbline.harness.intake.allowance import beyond
from plumbline.harness.intake.documents import InputError, named, read
from plumbline.harness.intake.refusal import RobotError, listed
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene.motion import MOST_SAMPLES, Samples

TIME = "time"
"""The name of the first column."""


def load_commands(path: Path) -> dict[str, Samples]:
    """The motions of a CSV file by the names of their joints.

    Raises:
        RobotError: naming file, line, column, value and expectation; for what is larger than allowed too.
    """
    where = named(path)
    try:
        lines = read(path).removeprefix("\ufeff").splitlines()
    except InputError as error:
        raise RobotError(str(error)) from None
    rows = [(number, cells) for number, cells in enumerate(_rows(lines, where), 1) if any(cell.strip() for cell in cells)]
    if not rows:
        raise RobotError(f"{where}: is empty, expected a first line like {TIME},JOINT,JOINT")
    names = _header(rows[0][1], f"{where}: line {rows[0][0]}")
    if len(rows) - 1 > MOST_SAMPLES or len(rows) == 1:
        raise RobotError(f"{where}: {len(rows) - 1} lines of numbers, expected 1 to {MOST_SAMPLES}")
    if excess := beyond("parts", (len(rows) - 1) * len(names), "numbers"):
        raise RobotError(f"{where}: {excess}")
    columns: list[list[float]] = [[] for _ in names]
    for number, cells in rows[1:]:
        if len(cells) != len(names):
            raise RobotError(f"{where}: line {number}: {len(cells)} values, expected {len(names)}: {listed(names, 8)}")
        for name, cell, column in zip(names, cells, columns, strict=True):
            column.append(_number(cell, f"{where}: line {number}: column {quoted(name, 80)}"))
        times = columns[0]
        if len(times) > 1 and times[-1] <= times[-2]:
            raise RobotError(
                f"{where}: line {number}: column {quoted(TIME)}: {times[-1]:g} after {times[-2]:g}, expected a later time"
            )
    return {
        name: Samples(time=tuple(columns[0]), target=tuple(column)) for name, column in zip(names[1:], columns[1:], strict=True)
    }


def _rows(lines: list[str], where: str) -> list[list[str]]:
    try:
        return list(csv.reader(lines, strict=True))
    except csv.Error as error:
        raise RobotError(f"{where}: no CSV: {error}; expected values with commas between them") from None


def _header(cells: list[str], where: str) -> list[str]:
    names = [cell.strip() for cell in cells]
    if names[0] != TIME or len(names) < 2:
        raise RobotError(f"{where}: {listed(names, 4)}, expected {TIME} and then the names of joints")
    for name in names:
        if not name or names.count(name) > 1:
            raise RobotError(
                f"{where}: column {quoted(name, 80)} {'is twice there' if name else 'has no name'}, expected names, each once"
            )
    return names


def _number(cell: str, where: str) -> float:
    try:
        value = float(cell) if len(cell) < 60 else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RobotError(f"{where}: {quoted(cell, 60)}, expected a finite number")
    return value
