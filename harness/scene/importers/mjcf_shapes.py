"""MJCF's geoms as shapes: primitives as they are, meshes as the convex hulls that MuJoCo collides."""

from collections.abc import Mapping

import numpy as np

from plumbline.harness.intake.error import RobotError
from plumbline.harness.scene import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Plane, Shape, Sphere
from plumbline.harness.scene.importers.decomposition import ELEMENT as ELLIPSOIDS
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.meshes import coarser, hull_of, simplified
from plumbline.harness.scene.importers.mjcf_model import Model
from plumbline.harness.scene.importers.poses import Pose, pose
from plumbline.harness.scene.importers.robot import Geometry, Look, Need


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
