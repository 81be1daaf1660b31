"""Fork servers of a test's own, which load NumPy alone: for how servers start, die and differ, not for what trials need."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.forkserver import ForkServer
from typing import Any

import pytest

from plumbline.harness.run import fork_servers

__all__ = ["light_servers"]


@contextmanager
def light_servers() -> Iterator[None]:
    """For the time of a block; those of other tests are as before afterwards, and none of these is left."""
    apart, loaded, plain = dict[Any, Any](), dict[Any, Any](), ForkServer()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fork_servers, "_PRELOAD", ("numpy",))
        patch.setattr(fork_servers, "_expected", [])
        patch.setattr(fork_servers, "_PLAIN", plain)
        patch.setattr(fork_servers, "_servers", loaded)
        patch.setattr(fork_servers, "_apart", apart)
        plain.set_forkserver_preload(fork_servers._preload(()))
        try:
            yield
        finally:
            for server in (plain, *apart.values(), *loaded.values()):
                if server is not None and server._forkserver_pid is not None:
                    os.kill(server._forkserver_pid, signal.SIGKILL)
                    os.waitpid(server._forkserver_pid, 0)
