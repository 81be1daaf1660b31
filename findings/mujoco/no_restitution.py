# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "There is no coefficient of restitution, and a ball does not bounce by default"
# seen = ["4.0.0"]
# documented = "Restitution is got by springs: solref in its negative format, a stiffness and a damping, from which the rebound follows with contacts that last several steps."
# sources = ["MuJoCo, Modeling: restitution"]
# mend = 'solref="-stiffness -damping" with solimp near 1, set for the rebound wanted; contacts cannot pull, so the textbook formula of a spring and damper is off'
# cases = ["impact_bounce", "impact_oblique"]
# ///
"""A ball is dropped from a metre on a default plane; no field of a geom, a pair or the options is called restitution."""

import mujoco

spec = mujoco.MjSpec()
fields = [
    name
    for owner in (spec, spec.option, spec.add_pair(), spec.worldbody.add_geom())
    for name in dir(owner)
    if "restitution" in name.lower()
]
model = mujoco.MjModel.from_xml_string(
    '<mujoco><worldbody><geom type="plane" size="1 1 1"/><body pos="0 0 1.1"><freejoint/><geom type="sphere" size="0.1"/></body></worldbody></mujoco>'
)
data, touched, apex = mujoco.MjData(model), False, 0.0
for _ in range(1000):
    mujoco.mj_step(model, data)
    touched = touched or data.ncon > 0
    if touched and data.qvel[2] > 0:
        apex = max(apex, data.qpos[2] - 0.1)
print(
    f"{'gone' if fields else 'still there'}: fields named so: {', '.join(fields) or 'none'}; dropped from 1 m a ball comes back to {apex:.3f} m"
)
