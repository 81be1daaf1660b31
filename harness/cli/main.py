"""The command line: the one place that knows every part; each command imports what it needs when it is called."""

import click

from harness.cli.cluster_commands import merge
from harness.cli.diff_command import diff
from harness.cli.figure_command import figure
from harness.cli.findings_command import findings
from harness.cli.guard import Guarded
from harness.cli.history_group import history
from harness.cli.installed import cases, check, engines
from harness.cli.nightly_command import nightly
from harness.cli.parity_command import parity
from harness.cli.run_folder import report, reproduce, serve, show, verify, view
from harness.cli.run_study import run
from harness.cli.scene_commands import scene
from harness.cli.select_command import select
from harness.cli.warm_command import warm


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
    warm,
):
    main.add_command(command)


if __name__ == "__main__":
    main()
