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
    Share,
    Step,
    Unit,
)
from plumbline.harness.case.problem import Problem, Rays

__all__ = [
    "Axis", "ByParameters", "Case", "Check", "Clocks", "Converged", "Count", "FloatCount", "NotNegative", "Parameters",
    "Positive", "Problem", "Rays", "Share", "Step", "Unit",
]  # fmt: skip
