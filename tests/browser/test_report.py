"""Can a person read the report? A real browser opens every page from disk, without a network."""

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest

from plumbline.reports.html.policy import guarded
from plumbline.reports.html.report import write_report
from tests.browser.conftest import Visit
from tests.run_folder import BAD_CASE, write_run_folder

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = write_run_folder(tmp_path_factory.mktemp("hostile") / "run", hostile=True, only=(BAD_CASE,))
    return write_report(folder).index.parent


def html_files(report: Path) -> list[Path]:
    found = sorted(report.glob("*.html"))
    assert found
    return found


WIDTHS = (1280, 390)


@dataclass(frozen=True)
class Read:
    """What is read off an open page that is left as it is."""

    said: tuple[str, ...]
    asked: frozenset[str]
    """Schemes of the addresses that it asked for."""
    links: tuple[str, ...]
    needs: dict[int, int]
    """How wide it is on a screen of each width, both in px."""


@pytest.fixture(scope="module")
def pages(tab: Any, plain: Path) -> dict[Path, Read]:
    """Each page of the report, opened once."""
    every = {}
    for path in html_files(plain):
        seen = Visit(tab, path)
        links = tab.eval_on_selector_all("[href], [src]", "all => all.map(one => one.href || one.src)")
        needs = {}
        for width in WIDTHS:
            tab.set_viewport_size({"width": width, "height": 900})
            needs[width] = tab.evaluate("document.documentElement.scrollWidth")
        every[path] = Read(tuple(seen.said), frozenset(urlsplit(url).scheme for url in seen.asked), tuple(links), needs)
        seen.close()
    return every


def test_every_page_opens_from_disk_in_silence_and_fetches_nothing_from_a_network(pages: dict[Path, Read]) -> None:
    assert len(pages) == 15
    for path, page in pages.items():
        assert page.said == (), path.name
        assert page.asked <= {"file", "data"}, path.name


def test_every_link_leads_to_a_file_and_every_fragment_to_an_element(pages: dict[Path, Read]) -> None:
    followed = 0
    for path, page in pages.items():
        for href in page.links:
            address = urlsplit(href)
            if address.scheme in ("http", "https", "data"):
                continue
            assert address.scheme == "file", href
            target = Path(unquote(address.path))
            assert target.is_file(), f"{path.name}: {href}"
            if address.fragment:
                assert f'id="{unquote(address.fragment)}"' in target.read_text(encoding="utf-8"), f"{path.name}: {href}"
            followed += 1
    assert followed > 50


@pytest.mark.parametrize("width", WIDTHS)
def test_no_page_is_wider_than_the_screen(pages: dict[Path, Read], width: int) -> None:
    assert {path.name: page.needs[width] for path, page in pages.items() if page.needs[width] > width} == {}


@pytest.mark.parametrize("scheme", [pytest.param("dark", marks=pytest.mark.slow), "light"])
def test_charts_are_drawn_as_svg_with_marks_and_have_a_size(plain: Path, visit: Any, look: Any, scheme: str) -> None:
    for name in ("index.html", "case-stack_tower.html"):
        page = look(plain / name) if scheme == "light" else visit(plain / name, color_scheme=scheme).page
        charts = page.locator("figure.chart .plot svg.marks")
        assert charts.count() == 2
        for k in range(2):
            box = charts.nth(k).bounding_box()
            assert box is not None
            assert box["width"] > 300
            assert box["height"] > 100
            assert charts.nth(k).locator(".mark-symbol path").count() > 5


def test_outcomes_without_a_number_are_drawn_on_the_chart(plain: Path, look: Any) -> None:
    text = look(plain / "case-stack_tower.html").locator("#case-stack_tower-step .plot svg").text_content()
    for symbol in "∞∅◷‡▣":
        assert symbol in text


def test_without_scripts_the_static_pictures_stand_and_the_tables_are_there(plain: Path, browser: Any) -> None:
    page = browser.new_page(java_script_enabled=False)
    page.goto((plain / "case-stack_tower.html").as_uri())
    stills = page.locator("figure.chart img.still")
    assert stills.count() == 2
    for k in range(2):
        assert stills.nth(k).is_visible()
        assert (stills.nth(k).bounding_box() or {"height": 0})["height"] > 150
    assert page.locator("table.trials tbody tr").count() == 60
    page.close()


def test_print_shows_the_static_picture_in_place_of_the_live_chart(plain: Path, look: Any) -> None:
    page = look(plain / "case-stack_tower.html")
    assert not page.locator("figure.chart img.still").first.is_visible()
    page.emulate_media(media="print")
    assert page.locator("figure.chart img.still").first.is_visible()
    assert not page.locator("figure.chart .plot").first.is_visible()
    page.emulate_media(media="screen")
    assert page.locator("figure.chart .plot").first.is_visible()


