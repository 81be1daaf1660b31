"""Light in the reference engine's pictures: Snell, Fresnel and mirrors ray by ray, shadows by hand, and the white furnace."""

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from plumbline import engine
from plumbline.engine.images.scatter import LEAST

Array = NDArray[np.float64]
CLEAR = engine.Optics(transmission=1.0, refractive_index=1.5)
MIRROR = engine.Optics(mirror=1.0)
WHITE = engine.Optics(colour=(1.0, 1.0, 1.0))
SKY = engine.Sun(irradiance=0.0, sky=1.0)
OUT = 1e-9


def _world(*bodies: engine.Body, **more: Any) -> engine.World:
    return engine.World(bodies, options=engine.Options(contacts=False), **more)


def _body(shape: engine.Shape, optics: engine.Optics = WHITE, name: str = "body", **more: Any) -> engine.Body:
    return engine.Body(name=name, motion="static", shapes=[engine.Placed(shape)], optics=optics, **more)


def _slab(index: float, thick: float = 1.0) -> engine.World:
    """A clear slab between z = 0 and z = -thick."""
    glass = engine.Optics(transmission=1.0, refractive_index=index)
    return _world(_body(engine.Box((500.0, 500.0, thick / 2)), glass, p_WB=(0, 0, -thick / 2)))


def _fresnel(angle: float, before: float, after: float) -> tuple[Any, Any, Any]:
    """The refracted angle and both polarisations' shares of reflected light, from tangents and sines in fifty digits.

    Equation: Rs = (sin(i - t) / sin(i + t))^2, Rp = (tan(i - t) / tan(i + t))^2 (Born, Wolf, section 1.5.2, eq. 21a).
    """
    with mpmath.workdps(50):
        i = mpmath.mpf(angle)
        t = mpmath.asin(before * mpmath.sin(i) / mpmath.mpf(after))
        return t, (mpmath.sin(i - t) / mpmath.sin(i + t)) ** 2, (mpmath.tan(i - t) / mpmath.tan(i + t)) ** 2


def _share(angle: float, before: float, after: float) -> float:
    """Of unpolarised light, reflected."""
    return 0.0 if before == after else float(sum(_fresnel(angle, before, after)[1:]) / 2)


@pytest.mark.parametrize("index", [1.0001, 1.33, 1.5, 2.4, 4.0])
@pytest.mark.parametrize("degrees", [1, 10, 30, 45, 56.3, 60, 75, 85, 89])
def test_refraction_into_a_slab_and_out_of_it_follows_snell_and_fresnel(index: float, degrees: float) -> None:
    """Direction within, parallel exit shifted by d sin(i - t) / cos t, and the weights of all first pieces, to 1e-9."""
    angle = math.radians(degrees)
    start, d = np.array([[-math.tan(angle), 0.0, 1.0]]), np.array([[math.sin(angle), 0.0, -math.cos(angle)]])
    path = _slab(index).trace(start, d, 2)
    t, rs, rp = _fresnel(angle, 1.0, index)
    within, back = float(t), float((rs + rp) / 2)
    assert path.kind[0] == "given"
    assert path.end[0] == pytest.approx((0, 0, 0), abs=OUT)
    if back > LEAST:
        mirrored = path.kind.tolist().index("reflected")
        assert path.direction[mirrored] == pytest.approx((math.sin(angle), 0.0, math.cos(angle)), abs=OUT)
        assert path.weight[mirrored] == pytest.approx(back, abs=OUT)
        assert path.body[mirrored] == -1
    first, out = np.flatnonzero(path.kind == "refracted")[:2]
    assert path.direction[first] == pytest.approx((math.sin(within), 0.0, -math.cos(within)), abs=OUT)
    assert path.weight[first] == pytest.approx(1.0 - back, abs=OUT)
    assert path.end[first] == pytest.approx((math.tan(within), 0.0, -1.0), abs=OUT)
    assert path.parent[out] == first
    # Back in air: parallel to the given ray, the same share reflected at the second face (Stokes).
    assert path.direction[out] == pytest.approx(d[0], abs=OUT)
    assert path.weight[out] == pytest.approx((1.0 - back) ** 2, abs=OUT)
    assert np.isinf(path.end[out]).all()
    aside = np.cross(path.start[out] - start[0], d[0])
    assert np.linalg.norm(aside) == pytest.approx(math.sin(angle - within) / math.cos(within), abs=OUT)


