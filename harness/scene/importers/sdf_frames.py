"""Where things are in an SDF model: frames by name, each told in another one, as the specification's pose semantics have it.

A pose without `relative_to` is told in the model, of a joint in its child, of what belongs to a link in that link; a frame that
is attached to something moves with it. Source: Open Robotics, SDFormat, "Pose frame semantics" (1.7 and later).
"""

import math
from dataclasses import dataclass, field

import numpy as np

from plumbline.harness.intake.error import listed
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene.importers.poses import IDENTITY, Pose, pose, rolled
from plumbline.harness.scene.importers.sdf_grammar import numbers, word
from plumbline.harness.scene.importers.xml_text import Element

ITSELF = "__model__"


@dataclass(slots=True, eq=False)
class Scope:
    """The frames of a model. Terms: prefix: of its names in those around it. models: nested ones, by name."""

    model: Element
    prefix: str
    named: dict[str, Element] = field(default_factory=dict)
    models: "dict[str, Scope]" = field(default_factory=dict)
    poses: dict[str, Pose] = field(default_factory=dict)
    open: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, model: Element, prefix: str = "") -> "Scope":
        """The frames of a model and of those nested in it. Raises: RobotError, where a name stands twice."""
        scope = cls(model, prefix)
        for child in model.children:
            if child.tag not in ("link", "joint", "frame", "model"):
                continue
            name = child.attributes.get("name", "")
            if not name or "::" in name or name in (ITSELF, "world"):
                raise child.refuse(f"name is {quoted(name, 80)}, expected one that is not reserved, without '::'")
            if name in scope.named:
                raise child.refuse(f"name stands in line {scope.named[name].line} too, expected each once")
            scope.named[name] = child
            if child.tag == "model":
                scope.models[name] = cls.of(child, f"{prefix}{name}::")
        return scope

    def pose_of(self, name: str, asker: Element) -> Pose:
        """The pose of a frame in the model. Args: asker: the element that names it. Raises: RobotError."""
        if name == ITSELF:
            return IDENTITY
        if name == "world":
            raise asker.refuse("a pose in 'world' is not read inside of a model, expected a frame of the model")
        if name not in self.poses:
            if name in self.open:
                raise asker.refuse(f"frames {listed(self.open)} are told in each other, expected an end to that")
            self.open.append(name)
            self.poses[name] = self._pose_of(name, asker)
            self.open.pop()
        return self.poses[name]

    def _pose_of(self, name: str, asker: Element) -> Pose:
        head, colons, rest = name.partition("::")
        element = self._element(head, asker)
        if element.tag == "model":
            inner = self.models[head]
            own = self.placed(element, ITSELF)
            anchor = element.attributes.get("placement_frame")
            if anchor is not None:
                own = own @ inner.pose_of(anchor, element).inverse()
            return own @ inner.pose_of(rest, asker) if colons else own
        if colons:
            raise asker.refuse(f"{quoted(name, 80)} is no frame of the model, expected one")
        if element.tag == "joint":
            return self.placed(element, word(element, "child"))
        return self.placed(element, element.attributes.get("attached_to") or ITSELF if element.tag == "frame" else ITSELF)

    def _element(self, name: str, asker: Element) -> Element:
        if name not in self.named:
            frames = listed(list(self.named), 12)
            raise asker.refuse(f"{quoted(name, 80)} is no frame of the model, expected one of {frames}")
        return self.named[name]

    def placed(self, element: Element, default: str) -> Pose:
        """The pose in the model that an element's <pose> states. Args: default: what it is told in unless it says so."""
        stated = element.first("pose")
        base = default
        if stated is not None:
            base = stated.attributes.get("relative_to") or stated.attributes.get("frame") or default
        return self.pose_of(base, stated or element) @ (IDENTITY if stated is None else _stated(stated))

    def link_of(self, name: str, asker: Element) -> str:
        """The full name of the link that a frame is attached to; 'world' for the world. Raises: RobotError."""
        if name == "world":
            return name
        if self.prefix and name == ITSELF:
            return self.prefix + self.canonical(asker)
        seen = [name]
        while True:
            head, colons, rest = name.partition("::")
            if name == ITSELF:
                return self.prefix + self.canonical(asker)
            element = self._element(head, asker)
            if element.tag == "model":
                inner = self.models[head]
                return inner.link_of(rest if colons else ITSELF, asker)
            if element.tag == "link":
                return self.prefix + name
            name = word(element, "child") if element.tag == "joint" else element.attributes.get("attached_to") or ITSELF
            if name in seen:
                raise asker.refuse(f"frames {listed(seen)} are attached to each other, expected an end to that")
            seen.append(name)

    def canonical(self, asker: Element) -> str:
        """The link that stands for the model: the one that it names, else the first; of a model of models the first one's."""
        stated = self.model.attributes.get("canonical_link")
        if stated is not None:
            return self.link_of(stated, asker).removeprefix(self.prefix)
        for child in self.model.children:
            if child.tag == "link":
                return child.attributes["name"]
        for name, inner in self.models.items():
            return f"{name}::{inner.canonical(asker)}"
        raise self.model.refuse("has no <link>, expected at least one")


def _stated(element: Element) -> Pose:
    """The pose that an element says. Raises: RobotError."""
    form = element.attributes.get("rotation_format", "euler_rpy")
    if not element.text.strip():
        return IDENTITY
    if form == "quat_xyzw":
        values = numbers(element, counts=(7,)) or ()
        x, y, z, w = values[3:]
        if not math.hypot(x, y, z, w) > 1e-9:
            raise element.refuse("has a quaternion of length 0, expected a rotation")
        stated_pose = pose((values[0], values[1], values[2]), (w, x, y, z))
    elif form == "euler_rpy":
        values = numbers(element, counts=(6,)) or ()
        angles = np.radians(values[3:]) if element.attributes.get("degrees", "").lower() in ("true", "1") else values[3:]
        stated_pose = Pose(rolled(angles), np.array(values[:3]) + 0.0)
    else:
        raise element.refuse(f"rotation_format is {quoted(form, 40)}, expected euler_rpy or quat_xyzw")
    if not np.isfinite(stated_pose.p).all() or not np.isfinite(stated_pose.R).all():
        raise element.refuse("is not finite, expected finite numbers")
    return stated_pose
