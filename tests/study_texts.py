"""Small studies in TOML, as a person writes them: what tests run through the command line, and make reports of."""

import json
from collections.abc import Sequence

__all__ = ["DOMINANCE", "ONE_CASE", "SCALING", "TREMBLE", "WITHIN", "determinism", "effects", "limits"]

COMPILED = ("mujoco", "bullet")
"""Engines that come compiled, and answer soonest."""
WITHIN = 1.1
"""How close the bracket of a limit is asked to be: the ratio of its ends."""
FEWER = 16
"""Spheres at a wall, a quarter of the case's own, which all cost alike: it is asked where the first one gets through."""
ONE_CASE = """
name = "few"
recordings = false
[[experiments]]
name = "look"
cases = ["friction_stop"]
timing = false
"""
SCALING = """
name = "small-scaling"
recordings = false
[[experiments]]
name = "pile"
cases = ["stack_pile"]
engines = ["mujoco", "bullet"]
tracks = ["default"]
parameters = { n = [4, 6, 8] }
samples = 2
sample_seconds = 0.002
"""
DOMINANCE = """
name = "small-dominance"
recordings = false
[[experiments]]
name = "flight"
cases = ["flight_projectile"]
engines = ["mujoco", "bullet"]
tracks = ["tuned"]
dominance = true
samples = 2
sample_seconds = 0.002
"""
TREMBLE = """
name = "small-tremble"
recordings = false
[variants.mujoco]
"default law" = { beside = "default", changes = "law", on = "default", integrator = "implicitfast", source = "the study" }
[[experiments]]
name = "coarse"
cases = ["stand_humanoid"]
engines = ["mujoco"]
tracks = ["default"]
dt = [0.004166666666666667]
parameters = { stiffness = [1.0] }
variants = ["*"]
timing = false
"""


def limits() -> str:
    """Where spheres break through a wall, with what helps; and at three steps, asked for the sub-step that all share."""
    return f"""
name = "small-limits"
recordings = false
[[experiments]]
name = "walls"
cases = ["tunnel_sphere_wall"]
engines = {json.dumps(COMPILED)}
tracks = ["tuned"]
parameters = {{ continuous = [false], phases = [{FEWER}] }}
timing = false
limit = {{ members = 2, remedies = ["tuned"], within = {WITHIN} }}
[[experiments]]
name = "steps"
cases = ["tunnel_sphere_wall"]
engines = ["mujoco"]
tracks = ["tuned"]
dt = [{1 / 240}, {1 / 120}, {1 / 60}]
parameters = {{ continuous = [false], phases = [{FEWER}] }}
timing = false
limit = {{ members = 2, within = 2.0, parts = [1] }}
"""


def effects(engines: Sequence[str] = COMPILED) -> str:
    """What each effect costs in a flight and in a slide."""
    return f"""
name = "small-effects"
recordings = false
[[experiments]]
name = "effects"
cases = ["flight_projectile", "friction_stop"]
engines = {json.dumps(engines)}
tracks = ["tuned"]
effects = true
samples = 3
sample_seconds = 0.002
deadline = 120.0
"""


def determinism(engines: Sequence[str] = COMPILED) -> str:
    """Which repetitions give the same bits."""
    return f"""
name = "small-determinism"
recordings = false
[[experiments]]
name = "determinism"
cases = ["system_determinism"]
engines = {json.dumps(engines)}
tracks = ["tuned"]
timing = false
determinism = true
"""
