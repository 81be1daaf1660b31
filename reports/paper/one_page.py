"""All pages of a report as one, for print: contents first, each page on a sheet of its own, links within it."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from html.parser import HTMLParser
from urllib.parse import unquote

_VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"}
_POINTING = ("id", "for", "aria-labelledby", "aria-describedby", "aria-controls")
_LEFT_OUT = {"script", "button", "form", "noscript"}


@dataclass(frozen=True, slots=True)
class Sheet:
    """A page of the report. name: its file without the ending. text: its HTML."""

    name: str
    text: str


class _Main(HTMLParser):
    """The content of a page's `main`, with addresses that hold on the joined page, and its first heading.

    Folds outside of tables are open. Scripts are left out, and so is what only works with them; an address outside of the
    report's pages stays as it is.
    """

    def __init__(self, name: str, names: frozenset[str]) -> None:
        super().__init__(convert_charrefs=False)
        self._name, self._names = name, names
        self.made: list[str] = []
        self.title = ""
        self._inside, self._skipped, self._heading, self._tables = False, 0, False, 0

    def _address(self, address: str) -> str:
        file, mark, place = address.partition("#")
        page = file.removesuffix(".html") if file.endswith(".html") else ""
        if not file and mark:
            return f"#{self._name}--{place}" if place else f"#{self._name}"
        if page not in self._names or page == "":
            return address
        return f"#{page}--{place}" if place else f"#{page}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "main":
            self._inside = True
        elif self._skipped or (self._inside and tag in _LEFT_OUT):
            self._skipped += tag not in _VOID
        elif self._inside:
            self._heading = self._heading or (tag == "h1" and not self.title)
            self._tables += tag == "table"
            if tag == "details" and not self._tables and ("open", None) not in attrs:
                attrs = [*attrs, ("open", None)]  # paper cannot be unfolded; the particulars of each trial stay in the report
            self.made.append(f"<{tag}{''.join(self._attribute(name, value) for name, value in attrs)}>")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if self._inside and not self._skipped:
            self.made.append(f"<{tag}{''.join(self._attribute(name, value) for name, value in attrs)}/>")

    def _attribute(self, name: str, value: str | None) -> str:
        if value is None:
            return f" {name}"
        if name in _POINTING:
            value = " ".join(f"{self._name}--{word}" for word in value.split())
        elif name == "href":
            value = self._address(unquote(value) if value.startswith("#") else value)
        return f' {name}="{escape(value)}"'

    def handle_endtag(self, tag: str) -> None:
        if tag == "main":
            self._inside = False
        elif self._skipped:
            self._skipped -= 1
        elif self._inside:
            self._heading = self._heading and tag != "h1"
            self._tables -= tag == "table"
            self.made.append(f"</{tag}>")

    def handle_data(self, text: str) -> None:
        self._take(text, text)

    def handle_entityref(self, name: str) -> None:
        self._take(f"&{name};", f"&{name};")

    def handle_charref(self, name: str) -> None:
        self._take(f"&#{name};", f"&#{name};")

    def _take(self, text: str, heading: str) -> None:
        if self._inside and not self._skipped:
            self.made.append(text)
            self.title += heading if self._heading else ""


def joined(sheets: Sequence[Sheet], title: str, about: Sequence[tuple[str, str]]) -> str:
    """One page of these. Args: about: names and values of the title sheet, as text."""
    names = frozenset(sheet.name for sheet in sheets)
    contents, bodies = [], []
    for sheet in sheets:
        main = _Main(sheet.name, names)
        main.feed(sheet.text)
        heading = re.sub(r"\s+", " ", main.title).strip() or escape(sheet.name)
        contents.append(f'<li><a href="#{sheet.name}">{heading}</a></li>')
        bodies.append(f'<article class="sheet" id="{sheet.name}">{"".join(main.made)}</article>')
    facts = "".join(f"<tr><th scope='row'>{escape(name)}</th><td>{escape(value)}</td></tr>" for name, value in about)
    return (
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>"
        f"<title>{escape(title)}</title><link rel='stylesheet' href='style/report.css'></head><body class='printed'><main>"
        f"<article class='sheet'><h1>{escape(title)}</h1><table class='plain'>{facts}</table>"
        f"<h2>Contents</h2><ol class='contents'>{''.join(contents)}</ol></article>{''.join(bodies)}</main></body></html>"
    )
