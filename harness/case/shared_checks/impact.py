"""What a law of restitution is allowed to miss by how long an impact lasts: a step, or the length of a spring.

A method that has such a law turns a body round within the step that finds it. One whose contacts are springs with dampers,
stiff enough for their half period to last T, keeps a body for T and is passed into by v T/pi. T is a number of steps: ten, in
which Euler's method still keeps the half period to half a percent, (w dt)^2/24 = (pi/10)^2/24. Such a contact gives back what
gravity does to it meanwhile, but for the damper's share: over all damping ratios the square of the rebound falls by at most
g T/(3 v) of the square of the speed of approach v, and the body leaves the place of contact by at most T later than it came,
the slower flight that follows taken together with it (x'' = max(0, -2 z w x' - w^2 x) - g, integrated).
"""

SPRING_STEPS = 10
"""How long an impact lasts that is a spring's half period [steps]."""
