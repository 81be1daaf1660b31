"""The command that lists what is wrong or a trap in an engine, runs its script, and makes a report of it for the vendor."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from plumbline.harness.cli.guard import GATE, say
from plumbline.harness.cli.listing import print_json, print_table

if TYPE_CHECKING:
    from plumbline.harness.findings.vendor.finding import Finding
    from plumbline.harness.findings.vendor.still_there import Standing


@click.command()
@click.argument("asked", metavar="[ENGINE|NAME]", required=False)
@click.option("--run", "run", is_flag=True, help="Run each script in a process of its own: is it still there?")
@click.option("--issue", "issue", is_flag=True, help="Print a text for the vendor, with the script and today's figure.")
@click.option("--json", "as_json", is_flag=True, help="One JSON array of flat rows.")
@click.option(
    "--python",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="The interpreter that has the engine, in place of this one.",
)
def findings(asked: str | None, run: bool, issue: bool, as_json: bool, python: Path | None) -> None:
    """Known bugs and pitfalls of ENGINE, as scripts in the vendor's own API."""
    from plumbline.harness.findings.vendor.finding import FindingError
    from plumbline.harness.findings.vendor.shelf import chosen, shelf

    try:
        every = shelf()
        those = chosen(every, asked) if asked else every
    except FindingError as error:
        raise click.UsageError(str(error)) from None
    if issue:
        _print_issue(those, asked, python)
    elif run:
        _print_standings(those, as_json, python)
    elif as_json:
        print_json([_row(finding) for finding in those])
    else:
        title = f"{len(those)} findings; --run asks whether they are still there"
        print_table(title, ["name", "kind", "title", "seen in"], [[f.name, f.kind, f.title, ", ".join(f.seen)] for f in those])


def _row(finding: "Finding") -> dict[str, object]:
    return {
        "name": finding.name,
        "engine": finding.engine,
        "kind": finding.kind,
        "title": finding.title,
        "seen": ", ".join(finding.seen),
        "documented": finding.documented,
        "sources": "; ".join(finding.sources),
        "mend": finding.mend,
        "cases": ", ".join(finding.cases),
        "script": str(finding.script),
    }


def _print_issue(those: "list[Finding]", asked: str | None, python: Path | None) -> None:
    from plumbline.harness.findings.vendor.issue_text import issue_text
    from plumbline.harness.findings.vendor.still_there import ask

    if len(those) != 1:
        names = ", ".join(finding.name for finding in those)
        raise click.UsageError(f"--issue takes the name of one finding, not '{asked or 'all'}'; there are {names}")
    click.echo(issue_text(ask(those[0], str(python or sys.executable))), nl=False)


def _print_standings(those: "list[Finding]", as_json: bool, python: Path | None) -> None:
    from plumbline.harness.findings.vendor.still_there import ask_all

    standings: list[Standing] = []
    for standing in ask_all(those, str(python or sys.executable)):
        standings.append(standing)
        say(f"{len(standings)}/{len(those)} {standing.finding.name}: {standing.verdict}", err=True)
    if as_json:
        print_json([_row(s.finding) | {"verdict": s.verdict, "figure": s.figure, "version": s.version} for s in standings])
    else:
        rows = [[s.finding.name, s.finding.kind, s.verdict, s.figure, s.version] for s in standings]
        counts = {
            verdict: sum(s.verdict == verdict for s in standings)
            for verdict in ("still there", "gone", "unavailable", "failed")
        }
        title = ", ".join(f"{number} {verdict}" for verdict, number in counts.items() if number)
        print_table(title, ["name", "kind", "verdict", "figure", "version"], rows)
    if any(standing.verdict == "failed" for standing in standings):
        sys.exit(GATE)
