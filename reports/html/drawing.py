"""Pictures drawn while the pages are made: those of a small report in a thread, those of a large one in processes of their own.

What draws charts holds the interpreter until it is done, so that a thread of this process only takes turns with the pages. A
process is `python -m reports.html.drawing`: pictures come in over its connection, and their files go back.
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

from plumbline.reports.charts.figure import Figure
from plumbline.reports.page import Picture


class Drawing:
    """Draws pictures beside whoever asks for them. A context: at its end all are drawn, unless it ends in an error."""

    def __init__(self, report: Path, processes: int = 0) -> None:
        """Args: report: an earlier report of the folder, whose pictures are taken where they show the same. processes: that
        draw; 0 for a thread of this one, which is there at once."""
        self._report = report
        self._idle: SimpleQueue[_Process | None] = SimpleQueue()
        self._all: list[_Process] = []
        for _ in range(processes):
            with suppress(OSError):  # one less
                self._all.append(_Process())
        for process in self._all or (None,):
            self._idle.put(process)
        self._threads = ThreadPoolExecutor(max(1, len(self._all)), "pictures")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._threads.shutdown(cancel_futures=kind is not None)
        for process in self._all:
            process.end()

    def ask(self, picture: Picture) -> Future[str | bytes]:
        """Its file, once it is drawn; what drawing raises is raised there."""
        return self._threads.submit(self._drawn, picture)

    def _drawn(self, picture: Picture) -> str | bytes:
        """By a process, or here where that could not: what is wrong is raised here then."""
        process = self._idle.get()
        try:
            drawn = process.drawn(picture, self._report) if process is not None else None
        except (EOFError, OSError):  # it died, and is not asked again
            process = drawn = None
        finally:
            self._idle.put(process)
        return picture.kept(self._report) if drawn is None else drawn


class _Process:
    """A process that draws, as seen from here."""

    def __init__(self) -> None:
        """Raises: OSError."""
        self._connection, theirs = Pipe()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "plumbline.reports.html.drawing", str(theirs.fileno())],
                env=os.environ | {"PYTHONPATH": os.pathsep.join(str(Path(folder).absolute()) for folder in sys.path)},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,  # what it could not draw is drawn here, and told here
                pass_fds=[theirs.fileno()],
                start_new_session=True,  # an interrupt is for whoever asks
            )

    def drawn(self, picture: Picture, report: Path) -> str | bytes | None:
        """The file of a picture; None where it cannot be handed over, or drawn there. Raises: EOFError, OSError."""
        try:
            content = pickle.dumps((picture, report))
        except Exception:  # a stranger's picture may hold anything
            return None
        self._connection.send_bytes(content)
        drawn: str | bytes | None = self._connection.recv()
        return drawn

    def end(self) -> None:
        """Hang up: it ends by itself then."""
        self._connection.close()
        self._process.wait()


def main(descriptor: int) -> None:
    """Draw what comes until nobody asks any more. Args: descriptor: of the connection."""
    connection = Connection(descriptor)
    first = Figure("", "", "", {"data": {"values": [{}]}, "mark": "point"}, (), ())
    first.kept(Path(os.devnull))  # brings the JavaScript engine, while nobody waits for it yet
    while True:
        try:
            content = connection.recv_bytes()
        except EOFError:
            return
        drawn: str | bytes | None = None
        with suppress(Exception):  # whoever asked draws it then, and meets what is wrong
            picture, report = pickle.loads(content)
            drawn = picture.kept(report)
        connection.send(drawn)


if __name__ == "__main__":
    main(int(sys.argv[1]))
