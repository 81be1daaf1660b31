"""The command that answers which engine: requirements, weights, the rank with its doubt, the settings, the runs behind it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from plumbline.harness.cli.guard import say
from plumbline.harness.cli.listing import print_json, print_table
from plumbline.harness.cli.options import opened
from plumbline.harness.findings.columns import headings

if TYPE_CHECKING:
    from plumbline.harness.findings.selection import Answer
    from plumbline.harness.store.store import Store


def _listed(_context: click.Context, _parameter: click.Parameter, given: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(word.strip() for text in given for word in text.split(",") if word.strip())


def _weights(_context: click.Context, _parameter: click.Parameter, given: tuple[str, ...]) -> dict[str, float]:
    from plumbline.harness.findings.selection import CRITERIA

    weights: dict[str, float] = {}
    for word in _listed(_context, _parameter, given):
        name, _, number = word.partition("=")
        if name not in CRITERIA:
            raise click.BadParameter(f"'{name}': no such criterion; there are {', '.join(CRITERIA)}")
        try:
            weights[name] = float(number)
        except ValueError:
            raise click.BadParameter(f"'{word}': expected {name}=NUMBER") from None
        if not 0 <= weights[name] <= 1000:
            raise click.BadParameter(f"'{word}': expected a weight from 0 to 1000")
    return weights


@click.command()
@click.argument("folder", metavar="[DIR]", required=False, type=click.Path(path_type=Path))
@click.option("--published", is_flag=True, help="By the dataset that ships with Plumbline, in place of DIR.")
@click.option("--need", multiple=True, callback=_listed, metavar="NAME,...", help="Families or patterns of cases that count.")
@click.option("--feature", multiple=True, callback=_listed, metavar="NAME,...", help="What an engine has to be able to do.")
@click.option("--max-error", type=click.FloatRange(0, 1, min_open=True), help="A share of each case's scale, to be reached.")
@click.option("--realtime", type=click.FloatRange(0, min_open=True), help="How many times faster than real time.")
@click.option("--weight", multiple=True, callback=_weights, metavar="CRITERION=NUMBER,...", help="1 unless said.")
@click.option("--licence", multiple=True, callback=_listed, metavar="SPDX,...", help="Any of these.")
@click.option("--platform", default="", metavar="NAME", help="linux-x86_64, linux-aarch64, macos-arm64, windows-x86_64.")
@click.option("--preset", default="", metavar="NAME|FILE", help="Weights, cases and reasons for a purpose.")
@click.option("--with-reference", is_flag=True, help="Rank our own engine, the ruler, too.")
@click.option("--evidence", is_flag=True, help="What the answer leans on, run by run, in place of the answer.")
@click.option("--json", "as_json", is_flag=True, help="One JSON array of flat rows.")
def select(
    folder: Path | None,
    published: bool,
    need: tuple[str, ...],
    feature: tuple[str, ...],
    max_error: float | None,
    realtime: float | None,
    weight: dict[str, float],
    licence: tuple[str, ...],
    platform: str,
    preset: str,
    with_reference: bool,
    evidence: bool,
    as_json: bool,
) -> None:
    """Which engine? By the run in DIR, for what is needed, and how surely."""
    from plumbline.harness.findings.selection import Wish, choose, read_preset
    from plumbline.harness.findings.selection.preset import merged

    store = _store(folder, published)
    base = read_preset(preset).wish() if preset else Wish()
    wish = merged(
        base,
        cases=dict.fromkeys(_known(store, need), 1.0),
        features=feature,
        max_error=max_error,
        strict=max_error is not None,
        realtime=realtime,
        weights={**base.weights, **weight},
        licences=licence,
        platform=platform,
        with_reference=with_reference,
    )
    answer = choose(store, wish)
    if evidence:
        _print_evidence(answer, as_json)
    elif as_json:
        print_json(_rows(answer))
    else:
        _print(store, answer, preset)


def _store(folder: Path | None, is_published: bool) -> "Store":
    if (folder is None) != is_published:
        raise click.UsageError("expected DIR or --published, one of them")
    if folder is not None:
        return opened(folder)

    from plumbline.api.published import published_in_words
    from plumbline.harness.store.published import published

    store = published()
    for sentence in published_in_words(store):
        say(sentence, err=True)
    return store


def _print_evidence(answer: "Answer", as_json: bool) -> None:
    from plumbline.harness.findings.selection import listing

    rows = listing.rows(answer)
    if as_json:
        print_json(rows)
    else:
        print_table("evidence", headings(listing.SHOWN), [[column.cell(row) for column in listing.SHOWN] for row in rows])


def _known(store: "Store", need: tuple[str, ...]) -> tuple[str, ...]:
    from plumbline.harness.findings.selection import Wish

    cases = {str(case) for case in store.trials["case"]}
    about = store.catalogue.get("cases", {})
    families = {case: str(about.get(case, {}).get("family") or case.partition("_")[0]) for case in cases}
    for name in need:
        if not any(Wish(cases={name: 1.0}).weight_of_case(case, family) for case, family in families.items()):
            known = ", ".join(sorted(set(families.values())))
            raise click.BadParameter(f"'{name}' is no family or case of this run; families are {known}", param_hint="--need")
    return need


def _rows(answer: "Answer") -> list[dict[str, Any]]:
    """One an engine: its place, or why it is left out; of one that nobody stands beside no share, but why it is alone."""
    rows: list[dict[str, Any]] = []
    for place in answer.rank.places if answer.rank is not None else ():
        rows.append(
            {
                "engine": place.engine,
                "place": place.number,
                "first": None if answer.alone else place.first,
                "score": place.score,
                "low": place.low,
                "high": place.high,
                "track": answer.evidence.tracks[place.engine],
                **{criterion: place.by_criterion.get(criterion) for criterion in _criteria()},
                "alone": answer.alone or None,
                "left_out": None,
                "case": None,
                "trial": None,
            }
        )
    blank = dict.fromkeys(rows[0] if rows else ("place", "first", "score", "low", "high", "track", *_criteria(), "alone"))
    for drop in answer.dropped:
        why = f"{drop.requirement}: {drop.value}"
        rows.append({**blank, "engine": drop.engine, "left_out": why, "case": drop.case or None, "trial": drop.trial or None})
    return rows


def _criteria() -> tuple[str, ...]:
    from plumbline.harness.findings.selection import CRITERIA

    return tuple(CRITERIA)


def _print(store: "Store", answer: "Answer", preset: str) -> None:
    from plumbline.harness.findings.selection.words import dropped_sentence, headline, turn_sentences, undecided_sentence

    titles = store.titles

    def called(name: str) -> str:
        return titles.get(name, name)

    say(headline(answer, called))
    if answer.rank is not None:
        counted = answer.rank.counted
        columns = ["place", "engine", "settings", "first in", "score", *(f"{name} ({counted[name]})" for name in counted)]
        rows = []
        for place in answer.rank.places:
            shares = [f"{place.by_criterion[name]:.2f}" for name in counted]
            score = f"{place.score:.2f} ({place.low:.2f} .. {place.high:.2f})"
            track = answer.evidence.tracks[place.engine]
            first = "-" if answer.alone else f"{100 * place.first:.0f} %"
            rows.append([place.number, called(place.engine), track, first, score, *shares])
        title = f"of 1; in brackets the cases that each is measured on{f'; preset {preset}' if preset else ''}"
        print_table(title, columns, rows)
    for drop in answer.dropped:
        say(dropped_sentence(drop, called, called))
    for drop in answer.undecided:
        say(undecided_sentence(drop, called, called))
    for sentence in turn_sentences(answer.turns, called, called):
        say(f"It would be {sentence}")
    _print_gaps(answer)


def _print_gaps(answer: "Answer") -> None:
    """What there is no evidence of, so that nobody takes silence for a good mark."""
    without = [name for name in _criteria() if answer.rank is not None and name not in answer.rank.counted]
    if without:
        say(f"Nothing in this run says anything of {', '.join(without)}.")
    bounds = {case for (_, case, _), datum in answer.evidence.table.items() if datum.bounded}
    if bounds:
        say(f"Speed known only as a lower bound in {len(bounds)} cases; --evidence lists them.")
    if answer.evidence.incomplete:
        pairs = answer.evidence.incomplete
        cases = ", ".join(dict.fromkeys(case for _, case in pairs))
        say(f"Not counted, since it is not known of every engine: {len(pairs)} pairs of criterion and case ({cases}).")
