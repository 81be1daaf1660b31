"""Connections of strangers, none of which can keep the others waiting.

One loop listens to all of them. Each asks one question, in a head of bounded length and time, and takes its answer at a pace
that it must not fall below. Where there are too many, the one that has been silent longest makes room.
"""

import asyncio
import os
from collections.abc import Awaitable, Callable
from contextlib import suppress
from http import HTTPStatus
from pathlib import Path

from plumbline.reports.server.request import PageRequest, Refused, Response, read_head, text

MOST = 128
"""Connections at a time."""
HEAD_BYTES = 16 * 1024
HEAD_SECONDS = 10.0
PATIENCE = 30.0
"""Seconds that an answer may take to send, and as many more as its bytes take at the slowest pace."""
SLOWEST = 32 * 1024
"""Bytes a second."""
LINGER = 1.0
"""Seconds that are left to a client to close: closing before it has, a machine may drop what is still under way."""
_PART = 64 * 1024

Ask = Callable[[PageRequest], Awaitable[Response]]


class Connections:
    """All that are open, with the answers to give them."""

    def __init__(self, ask: Ask) -> None:
        self._ask = ask
        self._heard: dict[asyncio.Task[None], bool] = {}

    async def take(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve one connection to its end."""
        task: asyncio.Task[None] | None = asyncio.current_task()
        assert task is not None
        if len(self._heard) >= MOST:
            self._make_room()
        self._heard[task] = False
        writer.transport.set_write_buffer_limits(high=0)  # what is drained is out of our hands
        try:
            answer, content = await self._answer(reader, task)
            await _send(writer, answer, content)
            await _take_leave(reader, writer)
        except (asyncio.CancelledError, asyncio.IncompleteReadError, TimeoutError, OSError):
            pass  # it made room, or it is gone, or it was too slow
        finally:
            self._heard.pop(task, None)
            writer.transport.abort()

    def _make_room(self) -> None:
        first = next(iter(self._heard))
        out = next((task for task, heard in self._heard.items() if not heard), first)
        self._heard.pop(out)
        out.cancel()

    async def _answer(self, reader: asyncio.StreamReader, task: "asyncio.Task[None]") -> tuple[Response, bool]:
        """The answer, and whether its content is asked for."""
        try:
            async with asyncio.timeout(HEAD_SECONDS):
                head = await reader.readuntil(b"\r\n\r\n")
        except asyncio.LimitOverrunError:
            return text(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, f"expected a head of at most {HEAD_BYTES} bytes"), True
        except TimeoutError:
            return text(HTTPStatus.REQUEST_TIMEOUT, f"expected a request within {HEAD_SECONDS:g} s"), True
        self._heard[task] = True
        try:
            request = read_head(head)
        except Refused as refused:
            return text(refused.status, str(refused)), not head.startswith(b"HEAD ")
        return await self._ask(request), request.content


async def _send(writer: asyncio.StreamWriter, answer: Response, content: bool) -> None:
    """Send an answer, part by part. Raises: TimeoutError, OSError."""
    if isinstance(answer.content, Path):
        with answer.content.open("rb") as file:
            length = os.fstat(file.fileno()).st_size
            await _send_parts(writer, answer, length if content else 0, length, file.read)
    else:
        whole = memoryview(answer.content)
        offset = 0

        def read(count: int) -> bytes:
            nonlocal offset
            offset += count
            return bytes(whole[offset - count : offset])

        await _send_parts(writer, answer, len(whole) if content else 0, len(whole), read)


async def _send_parts(
    writer: asyncio.StreamWriter, answer: Response, left: int, length: int, read: Callable[[int], bytes]
) -> None:
    async with asyncio.timeout(PATIENCE + left / SLOWEST):
        writer.write(answer.head(length))
        while left and (block := read(min(left, _PART))):
            writer.write(block)
            await writer.drain()
            left -= len(block)
        await writer.drain()


async def _take_leave(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Say that nothing more comes, and wait a little for the client to part as well."""
    writer.write_eof()
    with suppress(TimeoutError):
        async with asyncio.timeout(LINGER):
            while await reader.read(_PART):
                pass
