"""One step's contacts as a complementarity problem in impulses: u = W r + q between relative velocity and impulse.

Every contact alpha has the frame (normal, tangent, tangent) and the law of Signorini and Coulomb, in De Saxce's form one cone
complementarity with the velocity v = u + (mu |u_T|, 0, 0):

    r in K,  v in K*,  r . v = 0,  K = {|r_T| <= mu r_N}

Source: De Saxce, Feng, The bipotential method, Math. Comput. Modelling 28, 1998; Acary, Cadoux, Applications of an existence
result for the Coulomb friction problem, 2013.
"""

from dataclasses import dataclass

from plumbline.engine.maths.types import Floats


@dataclass(frozen=True, slots=True)
class Problem:
    """Contacts of one step.

    Terms:
        inverse_mass (3k, 3k) 1/kg: W = J M^-1 J^T, symmetric, positive semi-definite; velocity (k, 3) m/s: q, what the law sees
        at no impulse; friction (k,); speed [m/s]: the largest relative velocity the step starts from, the unit of residuals.
    """

    inverse_mass: Floats
    velocity: Floats
    friction: Floats
    speed: float

    @property
    def tables(self) -> tuple[Floats, Floats, Floats, float]:
        """All of it, as compiled code takes it."""
        return self.inverse_mass, self.velocity, self.friction, self.speed

    @property
    def size(self) -> int:
        """How many contacts there are."""
        return len(self.friction)

    def after(self, impulse: Floats) -> Floats:
        """Relative velocities u (k, 3) m/s after impulses (k, 3) N s."""
        return self.velocity + (self.inverse_mass @ impulse.ravel()).reshape(-1, 3)
