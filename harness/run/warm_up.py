"""Compile what an engine's trials will need: several processes, each one group of kernels at a time.

Two processes that need a kernel at the same time wait for each other; here each group goes to one process. Processes come off a
fork server that has loaded the engine, and end with this one.
"""

from collections.abc import Callable, Collection, Sequence, Set
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from tempfile import TemporaryDirectory

from plumbline.harness.adapter.kernels import KernelGroup, Kernels
from plumbline.harness.intake.bounded import named_signal
from plumbline.harness.intake.safe_text import LONGEST
from plumbline.harness.run.child import confine
from plumbline.harness.run.fork_servers import WORTH_A_SERVER, loaded, start
from plumbline.harness.run.interrupt import stop_if_asked
from plumbline.harness.run.message import BrokenMessage, Inbox, Worker, send
from plumbline.harness.run.waiting_time import Progress

_LISTENS = 1.0
"""Seconds between looks at whether this is to stop."""


def _titled(group: KernelGroup) -> str:
    """A group in a few words."""
    first, *others = group.names
    return f"{first} and {len(others)} more" if others else first


def following(waiting: Collection[int], groups: Sequence[KernelGroup], own: Set[str], begun: Set[str]) -> int:
    """The group that a process takes next: one of a family that it has begun, else of one that none has, else any.

    Groups that come first come before all others. Args: waiting: numbers of groups, at least one. own: the families that the
    process has begun. begun: those that any process has.
    """
    eligible = [number for number in waiting if groups[number].first] or list(waiting)
    return min(eligible, key=lambda number: (groups[number].family not in own, groups[number].family in begun))


def warm_up(
    title: str, kernels: Callable[[], Kernels], wanted: Collection[int], loads: tuple[str, ...], workers: int
) -> list[str]:
    """Compile groups of an engine's kernels; progress goes to standard error.

    Args: kernels: at the top of a module, since the processes call it too. wanted: numbers of groups. loads: modules that are
    loaded before. workers: processes at most.
    Returns: what could not be compiled, with the reasons.
    """
    groups, waiting, failures, begun = kernels().groups, list(wanted), list[str](), set[str]()
    running: list[_Compiler] = []
    with Progress(title, len(waiting)) as progress, TemporaryDirectory(prefix="plumbline-warm-") as scratch:
        try:
            while waiting or running:
                while waiting and len(running) < workers:
                    running.append(_start(kernels, loads, Path(scratch) / "log"))
                    running[-1].take(waiting, groups, begun)
                wait([worker.inbox.pipe for worker in running], timeout=_LISTENS)
                stop_if_asked()
                for worker in list(running):
                    answer = worker.answer()
                    if answer is None:
                        continue
                    group = groups[worker.number]
                    failures += [f"{_titled(group)}: {answer}"] if answer else []
                    progress.advance(_titled(group))
                    if waiting and not worker.inbox.ended:
                        worker.take(waiting, groups, begun)
                    else:
                        running.remove(worker)
                        worker.dismiss()
        finally:
            for worker in running:
                worker.stop()
    return failures


@dataclass(slots=True)
class _Compiler(Worker):
    """A process that compiles. Terms: number: of the group that it compiles. own: the families that it has begun."""

    number: int = -1
    own: set[str] = field(default_factory=set)

    def take(self, waiting: list[int], groups: Sequence[KernelGroup], begun: set[str]) -> None:
        """Begin another of the groups that wait."""
        self.number = following(waiting, groups, self.own, begun)
        waiting.remove(self.number)
        self.own.add(groups[self.number].family)
        begun.add(groups[self.number].family)
        self.tell(self.number)

    def answer(self) -> str | None:
        """Why its group could not be compiled, '' if it could; None as long as it compiles."""
        try:
            for _, reason in self.inbox.lines():
                return str(reason)
        except BrokenMessage as error:
            self.inbox.ended = True
            return f"broken contract: {error}"
        if not self.inbox.ended:
            return None
        code = self.process.exit_code() or 0
        return f"the process died: {named_signal(-code)}" if code < 0 else f"the process ended with exit code {code}"

    def dismiss(self) -> None:
        """Let the process end by itself."""
        self.tell(None)
        self.process.exit_code()
        self.stop()


def _start(kernels: Callable[[], Kernels], loads: tuple[str, ...], log: Path) -> _Compiler:
    process = start(loaded(loads, WORTH_A_SERVER), _serve, kernels, log)
    return _Compiler(process, None, Inbox(process.pipe))


def _serve(pipe: Connection, kernels: Callable[[], Kernels], log: Path) -> None:
    """Compile the groups whose numbers come in, and tell of each why it could not be compiled, '' if it could."""
    confine(log)
    groups = kernels().groups
    while (number := pipe.recv()) is not None:
        reason = ""
        try:
            groups[number].compile()
        except Exception as error:
            reason = f"{type(error).__name__}: {error}"[:LONGEST]
        send(pipe, "compiled", reason)
