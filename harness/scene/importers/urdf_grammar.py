"""The elements and attributes of URDF, which are numbers and how many, and what no robot may say; checked before it is parsed.

Source: ROS, urdf/XML (link, joint, transmission, gazebo); the elements of vendors' dialects stand apart.
"""

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType

from plumbline.harness.intake.near_miss import did_you_mean, misspelt
from plumbline.harness.intake.safe_text import quoted, readable
from plumbline.harness.intake.typed_fields import LARGEST, wrong_size
from plumbline.harness.scene.importers.robot import parents_first
from plumbline.harness.scene.importers.xml_text import Element

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
GEOMETRIES = ("box", "cylinder", "sphere", "mesh")


@dataclass(frozen=True, slots=True)
class _Form:
    """What an element may say.

    Terms: children: elements in it. numbers: attributes, each with how many numbers it may have. texts: other attributes.
    required: attributes that have to be there. positive, not_negative: numbers that are above 0, and 0 or more.
    """

    children: tuple[str, ...] = ()
    numbers: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    texts: tuple[str, ...] = ()
    required: tuple[str, ...] = ()
    positive: tuple[str, ...] = ()
    not_negative: tuple[str, ...] = ()


def _single(*names: str) -> dict[str, tuple[int, ...]]:
    return dict.fromkeys(names, (1,))