def test_words_and_outcomes_filter_the_trials(plain: Path, look: Any) -> None:
    page = look(plain / "case-stack_tower.html")
    rows = page.locator("table.trials tbody tr:visible")
    assert rows.count() == 60
    page.locator(".tools input").fill("mujoco tuned")
    assert rows.count() == 6
    page.locator(".tools input").fill("")
    page.locator(".tools select").select_option("crashed")
    assert rows.count() == 1
    page.locator(".tools select").select_option("")
    assert rows.count() == 60


def test_a_permanent_link_to_a_trial_opens_its_row(plain: Path, look: Any) -> None:
    page = look(plain / "case-stack_tower.html")
    name = page.locator("table.trials tbody tr").nth(40).get_attribute("id")
    page.evaluate(f"location.hash = '{name}'")
    page.wait_for_selector(f"#{name} details[open]")
    assert "plumbline reproduce" in page.locator(f"#{name}").inner_text()


def column(page: Any, head: str) -> list[float]:
    place = page.locator("table.trials thead th").all_inner_texts().index(head)
    return [
        float(text) for text in page.eval_on_selector_all(
            "table.trials tbody tr", f"rows => rows.map(row => row.cells[{place}].dataset.value)"
        ) if text != ""
    ]  # fmt: skip


def test_a_click_on_a_heading_sorts_the_numbers_another_turns_them_and_gaps_stand_last(plain: Path, look: Any) -> None:
    page = look(plain / "case-stack_tower.html", turned_back=False)
    last = page.locator("table.trials tbody tr").last
    heads = [text for text in page.locator("table.trials thead th").all_inner_texts() if text.startswith("CPU")]
    before = column(page, heads[0])
    button = page.locator("table.trials thead th button", has_text=heads[0])
    for turned in (False, True):
        button.click()
        assert column(page, heads[0]) == sorted(before, reverse=turned) != before
        assert last.get_attribute("data-status") in ("unavailable", "diverged", "oom")


def test_the_price_list_shows_one_error_at_first_and_each_price_leads_to_its_trial(plain: Path, visit: Any) -> None:
    page = visit(plain / "price.html").page
    table = page.locator("table.prices")
    rows = table.locator("tbody tr:visible")
    assert [row.locator("td").first.inner_text() for row in rows.all()] == ["10⁻²"] * 3
    page.locator("#list .tools select").select_option("")
    assert rows.count() > 3 * 3
    page.locator("#list .tools input").fill("tower")
    rows.first.locator("td.x1 a").click()
    page.wait_for_selector("tr:target details[open]")
    assert "plumbline reproduce" in page.locator("tr:target").inner_text()


def test_a_folded_chapter_opens_for_a_link_to_it_from_the_page_and_from_elsewhere(plain: Path, visit: Any) -> None:
    page = visit(plain / "concepts.html").page
    assert page.locator("details.chapter[open]").count() == 1
    page.locator("main a[href='#joints']").click()
    assert page.locator("#joints table.concepts").is_visible()
    page.goto("about:blank")
    page.goto((plain / "concepts.html").as_uri() + "#sensors")
    assert page.locator("#sensors table.concepts").is_visible()
    page.wait_for_function("() => document.getElementById('sensors').getBoundingClientRect().top < innerHeight")


def test_a_miniature_leads_to_the_chart_of_its_case(plain: Path, visit: Any) -> None:
    page = visit(plain / "price.html").page
    assert page.locator(".mini").count() == 3
    page.locator(".mini").first.click()
    page.wait_for_selector("figure.chart:target .plot svg")


def test_hovering_a_point_tells_its_trial(plain: Path, visit: Any) -> None:
    page = visit(plain / "case-flight_projectile.html").page
    page.locator("#case-flight_projectile-step .plot svg .mark-symbol path[aria-label]").first.hover(force=True)
    page.wait_for_selector("#hover", state="visible")
    told = page.locator("#hover").inner_text()
    assert "trial" in told
    assert "settings" in told


def test_the_yardstick_is_put_away_on_every_page_and_stays_away_until_it_is_called_back(plain: Path, visit: Any) -> None:
    seen = visit(plain / "index.html")
    page = seen.page
    legends = page.locator("figure.chart .switches > :visible")
    own, columns = page.locator(".ours:visible"), page.locator("table.matrix thead th.group:visible")
    assert own.count() > 1
    assert "Plumbline reference (ours)" in legends.all_text_contents()
    before = columns.count()
    page.get_by_role("button", name="Hide the reference engine").click()
    page.wait_for_function("() => !document.querySelector('figure.chart .plot').textContent.includes('(ours)')")
    assert own.count() == 0
    assert columns.count() == before - 1
    widths = page.eval_on_selector_all(
        "table.matrix tbody tr:not(.family)",
        "rows => rows.map(row => [...row.cells].filter(cell => cell.offsetParent).length)",
    )
    assert set(widths) == {1 + 2 * (before - 1)}
    for name in ("case-stack_tower.html", "price.html"):
        page.goto((plain / name).as_uri())
        page.wait_for_selector("figure.chart[data-drawn] .plot svg")
        page.get_by_role("button", name="Show the reference engine").wait_for()
        assert own.count() == 0, name
        assert "(ours)" not in "".join(legends.all_text_contents()), name
    page.get_by_role("button", name="Show the reference engine").click()
    assert own.count() > 0
    assert seen.said == []


