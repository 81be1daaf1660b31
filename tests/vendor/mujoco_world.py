"""Worlds of MuJoCo of one's own, for scripts in the vendor's words."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

G = 9.81


def load(world: str, dt: float, gravity: float = G, option: str = "", more: str = "") -> tuple[Any, Any]:
    """A model of an MJCF world, and its data. Args: option: attributes of <option>. more: elements beside the world."""
    head = f'<option timestep="{dt!r}" gravity="0 0 {-gravity}" {option}/>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{head}{more}<worldbody>{world}</worldbody></mujoco>")
    return model, mujoco.MjData(model)


def make_spec(dt: float, gravity: float = G, elliptic: bool = True, **option: Any) -> Any:
    """An empty model. Args: option: fields of its mjOption."""
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = dt, (0.0, 0.0, -gravity)
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC if elliptic else mujoco.mjtCone.mjCONE_PYRAMIDAL
    for name, value in option.items():
        setattr(spec.option, name, value)
    return spec


def on_plane(spec: Any, place: tuple[float, float, float], settle: Callable[[Any], None], **geom: Any) -> tuple[Any, Any]:
    """A free body of 1 kg on the plane z = 0, compiled. Args: settle: sets the law of the pair. geom: of the body's shape."""
    body = spec.worldbody.add_body(pos=place)
    body.add_freejoint()
    body.add_geom(name="body", mass=1.0, **geom)
    spec.worldbody.add_geom(name="plane", type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0.0, 0.0, 1.0))
    settle(spec.add_pair(geomname1="plane", geomname2="body"))
    model = spec.compile()
    return model, mujoco.MjData(model)


def contact_force(model: Any, data: Any) -> Any:
    """What all contacts together push the second body of each pair with, in the world (3,) [N]."""
    total, one = np.zeros(3), np.zeros(6)
    for place in range(data.ncon):
        mujoco.mj_contactForce(model, data, place, one)
        total += one[:3] @ data.contact.frame[place].reshape(3, 3)
    return total


def blew_up(data: Any) -> bool:
    """Has MuJoCo met something that is not finite? Unless it is told not to, it begins anew then."""
    kinds = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
    return any(data.warning[kind].number for kind in kinds)
