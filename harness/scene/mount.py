"""What all sensors state: the body that carries one, where it sits on it, and how often it is read."""

from pydantic.dataclasses import dataclass

from plumbline.harness.scene.values import FROZEN, Name, Positive, Quaternion, Vector3


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Mount:
    """A sensor whose frame S sits on a body at p_BS [m], turned by q_BS, read `rate` [Hz] times a second."""

    name: Name
    body: Name
    rate: Positive
    p_BS: Vector3 = (0.0, 0.0, 0.0)
    q_BS: Quaternion = (1.0, 0.0, 0.0, 0.0)
