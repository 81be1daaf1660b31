"""How well followers keep touch with the cams that they ride on, from poses and shapes alone."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Body, Plane
from plumbline.harness.scene.support import support
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import rotate_back


def _outermost(body: Body, up_B: Floats) -> Floats:
    """The support function of a body: how far from its origin it reaches along directions (t, 3) in B, (t,) m."""
    if not body.collision or any(isinstance(placed.shape, Plane) for placed in body.collision):
        raise NotMeasurable(f"body '{body.name}' has no shape, or one without end")
    outermost: Floats = np.max(
        [up_B @ np.array(p.p_BS) + support(p.shape, rotate_back(np.array(p.q_BS), up_B)) for p in body.collision], axis=0
    )
    return outermost


@metric("m")
def cam_follower_gap(run: Run) -> float:
    """definition: greatest distance, or depth, between the highest point of a cam and the lowest of the follower on it, along
    its rail"""
    places = {body.name: place for place, body in enumerate(run.scene.bodies)}
    cams = [place for place, body in enumerate(run.scene.bodies) if body.motion == "kinematic"]
    rails = [joint for joint in run.scene.joints if joint.type == "prismatic"]
    if not cams or not rails or len(run.actual) == 0:
        raise NotMeasurable(
            f"{len(cams)} cams, {len(rails)} followers on rails, {len(run.actual)} samples, expected some of each"
        )
    worst = 0.0
    for rail in rails:
        follower, up = places[rail.child], np.array(rail.axis_W)
        # Each rides on the cam that its rail leads to.
        off = [np.linalg.norm(np.cross(np.array(run.scene.bodies[cam].p_WB) - rail.anchor_W, up)) for cam in cams]
        cam = cams[int(np.argmin(off))]
        ways = [
            rotate_back(run.actual.q_WB[:, place], np.broadcast_to(way, (len(run.actual), 3)))
            for place, way in ((cam, up), (follower, -up))
        ]
        apart = (run.actual.p_WB[:, follower] - run.actual.p_WB[:, cam]) @ up
        gap = apart - _outermost(run.scene.bodies[cam], ways[0]) - _outermost(run.scene.bodies[follower], ways[1])
        worst = max(worst, float(np.max(np.abs(gap))))
    return worst
