"""MJCF's geoms as shapes: primitives as they are, meshes as the convex hulls that MuJoCo collides.

MJCF's contact filtering by bit masks, and friction per geom, as laws per pair of contact keys.

Two geoms touch where the type of one and the affinity of the other share a bit. Their friction is the larger one, number by
number, or that of the geom of higher priority; whether they slide, twist and roll follows the larger dimension likewise.
Source: MuJoCo, "Computation", collision detection; "Modeling", contact parameters.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from plumbline.harness.intake.error import RobotError
from plumbline.harness.scene import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Plane, Shape, Sphere, Surface
from plumbline.harness.scene.importers.decomposition import ELEMENT as ELLIPSOIDS
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.meshes import coarser, hull_of, simplified
from plumbline.harness.scene.importers.mjcf_model import Model
from plumbline.harness.scene.importers.poses import Pose, pose
from plumbline.harness.scene.importers.robot import ContactRules, Geometry, Look, Need


def geometries(model: Model, keys: Mapping[int, str], rows: list[Fidelity], needs: list[Need]) -> dict[int, list[Geometry]]:
    """The shapes by body. Args: keys: the contact key of each geom that collides; rows, needs: are added to."""
    made: dict[int, list[Geometry]] = {}
    exact, hulls, rounds, strange = 0, [], [], []
    off: dict[str, float] = {}
    for k, key in keys.items():
        word, name = model.word("Geom", int(model.geom_type[k])), model.name("geom", k)
        body = int(model.geom_bodyid[k])
        X = pose(model.geom_pos[k], model.geom_quat[k])
        size = tuple(float(x) for x in model.geom_size[k])
        if word in ("hfield", "sdf"):
            strange.append(name)
            continue
        shape = _shape(model, k, word, size, name)
        if isinstance(shape, ConvexHull):
            hulls.append(name)
            shape, far = simplified(shape)
            if far > 0:
                off[name] = far
        elif word == "ellipsoid":
            rounds.append(name)
        else:
            exact += 1
        made.setdefault(body, []).append(Geometry(shape, Pose(X.R, X.p), key))
    if exact:
        rows += Fidelity.exact("geom", "primitives", "shapes", count=exact)
    rows += Fidelity.told("mesh as its hull", hulls)
    rows += coarser(off)
    rows += Fidelity.exact(
        ELLIPSOIDS,
        rounds,
        "ellipsoid",
        consequence="Bullet has none, DART on planes, boxes and cylinders alone; the companion makes hulls of them by "
        "ellipsoids = 'polyhedra'",
    )
    needs += Need.of("height_field", "geom", strange)
    return made


def drawn(model: Model, colliding: Mapping[int, str]) -> dict[int, list[Geometry]]:
    """By body, the shapes that touch nothing and can be drawn."""
    made: dict[int, list[Geometry]] = {}
    for k in range(len(model.geom_type)):
        word = model.word("Geom", int(model.geom_type[k]))
        if k not in colliding and word in ("sphere", "capsule", "cylinder", "box", "ellipsoid"):
            shape = _shape(model, k, word, tuple(float(x) for x in model.geom_size[k]), model.name("geom", k))
            made.setdefault(int(model.geom_bodyid[k]), []).append(Geometry(shape, pose(model.geom_pos[k], model.geom_quat[k])))
    return made


def looks(model: Model, colliding: Mapping[int, str]) -> dict[int, list[Look]]:
    """By body, what is drawn of it where meshes that touch nothing say how it looks; none where no geom is such a mesh."""
    made: dict[int, list[Look]] = {}
    meshed: set[int] = set()
    for k in range(len(model.geom_type)):
        word, body = model.word("Geom", int(model.geom_type[k])), int(model.geom_bodyid[k])
        if k in colliding or word not in ("sphere", "capsule", "cylinder", "box", "ellipsoid", "mesh"):
            continue
        X, colour = pose(model.geom_pos[k], model.geom_quat[k]), _colour(model, k)
        if word != "mesh":
            shape = _shape(model, k, word, tuple(float(x) for x in model.geom_size[k]), model.name("geom", k))
            made.setdefault(body, []).append(Look(X_LG=X, shape=shape, colour=colour))
            continue
        meshed.add(body)
        mesh = int(model.geom_dataid[k])
        first, faces = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
        made.setdefault(body, []).append(
            Look(
                X_LG=X,
                vertices=model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])].astype(np.float64),
                faces=model.mesh_face[faces : faces + int(model.mesh_facenum[mesh])].astype(np.int64),
                where=f"<geom> {model.name('geom', k)!r}",
                colour=colour,
            )
        )
    return {body: visuals for body, visuals in made.items() if body in meshed}


def _colour(model: Model, k: int) -> tuple[float, float, float]:
    """Of a geom's material, where it has one, else its own."""
    material = int(model.geom_matid[k])
    red, green, blue, _ = (float(c) for c in (model.mat_rgba[material] if material >= 0 else model.geom_rgba[k]))
    return red, green, blue


