"""The values that engines are judged by in a scene without a truth: sides, differences between camps, and the agreement."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from plumbline.harness.scene import Scene
from plumbline.harness.search.own_limits import TOLERANCE, OwnLimit
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.parting import Extent

Word: TypeAlias = Literal["agrees", "converges elsewhere", "converges", "does not converge", "diverged", "cannot"]
"""'converges' alone where no limit is agreed that it could stand by or against."""


ROUNDING = 1e-12
"""Share of the size below which a way is rounding: 1e4 steps of one part in 1e16 each."""


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
class CampGap:
    """Two camps. Terms: distance: the largest of their sharpest members, as a share of the size, up to `time` [s], the last
    that both are known at; since [s]: from then on further than their bars; body: that lies apart most."""

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
        case, where: the scene, and what differs from the case's own; scene: None where no engine was told it. duration [s].
        scale: sizes of what moves.
        granted: share of the size that limits may lie apart beyond their bars.
        agreed: the camp whose limit is the truth here, '' where none is. until [s]: up to there it is known; bar: its error
        there, as a share of the size. limit: its poses, bars (t,) up to each sample; None without one.
        finest [s]: the step that every ladder is to come down to, if there is time, and finest_unknown [s] where its limit is
        not known to the end; 0 where none is said.
    """

    case: str
    where: str
    duration: float
    scale: Extent
    granted: float
    sides: tuple[Side, ...]
    differences: tuple[CampGap, ...]
    agreed: str = ""
    until: float = 0.0
    bar: float | None = None
    limit: Trajectory | None = None
    bars: Floats | None = None
    scene: Scene | None = None
    finest: float = 0.0
    finest_unknown: float = 0.0

    def members(self, camp: str) -> tuple[Side, ...]:
        """Those that stand in a camp, undecided ones left out."""
        return tuple(side for side in self.sides if side.camps == (camp,))

    @property
    def still(self) -> bool:
        """Is the agreed limit that nothing moves? No body then leaves its place, or turns, by more than the limit's bar."""
        if self.limit is None:
            return False
        least = max(self.bar or 0.0, ROUNDING) * self.scale.largest
        moved = np.linalg.norm(self.limit.p_WB - self.limit.p_WB[:1], axis=-1).max(initial=0.0)
        # Of two unit quaternions the scalar product is the cosine of half the angle between them.
        cosine = np.abs(np.sum(self.limit.q_WB * self.limit.q_WB[:1], axis=-1)).min(initial=1.0)
        turned = 2.0 * np.arccos(min(1.0, float(cosine)))
        return bool(moved <= least and turned <= max(self.bar or 0.0, np.sqrt(ROUNDING)))

    @property
    def cut_short(self) -> tuple[Side, ...]:
        """Whose ladder of steps ended before it came down to the finest one, though the last step had an answer."""

        def cut(side: Side) -> bool:
            last = side.limit.rungs[-1] if side.limit.rungs else None
            finest = self.finest if side.limit.until >= 0.999 * self.duration else self.finest_unknown
            return last is not None and last.run is not None and last.dt > finest * (1 + 1e-9) > 0

        return tuple(filter(cut, self.sides))

    @property
    def moving(self) -> tuple[Side, ...]:
        """Whose finest answer moves a body from its place, or turns it, by more than the tolerance."""
        return tuple(side for side in self.sides if side.limit.farthest(self.scale) > TOLERANCE)

    @property
    def camps(self) -> tuple[str, ...]:
        """Their letters."""
        return tuple(sorted({side.camps[0] for side in self.sides if len(side.camps) == 1}))
