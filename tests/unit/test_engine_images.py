"""Pictures of the reference engine: every shape's depth and outline by both renderers against closed forms; what is refused."""

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from plumbline import engine
from plumbline.engine.build.level_of_detail import simplified
from plumbline.engine.compile.jit import jit_is_off
from plumbline.harness import scene as words
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.trajectory import State
from tests.rays_one_by_one import cast_one_by_one

Array = NDArray[np.float64]
BOTH = pytest.mark.parametrize("method", ["rasterised", "ray_traced"])
FINE = 0.1 if jit_is_off() else 0.5
"""Of a picture of 640 x 480 pixels: plain Python is given a twenty-fifth of what compiled code is."""
WIDTH, HEIGHT, FOCAL = round(640 * FINE), round(480 * FINE), 500.0 * FINE
HALF = (0.5, 0.3, 0.7)
CORNERS = [tuple(h * (1 if k >> c & 1 else -1) for c, h in enumerate(HALF)) for k in range(8)]
SIDES = [
    (0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7),
    (1, 7, 5),
]  # fmt: skip
BOX = words.Box(half_extents=HALF)
SHAPES: dict[str, tuple[engine.Shape, words.Shape]] = {
    "sphere": (engine.Sphere(0.6), words.Sphere(radius=0.6)),
    "box": (engine.Box(HALF), BOX),
    "capsule": (engine.Capsule(0.3, 0.5), words.Capsule(radius=0.3, half_length=0.5)),
    "cylinder": (engine.Cylinder(0.4, 0.5), words.Cylinder(radius=0.4, half_length=0.5)),
    "ellipsoid": (engine.Ellipsoid((0.3, 0.5, 0.4)), words.Ellipsoid(semi_axes=(0.3, 0.5, 0.4))),
    "plane": (engine.Plane((0.0, -0.96, -0.28)), words.Plane(normal=(0.0, -0.96, -0.28))),
    "hull": (engine.ConvexHull(CORNERS), BOX),
    "mesh": (engine.TriangleMesh(CORNERS, SIDES), BOX),
}


def _eye(**changed: Any) -> engine.Eye:
    plain: dict[str, Any] = {
        "width": WIDTH, "height": HEIGHT, "focal_x": FOCAL, "focal_y": 1.1 * FOCAL, "centre_x": 0.47 * WIDTH,
        "centre_y": 0.52 * HEIGHT,
    }  # fmt: skip
    return engine.Eye(**{**plain, **changed})


def _world(*bodies: engine.Body, **more: Any) -> engine.World:
    return engine.World(bodies, options=engine.Options(contacts=False), **more)


def _ways(eye: engine.Eye) -> Array:
    """Directions in W with unit z in E, by hand: the centre of pixel (0, 0) is at (0.5, 0.5)."""
    u, v = np.meshgrid(np.arange(eye.width) + 0.5, np.arange(eye.height) + 0.5)
    local = np.stack([(u - eye.centre_x) / eye.focal_x, (v - eye.centre_y) / eye.focal_y, np.ones_like(u)], axis=-1)
    w, x, y, z = eye.q_WE
    return np.asarray(Rotation.from_quat([x, y, z, w]).apply(local.reshape(-1, 3)))


def _pose(seed: int) -> tuple[Any, Any]:
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    return (0.3 * rng.uniform(-1, 1), 0.2 * rng.uniform(-1, 1), 3.0), tuple((q / np.linalg.norm(q)).tolist())


def _closed_form(shape: words.Shape, p: Any, q: Any, eye: engine.Eye, start: float = 0.0) -> tuple[Array, Array]:
    """z-depth (h, w) m and outward normal along the ray's direction, by the closed forms of the harness."""
    ways = _ways(eye)
    long = np.linalg.norm(ways, axis=1)
    body = words.Body(name="it", motion="static", p_WB=p, q_WB=q, collision=(words.PlacedShape(shape=shape),))
    scene = words.Scene(bodies=(body,))
    origins = np.asarray(eye.p_WE, float) + start * ways
    hits = first_hits(scene, State.initial(scene), origins, ways / long[:, None], 1e6)
    cosine = np.abs(np.sum(hits.normal_W * ways, axis=1)) / long
    return (start + hits.distance / long).reshape(eye.height, eye.width), cosine.reshape(eye.height, eye.width)


ASKEW = _eye(p_WE=(0.02, 0.01, 0.0), q_WE=(math.cos(0.03), 0.0, math.sin(0.03), 0.0))


