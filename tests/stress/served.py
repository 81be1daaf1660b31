"""A server of a run folder in a process of its own, and requests as bytes, for tests of what clients may do to it."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil

__all__ = ["LONG", "SHORT", "BIG", "SECRET", "Served", "served_with", "everything", "HOST", "FIRST"]


START = """
import os, sys
from pathlib import Path
from plumbline.reports.server import serve
from plumbline.reports.server import connections
for limits in sys.argv[2:]:
    if os.fork() == 0:
        connections.HEAD_SECONDS, connections.PATIENCE, connections.SLOWEST = map(float, limits.split())
        # In one call, since the other one writes to the same pipe.
        serve(Path(sys.argv[1]), 0, lambda said: os.write(1, f"{limits};{os.getpid()};{said}\\n".encode()))
        os._exit(0)
for _ in sys.argv[2:]:
    os.wait()
"""
LONG = (10.0, 30.0, 32 * 1024)
"""Seconds for a head, for an answer, and the least pace [bytes/s]."""
SHORT = (1.0, 1.0, 256 * 2**20)
"""As above; short, for the tests that wait for them to pass."""
THREADS, FILES, MEMORY = 16, 2 * 128 + 64, 600 * 2**20
"""What the server may take, whatever comes: threads; files, a connection's and its answer's each; bytes."""
BIG = 40 * 2**20
SECRET = b"the secret of this machine"


@contextlib.contextmanager
def served_with(folder: Path, *limits: tuple[float, float, float]) -> Iterator[list["Served"]]:
    """Servers of a folder, each in a process of its own, forked off one that has loaded what they need."""
    told = [" ".join(map(str, of_one)) for of_one in limits]
    process = subprocess.Popen([sys.executable, "-c", START, str(folder), *told], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    lines = (process.stdout.readline().strip().split(";") for _ in limits)
    started = {of: Served(int(pid), int(address.rstrip("/").rsplit(":", 1)[1])) for of, pid, address in lines}
    try:
        yield [started[of_one] for of_one in told]
    finally:
        for server in started.values():
            os.kill(server.watched.pid, signal.SIGINT)
        process.communicate(timeout=60)


class Served:
    """A server in a process of its own."""

    def __init__(self, pid: int, port: int) -> None:
        self.port, self.watched = port, psutil.Process(pid)

    def connect(self) -> socket.socket:
        return socket.create_connection(("127.0.0.1", self.port), timeout=30)

    def ask(self, raw: bytes) -> bytes:
        """All that is answered to raw bytes, until the server closes."""
        with self.connect() as connection:
            connection.sendall(raw)
            return everything(connection)

    def get(self, path: str = "/report/index.html") -> bytes:
        return self.ask(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\n\r\n".encode())

    def taken(self) -> str:
        """What the server takes now, within its bounds."""
        threads, files = self.watched.num_threads(), self.watched.num_fds()
        memory = self.watched.memory_info().rss
        assert threads <= THREADS
        assert files <= FILES
        assert memory <= MEMORY
        return f"threads {threads}, files {files}, memory {memory / 2**20:.0f} MiB"

    def is_well(self) -> None:
        answer = self.get()
        assert answer.startswith(b"HTTP/1.1 200 "), answer[:200]
        assert answer.endswith(b"The report</title>")


def everything(connection: socket.socket) -> bytes:
    parts = []
    with contextlib.suppress(ConnectionResetError):
        while part := connection.recv(2**16):
            parts.append(part)
    return b"".join(parts)


HOST = b"Host: 127.0.0.1\r\n"
FIRST = b"GET /report/index.html HTTP/1.1\r\n"
