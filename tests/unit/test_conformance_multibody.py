"""The motion that pairs are judged by, against Pinocchio in joint coordinates, and against what every motion keeps."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from plumbline.harness.conformance.engine import ROUNDING
from plumbline.harness.conformance.multibody import Multibody, matrix
from plumbline.harness.conformance.pairs import DURATION, NOUNS, RUNGE_KUTTA, STEP, WRENCHES, Pair, PairPlan, all_pairs, task
from plumbline.harness.scene import WORLD, Ball, Body, Distance, Limits, Prismatic, Revolute, Scene

PAIRS = [pair for _, pairs in all_pairs() for pair in pairs if not any(noun.name == "prescribed body" for noun in pair.nouns)]


UP = (0.0, 0.0, 1.0)


def _id(pair: Pair) -> str:
    return f"{pair.nouns[0].name}-{pair.nouns[1].name}{'-hung' if pair.hung else ''}"


def _inertia(body: Body, about: np.ndarray) -> pin.Inertia:
    R = matrix(np.array(body.q_WB))
    return pin.Inertia(body.mass, np.array(body.p_WB) - about, R @ np.array(body.inertia) @ R.T)


def by_pinocchio(plan: PairPlan, scene: Scene) -> np.ndarray:
    """v' and w' of all bodies (n, 6) at time 0, by the articulated-body algorithm; all joint frames are parallel to W there."""
    model = pin.Model()
    model.gravity.linear = np.array(scene.gravity)
    joints = {joint.child: joint for joint in scene.joints if not isinstance(joint, Distance)}
    origins, numbers = {WORLD: np.zeros(3)}, {WORLD: 0}
    rates, efforts = np.zeros(0), np.zeros(0)

    def depth(name: str) -> int:
        return 0 if name not in joints else 1 + depth(joints[name].parent)

    # A body without mass may stand behind the one that it carries.
    for body in sorted(scene.bodies, key=lambda body: depth(body.name)):
        joint = joints.get(body.name)
        v, w = np.array(body.v_WB), np.array(body.w_WB)
        if joint is None:
            parent, kind, origin, rate, effort = WORLD, pin.JointModelFreeFlyer(), np.array(body.p_WB), [*v, *w], np.zeros(6)
        else:
            parent, origin = joint.parent, np.array(joint.anchor_W)
            upper = next((b for b in scene.bodies if b.name == parent), None)
            v_P, w_P, p_P = (np.zeros(3),) * 3 if upper is None else map(np.array, (upper.v_WB, upper.w_WB, upper.p_WB))
            if isinstance(joint, Ball):
                kind, rate, effort = pin.JointModelSpherical(), list(w - w_P), np.zeros(3)
            else:
                axis = np.array(joint.axis_W)
                slides = isinstance(joint, Prismatic)
                speed = axis @ (v - v_P - np.cross(w_P, body.p_WB - p_P)) if slides else axis @ (w - w_P)
                kind = (pin.JointModelPrismaticUnaligned if slides else pin.JointModelRevoluteUnaligned)(axis)
                drive, dry = joint.drive, joint.friction_loss or 0.0
                push = -dry * np.sign(speed)
                if drive is not None:
                    push += drive.stiffness * (drive.target - joint.position) - drive.damping * speed
                rate, effort = [speed], np.array([push])
        placement = pin.SE3(np.eye(3), origin - origins[parent])
        numbers[body.name] = model.addJoint(numbers[parent], kind, placement, body.name)
        origins[body.name] = origin
        model.appendBodyToJoint(numbers[body.name], _inertia(body, origin), pin.SE3.Identity())
        at = pin.SE3(np.eye(3), np.array(body.p_WB) - origin)
        model.addFrame(pin.Frame(f"{body.name} centre", numbers[body.name], at, pin.FrameType.OP_FRAME))
        rates, efforts = np.concatenate((rates, rate)), np.concatenate((efforts, effort))
    external = {body.name: np.zeros(6) for body in scene.bodies}

    def push_at(name: str, point: np.ndarray, force: np.ndarray, torque: np.ndarray) -> None:
        if name != WORLD:
            external[name] += np.concatenate((force, np.cross(point - origins[name], force) + torque))

    if plan.wrenches:
        for body in scene.bodies:
            if body.name in WRENCHES:
                push_at(body.name, np.array(body.p_WB), *(np.array(part) for part in WRENCHES[body.name]))
    for line in (joint for joint in scene.joints if isinstance(joint, Distance)):
        ends, speeds = [np.array(line.anchor_W), np.array(line.child_anchor_W)], []
        for name, point in zip((line.parent, line.child), ends, strict=True):
            held = next((b for b in scene.bodies if b.name == name), None)
            speeds.append(np.zeros(3) if held is None else held.v_WB + np.cross(held.w_WB, point - held.p_WB))
        apart, spring = ends[1] - ends[0], line.spring
        assert spring is not None
        length = np.linalg.norm(apart)
        along = apart / length
        pull = (spring.stiffness * (length - spring.rest) + spring.damping * along @ (speeds[1] - speeds[0])) * along
        push_at(line.parent, ends[0], pull, np.zeros(3))
        push_at(line.child, ends[1], -pull, np.zeros(3))
    data, q = model.createData(), pin.neutral(model)
    forces = pin.StdVec_Force()
    for number in range(model.njoints):
        forces.append(pin.Force(external.get(model.names[number], np.zeros(6))))
    a = pin.aba(model, data, q, rates, efforts, forces)
    pin.forwardKinematics(model, data, q, rates, a)
    pin.updateFramePlacements(model, data)
    frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    return np.array(
        [
            pin.getFrameClassicalAcceleration(model, data, model.getFrameId(f"{b.name} centre"), frame).vector
            for b in scene.bodies
        ]
    )


@pytest.mark.parametrize("pair", PAIRS, ids=_id)
def test_a_pair_starts_with_pinocchios_accelerations(pair: Pair) -> None:
    asked = task(pair)
    wrenches = {name: w for name, w in WRENCHES.items() if asked.plan.wrenches and name in asked.plan.bodies}
    body = Multibody(asked.scene, wrenches)
    got = body.accelerations(body.start())[:-1]
    np.testing.assert_allclose(got, by_pinocchio(asked.plan, asked.scene), rtol=0, atol=1e-9)


@pytest.mark.parametrize("pair", [pair for _, pairs in all_pairs() for pair in pairs], ids=_id)
def test_four_steps_are_exact_beside_what_engines_are_allowed(pair: Pair) -> None:
    """Off by less than a thousandth of what a step of first order is allowed on the same motion, or by rounding's allowance."""
    asked = task(pair)
    wrenches = {name: w for name, w in WRENCHES.items() if asked.plan.wrenches and name in asked.plan.bodies}
    fine = Multibody(asked.scene, wrenches).motion(DURATION, 8 * RUNGE_KUTTA)
    exact = asked.expected
    allowed = {"p_WB": exact.gained, "q_WB": exact.turned, "v_WB": exact.varied, "w_WB": exact.swung}
    for name, growth in allowed.items():
        assert np.abs(getattr(fine, name) - getattr(exact, name)).max() < 1e-3 * STEP * growth + ROUNDING


