"""The house words of a page, each linked to its entry of the glossary where it is first met."""

import re
from collections.abc import Iterator

from markupsafe import Markup

from plumbline.reports.words.glossary import HOUSE_WORDS, WORD, glossary, house_word

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
