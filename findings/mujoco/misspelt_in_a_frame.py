# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "A misspelt attribute within a frame is read as nothing"
# seen = ["4.0.0"]
# documented = "MJCF is said to be checked against a schema, which names what is unknown; frame and replicate are said to lie outside of it. That what they hold is not checked either is not said."
# sources = ["MuJoCo, XML Reference: meta elements", "MuJoCo, Modeling: URDF extensions"]
# mend = "load the model once without its frames, or compare the attributes with those of mj_printSchema"
# cases = []
# ///
"""A hinge's damping of 0.5 N m s/rad, misspelt: refused in a body, and in the same body within a frame read as a hinge without damping."""

import mujoco

BODY = '<body><joint dampng="0.5"/><geom size="0.1"/></body>'


def read(inside: str) -> mujoco.MjModel | None:
    """The model; None where it is refused."""
    try:
        return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{inside}</worldbody></mujoco>")
    except ValueError:
        return None


alone, framed = read(BODY), read(f"<frame>{BODY}</frame>")
assert alone is None, "the same mistake is no longer refused outside of a frame"
print(
    "gone: a misspelt damping is refused within a frame too"
    if framed is None
    else f"still there: a damping of 0.5, misspelt, is read as {framed.dof_damping[0]:g} within a frame"
)
