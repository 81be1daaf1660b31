"""Colour camera: the pictures that the engine's own renderer draws of the present state, frame by frame."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.scene import Camera
from plumbline.harness.sensors.pictures import Pictures
from plumbline.harness.sensors.reader import Setting
from plumbline.harness.trajectory import Floats, State


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
