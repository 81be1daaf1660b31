"""MJCF's tendons: fixed ones, and one between two sites that has a spring or damper alone, a spring between two bodies."""

from collections.abc import Mapping, Sequence

import numpy as np

from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.mjcf_model import Model
from plumbline.harness.scene.importers.robot import Closure, Cord, Servo


def pulls(model: Model, k: int) -> bool:
    """Has a tendon a force or an inertia of its own, a limit apart?"""
    words = ("stiffness", "damping", "frictionloss", "armature")
    return any(bool(np.any(getattr(model, f"tendon_{word}")[k] != 0)) for word in words)


def is_fixed(model: Model, k: int) -> bool:
    """Is a tendon a linear combination of coordinates?"""
    first, count = int(model.tendon_adr[k]), int(model.tendon_num[k])
    return count > 0 and all(model.word("Wrap", int(w)) == "joint" for w in model.wrap_type[first : first + count])


def has_more(model: Model, k: int) -> bool:
    """Has a tendon a law that a scene has no word for?"""
    low, high = (float(x) for x in model.tendon_lengthspring[k])
    beside = ("frictionloss", "armature", "stiffnesspoly", "dampingpoly", "springyield")
    slack = bool(model.tendon_stiffness[k]) and low != high
    return slack or any(bool(np.any(getattr(model, f"tendon_{word}")[k])) for word in beside)


def fixed(model: Model, servos: Mapping[int, Servo], rows: list[Fidelity]) -> dict[int, Cord]:
    """Fixed tendons with a law that a scene has, by their place. Args: servos: by tendon; rows: are added to."""
    carried: dict[int, Cord] = {}
    for k in range(len(model.tendon_limited)):
        stiffness = 0.0 if model.flag("spring") else float(model.tendon_stiffness[k])
        damping = 0.0 if model.flag("damper") else float(model.tendon_damping[k])
        limited = bool(model.tendon_limited[k]) and not model.flag("limit")
        if not is_fixed(model, k) or has_more(model, k) or not (stiffness or damping or limited or k in servos):
            continue
        first, count = int(model.tendon_adr[k]), int(model.tendon_num[k])
        arms: dict[str, float] = {}
        for joint, arm in zip(model.wrap_objid[first : first + count], model.wrap_prm[first : first + count], strict=True):
            name = model.name("joint", int(joint))
            arms[name] = arms.get(name, 0.0) + float(arm)
        carried[k] = Cord(
            name=model.name("tendon", k),
            arms=tuple((name, arm) for name, arm in arms.items() if arm),
            lower=float(model.tendon_range[k][0]) if limited else None,
            upper=float(model.tendon_range[k][1]) if limited else None,
            stiffness=stiffness,
            damping=damping,
            rest=float(model.tendon_lengthspring[k][0]),
            servo=servos.get(k),
        )
    carried = {k: cord for k, cord in carried.items() if cord.arms}
    rows += Fidelity.exact("tendon", [cord.name for cord in carried.values()], "tendon")
    return carried


def springs(model: Model, links: Sequence[str], rows: list[Fidelity]) -> dict[int, Closure]:
    """Springs between two links, by the place of their tendon. Args: links: names by body; rows: are added to."""
    made: dict[int, Closure] = {}
    for k in range(len(model.tendon_limited)):
        stiffness = 0.0 if model.flag("spring") else float(model.tendon_stiffness[k])
        damping = 0.0 if model.flag("damper") else float(model.tendon_damping[k])
        if _is_line(model, k) and stiffness + damping > 0:
            first = int(model.tendon_adr[k])
            a, b = (int(site) for site in model.wrap_objid[first : first + 2])
            made[k] = Closure(
                name=model.name("tendon", k),
                kind="spring",
                link_A=links[int(model.site_bodyid[a])],
                link_B=links[int(model.site_bodyid[b])],
                anchor_A=np.array(model.site_pos[a], dtype=np.float64),
                anchor_B=np.array(model.site_pos[b], dtype=np.float64),
                stiffness=stiffness,
                damping=damping,
                rest=float(model.tendon_lengthspring[k][0]),
            )
    if made:
        names = [spring.name for spring in made.values()]
        rows += Fidelity.exact("tendon", names, "springs between points of two bodies")
    return made


def _is_line(model: Model, k: int) -> bool:
    """Does a tendon run straight from one site to another, with a linear spring and damper and nothing else?"""
    first, count = int(model.tendon_adr[k]), int(model.tendon_num[k])
    straight = count == 2 and all(model.word("Wrap", int(w)) == "site" for w in model.wrap_type[first : first + 2])
    low, high = (float(x) for x in model.tendon_lengthspring[k])
    beside = ("frictionloss", "armature", "limited", "stiffnesspoly", "dampingpoly", "springyield")
    return straight and low == high and not any(bool(np.any(getattr(model, f"tendon_{word}")[k])) for word in beside)
