"""What MuJoCo's compiler makes of a URDF, in MuJoCo's own words."""

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
pytestmark = pytest.mark.mujoco


def inertia_of(mass: float) -> float:
    """About a hinge, of a link with .6 kg m2 and of another fixed to it at the hinge, of this mass and .3 kg m2."""
    moments = '<inertia ixx="{0}" ixy="0" ixz="0" iyy="{0}" iyz="0" izz="{0}"/>'
    model = mujoco.MjModel.from_xml_string(
        f'<robot name="p"><link name="b"/><link name="l"><inertial><mass value="2"/>{moments.format(0.6)}</inertial></link>'
        f'<link name="t"><inertial><mass value="{mass}"/>{moments.format(0.3)}</inertial></link>'
        '<joint name="j" type="continuous"><parent link="b"/><child link="l"/><axis xyz="0 1 0"/></joint>'
        '<joint name="f" type="fixed"><parent link="l"/><child link="t"/></joint></robot>'
    )
    data = mujoco.MjData(model)
    data.qvel[:] = 1.0
    mujoco.mj_forward(model, data)
    momentum = np.zeros(1)
    mujoco.mj_mulM(model, data, momentum, data.qvel)
    return float(momentum[0])


def test_the_tensor_of_a_link_without_mass_is_left_out_where_it_is_fused() -> None:
    """A link that is fixed to another adds its tensor, of whatever small mass, but with no mass at all it does not."""
    assert inertia_of(1e-9) == pytest.approx(0.9)
    assert inertia_of(0.0) == pytest.approx(0.6)


def test_a_tensor_that_breaks_the_triangle_inequality_is_refused() -> None:
    """Of moments .1, .1 and .3, with the name of the link."""
    with pytest.raises(ValueError, match="inertia must satisfy"):
        mujoco.MjModel.from_xml_string(
            '<robot name="p"><link name="b"/><link name="l"><inertial><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" '
            'iyy="0.1" iyz="0" izz="0.3"/></inertial></link><joint name="j" type="continuous"><parent link="b"/>'
            '<child link="l"/><axis xyz="0 1 0"/></joint></robot>'
        )
