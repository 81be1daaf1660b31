"""What of a case reaches an engine: the scene, how long it runs, what acts on it, and what is read of it as it goes.

An engine's answer rests on this and on nothing else of its case. What judges the answer, checks, metrics and truth, stands in
`harness.case.case`, which the code that steps does not import.
"""

import hashlib
from dataclasses import dataclass
from typing import Any

from plumbline.harness.case.forces import Control, wrench_after
from plumbline.harness.case.symmetries import Retelling
from plumbline.harness.scene import Scene
from plumbline.harness.scene.file import dump_json
from plumbline.harness.trajectory import Floats, State


@dataclass(frozen=True, slots=True, kw_only=True)
class Rays:
    """Rays of one cast: origins (r, 3) m and unit directions (r, 3) in W, followed up to max_range [m]."""

    origins: Floats
    directions: Floats
    max_range: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """An initial value problem with what is recorded of it.

    Terms:
        duration, sample_interval [s]: as of a `Case`. contacts: are they read at each sample? impulses: what bodies gave each
        other in every step too? control, rays, retellings: those of the case at its parameters. worlds: how many are stepped
        together, 0 where the case is not about that. readings_due: is what ideal sensors have to read worked out beside?
    """

    scene: Scene
    duration: float
    sample_interval: float
    contacts: bool = False
    impulses: bool = False
    control: Control | None = None
    rays: Rays | None = None
    retellings: tuple[Retelling, ...] | None = None
    worlds: int = 0
    readings_due: bool = False

    def plain(self) -> list[Any]:
        """What tells it from another one, JSON-ready; of a control its interval and what it answers at two instants."""
        control = self.control and [self.control.interval, _digest(wrench_after(self.control, State.initial(self.scene)))]
        tellings = self.retellings and [
            [other.name, other.clock, other.restored_at, _digest(dump_json(other.scene).encode())] for other in self.retellings
        ]
        rays = self.rays and [_digest(self.rays.origins.tobytes() + self.rays.directions.tobytes()), self.rays.max_range]
        scene, read = _digest(dump_json(self.scene).encode()), [self.contacts, self.impulses, self.worlds, self.readings_due]
        return [scene, float(self.duration), self.sample_interval, read, control, tellings, rays]


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
