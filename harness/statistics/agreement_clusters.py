"""Camps: who agrees with whom, where each says a value with an error bar and not all say the same.

Two agree where they lie no further apart than their bars together. Agreement is not passed on: A may agree with B and B with C
while A and C differ, when B's bar is wide. So whoever has the narrowest bar speaks first; the next one joins the camp with all
of whose members it agrees, or founds one of its own; one that agrees with all members of several camps is undecided, for its
bar is too wide to tell them apart.
"""

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Flags: TypeAlias = NDArray[np.bool_]


def camps(agree: Flags, widths: Sequence[float]) -> list[tuple[int, ...]]:
    """The camps that each one belongs to, by number from 0 in the order of their founding: one, or several where it is
    undecided.

    Args: agree (n, n): does each pair agree? widths (n,): of the bars; the narrowest speaks first.
    """
    founded: list[list[int]] = []
    belongs: dict[int, tuple[int, ...]] = {}
    for bar in sorted(range(len(widths)), key=lambda bar: (widths[bar], bar)):
        fits = tuple(k for k, members in enumerate(founded) if all(agree[bar, other] for other in members))
        if not fits:
            fits = (len(founded),)
            founded.append([])
        if len(fits) == 1:
            founded[fits[0]].append(bar)
        belongs[bar] = fits
    return [belongs[bar] for bar in range(len(widths))]
