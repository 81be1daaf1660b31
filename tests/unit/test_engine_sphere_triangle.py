"""A sphere against a triangle: its contact is the closest point of the triangle, found here among faces, edges and corners."""

import numpy as np
import pytest

from plumbline import engine
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.arena import int_table

TRIANGLE = np.array([(0.0, 0.0, 0.0), (0.8, 0.1, 0.2), (0.2, 0.9, -0.1)])
R, MARGIN = 0.1, 0.05


def _closest(point: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Of the corners, of the feet on the edges and of the foot on the face, those that lie on them, the nearest one."""
    spots = [*corners]
    for k in range(3):
        a, e = corners[k], corners[(k + 1) % 3] - corners[k]
        share = (point - a) @ e / (e @ e)
        if 0 < share < 1:
            spots.append(a + share * e)
    shares = np.linalg.lstsq((corners[1:] - corners[0]).T, point - corners[0], rcond=None)[0]
    if shares.min() > 0 and shares.sum() < 1:
        spots.append(corners[0] + (corners[1:] - corners[0]).T @ shares)
    return min(spots, key=lambda spot: float(np.linalg.norm(spot - point)))


def _contacts(mesh: engine.TriangleMesh, centres: np.ndarray) -> dict[int, list[tuple[np.ndarray, np.ndarray, float]]]:
    """Points, normals from the ball and gaps [m] of each ball; none of them meets another, and nothing pulls."""
    bodies = [engine.Body(name="mesh", motion="static", shapes=[engine.Placed(mesh)])]
    bodies += [
        engine.Body(name=f"ball_{k}", material="ball", shapes=[engine.Placed(engine.Sphere(R))], p_WB=tuple(centre))
        for k, centre in enumerate(centres)
    ]
    options = engine.Options(dt=1e-9, margin=MARGIN)
    world = engine.World(bodies, apart=[("ball", "ball")], gravity=(0, 0, 0), options=options)
    world.step()
    found: dict[int, list[tuple[np.ndarray, np.ndarray, float]]] = {}
    contacts = world.contacts()
    for (a, b), spot, normal, gap in zip(contacts.bodies, contacts.point, contacts.normal, contacts.gap, strict=True):
        found.setdefault(max(a, b) - 1, []).append((spot, normal if b == 0 else -normal, gap))
    return found


def test_it_is_met_at_its_closest_point_from_outside_and_never_from_behind() -> None:
    centres = np.random.default_rng(0).uniform(-0.2, 1.0, (800, 3)) * (1, 1, 0.3)
    found = _contacts(engine.TriangleMesh(TRIANGLE.tolist(), [(0, 1, 2)]), centres)
    outward = np.cross(TRIANGLE[1] - TRIANGLE[0], TRIANGLE[2] - TRIANGLE[0])
    met = {"face": 0, "beside": 0}
    for k, centre in enumerate(centres):
        spot = _closest(centre, TRIANGLE)
        apart = np.linalg.norm(centre - spot)
        if apart - R > MARGIN or (centre - spot) @ outward < 0:
            assert k not in found
            continue
        ((place, normal, gap),) = found[k]
        assert gap == pytest.approx(apart - R, abs=1e-14)
        assert normal == pytest.approx((spot - centre) / apart, abs=1e-12)
        assert place == pytest.approx(centre + normal * (R + gap / 2), abs=1e-14)
        met["face" if np.linalg.norm(np.cross(spot - centre, outward)) < 1e-9 else "beside"] += 1
    assert min(met.values()) > 25


@pytest.mark.parametrize("fold", [0.0, 0.5, -0.5])
def test_the_edge_between_two_triangles_is_met_where_it_sticks_out_alone(fold: float) -> None:
    """Beside a flat seam, or one folded inwards, only the normals of the faces are met; over a ridge what lies between them."""
    corners = [(0, 0, 0), (1, 0, 0), (0.5, 1, -fold), (0.5, -1, -fold)]
    mesh = engine.TriangleMesh(corners, [(0, 1, 2), (1, 0, 3)])
    rng = np.random.default_rng(1)
    centres = np.column_stack([rng.uniform(0.2, 0.8, 200), rng.uniform(-0.05, 0.05, 200), rng.uniform(0.02, 0.1, 200)])
    found = _contacts(mesh, centres)
    faces = np.array([(0, -fold, -1), (0, fold, -1)]) / np.hypot(1, fold)
    of_edge = 0
    for contacts in found.values():
        for _, normal, _ in contacts:
            if np.abs(faces @ normal - 1).min() > 1e-9:
                of_edge += 1
                assert abs(normal[0]) < 1e-12
    assert len(found) > 150
    assert (of_edge > 25) == (fold > 0)


def test_a_centre_on_the_triangle_is_pushed_out_along_its_normal() -> None:
    """There the direction to the closest point is rounding."""
    ((place, normal, gap),) = _contacts(
        engine.TriangleMesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]), np.array([(0.2, 0.3, 0)])
    )[0]
    assert normal == pytest.approx((0, 0, -1), abs=1e-9)
    assert gap == pytest.approx(-R, abs=1e-9)
    assert place == pytest.approx((0.2, 0.3, -R / 2), abs=1e-9)


def _on_a_floor(rise: float, speed: float) -> tuple[engine.World, list[int], list[float]]:
    """A ball laid on a strip of triangles and pushed along it, for 1.5 m: new contacts and force upwards [N], step by step.

    Args: rise: by how much every second row of the strip's corners lies higher [m].
    """
    places = [(0.25 * i, y, rise * (i % 2)) for i in range(-2, 12) for y in (-0.6, 0.4)]
    faces = [face for k in range(0, len(places) - 2, 2) for face in ((k, k + 2, k + 1), (k + 1, k + 2, k + 3))]
    floor = engine.Body(name="floor", motion="static", shapes=[engine.Placed(engine.TriangleMesh(places, faces))])
    ball = engine.Body(
        name="ball", inertia=0.4 * R**2 * np.eye(3), shapes=[engine.Placed(engine.Sphere(R))],
        p_WB=(0.0513, 0.0, R + rise * 0.2), v_WB=(speed, 0.0, 0.0), w_WB=(0.0, speed / R, 0.0),
    )  # fmt: skip
    law = engine.Surface(static_friction=0.5, kinetic_friction=0.5)
    world = engine.World([floor, ball], [], {("default", "default"): law})
    new, force = [], []
    for _ in range(int(1.5 / speed * 240)):
        world.step(1)
        new.append(int(int_table(world._ints, at.COUNT)[0, at.NEW]))
        force.append(float(abs(world.contacts().force[:, 2].sum())))
    return world, new, force


def test_a_ball_goes_on_from_triangle_to_triangle_with_what_it_bore() -> None:
    """Twelve edges of a flat floor on its way are no blow: one new contact, and its weight of 9.81 N all the way."""
    _, new, force = _on_a_floor(0.0, 1.0)
    assert sum(new) == new[0] == 1
    assert force[24:] == pytest.approx([9.81] * len(force[24:]), rel=1e-6)


def test_a_ball_meets_a_sharp_edge_anew() -> None:
    """Where the floor bends by 18 degrees and more, what the last triangle bore says nothing of the next."""
    _, new, _ = _on_a_floor(0.04, 1.0)
    assert sum(new) > 4
