"""Fork servers of a test's own, which load NumPy alone: for how servers start, die and differ, not for what trials need."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from plumbline.harness.run import fork_servers

__all__ = ["light_servers"]


@contextmanager
def light_servers() -> Iterator[None]:
    """For the time of a block; those of other tests are as before afterwards, and none of these is left."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fork_servers, "_PRELOAD", ("numpy",))
        patch.setattr(fork_servers, "_expected", [])
        patch.setattr(fork_servers, "_servers", {})
        patch.setattr(fork_servers, "_deadly", set())
        try:
            yield
        finally:
            fork_servers.end_servers([*fork_servers._servers])
