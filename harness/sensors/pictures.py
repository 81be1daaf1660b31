"""Frames of a camera kept in memory while its scene is simulated, within a bound.

Depths are kept in double precision, in which they are judged; colours in single precision, 24 bits a channel where an eye tells
eight, and bodies as 32-bit integers. A trajectory on disk keeps these types.
"""

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.adapter import Unsupported
from plumbline.harness.trajectory import Floats

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
