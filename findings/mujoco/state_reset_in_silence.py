# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "A simulation that diverges is put back to its start and goes on as if nothing had been"
# seen = ["4.0.0"]
# documented = "On a bad state a warning is counted and the state is reset; option/flag/autoreset turns that off."
# sources = ["MuJoCo, XML Reference: option/flag, autoreset"]
# mend = "look at data.warning after each step, or disable autoreset"
# cases = []
# ///
"""A body is given a velocity that is not a number; afterwards every number is finite."""

import math

import mujoco

model = mujoco.MjModel.from_xml_string(
    '<mujoco><worldbody><body pos="0 0 1"><freejoint/><geom type="sphere" size="0.1"/></body></worldbody></mujoco>'
)
data = mujoco.MjData(model)
mujoco.mj_step(model, data, 100)
before = data.time
data.qvel[0] = math.nan
mujoco.mj_step(model, data)
finite = all(map(math.isfinite, [*data.qpos, *data.qvel]))
print(
    f"{'still there' if finite and data.time < before else 'gone'}: time was {before:.3f} s and is {data.time:.3f} s, the state {'is finite' if finite else 'is not finite'}, no error was raised"
)
