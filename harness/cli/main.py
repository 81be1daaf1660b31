"""The command line: the one place that knows every part; each command imports what it needs when it is called."""

import click

from plumbline.harness.cli.command_page import glossary
from plumbline.harness.cli.diff_command import diff
from plumbline.harness.cli.findings_command import findings
from plumbline.harness.cli.guard import Guarded
from plumbline.harness.cli.history_command import history
from plumbline.harness.cli.installed import cases, check, engines, warm
from plumbline.harness.cli.nightly_command import nightly
from plumbline.harness.cli.parity_command import parity
from plumbline.harness.cli.run_folder import figure, publish, report, reproduce, serve, show, verify, view
from plumbline.harness.cli.run_study import merge, run
from plumbline.harness.cli.scene_commands import scene
from plumbline.harness.cli.select_command import select


@click.group(cls=Guarded, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="plumbline")
def main() -> None:
    """Compare rigid-body physics engines: what accuracy costs in time, and where each engine breaks."""


for command in (
    engines,
    cases,
    check,
    run,
    show,
    report,
    view,
    serve,
    verify,
    reproduce,
    diff,
    merge,
    select,
    figure,
    findings,
    nightly,
    history,
    scene,
    parity,
    publish,
    warm,
    glossary,
):
    main.add_command(command)


if __name__ == "__main__":
    main()
