# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "A box creeps down an incline that holds it"
# seen = ["4.0.0"]
# documented = "Friction is soft: it lets bodies slip slowly. Against it the documentation has the elliptic cone with impratio above 1, and noslip iterations."
# sources = ["MuJoCo, Modeling: preventing slip", "MuJoCo, XML Reference: option, impratio, noslip_iterations"]
# mend = '<option cone="elliptic" impratio="10"/>'
# cases = ["friction_creep", "friction_threshold", "stack_bowl"]
# cause = "soft friction, which creeps"
# ///
"""At 0.9 of the angle of friction Coulomb's law holds a box where it is; a tenth of a millimetre is what it settles by."""

import math

import mujoco

G, MU = 9.81, 0.5

angle = math.degrees(math.atan(0.9 * MU))
a = math.radians(angle)
model = mujoco.MjModel.from_xml_string(
    f'<mujoco><option timestep="{1 / 240!r}" gravity="{G * math.sin(a)!r} 0 {-G * math.cos(a)!r}"/><worldbody>'
    f'<geom type="plane" size="9 9 1" friction="{MU} 0 0"/><body pos="0 0 0.025"><freejoint/>'
    f'<geom type="box" size="0.1 0.1 0.025" mass="1" friction="{MU} 0 0"/></body></worldbody></mujoco>'
)
data = mujoco.MjData(model)
mujoco.mj_step(model, data, 120)
start = data.qpos[0]
mujoco.mj_step(model, data, 240)
crept = data.qpos[0] - start
print(f"{'gone' if crept < 1e-4 else 'still there'}: {1e3 * crept:.2f} mm in a second, after half a second to settle; 0 is due")
