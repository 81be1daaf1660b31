"""How large a number of a file may be: finite is not enough where it is squared, multiplied and summed up."""

import math

LARGEST = 1e60
"""Five factors of it are finite, as in m r^2 w^2; the observable universe is 1e27 m across."""


def wrong_size(value: float) -> str:
    """What is expected of a number that is none, or too large; '' where nothing is."""
    if value != value or abs(value) == math.inf:  # of a whole number without end there is no float
        return "expected finite numbers"
    return f"expected at most {LARGEST:g} in size" if abs(value) > LARGEST else ""
