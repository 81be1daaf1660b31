"""A mesh taken apart into convex pieces by CoACD, which is asked for once for each mesh and scale, on this machine.

Source: Wei, Liu, Ling, Su, Approximate convex decomposition for 3D meshes with collision-aware concavity and tree search,
ACM Transactions on Graphics 41(4), 2022.
"""

import hashlib
import io
import json
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import readable
from plumbline.harness.intake.user_cache import cache_folder, keep, read_kept
from plumbline.harness.scene import ConvexHull
from plumbline.harness.scene.importers.meshes import Mesh, hull_of
from plumbline.harness.scene.importers.poses import Array

CONCAVITY = 0.05
"""Below which a piece is not cut further, in CoACD's measure, relative to the mesh's size: its own default."""

SEARCH = {"mcts_iterations": 20, "mcts_nodes": 8, "mcts_max_depth": 1, "resolution": 500}
"""A shorter search for cuts than CoACD's own, which takes minutes for a robot of eight links; the error is measured anyhow."""


def pieces_of(mesh: Mesh, most: int, where: str, tell: Callable[[str], object] | None) -> tuple[list[ConvexHull], float]:
    """At most `most` convex pieces of a mesh, and the sum of their volumes [m3], overlaps counted twice.

    Args: tell: is told, before a mesh is taken apart, that this takes its time; None where nobody listens.
    Raises: RobotError, where CoACD is not installed or finds none.
    """
    try:
        import coacd
    except ImportError:
        raise RobotError(f"{where}: --convex needs CoACD: pip install plumbline[decomposition]") from None
    kept = _place(mesh, most)
    points = _kept(kept)
    if points is None:
        if tell is not None:
            tell(f"{where}: {len(mesh.faces)} faces are taken apart into convex pieces, once on this machine")
        coacd.set_log_level("error")
        whole = coacd.Mesh(np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int32))
        try:
            pieces = coacd.run_coacd(whole, threshold=CONCAVITY, max_convex_hull=most, seed=0, **SEARCH)
        except Exception as error:  # a broken mesh may break it anywhere
            message = readable(f"{type(error).__name__}: {error}", 160)
            raise RobotError(
                f"{where}: CoACD cannot take the mesh apart ({message}); without --convex its hull is taken"
            ) from None
        points = [np.asarray(corners, np.float64) for corners, _ in pieces]
        _keep(kept, points)
    made = [hull_of(corners, where) for corners in points]
    if not made:
        raise RobotError(f"{where}: CoACD finds no pieces; without --convex the mesh's hull is taken")
    return [shape for shape, _ in made], sum(volume for _, volume in made)


def _place(mesh: Mesh, most: int) -> Path:
    """Where the pieces of a mesh are kept, by all that they depend on."""
    asked = {"coacd": version("coacd"), "most": most, "concavity": CONCAVITY, **SEARCH}
    digest = hashlib.sha256(json.dumps(asked, sort_keys=True).encode())
    for array in (mesh.vertices, mesh.faces):
        digest.update(repr((array.shape, array.dtype.str)).encode() + np.ascontiguousarray(array).tobytes())
    return cache_folder("pieces") / f"{digest.hexdigest()}.npz"


def _kept(place: Path) -> list[Array] | None:
    """The corners (n, 3) m of each piece that is kept; None where none are, or no such thing."""
    content = read_kept(place)
    if content is None:
        return None
    with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
        points = [np.asarray(arrays[name], np.float64) for name in sorted(arrays.files)]
    sound = all(corners.ndim == 2 and corners.shape[1] == 3 and np.isfinite(corners).all() for corners in points)
    return points if points and sound else None


def _keep(place: Path, points: Sequence[Array]) -> None:
    """Keep the pieces, all or nothing; where that cannot be done they are worked out again."""
    archive, arrays = io.BytesIO(), dict[str, Any]({f"{k:03}": corners for k, corners in enumerate(points)})
    np.savez(archive, allow_pickle=False, **arrays)
    keep(place, archive.getvalue())
