"""The words of SDF that say how a robot moves, those that say nothing of that, and values as texts of elements.

Source: Open Robotics, SDFormat Specification 1.6 to 1.11.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from plumbline.harness.intake.near_miss import misspelt
from plumbline.harness.intake.safe_text import quoted, readable
from plumbline.harness.intake.typed_fields import wrong_size
from plumbline.harness.scene.importers.xml_text import Element

SMALLEST, FARTHEST = 1e-9, 1e6
"""Of shapes [m]: beyond them volumes and moments have no digits left."""
VERSIONS = ("1.6", "1.7", "1.8", "1.9", "1.10", "1.11")


@dataclass(frozen=True, slots=True)
class _ElementWords:
    """What an element may say. Terms: moves: elements that say how a robot moves; still: that do not. words: attributes."""

    moves: tuple[str, ...] = ()
    still: tuple[str, ...] = ()
    words: tuple[str, ...] = ()


def _form(moves: str = "", still: str = "", words: str = "") -> _ElementWords:
    return _ElementWords(tuple(moves.split()), tuple(still.split()), tuple(words.split()))


_FORMS: Mapping[str, _ElementWords] = MappingProxyType(
    {
        "world": _form(
            "model gravity include joint frame",
            "physics light scene plugin gui atmosphere magnetic_field wind audio state spherical_coordinates road population "
            "actor",
        ),
        "model": _form(
            "link joint model frame pose static self_collide include",
            "plugin allow_auto_disable enable_wind gripper",
            "name canonical_link placement_frame",
        ),
        "link": _form(
            "inertial collision pose sensor gravity kinematic velocity_decay self_collide",
            "visual light must_be_base_link enable_wind battery projector audio_source audio_sink particle_emitter plugin",
            "name",
        ),
        "inertial": _form("mass pose inertia density fluid_added_mass", words="auto"),
        "inertia": _form("ixx ixy ixz iyy iyz izz"),
        "collision": _form("geometry pose surface density", "laser_retro max_contacts", "name"),
        "geometry": _form("box sphere cylinder capsule ellipsoid mesh plane heightmap polyline image cone"),
        "box": _form("size"),
        "sphere": _form("radius"),
        "cylinder": _form("radius length"),
        "capsule": _form("radius length"),
        "ellipsoid": _form("radii"),
        "mesh": _form("uri scale submesh", "convex_decomposition"),
        "plane": _form("normal size"),
        "joint": _form(
            "parent child axis axis2 pose gearbox_ratio thread_pitch screw_thread_pitch", "physics sensor plugin", "name type"
        ),
        "axis": _form("xyz limit dynamics mimic use_parent_model_frame initial_position"),
        "limit": _form("lower upper effort velocity stiffness dissipation"),
        "dynamics": _form("damping friction spring_reference spring_stiffness"),
        "mimic": _form("multiplier offset reference", words="joint axis"),
        "frame": _form("pose", words="name attached_to"),
        "pose": _form(words="relative_to degrees rotation_format frame"),
        "xyz": _form(words="expressed_in"),
    }
)
_NO_PART = {
    "plugin": "plug-ins are not read",
    "physics": "settings of engines are not read",
    "visual": "the collision shapes are drawn",
}


@dataclass(frozen=True, slots=True)
class SdfLeft:
    """What was left behind. Terms: of_sdf: owners by the element's word, of SDF's own. unknown: owners by the word."""

    of_sdf: dict[str, list[str]] = field(default_factory=dict)
    unknown: dict[str, list[str]] = field(default_factory=dict)


def check(element: Element, left: SdfLeft, *, strict: bool) -> None:
    """Look through an element and all below it that is read.

    Raises: RobotError, for what stands twice, and for what may be a slip of the pen, or for all that SDF does not have.
    """
    form = _FORMS.get(element.tag, _ElementWords())
    name = readable(element.attributes.get("name", ""), 80) or f"line {element.line}"
    for word in element.attributes:
        if form.words and word not in form.words and ":" not in word:
            label = f"{word} of <{element.tag}>"
            _left_or_refused(element, f"attribute {quoted(word, 60)}", word, form.words, left, label, name, strict)
    if not form.moves:
        return
    for child in element.children:
        if child.tag in form.moves:
            check(child, left, strict=strict)
        elif child.tag in form.still:
            left.of_sdf.setdefault(child.tag, []).append(name)
        elif ":" in child.tag:
            left.unknown.setdefault(f"<{child.tag}> in <{element.tag}>", []).append(name)
        else:
            _left_or_refused(child, "it", child.tag, form.moves, left, f"<{child.tag}> in <{element.tag}>", name, strict)


def _left_or_refused(
    element: Element, what: str, word: str, words: tuple[str, ...], left: SdfLeft, label: str, owner: str, strict: bool
) -> None:
    near = misspelt(word, words)
    if strict or near:
        hint = f"; did you mean {near}?" if near else ""
        raise element.refuse(f"{what} is no word of SDF here, expected one of {', '.join(words)}{hint}")
    left.unknown.setdefault(label, []).append(owner)


def why(word: str) -> str:
    """Why an element is left out."""
    return _NO_PART.get(word, "no part of the motion of the links")


def numbers(
    element: Element, tag: str = "", counts: tuple[int, ...] = (1,), *, infinite: bool = False
) -> tuple[float, ...] | None:
    """The numbers that a child says, or the element itself; None where there is no such child.

    Args: infinite: may they be? Raises: RobotError.
    """
    stated = element.first(tag) if tag else element
    if stated is None:
        return None
    words = stated.text.split()
    try:
        values = tuple(map(float, words)) if len(stated.text) < 1000 and "_" not in stated.text else ()
    except ValueError:
        values = ()
    if len(values) not in counts or any(map(math.isnan, values)) or not (infinite or all(map(math.isfinite, values))):
        expected = " or ".join(str(count) for count in counts)
        what = "" if infinite else "finite "
        raise stated.refuse(f"is {quoted(stated.text.strip(), 80)}, expected {expected} {what}number{'s' * (counts != (1,))}")
    if wrong := next(filter(None, map(wrong_size, filter(math.isfinite, values))), ""):
        raise stated.refuse(f"is {quoted(stated.text.strip(), 80)}, {wrong}")
    return values


def number(element: Element | None, tag: str, default: float) -> float:
    """A number that a child says, or the default. Raises: RobotError."""
    value = None if element is None else numbers(element, tag)
    return default if value is None else value[0]


def lengths(element: Element, tag: str, default: tuple[float, ...] = ()) -> tuple[float, ...]:
    """As many lengths [m] as the default has; without a default one, which a child has to say. Raises: RobotError."""
    values = numbers(element, tag, (len(default) or 1,))
    if values is None and not default:
        raise element.refuse(f"has no <{tag}>, expected one")
    values = values or default
    if not all(SMALLEST <= value <= FARTHEST for value in values):
        values_stated = ", ".join(f"{value:g}" for value in values)
        raise element.refuse(f"<{tag}> is {values_stated}, expected {SMALLEST:g} to {FARTHEST:g} m")
    return values


def flag(element: Element, tag: str, default: bool = False) -> bool:
    """Whether a child says true. Raises: RobotError."""
    stated = element.first(tag)
    if stated is None:
        return default
    word = stated.text.strip().lower()
    if word not in ("true", "false", "1", "0"):
        raise stated.refuse(f"is {quoted(word, 80)}, expected true or false")
    return word in ("true", "1")


def word(element: Element, tag: str) -> str:
    """The text that a child has to say. Raises: RobotError."""
    stated = element.first(tag)
    if stated is None or not stated.text.strip():
        raise element.refuse(f"has no <{tag}>, expected one")
    return stated.text.strip()