def test_reflectance_at_normal_incidence_brewsters_angle_and_grazing_is_the_known_one() -> None:
    n = 1.5
    world = _slab(n)

    def share(angle: float) -> float:
        path = world.trace([[0, 0, 1e-4]], [[math.sin(angle), 0, -math.cos(angle)]], 1)
        return float(path.weight[path.kind == "reflected"][0])

    assert share(0.0) == pytest.approx(((n - 1) / (n + 1)) ** 2, abs=1e-12)
    # At Brewster's angle one polarisation is not reflected, the other by ((n^2 - 1) / (n^2 + 1))^2.
    assert share(math.atan(n)) == pytest.approx(0.5 * ((n * n - 1) / (n * n + 1)) ** 2, abs=1e-12)
    # Towards grazing R = 1 - k (90 deg - angle), k = 2 (n^2 + 1) / sqrt(n^2 - 1), the mean of both polarisations' slopes.
    slope = (2.0 / math.sqrt(n * n - 1.0) + 2.0 * n * n / math.sqrt(n * n - 1.0)) * 1e-5
    assert 1.0 - share(math.pi / 2 - 1e-5) == pytest.approx(slope, rel=1e-3)


@pytest.mark.parametrize("index", [1.33, 1.5, 2.4])
def test_light_is_totally_reflected_beyond_the_critical_angle_and_not_before(index: float) -> None:
    """From within the slab, a billionth of a radian on either side of asin(1/n)."""
    world, critical = _slab(index), math.asin(1.0 / index)
    for angle, passes in ((critical - 1e-9, True), (critical + 1e-9, False)):
        path = world.trace([[0.0, 0.0, -0.5]], [[math.sin(angle), 0.0, math.cos(angle)]], 1)
        assert ("refracted" in path.kind) == passes
        reflected = path.kind.tolist().index("reflected")
        assert path.direction[reflected] == pytest.approx((math.sin(angle), 0.0, -math.cos(angle)), abs=OUT)
        assert path.weight.sum() - path.weight[0] == pytest.approx(1.0, abs=1e-12)
        if not passes:
            assert path.weight[reflected] == 1.0


@pytest.mark.parametrize(
    "shape", [engine.Sphere(0.5), engine.Capsule(0.5, 0.3), engine.Cylinder(0.5, 0.5), engine.Box((1, 1, 0.5))]
)
def test_a_ray_that_starts_inside_a_clear_solid_finds_the_exit(shape: engine.Shape) -> None:
    """Along z from the middle of it, and along x, where it leaves at right angles."""
    for axis in (0, 2):
        d = np.eye(3)[[axis]]
        path = _world(_body(shape, CLEAR)).trace([[0.0, 0.0, 0.0]], d, 1)
        assert path.body[0] == 0
        assert path.kind[path.direction @ d[0] > 0].tolist() == ["given", "refracted"]
        assert path.weight[path.kind == "refracted"] == pytest.approx([1 - 0.2**2], abs=OUT)


@pytest.mark.parametrize("height", [0.0, 0.1, 0.3, 0.45])
def test_a_glass_ball_turns_a_ray_by_twice_the_difference_of_its_angles(height: float) -> None:
    """In by asin(h/r), within by Snell; the same at the exit: deviation 2 (i - t), in the plane of the ray and the centre."""
    path = _world(_body(engine.Sphere(0.5), CLEAR)).trace([[-2.0, 0.0, height]], [[1.0, 0.0, 0.0]], 2)
    i = math.asin(height / 0.5)
    t, _, _ = _fresnel(i, 1.0, 1.5) if height else (0.0, 0, 0)
    turn = 2 * (i - float(t))
    out = np.flatnonzero(path.kind == "refracted")[1]
    assert path.direction[out] == pytest.approx((math.cos(turn), 0.0, -math.sin(turn)), abs=OUT)


