"""Programs that run each in a process of its own, forked from one that has imported Numba, which takes most of their time."""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

__all__ = ["NUMBA", "Fork", "forks"]

NUMBA = "import numba"
ROOT = str(Path(__file__).parents[1])
SERVER = """
import contextlib, io, json, os, sys
exec(sys.argv[1])
for line in sys.stdin:
    if os.fork() == 0:
        program, folder, told = json.loads(line)
        os.chdir(folder)
        sys.path.insert(0, folder)
        os.environ.update(told)
        with contextlib.redirect_stdout(io.StringIO()) as said:
            exec(program, {})
        print(json.dumps(said.getvalue()), flush=True)
        os._exit(0)
    if os.wait()[1]:
        print("null", flush=True)
"""


class Fork(Protocol):
    """Runs a program. Returns: what it printed. Raises: AssertionError where it failed; what it raised stands on stderr."""

    def __call__(self, program: str, folder: str = ROOT, **told: str) -> str:
        """Args: folder: where it runs and imports from first. told: variables of its environment."""


@contextmanager
def forks(before: str = NUMBA) -> Iterator[Fork]:
    """For the time of a block. Args: before: what all programs have done already; none has imported anything of ours."""
    command, pipe = [sys.executable, "-B", "-c", SERVER, before], subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as server:
        asked, answers = server.stdin, server.stdout
        assert asked is not None
        assert answers is not None

        def run(program: str, folder: str = ROOT, **told: str) -> str:
            print(json.dumps((program, folder, told)), file=asked, flush=True)
            said = json.loads(answers.readline())
            assert isinstance(said, str), f"failed: {program}"
            return said

        yield run
