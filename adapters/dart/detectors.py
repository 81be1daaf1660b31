"""The collision detectors: the pairs of shapes that each has wrong, the one that suits a scene, what it is to leave out."""

from collections.abc import Mapping
from itertools import combinations, combinations_with_replacement

from plumbline.adapters.dart.built import Built
from plumbline.adapters.dart.surfaces import touching_bodies
from plumbline.harness.adapter import Notice, Unsupported
from plumbline.harness.scene import Effect, Scene

DETECTORS = ("fcl", "ode", "dart", "bullet")


def _pairs(*pairs: str) -> frozenset[str]:
    return frozenset("/".join(sorted(pair.split("/"))) for pair in pairs)


SOLIDS = ("sphere", "box", "capsule", "cylinder", "convex_hull", "triangle_mesh")
MESHES = frozenset({"convex_hull", "triangle_mesh"})
ROUND = _pairs("box/capsule", "box/cylinder", "capsule/cylinder", "cylinder/cylinder")
ON_PLANES = _pairs("plane/box", "plane/capsule", "plane/cylinder")
NO_ELLIPSOID = _pairs(*(f"ellipsoid/{other}" for other in (*SOLIDS, "ellipsoid", "plane")))
WRONG_PAIRS: Mapping[str, frozenset[str]] = {
    "fcl": ON_PLANES
    | ROUND
    | _pairs("capsule/capsule", "capsule/sphere", "ellipsoid/capsule", "ellipsoid/sphere", "ellipsoid/ellipsoid"),
    "dart": ON_PLANES | ROUND | NO_ELLIPSOID,
    "ode": (ROUND - {"box/cylinder"}) | NO_ELLIPSOID,
    "bullet": _pairs("cylinder/convex_hull", "cylinder/triangle_mesh", "box/triangle_mesh") | NO_ELLIPSOID,
}
"""The pairs of shapes that each detector lets sink, rock or slide by another friction; hulls and meshes see `_wrong`.

Heights lost in 3 s at 1/240 s, of 0.1 m: capsule on a box by ODE all of it, on the end of a cylinder 42 mm, box or cylinder on
a lying cylinder or capsule by ODE 4 mm, cylinder on a box by FCL 97 mm and by DART's own detector 126 mm; cylinder lying on a
mesh by Bullet 10 mm and more, on a hull 19 mm, box on a mesh 3 mm.

An ellipsoid (.1, .2, .3 m), 1 mm deep at twenty attitudes: ODE makes a ball of 1 cm of it; for Bullet and DART's own detector
it is a polyhedron, whose depth errs by up to 9.8 mm with the one and which the other misses at twelve. By FCL depths are right
to 2e-7 m on planes, boxes and cylinders, its normal leaning by up to .02 rad on a box; against balls by up to .1 rad.
"""


def choose_detector(scene: Scene, asked: str | None, notices: list[Notice], swept: bool = False) -> str:
    """The detector of this scene: None is the vendor's default, 'auto' one that has every pair that can meet right.

    For sweeps without a matrix that is DART's own, if it has them right: balls in heaps of 10 to 60 then overlap by a seventh
    to a quarter of what ODE's contacts leave (0.25 mm for 1.7, 0.20 for 0.78, at 1/240 s).

    Raises: Unsupported.
    """
    meetings = _meetings(scene)
    if asked in DETECTORS:
        if wrong := _wrong(asked, meetings):
            raise Unsupported(
                f"{', '.join(wrong)} with the '{asked}' detector",
                "it lets such pairs sink, rock or slide by another friction; expected 'auto' or another detector",
            )
        return asked
    if asked is None and not _wrong("fcl", meetings):
        return "fcl"
    first: tuple[str, ...] = ("dart",) if swept and asked == "auto" else ()
    right = next((name for name in (*first, "ode", "bullet", "fcl") if not _wrong(name, meetings)), None)
    if right is None:
        raise Unsupported(
            ", ".join(sorted({*_wrong("ode", meetings), *_wrong("bullet", meetings)})),
            "of these pairs DART's ODE detector has some wrong, Bullet's others and FCL some too; none has all right",
        )
    if asked is None:
        named = ", ".join(_wrong("fcl", meetings))
        notices.append(Notice(f"detector: FCL, the vendor's default, has {named} wrong; '{right}' stands in"))
    return right


def _meetings(scene: Scene) -> set[tuple[str, str, bool]]:
    """The pairs of shapes that can meet, each with its types in alphabetical order: and can both of them move?"""
    joined = scene.joined()
    apart = {frozenset(pair) for pair in scene.apart}
    groups: dict[tuple[str, bool, frozenset[str]], list[str]] = {}
    for body in touching_bodies(scene):
        types = frozenset(placed.shape.type for placed in body.collision)
        groups.setdefault((body.material, body.movable, types), []).append(body.name)
    meetings = set()
    for (one, ones), (other, others) in combinations_with_replacement(groups.items(), 2):
        if not (one[1] or other[1]) or frozenset((one[0], other[0])) in apart:
            continue
        if any(a != b and frozenset((a, b)) not in joined for a in ones for b in others):
            meetings |= {(min(a, b), max(a, b), one[1] and other[1]) for a in one[2] for b in other[2]}
    return meetings


def _wrong(detector: str, meetings: set[tuple[str, str, bool]]) -> list[str]:
    """The pairs among `meetings` that a detector has wrong, as 'box/capsule'."""
    wrong = set()
    for a, b, both in meetings:
        meshes = len(MESHES & {a, b}) if a != b else 2 * (a in MESHES)
        # Balls fall through meshes by FCL, hulls by DART's own detector; two that move push each other sideways by ODE.
        loose = meshes > 0 if detector in ("fcl", "dart") else detector == "ode" and both and meshes == 2
        if loose or f"{a}/{b}" in WRONG_PAIRS[detector]:
            wrong.add(f"{a}/{b}")
    return sorted(wrong)


def keep_apart(built: Built) -> None:
    """Keep joined bodies, and materials that are apart, from colliding."""
    scene = built.scene
    if Effect.CONTACT not in scene.effects or not (scene.joined() or scene.apart):
        return
    option = built.world.getConstraintSolver().getCollisionOption()
    solid = [(body, node) for body, node in zip(scene.bodies, built.nodes, strict=True) if body.collision]
    for (a, node_a), (b, node_b) in combinations(solid, 2):
        if (a.movable or b.movable) and not scene.collides(a, b):
            option.collisionFilter.addBodyNodePairToBlackList(node_a, node_b)