def test_a_ball_of_glass_in_a_block_of_the_same_glass_is_not_there() -> None:
    """Its surface separates equal indices: nothing reflected, nothing bent; in water of index 1.33 it bends by 1.5 / 1.33."""
    for around in (1.5, 1.33):
        block = _body(engine.Box((2, 2, 2)), engine.Optics(transmission=1.0, refractive_index=around), "block")
        path = _world(block, _body(engine.Sphere(0.5), CLEAR, "ball")).trace([[-3.0, 0.0, 0.3]], [[1.0, 0.0, 0.0]], 4)
        bent = np.flatnonzero((path.kind == "refracted") & (path.body == 1))
        inside = int(np.flatnonzero(path.parent == bent[0])[-1])
        i = math.asin(0.6)
        turn = i - float(_fresnel(i, around, 1.5)[0])
        assert path.direction[inside] == pytest.approx((math.cos(turn), 0.0, -math.sin(turn)), abs=OUT)
        assert path.weight[inside] == pytest.approx(
            (1 - 0.04 if around == 1.5 else 1 - (0.33 / 2.33) ** 2) * (1 - _share(i, around, 1.5)), abs=OUT
        )
        if around == 1.5:
            out = path.direction[(path.body == -1) & (path.direction[:, 0] > 0)]
            assert out[0] == pytest.approx((1.0, 0.0, 0.0), abs=OUT)


def test_a_mirror_shows_a_point_where_its_image_is() -> None:
    """Every mirrored ray through the point comes, drawn back, from the eye's image behind the mirror, to 1e-9."""
    tilt = np.array([0.3, -0.2, 1.0])
    n = tilt / np.linalg.norm(tilt)
    world = _world(_body(engine.Plane(tuple(n)), MIRROR))
    eye = np.array([0.4, 0.1, 1.7])
    image = eye - 2 * (eye @ n) * n
    aims = np.random.default_rng(0).uniform(-1, 1, (50, 3))
    aims -= np.outer(aims @ n, n)
    path = world.trace(np.tile(eye, (50, 1)), aims - eye, 1)
    mirrored = path.kind == "mirrored"
    assert mirrored.sum() == 50
    assert path.weight[mirrored] == pytest.approx(np.ones(50))
    away = path.start[mirrored] - image
    assert np.linalg.norm(np.cross(away, path.direction[mirrored]), axis=1).max() < OUT
    # A ball at a known place is met by the ray towards its own image.
    target = np.array([1.0, 0.5, 1.2])
    beyond = target - 2 * (target @ n) * n
    both = _world(_body(engine.Plane(tuple(n)), MIRROR), _body(engine.Sphere(0.1), WHITE, "ball", p_WB=target))
    seen = both.trace(eye[None], (beyond - eye)[None], 1)
    assert seen.body.tolist() == [0, 1]
    assert np.linalg.norm(seen.end[1] - target) == pytest.approx(0.1, abs=OUT)
    assert np.linalg.norm(np.cross(seen.start[1] - target, seen.direction[1])) < OUT


def test_the_pieces_of_a_ray_share_its_light() -> None:
    """Whatever a ray becomes over many surfaces, what leaves and what scatters add up to 1, but for the faintest rays."""
    optics = engine.Optics(mirror=0.2, transmission=0.7, refractive_index=1.6)
    world = _world(_body(engine.Box((0.4, 0.5, 0.6)), optics, q_WB=(0.9, 0.1, 0.3, 0.2)))
    path = world.trace([[-2.0, 0.05, 0.1]], [[1.0, 0.0, 0.0]], 40)
    met = path.body == 0
    scattered = (1 - 0.2) * (1 - 0.7) * path.weight[met].sum()
    assert path.weight[~met].sum() + scattered == pytest.approx(1.0, abs=200 * LEAST)


SMALL: dict[str, Any] = {"width": 32, "height": 24, "focal_x": 20.0, "focal_y": 20.0, "centre_x": 16.0, "centre_y": 12.0}
AHEAD = (0.5, -0.5, 0.5, -0.5)
"""From an eye that looks along z to one that looks along x, z up."""


