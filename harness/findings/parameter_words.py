"""What a case's parameter is called where people read of it, and its unit: a name like `n` says nothing outside of its case."""

from collections.abc import Mapping
from typing import Any

from harness.findings.where import STEP

__all__ = ["axis_title", "called", "said"]

COUNTED: Mapping[str, tuple[str, str]] = {
    "stack_pile.n": ("ball", "balls"),
    "stack_tower.n": ("box", "boxes"),
    "stack_ten_minutes.n": ("box", "boxes"),
    "rest_jitter.n": ("box", "boxes"),
    "stack_overhang.n": ("brick", "bricks"),
    "stack_stirred.n": ("body", "bodies"),
    "stack_bowl.n": ("loose body", "loose bodies"),
    "joint_chain.n": ("link", "links"),
    "stand_quadruped.n": ("quadruped", "quadrupeds"),
    "system_scaling.n": ("body", "bodies"),
    "system_determinism.n": ("body", "bodies"),
    "system_level_of_detail.n": ("cam", "cams"),
    "balls": ("ball", "balls"),
    "blocks": ("block", "blocks"),
    "channels": ("channel", "channels"),
    "columns": ("column", "columns"),
    "facets": ("facet", "facets"),
    "members": ("pendulum", "pendulums"),
    "phases": ("shot", "shots"),
    "rays": ("ray", "rays"),
    "rows": ("row", "rows"),
    "starts": ("start", "starts"),
    "workers": ("process", "processes"),
    "worlds": ("world", "worlds"),
}
"""What a number counts, one and several, by the parameter, or by case and parameter where cases mean different things by it."""

MEASURED: Mapping[str, tuple[str, str]] = {
    STEP: ("time step", "s"),
    "amplitude": ("amplitude", "deg"),
    "angle": ("angle", "deg"),
    "damping": ("damping", "N m s/rad"),
    "drop": ("height of the drop", "m"),
    "friction": ("coefficient of friction", "1"),
    "margin": ("margin of friction", "1"),
    "nearest": ("tilt at the start", "rad"),
    "origin": ("distance from the origin", "m"),
    "overlap": ("overlap, of an edge", "1"),
    "push": ("push, of the weight", "1"),
    "joint_spring.rate": ("natural frequency", "rad/s"),
    "rate": ("angular rate", "rad/s"),
    "ratio": ("mass ratio", "1"),
    "scale": ("scale of lengths", "1"),
    "speed": ("speed", "m/s"),
    "spin": ("spin", "rad/s"),
    "spin_fast.speed": ("spin", "rad/s"),
    "stand_humanoid.stiffness": ("stiffness of the drives, of the described", "1"),
    "stiffness": ("stiffness", "N m/rad"),
    "friction_static_kinetic.stiffness": ("stiffness", "N/m"),
    "stack_arch.thickness": ("thickness, of the radius", "1"),
    "thickness": ("wall thickness", "m"),
    "thin": ("thinning of the rays", "1"),
    "tunnel_thin_mesh.slide": ("speed along the ground", "m/s"),
    "tunnel_thin_mesh.thickness": ("thickness of the ground", "m"),
}
"""What a number measures and its unit, 1 for none, likewise."""
PHRASED: Mapping[str, str] = {"thin": "one ray in {}"}
"""What is said of a value where name and number do not make a phrase."""


def called(case: str, parameter: str) -> str:
    """A parameter of a case as a quantity: 'number of balls', 'wall thickness'; the name in words where nobody knows better."""
    if (counted := _of(COUNTED, case, parameter)) is not None:
        return f"number of {counted[1]}"
    measured = _of(MEASURED, case, parameter)
    return measured[0] if measured is not None else parameter.replace("_", " ")


def axis_title(case: str, parameter: str, unit: str | None = None) -> str:
    """The title of an axis: 'number of balls', 'wall thickness [m]'. Args: unit: where the case's axis has one of its own."""
    measured = _of(MEASURED, case, parameter)
    known = unit if unit is not None else measured[1] if measured is not None else "1"
    return called(case, parameter) + ("" if known == "1" else f" [{known}]")


def said(case: str, parameter: str, value: Any) -> str:
    """A parameter with its value: '100 balls', 'wall thickness 0.02 m', 'seen by rays'; a word speaks for itself."""
    if isinstance(value, str):
        return value.replace("_", " ")
    if isinstance(value, bool) or not isinstance(value, int | float):
        return f"{parameter.replace('_', ' ')} {('off', 'on')[value] if isinstance(value, bool) else value}"
    number = f"{value:g}" if isinstance(value, float) else str(value)
    if parameter in PHRASED:
        return PHRASED[parameter].format(number)
    if (counted := _of(COUNTED, case, parameter)) is not None:
        return f"{number} {counted[0] if value == 1 else counted[1]}"
    measured = _of(MEASURED, case, parameter)
    unit = measured[1] if measured is not None else "1"
    return f"{called(case, parameter)} {number}" + ("" if unit == "1" else f" {unit}")


def _of(words: Mapping[str, tuple[str, str]], case: str, parameter: str) -> tuple[str, str] | None:
    own = words.get(f"{case}.{parameter}")
    # What one table says of a parameter of this case goes before what the other says of all.
    elsewhere = COUNTED.keys() | MEASURED.keys()
    return own if own is not None or f"{case}.{parameter}" in elsewhere else words.get(parameter)
