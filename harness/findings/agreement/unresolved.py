"""Drives and springs that swing faster than any step that was run: what engines agree on is what their steps make of them.

A stiffness k on an inertia I swings with w = sqrt(k/I), and its swing dies away by d/(2 I) a second. Where w h > 1 at the
finest step h no run follows it: an implicit step takes it away at once. Nobody sees the difference if it has died away by the
next sample anyway; else it is there, and no engine shows it. I is that of all behind the joint at the start, if that is stiff.
"""

import math

from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.scene import Prismatic, Revolute, Scene
from plumbline.harness.trajectory.carried_inertia import carried


def unresolved_words(agreement: Agreement) -> list[str]:
    """A sentence that names the joints whose swing no run follows, and that lasts from one sample to the next."""
    finest = [side.limit.finest for side in agreement.sides]
    steps = [rung.substep for rung in finest if rung is not None]
    runs = [rung.run for rung in finest if rung is not None and rung.run is not None]
    if agreement.scene is None or not steps:
        return []
    sample = float(runs[0].time[1] - runs[0].time[0])
    periods = {
        joint.name: 2 * math.pi / rate
        for joint in agreement.scene.joints
        if isinstance(joint, Revolute | Prismatic)
        for rate, decay in [_swing(agreement.scene, joint)]
        if rate * min(steps) > 1 and decay * sample < 1
    }
    if not periods:
        return []
    names, shortest = ", ".join(f"'{name}'" for name in periods), 1e3 * min(periods.values())
    return [
        f"No step that was run follows the swing of {names} (a period of {shortest:.2g} ms, hardly damped): what engines agree "
        "on there is what their steps make of it."
    ]


def _swing(scene: Scene, joint: Revolute | Prismatic) -> tuple[float, float]:
    """How fast the springs and drive of a joint swing [rad/s], and how fast that dies away [1/s]."""
    laws = [law for law in (joint.spring, joint.drive) if law is not None]
    inertia = carried(scene, joint)
    stiffness, damping = sum(law.stiffness for law in laws), sum(law.damping for law in laws)
    return (math.sqrt(stiffness / inertia), damping / (2 * inertia)) if inertia > 0 else (0.0, 0.0)