@pytest.mark.parametrize("method", ["rasterised", "ray_traced"])
@pytest.mark.parametrize("sky_rays", [0, 4])
@pytest.mark.parametrize("bounces", [1, 6])
def test_a_white_furnace_is_white(method: str, sky_rays: int, bounces: int) -> None:
    """White, mirror and glass bodies under a sky of radiance 1 look like the sky: sums of shares, to their rounding."""
    half = engine.Optics(colour=(1, 1, 1), mirror=0.3, transmission=0.5)
    world = _world(
        _body(engine.Plane(), WHITE, "ground"),
        _body(engine.Sphere(0.6), WHITE, "white", p_WB=(4, 0, 0.6)),
        _body(engine.Sphere(0.5), MIRROR, "mirror", p_WB=(3, -1.2, 0.5)),
        _body(engine.Sphere(0.5), CLEAR, "glass", p_WB=(3, 1.1, 0.5)),
        _body(engine.Box((0.4, 0.3, 0.2)), half, "half", p_WB=(2.5, 0, 0.3), q_WB=(0.9, 0.2, 0.1, 0.3)),
        sun=SKY,
    )
    eye = engine.Eye(p_WE=(0, 0, 1), q_WE=AHEAD, sky_rays=sky_rays, bounces=bounces, **SMALL)
    colour = world.render(eye, method).colour
    assert colour is not None
    assert np.abs(colour - 1.0).max() < 1e-12
    # What takes light is seen to: a body of colour .9 cannot be as bright as the sky.
    world = _world(_body(engine.Sphere(1.0), engine.Optics(colour=(0.9, 1.0, 1.0)), p_WB=(3, 0, 1)), sun=SKY)
    colour = world.render(eye, method).colour
    assert colour is not None
    assert colour[12, 16] == pytest.approx((0.9, 1.0, 1.0), abs=1e-12)


@pytest.mark.parametrize("method", ["rasterised", "ray_traced"])
def test_a_ball_is_as_bright_as_lambert_says_and_dark_where_it_turns_from_the_sun(method: str) -> None:
    towards, colour = np.array([-0.6, 0.0, 0.8]), np.array([0.2, 0.5, 0.9])
    ball = _body(engine.Sphere(1.0), engine.Optics(colour=tuple(colour)), p_WB=(4, 0, 0))
    world = _world(ball, sun=engine.Sun(towards_W=tuple(7 * towards), irradiance=2.0, sky=0.1))
    eye = engine.Eye(q_WE=AHEAD, **SMALL)
    picture = world.render(eye, method)
    assert picture.colour is not None
    rows, columns = np.nonzero(np.isfinite(picture.depth))
    z = picture.depth[rows, columns]
    x, y = z * (columns + 0.5 - 16) / 20, z * (rows + 0.5 - 12) / 20
    normal = np.column_stack([z - 4, -x, -y])
    cosine = normal @ towards
    lit = np.where(cosine > 0, cosine, 0.0) * 2.0 / math.pi + 0.1
    assert (cosine < 0).any()
    assert np.abs(picture.colour[rows, columns] - lit[:, None] * colour).max() < 1e-12
    assert np.abs(picture.colour[np.isinf(picture.depth)] - 0.1).max() < 1e-15


def test_the_shadow_of_a_ball_on_the_ground_is_its_ellipse() -> None:
    """A point of the ground is dark where its line to the sun passes the centre by less than the radius: no ray of ours."""
    towards, centre, r = np.array([0.36, 0.48, 0.8]), np.array([4.0, 0.0, 1.0]), 0.7
    world = _world(
        _body(engine.Plane(), WHITE, "ground"),
        _body(engine.Sphere(r), CLEAR, "ball", p_WB=centre),
        sun=engine.Sun(towards_W=tuple(towards), irradiance=math.pi, sky=0.25),
    )
    eye = engine.Eye(p_WE=(1, 0, 4), q_WE=(0.2, -0.678, 0.678, -0.2), width=64, height=64, focal_x=60, focal_y=60, centre_x=32,
                     centre_y=32)  # fmt: skip
    picture = world.render(eye, "ray_traced")
    assert picture.colour is not None
    rows, columns = np.nonzero(picture.body == 0)
    z = picture.depth[rows, columns]
    local = np.column_stack([z * (columns + 0.5 - 32) / 60, z * (rows + 0.5 - 32) / 60, z])
    away = local @ eye.axes.T + eye.p_WE - centre
    dark = np.linalg.norm(np.cross(away, towards), axis=1) < r
    assert dark.sum() > 50
    expected = np.where(dark, 0.25, 0.25 + 0.8)
    assert np.abs(picture.colour[rows, columns, 0] - expected).max() < 1e-9


