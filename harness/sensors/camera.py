"""Colour camera: the pictures that the engine's own renderer draws of the present state, frame by frame.

Frames of a camera kept in memory while its scene is simulated, within a bound.

Depths are kept in double precision, in which they are judged; colours in single precision, 24 bits a channel where an eye tells
eight, and bodies as 32-bit integers. A trajectory on disk keeps these types.
"""

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import Camera
from plumbline.harness.sensors.reader import Setting
from plumbline.harness.trajectory import Floats, State

LARGEST = 2**30
"""Bytes that the frames of one camera may take."""


class Pictures:
    """Frames by channel, all frames of a channel alike in shape."""

    def __init__(self, sensor: str) -> None:
        self._sensor, self._bytes = sensor, 0
        self._times: list[float] = []
        self._frames: dict[str, list[NDArray[Any]]] = {}

    def keep(self, time: float, **channels: NDArray[Any]) -> None:
        """Add one frame, taken at `time` [s]; the same channels every time.

        Raises:
            Unsupported: the frames would take more than LARGEST bytes.
        """
        self._bytes += sum(frame.nbytes for frame in channels.values())
        if self._bytes > LARGEST:
            raise Unsupported(
                f"sensor '{self._sensor}': frame {len(self._times) + 1}",
                f"all frames so far take {self._bytes} bytes, expected at most {LARGEST}: fewer pixels, a lower rate",
            )
        self._times.append(time)
        for channel, frame in channels.items():
            self._frames.setdefault(channel, []).append(frame)

    def streams(self) -> dict[str, Floats]:
        """'<sensor>/time' (k,) and '<sensor>/<channel>' (k, ...) of all frames."""
        streams = {f"{self._sensor}/time": np.array(self._times)}
        for channel, frames in self._frames.items():
            # Streams are typed as doubles, which most are; whatever reads these two channels lets NumPy promote them.
            streams[f"{self._sensor}/{channel}"] = cast(Floats, np.array(frames))
        return streams


class CameraReader:
    """Frames '<name>/colour' (k, height, width, 3) linear [1], '<name>/depth' (k, height, width) m along the optical axis, inf
    where nothing is seen, '<name>/body' (k, height, width) place in the scene, -1 for nothing.
    """

    def __init__(self, camera: Camera, setting: Setting, start: State) -> None:  # noqa: ARG002 -- a frame needs no past
        self._camera, self._setting = camera, setting
        self._pictures = Pictures(camera.name)

    def read(self, time: float, state: State) -> None:  # noqa: ARG002 -- the renderer sees the simulation's own state
        """Draw a frame. Raises: Unsupported."""
        image = self._setting.simulation.render(self._camera)
        channels: dict[str, NDArray[Any]] = {"depth": image.depth, "body": image.body.astype(np.int32)}
        if image.colour is not None:
            channels["colour"] = image.colour.astype(np.float32)
        self._pictures.keep(time, **channels)

    def streams(self) -> dict[str, Floats]:
        """All frames so far."""
        return self._pictures.streams()
