"""Which of MuJoCo's integrators carries a stiff spring, told in its own words.

Sources: MuJoCo, "Computation", numerical integration (the discrete integrator alone is implicit in position; the others are
stable up to w h = 2); change log of 3.13.0, which added it.
"""

import math
from typing import Any

import pytest

from tests.vendor.mujoco_world import blew_up, make_spec, mujoco

pytestmark = pytest.mark.mujoco

DT, STRETCH = 1 / 240, 0.3


def stretches(integrator: str, rate: float, ratio: float, servo: bool = False) -> list[float]:
    """How far 1 kg on a rail is from the rest of its spring or position servo [m] after each step of a second, let go at .3 m.

    Args: rate: undamped [rad/s]; ratio: of damping over critical damping. The list ends with inf where MuJoCo says it blew up.
    """
    spec: Any = make_spec(DT, gravity=0.0, integrator=getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}"))
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    body = spec.worldbody.add_body()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(0.1, 0.0, 0.0), mass=1.0)
    rail = body.add_joint(name="rail", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=(1.0, 0.0, 0.0))
    stiffness, damping = rate**2, 2 * ratio * rate
    if servo:
        made = spec.add_actuator(name="servo", target="rail", trntype=mujoco.mjtTrn.mjTRN_JOINT)
        made.gaintype, made.gainprm = mujoco.mjtGain.mjGAIN_FIXED, [stiffness, *([0.0] * 9)]
        made.biastype, made.biasprm = mujoco.mjtBias.mjBIAS_AFFINE, [0.0, -stiffness, -damping, *([0.0] * 7)]
    else:
        rail.stiffness, rail.damping = [stiffness, 0, 0], [damping, 0, 0]
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[0] = STRETCH
    found: list[float] = []
    for _ in range(round(1 / DT)):
        mujoco.mj_step(model, data)
        if blew_up(data):
            return [*found, math.inf]
        found.append(abs(float(data.qpos[0])))
    return found


@pytest.mark.parametrize("servo", [False, True], ids=["spring", "servo"])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 2.0])
def test_the_discrete_integrator_carries_a_spring_of_60000_rad_s_at_1_240_s(ratio: float, servo: bool) -> None:
    # Implicit in position and velocity: each step leaves (1 + 2 ratio w h)/(1 + 2 ratio w h + (w h)^2) of the stretch at most.
    z = 6e4 * DT
    first = STRETCH * (1 + 2 * ratio * z) / (1 + 2 * ratio * z + z * z)
    assert max(stretches("DISCRETE", 6e4, ratio, servo)) == pytest.approx(first)


@pytest.mark.parametrize("integrator", ["EULER", "RK4", "IMPLICIT", "IMPLICITFAST"])
def test_no_other_integrator_carries_a_spring_of_60000_rad_s_at_1_240_s(integrator: str) -> None:
    for servo in (False, True):
        assert max(stretches(integrator, 6e4, 0.1, servo)) == math.inf


def test_without_damping_the_velocity_implicit_rule_ends_at_w_h_of_2_and_the_discrete_one_nowhere() -> None:
    for z in (1.0, 1.9, 2.1, 20.0):
        far = max(stretches("IMPLICITFAST", z / DT, 0.0))
        # Below the limit the amplitude stays within 1/sqrt(1 - (w h/2)^2) of the stretch; beyond it grows in each step.
        assert far <= STRETCH / math.sqrt(1 - z * z / 4) * (1 + 1e-9) if z < 2 else far > 1e10
        assert max(stretches("DISCRETE", z / DT, 0.0)) <= STRETCH


def test_below_the_limit_the_discrete_integrator_fades_what_the_velocity_implicit_one_keeps() -> None:
    kept, faded = (stretches(integrator, 1 / DT, 0.0)[-24:] for integrator in ("IMPLICITFAST", "DISCRETE"))
    # At w h = 1 the one turns by 60 degrees a step for ever; of the other 1/sqrt(2) a step is left, 2^-108 after 216 steps.
    assert max(kept) == pytest.approx(STRETCH, rel=0.2)
    assert max(faded) < 1e-12
