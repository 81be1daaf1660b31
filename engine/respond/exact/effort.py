"""How much a contact solve may cost: matrices counted, never a clock, so that a problem has the same answer on any machine.

A method asks before it factorises a matrix. What one costs, with all that goes on around it, is taken from a measurement as a
function of the number of unknowns n, in milliseconds of one core of that machine, an x86-64 server at 2.5 GHz: a call's share, and
one that grows with the cube of n.
"""

import math

__all__ = ["UNBOUNDED", "Effort"]

UNBOUNDED = math.inf

PLAIN, FINE = (0.45, 0.15), (0.5, 3.0)
"""Cost [ms] of a matrix of doubles, and of one in extended precision: of any size, and of the cube of n / 100 on top."""


class Effort:
    """What is left of the effort for one problem.

    Args: most [ms]: what all matrices together may cost; unknowns: n, three for each contact.
    """

    def __init__(self, most: float, unknowns: int) -> None:
        self.left, self.matrices, self.over = most, 0, False
        cube = (unknowns / 100) ** 3
        self._plain, self._fine = (base + share * cube for base, share in (PLAIN, FINE))

    def take(self, fine: bool = False) -> bool:
        """Whether one more matrix may be factorised, which then counts. Args: fine: in extended precision."""
        cost = self._fine if fine else self._plain
        if cost > self.left:
            self.over = True
            return False
        self.left -= cost
        self.matrices += 1
        return True
