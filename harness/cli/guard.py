"""How a command ends: exit codes, what people can mend as one line, and sentences that do nothing to a terminal."""

import os
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from io import StringIO, TextIOWrapper
from itertools import pairwise
from typing import Any, NoReturn

import click

from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.safe_text import one_line, readable
from plumbline.harness.run.interrupt import listen

GATE, USAGE, MACHINE, INTERRUPTED = 1, 2, 3, 130
"""Exit codes: a check that failed, a wrong use, a machine that does not let us, a request to stop."""
_CODES = {"usage": USAGE, "machine": MACHINE}


def stop(code: int, message: str) -> NoReturn:
    """End the process with this exit code, the message spelled out on standard error."""
    click.echo(readable(message), err=True)
    sys.exit(code)


def _misused(error: click.ClickException) -> NoReturn:
    """Say what click says of a wrong use, cleaned."""
    message = StringIO()
    error.show(file=message)
    stop(error.exit_code, message.getvalue().rstrip("\n"))


def say(sentence: str, err: bool = False) -> None:
    """A line of text that may come from engines and files."""
    click.echo(one_line(sentence), err=err)


def fail_for(sentences: Sequence[str], code: int = GATE) -> None:
    """Say these on standard error; end the process with this exit code if there are any."""
    for sentence in sentences:
        say(sentence, err=True)
    if sentences:
        sys.exit(code)


class _Notices:
    """Standard error, which nobody may be listening to: a disk that is full takes notices, and no rows and no exit code."""

    def __init__(self, stream: TextIOWrapper) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """All of it counts as written."""
        with suppress(OSError):
            self._stream.write(text)
            self._stream.flush()
        return len(text)

    def flush(self) -> None:
        """`write` does."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def open_streams() -> None:
    """In the place of a standard stream that is closed, one that takes all: a file of ours would get its number otherwise."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, "r" if number == 0 else "w", encoding="utf-8", closefd=False))  # noqa: SIM115
    if sys.stderr is sys.__stderr__ and isinstance(sys.stderr, TextIOWrapper):
        sys.stderr = _Notices(sys.stderr)  # it passes all else on


def check_words(words: Sequence[str]) -> None:
    """Refuse what no name of a file, a folder or anything else can be. Raises: click.UsageError."""
    for before, word in pairwise(("", *words)):
        option = word.removesuffix("=") if re.fullmatch("--[a-z-]+=", word) else before if not word else ""
        if option or not word:
            raise click.UsageError(f"{option or 'an argument'}: got '', expected a value")
        try:
            word.encode()
        except UnicodeEncodeError:
            raise click.UsageError(f"{word!a}: a name that is no UTF-8, expected one that is") from None


class Guarded(click.Group):
    """Turns the errors that people can mend into a line and an exit code; anything else keeps its trace."""

    def make_context(self, *arguments: Any, **extra: Any) -> click.Context:
        """Parse the part of the command line that comes before the command."""
        open_streams()
        try:
            check_words(arguments[1] if len(arguments) > 1 else extra["args"])
            return super().make_context(*arguments, **extra)
        except click.ClickException as error:
            _misused(error)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command. Requests to stop are heard even where the shell has told its children to ignore them."""
        listen()
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")  # a terminal that lacks a letter is no reason to stop
        try:
            return super().invoke(ctx)
        except click.ClickException as error:
            _misused(error)
        except (click.exceptions.Exit, click.Abort, BrokenPipeError):
            raise
        except KeyboardInterrupt:
            stop(INTERRUPTED, "interrupted")
        except OSError as error:
            stop(MACHINE, f"{error.filename or 'machine'}: {error.strerror or error}")
        except MemoryError:
            stop(MACHINE, "no memory is left for this process; free some, and go on with --resume")
        except PlumblineError as error:
            stop(_CODES[error.lies_in], str(error))
