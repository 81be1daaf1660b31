"""A finding about an engine, which is what the head of its script says; and all findings that the project has.

The head is a block of inline script metadata (PyPA specification of that name, PEP 723): TOML in comments, from `# /// script`
to `# ///`. What the finding says of itself stands in its table `tool.finding`.
"""

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

FindingKind = Literal["bug", "trap", "limit"]
"""bug: against what the vendor documents, or the format read; trap: documented, or told, and easily fallen into; limit: the
method's."""

_HEAD = re.compile(r"(?m)^# /// script$\s(?P<content>(^#(| .*)$\s)+)^# ///$")


class FindingError(ValueError):
    """The head of a script is missing or says something that no finding has."""


class _Table(BaseModel):
    """`tool.finding`, as written."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    engine: str = Field(min_length=1)
    kind: FindingKind
    title: str = Field(min_length=1)
    seen: list[str] = Field(min_length=1)
    documented: str = Field(min_length=1)
    sources: list[str] = Field(min_length=1)
    mend: str = Field(min_length=1)
    cases: list[str]
    tracks: list[str] = Field(default=["default", "tuned"], min_length=1)
    effects: list[str] = []
    cause: str = ""


@dataclass(frozen=True)
class Finding:
    """What a script is about.

    name: engine and file name, as the command line takes it. kind, title, documented, mend: see `findings/README.md`. seen: the
    versions in which it was found. sources: where the vendor says so, and earlier reports. cases: those of the catalogue that
    it shows in, on `tracks`. effects: of scenes, that it adds or takes away. cause: what it is called where cases fail by it,
    '' where it makes no answer wrong. requires: what the script needs installed, as requirements of a package index. script:
    the file. text: all of it."""

    name: str
    engine: str
    kind: FindingKind
    title: str
    seen: tuple[str, ...]
    documented: str
    sources: tuple[str, ...]
    mend: str
    cases: tuple[str, ...]
    requires: tuple[str, ...]
    script: Path
    text: str
    tracks: tuple[str, ...] = ("default", "tuned")
    effects: tuple[str, ...] = ()
    cause: str = ""

    @property
    def body(self) -> str:
        """What a reader of the script alone sees."""
        return _HEAD.sub("", self.text).strip()

    @property
    def standalone(self) -> str:
        """The script without this project's table: its head says what it needs, and no more."""
        return re.sub(r"(?m)^#\n# \[tool\.finding\]\n(?:#(?! ///$).*\n)*", "", self.text).strip()


def _head(path: Path, text: str) -> dict[str, Any]:
    match = _HEAD.search(text)
    if match is None:
        raise FindingError(f"{path}: no block from '# /// script' to '# ///' at its head")
    content = "".join(line[2:] if line.startswith("# ") else line[1:] for line in match["content"].splitlines(keepends=True))
    try:
        return tomllib.loads(content)
    except tomllib.TOMLDecodeError as error:
        raise FindingError(f"{path}: head: {error}") from None


def read_finding(path: Path) -> Finding:
    """The finding of a script. Raises: FindingError, with file, field and value; OSError."""
    text = path.read_text(encoding="utf-8")
    head = _head(path, text)
    try:
        table = _Table.model_validate(head.get("tool", {}).get("finding", {}))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise FindingError(f"{path}: tool.finding.{where}: {first['msg']}, not {first['input']!r}") from None
    if table.engine != path.parent.name:
        raise FindingError(f"{path}: tool.finding.engine: '{table.engine}', in the folder of '{path.parent.name}'")
    fields: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in table}
    return Finding(
        name=f"{table.engine}/{path.stem}",
        requires=tuple(head.get("dependencies", ())),
        script=path,
        text=text,
        **fields,
    )


FOLDER = Path(__file__).resolve().parents[3] / "findings"
"""Where the scripts lie, a folder an engine."""


def shelf(folder: Path = FOLDER) -> list[Finding]:
    """Every finding by name. Raises: FindingError, OSError."""
    return [read_finding(path) for path in sorted(folder.glob("*/*.py"))]


def chosen(findings: Sequence[Finding], asked: str) -> list[Finding]:
    """Those of an engine, or the one of this name. Raises: FindingError, with what there is."""
    found = [finding for finding in findings if asked in (finding.engine, finding.name)]
    if not found:
        names = sorted({finding.engine for finding in findings}) + [finding.name for finding in findings]
        raise FindingError(f"no engine and no finding is called '{asked}'; there are {', '.join(names)}")
    return found
