"""MJCF's actuators and tendons: what pulls at a joint or fixed tendon by a law affine in coordinate and rate, as a drive.

A tendon between two sites that has a spring or damper alone is a spring between two bodies.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.mjcf_model import Model
from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.importers.robot import Closure, Cord, Need, Servo

Servos: TypeAlias = dict[int, Servo]
"""By the place of a joint or tendon in the compiled model."""
_Kind: TypeAlias = Literal["joint", "tendon"]


@dataclass(frozen=True, slots=True)
class _Law:
    """The force of an actuator on the coordinate q of its joint: constant + pull - stiffness q - damping q', cut off.

    Terms: pull: what its command asks of the gains, stiffness target + damping target_velocity. low, high: the bounds.
    """

    stiffness: float
    damping: float
    pull: float
    constant: float
    low: float = -math.inf
    high: float = math.inf

    @property
    def bounded(self) -> bool:
        """Has it a bound?"""
        return math.isfinite(self.low) or math.isfinite(self.high)

    @property
    def gains(self) -> bool:
        """Does it depend on the coordinate?"""
        return self.stiffness != 0 or self.damping != 0


def read(model: Model, ctrl: Array) -> tuple[Servos, Servos, list[Fidelity], list[Need]]:
    """The servos of joints and of fixed tendons at the commands `ctrl`, what became of the actuators, and those that a scene
    has no word for."""
    if model.flag("actuation"):
        count = len(model.actuator_trntype)
        return {}, {}, Fidelity.exact("actuator", "", count=count, consequence="the file switches actuators off"), []
    laws: dict[tuple[_Kind, int], list[tuple[str, _Law]]] = {}
    strange: list[str] = []
    for k in range(len(model.actuator_trntype)):
        law, kind = _law(model, k, ctrl), _pulled(model, k)
        if law is None or kind is None:
            strange.append(model.name("actuator", k))
        else:
            laws.setdefault((kind, int(model.actuator_trnid[k][0])), []).append((model.name("actuator", k), law))
    servos: dict[_Kind, Servos] = {"joint": {}, "tendon": {}}
    idle = list[str]()
    driven: dict[_Kind, list[str]] = {"joint": [], "tendon": []}
    for (kind, number), acting in laws.items():
        array = "jnt" if kind == "joint" else "tendon"
        whole: tuple[float, ...] = (-math.inf, math.inf)
        if getattr(model, f"{array}_actfrclimited")[number]:
            low, high = getattr(model, f"{array}_actfrcrange")[number]
            whole = float(low), float(high)
        servo, names = _servo([law for _, law in acting], whole), [name for name, _ in acting]
        if servo is None or (kind == "tendon" and servo.push):
            strange += names
        elif servo == Servo():
            idle += names
        else:
            driven[kind] += names
            servos[kind][number] = servo
    rows = Fidelity.exact("actuator", driven["joint"], "drive of its joint")
    rows += Fidelity.exact("actuator", driven["tendon"], "drive of its tendon")
    rows += Fidelity.told("idle actuator", idle)
    return servos["joint"], servos["tendon"], rows, Need.of("actuator", "actuator", strange)


def _pulled(model: Model, k: int) -> _Kind | None:
    """What an actuator pulls at: a joint of one coordinate, or a fixed tendon that a scene has; None for anything else."""
    word, number = model.word("Trn", int(model.actuator_trntype[k])), int(model.actuator_trnid[k][0])
    if word in ("joint", "jointinparent") and model.word("Joint", int(model.jnt_type[number])) in ("hinge", "slide"):
        return "joint"
    return "tendon" if word == "tendon" and is_fixed(model, number) and not has_more(model, number) else None


def _law(model: Model, k: int, ctrl: Array) -> _Law | None:
    """The law of an actuator whose force is affine in the length that it pulls at; None for another one.

    Its force is gain u + b_0 + b_1 l + b_2 l', with l = gear q: a torque of gear times that.
    """
    plain = (
        model.word("Gain", int(model.actuator_gaintype[k])) == "fixed"
        and model.word("Dyn", int(model.actuator_dyntype[k])) == "none"
        and not np.any(model.actuator_armature[k])
        and not np.any(model.actuator_damping[k])
        and not model.actuator_gear[k][1:].any()
    )
    bias = model.word("Bias", int(model.actuator_biastype[k]))
    if not plain or bias not in ("none", "affine"):
        return None
    gear, gain = float(model.actuator_gear[k][0]), float(model.actuator_gainprm[k][0])
    if gear == 0:
        return None
    b0, b1, b2 = (float(b) for b in model.actuator_biasprm[k][:3]) if bias == "affine" else (0.0, 0.0, 0.0)
    if b1 > 0 or b2 > 0:
        return None
    low, high = -math.inf, math.inf
    if model.actuator_forcelimited[k]:
        low, high = sorted(gear * float(bound) for bound in np.ravel(model.actuator_forcerange[k])[:2])
    pull, constant = gain * _command(model, k, ctrl) * gear, b0 * gear
    if b1 == b2 == 0:
        pull, constant = 0.0, constant + pull
    return _Law(-b1 * gear * gear, -b2 * gear * gear, pull, constant, low, high)


def _servo(laws: Sequence[_Law], whole: tuple[float, ...]) -> Servo | None:
    """The drive that the actuators of a length are together; an empty one where they do nothing, None where it is none.

    Laws without bounds add up, and so do constants within theirs; `whole` are the bounds of all together.
    Bounds that are not alike both ways, low and high, are those of a drive about their middle beside a constant push: with
    m = (low + high)/2 and w = (high - low)/2, clip(f, low, high) = m + clip(f - m, -w, w).
    """
    if len(laws) > 1:
        if any(law.bounded and law.gains for law in laws):
            return None
        fixed = sum(min(max(law.constant, law.low), law.high) for law in laws if not law.gains)
        pulled = [law for law in laws if law.gains]
        laws = [
            _Law(
                sum(law.stiffness for law in pulled),
                sum(law.damping for law in pulled),
                sum(law.pull for law in pulled),
                fixed + sum(law.constant for law in pulled),
            )
        ]
    (law,) = laws
    low, high = max(law.low, whole[0]), min(law.high, whole[1])
    if low > high or (low == high == 0):
        return None
    if not law.gains and min(max(law.constant, low), high) == 0:
        return Servo()
    middle, limit = 0.0, None
    if math.isfinite(low) or math.isfinite(high):
        if abs(low + high) > 1e-12 * abs(high):
            middle = (low + high) / 2
        limit = high - middle
    if limit is not None and (not math.isfinite(limit) or limit <= 0):
        return None
    servo = Servo(stiffness=law.stiffness, damping=law.damping, limit=limit, feedforward=law.constant - middle, push=middle)
    if law.stiffness > 0:
        return replace(servo, target=law.pull / law.stiffness)
    return replace(servo, target_velocity=law.pull / law.damping) if law.damping > 0 else servo


def _command(model: Model, k: int, ctrl: Array) -> float:
    index = int(model.actuator_ctrladr[k])
    command = float(ctrl[index]) if 0 <= index < len(ctrl) else 0.0
    if model.actuator_ctrllimited[k]:
        low, high = (float(x) for x in np.ravel(model.actuator_ctrlrange[k])[:2])
        command = min(max(command, low), high)
    return command


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
