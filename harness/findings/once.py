"""What is worked out of a store once for all that ask."""

from collections.abc import Callable, Iterable
from functools import lru_cache, wraps
from typing import TypeVar

from plumbline.harness.store.store import Store

T = TypeVar("T")


def once(read: Callable[[Store], Iterable[T]]) -> Callable[[Store], tuple[T, ...]]:
    """What a function reads of a store, as a tuple that is kept until it is called with another store."""
    return wraps(read)(lru_cache(maxsize=1)(lambda store: tuple(read(store))))
