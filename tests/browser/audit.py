"""What is wrong with an open page as a reader meets it: everything is asked at once, since to open a page costs the most."""

import re
from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from tests.browser.conftest import Visit

__all__ = ["faults"]

LONGEST = 14_000
"""The most pixels that a page may be high on a wide screen; twice as many on a phone."""
STOPS = 12
"""How often Tab is pressed: from there on the order of the document says the rest."""

SEEN = """() => {
  const wide = document.documentElement.clientWidth, found = [];
  const shown = (one) => one.checkVisibility({ visibilityProperty: true });
  if (document.documentElement.scrollWidth > wide) {
    const over = [...document.querySelectorAll("main *, header *, footer *")]
      .filter((one) => shown(one) && !one.closest(".scroll *") && one.getBoundingClientRect().right > wide + 1);
    found.push(`scrolls sideways: ${document.documentElement.scrollWidth} of ${wide} px, ${over.slice(0, 3).map((one) => `${one.tagName}.${one.className}`)}`);
  }
  for (const figure of document.querySelectorAll("figure.chart")) {
    if (!shown(figure)) continue;
    const svg = figure.querySelector(".plot svg.marks");
    if (!svg) { found.push(`${figure.id}: no chart`); continue; }
    const marks = svg.querySelectorAll(".mark-symbol path, .mark-line path, .mark-rule line, .mark-rect path, .mark-area path, .mark-text text");
    const drawn = [...marks].filter((mark) => !mark.closest(".role-axis, .role-legend"));
    if (!drawn.length) found.push(`${figure.id}: no marks`);
    const frame = svg.getBoundingClientRect();
    if (frame.right > figure.getBoundingClientRect().right + 1) found.push(`${figure.id}: wider than its card`);
    for (const text of svg.querySelectorAll(".role-axis text, .role-axis-title text, .role-title text")) {
      const box = text.getBoundingClientRect();
      if (box.width && (box.left < frame.left - 2 || box.right > frame.right + 2 || box.top < frame.top - 2 || box.bottom > frame.bottom + 2))
        found.push(`${figure.id}: '${text.textContent}' is cut off`);
    }
    const keys = figure.querySelector(".switches");
    if (!keys?.children.length) { if (figure.querySelector("script.spec").textContent.includes('"engine"')) found.push(`${figure.id}: no legend`); }
    else {
      if (keys.scrollWidth > keys.clientWidth + 1) found.push(`${figure.id}: its legend does not fit`);
      if (svg.querySelector(".role-legend *")) found.push(`${figure.id}: two legends`);
    }
    const caption = figure.querySelector(".caption"), line = parseFloat(getComputedStyle(caption).lineHeight);
    if (wide > 1000 && caption.getBoundingClientRect().height > 2.3 * line) found.push(`${figure.id}: a caption of more than two lines`);
  }
  for (const frame of document.querySelectorAll(".scroll")) {
    if (!shown(frame) || frame.scrollWidth <= frame.clientWidth + 1) continue;
    if (frame.tabIndex !== 0) found.push(`a wide table without a keyboard: ${frame.getAttribute("aria-label")}`);
    const heads = frame.querySelector("thead tr")?.cells ?? [], edge = frame.getBoundingClientRect().right + 12;
    if ([...heads].some((head) => head.textContent.trim() && head.getBoundingClientRect().right > edge) && frame.nextElementSibling?.hidden !== false)
      found.push(`a wide table that hides columns in silence: ${frame.getAttribute("aria-label")}`);
  }
  for (const one of document.querySelectorAll("a[href], button, input, select, summary, textarea"))
    if (shown(one) && one.tabIndex < 0) found.push(`out of reach of the keyboard: ${one.outerHTML.slice(0, 80)}`);
  for (const fold of document.querySelectorAll("details")) if (!fold.querySelector(":scope > summary")?.textContent.trim()) found.push("a fold without a name");
  for (const text of document.querySelectorAll("p.note, p.caption, li"))
    if (/\\d[eE][-+]?\\d/.test(text.innerText.replace(/<[^>]*>/g, "")) && !text.querySelector("code")) found.push(`a power in another notation: ${text.innerText.slice(0, 80)}`);
  return { found, high: document.documentElement.scrollHeight };
}"""

