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
"""Two equal boxes pushed at 2 m/s, along an axis and at 45 degrees, go equally far: v2/(2 mu g), but for a step's way or two (2 % each)."""

import math

import mujoco

G, SPEED, MU = 9.81, 2.0, 0.5
BOX = '<body pos="0 {y} 0.025"><freejoint/><geom type="box" size="0.1 0.1 0.025" mass="1" friction="{mu} 0 0"/></body>'

model = mujoco.MjModel.from_xml_string(
    f'<mujoco><option timestep="{1 / 240!r}" gravity="0 0 {-G}"/><worldbody><geom type="plane" size="9 9 1" friction="{MU} 0 0"/>'
    + BOX.format(y=0, mu=MU)
    + BOX.format(y=2, mu=MU)
    + "</worldbody></mujoco>"
)
data = mujoco.MjData(model)
data.qvel[0] = SPEED
data.qvel[6:8] = SPEED * math.cos(math.pi / 4), SPEED * math.sin(math.pi / 4)
mujoco.mj_step(model, data, 240)
straight, askew = math.hypot(data.qpos[0], data.qpos[1]), math.hypot(data.qpos[7], data.qpos[8] - 2)
print(
    f"{'gone' if abs(askew / straight - 1) < 0.05 else 'still there'}: {straight:.3f} m along an axis, {askew:.3f} m at 45 degrees "
    f"({100 * (askew / straight - 1):+.0f} %); {SPEED**2 / (2 * MU * G):.3f} m are due"
)
