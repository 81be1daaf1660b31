# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "By default the cone of friction is a pyramid: a push at 45 degrees goes 42 % too far"
# seen = ["4.0.0"]
# documented = "option/cone is pyramidal by default; the elliptic one is offered as the better model of the physical reality."
# sources = ["MuJoCo, XML Reference: option, cone", "MuJoCo, Computation: friction cones"]
# mend = '<option cone="elliptic"/>'
# cases = ["friction_isotropy", "friction_stop"]
# tracks = ["default"]
# cause = "friction as a pyramid, not a cone"
# ///
"""Equal boxes pushed at 2 m/s at five angles go equally far: v2/(2 mu g), but for a step's way or two (2 % each)."""

import math
import sys
import time

import mujoco

G, SPEED, MU = 9.81, 2.0, 0.5
ANGLES = (0.0, 20.0, 45.0, 70.0, 90.0)
BOX = '<body pos="0 {y} 0.025"><freejoint/><geom type="box" size="0.1 0.1 0.025" mass="1" friction="{mu} 0 0"/></body>'


def measure(mended, dt=1 / 240):
    """How far the boxes go [m], by angle, and the time of the steps [s]."""
    cone = "elliptic" if mended else "pyramidal"
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{dt!r}" gravity="0 0 {-G}" cone="{cone}"/><worldbody>'
        f'<geom type="plane" size="9 9 1" friction="{MU} 0 0"/>'
        + "".join(BOX.format(y=2 * k, mu=MU) for k in range(len(ANGLES)))
        + "</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    for k, angle in enumerate(ANGLES):
        data.qvel[6 * k : 6 * k + 2] = SPEED * math.cos(math.radians(angle)), SPEED * math.sin(math.radians(angle))
    begun = time.process_time()
    mujoco.mj_step(model, data, round(1 / dt))
    took = time.process_time() - begun
    return [math.hypot(data.qpos[7 * k], data.qpos[7 * k + 1] - 2 * k) for k in range(len(ANGLES))], took


MENDED = "--mended" in sys.argv
distances, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if max(abs(distance / distances[0] - 1) for distance in distances) < 0.05 else 'stands' if MENDED else 'still there'}: "
    f"{', '.join(f'{distance:.3f}' for distance in distances)} m at {', '.join(f'{angle:g}' for angle in ANGLES)} degrees "
    f"({100 * (distances[2] / distances[0] - 1):+.0f} % at 45, {measure(MENDED, 0.002)[0][2]:.3f} m at MuJoCo's own step); {SPEED**2 / (2 * MU * G):.3f} m are due"
)
