"""The passive motion of a robot of facts, integrated by SciPy's DOP853: what its dynamics are held against."""

import numpy as np
from scipy.integrate import solve_ivp

from plumbline.harness.scene.importers.poses import Array, Pose
from plumbline.harness.scene.parity.canonical import Canonical
from plumbline.harness.scene.parity.motion import Configuration, first_rates, passive

RTOL = 1e-9


def _hat(v: Array) -> Array:
    return np.cross(np.eye(3), v)


def after(robot: Canonical, start: Configuration, gravity: Array, duration: float = 1.0) -> Configuration:
    """Where the robot is after so long [s]."""
    turning = [k for k, joint in enumerate(robot.joints) if joint.kind in ("ball", "free")]
    count, starts = len(robot.joints), first_rates(robot)

    def unpacked(y: Array) -> Configuration:
        turned = {}
        for number, k in enumerate(turning):
            raw = y[count + 12 * number : count + 12 * number + 12]
            R, o = raw[:9].reshape(3, 3), raw[9:]
            turned[k] = Pose(R, o - R @ robot.joints[k].anchor)
        return Configuration(y[:count], turned, y[count + 12 * len(turning) :])

    def slope(_time: float, y: Array) -> Array:
        at = unpacked(y)
        M, forces = passive(robot, at, gravity)
        dq, more = np.zeros(count), []
        for k, joint in enumerate(robot.joints):
            rate = at.rates[starts[k] : starts[k + 1]]
            if k in at.turned:
                w, v = rate[:3], rate[3:] if joint.kind == "free" else np.zeros(3)
                more += [(_hat(w) @ at.turned[k].R).ravel(), v]
            else:
                dq[k] = rate[0]
        return np.concatenate([dq, *more, np.linalg.solve(M, -forces)])

    y0 = [start.q]
    for k in turning:
        X = start.turned.get(k, Pose(np.eye(3), np.zeros(3)))
        y0 += [X.R.ravel(), X.of(robot.joints[k].anchor)]
    end = solve_ivp(slope, (0.0, duration), np.concatenate([*y0, start.rates]), method="DOP853", rtol=RTOL, atol=RTOL)
    assert end.success
    return unpacked(end.y[:, -1])
