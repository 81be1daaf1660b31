"""An inertial measurement unit: accelerometer and gyroscope, with their noise in the units of data sheets."""

from typing import Literal

from pydantic.dataclasses import dataclass

from plumbline.harness.scene.mount import Mount
from plumbline.harness.scene.values import FROZEN, Finite, NonNegative, Positive, Vector3


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class AxisNoise:
    """Errors of one inertial channel, u being rad/s (gyroscope) or m/s2 (accelerometer), in the order in which they arise.

    Data sheets use other units: docs/method.md says how to convert them.

    Terms:
        misalignment [rad]: rotation vector that turns the channel's triad against S. scale_error [1]: the signal is multiplied
        by 1 + scale_error.
        density [u/sqrt(Hz)]: white noise. bias [u]: constant. instability [u]: the flat floor of the Allan deviation.
        instability_time [s]: correlation time of the process that makes that floor.
        random_walk [u/s/sqrt(Hz)]: rate of the drifting bias.
        saturation [u]: greatest size of what can be read, None for no bound. quantisation [u]: distance of neighbouring
        readings, 0 for none.
    Source: IEEE Std 952-1997, annex C; IEEE Std 1293-2018 (accelerometers: scale factor, misalignment).
    """

    misalignment: Vector3 = (0.0, 0.0, 0.0)
    scale_error: Finite = 0.0

    density: NonNegative = 0.0
    bias: Finite = 0.0
    instability: NonNegative = 0.0
    instability_time: Positive = 100.0
    random_walk: NonNegative = 0.0
    saturation: Positive | None = None
    quantisation: NonNegative = 0.0

    def __post_init__(self) -> None:
        if self.saturation is not None and self.saturation < self.quantisation:
            raise ValueError(
                f"inertial noise: saturation {self.saturation:g} lies below quantisation {self.quantisation:g}, which leaves "
                "no reading but 0; expected at least one step of the quantisation"
            )


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class ImuNoise:
    """Noise of an inertial measurement unit: the same law on each of three axes, drawn independently."""

    accelerometer: AxisNoise = AxisNoise()
    gyroscope: AxisNoise = AxisNoise()


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Imu(Mount):
    """Accelerometer (specific force) and gyroscope at p_BS [m], turned by q_BS, read `rate` [Hz] times a second.

    Terms:
        latency [s]: age of a signal when it is read; a reading stamped t tells of t - latency.
        reading: 'native' takes the engine's own sensor where it has one, 'states' differences the velocities in any engine.
    """

    latency: NonNegative = 0.0
    reading: Literal["native", "states"] = "native"
    noise: ImuNoise | None = None
    type: Literal["imu"] = "imu"
