"""What a child process tells the one that started it: lines of JSON of bounded length, which are read as a stranger's.

An engine's code runs in the child, so nothing that comes from there is trusted: no pickle is opened, no line may be longer than
`LONGEST`, no read waits for a line that never ends, and what a line says is checked against the types of the fields that it is
to fill. Text loses what a terminal, a table or an encoder would choke on.
"""

import dataclasses
import json
import os
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache
from multiprocessing.connection import Connection, wait
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from plumbline.harness.intake.safe_text import readable
from plumbline.harness.run.fork_servers import Forked
from plumbline.harness.run.interrupt import MemoryWatch
from plumbline.harness.store.record import Answer, Record
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.bench import Sampling

T = TypeVar("T")
LONGEST = 4 * 2**20
"""Bytes of a line; the longest of the catalogue's records take some 30 kB."""
_PART = 2**16


class BrokenMessage(Exception):
    """A child said what no child may say; the text says what."""


def _cleaned(value: Any) -> Any:
    """The same JSON value with readable texts, names among them."""
    if isinstance(value, str):
        return readable(value)
    if isinstance(value, dict):
        return {readable(name): _cleaned(element) for name, element in value.items()}
    return [_cleaned(element) for element in value] if isinstance(value, list) else value


def send(pipe: Connection, kind: str, value: Any) -> None:
    """Tell the parent something of this kind: a dataclass, or what JSON has a form for.

    Raises: TypeError, where something in it has none; ValueError, where the line is too long.
    """
    line = json.dumps({kind: _plain(value, kind)}).encode("ascii") + b"\n"
    if len(line) > LONGEST:
        raise ValueError(f"{kind}: {len(line)} bytes, expected at most {LONGEST}")
    while line:
        line = line[os.write(pipe.fileno(), line) :]


def _plain(value: Any, where: str) -> Any:
    """The value in what JSON has a form for."""
    if value is None or type(value) in (bool, int, str) or isinstance(value, float):
        return value
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name), f"{where}.{field.name}") for field in dataclasses.fields(value)}
    if isinstance(value, Mapping) and all(type(name) is str for name in value):
        return {name: _plain(element, f"{where}.{name}") for name, element in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(element, f"{where}[{index}]") for index, element in enumerate(value)]
    what = f"{type(value).__module__}.{type(value).__name__}"
    raise TypeError(f"{where}: got {readable(repr(value), 80)} of {what}, expected a JSON value")


@dataclasses.dataclass(slots=True)
class Inbox:
    """The parent's end of a pipe.

    Terms: rest: the bytes of a line that has not ended. waiting: what has come and was not asked for yet. ended: will nothing
    more come?
    """

    pipe: Connection
    rest: bytes = b""
    waiting: list[tuple[str, Any]] = dataclasses.field(default_factory=list)
    ended: bool = False

    def lines(self) -> list[tuple[str, Any]]:
        """What has come, each with its kind, as much as one message may hold; never waits. Raises: BrokenMessage."""
        messages: list[tuple[str, Any]] = []
        for _ in range(LONGEST // _PART):
            if self.ended or not self.pipe.poll():
                break
            chunk = self._part()
            self.ended = not chunk
            *whole, self.rest = (self.rest + chunk).split(b"\n")
            if max(map(len, (*whole, self.rest))) > LONGEST:
                raise BrokenMessage(f"a message of more than {LONGEST} bytes")
            messages += [_parsed(line) for line in whole]
        return messages

    def next(self, seconds: float) -> tuple[str, Any] | None:
        """The next message, waited for; None after so many seconds. Raises: EOFError, BrokenMessage."""
        until = time.monotonic() + seconds
        while not self.waiting:
            left = until - time.monotonic()
            if left <= 0 or not wait([self.pipe], timeout=left):
                return None
            self.waiting += self.lines()
            if self.ended and not self.waiting:
                raise EOFError
        return self.waiting.pop(0)

    def _part(self) -> bytes:
        try:
            return os.read(self.pipe.fileno(), _PART)
        except ConnectionError:
            return b""


@dataclasses.dataclass(slots=True)
class Worker:
    """A process off a fork server, as seen from here. Terms: watch: of its memory; None where nobody watches. inbox: what it
    says."""

    process: Forked
    watch: MemoryWatch | None
    inbox: Inbox

    def tell(self, message: object) -> None:
        """Tell it something; that it has died while it waited is for its inbox to say."""
        with suppress(ConnectionError):
            self.inbox.pipe.send(message)

    def stop(self) -> None:
        """End it, whatever it does, and what it started."""
        if self.watch is not None:
            self.watch.stop()
        self.process.end()
        self.inbox.pipe.close()


def _parsed(line: bytes) -> tuple[str, Any]:
    try:
        message = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise BrokenMessage(f"no JSON ({type(error).__name__}): {readable(repr(line[:80]))}") from None
    if not isinstance(message, dict) or len(message) != 1:
        raise BrokenMessage(f"expected one kind of message, got {readable(repr(message), 80)}")
    ((kind, value),) = message.items()
    return kind, value


@cache
def _form(of: type) -> Callable[[str], Any]:
    adapter: TypeAdapter[Any] = TypeAdapter(of)
    return lambda text: adapter.validate_json(text, strict=True)


def read_value(of: type[T], value: Any) -> T:
    """A value of this type that a child told, with readable texts. Raises: BrokenMessage."""
    try:
        read: T = _form(of)(json.dumps(_cleaned(value)))  # type: ignore[arg-type]  # a class can be hashed
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or of.__name__.lower()
        raise BrokenMessage(f"{where}: got {readable(repr(first['input']), 80)}: {first['msg']}") from None
    return read


def read_record(trial: Trial, value: Any, earlier: str = "") -> Record:
    """The record of a trial with the answer that a child told: what was asked of it, this process knows better.

    Args: earlier: whose answer it may have judged. Raises: BrokenMessage.
    """
    answer = read_value(Answer, value)
    return trial.record(replace(answer, simulated_as=earlier if answer.simulated_as else ""))


def read_sampling(value: Any) -> Sampling:
    """How a child says that it samples. Raises: BrokenMessage."""
    sampling = read_value(Sampling, value)
    if sampling.steps < 1 or sampling.run < 0 or (sampling.run and sampling.steps % sampling.run):
        raise BrokenMessage(f"sampling: got {sampling.steps} steps of runs of {sampling.run}, expected whole runs")
    return sampling
