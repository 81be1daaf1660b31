"""A server of a run folder in a process of its own, and requests as bytes, for tests of what clients may do to it."""

import contextlib
import signal
import socket
import subprocess
import sys
from pathlib import Path

import psutil

__all__ = ["START", "SHORT", "BIG", "SECRET", "Served", "everything", "HOST", "FIRST"]


START = """
import sys
from pathlib import Path
import reports
from reports.server import connections
connections.HEAD_SECONDS, connections.PATIENCE, connections.SLOWEST = map(float, sys.argv[2:])
reports.serve(Path(sys.argv[1]), 0, lambda said: print(said, flush=True))
"""
SHORT = (1.0, 1.0, 256 * 2**20)
"""Seconds for a head, for an answer, and the least pace [bytes/s]: short, for the tests that wait for them to pass."""
THREADS, FILES, MEMORY = 16, 2 * 128 + 64, 600 * 2**20
"""What the server may take, whatever comes: threads; files, a connection's and its answer's each; bytes."""
BIG = 40 * 2**20
SECRET = b"the secret of this machine"


class Served:
    """A server in a process of its own."""

    def __init__(self, folder: Path, limits: tuple[float, float, float] = (10.0, 30.0, 32 * 1024)) -> None:
        command = [sys.executable, "-c", START, str(folder), *map(str, limits)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        self.port = int(self.process.stdout.readline().strip().rstrip("/").rsplit(":", 1)[1])
        self.watched = psutil.Process(self.process.pid)

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

    def stop(self) -> None:
        self.process.send_signal(signal.SIGINT)
        self.process.communicate(timeout=60)


def everything(connection: socket.socket) -> bytes:
    parts = []
    with contextlib.suppress(ConnectionResetError):
        while part := connection.recv(2**16):
            parts.append(part)
    return b"".join(parts)


HOST = b"Host: 127.0.0.1\r\n"
FIRST = b"GET /report/index.html HTTP/1.1\r\n"