def _shape(model: Model, k: int, word: str, size: tuple[float, ...], name: str) -> Shape:
    """The shape of a geom."""
    match word:
        case "sphere":
            return Sphere(radius=size[0])
        case "capsule":
            return Capsule(radius=size[0], half_length=size[1])
        case "cylinder":
            return Cylinder(radius=size[0], half_length=size[1])
        case "box":
            return Box(half_extents=(size[0], size[1], size[2]))
        case "plane":
            return Plane()
        case "ellipsoid":
            return Ellipsoid(semi_axes=(size[0], size[1], size[2]))
        case "mesh":
            mesh = int(model.geom_dataid[k])
            first = int(model.mesh_vertadr[mesh])
            vertices = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])].astype(np.float64)
            return hull_of(vertices, f"<geom> {name!r}")[0]
        case _:
            raise RobotError(f"<geom> {name!r}: type {word}, which is no shape of a scene")


@dataclass(frozen=True, slots=True)
class _Sort:
    """What tells geoms apart for contacts. Terms: alone: the geom's own place, where a <pair> names it; -1 elsewhere."""

    contype: int
    conaffinity: int
    condim: int
    priority: int
    friction: tuple[float, float, float]
    alone: int


def contact_laws(model: Model, names: list[str]) -> tuple[dict[int, str], ContactRules, list[Fidelity]]:
    """The contact key of each geom that can touch, the laws between keys, what is said of contacts. Args: names of bodies."""
    count = len(model.geom_type)
    if model.flag("contact") or model.flag("constraint"):
        rows = Fidelity.exact("geom", "", count=count, consequence="the file switches contacts off")
        return {}, ContactRules(), rows
    paired = {int(k) for k in (*model.pair_geom1, *model.pair_geom2)}
    sorts: dict[int, _Sort] = {}
    for k in range(count):
        if model.geom_contype[k] or model.geom_conaffinity[k] or k in paired:
            sorts[k] = _Sort(
                int(model.geom_contype[k]),
                int(model.geom_conaffinity[k]),
                int(model.geom_condim[k]),
                int(model.geom_priority[k]),
                (float(model.geom_friction[k][0]), float(model.geom_friction[k][1]), float(model.geom_friction[k][2])),
                k if k in paired else -1,
            )
    keys = {
        sort: ("robot" if number == 0 else f"robot_{number + 1}") for number, sort in enumerate(dict.fromkeys(sorts.values()))
    }
    laws = {frozenset((keys[a], keys[b])): law for a, b in combinations_with_replacement(keys, 2) if (law := _law(a, b, keys))}
    paired_laws = _pairs(model, sorts, keys)
    laws |= paired_laws
    contacts = ContactRules(
        laws=tuple(laws.values()),
        excluded=tuple((names[int(s) >> 16], names[int(s) & 0xFFFF]) for s in model.exclude_signature),
        paired=frozenset(paired_laws),
    )
    return {k: keys[sort] for k, sort in sorts.items()}, contacts, _rows(model, sorts, count)


def _law(a: _Sort, b: _Sort, keys: dict[_Sort, str]) -> Surface | None:
    if not (a.contype & b.conaffinity or b.contype & a.conaffinity):
        return None
    if a.priority != b.priority:
        chosen = a if a.priority > b.priority else b
        friction, dimension = chosen.friction, chosen.condim
    else:
        friction = (max(a.friction[0], b.friction[0]), max(a.friction[1], b.friction[1]), max(a.friction[2], b.friction[2]))
        dimension = max(a.condim, b.condim)
    return _surface((keys[a], keys[b]), friction, dimension)


def _surface(between: tuple[str, str], friction: tuple[float, float, float], dimension: int) -> Surface:
    slide, twist, roll = friction
    slides = slide if dimension >= 3 else 0.0
    return Surface(
        between=between,
        static_friction=slides,
        kinetic_friction=slides,
        torsional_friction=twist if dimension >= 4 else 0.0,
        rolling_friction=roll if dimension >= 6 else 0.0,
    )


def _pairs(model: Model, sorts: dict[int, _Sort], keys: dict[_Sort, str]) -> dict[frozenset[str], Surface]:
    """The laws of <pair>, which hold whatever the masks say."""
    surfaces = {}
    for k in range(len(model.pair_geom1)):
        a, b = keys[sorts[int(model.pair_geom1[k])]], keys[sorts[int(model.pair_geom2[k])]]
        mu = model.pair_friction[k]
        friction = (float(mu[0]), float(mu[2]), float(mu[3]))
        surfaces[frozenset((a, b))] = _surface((a, b), friction, int(model.pair_dim[k]))
    return surfaces


def _rows(model: Model, sorts: dict[int, _Sort], count: int) -> list[Fidelity]:
    rows, colliding = list[Fidelity](), len(sorts)
    masks = {(sort.contype, sort.conaffinity) for sort in sorts.values()}
    choosy = {(t, a) for t, a in masks if not all(t & affinity or contype & a for contype, affinity in masks)}
    masked = [model.name("geom", k) for k, sort in sorts.items() if (sort.contype, sort.conaffinity) in choosy]
    rows += Fidelity.exact("contype, conaffinity", masked, "materials, of which some pairs never touch")
    if count > colliding:
        rows += Fidelity.told("geom of no contact", "of no contact", count=count - colliding)
    if colliding:
        rows += Fidelity.left_out("solref, solimp", "", "how soft a contact is and how fast it rebounds is each engine's own")
    away = [model.name("geom", k) for k in np.flatnonzero((model.geom_margin != 0) | (model.geom_gap != 0))]
    if away:
        rows += Fidelity.told("margin", away, float(np.abs(model.geom_margin).max()))
    return rows
