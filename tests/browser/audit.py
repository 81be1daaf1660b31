"""What is wrong with an open page as a reader meets it: everything is asked at once, since to open a page costs the most."""

from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from tests.browser.conftest import Visit
from tests.links import anchors

__all__ = ["faults"]

LONGEST = 14_000
"""The most pixels that a page may be high on a wide screen; twice as many on a phone."""
STOPS = 12
"""How often Tab is pressed: from there on the order of the document says the rest."""

SEEN = (Path(__file__).parent / "seen.js").read_text(encoding="utf-8")

LINKS = """() => [...document.querySelectorAll("[href], [src]")].map((one) => one.href?.baseVal ?? one.href ?? one.src)"""
SWITCH = (Path(__file__).parent / "switched.js").read_text(encoding="utf-8")
FILTER = (Path(__file__).parent / "filtered.js").read_text(encoding="utf-8")
AXE = (Path(__file__).parent / "violations.js").read_text(encoding="utf-8")


@cache
def _anchors(path: Path) -> frozenset[str]:
    return anchors(path.read_text(encoding="utf-8"))


def _links(seen: Visit, path: Path) -> list[str]:
    wrong = []
    for href in set(seen.page.evaluate(LINKS)):
        address = urlsplit(href)
        if address.scheme in ("http", "https", "data"):
            continue
        target = Path(unquote(address.path))
        if address.scheme != "file" or not target.is_file():
            wrong.append(f"a link to nothing: {href}")
        elif address.fragment and unquote(address.fragment) not in _anchors(target) | (
            frozenset(seen.page.evaluate("() => [...document.querySelectorAll('[id]')].map((one) => one.id)"))
            if target == path
            else frozenset()
        ):
            wrong.append(f"an anchor to nothing: {href.rpartition('/')[2]}")
    return wrong


def _keyboard(page: Any) -> list[str]:
    """Tab goes from one visible stop to another, and each shows that it is the one."""
    page.evaluate("() => { window.scrollTo(0, 0); document.activeElement?.blur?.(); }")
    visited = []
    for _ in range(STOPS):
        page.keyboard.press("Tab")
        stop = page.evaluate(
            """() => {
              const one = document.activeElement, style = getComputedStyle(one);
              return one === document.body ? null : {
                name: one.outerHTML.slice(0, 80), outlined: style.outlineStyle !== "none", shown: one.checkVisibility(),
              };
            }"""
        )
        if stop is None:
            break
        if not stop["outlined"] or not stop["shown"]:
            return [f"a stop of the keyboard that is not seen: {stop['name']}"]
        visited.append(stop["name"])
    return [] if len(visited) > 2 else ["Tab reaches nothing"]


def _axe(page: Any, source: str, whole: bool) -> list[str]:
    """Serious and critical violations of WCAG, by axe-core."""
    page.evaluate(source)
    result = page.evaluate(AXE, whole)
    return [
        f"axe {rule['id']} ({rule['impact']}, {len(rule['nodes'])} times): {rule['nodes'][0]['html'][:160]} "
        f"{rule['nodes'][0].get('failureSummary', '')[:200]}"
        for rule in result
        if rule["impact"] in ("serious", "critical")
    ]


def faults(seen: Visit, path: Path, axe: str, *, phone: bool, whole: bool) -> list[str]:
    """All that is wrong with a page, in words; none is a page that can be read.

    Args: axe: the source of axe-core. whole: it looks at all rows of tables, not at two of those that are made alike.
    """
    page = seen.page
    looked: Any = page.evaluate(SEEN)
    wrong: list[str] = list(looked["found"])
    if looked["high"] > (2 if phone else 1) * LONGEST:
        wrong.append(f"a scroll of {looked['high']} px")
    wrong += _links(seen, path)
    wrong += _keyboard(page)
    for figure in [one for one in page.query_selector_all("figure.chart") if one.is_visible()][:1]:
        wrong += [said for said in [figure.evaluate(SWITCH)] if said]
    for table in page.query_selector_all("table.filterable"):
        if table.query_selector("tbody tr"):
            wrong += [said for said in [table.evaluate(FILTER)] if said]
    if phone:
        wrong += _menu(page)
    wrong += _weights(page)
    wrong += _axe(page, axe, whole)
    outside: Collection[str] = {url for url in seen.asked if urlsplit(url).scheme not in ("file", "data")}
    return [*wrong, *(f"asks for {url}" for url in outside), *seen.said]


def _menu(page: Any) -> list[str]:
    """The menu of a phone opens and closes."""
    button = page.query_selector("button.menu")
    if button is None or not button.is_visible():
        return ["no menu on a phone"]
    nav = page.query_selector(".top nav")
    shut = not nav.is_visible()
    button.click()
    opened = nav.is_visible()
    button.click()
    return [] if shut and opened and not nav.is_visible() else ["a menu that does not open and close"]


def _weights(page: Any) -> list[str]:
    """A weight of the page on selection takes effect; one criterion alone has nothing to be weighed against."""
    slider = page.query_selector("#controls input[type=range]")
    if slider is None or len(page.query_selector_all("#places thead small")) < 2:
        return []
    before = page.inner_text("#headline")
    slider.focus()
    slider.press("End")
    for _ in range(60):
        page.wait_for_timeout(50)
        if page.inner_text("#headline") != before:
            return []
    return ["a weight without effect"]