def _pose_of(name: str, seed: int) -> tuple[Any, Any]:
    p, q = _pose(seed)
    return p, (1.0, 0.0, 0.0, 0.0) if name == "plane" else q  # the closed form is of a plane that faces the eye


@lru_cache(maxsize=3)
def _seen_askew(name: str, seed: int) -> tuple[Array, Array]:
    """What both renderers are compared with: each shape's closed form is worked out once."""
    return _closed_form(SHAPES[name][1], *_pose_of(name, seed), ASKEW)


@BOTH
@pytest.mark.parametrize("name", SHAPES)
def test_depth_and_outline_of_every_shape_are_those_of_its_closed_form(name: str, method: str) -> None:
    """Both renderers solve each pixel: rounding of 3 m (7e-16) over the cosine of the surface, with room for twenty of them."""
    for seed in range(3):
        p, q = _pose_of(name, seed)
        body = engine.Body(name="it", motion="static", p_WB=p, q_WB=q, shapes=[engine.Placed(SHAPES[name][0])])
        got = _world(body).render(ASKEW, method, colour=False)
        expected, cosine = _seen_askew(name, seed)
        here, there = got.depth < 1e6, expected < 1e6
        assert there.any()
        both = here & there
        error = np.abs(got.depth[both] - expected[both])
        assert np.median(error) < 1e-6  # the requirement; the next line is what is reached
        if name != "plane":
            assert (error * cosine[both] ** 2).max() < 20 * 7e-16 * 3
            assert both.sum() / (here | there).sum() > 0.999
        else:
            # A plane is met at any distance, and from both sides.
            assert (error / expected[both] ** 2).max() < 1e-12
        assert np.array_equal(got.body >= 0, np.isfinite(got.depth))


def test_the_outline_of_a_ball_is_its_conic() -> None:
    """d meets the ball about c where (d . c)^2 >= |d|^2 (c^2 - r^2): no depth is needed."""
    c, r, eye = np.array([0.4, -0.3, 2.0]), 0.5, _eye()
    picture = _world(engine.Body(shapes=[engine.Placed(engine.Sphere(r))], p_WB=c)).render(eye, colour=False)
    d = _ways(eye)
    inside = ((d @ c) ** 2 >= (d * d).sum(axis=1) * (c @ c - r * r)).reshape(picture.depth.shape)
    assert np.array_equal(np.isfinite(picture.depth), inside)


def _crowd(seed: int) -> engine.World:
    rng = np.random.default_rng(seed)
    bodies = [engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])]
    for k in range(14):
        a, b, c = rng.uniform(0.1, 0.6, 3)
        every: list[engine.Shape] = [
            engine.Sphere(a), engine.Box((a, b, c)), engine.Capsule(a, b), engine.Cylinder(a, b),
            engine.ConvexHull((rng.normal(size=(12, 3)) * a).tolist()), engine.TriangleMesh(CORNERS, SIDES),
        ]  # fmt: skip
        q = rng.normal(size=4)
        bodies.append(
            engine.Body(
                name=str(k),
                motion="kinematic",
                shapes=[engine.Placed(every[k % 6], rng.normal(size=3) * 0.2)],
                p_WB=rng.uniform((-3, -3, 0), 3),
                q_WB=q / np.linalg.norm(q),
                optics=engine.Optics(colour=rng.uniform(size=3)),
            )
        )
    return _world(*bodies, sun=engine.Sun(irradiance=0.0, sky=1.0))


@settings(max_examples=20, deadline=None)
@example(seed=498, inside=True)  # a capsule with one end behind the eye, the other before it
@given(seed=st.integers(0, 2**31), inside=st.booleans())
def test_both_renderers_agree_on_depth_bodies_and_colours(seed: int, inside: bool) -> None:
    """Anywhere, so that the near plane cuts bodies and the eye stands in some; under a sky alone, which casts no shadow here.

    An edge may pass a pixel's centre by less than rounding: one pixel is granted, at edges only.
    """
    world, rng = _crowd(seed), np.random.default_rng(seed)
    q = rng.normal(size=4)
    p = world.state()[1 + seed % 14, :3].copy() if inside else rng.uniform(-3, 3, 3)
    eye = _eye(
        p_WE=p, q_WE=q / np.linalg.norm(q), width=64, height=48, focal_x=40, focal_y=44, centre_x=30, centre_y=25, near=0.05
    )
    a, b = world.render(eye), world.render(eye, "ray_traced")
    assert a.colour is not None
    assert b.colour is not None
    same = (a.body == b.body) & (np.isfinite(a.depth) == np.isfinite(b.depth))
    assert (~same).sum() <= 1
    seen = same & np.isfinite(a.depth)
    # Rounding of some metres over the least cosine in 3000 pixels; a plane's horizon is kilometres away.
    assert (np.abs(a.depth[seen] - b.depth[seen]) / np.maximum(1.0, a.depth[seen] ** 2)).max(initial=0.0) < 1e-9
    assert np.abs(a.colour - b.colour)[same].max() < 1e-12


