"""A comment below a pull request: what got worse first, within what such a comment may hold."""

from collections.abc import Collection

from plumbline.harness.findings.changes.values import Change, Changes
from plumbline.harness.findings.changes.words import (
    command,
    first_line,
    folded,
    gate_in_short,
    headline,
    judged_in_short,
    one_a_side,
)
from plumbline.harness.intake.safe_text import LONGEST, markdown_cell, one_line

LONGEST_COMMENT = 60_000
"""Characters: a comment on GitHub holds 65 536, and what posts it may add to it."""
_MOST = 25
"""Lines of one section; nobody reads more there."""
_SECTIONS = (
    ("Worse", ("worse",)),
    ("Unconfirmed", ("unconfirmed",)),
    ("Better", ("better",)),
    ("Other bits, within tolerance", ("within tolerance",)),
)


def comment(changes: Changes, gated: Collection[str] = (), least: float = 0.0) -> str:
    """The summary in Markdown, never longer than LONGEST_COMMENT. Args: least: see `gate_in_short`."""
    lines = ["# What changed", "", markdown_cell(first_line(changes)), "", f"**{markdown_cell(headline(changes))}.**"]
    if not gated:
        lines += ["", f"{judged_in_short(changes.judged_of()).capitalize()}."]
    else:
        lines += ["", f"Gate ({markdown_cell(', '.join(sorted(gated)))}): {gate_in_short(changes, gated, least)}."]
    lines += [f"Not compared: {markdown_cell(text)}" for text in changes.unread]
    for title, senses in (*_SECTIONS, ("Circumstances", ("neither",))):
        rows = [row for row in changes.rows if row.sense in senses]
        lines += _section(title, rows, changes) if rows else []
    made = ""
    for number, line in enumerate(lines):
        rest = f"\n… {len(lines) - number} lines more: `plumbline diff` prints them.\n"
        if len(made) + len(line) + 1 + len(rest) > LONGEST_COMMENT:
            return made + rest
        made += f"{line}\n"
    return made


def _section(title: str, rows: list[Change], changes: Changes) -> list[str]:
    groups = one_a_side(folded(rows))
    lines = ["", f"## {title} ({len(rows)})", ""]
    for text, group in groups[:_MOST]:
        command_line = command(group[0], changes)
        shown = f" `{one_line(command_line, LONGEST).replace('`', '')}`" if command_line else ""
        lines.append(f"* {markdown_cell(text)}{shown}")
    return [*lines, f"* … and {len(groups) - _MOST} more"] if len(groups) > _MOST else lines
