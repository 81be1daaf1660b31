"""The page `docs/cli.md`: examples, and each command with its options as the code has them; and the command that says what a
word means.
"""

import tomllib
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path

import click

from plumbline.harness.cli.guard import USAGE, say, stop
from plumbline.harness.cli.listing import print_table

_EXAMPLES = Path(__file__).with_name("examples.toml")
_HEAD = """# The command line

Written from the code: `PLUMBLINE_GOLDEN=write pytest tests/architecture/test_command_page.py` writes it anew.

Exit codes: 0 done, 1 a gate failed or a page of the report could not be made, 2 wrong usage or a bad input file, 3 the machine
failed us, 130 interrupted.
"""


def _commands(group: click.Group, context: click.Context) -> Iterator[tuple[click.Command, click.Context]]:
    """Each command below a group with its context; a group comes before its commands."""
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if command is None or command.hidden:
            continue
        inner = click.Context(command, info_name=name, parent=context)
        yield command, inner
        if isinstance(command, click.Group):
            yield from _commands(command, inner)


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def page(main: click.Group) -> str:
    """The page in Markdown."""
    from plumbline.reports.words.glossary import linked

    examples = tomllib.loads(_EXAMPLES.read_text(encoding="utf-8"))["group"]
    wide = max(len(command) for group in examples for command, _ in group["commands"])
    lines = [_HEAD, "## Examples\n"]
    for group in examples:
        lines += [f"{group['title']}:\n", "```", *(f"{command:{wide}}  {what}" for command, what in group["commands"]), "```\n"]
    lines.append("## Commands and options\n")
    for command, context in _commands(main, click.Context(main, info_name="plumbline")):
        usage = " ".join([context.command_path, *command.collect_usage_pieces(context)])
        lines += [f"### {context.command_path}\n", f"`{usage}`\n", f"{_cell(command.help or '')}\n"]
        records = [record for option in command.get_params(context) if (record := option.get_help_record(context))]
        if len(records) > 1:
            rows = [f"| `{_cell(option)}` | {_cell(what)} |" for option, what in records if "--help" not in option]
            lines += ["| option | meaning |", "|---|---|", *rows, ""]
    return linked("\n".join(lines).rstrip() + "\n", "glossary.md")


@click.command()
@click.argument("words", metavar="[WORD]", nargs=-1)
def glossary(words: tuple[str, ...]) -> None:
    """What a WORD of pages, tables and help texts means; all words without one."""
    from plumbline.reports.words import glossary as page

    entries, wanted = page.glossary(), " ".join(words).lower()
    if not wanted:
        print_table("Glossary", ("word", "meaning"), [(", ".join(entry.words), entry.meaning) for entry in entries])
        return
    by_word = {word.lower(): entry for entry in entries for word in entry.words}
    if wanted not in by_word and (form := page.WORD.fullmatch(wanted)):
        wanted = page.house_word(form)  # 'resamples', 'remedies', as pages write them
    if wanted not in by_word:
        close = get_close_matches(wanted, by_word, cutoff=0.5)
        hint = f"; did you mean {', '.join(close)}?" if close else ""
        stop(USAGE, f"'{wanted}' is not in the glossary{hint}")
    entry = by_word[wanted]
    say(f"{', '.join(entry.words)}: {entry.meaning}")
