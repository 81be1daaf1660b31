# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "limit"
# title = "A box that slides is lifted off the ground, by more than a step's fall"
# seen = ["4.0.0"]
# documented = "The force of a contact is the point of the friction cone that is nearest to what the references ask for; beyond mu g tc/2 of slip that point has a normal force above the weight. The documentation tells the model and not this of it."
# sources = ["MuJoCo, Computation: constraint model, friction cones"]
# mend = 'a small impratio with the slip correction, impratio="1e-4" and noslip_iterations="5" in <option>, while bodies slide: what sticks on a slope then creeps. A longer solreffriction, "0.3 1", lets the box slide 5 % further; a finer step makes the hop smaller'
# cases = ["friction_stop"]
# cause = "soft friction, which lifts what slides"
# ///
"""Boxes set on the ground at 1 to 3 m/s slide to a stop; whatever presses them, they have no reason to rise. What gravity moves a body by in a step is granted."""

import math
import sys
import time

import mujoco

G, MU, DT = 9.81, 0.5, 1 / 240


def slide(mended, speed, angle=0.0, dt=DT, cone="elliptic"):
    """How far the box rises and slides [m], and the time of its steps [s]."""
    slip = 'impratio="1e-4" noslip_iterations="5"' * mended
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{dt!r}" gravity="0 0 {-G}" cone="{cone}" {slip}/><worldbody><geom name="g" type="plane" size="9 9 1"/>'
        '<body pos="0 0 0.05"><freejoint/><geom name="b" type="box" size="0.2 0.2 0.05" mass="1"/></body></worldbody>'
        f'<contact><pair geom1="g" geom2="b" condim="3" friction="{MU} {MU} 0 0 0"/></contact></mujoco>'
    )
    data = mujoco.MjData(model)
    data.qvel[:2] = speed * math.cos(angle), speed * math.sin(angle)
    highest, begun = 0.0, time.process_time()
    for _ in range(round(1.5 / dt)):
        mujoco.mj_step(model, data)
        highest = max(highest, float(data.qpos[2]) - 0.05)
    return highest, math.hypot(data.qpos[0], data.qpos[1]), time.process_time() - begun


def measure(mended):
    """The largest rise [m], how far the box at 3 m/s slides [m], and the time of the steps [s]."""
    runs = [slide(mended, speed, angle) for speed in (3.0, 2.0, 1.0) for angle in (0.0, math.pi / 4)]
    return max(rise for rise, _, _ in runs), runs[0][1], sum(took for _, _, took in runs)


MENDED = "--mended" in sys.argv
rise, distance, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if rise < G * DT**2 else 'stands' if MENDED else 'still there'}: "
    f"it rises by {1e3 * rise:.2f} mm, with the pyramidal cone by {1e3 * slide(MENDED, 3.0, cone='pyramidal')[0]:.2f}, at MuJoCo's own step by "
    f"{1e3 * slide(MENDED, 3.0, dt=0.002)[0]:.2f}, at rest by {1e3 * slide(MENDED, 0.0)[0]:.2f}; a step's fall is {1e3 * G * DT**2:.2f} mm; "
    f"it slides {distance:.3f} m, {3.0**2 / (2 * MU * G):.3f} are due"
)
