"""The command that says what a word means."""

from difflib import get_close_matches

import click

from plumbline.harness.cli.guard import USAGE, say, stop
from plumbline.harness.cli.listing import print_table


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
