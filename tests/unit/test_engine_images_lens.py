"""Brown's distortion in traced pictures: its inverse against other ways of finding it, and lenses that fold in the picture."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from plumbline import engine
from plumbline.engine.images.lens import RESIDUAL, look

Array = NDArray[np.float64]
SMALL: dict[str, Any] = {"width": 64, "height": 48, "focal_x": 50.0, "focal_y": 55.0, "centre_x": 30.0, "centre_y": 25.0}


def _brown(x: Array, y: Array, lens: engine.Lens) -> tuple[Array, Array]:
    r2 = x * x + y * y
    radial = 1 + lens.k1 * r2 + lens.k2 * r2**2 + lens.k3 * r2**3
    return (
        x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x),
        y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y,
    )


def _directions(eye: engine.Eye) -> tuple[Array, int]:
    made = np.full((eye.width * eye.height, 3), np.nan)
    length = np.empty(len(made))
    dark = look(eye.row, eye.width, 0, eye.height, 0.5, 0.5, made, length)
    if dark < 0:
        assert np.abs(length - np.linalg.norm(made, axis=1)).max() < 1e-15 * 4
    return made, dark


@pytest.mark.parametrize(
    "lens",
    [
        engine.Lens(),
        engine.Lens(k1=-0.2, k2=0.05),
        engine.Lens(k1=0.3, k2=0.1, k3=0.02, p1=0.01, p2=-0.02),
        engine.Lens(p1=0.05, p2=0.03),
        engine.Lens(k1=-0.2),
    ],
)
def test_every_direction_is_shown_at_its_own_pixel(lens: engine.Lens) -> None:
    eye = engine.Eye(lens=lens, **SMALL)
    made, dark = _directions(eye)
    assert dark == -1
    assert made[:, 2] == pytest.approx(np.ones(len(made)))
    u, v = np.meshgrid((np.arange(64) + 0.5 - 30) / 50, (np.arange(48) + 0.5 - 25) / 55)
    x, y = _brown(made[:, 0], made[:, 1], lens)
    assert np.hypot(x - u.ravel(), y - v.ravel()).max() <= 2 * RESIDUAL


def test_the_inverse_of_a_radial_lens_is_the_root_that_bisection_finds() -> None:
    """On the near side of the fold, where r (1 + k1 r^2 + k2 r^4) grows: another route, along a line."""
    lens = engine.Lens(k1=-0.4, k2=0.08)
    eye = engine.Eye(lens=lens, width=100, height=1, focal_x=125.0, focal_y=125.0, centre_x=0.0, centre_y=0.5)
    made, dark = _directions(eye)
    assert dark == -1
    for i in (3, 40, 75):
        shown = (i + 0.5) / 125
        root = brentq(lambda r, to=shown: r * (1 - 0.4 * r**2 + 0.08 * r**4) - to, 0.0, 1.0, xtol=1e-15)
        assert made[i, 0] == pytest.approx(root, abs=1e-11)


def test_a_lens_that_folds_within_the_picture_is_refused_by_the_pixel() -> None:
    """r - r^3 / 3 grows up to r = 1, where it is 2/3: a pixel at .7 shows nothing."""
    lens = engine.Lens(k1=-1 / 3)
    assert lens.fold == pytest.approx(1.0)
    world = engine.World([engine.Body(shapes=[engine.Placed(engine.Sphere(1.0))], p_WB=(0, 0, 3))])
    wide = engine.Eye(lens=lens, width=10, height=1, focal_x=10.0, focal_y=10.0, centre_x=0.0, centre_y=0.5)
    with pytest.raises(ValueError, match=r"shows nothing at pixel \(7, 0\)"):
        world.render(wide, "ray_traced")
    assert engine.Lens(k1=0.1, k2=0.1).fold == math.inf
    world.render(engine.Eye(lens=lens, width=6, height=1, focal_x=10.0, focal_y=10.0, centre_x=0.0, centre_y=0.5), "ray_traced")


def test_a_ball_is_seen_where_the_lens_shows_its_centre() -> None:
    """Small balls at known places: the centroid of their pixels is Brown's image of the centre, to a tenth of a pixel."""
    lens = engine.Lens(k1=-0.25, k2=0.06, p1=0.01, p2=0.015)
    eye = engine.Eye(lens=lens, width=320, height=240, focal_x=250, focal_y=250, centre_x=160, centre_y=120)
    places = np.array([(0.0, 0.0), (0.4, 0.3), (-0.5, 0.2), (0.45, -0.35)])
    bodies = [
        engine.Body(name=str(k), shapes=[engine.Placed(engine.Sphere(0.06))], p_WB=(4 * x, 4 * y, 4.0))
        for k, (x, y) in enumerate(places)
    ]
    body = engine.World(bodies, options=engine.Options(contacts=False)).render(eye, "ray_traced", colour=False).body
    x, y = _brown(places[:, 0], places[:, 1], lens)
    for k in range(len(places)):
        rows, columns = np.nonzero(body == k)
        # A ball of 4 pixels' radius: its outline's middle is off its centre by less than r^2 / z^2 of the focal length.
        assert columns.mean() + 0.5 == pytest.approx(250 * x[k] + 160, abs=0.2)
        assert rows.mean() + 0.5 == pytest.approx(250 * y[k] + 120, abs=0.2)
        # Without the lens it would be elsewhere, but for the one in the middle.
        if k:
            assert abs(columns.mean() + 0.5 - (250 * places[k, 0] + 160)) > 0.5
