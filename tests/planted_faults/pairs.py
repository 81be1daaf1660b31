"""Faults that show where two things stand together, each of which is right alone."""

from dataclasses import replace

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.adapter.rotations import conjugate
from plumbline.harness.scene import Body, Distance, Joint, Limits, Prismatic, Revolute, Scene, multiply
from plumbline.harness.trajectory import Floats, State
from tests.planted_faults.fault import fault
from tests.planted_faults.planting import Wrapped

_HINGE = Feature.REVOLUTE


@fault("pair_wrench_and_hinge", "pair_wrench_and_start_pose", needs=_HINGE | Feature.WRENCH)
class push_at_the_anchor(Wrapped):
    """a push on a body that hangs on a joint acts at the joint's anchor"""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        tau = np.array(tau_B_W)
        for place, body in enumerate(self.scene.bodies):
            for joint in self.scene.joints:
                if joint.child == body.name and isinstance(joint, Revolute):
                    tau[place] += np.cross(np.subtract(joint.anchor_W, body.p_WB), f_B_W[place])
        self.inner.wrench(f_B_W, tau)


_SEVERAL = Feature.MASSLESS | Feature.REVOLUTE | Feature.PRISMATIC


@fault("several_joints_move_one_body", "pair_hinge_and_second_joint_of_a_body", needs=_SEVERAL)
class between_joints_all_stands(Wrapped):
    """bodies without mass are told to stand where they began"""

    def state(self, out: State) -> None:
        self.inner.state(out)
        for place, body in enumerate(self.scene.bodies):
            if body.massless:
                out.p_WB[place], out.q_WB[place] = body.p_WB, body.q_WB


@fault("several_joints_move_one_body", "pair_slide_and_second_joint_of_a_body", needs=_SEVERAL)
def mass_between_joints(body: Body) -> Body:
    """bodies without mass weigh a fifth of a kilogramme"""
    return replace(body, mass=0.2, inertia=np.diag((1e-3, 1e-3, 1e-3)).tolist()) if body.massless else body


@fault("pair_wrench_and_distance_spring", needs=Feature.DISTANCE_SPRING | Feature.WRENCH)
class wrench_lost_beside_a_spring(Wrapped):
    """forces handed in are forgotten in scenes with a spring between two bodies"""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        sprung = any(isinstance(joint, Distance) for joint in self.scene.joints)
        self.inner.wrench(f_B_W * (not sprung), tau_B_W * (not sprung))


@fault("pair_slide_and_limit", "pair_slide_and_one_sided_limit", needs=Feature.PRISMATIC | Feature.LIMITS)
def slide_limits_counted_from_zero(joint: Joint) -> Joint:
    """the limits of slides count from where they start"""
    if not isinstance(joint, Prismatic) or joint.limits is None:
        return joint
    ends = [None if end is None else end + joint.position for end in (joint.limits.lower, joint.limits.upper)]
    return replace(joint, limits=Limits(lower=ends[0], upper=ends[1]))


@fault("pair_parent_turned_and_child_turned", needs=_HINGE)
def rotations_in_the_wrong_order(scene: Scene) -> Scene:
    """the child's rotation in its parent is multiplied in the wrong order"""
    turns = {body.name: body.q_WB for body in scene.bodies}
    over = {joint.child: turns[joint.parent] for joint in scene.joints if joint.parent in turns}

    def turned(body: Body) -> Body:
        q_WP = over.get(body.name)
        return body if q_WP is None else replace(body, q_WB=multiply(q_WP, multiply(body.q_WB, conjugate(q_WP))))

    return replace(scene, bodies=tuple(turned(body) for body in scene.bodies))


@fault("pair_hinge_and_uneven_steps", "pair_drive_and_uneven_steps", needs=_HINGE | Feature.STEP_LENGTHS | Feature.DRIVES)
class uneven_steps_forget_sub_steps(Wrapped):
    """each sub-step of an uneven step is as long as the step"""

    def retime(self, dt: float) -> None:
        self.inner.retime(dt * (self.asked.substeps or 1))  # type: ignore[attr-defined]  # what an engine may offer


@fault("pair_wrench_and_hinge", "pair_hinge_and_child_turned", "pair_slide_and_drive", needs=_HINGE | Feature.WRENCH)
class velocities_half_a_step_late(Wrapped):
    """the velocities of joined bodies are told as they were half a step ago"""

    def start(self) -> None:
        self._before = self.now()

    def step(self, count: int = 1) -> None:
        if count > 1:
            self.inner.step(count - 1)
        if count > 0:
            self._before = self.now()
            self.inner.step()

    def state(self, out: State) -> None:
        self.inner.state(out)
        if self.scene.joints:
            out.v_WB[:], out.w_WB[:] = (out.v_WB + self._before.v_WB) / 2, (out.w_WB + self._before.w_WB) / 2
