"""What a step returns beside the number of steps done, and what its stages return to it."""

from typing import Final

DONE: Final = 0
DIVERGED: Final = 1  # the state stopped being finite
FULL: Final = 2  # the arena has no room for all pairs: it must grow before the next step
CONVEX_PENDING: Final = 3  # pairs wait for the convex narrow phase
UNSOLVED: Final = 4  # an implicit integrator found no solution for so long a step
SEARCH_PENDING: Final = 5  # pairs must be found before the step: bodies move, or woke
OPEN_JOINT: Final = 16  # from this number on: which joint stays open
