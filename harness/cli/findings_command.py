"""The command that lists known bugs and pitfalls of an engine, runs their scripts, and writes reports for the vendor."""

import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import click

from plumbline.harness.cli.guard import GATE, say
from plumbline.harness.cli.listing import print_json, print_table

if TYPE_CHECKING:
    from plumbline.harness.findings.vendor_findings import Finding, ScriptAnswer


@click.command()
@click.argument("asked", metavar="[ENGINE|NAME]", required=False)
@click.option(
    "--run", "run", is_flag=True, help="Run each script in a process of its own: is it still there, and does its mend cure it?"
)
@click.option("--issue", "issue", is_flag=True, help="Print a text for the vendor, with the script and today's figure.")
@click.option(
    "--report", "report", metavar="ENGINE", help="Write a text for the vendor of each finding of ENGINE into a folder."
)
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("build/findings"),
    show_default=True,
    help="The folder.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON array of flat rows.")
@click.option(
    "--python",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="The interpreter that has the engine, in place of this one.",
)
def findings(
    asked: str | None, run: bool, issue: bool, report: str | None, out: Path, as_json: bool, python: Path | None
) -> None:
    """Known bugs and pitfalls of ENGINE, as scripts in the vendor's own API."""
    from plumbline.harness.findings.vendor_findings import FindingError, chosen, shelf

    try:
        every = shelf()
        wanted = report or asked
        those = chosen(every, wanted) if wanted else every
    except FindingError as error:
        raise click.UsageError(str(error)) from None
    if report:
        if asked or issue:
            raise click.UsageError("--report ENGINE stands alone: it writes the text of --issue of all findings of ENGINE")
        _write_report(those, out, python)
    elif issue:
        _print_issue(those, asked, python)
    elif run:
        _print_standings(those, as_json, python)
    elif as_json:
        print_json([_row(finding) for finding in those])
    else:
        title = f"{len(those)} findings; --run asks whether they are still there"
        print_table(title, ["name", "kind", "title", "seen in"], [[f.name, f.kind, f.title, ", ".join(f.seen)] for f in those])


def _row(finding: "Finding") -> dict[str, object]:
    row = {name: getattr(finding, name) for name in ("name", "engine", "kind", "title")}
    row |= {"seen": ", ".join(finding.seen), "documented": finding.documented, "sources": "; ".join(finding.sources)}
    return row | {"mend": finding.mend, "cases": ", ".join(finding.cases), "script": str(finding.script)}


def _print_issue(those: "list[Finding]", asked: str | None, python: Path | None) -> None:
    from plumbline.harness.findings.vendor_findings import ask_all, issue_text

    if len(those) != 1:
        names = ", ".join(finding.name for finding in those)
        raise click.UsageError(f"--issue takes the name of one finding, not '{asked or 'all'}'; there are {names}")
    click.echo(issue_text(next(ask_all(those, str(python or sys.executable)))), nl=False)


def _write_report(those: "list[Finding]", out: Path, python: Path | None) -> None:
    from plumbline.harness.findings.vendor_findings import ask_all, issue_text

    for standing in ask_all(those, str(python or sys.executable)):
        path = out / f"{standing.finding.name}.md"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(issue_text(standing), encoding="utf-8")
        click.echo(path)


def _print_standings(those: "list[Finding]", as_json: bool, python: Path | None) -> None:
    from plumbline.harness.findings.vendor_findings import ask_all

    standings: list[ScriptAnswer] = []
    for standing in ask_all(those, str(python or sys.executable)):
        standings.append(standing)
        mended = standing.mended.verdict if standing.mended else "not asked"
        say(f"{len(standings)}/{len(those)} {standing.finding.name}: {standing.verdict}; with its mend: {mended}", err=True)
    if as_json:
        print_json([_row(s.finding) | _answer(s) for s in standings])
    else:
        counts = Counter(s.verdict for s in standings)
        cured = sum(s.mended is not None and s.mended.cures for s in standings)
        title = ", ".join(f"{number} {verdict}" for verdict, number in counts.items()) + f"; with their mends {cured} gone"
        print_table(title, ["name", "verdict", "figure", "mended", "price", "version"], [_cells(s) for s in standings])
    if any(standing.broken for standing in standings):
        sys.exit(GATE)


def _answer(standing: "ScriptAnswer") -> dict[str, object]:
    mended = standing.mended
    assert mended is not None
    row = {name: getattr(standing, name) for name in ("verdict", "figure", "version")}
    return row | {"mended": mended.verdict, "mended_figure": mended.figure, "price": mended.price, "price_unit": mended.unit}


def _cells(standing: "ScriptAnswer") -> list[str]:
    answer = _answer(standing)
    price = "" if answer["price"] is None else f"{answer['price']:g} of a {answer['price_unit']}"
    mended = answer["mended"] if answer["mended"] == "gone" else f"{answer['mended']}: {answer['mended_figure']}"
    return [standing.finding.name, standing.verdict, standing.figure, str(mended), price, standing.version]
