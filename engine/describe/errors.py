"""The engine's own errors and warnings."""


class NotSupported(Exception):
    """The engine has no model for `what`; `why` says what is missing."""

    def __init__(self, what: str, why: str) -> None:
        super().__init__(f"{what}: {why}")
        self.what, self.why = what, why


class Diverged(Exception):
    """The motion could not be followed beyond step number `step`, counted from 1; in a batch, that of world number `world`."""

    def __init__(self, step: int, why: str = "the state is not finite", world: int | None = None) -> None:
        super().__init__(f"{'' if world is None else f'world {world}: '}{why} after step {step}")
        self.step, self.world = step, world


class ManyImpacts(RuntimeWarning):
    """A swept step had more impacts than are followed one by one; its remainder was done with speculative contacts."""
