"""How deep a light cube sinks under a heavy one in MuJoCo, told in its own words: by its softness, which is a choice.

At constant impedance d a contact of time constant tc and damping ratio z gives way by (1 - d) a tc^2 z^2, where a is what its
load accelerates its bodies by. Under a cube M times as heavy a light one is pressed by (1 + M) times its weight from both
sides, at four corners that each bear a quarter.

Source: MuJoCo, "Modeling", solver parameters (penetration at rest); "Computation", numerical integration: under the discrete
integrator without refsafe a contact is stable at any time constant, and as that goes to 0 it is rigid.
"""

from typing import Any

import pytest

from tests.vendor.mujoco_world import G, make_spec, mujoco

pytestmark = pytest.mark.mujoco

HALF = 0.1


def sunk(dt: float, ratio: float, solref: tuple[float, float], impedance: float, rigid: bool = False) -> tuple[float, float]:
    """By how much the upper of two cubes stands too low after 2 s [m], and its speed then [m/s].

    Args: ratio: of the upper cube's mass to the lower one's. rigid: the discrete integrator, every solref honoured.
    """
    spec: Any = make_spec(dt, tolerance=1e-12)
    if rigid:
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
        spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
    law = {"solref": solref, "solimp": (impedance, impedance, 0.001, 0.5, 2.0), "priority": 1}
    for mass, height in ((1.0, HALF), (ratio, 3 * HALF)):
        body = spec.worldbody.add_body(pos=(0.0, 0.0, height))
        body.add_freejoint()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=(HALF, HALF, HALF), mass=mass, **law)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0.0, 0.0, 1.0))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, round(2 / dt))
    return 3 * HALF - float(data.qpos[9]), float(abs(data.qvel[6:12]).max())


@pytest.mark.parametrize(("ratio", "impedance"), [(1.0, 0.999), (10.0, 0.999), (100.0, 0.999), (1000.0, 0.9999)])
def test_a_soft_contact_gives_way_by_its_time_constant_squared_whatever_the_step(ratio: float, impedance: float) -> None:
    for dt in (1 / 240, 1 / 960):
        depth, speed = sunk(dt, ratio, (0.02, 1.0), impedance)
        assert depth == pytest.approx(2 * (1 - impedance) * (1 + ratio) * G / 4 * 0.02**2, rel=1e-6)
        assert speed < 1e-6


@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6])
def test_rigid_contacts_of_the_discrete_integrator_bear_a_million_times_as_much(ratio: float) -> None:
    dt = 1 / 960
    depth, speed = sunk(dt, ratio, (0.05 * dt, 1.0), 0.9999, rigid=True)
    # What gives way is gone within a step: a step is the time constant, and no corner bears more than all of the load.
    assert depth < 2 * (1 - 0.9999) * (1 + ratio) * G * dt**2
    assert speed < 1e-6
