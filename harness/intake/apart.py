"""One call into code that is not ours, in a process of its own: what comes back is an answer of its type, or why there is none.

The child is `python -m harness.intake.apart`: it reads what to call on its standard input, which this program alone writes, and
writes the answer as JSON. Nothing of it is opened as a pickle.
"""

import json
import os
import pickle
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from plumbline.harness.intake.bounded import absolute, bounded
from plumbline.harness.intake.safe_text import readable

START = 10.0
"""Seconds that a child may take to be there, beside what it is given for the call."""
_LONGEST = 64 * 2**20
"""Bytes of an answer."""

T = TypeVar("T")


class NoAnswer(Exception):
    """Nothing came back; the message says why: what was raised, or how the process ended."""


def apart(
    form: type[T],
    seconds: float,
    function: Callable[..., object],
    *arguments: object,
    interpreter: str = sys.executable,
    path: Sequence[str] = (),
) -> T:
    """What a function of a module gives for these arguments, which are pickled.

    Args: path: where another interpreter than this one finds this program. Raises: NoAnswer, OSError.
    """
    from pydantic import TypeAdapter, ValidationError  # late: a listing calls nobody

    ended = bounded(
        [interpreter, "-P", "-m", "plumbline.harness.intake.apart"],
        START + seconds,
        answers=True,
        order=pickle.dumps((function, arguments)),
        # It is to find what this process finds, wherever that has been told to look.
        env=os.environ | {"PYTHONPATH": os.pathsep.join(absolute(path or sys.path))},
    )
    if not ended.answer:
        words = f": {ended.last_words}" if ended.code and ended.last_words else ""
        raise NoAnswer(readable(f"{ended.how} and no answer{words}", 300))
    try:
        message = json.loads(ended.answer[:_LONGEST])
        if "raised" in message:
            raise NoAnswer(readable(str(message["raised"]), 2000))
        return TypeAdapter(form).validate_json(json.dumps(message["answer"]))
    except ValidationError as error:
        raise NoAnswer(f"its answer is none: {readable(error.errors()[0]['msg'], 200)}") from None
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise NoAnswer(f"its answer is none: {readable(str(error), 200)}") from None


def _main(out: Path) -> None:
    function, arguments = pickle.load(sys.stdin.buffer)
    message: dict[str, Any]
    try:
        message = {"answer": function(*arguments)}
        text = json.dumps(message)
    except BaseException as error:
        text = json.dumps({"raised": f"{type(error).__name__}: {error}"})
    out.write_text(text, encoding="utf-8")
    os._exit(0)


if __name__ == "__main__":
    _main(Path(sys.argv[1]))
