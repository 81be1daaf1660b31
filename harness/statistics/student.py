"""Student's t: percentiles and tails, from `scipy.special` alone; `scipy.stats` hands on the same and costs half a second more.

Source: Student, Biometrika 6 (1908) 1.
"""


def percentile(share: float, freedom: float) -> float:
    """What a share of all values lies below. Args: freedom: degrees of freedom, above 0."""
    from scipy.special import stdtrit  # late: a listing must not pay for it

    return float(stdtrit(freedom, share))


def tail(value: float, freedom: float) -> float:
    """The probability of more than a value; NaN without degrees of freedom."""
    from scipy.special import stdtr  # late, too

    return float(stdtr(freedom, -value))