def test_a_cell_of_the_matrix_tells_its_reason_on_hovering_and_to_the_keyboard(plain: Path, visit: Any) -> None:
    page = visit(plain / "index.html").page
    cell = page.locator("table.matrix td.st-failed a").first
    cell.hover()
    assert "bound" in page.locator("#hover").inner_text()
    page.mouse.move(0, 0)
    assert not page.locator("#hover").is_visible()
    cell.focus()
    assert "bound" in page.locator("#hover").inner_text()
    assert "bound" in (cell.get_attribute("aria-label") or "")
    cell.blur()


def test_names_that_attack_run_no_script_and_open_no_dialog(hostile: Path, visit: Any) -> None:
    hovered = 0
    for path in html_files(hostile):
        seen = visit(path)
        seen.page.evaluate("document.querySelectorAll('details').forEach((one) => (one.open = true))")
        seen.page.evaluate("document.querySelectorAll('th button').forEach((one) => one.click())")
        for mark in seen.page.locator(".plot svg .mark-symbol path[aria-label]").all()[:6]:
            mark.hover(force=True)
            hovered += 1
        assert seen.page.evaluate("window.attacked") is None, path.name
        assert seen.said == [], path.name
        assert {urlsplit(url).scheme for url in seen.asked} <= {"file", "data"}, path.name
    assert hovered > 0


@pytest.mark.parametrize("head", ["", "<!doctype html>", '<!doctype html><html lang="en"><head><meta charset="utf-8">'])
def test_a_page_of_a_third_party_runs_no_script_of_its_own_text(head: str, tmp_path: Path, visit: Any) -> None:
    attack = "<script>window.attacked=1</script><img src='x' onerror='window.attacked=1'>"
    text = f"{head}<title>Roll</title><p id='x'>there</p>{attack}"
    for name, page in (("bare.html", text), ("guarded.html", guarded(text))):
        (tmp_path / name).write_text(page, encoding="utf-8")
    assert visit(tmp_path / "bare.html").page.evaluate("window.attacked") == 1, "the attack is none"
    seen = visit(tmp_path / "guarded.html")
    assert seen.page.evaluate("window.attacked") is None
    assert seen.page.locator("#x").inner_text() == "there"
    assert seen.page.evaluate("document.compatMode") == ("CSS1Compat" if head else "BackCompat")


def test_the_policy_itself_stops_a_script_that_slips_in(plain: Path, tmp_path: Path, visit: Any) -> None:
    shutil.copytree(plain, tmp_path / "report")
    page = tmp_path / "report" / "method.html"
    attack = '<script>window.attacked=1</script><img src="x" onerror="window.attacked=1"></main>'
    page.write_text(page.read_text(encoding="utf-8").replace("</main>", attack), encoding="utf-8")
    seen = visit(page)
    assert seen.page.evaluate("window.attacked") is None
    assert any("Content Security Policy" in text for text in seen.said)


def test_a_reader_weighs_engines_by_keyboard_and_leaves_some_out(plain: Path, visit: Any) -> None:
    seen = visit(plain / "select.html")
    page = seen.page
    scores = "[...document.querySelectorAll('#places tbody tr:not([hidden])')].map(row => row.cells[7].textContent).join()"
    before = page.evaluate(scores)
    speed = page.get_by_label("speed", exact=False).first
    speed.focus()
    speed.press("End")
    assert speed.input_value() == "5"
    page.wait_for_function(f"before => {scores} !== before", arg=before)
    page.get_by_label("times real time, at least").fill("100000")
    page.wait_for_function("() => document.getElementById('left-out').textContent.includes('times real time')")
    words = page.inner_text("#left-out")
    assert page.locator("#places tbody tr:visible").count() == words.count("it is not known: "), "a bound drops nobody"
    assert words.count("is excluded: ") + words.count("it is not known: ") == page.locator("#places tbody tr").count()
    assert seen.said == []


def test_what_the_page_works_out_is_what_it_was_written_with_to_the_digit(plain: Path, visit: Any) -> None:
    page = visit(plain / "select.html").page
    shown = "[...document.querySelectorAll('#places tbody tr:not([hidden])')]"
    rows = f"{shown}.map(row => [...row.cells].map(cell => cell.textContent.trim()))"
    written, headline = page.evaluate(rows), page.inner_text("#headline")
    speed = page.get_by_label("speed", exact=False).first
    speed.fill("2")
    page.wait_for_function(f"told => JSON.stringify({rows}) !== JSON.stringify(told)", arg=written)
    speed.fill("1")
    page.wait_for_function(f"told => JSON.stringify({rows}) === JSON.stringify(told)", arg=written)
    assert page.inner_text("#headline") == headline
