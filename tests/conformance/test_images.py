"""Images behind the adapters: the reference engine's by both renderers against closed forms, the others' against the same."""

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from plumbline.adapters.reference import ADAPTER as REFERENCE
from plumbline.harness.adapter import Unsupported
from plumbline.harness.conformance.frames import rotation
from plumbline.harness.scene import (
    Appearance,
    Body,
    Box,
    Camera,
    Capsule,
    Cylinder,
    PlacedShape,
    Plane,
    Scene,
    Sphere,
    Sun,
    axis_angle,
)
from plumbline.harness.scene.sensor import Distortion, Renderer
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.trajectory import State
from tests.conformance.engines import adapter, why_unavailable


def _yard() -> Scene:
    """A floor, a ball, a box, a capsule and a cylinder of their own colours before a camera on a turned carrier."""
    shapes = (
        Sphere(radius=0.5), Box(half_extents=(0.4, 0.3, 0.6)), Capsule(radius=0.25, half_length=0.4),
        Cylinder(radius=0.35, half_length=0.5),
    )  # fmt: skip
    bodies = [
        Body(
            name=shape.type,
            motion="static",
            collision=(PlacedShape(shape=shape),),
            p_WB=(4.0, 1.2 * k - 1.8, 0.8),
            q_WB=axis_angle((1.0, 2.0, 0.5), 0.5 * k),
            appearance=Appearance(colour=(0.2 * k + 0.1, 0.5, 0.9 - 0.2 * k), mirror=0.2 * k, transmission=0.1 * k),
        )
        for k, shape in enumerate(shapes)
    ]
    floor = Body(name="floor", motion="static", collision=(PlacedShape(shape=Plane()),))
    carrier = Body(name="carrier", p_WB=(0.0, 0.1, 1.0), q_WB=axis_angle((0.0, 0.0, 1.0), 0.05))
    return Scene(bodies=(floor, *bodies, carrier), gravity=(0.0, 0.0, 0.0), sun=Sun(irradiance=1.5, sky=0.4))


EYE = Camera(
    name="eye", body="carrier", rate=1.0, p_BS=(0.1, 0.0, 0.2), q_BS=(0.5, -0.5, 0.5, -0.5), width=128, height=96, focal_x=100,
    focal_y=95, centre_x=66, centre_y=40,
)  # fmt: skip


@pytest.mark.parametrize("renderer", ["rasterised", "ray_traced"])
def test_the_image_of_a_carried_camera_is_that_of_the_closed_forms(renderer: Renderer) -> None:
    scene = _yard()
    simulation = REFERENCE.build(scene, REFERENCE.tracks["tuned"])
    image = simulation.render(replace(EYE, renderer=renderer))
    carrier = scene.body("carrier")
    R = rotation(carrier.q_WB) @ rotation(EYE.q_BS)
    u, v = np.meshgrid((np.arange(128) + 0.5 - 66) / 100, (np.arange(96) + 0.5 - 40) / 95)
    ways = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3) @ R.T
    long = np.linalg.norm(ways, axis=1)
    start = np.array(carrier.p_WB) + rotation(carrier.q_WB) @ np.array(EYE.p_BS)
    hits = first_hits(scene, State.initial(scene), np.tile(start, (len(ways), 1)), ways / long[:, None], np.inf)
    expected = (hits.distance / long).reshape(96, 128)
    assert np.array_equal(image.body, hits.body.reshape(96, 128))
    there = np.isfinite(expected)
    assert set(np.unique(image.body)) == {-1, 0, 1, 2, 3, 4}
    # Rounding of a few metres, a grazing root taken of it: 1e-8; the floor's horizon lies far out, where rounding grows as z^2.
    assert (np.abs(image.depth[there] - expected[there]) / np.maximum(1.0, expected[there] ** 2)).max() < 1e-7
    assert simulation.render(replace(EYE, renderer=renderer), colour=False).colour is None


