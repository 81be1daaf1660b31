"""A request to stop is remembered where Python drops the exception that it raises."""

import signal
from collections.abc import Iterator

import pytest

from plumbline.harness.run.interrupt import listen, stop_if_asked


@pytest.fixture(autouse=True)
def _handlers() -> Iterator[None]:
    """Puts back who listened before, and leaves no request behind: a run in a later test would obey it."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    listen()
    for number, handler in before.items():
        signal.signal(number, handler)


class _Interrupted:
    """Where an exception is dropped: the end of an object."""

    def __init__(self, number: signal.Signals) -> None:
        self.number = number

    def __del__(self) -> None:
        signal.raise_signal(self.number)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_request_that_python_drops_is_met_at_the_next_look(number: signal.Signals) -> None:
    listen()
    stop_if_asked()
    doomed = _Interrupted(number)
    del doomed
    with pytest.raises(KeyboardInterrupt):
        stop_if_asked()
    listen()
    stop_if_asked()


def test_a_request_stops_at_once() -> None:
    listen()
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
