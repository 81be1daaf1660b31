"""Shapes of a scene as rerun draws them, gathered into batches that share one pose column."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbline.harness.trajectory.kinematics import product
from plumbline.reports.recordings.layout import Floats, Rgba, part

if TYPE_CHECKING:
    import rerun as rr

OVERLAID = "TransparentFillMajorWireframe"
"""How shapes are filled where several engines share a place, and where a solid would hide the arrows of its contacts."""

CROWD = 24
"""With more bodies at rest than this, bodies of one kind of shape share a path: a viewer lists and draws hundreds of paths
slowly."""

MESHES = ("convex_hull", "triangle_mesh")


@dataclass(frozen=True)
class ShapeBatch:
    """Shapes of one kind that are logged together.

    Terms:
        path: below the run. kind: of the shapes. bodies (n,): places in the scene. names: of the bodies. shapes: as in a scene
        file. p_BS (n, 3) m, q_BS (n, 4).
    """

    path: str
    kind: str
    bodies: Floats
    names: tuple[str, ...]
    shapes: tuple[Mapping[str, Any], ...]
    p_BS: Floats
    q_BS: Floats

    @cached_property
    def centred(self) -> bool:
        """Is every shape's frame that of its body?"""
        return not self.p_BS.any() and bool((self.q_BS == (1.0, 0.0, 0.0, 0.0)).all())


@dataclass(frozen=True, slots=True)
class Paint:
    """How shapes are drawn.

    Terms:
        colour: red, green, blue, opacity, 0..255. extent: half the side [m] that an unbounded plane is drawn with.
        fill: rerun's fill mode; None leaves it to the view.
    """

    colour: Rgba
    extent: float
    fill: str | None = None


def placed_shapes(body: Mapping[str, Any]) -> list[dict[str, Any]]:
    """What is drawn of a body: its visual shapes, its collision shapes where it has none."""
    visual = body.get("visual")
    shapes: list[dict[str, Any]] = body.get("collision", []) if visual is None else visual
    return shapes


def batches(bodies: Sequence[Mapping[str, Any]], places: Sequence[int], most: int = CROWD) -> list[ShapeBatch]:
    """The shapes of the bodies at these places, one path a body, or one a kind of shape where there are more than `most`.

    A mesh is one path, of which an instance is a copy: where bodies share paths, those that are alike share that of the first.
    """
    crowd = len(places) > most
    meshes: list[tuple[Mapping[str, Any], str]] = []
    gathered: dict[str, list[tuple[int, str, Mapping[str, Any]]]] = {}
    for index in places:
        body = bodies[index]
        placed = placed_shapes(body)
        kinds = {p["shape"]["type"] for p in placed}
        for number, p in enumerate(placed):
            kind = p["shape"]["type"]
            path = kind if crowd else part(body["name"])
            if kind in MESHES and (crowd or len(placed) > 1):
                path = f"{part(body['name'])}/{kind}_{number}"
                if crowd:
                    path = next((there for shape, there in meshes if shape == p["shape"]), path)
                    meshes.append((p["shape"], path))
            elif not crowd and len(kinds) > 1:
                path = f"{path}/{kind}"
            gathered.setdefault(path, []).append((index, body["name"], p))
    return [
        ShapeBatch(
            path=path,
            kind=members[0][2]["shape"]["type"],
            bodies=np.array([index for index, _, _ in members], dtype=np.int64),
            names=tuple(name for _, name, _ in members),
            shapes=tuple(p["shape"] for _, _, p in members),
            p_BS=np.array([p.get("p_BS", (0.0, 0.0, 0.0)) for _, _, p in members], dtype=np.float64),
            q_BS=np.array([frame(p) for _, _, p in members]),
        )
        for path, members in gathered.items()
    ]


def upright_to(normal: Sequence[float]) -> Floats:
    """The quaternion that turns +z into a unit normal."""
    n = np.asarray(normal, dtype=np.float64)
    if n[2] < -1 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    q = np.array([1.0 + n[2], -n[1], n[0], 0.0])
    return np.asarray(q / np.linalg.norm(q))


def frame(placed: Mapping[str, Any]) -> Floats:
    """How a placed shape is turned in its body; a plane is drawn with +z along its normal."""
    q_BS = np.asarray(placed.get("q_BS", (1.0, 0.0, 0.0, 0.0)), dtype=np.float64)
    shape = placed["shape"]
    return product(q_BS, upright_to(shape.get("normal", (0.0, 0.0, 1.0)))) if shape["type"] == "plane" else q_BS


def facets(shape: Mapping[str, Any]) -> tuple[Floats, Floats]:
    """Vertices and triangles of a hull or mesh, every facet with vertices of its own so that edges are seen."""
    vertices = np.asarray(shape["vertices"], dtype=np.float64)
    if shape["type"] == "triangle_mesh":
        faces = np.asarray(shape["faces"], dtype=np.int64)
    else:
        from scipy.spatial import ConvexHull  # late: only hulls need it

        hull = ConvexHull(vertices)
        faces = hull.simplices.astype(np.int64)
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        inward = np.sum(np.cross(b - a, c - a) * hull.equations[:, :3], axis=1) < 0
        faces[inward] = faces[inward][:, ::-1]
    corners = vertices[faces].reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(-1, 3)


def drawn(batch: ShapeBatch, paint: Paint) -> "list[rr.AsComponents]":
    """The shapes of a batch without their poses."""
    import rerun as rr

    shown: dict[str, Any] = {"colors": [paint.colour], "labels": list(batch.names), "show_labels": False}
    if paint.fill is not None:
        shown["fill_mode"] = paint.fill
    shapes = batch.shapes
    match batch.kind:
        case "sphere":
            return [rr.Ellipsoids3D(half_sizes=[[s["radius"]] * 3 for s in shapes], **shown)]
        case "ellipsoid":
            return [rr.Ellipsoids3D(half_sizes=[s["semi_axes"] for s in shapes], **shown)]
        case "box":
            return [rr.Boxes3D(half_sizes=[s["half_extents"] for s in shapes], **shown)]
        case "cylinder":
            lengths = [2 * s["half_length"] for s in shapes]
            return [rr.Cylinders3D(lengths=lengths, radii=[s["radius"] for s in shapes], **shown)]
        case "capsule":
            # rerun's capsule starts at its origin, ours is centred there.
            lengths, start = [2 * s["half_length"] for s in shapes], [[0.0, 0.0, -s["half_length"]] for s in shapes]
            return [rr.Capsules3D(lengths=lengths, radii=[s["radius"] for s in shapes], translations=start, **shown)]
        case "plane":
            # Its top lies in the plane; the way that the normal is turned is part of the pose (`frame`).
            thickness = paint.extent / 400
            half, middle = [[paint.extent, paint.extent, thickness]] * len(shapes), [[0.0, 0.0, -thickness]] * len(shapes)
            return [rr.Boxes3D(half_sizes=half, centers=middle, **shown)]
        case "convex_hull" | "triangle_mesh":
            corners, triangles = facets(shapes[0])
            return [rr.Mesh3D(vertex_positions=corners, triangle_indices=triangles, albedo_factor=paint.colour)]
        case _:
            raise ValueError(f"shape '{batch.kind}' of body '{batch.names[0]}': no way to draw it")
