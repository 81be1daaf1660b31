"""What is worked out of a store once, and kept with it for all that ask."""

from collections.abc import Callable, Iterable
from functools import wraps
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeVar

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store


T = TypeVar("T")

P = ParamSpec("P")


def once(read: Callable[Concatenate["Store", P], T]) -> Callable[Concatenate["Store", P], T]:
    """A function of a store, and of what else tells its answers apart, that works each out once.

    Answers live as long as their store: two stores that are compared do not drive out each other's, and a store that nobody
    holds any more takes its own along.
    """

    @wraps(read)
    def kept(store: "Store", /, *question: P.args, **named: P.kwargs) -> T:
        answers: dict[Any, T] = vars(store).setdefault("_worked_out", {})
        key = read, question, *named.items()
        if key not in answers:
            answers[key] = read(store, *question, **named)
        return answers[key]

    return kept


def all_once(read: Callable[["Store"], Iterable[T]]) -> Callable[["Store"], tuple[T, ...]]:
    """The same of a function that yields what it finds, as a tuple."""
    return once(wraps(read)(lambda store: tuple(read(store))))
