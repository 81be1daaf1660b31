"""The two pages of the server's own: what there is, and the page that holds the viewer."""

from urllib.parse import quote

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from plumbline.harness.store.store import Store
from plumbline.reports.recordings.layout import file_name
from plumbline.reports.words.text import plural

TEMPLATES = __file__.removesuffix("pages.py") + "static"


def template(name: str, **values: object) -> bytes:
    """A page with every string escaped."""
    page = Environment(loader=FileSystemLoader(TEMPLATES), autoescape=True, undefined=StrictUndefined).get_template(name)
    return page.render(**values).encode()


def recordings(store: Store) -> list[dict[str, object]]:
    """A row for each case: its name and title, its recording if there is one, and how its trials ended."""
    rows = []
    for case, trials in store.trials.groupby("case", sort=False):
        entry = store.catalogue.get("cases", {}).get(case, {})
        path = store.folder / "recordings" / file_name(str(case))
        counts = trials["status"].value_counts(sort=False)
        rows.append(
            {
                "case": case,
                "title": entry.get("title") or case,
                "address": quote(f"/recordings/{path.name}") if path.is_file() else None,
                "megabytes": path.stat().st_size / 1e6 if path.is_file() else None,
                "outcomes": ", ".join(f"{count} {status}" for status, count in counts.items()),
                "trials": plural(len(trials), "trial"),
            }
        )
    return rows


def front_page(store: Store) -> bytes:
    """Links to the report and to each recording."""
    report = (store.folder / "report" / "index.html").is_file()
    return template("front.html", study=store.study.get("name", store.folder.name), report=report, rows=recordings(store))


def viewer_page(store: Store) -> bytes:
    """The page that loads the viewer; which recording is in the address."""
    return template("view.html", study=store.study.get("name", store.folder.name))
