"""A case: one question in SI units, its scene, its truth and the checks that judge an answer."""

from plumbline.harness.case.case import (
    Axis,
    ByParameters,
    Case,
    Check,
    Clocks,
    Converged,
    Count,
    FloatCount,
    NotNegative,
    Parameters,
    Positive,
    Rays,
    Share,
    Step,
    Unit,
)

__all__ = [
    "Axis",
    "ByParameters",
    "Case",
    "Check",
    "Clocks",
    "Converged",
    "Count",
    "FloatCount",
    "NotNegative",
    "Parameters",
    "Positive",
    "Rays",
    "Share",
    "Step",
    "Unit",
]
