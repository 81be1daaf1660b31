"""The truth of a case in whose scene nothing moves: what its range finders and cameras see, in closed form."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from plumbline.harness.scene import Camera, DepthCamera, Lidar, Scene
from plumbline.harness.sensors.true_frames import stamps_up_to, true_frames
from plumbline.harness.sensors.true_scans import true_scans
from plumbline.harness.trajectory import Floats, Trajectory


def seen(scene: Callable[[Any], Scene]) -> Callable[[Floats, Any], Trajectory]:
    """The truth of a case: all bodies at rest, with the streams of the scene's cameras and range finders."""

    def expected(time: Floats, parameters: Any) -> Trajectory:
        stage = scene(parameters)
        truth, streams = Trajectory.at_rest(stage, time), dict[str, Floats]()
        for sensor in stage.sensors:
            if isinstance(sensor, Camera | DepthCamera):
                stamps = stamps_up_to(float(truth.time[-1]), sensor.rate) if len(truth) else truth.time
                streams |= true_frames(stage, sensor, stamps)
            elif isinstance(sensor, Lidar) and len(truth):
                streams |= true_scans(stage, sensor, float(truth.time[-1]))
        return replace(truth, streams=streams)

    return expected