@BOTH
@pytest.mark.parametrize("name", ["sphere", "box", "capsule", "cylinder", "ellipsoid", "hull"])
def test_a_solid_cut_open_by_the_near_plane_shows_its_far_side(name: str, method: str) -> None:
    """What the near plane leaves is what rays see that start on it, the solid being convex: from its inside, its exit."""
    made, said = SHAPES[name]
    p, q = (0.05, 0.1, 0.6), _pose(4)[1]
    body = engine.Body(name="it", motion="kinematic", p_WB=p, q_WB=q, shapes=[engine.Placed(made)])
    world, eye = _world(body), _eye(width=64, height=48, focal_x=50, focal_y=50, centre_x=32, centre_y=24, near=0.5)
    got = world.render(eye, method, colour=False).depth.ravel()
    ways = _ways(eye)
    hits = cast_one_by_one(world, 0.5 * ways, ways)
    expected = 0.5 + hits.distance / np.linalg.norm(ways, axis=1)
    there = np.isfinite(expected)
    assert there.sum() > 100
    assert np.array_equal(np.isfinite(got), there)
    assert np.abs(got[there] - expected[there]).max() < 1e-9
    # From outside the first hit of the whole solid is another one.
    assert (np.abs(_closed_form(said, p, q, eye)[0].ravel()[there] - expected[there]) > 0.01).mean() > 0.5


@BOTH
def test_the_eye_inside_a_solid_sees_the_wall_around_it(method: str) -> None:
    shapes: tuple[engine.Shape, ...] = (
        engine.Sphere(0.5), engine.Box((0.5, 0.6, 0.7)), engine.Capsule(0.5, 0.2), engine.Cylinder(0.5, 0.6),
        engine.Ellipsoid((0.5, 0.6, 0.7)),
    )  # fmt: skip
    for shape in shapes:
        world = _world(engine.Body(shapes=[engine.Placed(shape)]))
        picture = world.render(_eye(width=16, height=12, focal_x=9, focal_y=9, centre_x=8, centre_y=6), method)
        assert np.isfinite(picture.depth).all()
        assert (picture.body == 0).all()


def test_a_seam_of_a_mesh_has_no_hole_and_no_overlap_at_the_centres_of_pixels() -> None:
    """A wall of triangles whose corners and diagonals lie exactly on the centres of pixels, in one body; then two such bodies.

    Of the pixels on the seam of two bodies each has the right or lower one, whatever the order.
    """
    eye = engine.Eye(width=16, height=16, focal_x=8.0, focal_y=8.0, centre_x=8.0, centre_y=8.0)

    def wall(low: int, high: int) -> engine.Placed:
        """Squares between the centres of columns low..high and rows 0..15, at z = 2 m."""
        xs, ys = np.arange(low, high + 1), np.arange(16)
        points = [((x + 0.5 - 8) / 8 * 2, (y + 0.5 - 8) / 8 * 2, 2.0) for y in ys for x in xs]
        n = len(xs)
        faces = []
        for j in range(15):
            for i in range(n - 1):
                a, b, c, d = j * n + i, j * n + i + 1, (j + 1) * n + i, (j + 1) * n + i + 1
                faces += [(a, b, d), (a, d, c)]
        return engine.Placed(engine.TriangleMesh(points, faces))

    whole = _world(engine.Body(motion="static", shapes=[wall(0, 15)])).render(eye, colour=False)
    # Left and upper edges belong to the wall, right and lower ones do not.
    assert np.isfinite(whole.depth[:15, :15]).all()
    assert np.isinf(whole.depth[15]).all()
    assert np.isinf(whole.depth[:, 15]).all()
    for order in (False, True):
        halves = [
            engine.Body(name="left", motion="static", shapes=[wall(0, 7)]),
            engine.Body(name="right", motion="static", shapes=[wall(7, 15)]),
        ]
        body = _world(*(halves[::-1] if order else halves)).render(eye, colour=False).body
        left = int(order)
        assert (body[:15, :7] == left).all()
        assert (body[:15, 7:15] == 1 - left).all()


