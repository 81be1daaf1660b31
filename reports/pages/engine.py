"""A page for each engine: what it is, its settings, what is its own and what its adapter makes, what it fails and passes."""

from collections.abc import Mapping
from functools import partial

from plumbline.harness.store.store import Store
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page
from plumbline.reports.tables.verdicts import by_reason, cases_of, failing, laws_of, tracks_of, versions_of
from plumbline.reports.words.catalogue import engine_file, engines, setting_words
from plumbline.reports.words.known_findings import by_engine


def render(store: Store) -> Mapping[str, str]:
    """One page an engine."""
    known = by_engine(store)
    return {
        engine_file(name): fill(
            "engine.html",
            store,
            title=engine["title"],
            name=name,
            engine=engine,
            versions=versions_of(store, name),
            tracks=tracks_of(store, name),
            setting_of=partial(setting_words, store, name),
            failures=[failure for failure in failing(store) if failure.cause.engine == name],
            listed=cases_of(store, name),
            laws=laws_of(store, name) if engine["features"] else [],
            findings=known.get(name, []),
            reasons=by_reason(engine["known_failures"]),
        )
        for name, engine in engines(store).items()
    }


PAGE = Page(name="engine", title="Engines", order=55, render=render, listed=False)
