"""One description of a table, for the terminal, CSV, JSON, Markdown and LaTeX.

A table is a list of objects with fields. CSV and JSON hold the fields as they are; a terminal and a paper have room for fewer,
in words of their own.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

from plumbline.harness.statistics.interval import Interval

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store

Row = Mapping[str, Any]
"""A flat row: the fields of an object by name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """What a row is of: an engine under one group of settings in one scene. Terms: where: what tells the scene from its case as
    it is, in words."""

    case: str
    where: str
    engine: str
    track: str

    @property
    def cell(self) -> dict[str, str]:
        """These four by name, for what else is said of the same."""
        return {"case": self.case, "where": self.where, "engine": self.engine, "track": self.track}


@dataclass(frozen=True, slots=True)
class Span:
    """An interval, printed low to high."""

    low: float
    high: float


class Titles(NamedTuple):
    """What cases and engines are called on pages, by name."""

    cases: Mapping[str, str]
    engines: Mapping[str, str]

    def scene(self, row: Any) -> str:
        """'A tower of boxes, n 4': a case and what tells its scene from others of it."""
        return self.cases[row.case] + (f", {row.where}" if row.where else "")

    def engine(self, row: Any) -> str:
        """The title of a row's engine."""
        return self.engines[row.engine]


class Column(NamedTuple):
    """What stands under a heading.

    Terms: value: the name of a field, or what makes a cell of a row. form: the format of a number; None makes an empty
    cell then. unit: what follows the number.
    """

    heading: str
    value: str | Callable[[Any], object]
    form: str = ""
    unit: str = ""

    def cell(self, row: Any) -> object:
        """The cell of a flat row, or of an object."""
        if callable(self.value):
            value = self.value(row)
        else:
            value = row[self.value] if isinstance(row, Mapping) else getattr(row, self.value)
        if not self.form:
            return value
        return "" if value is None else f"{value:{self.form}}{self.unit}"


class Titled(NamedTuple):
    """A column with titles in place of names."""

    heading: str
    value: Callable[[Titles, Any], object]


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table of a run folder.

    Terms: columns: of the flat rows, in this order. objects: what the rows are made of; row: an object as a row, where it is
    not its fields; bare: as `spread` takes it. shown: what a terminal has room for. sentences: what is said below the rows.
    paper: what a paper prints of the objects; nothing where it prints what a terminal shows.
    """

    columns: Sequence[str]
    objects: Callable[["Store"], Iterable[Any]]
    row: Callable[[Any], dict[str, Any]] | None = None
    bare: str = ""
    shown: Sequence[Column]
    sentences: Callable[[Sequence[Row]], list[str]] = lambda _: []
    paper: Sequence[Column | Titled] = ()

    def flat(self, each: Any) -> dict[str, Any]:
        """An object as a flat row."""
        return spread(each, self.bare) if self.row is None else self.row(each)

    def rows(self, store: "Store") -> list[dict[str, Any]]:
        """Flat rows with at least these columns."""
        return [self.flat(each) for each in self.objects(store)]

    def brief(self, row: Row) -> list[object]:
        """The cells of a flat row for a terminal."""
        return [column.cell(row) for column in self.shown]

    def printed(self, store: "Store", titles: Callable[[], Titles]) -> tuple[list[str], list[list[object]]]:
        """Headings and cells for a paper: the table's own, or what a terminal shows."""
        if not self.paper:
            return headings(self.shown), list(map(self.brief, self.rows(store)))
        return headings(self.paper), cells(self.paper, self.objects(store), titles())


def cells(columns: Sequence[Column | Titled], objects: Iterable[Any], titles: Titles) -> list[list[object]]:
    """The cells of objects, row by row."""
    return [
        [column.value(titles, each) if isinstance(column, Titled) else column.cell(each) for column in columns]
        for each in objects
    ]


def headings(columns: Iterable[Column | Titled]) -> list[str]:
    """The headings of these columns."""
    return [column.heading for column in columns]


def plain(*columns: str) -> list[Column]:
    """Columns under the names of their fields."""
    return [Column(name, name) for name in columns]


def names(of: type, bare: str = "") -> tuple[str, ...]:
    """The names of a dataclass's fields, each interval as `spread` has it."""
    return tuple(
        name
        for field in fields(of)
        for name in (_interval_columns(field.name, bare) if Interval in (field.type, *get_args(field.type)) else (field.name,))
    )


def spread(each: Any, bare: str = "") -> dict[str, Any]:
    """The fields of an object as a flat row: an interval is three columns, `cost`, `cost_low` and `cost_high`.

    Args: bare: the interval whose ends are called `low` and `high` alone.
    """
    row: dict[str, Any] = {}
    for field in fields(each):
        value = getattr(each, field.name)
        if Interval in (field.type, *get_args(field.type)):
            row |= zip(_interval_columns(field.name, bare), value or (None, None, None), strict=True)
        else:
            row[field.name] = value
    return row


def _interval_columns(name: str, bare: str) -> tuple[str, str, str]:
    return (name, "low", "high") if name == bare else (name, f"{name}_low", f"{name}_high")


def scene(row: Row) -> str:
    """'friction_slip_to_roll speed 5.5': a case with what tells its scene from others of it."""
    return f"{row['case']} {row['where']}".strip()


def side(row: Row) -> str:
    """An engine with its track."""
    return f"{row['engine']}/{row['track']}"


def outcome(row: Row, length: int) -> str:
    """The verdict of a row with so many characters of its reason."""
    return f"{row['verdict']}: {row['reason'][:length]}" if row["reason"] else str(row["verdict"])


def milli(value: float | None) -> float | None:
    """In thousandths."""
    return None if value is None else 1e3 * value


def span(low: float | None, high: float | None) -> Span | None:
    """An interval; None where an end of it is not known."""
    return None if low is None or high is None else Span(low, high)


def known(each: object | None, *names: str) -> dict[str, Any]:
    """These fields of an object by name; None each where there is no object."""
    return {name: None if each is None else getattr(each, name) for name in names}
