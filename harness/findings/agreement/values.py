"""The values that engines are judged by in a scene without a truth: sides, differences between camps, and the agreement."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from harness.search.own_limits import OwnLimit
from harness.trajectory import Floats, Trajectory
from harness.trajectory.parting import Extent

__all__ = ["Agreement", "Difference", "Side", "Word"]

Word: TypeAlias = Literal["agrees", "converges elsewhere", "converges", "does not converge", "diverged", "cannot"]
"""'converges' alone where no limit is agreed that it could stand by or against."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Side:
    """One engine on one track.

    Terms:
        word, why: the verdict, and its reason where it is none of convergence, else what steps without an answer came to.
        limit: what it comes to by itself. camps: the letter of its camp, several where it is undecided, none without a limit.
        votes: does it count for its engine? ours: is it our own? distance: of its limit from the agreed one, up to the time
        to which both are known, as a share of the size; None where there is no such. since [s]: from then on it lies apart
        from it, None where it does not. adds: effects that the scene does not call for and that the engine says it computes.
    """

    engine: str
    track: str
    ours: bool
    word: Word
    why: str
    limit: OwnLimit
    camps: tuple[str, ...] = ()
    votes: bool = False
    distance: float | None = None
    since: float | None = None
    adds: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """Two camps. Terms: distance: of their sharpest members, as a share of the size, at `time` [s], the last that both are
    known at; since [s]: from then on further than their bars; body: that lies apart most."""

    one: str
    other: str
    distance: float
    time: float
    since: float
    body: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement:
    """What engines say of one scene.

    Terms:
        case, where: the scene, and what differs from the case's own. duration [s]. scale: sizes of what moves.
        granted: share of the size that limits may lie apart beyond their bars.
        agreed: the camp whose limit is the truth here, '' where none is. until [s]: up to there it is known; bar: its error
        there, as a share of the size. limit: its poses, bars (t,) up to each sample; None without one.
    """

    case: str
    where: str
    duration: float
    scale: Extent
    granted: float
    sides: tuple[Side, ...]
    differences: tuple[Difference, ...]
    agreed: str = ""
    until: float = 0.0
    bar: float | None = None
    limit: Trajectory | None = None
    bars: Floats | None = None

    def members(self, camp: str) -> tuple[Side, ...]:
        """Those that stand in a camp, undecided ones left out."""
        return tuple(side for side in self.sides if side.camps == (camp,))

    @property
    def camps(self) -> tuple[str, ...]:
        """Their letters."""
        return tuple(sorted({side.camps[0] for side in self.sides if len(side.camps) == 1}))
