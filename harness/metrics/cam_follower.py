"""How well followers keep touch with the cams that they ride on, from poses and shapes alone."""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Body, Plane, Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import rotate_back
from harness.trajectory.touching import reach_of


def _outermost(body: Body, up_B: Floats) -> Floats:
    """The support function of a body: how far from its origin it reaches along directions (t, 3) in B, (t,) m."""
    if not body.collision or any(isinstance(placed.shape, Plane) for placed in body.collision):
        raise NotMeasurable(f"body '{body.name}' has no shape, or one without end")
    outermost: Floats = np.max(
        [up_B @ np.array(p.p_BS) + reach_of(p.shape, rotate_back(np.array(p.q_BS), up_B)) for p in body.collision], axis=0
    )
    return outermost


def _gap(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    places = {body.name: place for place, body in enumerate(scene.bodies)}
    cams = [place for place, body in enumerate(scene.bodies) if body.motion == "kinematic"]
    rails = [joint for joint in scene.joints if joint.type == "prismatic"]
    if not cams or not rails or len(actual) == 0:
        raise NotMeasurable(f"{len(cams)} cams, {len(rails)} followers on rails, {len(actual)} samples, expected some of each")
    if not actual.finite:
        return math.nan
    worst = 0.0
    for rail in rails:
        follower, up = places[rail.child], np.array(rail.axis_W)
        # Each rides on the cam that its rail leads to.
        off = [np.linalg.norm(np.cross(np.array(scene.bodies[cam].p_WB) - rail.anchor_W, up)) for cam in cams]
        cam = cams[int(np.argmin(off))]
        ways = [
            rotate_back(actual.q_WB[:, place], np.broadcast_to(way, (len(actual), 3)))
            for place, way in ((cam, up), (follower, -up))
        ]
        apart = (actual.p_WB[:, follower] - actual.p_WB[:, cam]) @ up
        gap = apart - _outermost(scene.bodies[cam], ways[0]) - _outermost(scene.bodies[follower], ways[1])
        worst = max(worst, float(np.max(np.abs(gap))))
    return worst


CAM_FOLLOWER_GAP = Metric(
    name="cam_follower_gap",
    unit="m",
    source="definition: greatest distance, or depth, between the highest point of a cam and the lowest of the follower on it, "
    "along its rail",
    measure=_gap,
)

METRIC = CAM_FOLLOWER_GAP
