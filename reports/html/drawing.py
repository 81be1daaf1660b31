"""Pictures drawn while the pages are made, in processes of their own: what draws charts may end the process that it is in.

It holds the interpreter until it is done, too, so that a thread would only take turns with the pages. A process is
`python -m reports.html.drawing`: pictures come in over its connection, and their files go back.
"""

import os
import pickle
import subprocess
import sys
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from queue import SimpleQueue
from typing import Self

from plumbline.harness.intake.bounded import named_signal
from plumbline.reports.charts.figure import Figure
from plumbline.reports.page import Picture

PATIENCE = 120.0
"""Seconds on the wall that a picture may take; the dearest take one."""
_TRIES = 2
"""Processes that a picture is asked of: the first may have died of what it drew before."""


class NotDrawn(Exception):
    """There is no picture; the message says why."""


class Drawing:
    """Draws pictures beside whoever asks for them. A context: at its end all are drawn, unless it ends in an error."""

    def __init__(self, report: Path, processes: int = 1) -> None:
        """Args: report: an earlier report of the folder, whose pictures are taken where they show the same. processes: that
        draw."""
        self._report = report
        self._idle: SimpleQueue[_Process] = SimpleQueue()
        self._all = [_Process() for _ in range(processes)]
        if not report.is_dir():  # else most pictures stand there
            for process in self._all:
                process.start()
        for process in self._all:
            self._idle.put(process)
        self._threads = ThreadPoolExecutor(processes, "pictures")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._threads.shutdown(cancel_futures=kind is not None)
        for process in self._all:
            process.end()

    def ask(self, picture: Picture) -> Future[str | bytes]:
        """Its file, once it is drawn where none stands; NotDrawn is raised there where it is not."""
        with suppress(Exception):  # which drawing it will meet too
            if (standing := picture.standing(self._report)) is not None:
                ready: Future[str | bytes] = Future()
                ready.set_result(standing)
                return ready
        return self._threads.submit(self._drawn, picture)

    def _drawn(self, picture: Picture) -> str | bytes:
        process = self._idle.get()
        try:
            for number in range(_TRIES):
                try:
                    return process.drawn(picture, self._report)
                except (EOFError, OSError) as error:
                    how = process.end()
                    if number == _TRIES - 1:
                        raise NotDrawn(f"what draws it {how}") from error
            raise AssertionError
        finally:
            self._idle.put(process)


class _Process:
    """A process that draws, as seen from here; it is started when it is first asked, and after it has died."""

    def __init__(self) -> None:
        self._connection: Connection | None = None
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Begin to load what draws. Raises: OSError."""
        ours, theirs = Pipe()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "plumbline.reports.html.drawing", str(theirs.fileno())],
                env=os.environ | {"PYTHONPATH": os.pathsep.join(str(Path(folder).absolute()) for folder in sys.path)},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,  # how it ended is told
                pass_fds=[theirs.fileno()],
                start_new_session=True,  # an interrupt is for whoever asks
            )
        self._connection = ours

    def drawn(self, picture: Picture, report: Path) -> str | bytes:
        """The file of a picture. Raises: EOFError, OSError, where the process dies of it; NotDrawn, with what is wrong."""
        if self._connection is None:
            self.start()
        assert self._connection is not None
        self._connection.send_bytes(pickle.dumps((picture, report)))
        if not self._connection.poll(PATIENCE):
            raise TimeoutError
        kind, content = (answer := self._connection.recv_bytes())[:1], answer[1:]
        if kind == _ERROR:
            raise NotDrawn(content.decode())
        return content.decode("utf-8", "surrogatepass") if kind == _TEXT else content

    def end(self) -> str:
        """End it. Returns: how it had ended, in words."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        if self._process is None:
            return "was not started"
        try:
            code = self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            return f"did not end within {PATIENCE:g} s"
        return f"was killed by {named_signal(-code)}" if code < 0 else f"ended with exit code {code}"


_TEXT, _BYTES, _ERROR = b"t", b"b", b"e"
"""How an answer begins."""


def main(descriptor: int) -> None:
    """Draw what comes until nobody asks any more. Args: descriptor: of the connection."""
    connection = Connection(descriptor)
    # Brings the JavaScript engine, while nobody waits for it yet.
    Figure("", "", "", {"data": {"values": [{}]}, "mark": "point"}, (), ()).kept(Path(os.devnull))
    while True:
        try:
            content = connection.recv_bytes()
        except EOFError:
            return
        try:
            picture, report = pickle.loads(content)
            drawn: str | bytes = picture.kept(report)
            answer = _BYTES + drawn if isinstance(drawn, bytes) else _TEXT + drawn.encode("utf-8", "surrogatepass")
        except Exception as error:
            answer = _ERROR + f"{type(error).__name__}: {error}".encode("utf-8", "backslashreplace")
        connection.send_bytes(answer)


if __name__ == "__main__":
    main(int(sys.argv[1]))