def _chain() -> Scene:
    """A hinge below a ball below a body that flies; nothing pushes but gravity."""
    by_name = {noun.name: noun for noun in NOUNS}
    return task(Pair((by_name["hinge"], by_name["ball"]), hung=False)).scene


def test_what_falls_freely_keeps_energy_angular_momentum_and_its_joints() -> None:
    """Over .4 s, more than a turn of the last body; joints drift by what rows that hold accelerations let through."""
    scene = _chain()
    body = Multibody(scene)
    end = body.motion(0.4, 200)

    def kept(p: np.ndarray, q: np.ndarray, v: np.ndarray, w: np.ndarray) -> tuple[float, np.ndarray]:
        energy, momentum, centre, total = 0.0, np.zeros(3), np.zeros(3), sum(b.mass for b in scene.bodies)
        for k, b in enumerate(scene.bodies):
            inertia = matrix(q[k]) @ np.array(b.inertia) @ matrix(q[k]).T
            energy += b.mass * (v[k] @ v[k] / 2 - np.array(scene.gravity) @ p[k]) + w[k] @ inertia @ w[k] / 2
            momentum = momentum + inertia @ w[k] + b.mass * np.cross(p[k], v[k])
            centre = centre + b.mass * p[k] / total
        speed = sum(b.mass * v[k] for k, b in enumerate(scene.bodies)) / total
        return energy, momentum - total * np.cross(centre, speed)

    start = body.start()[:-1]
    before = kept(start[:, :3], start[:, 3:7], start[:, 7:10], start[:, 10:])
    after = kept(end.p_WB, end.q_WB, end.v_WB, end.w_WB)
    assert after[0] == pytest.approx(before[0], abs=1e-7)
    np.testing.assert_allclose(after[1], before[1], atol=1e-8)
    ball = next(joint for joint in scene.joints if isinstance(joint, Ball))
    ends = []
    for name in (ball.parent, ball.child):
        k = next(i for i, b in enumerate(scene.bodies) if b.name == name)
        lever = matrix(start[k, 3:7]).T @ (np.array(ball.anchor_W) - start[k, :3])
        ends.append(end.p_WB[k] + matrix(end.q_WB[k]) @ lever)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-8)


@pytest.mark.parametrize(
    ("joint", "said"),
    [
        (
            Revolute(name="h", parent=WORLD, child="b", anchor_W=(0.0, 0.0, 1.0), axis_W=(1.0, 0.0, 0.0), armature=0.1),
            "armature",
        ),
        (Distance(name="h", parent=WORLD, child="b", anchor_W=(0.0, 0.0, 1.0), child_anchor_W=(0.0, 0.0, 0.0)), "a rod"),
    ],
)
def test_what_it_does_not_know_it_refuses(joint: Revolute | Distance, said: str) -> None:
    with pytest.raises(NotImplementedError, match=said):
        Multibody(Scene(bodies=(Body(name="b"),), joints=(joint,)))


def test_a_limit_that_is_reached_is_refused() -> None:
    """The hinge of the last body starts at 0 and goes up; at its limit no law of this file says what happens."""
    scene = _chain()
    hinge = next(joint for joint in scene.joints if isinstance(joint, Revolute))
    limited = replace(hinge, limits=Limits(upper=1e-3))
    stopped = replace(scene, joints=tuple(limited if joint is hinge else joint for joint in scene.joints))
    with pytest.raises(NotImplementedError, match="a limit is reached"):
        Multibody(stopped).motion(DURATION, RUNGE_KUTTA)


def test_each_two_nouns_that_can_stand_together_do() -> None:
    """17 nouns make 136 pairs; two ranges of one coordinate cannot stand together."""
    names = [name for name, _ in all_pairs()]
    assert len(names) == len(set(names)) == len(NOUNS) * (len(NOUNS) - 1) // 2 - 1
    assert "pair_limit_and_one_sided_limit" not in names
