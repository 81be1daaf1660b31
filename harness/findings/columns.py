"""One description of a table, for the terminal, CSV, JSON, Markdown and LaTeX.

A table is a list of objects. CSV and JSON hold their fields, and those of their parts, as they are; a terminal and a paper have
room for fewer, in words of their own.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

from plumbline.harness.statistics.interval import Interval

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store


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

    def scene(self, each: Any) -> str:
        """'A tower of boxes, n 4': a case and what tells its scene from others of it."""
        return self.cases[each.case] + (f", {each.where}" if each.where else "")

    def engine(self, each: Any) -> str:
        """The title of an object's engine."""
        return self.engines[each.engine]


class Column(NamedTuple):
    """What stands under a heading.

    Terms: value: the path of a field, or what makes a cell of an object. form: the format of a number; None makes an empty
    cell then. unit: what follows the number.
    """

    heading: str
    value: str | Callable[[Any], object]
    form: str = ""
    unit: str = ""

    def cell(self, each: Any) -> object:
        """The cell of an object."""
        value = self.value(each) if callable(self.value) else at(each, self.value)
        if not self.form:
            return value
        return "" if value is None else f"{value:{self.form}}{self.unit}"


class Titled(NamedTuple):
    """A column with titles in place of names."""

    heading: str
    value: Callable[[Titles, Any], object]


class _Flat(NamedTuple):
    """Columns of flat rows, one or those of an interval, the path of what stands in them, and what does where it is missing."""

    columns: tuple[str, ...]
    path: str
    none: str | None


_FLAT = re.compile(r"(\w+)(\.\.|\((\w+),(\w+)\))?(\?)?(?:=([\w.]+))?")


@cache
def _flat(text: str) -> tuple[_Flat, ...]:
    columns = []
    for word in text.split():
        name, interval, low, high, or_blank, path = _FLAT.fullmatch(word).groups()  # type: ignore[union-attr]
        ends = () if interval is None else (low or f"{name}_low", high or f"{name}_high")
        columns.append(_Flat((name, *ends), path or name, "" if or_blank else None))
    return tuple(columns)


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table of a run folder.

    Terms: holds: the columns of flat rows in their order, parted by blanks: 'dt' is the field of an object, 'dt=at.dt' that of
    its part `at` under this name, 'cost..' an interval as cost, cost_low and cost_high, 'cost(low,high)' as cost, low and high;
    what an object, or a part of it, does not have is None, or '' where the column is 'track?'. beside: likewise, what programs
    are told and a sheet has no room for. objects: what the rows are made of. shown: what a terminal has room for. sentences:
    what is said below the objects. paper: what a paper prints of them; nothing where it prints what a terminal shows.
    """

    holds: str
    beside: str = ""
    objects: Callable[["Store"], Iterable[Any]]
    shown: Sequence[Column]
    sentences: Callable[[Sequence[Any]], list[str]] = lambda _: []
    paper: Sequence[Column | Titled] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the columns of a sheet."""
        return tuple(name for flat in _flat(self.holds) for name in flat.columns)

    def flat(self, each: Any) -> dict[str, Any]:
        """An object as a flat row, with at least these columns."""
        row: dict[str, Any] = {}
        for columns, path, none in _flat(f"{self.holds} {self.beside}"):
            value = at(each, path)
            if len(columns) == 1:
                row[columns[0]] = none if value is None else value
            else:
                row |= zip(columns, value or (None, None, None), strict=True)
        return row

    def rows(self, store: "Store") -> list[dict[str, Any]]:
        """All flat rows."""
        return [self.flat(each) for each in self.objects(store)]

    def said(self, store: "Store") -> list[str]:
        """What is said of a store."""
        return self.sentences(tuple(self.objects(store)))

    def brief(self, each: Any) -> list[object]:
        """The cells of an object for a terminal."""
        return [column.cell(each) for column in self.shown]

    def printed(self, store: "Store", titles: Callable[[], Titles]) -> tuple[list[str], list[list[object]]]:
        """Headings and cells for a paper: the table's own, or what a terminal shows."""
        if not self.paper:
            return headings(self.shown), list(map(self.brief, self.objects(store)))
        return headings(self.paper), cells(self.paper, self.objects(store), titles())


def at(each: Any, path: str) -> Any:
    """What stands at 'fit.order' of an object or a mapping; None where a part is missing."""
    for name in path.split("."):
        each = each.get(name) if isinstance(each, Mapping) else getattr(each, name, None)
    return each


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
    """Columns of fields: 'step' under its own name, 'steps run=run.steps:.3g s' under another, with format and unit."""
    made = []
    for column in columns:
        heading, parted, value = column.partition("=")
        path, _, form = value.partition(":")
        form, blank, unit = form.partition(" ")
        made.append(Column(heading, path if parted else heading, form, blank + unit))
    return made


def names(of: type, *without: str, path: str = "") -> str:
    """The fields of a dataclass as `Table.holds` takes them, but for some. Args: path: to what has the fields."""
    chosen = [field for field in fields(of) if field.name not in without]
    intervals = (".." if Interval in (field.type, *get_args(field.type)) else "" for field in chosen)
    paths = (f"={path}.{field.name}" if path else "" for field in chosen)
    return " ".join(f"{field.name}{ends}{source}" for field, ends, source in zip(chosen, intervals, paths, strict=True))


def scene(each: Any) -> str:
    """'friction_slip_to_roll speed 5.5': a case with what tells its scene from others of it."""
    return f"{each.case} {each.where or ''}".strip()


def side(each: Any) -> str:
    """An engine with its track."""
    return f"{each.engine}/{each.track}"


def outcome(each: Any, length: int) -> str:
    """A verdict with so many characters of its reason."""
    return f"{each.verdict}: {each.reason[:length]}" if each.reason else str(each.verdict)


def bracketed(value: Interval | None, form: str, parted: str = " .. ") -> str:
    """The ends of an interval; nothing of none."""
    return "" if value is None else f"{value.low:{form}}{parted}{value.high:{form}}"


def milli(value: float | None) -> float | None:
    """In thousandths."""
    return None if value is None else 1e3 * value


def span(value: Interval | None, times: float = 1.0) -> Span | None:
    """An interval, in another unit; None where an end of it is not known."""
    return None if value is None or value.low is None or value.high is None else Span(times * value.low, times * value.high)


def known(each: object | None, *names: str) -> dict[str, Any]:
    """These fields of an object by name; None each where there is no object."""
    return {name: None if each is None else getattr(each, name) for name in names}