def test_what_is_drawn_is_the_visual_shape_and_a_mesh_stands_for_coarser_ones() -> None:
    """Hull or pieces touch, the mesh is seen: the picture of a dented mesh is that of the mesh, not of its hull."""
    corners = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (0, 0, 0.4), (0, 0, 1.0)]
    faces = [(1, 0, 4), (2, 1, 4), (3, 2, 4), (0, 3, 4), (0, 1, 5), (1, 2, 5), (2, 3, 5), (3, 0, 5)]
    mesh = engine.TriangleMesh(corners, faces)
    hull, _ = simplified(mesh, "hull")
    dented = engine.Body(shapes=hull, visual=[engine.Placed(mesh)], p_WB=(0, 0, 3.0))
    for method in ("rasterised", "ray_traced"):
        eye = _eye(width=65, height=65, focal_x=60, focal_y=60, centre_x=32.5, centre_y=32.5)
        picture = _world(dented).render(eye, method)
        # The middle of the dent, which the hull covers at 3 m.
        assert picture.depth[32, 32] == pytest.approx(3.4, abs=1e-12)
        touching = _world(replace(dented, visual=None)).render(eye, method)
        assert touching.depth[32, 32] == pytest.approx(3.0, abs=1e-12)


def test_pictures_show_bodies_where_they_are_now() -> None:
    body = engine.Body(shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(0, 0, 2.0), v_WB=(0, 0, 1.0))
    world = engine.World([body], gravity=(0, 0, 0), options=engine.Options(dt=0.1))
    eye = _eye(width=9, height=9, focal_x=9, focal_y=9, centre_x=4.5, centre_y=4.5)
    for method in ("rasterised", "ray_traced"):
        before = world.render(eye, method).depth[4, 4]
        world.step(5)
        assert world.render(eye, method).depth[4, 4] - before == pytest.approx(0.5, abs=1e-12)


def test_a_picture_is_the_same_bit_for_bit_again_and_on_any_number_of_threads() -> None:
    world = _crowd(3)
    world = _world(
        *(replace(b, optics=engine.Optics(mirror=0.3, transmission=0.5 * (k % 2))) for k, b in enumerate(world._bodies))
    )
    small = {"width": 40, "height": 30, "focal_x": 30.0, "focal_y": 30.0, "centre_x": 20.0, "centre_y": 15.0}
    eye = _eye(p_WE=(-4, 0, 1.5), q_WE=(0.5, -0.5, 0.5, -0.5), samples=3, sky_rays=2, **small)
    first = world.render(eye, "ray_traced")
    for threads in (1, 2):
        again = world.render(eye, "ray_traced", threads=threads)
        assert np.array_equal(again.depth, first.depth)
        assert np.array_equal(again.body, first.body)
        assert again.colour is not None
        assert np.array_equal(again.colour, first.colour)
    plain = replace(eye, samples=1, sky_rays=0)
    assert np.array_equal(world.render(plain).depth, world.render(plain).depth)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("p_WE", (0.0, math.nan, 0.0)), ("q_WE", (0.0, 0.0, 0.0, 0.0)), ("width", 0), ("height", 20000), ("focal_x", 0.0),
        ("focal_y", math.inf), ("centre_x", math.nan), ("near", 0.0), ("near", -1.0), ("samples", 0), ("bounces", -1),
        ("sky_rays", 0.5), ("lens", "wide"),
    ],
)  # fmt: skip
def test_a_degenerate_eye_is_refused_by_name(field: str, value: Any) -> None:
    with pytest.raises(ValueError, match=rf"eye: \|?{field}"):
        engine.Eye(**{field: value})


def test_bad_optics_suns_and_methods_are_refused_by_name() -> None:
    for field, value in (("mirror", 1.5), ("transmission", -0.1), ("refractive_index", 0.9), ("colour", (0.0, 2.0, 0.0))):
        with pytest.raises(ValueError, match=f"optics: {field}"):
            engine.Optics(**{field: value})  # type: ignore[arg-type]
    for field, value in (("towards_W", (0.0, 0.0, 0.0)), ("irradiance", -1.0), ("sky", math.inf)):
        with pytest.raises(ValueError, match=f"sun: {field}"):
            engine.Sun(**{field: value})  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="body 'b': optics"):
        engine.Body(name="b", optics="shiny")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="method 'painted'"):
        _world(engine.Body()).render(_eye(), "painted")
    with pytest.raises(engine.NotSupported, match="lens"):
        _world(engine.Body()).render(_eye(lens=engine.Lens(k1=0.1)))