def test_a_pane_before_the_dark_shines_by_both_of_its_faces() -> None:
    """At right angles a pane reflects 2 R / (1 + R), all orders summed (Born, Wolf, section 7.6.1, without interference).

    The sky is behind the eye, a black wall behind the pane. Orders fainter than the least weight are taken for sky: twice that.
    """
    pane = _body(engine.Box((50, 50, 0.1)), CLEAR, "pane", p_WB=(0, 0, 3))
    wall = _body(engine.Box((5000, 5000, 0.1)), engine.Optics(colour=(0, 0, 0)), "wall", p_WB=(0, 0, 5))
    eye = engine.Eye(width=9, height=7, focal_x=900, focal_y=900, centre_x=4.5, centre_y=3.5, bounces=20)
    colour = _world(pane, wall, sun=SKY).render(eye, "ray_traced").colour
    assert colour is not None
    assert colour[3, 4] == pytest.approx(np.full(3, 2 * 0.04 / 1.04), abs=2 * LEAST)


def test_samples_average_an_edge_by_its_share_of_the_pixel() -> None:
    """A white face covers a quarter of column 16 and all of what is right of it; 64 samples hold it to their spacing, 1/64."""
    edge = (16.75 - 16.0) / 20 * 4
    wall = _body(engine.Box((2.0, 9.0, 1.0)), WHITE, p_WB=(edge + 2.0, 0.0, 5.0))
    world = _world(wall, sun=engine.Sun(towards_W=(0, 0, -1), irradiance=math.pi, sky=0.0))
    colour = world.render(engine.Eye(samples=64, **SMALL), "ray_traced").colour
    assert colour is not None
    assert colour[12, 15] == pytest.approx((0, 0, 0), abs=1e-12)
    assert colour[12, 16] == pytest.approx((0.25, 0.25, 0.25), abs=1 / 64)
    assert colour[12, 17] == pytest.approx((1, 1, 1), abs=1e-12)
    one = world.render(engine.Eye(**SMALL), "ray_traced").colour
    assert one is not None
    assert one[12, 16] == pytest.approx((0, 0, 0), abs=1e-12)


def test_rays_to_the_sky_see_how_much_of_it_a_wall_hides() -> None:
    """The foot of an endless black wall sees half of the sky, and so half its light; 256 directions, to their spacing."""
    black = engine.Optics(colour=(0, 0, 0))
    world = _world(
        _body(engine.Plane(), WHITE, "ground"), _body(engine.Plane((-1, 0, 0)), black, "wall", p_WB=(1, 0, 0)), sun=SKY
    )
    eye = engine.Eye(p_WE=(1 - 1e-6, 0, 1), q_WE=(0, 1, 0, 0), sky_rays=256, **SMALL)
    colour = world.render(eye, "ray_traced").colour
    assert colour is not None
    assert world.render(eye, "ray_traced").body[12, 15] == 0
    foot = np.array([colour[12, 15, 0], colour[11, 15, 0]])
    # The pixels beside the middle lie 1/40 m before the wall; what a wall of any height hides of a plane point is a half.
    assert foot == pytest.approx([0.5, 0.5], abs=0.02)


def test_a_lit_floor_shows_no_specks_far_from_the_origin_nor_from_afar() -> None:
    """Rays to the sun start off the surface by more than the rounding of where they are, or of how far the eye is."""
    for shift, height in ((0.0, 1.0), (1e4, 1.0), (0.0, 1e5), (1e6, 10.0)):
        slab = _body(
            engine.Box((2.0 * height, 2.0 * height, 0.5)), WHITE, p_WB=(shift, shift, -0.5), q_WB=(0.96, 0.0, 0.0, 0.28)
        )
        world = _world(slab, sun=engine.Sun(towards_W=(0.6, 0, 0.8), irradiance=math.pi, sky=0.0))
        eye = engine.Eye(p_WE=(shift + 0.1, shift, height), q_WE=(0, 1, 0, 0), **SMALL)
        colour = world.render(eye, "ray_traced").colour
        assert colour is not None
        assert np.abs(colour - 0.8).max() < 1e-9
