"""Trees of joints become multibodies."""

from collections.abc import Callable, Sequence
from typing import Any

from plumbline.harness.adapter.reduced_trees import JointTree
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import State
from plumbline.harness.trajectory.joint_states import joint_states

PRIMING = 1e-9
"""The length [s] of a step by which a multibody learns that its root stands still: until then that has six coordinates. At
1e-20, whose square is no number of single precision, an undamped spring of 80 N/m lost 9 % of its energy in 0.8 s."""


def put_trees(
    world: Any, scene: Scene, trees: Sequence[JointTree], root: Callable[[str], Any], link: Callable[..., Any]
) -> None:
    """Insert the joints of trees with the velocities of the start.

    Args: root: the handle that a tree's root has. link: inserts a joint towards the body of that name, whose parent is the root
    of its tree, or None for another body.
    """
    inserted = []
    for tree in trees:
        base = root(tree.root)
        ends = [link(b.edge, b.node, base if b.above == tree.root else None) for b in tree.branches]
        inserted.append((tree, ends[-1]))
    if not inserted:
        return
    parameters, gravity = world.integration_parameters, (world.gravity.x, world.gravity.y, world.gravity.z)
    usual, parameters.dt, world.gravity = parameters.dt, PRIMING, (0.0, 0.0, 0.0)
    world.step()
    parameters.dt, world.gravity = usual, gravity
    start = State.initial(scene)
    rate = dict(zip((joint.name for joint in scene.joints), joint_states(scene, start).rate.tolist(), strict=True))
    for tree, end in inserted:
        multibody = world.multibody_joints.multibody(end)
        rotors = [0.0] * multibody.ndofs
        rates, links = [0.0] * multibody.ndofs, {link.link_id: link for link in multibody}
        if links[0].ndofs == 6:
            body_index = scene.index(tree.root)
            rates[:6] = [*start.v_WB[body_index].tolist(), *start.w_WB[body_index].tolist()]
        for number, branch in enumerate(tree.branches, 1):
            if links[number].ndofs == 1:
                rates[links[number].assembly_id] = rate[branch.edge.name]
                rotors[links[number].assembly_id] = getattr(branch.edge, "armature", None) or 0.0
        multibody.set_damping([0.0] * multibody.ndofs)
        multibody.set_armature(rotors)
        multibody.set_generalized_velocity(rates)