LINKS = """() => [...document.querySelectorAll("[href], [src]")].map((one) => one.href?.baseVal ?? one.href ?? one.src)"""

SWITCH = """async (figure) => {
  const buttons = [...figure.querySelectorAll(".switches button")], count = () => [...figure.querySelectorAll(".plot svg .mark-symbol path, .plot svg .mark-rule line, .plot svg .mark-text text")]
    .filter((mark) => !mark.closest(".role-axis, .role-legend")).length;
  if (buttons.length < 2) return "";
  const before = count(), turn = async (pressed) => {
    buttons[0].click();
    for (let k = 0; k < 100; k++) {
      await new Promise((done) => setTimeout(done, 30));
      if (buttons[0].getAttribute("aria-pressed") === pressed && (pressed === "true" ? count() === before : count() < before)) return true;
    }
    return false;
  };
  if (!(await turn("false"))) return `${figure.id}: its first switch hides nothing`;
  return (await turn("true")) ? "" : `${figure.id}: its first switch does not bring back what it hid`;
}"""

FILTER = """(table) => {
  const tools = table.closest(".scroll").previousElementSibling, search = tools?.querySelector("input[type=search]");
  const shown = () => [...table.tBodies[0].rows].filter((row) => !row.hidden).length, type = (text) => {
    search.value = text;
    search.dispatchEvent(new Event("input"));
    return shown();
  };
  if (!search) return "a table to filter without a field";
  const before = shown();
  if (type("no row has this") !== 0) return "a filter that keeps what lacks its word";
  return type("") === before ? "" : "a filter that does not give back its rows";
}"""


@cache
def anchors(path: Path) -> frozenset[str]:
    """The names that a link into a page may end in."""
    return frozenset(re.findall(r'\bid="([^"]+)"', path.read_text(encoding="utf-8")))


def _links(seen: Visit, path: Path) -> list[str]:
    wrong = []
    for href in set(seen.page.evaluate(LINKS)):
        address = urlsplit(href)
        if address.scheme in ("http", "https", "data"):
            continue
        target = Path(unquote(address.path))
        if address.scheme != "file" or not target.is_file():
            wrong.append(f"a link to nothing: {href}")
        elif address.fragment and unquote(address.fragment) not in anchors(target) | (
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


def _axe(page: Any, source: str) -> list[str]:
    """Serious and critical violations of WCAG, by axe-core."""
    page.evaluate(source)
    result = page.evaluate("async () => (await axe.run(document, { resultTypes: ['violations'], preload: false })).violations")
    return [
        f"axe {rule['id']} ({rule['impact']}, {len(rule['nodes'])} times): {rule['nodes'][0]['html'][:160]} "
        f"{rule['nodes'][0].get('failureSummary', '')[:200]}"
        for rule in result
        if rule["impact"] in ("serious", "critical")
    ]


def faults(seen: Visit, path: Path, axe: str, *, phone: bool) -> list[str]:
    """All that is wrong with a page, in words; none is a page that can be read. Args: axe: the source of axe-core."""
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
        if table.query_selector("tbody tr[data-status]"):
            wrong += [said for said in [table.evaluate(FILTER)] if said]
    if phone:
        wrong += _menu(page)
    wrong += _weights(page)
    wrong += _axe(page, axe)
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
    """A weight of the page on selection takes effect."""
    slider = page.query_selector("#controls input[type=range]")
    if slider is None:
        return []
    before = page.inner_text("#headline")
    slider.focus()
    slider.press("End")
    for _ in range(60):
        page.wait_for_timeout(50)
        if page.inner_text("#headline") != before:
            return []
    return ["a weight without effect"]
