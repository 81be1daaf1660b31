"""What the project says against an engine of others, collected from where it is said.

A claim is named by who says it and its words: `bullet lacks ellipsoid`, `dart refuses: DART has no rolling friction`,
`docs/method.md: MuJoCo has no such law.`. The page on fairness has a row for each (`tests/architecture/test_declarations.py`).
"""

import ast
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from plumbline.harness.adapter import Adapter
from plumbline.harness.study import plugins

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "fairness.md"
ENGINES = ("bullet", "dart", "mujoco", "newton", "rapier", "sapien")
NAMED = re.compile(
    r"\b(MuJoCo(?:-Warp)?|Bullet|pybullet|DART|dartpy|Rapier|PhysX|SAPIEN|XPBD|"
    r"Newton(?!'s (?:law|method|iteration|equation|third))(?! (?:iteration|step|method|solver)|-))\b"
)
"""Engines, and no law or method of Newton's."""
AGAINST = re.compile(
    r"\b(cannot|not|no|never|none|nothing|nobody|alone|only|without|lacks?|missing|miss(?:es)?|ignores?|fails?|breaks?|refuses?|"
    r"loses?|lost|leaves? out|left out|errs?|wrong|slower|longer|dear(?:er)?|costs?|explodes?|diverges?|blows? up|jitters?|"
    r"creeps?|drifts?|sinks?|sags?|gains?|scatters?|beyond|crash(?:es)?|hangs?)\b"
)
"""Words that make a sentence about an engine one against it: what it does not have, not do, does wrongly or more dearly."""

TEXTS = ("adapters", "cases", "harness", "reports")
"""Where sentences for users stand in the code. A docstring is for those who read the code, but for that of a case."""


def plain(text: str) -> str:
    """Words alone: one space between them, neither marks of Markdown nor links."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return " ".join(re.sub(r"[`*|]", " ", text).split())


def declared(adapter: Adapter) -> Iterator[str]:
    """What an adapter says of its engine in typed fields."""
    yield from (f"{adapter.name} lacks {name}" for name in (~adapter.features).names)
    yield from (f"{adapter.name} makes {emulation.feature.names[0]}: {emulation.how}" for emulation in adapter.emulated)
    yield from (f"{adapter.name} fails: {reason}" for reason in adapter.known_failures.values())
    yield from (f"{adapter.name} deviates: {deviation}" for deviation in adapter.deviations)
    yield from (f"{adapter.name} {track}: {settings.source}" for track, settings in adapter.tracks.items())
    yield f"{adapter.name} knobs: {', '.join(adapter.knobs)}"


def _words(node: ast.expr) -> str:
    """A literal text; what is put into it stands as {}."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=parts):
            return "".join(_words(part) if isinstance(part, ast.Constant) else "{}" for part in parts)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return _words(left) + _words(right)
        case ast.IfExp(body=one, orelse=other):
            return f"{_words(one)} / {_words(other)}"
    return ""


def refused(folder: Path) -> Iterator[str]:
    """Why an adapter refuses a scene, for each place where it does."""
    for path in sorted(folder.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Unsupported":
                why = _words(node.args[1]) if len(node.args) == 2 else ""
                yield f"{folder.name} refuses: {why or f'{path.name}, {ast.unparse(node)}'}"


def sentences(page: Path) -> Iterator[str]:
    """The sentences of a page of text, and the rows of its tables."""
    text = re.sub(r"```(?s:.*?)```|^#.*$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
    for paragraph in re.split(r"\n\s*\n|\n(?=\s*(?:\*|\||\d+\.) )", text):
        if paragraph.lstrip().startswith("|"):
            yield " ".join(paragraph.split())
        else:
            yield from re.split(r"(?<=[.;])\s+(?=[A-Z`*\[])", " ".join(paragraph.split()))


def written() -> Iterator[str]:
    """What pages say against an engine, but for the tables of the page on fairness, whose rows are answers."""
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "examples" / "README.md", *sorted(ROOT.glob("docs/*.md"))]
    for page in pages:
        for sentence in sentences(page):
            if page == PAGE and sentence.startswith("|"):
                continue
            if NAMED.search(sentence) and AGAINST.search(sentence):
                yield f"{page.relative_to(ROOT)}: {sentence}"


def shown() -> Iterator[str]:
    """What templates of pages, built-in studies and docstrings of cases say against an engine; findings have rows by name."""
    for page in sorted((ROOT / "reports").rglob("*.html")):
        for sentence in re.split(r"(?<=[.;])\s+(?=[A-Z`*\[])|\n\s*\n", page.read_text(encoding="utf-8")):
            text = " ".join(re.sub(r"(?s)<[^>]*>|\{[%#].*?[%#]\}|\{\{.*?\}\}", " ", sentence).split())
            if NAMED.search(text) and AGAINST.search(text):
                yield f"{page.relative_to(ROOT)}: {text}"
    for study in sorted((ROOT / "harness" / "study").rglob("*.toml")):
        for text in _strings(tomllib.loads(study.read_text(encoding="utf-8"))):
            if NAMED.search(text) and AGAINST.search(text):
                yield f"{study.relative_to(ROOT)}: {text}"
    for path in sorted((ROOT / "cases").rglob("*.py")):
        text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        if NAMED.search(text) and AGAINST.search(text):
            yield f"{path.relative_to(ROOT)}: {text}"


def _strings(values: object) -> Iterator[str]:
    """All texts of a file of TOML."""
    match values:
        case str(text):
            yield text
        case dict():
            for value in values.values():
                yield from _strings(value)
        case list():
            for value in values:
                yield from _strings(value)


def told() -> Iterator[str]:
    """What sentences in the code say against an engine, but for docstrings and comments."""
    for path in sorted(path for folder in TEXTS for path in (ROOT / folder).rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        loose = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        loose |= {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values}
        for node in ast.walk(tree):
            text = _words(node) if isinstance(node, ast.Constant | ast.JoinedStr) and id(node) not in loose else ""
            if NAMED.search(text) and AGAINST.search(text):
                yield f"{path.relative_to(ROOT)}: {text}"


@cache
def claims() -> frozenset[str]:
    """Every claim that is made."""
    adapters = [plugins.adapters()[name] for name in ENGINES]
    made = [claim for adapter in adapters for claim in declared(adapter)]
    made += [claim for name in ENGINES for claim in refused(ROOT / "adapters" / name)]
    declarations = " ".join(map(plain, made))
    texts = [text for text in map(plain, told()) if text.split(": ", 1)[1] not in declarations]
    return frozenset((*map(plain, (*made, *written(), *shown())), *texts))


if __name__ == "__main__":
    print(*sorted(claims()), sep="\n")
