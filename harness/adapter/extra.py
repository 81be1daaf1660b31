"""What it takes to install an engine that plumbline does not bring along."""

import sys
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Extra:
    """An engine that is installed when it is asked for: by plumbline's extra of its name, or in an environment of its own.

    Terms: megabytes: that its environment takes on the disk. seconds: that installing it took where that was measured. pythons:
    the versions of Python that its package index has wheels for.
    """

    megabytes: int
    seconds: int
    pythons: tuple[str, ...] = ("3.11", "3.12", "3.13")

    @property
    def price(self) -> str:
        """What it takes, in words."""
        return f"{self.megabytes} MB, about {self.seconds} s"

    @property
    def hindrance(self) -> str:
        """Why it cannot be installed beside this Python; '' where it can."""
        running = f"{sys.version_info.major}.{sys.version_info.minor}"
        return "" if running in self.pythons else f"needs Python {' or '.join(self.pythons)}; this is {running}"
