"""A case: one question in SI units, its scene, its truth and the checks that judge an answer."""

from plumbline.harness.case.case import Axis, Case, Check, Clocks, Converged, Parameters, Rays, Step, Unit

__all__ = [
    "Axis",
    "Case",
    "Check",
    "Clocks",
    "Converged",
    "Parameters",
    "Rays",
    "Step",
    "Unit",
]
