"""Equal worlds of the engine in one array."""

from typing import TYPE_CHECKING

from plumbline.harness.adapter import Diverged, Notice, Settings, Unsupported
from plumbline.harness.trajectory import State

if TYPE_CHECKING:
    from plumbline import engine

__all__ = ["ReferenceBatch"]


class ReferenceBatch:
    """Equal worlds of the engine, advanced in one call on one thread. Args: steps: of the engine in one dt."""

    def __init__(self, batch: "engine.Batch", resolved: Settings, steps: int) -> None:
        self._batch, self._resolved, self._steps = batch, resolved, steps

    @property
    def resolved(self) -> Settings:
        """What the engine uses in every world."""
        return self._resolved

    @property
    def worlds(self) -> int:
        """How many there are."""
        return len(self._batch)

    def step(self, count: int = 1) -> None:
        """Advance every world by count * dt. Raises: Diverged, Unsupported."""
        from plumbline import engine

        try:
            self._batch.step(count * self._steps)
        except engine.Diverged as error:
            raise Diverged(str(error)) from error
        except engine.NotSupported as error:
            raise Unsupported(error.what, error.why) from error

    def state(self, world: int, out: State) -> None:
        """Write the present state of a world into `out`."""
        table = self._batch.world(world).state()
        out.p_WB[:], out.q_WB[:], out.v_WB[:], out.w_WB[:] = table[:, :3], table[:, 3:7], table[:, 7:10], table[:, 10:]

    def warnings(self) -> tuple[Notice, ...]:
        """Nothing to say."""
        return ()

    def close(self) -> None:
        """Nothing to free: the worlds are arrays."""
