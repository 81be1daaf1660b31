# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "limit"
# title = "A box that slides is lifted off the ground"
# seen = ["4.0.0"]
# documented = "The force of a contact is the point of the friction cone that is nearest to what the references ask for; beyond mu g tc/2 of slip that point has a normal force above the weight. The documentation tells the model and not this of it."
# sources = ["MuJoCo, Computation: constraint model, friction cones"]
# mend = "a longer solreffriction; impratio does not help"
# cases = ["friction_stop"]
# cause = "soft friction, which lifts what slides"
# ///
"""A box set on the ground at 3 m/s slides to a stop; whatever presses it, it has no reason to rise. One that stands does not, to the bit."""

import mujoco

G, MU = 9.81, 0.5

rises = {}
for speed in (3.0, 0.0):
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{1 / 240!r}" gravity="0 0 {-G}" cone="elliptic"/><worldbody><geom type="plane" size="9 9 1" friction="{MU} 0 0"/>'
        f'<body pos="0 0 0.05"><freejoint/><geom type="box" size="0.2 0.2 0.05" mass="1" friction="{MU} 0 0"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    data.qvel[0] = speed
    highest = 0.0
    for _ in range(360):
        mujoco.mj_step(model, data)
        highest = max(highest, data.qpos[2] - 0.05)
    rises[speed] = highest
print(
    f"{'gone' if rises[3.0] < 1e-4 else 'still there'}: it rises by {1e3 * rises[3.0]:.2f} mm; one that stands by {1e3 * rises[0.0]:.2f} mm"
)
