"""The drives of two robots' joints, number by number, with the force that each difference is worth at the states drawn."""

from collections.abc import Sequence

import numpy as np

from plumbline.harness.scene.importers.robot import Servo
from plumbline.harness.scene.parity.difference import Difference, Quantity
from plumbline.harness.scene.parity.facts import JointFacts
from plumbline.harness.scene.parity.motion import Configuration


def drive_rows(
    a: JointFacts, b: JointFacts, index: int, rate: int, states: Sequence[Configuration], extent: float, tolerance: float
) -> list[Difference]:
    """Rows of one joint's drives. Args: index, rate: of the joint in the states. extent [m]: that lengths are held against."""
    mine, other = a.drive or Servo(), b.drive or Servo()
    slides = a.kind == "prismatic"
    own, force = ("m", "N") if slides else ("rad", "N m")
    positions = np.array([state.q[index] for state in states])
    rates = np.array([state.rates[rate] for state in states])
    held, swift = float(np.abs(mine.target - positions).max()), float(np.abs(mine.target_velocity - rates).max())
    # Each number with what a change of it is times, to be a force on the joint.
    numbers: tuple[tuple[Quantity, str, str, float], ...] = (
        ("drive stiffness", "stiffness", f"{force}/{own}", held),
        ("drive damping", "damping", f"{force} s/{own}", swift),
        ("drive target", "target", own, max(mine.stiffness, other.stiffness)),
        ("drive rate", "target_velocity", f"{own}/s", max(mine.damping, other.damping)),
        ("drive force", "feedforward", force, 1.0),
        ("drive push", "push", force, 1.0),
    )
    rows = []
    for quantity, field, unit, times in numbers:
        x, y = getattr(mine, field), getattr(other, field)
        if x == y or (quantity in ("drive target", "drive rate") and times == 0):
            continue
        size = abs(x - y)
        scale = max(abs(x), abs(y))
        if quantity == "drive target":
            scale = extent if slides else 1.0
        if size / scale > tolerance:
            rows.append(_row(quantity, a.name, x, y, unit, tolerance, size, size / scale, size * times, force))
    x, y = mine.limit, other.limit
    if x != y:
        size = None if x is None or y is None else abs(x - y)
        relative = None if size is None or x is None or y is None else size / max(x, y)
        if relative is None or relative > tolerance:
            rows.append(_row("drive limit", a.name, x, y, force, tolerance, size, relative, size, force))
    return rows


def _row(quantity: Quantity, name: str, x: float | None, y: float | None, unit: str, tolerance: float, size: float | None,
         relative: float | None, torque: float | None, force: str) -> Difference:  # fmt: skip
    words = "one is bounded, the other is not" if torque is None else f"worth up to {torque:.3g} {force} at the states drawn"
    return Difference(
        quantity=quantity, element=name, value_A=x, value_B=y, unit=unit, tolerance=tolerance, absolute=size,
        relative=relative, torque=torque, torque_unit="" if torque is None else force, words=words,
    )  # fmt: skip