def test_a_traced_image_knows_the_lens_and_says_where_it_folds() -> None:
    simulation = REFERENCE.build(_yard(), REFERENCE.tracks["tuned"])
    straight = simulation.render(replace(EYE, renderer="ray_traced"))
    bent = simulation.render(replace(EYE, renderer="ray_traced", distortion=Distortion(k1=-0.1), samples=2))
    # A barrel draws towards the middle: more of the picture is floor and sky, and the box moves inwards.
    assert (bent.body > 0).sum() < (straight.body > 0).sum()
    with pytest.raises(Unsupported, match=r"image of camera 'eye': eye: lens .* shows nothing at pixel"):
        simulation.render(replace(EYE, renderer="ray_traced", distortion=Distortion(k1=-1.0)))


def test_sun_and_appearance_reach_both_renderers() -> None:
    """The same scene in the words of the scene: where light falls unhindered, both give Lambert's law, on every body."""
    scene = replace(_yard(), sun=Sun(irradiance=0.0, sky=0.7))
    simulation = REFERENCE.build(scene, REFERENCE.tracks["tuned"])
    image = simulation.render(EYE)
    assert image.colour is not None
    for k in range(1, 5):
        look = scene.bodies[k].appearance
        expected = 0.7 * (look.scatters * np.array(look.colour) + 1.0 - look.scatters)
        np.testing.assert_allclose(image.colour[image.body == k], np.broadcast_to(expected, (int((image.body == k).sum()), 3)))
    traced = simulation.render(replace(EYE, renderer="ray_traced"))
    assert traced.colour is not None
    # The ball neither mirrors nor lets light through: it looks the same to both.
    np.testing.assert_allclose(traced.colour[image.body == 1], image.colour[image.body == 1], rtol=1e-12)
    assert np.abs(traced.colour - image.colour)[image.body == 4].max() > 0.01


@pytest.mark.parametrize(("name", "outline", "grain"), [("mujoco", 0.99, 2.5 / 255), ("bullet", 0.8, 10 / 255)])
def test_another_engines_image_shows_the_same_bodies_in_the_same_light(name: str, outline: float, grain: float) -> None:
    """Round shapes are polyhedra there: MuJoCo's with 192 corners around, Bullet's hulls of 42 points in all.

    Those 42 stand 0.55 rad apart, so that an outline between them sags by up to 1 - cos(.32) = 5 % of the radius on each side:
    nine tenths of a slim body's area, and a pixel of its dozen across. Colours are compared by the median of each body, over 8
    bits of a light of .88 at most, MuJoCo rounding twice; Bullet blends the normals of so coarse a polyhedron's corners.
    """
    if why_unavailable(name):
        pytest.skip(str(why_unavailable(name)))
    scene = _yard()
    own = REFERENCE.build(scene, REFERENCE.tracks["tuned"]).render(EYE)
    engine = adapter(name)
    with closing(engine.build(scene, engine.tracks["tuned"])) as simulation:
        try:
            other = simulation.render(EYE)
            plain = simulation.render(EYE, colour=False)
        except Unsupported as refused:
            pytest.skip(str(refused))
    assert plain.colour is None
    assert np.array_equal(plain.body, other.body)
    assert own.colour is not None
    assert other.colour is not None
    for k in range(1, 5):
        a, b = own.body == k, other.body == k
        assert (a & b).sum() / (a | b).sum() > outline, scene.bodies[k].name
        assert np.median(np.abs(own.colour[a & b] - other.colour[a & b])) < grain, scene.bodies[k].name
    both = (own.body == other.body) & (own.body > 0)
    # Polyhedra lie within the solids, by 5 % of half a metre at most; the buffers are single precision.
    assert np.median(np.abs(own.depth[both] - other.depth[both])) < 0.02
    assert np.abs(own.colour[(own.body < 0) & (other.body < 0)] - other.colour[(own.body < 0) & (other.body < 0)]).max() < 1e-12
