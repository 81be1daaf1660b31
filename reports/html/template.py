"""Templates filled in with every string escaped, cleaned of control characters and cut to a readable length.

Compiled templates on disk: the first report that a machine makes of a version compiles them, the others read them.

What of a constant goes through a filter is worked out when a template is compiled, so that a name stands for all that this may
depend on. What was damaged, or may be another user's, is compiled anew, never run.

The house words of a page, each linked to its entry of the glossary where it is first met.
"""

import hashlib
import inspect
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined
from jinja2.bccache import Bucket, BytecodeCache, bc_magic
from markupsafe import Markup, escape

from plumbline.harness.case.undropped import called
from plumbline.harness.findings import parameter_words
from plumbline.harness.findings.emulations import share_in_words
from plumbline.harness.findings.parameter_words import substeps_of
from plumbline.harness.findings.tables import table
from plumbline.harness.intake.user_cache import cache_folder, keep, read_kept
from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure
from plumbline.reports.charts.marks import looks
from plumbline.reports.page import Page, Rendered, navigation
from plumbline.reports.tables.csv import sheet
from plumbline.reports.words.catalogue import case_file, cases, engine_file, engines, labels, setting_words
from plumbline.reports.words.glossary import HOUSE_WORDS, WORD, glossary, house_word
from plumbline.reports.words.status import STATUSES, outcome
from plumbline.reports.words.text import (
    amount,
    formula,
    knobs,
    plain_value,
    plural,
    powers,
    settings_text,
    step,
    unit_text,
    visible,
)


class CompiledTemplates(BytecodeCache):
    """Those of an environment. Args: filters: what its templates call; they rest on all modules of `html` and `words` too."""

    def __init__(self, filters: Iterable[Any]) -> None:
        texts = {Path(inspect.getfile(inspect.unwrap(call))) for call in filters}
        texts |= {path for room in ("html", "words") for path in (Path(__file__).parents[1] / room).glob("*.*")}
        digest = hashlib.sha256(bc_magic + version("jinja2").encode())
        for path in sorted(texts):
            digest.update(hashlib.sha256(path.read_bytes()).digest())
        self._rests_on = digest.digest()

    def get_cache_key(self, name: str, filename: str | None = None) -> str:  # noqa: ARG002  # the same wherever it lies
        """Its name within the folder of templates."""
        return name

    def load_bytecode(self, bucket: Bucket) -> None:
        """Take the compiled template over, where it is kept whole."""
        if content := read_kept(self._place(bucket)):
            bucket.bytecode_from_string(content)

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Keep it; where nothing can be kept it is compiled each time."""
        keep(self._place(bucket), bucket.bytecode_to_string())

    def _place(self, bucket: Bucket) -> Path:
        """Its file, by its name, its text and what else it rests on."""
        named = f"{bucket.key}\0{bucket.checksum}".encode()
        return cache_folder("templates") / hashlib.sha256(self._rests_on + named).hexdigest()


_MAIN = '<main id="content">'
_MET = re.compile(
    r"(?P<folds><details\b[^>]*>)|(?P<end></details>)"
    r"|<(?P<left>a|button|code|h[1-6]|label|option|script|style|summary|svg|table)\b.*?</(?P=left)>|<[^>]*>|" + WORD.pattern,
    re.DOTALL | re.IGNORECASE,
)
"""What a page has of details, of what is left as it is (links, code, headings, tables, pictures), other tags and words."""
_LINK = Markup('<a class="word" href="glossary.html#{}" title="{}">{}</a>')


def explained(page: str) -> str:
    """The page with links. A word that stands in headings and tables alone is named below the content."""
    entries = {word: entry for entry in glossary() for word in entry.words if word in HOUSE_WORDS}

    def link(word: str, shown: str) -> Markup:
        return _LINK.format(entries[word].anchor, entries[word].meaning.replace("`", ""), Markup(shown))

    start, end = page.find(_MAIN), page.rfind("</main>")
    if not entries or start < 0 or end < 0:
        return page
    content, pieces, done = page[start:end], list[str](), 0
    first = dict(_first_met(content))
    for word, (begin, stop) in sorted(first.items(), key=lambda met: met[1]):
        pieces += [content[done:begin], link(word, content[begin:stop])]
        done = stop
    rest = sorted({house_word(met) for met in WORD.finditer(_text(content))} - first.keys())
    links = ", ".join(link(word, word) for word in rest)
    below = f'<p class="note words">Words in headings and tables: {links}.</p>\n' if rest else ""
    return "".join([page[:start], *pieces, content[done:], below, page[end:]])


def _first_met(content: str) -> Iterator[tuple[str, tuple[int, int]]]:
    """Each word's first place in prose that is open to see, or else in what folds."""
    opened, folded = dict[str, tuple[int, int]](), dict[str, tuple[int, int]]()
    around = list[bool]()  # of the details around: is one closed?
    for met in _MET.finditer(content):
        if met["folds"]:
            around.append(not re.search(r"\sopen\b", met[0]))
        elif met["end"]:
            around = around[:-1]
        elif not met[0].startswith("<"):
            (folded if any(around) else opened).setdefault(house_word(met), met.span())
    yield from (folded | opened).items()


