"""The command that runs a study: its options, which load nothing that they do not need."""

import re
from pathlib import Path
from typing import Any

import click

from plumbline.harness.cli.options import limited
from plumbline.harness.cli.robot_options import robot_options, run_options
from plumbline.harness.intake.safe_text import quoted


def _parse_shard(_context: click.Context, _parameter: click.Parameter, text: str) -> tuple[int, int]:
    shard = re.fullmatch("([0-9]{1,6})/([0-9]{1,6})", text)
    index, count = (int(number) for number in shard.groups()) if shard else (0, 0)
    if not 1 <= index <= count:
        raise click.BadParameter(f"{quoted(text)}, expected i/n with 1 <= i <= n, like 2/4")
    return index, count


_MERGE = "--resume-with-another-study"


class _Resumable(click.Command):
    """A command with a flag that may have a value: click would take the word behind a plain `--resume` for it."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click does, where `--resume=merge` is a flag of its own."""
        for word in args:
            value = word.removeprefix("--resume=")
            if value not in (word, "merge"):
                raise click.BadParameter(f"'{value}', expected merge, or --resume alone", param_hint="--resume")
        try:
            return super().parse_args(ctx, [_MERGE if word == "--resume=merge" else word for word in args])
        except click.NoSuchOption as error:
            known = sorted(name for option in self.params for name in option.opts if name.startswith("--") and name != _MERGE)
            near = f"; did you mean {' or '.join(error.possibilities)}?" if error.possibilities else ""
            raise click.UsageError(
                f"no option {quoted(error.option_name, 60)}, expected some of {', '.join(known)}{near}", ctx
            ) from None


@click.command(cls=_Resumable)
@click.argument("study")
@click.option("--engine", "engine_names", multiple=True, help="Only this engine, or its ==VERSION or =WHEEL; may be repeated.")
@click.option("--case", "globs", multiple=True, metavar="GLOB", help="Only cases of this pattern; may be repeated.")
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="The run folder [build/STUDY].")
@click.option("--workers", type=click.IntRange(1, 1024), default=2, show_default=True, help="Accuracy runs side by side.")
@click.option("--scheduler", metavar="ADDRESS", help="Run on the workers of a dask.distributed scheduler, tcp://HOST:PORT.")
@click.option("--shard", default="1/1", callback=_parse_shard, metavar="I/N", help="Only the I-th of N parts.")
@click.option("--resume", "resume", flag_value="same", help="Go on with a stopped run; =merge: with another study.")
@click.option(_MERGE, "resume", flag_value="merge", hidden=True)
@robot_options
@run_options
@limited
def run(study: str, **options: Any) -> None:
    """Run STUDY: a built-in name (quick, accuracy, price, limits, effects, ...), a study file, a scene or robot of your own."""
    from plumbline.harness.cli.run_study import run_study  # late: its help waits for no library

    run_study(study, **options)
