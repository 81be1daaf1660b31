"""The order in which the rows of joints are eliminated, whatever order they are listed in.

The factor of J M^-1 J^T fills from the first joint that shares a body with a joint up to that joint, and costs the square of
that width. Reverse Cuthill-McKee puts neighbours near each other; children before their parents, the largest branch first,
suits trees.

Source: George, Liu, Computer Solution of Large Sparse Positive Definite Systems (1981), chapter 4.
"""

from collections.abc import Sequence

from plumbline.engine.describe.bodies import Body
from plumbline.engine.describe.joints import Ball, Distance, Fixed, Joint, Prismatic, Revolute

ROWS = {Fixed: 6, Ball: 3, Revolute: 5, Prismatic: 5, Distance: 1}
"""The equality rows of each type of joint."""

TRIED = 32
"""From so many joints of a mechanism the orders are tried, those with the fewest neighbours first."""


def elimination_order(bodies: Sequence[Body], joints: Sequence[Joint]) -> Sequence[Joint]:
    """The joints, reordered where that makes the factor cheaper; mechanisms of their own stay together."""
    if len(joints) < 3:
        return joints
    beside = neighbours(bodies, joints)
    found = [j for part in mechanisms(beside) for j in _best(part, beside, joints)]
    if factor_cost(found, beside, joints) < factor_cost(range(len(joints)), beside, joints):
        return [joints[j] for j in found]
    return joints


def neighbours(bodies: Sequence[Body], joints: Sequence[Joint]) -> list[list[int]]:
    """For each joint the others on its dynamic bodies, ascending: those that it couples with."""
    on: dict[str, list[int]] = {body.name: [] for body in bodies if body.motion == "dynamic"}
    for j, joint in enumerate(joints):
        for name in {joint.parent, joint.child} & on.keys():
            on[name].append(j)
    return [
        sorted({k for name in (joint.parent, joint.child) for k in on.get(name, ())} - {j}) for j, joint in enumerate(joints)
    ]


def factor_cost(order: Sequence[int], beside: Sequence[Sequence[int]], joints: Sequence[Joint]) -> int:
    """The squared widths of all rows in the factor, summed, in this order of the joints: what it costs, in units of one.

    Args: beside: as `neighbours` returns it.
    """
    place = {j: k for k, j in enumerate(order)}
    begin = [0]
    for j in order:
        begin.append(begin[-1] + ROWS[type(joints[j])])
    total = 0
    for k, j in enumerate(order):
        first = min((place[i] for i in beside[j]), default=k)
        width = begin[k + 1] - begin[min(first, k)]
        total += (begin[k + 1] - begin[k]) * width * width
    return total


def mechanisms(beside: Sequence[Sequence[int]]) -> list[list[int]]:
    """The joints of each mechanism, in the order of their first joints."""
    seen: set[int] = set()
    parts = []
    for j in range(len(beside)):
        if j not in seen:
            parts.append(list(_found_from(j, beside)))
            seen.update(parts[-1])
    return parts


def _best(part: Sequence[int], beside: Sequence[Sequence[int]], joints: Sequence[Joint]) -> list[int]:
    """The cheapest order of one mechanism among those tried; the first one of equals."""
    starts = sorted(part, key=lambda j: (len(beside[j]), j))[:TRIED]
    starts += [list(_found_from(j, beside))[-1] for j in starts[:4]]
    orders = [sorted(part)]
    for j in dict.fromkeys(starts):
        orders += [list(_found_from(j, beside))[::-1], _children_first(j, beside)]
    costs = [factor_cost(order, beside, joints) for order in orders]
    return orders[costs.index(min(costs))]


def _found_from(start: int, beside: Sequence[Sequence[int]]) -> dict[int, int]:
    """For each joint of a mechanism, breadth first from one of them, the joint from which it was found.

    Those with few neighbours come first: Cuthill-McKee, to be reversed.
    """
    found, order = {start: start}, [start]
    for j in order:
        new = sorted((k for k in beside[j] if k not in found), key=lambda k: (len(beside[k]), k))
        found.update(dict.fromkeys(new, j))
        order += new
    return found


def _children_first(start: int, beside: Sequence[Sequence[int]]) -> list[int]:
    """Every joint after those found from it, and the largest branch first: no other has to reach back across it."""
    above = _found_from(start, beside)
    size = dict.fromkeys(above, 1)
    below: dict[int, list[int]] = {j: [] for j in above}
    for j in reversed(above):
        if j != start:
            size[above[j]] += size[j]
            below[above[j]].append(j)
    order, stack = [], [start]
    while stack:
        joint = stack.pop()
        order.append(joint)
        stack += sorted(below[joint], key=lambda j: (-size[j], j))
    return order[::-1]