def _text(content: str) -> str:
    """All text of a page's content, without scripts and pictures."""
    return re.sub(r"<(script|style|svg|code)\b.*?</\1>|<[^>]*>", " ", content, flags=re.DOTALL | re.IGNORECASE)


ADDRESS = re.compile(r"https?://[^\s<>\"'()\[\]{}]+[^\s<>\"'()\[\]{}.,;:]")


def cite(text: str) -> Markup:
    """A source with its web addresses as links; any other scheme stays text."""
    shown, parts, end = visible(text), [], 0
    for match in ADDRESS.finditer(shown):
        address = escape(match.group())
        parts += [escape(shown[end : match.start()]), Markup('<a rel="noreferrer noopener" href="')]
        parts += [address, Markup('">'), address, Markup("</a>")]
        end = match.end()
    return Markup("").join([*parts, escape(shown[end:])])


def ticked(text: str) -> Markup:
    """Prose with code between backticks."""
    pieces, code = visible(text).split("`"), Markup("<code>{}</code>")
    return Markup("").join(code.format(piece) if k % 2 else escape(piece) for k, piece in enumerate(pieces))


def quantity(parameter: str, case: str) -> str:
    """What a parameter of a case is called: 'number of balls'."""
    return parameter_words.called(case, parameter)


def axis_title(parameter: str, case: str) -> str:
    """The same with its unit: 'wall thickness [m]'."""
    return parameter_words.axis_title(case, parameter)


def cleaned(value: Any) -> Any:
    """What every expression of a template goes through before it is escaped."""
    return visible(value) if isinstance(value, str) and type(value) is not Markup else value


class Templates(Environment):
    """Looks into a dict before it asks for an attribute: cells of tables are such, a million in a large report."""

    def getattr(self, obj: Any, attribute: str) -> Any:
        """What `obj.attribute` stands for in a template."""
        return obj[attribute] if type(obj) is dict and attribute in obj else super().getattr(obj, attribute)


@cache
def environment() -> Environment:
    """The templates of this folder, with the filters that they share."""
    made = Templates(
        loader=PackageLoader("plumbline.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=cleaned,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    filters = {
        "amount": amount,
        "called": called,
        "case_file": case_file,
        "engine_file": engine_file,
        "cite": cite,
        "integrator": parameter_words.integrator_called,
        "metric": metric_title,
        "outcome": outcome,
        "plural": plural,
        "powers": powers,
        "plain": plain_value,
        "axis_title": axis_title,
        "quantity": quantity,
        "formula": formula,
        "knobs": knobs,
        "own_share": share_in_words,
        "unit": unit_text,
        "settings": settings_text,
        "step": step,
        "substeps": substeps_of,
        "ticked": ticked,
        "address": lambda text: quote(text, safe=""),
    }
    made.filters |= filters
    made.bytecode_cache = CompiledTemplates(filters.values())
    return made


def fill(template: str, store: Store, **context: Any) -> str:
    """A whole page from `templates/<template>`, house words linked to the glossary."""
    named, by_name = engines(store), cases(store)
    common: dict[str, Any] = {
        "navigation": navigation(store),
        "engines": named,
        "cases": by_name,
        "looks": looks(named),
        "yardsticks": [label for name, label in labels(store).items() if named[name]["ours"]],
        "case_titles": {name: case["title"] for name, case in by_name.items()},
        "setting_of": partial(setting_words, store),
        "statuses": STATUSES,
        "study": store.study,
    }
    page = environment().get_template(template).render(common | context)
    return page if template == "glossary.html" else explained(page)


def filled_page(
    name: str,
    title: str,
    order: int,
    context_of: Callable[[Store], Mapping[str, Any]],
    *,
    heading: str = "",
    listed: bool = True,
    tables: Sequence[str] = (),
    concerns: Callable[[Store], bool] = lambda _: True,
) -> Page:
    """A page that is `templates/<name>.html` with what it is told, beside it the charts among that and some tables as CSV.

    Args: heading: where the page does not call itself as in the navigation. tables: by name. Others: as a `Page` has them.
    """

    def render(store: Store) -> Mapping[str, Rendered]:
        context = context_of(store)
        page = fill(f"{name}.html", store, title=heading or title, **context)
        sheets = {each: table(each) for each in tables}
        charts = chain.from_iterable(
            charts_of if isinstance(charts_of, list) else [charts_of] for charts_of in context.values()
        )
        return {
            f"{name}.html": page,
            **{f"{each}.csv": sheet(sheets[each].columns, sheets[each].rows(store)) for each in tables},
            **{chart.path: chart for chart in charts if isinstance(chart, Figure)},
        }

    return Page(name=name, title=title, order=order, render=render, listed=listed, concerns=concerns)
