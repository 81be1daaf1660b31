"""A finding about an engine, which is what the head of its script says; and all findings that the project has.

The head is a block of inline script metadata (PyPA specification of that name, PEP 723): TOML in comments, from `# /// script`
to `# ///`. What the finding says of itself stands in its table `tool.finding`.
"""

import ast
import platform
import re
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from plumbline.harness.findings.spoken import SPOKEN
from plumbline.harness.intake.bounded import bounded

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
        name=f"{table.engine}/{path.stem}", requires=tuple(head.get("dependencies", ())), script=path, text=text, **fields
    )


FOLDER = Path(__file__).resolve().parents[2] / "findings"
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


SECONDS = 60.0
"""After which a script counts as hung: six times what one may take on a machine that does nothing else."""

ScriptVerdict = Literal["still there", "gone", "stands", "unavailable", "failed"]
"""stands: it is there with its mend; unavailable: what the script needs is not installed; failed: no answer."""

_UNAVAILABLE = "ModuleNotFoundError"
_PRICE = re.compile(r"price: (\S+) of an? (\w+)$", re.MULTILINE)


@dataclass(frozen=True)
class Mended:
    """What a script said of its mend.

    verdict: 'gone' if the mend cures it. figure: in the script's own words. price: time of a `unit` (step, ray, loading, ...)
    with the mend over that without, clocked in turns in one process; None without an answer."""

    verdict: ScriptVerdict
    figure: str
    price: float | None = None
    unit: str = ""

    @property
    def cures(self) -> bool:
        """Is the finding gone with its mend?"""
        return self.verdict == "gone"


@dataclass(frozen=True)
class ScriptAnswer:
    """What a script said.

    finding: which. verdict: of it. figure: in the script's own words, or why there is none. version: of the engine that is
    installed, '' where none is. seconds: how long it took, by the wall. mended: the same with its mend, None if not asked."""

    finding: Finding
    verdict: ScriptVerdict
    figure: str
    version: str
    seconds: float
    mended: Mended | None = None

    @property
    def broken(self) -> bool:
        """Did the script end without an answer, or does its mend not cure it?"""
        mended = self.mended
        return self.verdict == "failed" or (mended is not None and not mended.cures and mended.verdict != "unavailable")


def _version(finding: Finding, python: str) -> str:
    """Of the package that the script's first requirement names, in whichever interpreter runs it."""
    package = finding.requires[0].partition("=")[0] if finding.requires else finding.engine
    command = f"import importlib.metadata as m; print(m.version({package!r}))"
    return bounded([python, "-I", "-c", command], SECONDS).out.decode("utf-8", "replace").strip()


def _answer(finding: Finding, python: str, *arguments: str) -> tuple[ScriptVerdict, str, str]:
    """Verdict, figure or reason, and all that was printed."""
    with tempfile.TemporaryDirectory() as folder:
        ended = bounded([python, "-I", str(finding.script), *arguments], SECONDS, cwd=folder)
    printed = ended.out.decode("utf-8", "replace")
    if ended.code is None:
        return "failed", f"no answer within {SECONDS:g} s", ""
    # A vendor's library may end its own lines on the console without a line break.
    last = printed.rstrip().rpartition("\n")[2]
    for verdict in get_args(ScriptVerdict)[:3]:
        _, said, figure = last.partition(f"{verdict}: ")
        if ended.code == 0 and said:
            return verdict, figure, printed
    why = ended.last_words or "no output"
    reason = why if ended.code >= 0 else f"ended by signal {-ended.code}"
    return "unavailable" if why.startswith(_UNAVAILABLE) else "failed", reason, printed


def ask(finding: Finding, python: str = sys.executable) -> ScriptAnswer:
    """Run a script, isolated from this project and from the user's paths.

    Args: python: the interpreter, in whose environment the engine is installed.
    """
    begun = time.monotonic()
    verdict, figure, _ = _answer(finding, python)
    took = time.monotonic() - begun
    return ScriptAnswer(finding, verdict, figure, _version(finding, python), took)


def ask_mended(finding: Finding, python: str = sys.executable) -> Mended:
    """Run a script with its mend; one that tells no price of it has failed. Args: see `ask`."""
    verdict, figure, printed = _answer(finding, python, "--mended")
    price = _PRICE.search(printed)
    if verdict in ("gone", "stands") and price is None:
        return Mended("failed", f"no price of the mend, only '{verdict}: {figure}'")
    return Mended(verdict, figure, float(price[1]) if price else None, price[2] if price else "")


def ask_all(findings: Sequence[Finding], python: str = sys.executable) -> Iterator[ScriptAnswer]:
    """Each in its turn, with its mend, as it is known."""
    for finding in findings:
        yield replace(ask(finding, python), mended=ask_mended(finding, python))


def issue_text(standing: ScriptAnswer) -> str:
    """Title, versions, figure, the law that is expected, what is documented, the whole script, and what helps today."""
    finding = standing.finding
    sources = "\n".join(f"- {source}" for source in finding.sources)
    seen = ", ".join(finding.seen)
    today = f"{standing.verdict}: {standing.figure}" if standing.verdict in ("still there", "gone") else standing.figure
    version = standing.version or "not installed here"
    machine = f"Python {platform.python_version()}, {platform.system()} {platform.machine()}"
    needs = ", ".join(finding.requires) or finding.engine
    mended = standing.mended
    cured = f"\n\nWith it: {mended.verdict}: {mended.figure}." if mended else ""
    if mended and mended.price is not None:
        cured += f" Time of a {mended.unit} with it, over that without: {mended.price:.2f}."
    return f"""# {finding.title}

**Version**: {version} (first seen in {seen}); {machine}

**What happens**: {today}

**Expected**: {ast.get_docstring(ast.parse(finding.text))}

{SPOKEN["asked"][finding.kind]} {finding.documented}

{sources}

**To reproduce**: needs {needs} and nothing else; the last line that it prints says whether it is still there. With \
`--mended` it does what helps, and says what that costs.

```python
{finding.standalone}
```

**What helps meanwhile**: {finding.mend}{cured}
"""