_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_LIMITS = ("lower", "upper", "effort", "velocity")
_SOFT = ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity")
_OF_A_JOINT = ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller")
_FORMS: Mapping[str, _Form] = MappingProxyType(
    {
        "robot": _Form(("link", "joint", "material"), texts=("name", "version")),
        "link": _Form(("inertial", "visual", "collision"), texts=("name", "type"), required=("name",)),
        "joint": _Form(_OF_A_JOINT, texts=("name", "type"), required=("name", "type")),
        "inertial": _Form(("origin", "mass", "inertia")),
        "visual": _Form(("origin", "geometry", "material"), texts=("name",)),
        "collision": _Form(("origin", "geometry"), texts=("name", "group")),
        "geometry": _Form(GEOMETRIES),
        "material": _Form(("color", "texture"), texts=("name",)),
        "origin": _Form(numbers={"xyz": (3,), "rpy": (3,)}),
        "mass": _Form(numbers=_single("value"), required=("value",), not_negative=("value",)),
        "inertia": _Form(numbers=_single(*_MOMENTS), required=_MOMENTS),
        "box": _Form(numbers={"size": (3,)}, required=("size",), positive=("size",)),
        "cylinder": _Form(numbers=_single("radius", "length"), required=("radius", "length"), positive=("radius", "length")),
        "sphere": _Form(numbers=_single("radius"), required=("radius",), positive=("radius",)),
        "mesh": _Form(numbers={"scale": (1, 3)}, texts=("filename",), required=("filename",)),
        "color": _Form(numbers={"rgba": (4,)}),
        "texture": _Form(texts=("filename",)),
        "parent": _Form(texts=("link",), required=("link",)),
        "child": _Form(texts=("link",), required=("link",)),
        "axis": _Form(numbers={"xyz": (3,)}),
        "limit": _Form(numbers=_single(*_LIMITS), not_negative=("effort", "velocity")),
        "dynamics": _Form(numbers=_single("damping", "friction"), not_negative=("damping", "friction")),
        "mimic": _Form(numbers=_single("multiplier", "offset"), texts=("joint",), required=("joint",)),
        "calibration": _Form(numbers=_single("rising", "falling")),
        "safety_controller": _Form(numbers=_single(*_SOFT)),
    }
)
_ONCE = ("inertial", "origin", "mass", "inertia", "axis", "limit", "dynamics", "mimic", "parent", "child", "geometry")
_STILL = {
    *("visual", "material", "color", "texture", "calibration", "safety_controller"),
    *("version", "group", "rgba", "rising", "falling"),
}
"""Words of URDF that change no motion, so that what is near them changes none either."""
_ALONE = {
    *("inertial", "collision", "mass", "inertia", "axis", "limit", "dynamics", "mimic", "damping", "friction"),
    *("lower", "upper", "effort", "velocity", "multiplier", "ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
}
"""Words that change the motion wherever they are meant to stand: in another element they are refused."""
FOREIGN: Mapping[str, str] = MappingProxyType(
    {
        "transmission": "gear ratios between motors and joints are not part of the motion of the links",
        "gazebo": "what one simulator is told beside the robot, friction and damping among it, is not read",
        "contact": "friction and stiffness of contacts as one engine reads them; [[surfaces]] of the companion file say them",
        "sensor": "sensors are not read",
        "plugin": "plug-ins are not read",
        "self_collision_checking": "shapes for a planner are not read",
        "drake": "what one simulator is told beside the robot is not read",
        "capsule": "a planner's shapes are not read",
        "audio_source": "sounds are not read",
        "verbose": "a name for people is not read",
        "actuator": "motors outside of a transmission are not read",
        "hardwareInterface": "interfaces to hardware are not read",
        "ros2_control": "interfaces to hardware are not read",
        "frame": "extra frames carry no mass",
        "specular": "how it looks",
        "material": "how it looks",
        "joint_properties": "damping and friction of a dialect, which are 0 here",
        "vhacd": "settings of a decomposition are not read",
        "cdf": "signed distance functions are not read",
    }
)
"""Elements of dialects that stand beside the robot, and what is lost without them."""


@lru_cache(maxsize=4096)
def _values(text: str) -> tuple[tuple[float, ...], bool]:
    """As many numbers as there are words, NaN where one is none; are all of a size that is taken? Texts are read repeatedly."""
    words = text.split()
    try:
        values = tuple(map(float, words)) if len(text) < 400 and "_" not in text else (math.nan,) * len(words)
    except ValueError:
        values = (math.nan,) * len(words)
    return values, sum(map(abs, values)) <= LARGEST


def numbers(element: Element, name: str, counts: tuple[int, ...] = (1,)) -> tuple[float, ...] | None:
    """The numbers of an attribute; None where it does not stand there. Raises: RobotError."""
    text = element.attributes.get(name)
    if text is None:
        return None
    values, taken = _values(text)
    if taken and len(values) in counts:
        return values
    several = "s" if counts != (1,) else ""
    if len(values) not in counts:
        expected = " or ".join(str(count) for count in counts)
        raise element.refuse(f"{name} is {quoted(text)}, expected {expected} number{several}")
    if not all(map(math.isfinite, values)):
        raise element.refuse(f"{name} is {quoted(text)}, expected finite number{several}")
    if wrong := next(filter(None, map(wrong_size, values)), ""):
        raise element.refuse(f"{name} is {quoted(text)}, {wrong}")
    return values


@dataclass(frozen=True, slots=True)
class Left:
    """What was left behind. Terms: foreign: elements of known dialects, by kind. unknown: owners of each other word."""

    foreign: Counter[str] = field(default_factory=Counter)
    unknown: dict[str, list[str]] = field(default_factory=dict)

    def words(self) -> list[str]:
        """Each word that is left out, with how often."""
        return [f"{word} ({len(owners)})" if len(owners) > 1 else word for word, owners in self.unknown.items()]


def check(root: Element, *, strict: bool = False) -> tuple[Element, Left]:
    """The robot, out of which all is taken that is not URDF's own, and what was left behind.

    Args: strict: is every word refused that is neither URDF's nor a known dialect's? Else those that are no slip of the pen for
    what changes the motion are left behind.
    Raises: RobotError, naming file, line, element, attribute, value and expectation.
    """
    if root.tag != "robot":
        raise root.refuse("is the root of the file, expected <robot>")
    left = Left()
    _check_element(root, left, strict)
    return root, left


def _passed_over(word: str, words: Iterable[str], strict: bool) -> bool:
    """May an unknown word be left out: is it neither one that changes the motion nor near one that may stand here?"""
    return not (strict or word in _ALONE or misspelt(word, (each for each in words if each not in _STILL)))


def _check_element(element: Element, left: Left, strict: bool) -> None:
    _check_attributes(element, left, strict)
    if element.tag == "geometry":
        shapes = [child.tag for child in element.children if child.tag not in FOREIGN or child.tag in ("capsule", "cdf")]
        if len(shapes) != 1 or shapes[0] not in GEOMETRIES:
            got = ", ".join(f"<{tag}>" for tag in shapes[:4]) or "nothing"
            raise element.refuse(f"holds {quoted(got)[1:-1]}, expected one of {', '.join(GEOMETRIES)}")
    kept = []
    known = _FORMS[element.tag].children
    for child in element.children:
        foreign = child.tag.partition(":")[0]
        if child.tag in known:
            _check_element(child, left, strict)
            kept.append(child)
        elif foreign == "xacro":
            raise child.refuse("a macro that was not expanded; run xacro first and give its output")
        elif foreign in FOREIGN or ":" in child.tag:
            _check_dialect(child)
            left.foreign[foreign] += 1
        elif _passed_over(child.tag, known, strict):
            _leave(left, f"<{quoted(child.tag, 60)[1:-1]}> in <{element.tag}>", element)
        else:
            hint = did_you_mean(misspelt(child.tag, known) or child.tag, known, "<{}>")
            expected = f"one of {', '.join(known)}" if known else "no element"
            raise child.refuse(f"is unknown in <{element.tag}>, expected {expected}{hint}")
    if len(kept) > 1:
        tags = [child.tag for child in kept]
        for tag in _ONCE:
            if tags.count(tag) > 1:
                raise next(child for child in reversed(kept) if child.tag == tag).refuse(
                    f"stands twice in {element.where.partition(': ')[2]}, expected once"
                )
    if element.tag in ("visual", "collision") and not any(child.tag == "geometry" for child in kept):
        raise element.refuse("has no <geometry>, expected one")
    if element.tag == "joint":
        for tag in ("parent", "child"):
            if not any(child.tag == tag for child in kept):
                raise element.refuse(f"has no <{tag}>, expected one")
        for axis in element.all("axis") if element.attributes["type"] not in ("fixed", "floating") else ():
            if math.hypot(*(numbers(axis, "xyz", (3,)) or (1.0,))) < 1e-9:
                raise axis.refuse(f"xyz is {quoted(axis.attributes['xyz'])}, expected a direction")
    element.children = kept


def _check_dialect(element: Element) -> None:
    """An old dialect says damping and friction in <joint_properties>: where they are not 0 they are not lost in silence."""
    if element.tag == "joint_properties":
        for name in element.attributes:
            if any(numbers(element, name) or ()):
                raise element.refuse(
                    f"{name} is {quoted(element.attributes[name])} in a dialect's element; URDF says it in <dynamics>"
                )


def _leave(left: Left, word: str, owner: Element) -> None:
    left.unknown.setdefault(word, []).append(readable(owner.attributes.get("name", ""), 80) or f"line {owner.line}")


def _check_attributes(element: Element, left: Left, strict: bool) -> None:
    tag, form = element.tag, _FORMS[element.tag]
    for name in form.required:
        if name not in element.attributes:
            raise element.refuse(f"{name} is missing, expected {'a number' if name in form.numbers else 'a text'}")
    for name, text in element.attributes.items():
        if "$" in text and ("${" in text or "$(" in text):
            raise element.refuse(f"{name} is {quoted(text)}: a macro that was not expanded; run xacro first")
        if name in form.numbers:
            _check_signs(element, name, numbers(element, name, form.numbers[name]) or ())
        elif name not in form.texts and not name.startswith("xmlns") and ":" not in name:
            valid = (*form.numbers, *form.texts)
            if _passed_over(name, valid, strict):
                _leave(left, f"{quoted(name, 60)[1:-1]} of <{tag}>", element)
                continue
            hint = did_you_mean(misspelt(name, valid) or name, valid)
            raise element.refuse(f"attribute {quoted(name, 60)} is unknown, expected {', '.join(valid) or 'none'}{hint}")
    if tag == "joint" and element.attributes["type"] not in JOINT_TYPES:
        raise element.refuse(f"type is {quoted(element.attributes['type'])}, expected one of {', '.join(JOINT_TYPES)}")
    if tag == "limit":
        lower, upper = numbers(element, "lower"), numbers(element, "upper")
        if lower is not None and upper is not None and lower > upper:
            raise element.refuse(f"lower is {lower[0]:g} and upper {upper[0]:g}, expected lower <= upper")


def _check_signs(element: Element, name: str, values: tuple[float, ...]) -> None:
    form, expected = _FORMS[element.tag], ""
    if name in form.positive and min(values) <= 0:
        expected = "above 0"
    elif name in form.not_negative and min(values) < 0:
        expected = "0 or more"
    elif name == "scale" and 0 in values:
        expected = "no zero"
    if expected:
        raise element.refuse(f"{name} is {quoted(element.attributes[name])}, expected {expected}")


def check_tree(root: Element) -> list[str]:
    """The links, parents before children: one root, every joint between links that there are, every name once, no cycle.

    Raises: RobotError.
    """
    links, joints = root.all("link"), root.all("joint")
    if not links:
        raise root.refuse("has no <link>, expected at least one")
    for kind in (links, joints):
        seen: dict[str, Element] = {}
        for element in kind:
            name = element.attributes["name"]
            if name in seen:
                raise element.refuse(f"name stands in line {seen[name].line} too, expected each once")
            seen[name] = element
    names = {link.attributes["name"]: link for link in links}
    holder: dict[str, Element] = {}
    for joint in joints:
        ends = {}
        for tag in ("parent", "child"):
            ends[tag] = end_of(joint, tag)
            if ends[tag] not in names:
                raise joint.refuse(f"{tag} is {quoted(ends[tag], 80)}, expected the name of a <link>")
        if ends["child"] in holder:
            raise joint.refuse(
                f"child {quoted(ends['child'], 80)} already hangs on joint "
                f"{quoted(holder[ends['child']].attributes['name'], 80)} (line {holder[ends['child']].line}); expected a tree"
            )
        holder[ends["child"]] = joint
    roots = [name for name in names if name not in holder]
    if not roots:
        raise joints[0].refuse("the joints go round in a circle, expected a tree with one root")
    if len(roots) > 1:
        shown = ", ".join(f"{quoted(name, 60)} (line {names[name].line})" for name in roots[:4])
        raise names[roots[1]].refuse(f"{len(roots)} links hang on no joint: {shown}; expected one root")
    order = parents_first({child: end_of(joint, "parent") for child, joint in holder.items()}, roots)
    if lost := [name for name in names if name not in set(order)] if len(order) < len(names) else []:
        raise names[lost[0]].refuse(f"hangs in a circle of joints with {len(lost) - 1} other links; expected a tree")
    return order


def end_of(joint: Element, tag: str) -> str:
    """The link that a joint names as its 'parent' or 'child'."""
    end = joint.first(tag)
    assert end is not None
    return end.attributes["link"]
