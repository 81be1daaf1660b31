"""What recorded contact forces are allowed to miss of Newton's and Coulomb's laws, whatever the time step.

Forces and motion are two readings of one solve, so that no order of the step lies between them. What does is the residual of a
solver that iterates: it stops where the cost improves by less than 1e-8 of its scale, the finest default among the engines, and
a cost is quadratic in its residual, so that forces are known to the root of it.
"""

from plumbline.harness.case import Check
from plumbline.harness.metrics.contact_residuals import cone_residual, dissipation_residual, signorini_residual
from plumbline.harness.metrics.momentum_residual import momentum_residual

SOLVED = 1e-4
"""Share by which forces may miss a law that is solved for: the root of 1e-8."""
_ROOT = "1e-4: a solver that stops at an improvement of 1e-8 of a cost that is quadratic in its residual"


def forces_keep_momentum() -> Check:
    """In each step contact forces and gravity give bodies the momentum that they gain."""
    return Check(
        metric=momentum_residual,
        at_most=SOLVED,
        because=f"a force is what changes momentum, {_ROOT}; where samples are a step apart",
    )


def forces_obey_coulomb(end: float | None = None) -> tuple[Check, ...]:
    """Contacts push across no gap, stay in their cone, and rub mu N against their slip, until `end` [s]."""
    return (
        Check(
            metric=signorini_residual, at_most=SOLVED, because=f"contacts neither pull nor act across a gap; {_ROOT}", end=end
        ),
        Check(metric=cone_residual, at_most=SOLVED, because=f"no friction is beyond mu N; {_ROOT}", end=end),
        Check(
            metric=dissipation_residual,
            at_most=SOLVED,
            because=f"what slips, and goes on for the whole step, is rubbed by mu N against its way; {_ROOT}",
            end=end,
        ),
    )
