"""Checks of pictures against closed forms: depth, bodies, pixels, light, shadow; pictures and rays show the present."""

from dataclasses import replace
from math import pi, sin
from typing import Any, Literal

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, check, firm, near, that
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.conformance.frames import rotation, vector
from plumbline.harness.conformance.scenes import static, static_cube, without_gravity
from plumbline.harness.scene import WORLD, Appearance, Box, Camera, PlacedShape, Scene, Sphere, Sun, axis_angle
from plumbline.harness.trajectory import Image

_FLOOR = static("floor", Box(half_extents=(20.0, 0.5, 20.0)), p=(0.0, 1.5, 0.0))


def _picture(engine: Engine, scene: Scene, **changed: Any) -> Image:
    """What a camera at the origin of W sees that looks along z, of 64 by 48 pixels, unless changed."""
    asked: dict[str, Any] = {"width": 64, "height": 48, "focal_x": 40, "focal_y": 40, "centre_x": 32, "centre_y": 24, **changed}
    with engine.built(scene, None) as simulation:
        return simulation.render(Camera(name="camera", body=WORLD, rate=1.0, **asked))


@check("Is the depth image z-depth in metres, x right, y down, inf where nothing is?", Feature.RENDER | Feature.BOX)
def image_is_z_depth(engine: Engine) -> Comparisons:
    """A turned camera in the world sees a box that lies 1 m to its right, .75 m down and 4 m ahead, and nothing else."""
    look = axis_angle((1.0, -1.0, 1.0), 2 * pi / 3)
    centre = rotation(look) @ np.array([1.0, 0.75, 4.0])
    box = static_cube("box", 0.5, vector(centre))
    image = _picture(engine, Scene(bodies=(box,)), q_BS=look)
    right, down = 32 + round(40 * 1.0 / 3.5), 24 + round(40 * 0.75 / 3.5)
    yield that(image.depth.shape == (48, 64), f"shape of the image: got {image.depth.shape}, expected (48, 64)")
    yield near("z-depth of the box's face [m]", image.depth[down, right], 3.5, 0.02, "z-depth, not range")
    opposite = image.depth[48 - down, 64 - right]
    yield that(bool(np.isinf(opposite)), f"depth at the opposite pixel: got {opposite}, expected inf")


@firm("Does an image name the place in the scene of what is drawn, by its visual shapes?", Feature.RENDER | Feature.BOX)
def image_names_bodies(engine: Engine) -> Comparisons:
    """A box to the left and one to the right, drawn with a smaller one, in front of a wall that fills the lower half."""
    small = PlacedShape(shape=Box(half_extents=(0.2, 0.2, 0.2)))
    right = replace(static_cube("right", 0.5, (1.0, 0.0, 4.0)), visual=(small,))
    wall = static("wall", Box(half_extents=(20.0, 10.0, 0.5)), p=(0.0, 10.0, 8.0))
    image = _picture(engine, Scene(bodies=(wall, static_cube("left", 0.5, (-1.0, 0.0, 4.0)), right)))
    got = [int(image.body[row, column]) for row, column in ((24, 21), (24, 42), (40, 32), (4, 32), (19, 42))]
    seen = np.isfinite(image.depth)
    odd = int((seen != (image.body >= 0)).sum())
    yield that(image.body.shape == (48, 64), f"shape of the bodies: got {image.body.shape}, expected (48, 64)")
    where = "bodies at the left box, the right one, the wall, above it, and where the right one only touches"
    yield that(got == [1, 2, 0, -1, -1], f"{where}: got {got}, expected [1, 2, 0, -1, -1], places in the scene")
    yield that(odd == 0, f"pixels with a depth but no body or a body but no depth: got {odd}, expected none")


@check("Does a pixel show what lies at its centre, half a pixel from its corner?", Feature.RENDER | Feature.BOX)
def pixel_centre_is_at_half(engine: Engine) -> Comparisons:
    """The edges of a face cross the image a quarter of a pixel beyond the centres that they are to hold.

    Columns 20..40 and rows 12..35 have their centres within 20.25..40.75 and 12.25..35.75; were the centre of a pixel at one of
    its corners, the face would hold other ones.
    """
    low, high = np.array([20.25 - 32, 12.25 - 24]) / 40 * 4, np.array([40.75 - 32, 35.75 - 24]) / 40 * 4
    (x, y), (half_x, half_y) = (low + high) / 2, (high - low) / 2
    box = static("box", Box(half_extents=(float(half_x), float(half_y), 0.5)), p=(float(x), float(y), 4.5))
    seen = np.isfinite(_picture(engine, Scene(bodies=(box,))).depth)
    columns, rows = np.flatnonzero(seen.any(axis=0)), np.flatnonzero(seen.any(axis=1))
    got = [[int(indices[0]), int(indices[-1])] if len(indices) else [] for indices in (columns, rows)]
    yield that(got == [[20, 40], [12, 35]], f"first and last columns and rows: got {got}, expected [[20, 40], [12, 35]]")
    yield that(int(seen.sum()) == 21 * 24, f"pixels of the face: got {int(seen.sum())}, expected {21 * 24}")


