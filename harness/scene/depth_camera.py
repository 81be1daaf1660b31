"""A camera that measures depth, by one of three principles, and its noise."""

from typing import Literal

from pydantic.dataclasses import dataclass

from harness.scene.camera import Pixels
from harness.scene.values import FROZEN, Name, NonNegative, Positive, Probability, Quaternion, Vector3

__all__ = ["DepthCamera", "DepthNoise"]


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class DepthNoise:
    """Noise of a depth camera; sigma [m] + sigma_square [1/m] z^2 at depth z, and the share of missing pixels."""

    sigma: NonNegative = 0.0
    sigma_square: NonNegative = 0.0
    missing: Probability = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class DepthCamera:
    """A pinhole camera that measures z-depth [m] between `near` and `far`, by one of three principles."""

    name: Name
    body: Name
    rate: Positive
    p_BS: Vector3 = (0.0, 0.0, 0.0)
    q_BS: Quaternion = (1.0, 0.0, 0.0, 0.0)
    width: Pixels = 640
    height: Pixels = 480
    focal_x: Positive = 500.0
    focal_y: Positive = 500.0
    centre_x: float = 320.0
    centre_y: float = 240.0
    near: Positive = 0.1
    far: Positive = 10.0
    principle: Literal["structured_light", "time_of_flight", "stereo"] = "stereo"
    noise: DepthNoise | None = None
    type: Literal["depth_camera"] = "depth_camera"

    def __post_init__(self) -> None:
        if self.far <= self.near:
            raise ValueError(f"sensor '{self.name}': far {self.far} m does not lie beyond near {self.near} m")
