"""Templates filled in with every string escaped, cleaned of control characters and cut to a readable length."""

import re
from functools import cache
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from plumbline.harness.case.undropped import called
from plumbline.harness.findings import parameter_words
from plumbline.harness.findings.emulations import share_in_words
from plumbline.harness.findings.parameter_words import substeps_of
from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.store import Store
from plumbline.reports.charts.palette import looks
from plumbline.reports.html.compiled_templates import CompiledTemplates
from plumbline.reports.html.house_words import explained
from plumbline.reports.page import navigation
from plumbline.reports.words.catalogue import case_file, cases, engine_file, engines, labels
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
    named = engines(store)
    page = (
        environment()
        .get_template(template)
        .render(
            navigation=navigation(store),
            engines=named,
            looks=looks(named),
            yardsticks=[label for name, label in labels(store).items() if named[name]["ours"]],
            case_titles={name: case["title"] for name, case in cases(store).items()},
            statuses=STATUSES,
            study=store.study,
            **context,
        )
    )
    return page if template == "glossary.html" else explained(page)