@check("Is what stands close before the camera seen, and what reaches behind it cut?", Feature.RENDER | Feature.BOX)
def image_is_cut_near_the_camera(engine: Engine) -> Comparisons:
    """A face at .1 m fills the image; a floor that runs under the camera to behind it shows below the horizon alone."""
    wall = Box(half_extents=(1.0, 1.0, 0.5))
    close, behind = (_picture(engine, Scene(bodies=(static("wall", wall, p=(0.0, 0.0, z)),))) for z in (0.6, -2.0))
    below = _picture(engine, Scene(bodies=(_FLOOR,))).depth
    rows = np.arange(30, 48)
    expected = np.repeat(40.0 / (rows + 0.5 - 24.0)[:, None], 64, axis=1)
    yield near("z-depths of a face at .1 m [m]", close.depth, np.full((48, 64), 0.1), 1e-3, "nothing of it is cut away")
    yield that(bool(np.isinf(behind.depth).all()), "depths with a box behind the camera: got some, expected inf")
    yield near("z-depths of the floor [m]", below[30:], expected, 0.02, "1 % of the least")
    yield that(bool(np.isinf(below[:24]).all()), "depths above the horizon: got some, expected inf")


@check(
    "Are the colours of an image linear, and those of the bodies under the scene's sun and sky?", Feature.RENDER | Feature.BOX
)
def image_is_lit_by_sun_and_sky(engine: Engine) -> Comparisons:
    """A face whose normal is 60 degrees off the sun sends back its colour times irradiance cos / pi + sky; no face, the sky."""
    colour, sun = np.array([0.8, 0.4, 0.1]), Sun(towards_W=(0.0, -sin(pi / 3), -0.5), irradiance=pi / 2, sky=0.3)
    look = Appearance(colour=(0.8, 0.4, 0.1))
    box = replace(static_cube("box", 0.5, (0.0, 0.0, 4.0)), appearance=look)
    image = _picture(engine, Scene(bodies=(box,), sun=sun))
    if image.colour is None:
        yield that(False, "colour: got none, expected (48, 64, 3)")
        return
    # Light is at most .8 in all, so that 8 bits count in steps of .8/255; a rasteriser may round twice.
    grain = 2 * 0.8 / 255
    yield that(image.colour.shape == (48, 64, 3), f"shape of the colours: got {image.colour.shape}, expected (48, 64, 3)")
    yield near("colour of the face", image.colour[24, 32], colour * (0.5 * 0.5 + 0.3), grain, "Lambert's law, 8 bits a colour")
    yield near("colour of the sky", image.colour[2, 2], np.full(3, 0.3), grain)


@check("Does a ray-traced image have shadows?", Feature.RAY_TRACING | Feature.BOX)
def ray_traced_image_has_shadows(engine: Engine) -> Comparisons:
    """Seen from the side of a sun above it, a plate of a metre keeps its light off the floor below, not beside."""
    white = Appearance(colour=(1.0, 1.0, 1.0))
    plate = static("plate", Box(half_extents=(0.5, 0.05, 0.5)), p=(0.0, -0.5, 4.0))
    sun = Sun(towards_W=(0.0, -1.0, 0.0), irradiance=pi / 2, sky=0.25)
    scene = Scene(bodies=(replace(_FLOOR, appearance=white), plate), sun=sun)
    image = _picture(engine, scene, renderer="ray_traced")
    if image.colour is None:
        yield that(False, "colour: got none, expected (48, 64, 3)")
        return
    # The floor lies 1 m below: at 4 m ahead it is seen in row 24 + 40/4.
    yield near("floor under the plate", image.colour[34, 32], np.full(3, 0.25), 1e-2, "the sky alone")
    yield near("floor beside it", image.colour[34, 52], np.full(3, 0.75), 1e-2, "sun and sky")


_DT, _SPEED = 0.01, 10.0


def _coming(motion: Literal["kinematic", "dynamic"]) -> Scene:
    """A body of half a metre that comes down from 6 m at 10 m/s, .1 m a step, kinematic or thrown."""
    body = replace(static_cube("body", 0.5, (0.0, 0.0, 6.0)), motion=motion, v_WB=(0.0, 0.0, -_SPEED))
    behind = static("behind", Sphere(radius=1.0), p=(0.0, 0.0, 20.0), material="far")
    return without_gravity(behind, body, apart=(("far", body.material),))


@firm("Do rays meet kinematic bodies, and where they are now?", Feature.RAYS | Feature.KINEMATIC | Feature.BOX | Feature.SPHERE)
def rays_meet_kinematic_bodies(engine: Engine) -> Comparisons:
    o, d = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]])
    with engine.built(_coming("kinematic"), _DT) as simulation:
        first = simulation.cast(o, d, 50.0)
        simulation.step(4)
        later = simulation.cast(o, d, 50.0)
    ranges = [first.distance[0], later.distance[0]]
    yield near("range to a kinematic body, before any step and after 4 [m]", ranges, (5.5, 5.1), 1e-3)
    a, b = first.body.tolist(), later.body.tolist()
    yield that(a == b == [1], f"bodies: got {a} and {b}, expected [1]: it stands before the other")


@firm("Does a picture show where bodies are now, not a step ago?", Feature.RENDER | Feature.BOX | Feature.SPHERE)
def pictures_show_the_present(engine: Engine) -> Comparisons:
    camera = Camera(name="camera", body=WORLD, rate=1.0, width=16, height=16, focal_x=20, focal_y=20, centre_x=8, centre_y=8)
    with engine.built(_coming("dynamic"), _DT) as simulation:
        depths = [float(simulation.render(camera).depth[8, 8])]
        for steps in (1, 3):
            simulation.step(steps)
            depths.append(float(simulation.render(camera).depth[8, 8]))
    because = "a step is .1 m; depth buffers have a few millimetres"
    yield near("depth of a box that comes at .1 m a step [m]", depths, (5.5, 5.4, 5.1), 0.02, because)
