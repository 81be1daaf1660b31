"""Random trees of bodies and joints in random states, as Pinocchio has them and as bodies of ours."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbline import engine
from plumbline.engine.articulated import tables as to

__all__ = ["GRAVITY", "LINKS", "Tree", "pin", "random_tree", "table", "world_of"]

pin: Any = pytest.importorskip("pinocchio", reason="the package pin holds Pinocchio")

KINDS = ("revolute", "prismatic", "ball", "fixed")
LINKS = 12
GRAVITY = (0.0, 0.0, -9.81)


@dataclass
class Tree:
    """A random tree in a random state: as Pinocchio's model, and as bodies and joints of ours."""

    model: Any
    q: np.ndarray
    v: np.ndarray
    bodies: list[engine.Body]
    joints: list[engine.Joint]


def random_tree(
    seed: int,
    floating: bool,
    kinds: tuple[str, ...] = KINDS,
    backwards: bool = True,
    ties: Mapping[int, tuple[int, float]] | None = None,
) -> Tree:
    """Twelve links on joints of these kinds in turn, some told from the outer body on; each turned, moved and moving.

    Args: ties: by the number of a joint, that of the joint whose coordinate it follows, told before it, and the ratio.
    """
    rng = np.random.default_rng(seed)
    model, made = pin.Model(), []
    names: list[tuple[int, Any]] = []
    model.gravity.linear = np.array(GRAVITY)
    for k in range(LINKS):
        kind = "free" if floating and k == 0 else kinds[k % len(kinds)]
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        joint = {
            "free": pin.JointModelFreeFlyer,
            "ball": pin.JointModelSpherical,
            "revolute": lambda axis=axis: pin.JointModelRevoluteUnaligned(axis),
            "prismatic": lambda axis=axis: pin.JointModelPrismaticUnaligned(axis),
        }
        parent = int(rng.integers(max(0, k - 3), k)) if k > 0 else -1
        where = pin.SE3(Rotation.random(random_state=rng).as_matrix(), rng.normal(0, 0.3, 3))
        moments = np.diag(rng.uniform(0.02, 0.03, 3))
        turn = Rotation.random(random_state=rng).as_matrix()
        solid = pin.Inertia(rng.uniform(0.2, 3.0), rng.normal(0, 0.1, 3), turn @ moments @ turn.T)
        above, offset = names[parent] if parent >= 0 else (0, pin.SE3.Identity())
        if kind == "fixed":
            names.append((above, offset * where))
            model.appendBodyToJoint(above, solid, offset * where)
        else:
            number = model.addJoint(above, joint[kind](), offset * where, f"joint{k}")
            names.append((number, pin.SE3.Identity()))
            model.appendBodyToJoint(number, solid, pin.SE3.Identity())
        made.append((kind, parent, axis, solid, offset * where, above))
    pin.seed(seed)
    q, v = pin.randomConfiguration(model, -np.ones(model.nq), np.ones(model.nq)), rng.normal(0, 2, model.nv)
    for k, (leader, ratio) in (ties or {}).items():
        follower, leads = (model.idx_vs[model.getJointId(f"joint{number}")] for number in (k, leader))
        v[follower] = ratio * v[leads]
    data = model.createData()
    pin.forwardKinematics(model, data, q, v)
    bodies: list[engine.Body] = []
    joints: list[engine.Joint] = []
    for k, (kind, parent, axis, solid, here, above) in enumerate(made):
        number, offset = names[k]
        pose, moves = data.oMi[number] * offset, pin.getVelocity(model, data, number, pin.LOCAL_WORLD_ALIGNED)
        centre = pose.act(solid.lever)
        bodies.append(
            engine.Body(
                name=f"link{k}", mass=solid.mass, inertia=solid.inertia, p_WB=tuple(centre),
                q_WB=tuple(Rotation.from_matrix(pose.rotation).as_quat(scalar_first=True)),
                v_WB=tuple(moves.linear + np.cross(moves.angular, centre - data.oMi[number].translation)),
                w_WB=tuple(moves.angular),
            )
        )  # fmt: skip
        ends: dict[str, Any] = {
            "name": f"joint{k}", "parent": f"link{parent}" if parent >= 0 else engine.WORLD, "child": f"link{k}"
        }  # fmt: skip
        frame = data.oMi[above] * here
        sign = 1.0
        if backwards and k % 3 == 2:
            # The outer body is the joint's parent: the way of the coordinate turns round.
            ends["parent"], ends["child"], sign = ends["child"], ends["parent"], -1.0
        line: dict[str, Any] = {
            "anchor_W": tuple(pose.translation),
            "axis_W": tuple(sign * (frame.rotation @ axis)),
            "position": 0.7,
        }
        if ties and k in ties:
            leader, ratio = ties[k]
            line["coupling"] = engine.Coupling(joint=f"joint{leader}", ratio=ratio, offset=0.7 - ratio * 0.7)
        if kind == "revolute":
            joints.append(engine.Revolute(**ends, **line))
        elif kind == "prismatic":
            joints.append(engine.Prismatic(**ends, **line))
        elif kind == "ball":
            joints.append(engine.Ball(**ends, anchor_W=tuple(pose.translation)))
        elif kind == "fixed":
            joints.append(engine.Fixed(**ends))
    return Tree(model, q, v, bodies, joints)


def world_of(tree: Tree, **options: Any) -> engine.World:
    """The tree in joint coordinates; one step of semi-implicit Euler over a second, unless told otherwise."""
    chosen = {"dt": 1.0, "substeps": 1, "coordinates": "joint", **options}
    return engine.World(tree.bodies, tree.joints, gravity=GRAVITY, options=engine.Options(**chosen))


def table(world: engine.World, number: int) -> np.ndarray:
    """A table of the world's trees."""
    return to.float_view(*world.save(), number)
