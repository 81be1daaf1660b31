"""The command that answers which engine: requirements, weights, the rank with its doubt, the settings, the runs behind it."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from plumbline.harness.cli.guard import say
from plumbline.harness.cli.listing import print_json, print_table
from plumbline.harness.cli.options import opened
from plumbline.harness.findings.columns import headings

if TYPE_CHECKING:
    from plumbline.harness.findings.selection import Selection
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
@click.option("--published", is_flag=True, help="By the dataset that ships with Plumbline, instead of DIR.")
@click.option(
    "--need",
    multiple=True,
    callback=_listed,
    metavar="NAME,...",
    help="Families (flight, spin, orbit, joint, impact, friction, rest, stack, tunnel, stand, system, sensor) or patterns of "
    "cases that count.",
)
@click.option(
    "--feature",
    multiple=True,
    callback=_listed,
    metavar="NAME,...",
    help="A feature that an engine must have; `plumbline engines --json` lists them.",
)
@click.option(
    "--max-error",
    type=click.FloatRange(0, 1, min_open=True),
    help="The error to be reached, a share of each case's scale [0.01, or the preset's]. Engines that do not reach it are "
    "excluded.",
)
@click.option(
    "--realtime",
    type=click.FloatRange(0, min_open=True),
    help="The speed to be reached, in times real time. Slower engines are excluded.",
)
@click.option(
    "--weight",
    multiple=True,
    callback=_weights,
    metavar="CRITERION=NUMBER,...",
    help="Weights of accuracy, speed, limits, robustness, determinism, capability [1 each].",
)
@click.option("--licence", multiple=True, callback=_listed, metavar="SPDX,...", help="Only engines with one of these licences.")
@click.option(
    "--platform",
    default="",
    metavar="NAME",
    help="Only engines that run on: linux-x86_64, linux-aarch64, macos-arm64, windows-x86_64.",
)
@click.option(
    "--preset",
    default="",
    metavar="NAME|FILE",
    help="Weights and cases for a purpose: games, legged, manipulation, rl-throughput, sensors, teaching, vehicles; "
    "or a TOML file of your own.",
)
@click.option("--with-reference", is_flag=True, help="Rank the reference engine too.")
@click.option("--evidence", is_flag=True, help="The figures behind the answer, run by run.")
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
    """Which engine suits a purpose, and how sure that is, by the runs in DIR."""
    from plumbline.harness.findings.selection import Wish, choose, listing, read_preset
    from plumbline.harness.findings.selection.wish import merged

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
        print_json(listing.ranking(answer))
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


def _print_evidence(answer: "Selection", as_json: bool) -> None:
    from plumbline.harness.findings.selection import listing

    rows = listing.rows(answer)
    if as_json:
        print_json(rows)
    else:
        print_table("evidence", headings(listing.SHOWN), [[column.cell(row) for column in listing.SHOWN] for row in rows])


def _known(store: "Store", need: tuple[str, ...]) -> tuple[str, ...]:
    from plumbline.harness.findings.selection.wish import unmatched

    for name, known in unmatched(store, need):
        raise click.BadParameter(f"'{name}' is no family or case of this run; families are {known}", param_hint="--need")
    return need


def _print(store: "Store", answer: "Selection", preset: str) -> None:
    from plumbline.harness.findings.selection.words import (
        COLUMN_WORDS,
        beyond,
        decisive,
        dropped_sentence,
        error_percent,
        gaps,
        headline,
        percent,
        trade,
        turn_sentences,
        undecided_sentence,
    )

    titles = store.titles

    def called(name: str) -> str:
        return titles.get(name, name)

    say(headline(answer, called))
    if traded := trade(answer, called):
        say(traded)
    for sentence in filter(None, (beyond(answer, called, called), *turn_sentences(answer.turns, called, called))):
        say(sentence)
    sentence, command = decisive(answer, called, called)
    if sentence:
        say(sentence)
    if command:
        say(f"  {command}")
    if answer.rank is not None:
        counted, evidence = answer.rank.counted, answer.evidence
        columns = ["place", "engine", "settings", "first in", "within", "speed", "error", "score"]
        columns += [f"{name} ({counted[name]})" for name in counted]
        rows = []
        for entry in answer.rank.places:
            shares = [f"{entry.by_criterion[name]:.2f}" for name in counted]
            speed, error = evidence.speed(entry.engine), evidence.error(entry.engine)
            within, judged = evidence.within(entry.engine)
            score = f"{entry.score:.2f} ({entry.low:.2f} .. {entry.high:.2f})"
            figures = [
                f"{within}/{judged}" if judged else "-",
                "-" if speed is None else f"{float(f'{speed:.2g}'):g}x",
                "-" if error is None else error_percent(error),
            ]
            first = "-" if answer.alone else percent(entry.first)
            track = evidence.tracks[entry.engine]
            rows.append([entry.number, called(entry.engine), track, first, *figures, score, *shares])
        heading = f"{100 * answer.wish.max_error:g} % error asked for{f' by preset {preset}' if preset else ''}"
        print_table(heading, columns, rows)
        for sentence in COLUMN_WORDS:
            say(sentence)
        say("Score: 0 to 1, with its 95 % interval; beside a criterion, of how many cases.")
    for drop in answer.dropped:
        say(dropped_sentence(drop, called, called))
    for drop in answer.undecided:
        say(undecided_sentence(drop, called, called))
    for sentence in gaps(answer):
        say(sentence)
