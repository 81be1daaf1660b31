"""The text of an MJCF file made safe for its compiler: includes taken in, files read by us, nothing left that leads outside."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from xml.sax.saxutils import quoteattr

from plumbline.harness.intake.allowance import beyond
from plumbline.harness.intake.documents import named
from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.import_wishes import Drop
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.intake.typed_fields import wrong_size
from plumbline.harness.scene.importers.files import Folders, content, text_of
from plumbline.harness.scene.importers.meshes import too_many_faces
from plumbline.harness.scene.importers.xml_text import Element, elements

MESHES = (".stl", ".obj", ".msh")
_TEXTS = frozenset(("name", "class", "childclass", "dclass", "file", "content", "prefix", "model", "user", "data"))
"""Attributes in which 'nan' and 'inf' may be words."""
_REMOVED = {"texture": "pictures", "skin": "skins", "visual": "the look of the viewer", "statistic": "the view of the viewer"}
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_STRANGE = re.compile(r"[+-]?(?:nan|inf|infinity)", re.IGNORECASE)
_SUFFIX = re.compile(r"\.[A-Za-z0-9]{1,8}")


@dataclass(slots=True)
class Prepared:
    """Terms: text: of the model. assets: by flat names that are ours. lines: file and line of the original for each line of the
    text. removed: by tag, how many were left out. strange: names of what has no word in a scene, by what drops it."""

    text: str = ""
    assets: dict[str, bytes] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)
    removed: dict[str, int] = field(default_factory=dict)
    strange: dict[Drop, list[str]] = field(default_factory=dict)


def prepared(root: Element, folders: Folders) -> Prepared:
    """Check a model and all that it includes. Raises: RobotError."""
    if root.tag != "mujoco":
        raise root.refuse("is the root of the file, expected <mujoco> or <robot>")
    whole = _included(root, folders, {root.file}, [0])
    _check_classes(whole)
    made = Prepared()
    directories = _directories(whole)
    bodies = _Budget()
    pieces: list[str] = []
    _write(whole, made, folders, directories, bodies, pieces, 1)
    made.text = "".join(pieces)
    return made


def _check_classes(whole: Element) -> None:
    """The compiler does not say which class it misses. Raises: RobotError."""
    classes = {element.attributes.get("class", "main") for element in whole.walk() if element.tag == "default"} | {"main"}
    for element in whole.walk():
        name = element.attributes.get("childclass")
        if name is not None and name not in classes:
            hint = did_you_mean(name, classes)
            raise element.refuse(
                f"childclass is {quoted(name, 80)}, expected the class of a <default>: {listed(sorted(classes), 12)}{hint}"
            )


class _Budget:
    """How many bodies and meshes there are so far."""

    def __init__(self) -> None:
        self.bodies, self.meshes, self.joints = 0, 0, 0


def _included(element: Element, folders: Folders, seen: set[str], count: list[int]) -> Element:
    """The element with the content of included files in the place of <include>."""
    children: list[Element] = []
    for child in element.children:
        count[0] += 1
        if excess := beyond("parts", count[0], "elements, those of included files with them"):
            raise child.refuse(excess)
        if child.tag != "include":
            children.append(_included(child, folders, seen, count))
            continue
        reference = child.attributes.get("file", "")
        where = f"{child.where}: file"
        path = folders.found(reference, where)
        if path is None:
            raise RobotError(f"{where} is {quoted(reference)}: {folders.missing(reference)}; expected a file beside the model")
        if (name := named(path)) in seen:
            raise RobotError(f"{where} is {quoted(reference)}, which is included already; expected each file once")
        seen.add(name)
        inner = elements(text_of(path, where), name)
        if inner.tag not in ("mujocoinclude", "mujoco"):
            raise inner.refuse("is the root of an included file, expected <mujocoinclude>")
        children += _included(inner, folders, seen, count).children
    return Element(element.tag, element.attributes, element.file, element.line, children, element.text)


def _directories(root: Element) -> Mapping[str, str]:
    directories = {"assetdir": "", "meshdir": "", "strippath": "false"}
    for compiler in root.all("compiler"):
        directories |= {name: compiler.attributes[name] for name in directories if name in compiler.attributes}
    return directories


def _write(
    element: Element,
    made: Prepared,
    folders: Folders,
    directories: Mapping[str, str],
    budget: _Budget,
    pieces: list[str],
    times: int,
) -> None:
    """Write an element on a line of its own, so that what the compiler says of a line can be told of the original."""
    tag = element.tag
    if tag in _REMOVED:
        made.removed[tag] = made.removed.get(tag, 0) + 1
        return
    if _taken_out(element, made):
        return
    _check_numbers(element)
    times = _counted(element, budget, times)
    attributes = dict(element.attributes)
    if tag == "compiler":
        for name in ("assetdir", "meshdir", "texturedir", "strippath"):
            attributes.pop(name, None)
    if tag == "material":
        attributes.pop("texture", None)
    if "file" in attributes:
        attributes = _asset(element, attributes, made, folders, directories, budget)
    made.lines.append(element.where)
    pieces.append(f"<{tag}{''.join(f' {name}={quoteattr(value)}' for name, value in attributes.items())}>\n")
    for child in element.children:
        if not (tag == "material" and child.tag == "layer"):
            _write(child, made, folders, directories, budget, pieces, times)
    made.lines.append(element.where)
    pieces.append(f"</{tag}>\n")


def _taken_out(element: Element, made: Prepared) -> bool:
    """Is it one of those that a scene has no word for, and that would run code or make thousands of bodies?"""
    kind: dict[str, Drop] = {
        "composite": "flex",
        "flexcomp": "flex",
        "flex": "flex",
        "deformable": "flex",
        "plugin": "plugin",
        "extension": "plugin",
    }
    if element.tag == "attach" or (element.tag == "model" and "file" in element.attributes):
        raise element.refuse("a model in a model is not read; expected one model, put together beforehand")
    if element.tag in kind and (element.tag not in ("deformable", "extension") or element.children):
        made.strange.setdefault(kind[element.tag], []).append(element.attributes.get("name") or f"line {element.line}")
        return True
    return False


def _check_numbers(element: Element) -> None:
    for name, value in element.attributes.items():
        if name in _TEXTS:
            continue
        for word in value.split():
            if _STRANGE.fullmatch(word):
                raise element.refuse(f"{name} is {quoted(value)}, expected finite numbers")
            if _NUMBER.fullmatch(word) and (wrong := wrong_size(float(word))):
                raise element.refuse(f"{name} is {quoted(value)}, {wrong}")


def _counted(element: Element, budget: _Budget, times: int) -> int:
    """How many times what stands in the element will be there. Raises: RobotError, where it is too often."""
    if element.tag == "replicate":
        try:
            times *= max(1, int(element.attributes.get("count", "1")))
        except ValueError:
            raise element.refuse(f"count is {quoted(element.attributes['count'])}, expected a whole number") from None
        if excess := beyond("bodies", times, "copies"):
            raise element.refuse(excess)
    if element.tag in ("body", "geom", "site"):
        budget.bodies += times
        if excess := beyond("bodies", budget.bodies, "bodies, geoms and sites"):
            raise element.refuse(excess)
    if element.tag in ("joint", "freejoint"):
        budget.joints += times
        if excess := beyond("joints", budget.joints):
            raise element.refuse(excess)
    if element.tag == "hfield":
        cells = 1.0
        for name in ("nrow", "ncol"):
            try:
                cells *= float(element.attributes.get(name, "1"))
            except ValueError:
                raise element.refuse(f"{name} is {quoted(element.attributes[name])}, expected a whole number") from None
        if excess := beyond("vertices", cells, "heights"):
            raise element.refuse(excess)
    return times


def _asset(
    element: Element,
    attributes: dict[str, str],
    made: Prepared,
    folders: Folders,
    directories: Mapping[str, str],
    budget: _Budget,
) -> dict[str, str]:
    """The attributes with the file under a flat name of ours, its content among the assets. Raises: RobotError."""
    reference = attributes["file"]
    where = f"{element.where}: file"
    if element.tag not in ("mesh", "hfield"):
        raise RobotError(f"{where} is {quoted(reference)}: files of <{element.tag}> are not read, expected none")
    wanted = reference
    if directories["strippath"] == "true":
        wanted = re.split(r"[/\\]", reference)[-1]
    folder = directories["meshdir"] if element.tag == "mesh" else directories["assetdir"]
    base = folders.home / (folder or directories["assetdir"])
    path = folders.found(wanted, where, base)
    if path is None:
        raise RobotError(f"{where} is {quoted(reference)}: {folders.missing(wanted)}; mass may depend on it, expected a file")
    kind = path.suffix.lower()
    if kind not in (MESHES if element.tag == "mesh" else (".bin", ".hf")):
        raise RobotError(f"{where} is {quoted(reference)}, expected an ending among {', '.join(MESHES)}")
    raw = content(path, where, "meshes")
    if excess := too_many_faces(kind, raw):
        raise RobotError(f"{where}: {named(path)}: {excess}")
    budget.meshes += len(raw)
    if excess := beyond("meshes", budget.meshes, "bytes of all meshes"):
        raise RobotError(f"{where}: {excess}")
    name = f"asset{len(made.assets)}{kind}"
    made.assets[name] = raw
    attributes = {**attributes, "file": name}
    attributes.setdefault("name", _SUFFIX.sub("", re.split(r"[/\\]", reference)[-1]))
    attributes.pop("content_type", None)
    return attributes
