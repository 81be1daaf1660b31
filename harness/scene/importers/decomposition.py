"""A mesh taken apart into convex pieces by CoACD, which is asked for once for each mesh and scale.

Source: Wei, Liu, Ling, Su, Approximate convex decomposition for 3D meshes with collision-aware concavity and tree search,
ACM Transactions on Graphics 41(4), 2022.
"""

import numpy as np

from harness.intake.refusal import RobotError
from harness.intake.safe_text import readable
from harness.scene import ConvexHull
from harness.scene.importers.meshes import Mesh, hull_of

__all__ = ["CONCAVITY", "pieces_of"]

CONCAVITY = 0.05
"""Below which a piece is not cut further, in CoACD's measure, relative to the mesh's size: its own default."""

SEARCH = {"mcts_iterations": 20, "mcts_nodes": 8, "mcts_max_depth": 1, "resolution": 500}
"""A shorter search for cuts than CoACD's own, which takes minutes for a robot of eight links; the error is measured anyhow."""


def pieces_of(mesh: Mesh, most: int, where: str) -> tuple[list[ConvexHull], float]:
    """At most `most` convex pieces of a mesh, and the sum of their volumes [m3], overlaps counted twice.

    Raises: RobotError, where CoACD is not installed or finds none.
    """
    try:
        import coacd
    except ImportError:
        raise RobotError(f"{where}: --convex needs CoACD: pip install plumbline[decomposition]") from None
    coacd.set_log_level("error")
    whole = coacd.Mesh(np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int32))
    try:
        pieces = coacd.run_coacd(whole, threshold=CONCAVITY, max_convex_hull=most, seed=0, **SEARCH)
    except Exception as error:  # a broken mesh may break it anywhere
        message = readable(f"{type(error).__name__}: {error}", 160)
        raise RobotError(f"{where}: CoACD cannot take the mesh apart ({message}); without --convex its hull is taken") from None
    made = [hull_of(np.asarray(points, np.float64), where) for points, _ in pieces]
    if not made:
        raise RobotError(f"{where}: CoACD finds no pieces; without --convex the mesh's hull is taken")
    return [shape for shape, _ in made], sum(volume for _, volume in made)
