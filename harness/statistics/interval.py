"""A value with its interval, as everything that is measured with an error bar is handed on."""

from typing import NamedTuple


class Interval(NamedTuple):
    """A value and the 95 % interval that it lies in; both ends are None where they are not known."""

    value: float
    low: float | None = None
    high: float | None = None

    @property
    def ends(self) -> tuple[float, float]:
        """From where to where; the value itself where no interval is known."""
        return self.value if self.low is None else self.low, self.value if self.high is None else self.high

    def times(self, factor: float) -> "Interval":
        """The same in another unit."""
        return Interval(*(None if each is None else factor * each for each in self))  # type: ignore[arg-type]
