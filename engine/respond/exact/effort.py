"""How much a contact solve may cost: matrices counted, never a clock, so that a problem has the same answer on any machine.

A method asks before it factorises a matrix. What one costs, with all that goes on around it, is taken from a measurement as a
function of the number of unknowns n, in milliseconds of one core of that machine, an x86-64 server at 2.5 GHz.
"""

import math

UNBOUNDED = math.inf

PLAIN, TRACED, FINE_MATRIX = (0.3, 0.15), (0.12, 0.5), (0.6, 3.0)
"""Cost [ms] of a matrix of any size, and on top of that of the cube of n / 100: a step of Newton in doubles; one
along a traced path; and a factor with more digits."""


class Effort:
    """What is left of the effort for one problem.

    Args: most [ms]: what all matrices together may cost; unknowns: n, three for each contact.
    """

    def __init__(self, most: float, unknowns: int) -> None:
        self.left, self.matrices, self.over, self._cube = most, 0, False, (unknowns / 100) ** 3

    def most(self, wanted: int) -> int:
        """How many of so many matrices in doubles may still be factorised."""
        return int(min(wanted, self.left / (PLAIN[0] + PLAIN[1] * self._cube)))

    def took(self, matrices: int, wanted: bool) -> None:
        """Count matrices in doubles. Args: wanted: whether one more would have been factorised, had the effort been there."""
        for _ in range(matrices):
            self.take()
        if wanted and self.most(1) == 0:
            self.over = True

    def take(self, cost: tuple[float, float] = PLAIN) -> bool:
        """Whether one more matrix may be factorised, which then counts. Args: cost: as of `PLAIN`."""
        price = cost[0] + cost[1] * self._cube
        if price > self.left:
            self.over = True
            return False
        self.left -= price
        self.matrices += 1
        return True
