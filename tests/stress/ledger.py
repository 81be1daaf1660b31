"""The faults that were planted and what became of them: one line each at the end of a run of the tests."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import pytest

__all__ = ["PROPERTY", "Ledger", "Page"]

Name = tuple[str, str]
"""The family of a fault and the fault."""
PROPERTY = "planted faults"
"""The name under which the report of a test brings what it told, also out of another process."""


def pytest_configure(config: pytest.Config) -> None:
    """Take part in a run of the tests."""
    config.pluginmanager.register(Ledger(), PROPERTY)


def _name(words: Sequence[str]) -> Name:
    family, fault = words
    return family, fault


def _line(text: str) -> str:
    return "".join(sign if sign.isprintable() else "?" for sign in text[:120])


@dataclass(slots=True, eq=False)
class Ledger:
    """All faults of a run of the tests by family and name, each counted once, however many tests tell of it.

    Terms: figures: what was measured where a fault was survived, the last word counts. lost: why a fault was not survived.
    """

    figures: dict[Name, str] = field(default_factory=dict)
    lost: dict[Name, str] = field(default_factory=dict)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take what the report of a test brings."""
        for name, told in report.user_properties:
            if name == PROPERTY and isinstance(told, list):
                faults, test, failure = told
                self.close([(_name(fault), figure) for fault, figure in faults], _name(test), failure)

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Print all lines."""
        if len(self):
            terminalreporter.section(PROPERTY)
            for line in self.lines():
                terminalreporter.line(line)

    def close(self, faults: Sequence[tuple[Name, str]], test: Name, failure: str) -> None:
        """Enter what one test told, with its failure, or '' where it passed.

        A test that failed before it told of any fault stands for one: its file and its name.
        """
        if failure:
            self.lost |= dict.fromkeys([name for name, _ in faults] or [test], _line(failure))
        self.figures |= dict(faults)

    def __len__(self) -> int:
        return len(self.figures | self.lost)

    def lines(self) -> Iterator[str]:
        """Family, fault, outcome and figure of each, in order, and how many there are."""
        for name in sorted(self.figures | self.lost):
            said = ("NOT survived", self.lost[name]) if name in self.lost else ("survived", self.figures[name])
            yield " | ".join((*name, *said))
        yield f"{len(self)} different faults, {len(self) - len(self.lost)} survived, {len(self.lost)} not survived"


@dataclass(slots=True)
class Page:
    """The faults that one test tells of."""

    faults: list[tuple[Name, str]] = field(default_factory=list)

    def survived(self, family: str, fault: str, figure: str) -> None:
        """One planted fault was survived, with the figure that says how well. It counts once the whole test has passed."""
        for text in (family, fault, figure):
            if not text.strip() or not text.isprintable() or "|" in text:
                raise ValueError(f"ledger: got {text!r}, expected a line of text without '|'")
        self.faults.append(((family, fault), figure))
