"""Checks of rays and images against closed forms, and of the independence of noise channels."""

from dataclasses import replace
from math import pi, sin
from typing import Any

import numpy as np

from harness.adapter import Adapter, Feature, Settings
from harness.conformance.check import ConformanceCheck, Finding, NotApplicable, judge, near, that
from harness.conformance.exact import first_hit, rotation
from harness.conformance.runs import built
from harness.conformance.scenes import TURNED, ball, static
from harness.scene import (
    WORLD,
    Appearance,
    Box,
    Camera,
    Capsule,
    Cylinder,
    PlacedShape,
    Plane,
    Scene,
    Shape,
    Sphere,
    Sun,
    axis_angle,
)
from harness.trajectory import Floats, Hits, Image, Trajectory

__all__ = ["CHECKS", "noise_axes_are_independent"]

_SHAPES: tuple[tuple[Feature, Shape], ...] = (
    (Feature.SPHERE, Sphere(radius=0.5)),
    (Feature.BOX, Box(half_extents=(0.3, 0.5, 0.8))),
    (Feature.CAPSULE, Capsule(radius=0.3, half_length=0.5)),
    (Feature.CYLINDER, Cylinder(radius=0.4, half_length=0.6)),
    (Feature.PLANE, Plane()),
)


def _rays(count: int, seed: int) -> tuple[Floats, Floats]:
    """Rays in the frame of a shape: from a sphere of 3 m towards points within 0.6 m of the centre."""
    draw = np.random.default_rng(seed)
    origins = draw.normal(size=(count, 3))
    origins *= 3.0 / np.linalg.norm(origins, axis=1)[:, None]
    directions = draw.uniform(-0.6, 0.6, (count, 3)) - origins
    return origins, directions / np.linalg.norm(directions, axis=1)[:, None]


def _cast(adapter: Adapter, settings: Settings, scene: Scene, origins: Floats, directions: Floats, reach: float) -> Hits:
    with built(adapter, scene, settings) as simulation:
        return simulation.cast(np.ascontiguousarray(origins), np.ascontiguousarray(directions), reach)


def _rays_match_closed_forms(adapter: Adapter, settings: Settings) -> Finding:
    found, place = [], np.array([1.0, -2.0, 3.0])
    R = rotation(TURNED)
    for seed, (feature, shape) in enumerate(_SHAPES):
        if feature not in adapter.features:
            continue
        origins, directions = _rays(200, seed)
        if feature is Feature.PLANE:
            origins[:, 2] = np.abs(origins[:, 2]) + 0.1
        expected = np.array([first_hit(shape, o, d) for o, d in zip(origins, directions, strict=True)])
        expected[expected > 50.0] = np.inf
        scene = Scene(bodies=(static("target", shape, p=(1.0, -2.0, 3.0), q=TURNED),))
        hits = _cast(adapter, settings, scene, place + origins @ R.T, directions @ R.T, 50.0)
        same = np.isfinite(hits.distance) == np.isfinite(expected)
        both = np.isfinite(hits.distance) & np.isfinite(expected)
        worst = float(np.abs(hits.distance[both] - expected[both]).max()) if both.any() else np.inf
        found.append(near(f"worst range error on a turned {shape.type} [m]", worst, 0.0, 1e-5, "rounding in single precision"))
        wrong = int((~same).sum())
        found.append(
            that(wrong <= 1, f"{shape.type}: got {wrong} of 200 rays hitting or missing wrongly, expected 1 at most, grazing")
        )
    if not found:
        raise NotApplicable("the engine claims rays but no shape with a closed form")
    return judge(*found)


def _target(adapter: Adapter, x: float = 0.0) -> tuple[Scene, float]:
    """A wide target whose near face stands at x + 5 m, with rays along x in mind; the face's distance [m]."""
    if Feature.BOX in adapter.features:
        return Scene(
            bodies=(
                static("other", Box(half_extents=(0.1, 0.1, 0.1)), p=(0.0, 0.0, 90.0)),
                static("target", Box(half_extents=(20.0, 20.0, 20.0)), p=(x + 25.0, 0.0, 0.0)),
            )
        ), 5.0
    if Feature.SPHERE in adapter.features:
        return Scene(
            bodies=(
                static("other", Sphere(radius=0.1), p=(0.0, 0.0, 90.0)),
                static("target", Sphere(radius=20.0), p=(x + 25.0, 0.0, 0.0)),
            )
        ), 5.0
    raise NotApplicable("the engine claims neither a box nor a sphere to aim at")


def _ray_beyond_max_range_misses(adapter: Adapter, settings: Settings) -> Finding:
    """The target's bounding volume lies within reach, its face beyond: culling bodies is not culling hits."""
    scene, face = _target(adapter)
    o, d = np.zeros((2, 3)), np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    short = _cast(adapter, settings, scene, o, d, face - 0.1)
    long = _cast(adapter, settings, scene, o, d, face + 0.1)
    return judge(
        that(
            bool(np.isinf(short.distance).all()),
            f"distances at a range of 4.9 m: got {short.distance}, expected inf: the face is at 5 m",
        ),
        that(bool((short.body == -1).all()), f"bodies at a range of 4.9 m: got {short.body}, expected -1"),
        near("normals of misses", short.normal_W, np.zeros((2, 3)), 0.0, "zero where nothing is hit"),
        near("distance at a range of 5.1 m [m]", long.distance[0], face, 1e-5),
        that(bool(np.isinf(long.distance[1])), f"distance the other way: got {long.distance[1]}, expected inf"),
    )


def _ray_from_inside_meets_the_far_side(adapter: Adapter, settings: Settings) -> Finding:
    """Along each axis of a turned solid from a point within it; a sensor in the housing of its carrier sees that housing."""
    exits: dict[Feature, tuple[Shape, Floats]] = {
        Feature.SPHERE: (Sphere(radius=0.5), np.array([0.5, 0.5, 0.5])),
        Feature.BOX: (Box(half_extents=(0.3, 0.5, 0.8)), np.array([0.3, 0.5, 0.8])),
        Feature.CAPSULE: (Capsule(radius=0.3, half_length=0.5), np.array([0.3, 0.3, 0.8])),
        Feature.CYLINDER: (Cylinder(radius=0.4, half_length=0.6), np.array([0.4, 0.4, 0.6])),
    }
    found, place, R = [], np.array([1.0, -2.0, 3.0]), rotation(TURNED)
    for feature, (shape, far) in exits.items():
        if feature not in adapter.features:
            continue
        scene = Scene(bodies=(static("target", shape, p=(1.0, -2.0, 3.0), q=TURNED),))
        # Off the centre by a fifth along the ray itself, so that both ends of an axis are told apart.
        directions = np.concatenate([np.eye(3), -np.eye(3)])
        origins = 0.2 * np.tile(far, 2)[:, None] * np.abs(directions)
        expected = np.concatenate([0.8 * far, 1.2 * far])
        hits = _cast(adapter, settings, scene, place + origins @ R.T, directions @ R.T, 50.0)
        found.append(
            near(f"ranges from inside a {shape.type} [m]", hits.distance, expected, 1e-5, "rounding in single precision")
        )
        found.append(
            near(f"normals from inside a {shape.type}", hits.normal_W, directions @ R.T, 1e-4, "outwards, along the ray")
        )
    if not found:
        raise NotApplicable("the engine claims no solid with a closed form")
    return judge(*found)


def _ray_names_body_and_normal(adapter: Adapter, settings: Settings) -> Finding:
    scene, face = _target(adapter)
    hits = _cast(
        adapter,
        settings,
        scene,
        np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 80.0]]),
        np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        50.0,
    )
    return judge(
        that(hits.body.tolist() == [1, 0], f"bodies hit: got {hits.body.tolist()}, expected [1, 0], places in the scene"),
        near("distances [m]", hits.distance, (face, 9.9), 1e-5),
        near("normals against the rays", hits.normal_W, [(-1, 0, 0), (0, 0, -1)], 1e-4, "unit, outwards"),
    )


def _many_rays_all_answer(adapter: Adapter, settings: Settings) -> Finding:
    """More rays than fit in a 16-bit count: a batch that is cut off drops the last ones without a word."""
    scene, face = _target(adapter)
    count = 16_500
    o = np.zeros((count, 3))
    o[:, 1] = np.linspace(-0.05, 0.05, count)
    hits = _cast(adapter, settings, scene, o, np.tile((1.0, 0.0, 0.0), (count, 1)), 50.0)
    missed = int((~np.isfinite(hits.distance)).sum())
    return judge(
        that(len(hits.distance) == count, f"answers: got {len(hits.distance)}, expected {count}"),
        that(missed == 0, f"rays without a hit: got {missed} of {count}, expected none"),
        near("range of the first and the last ray [m]", hits.distance[[0, -1]], (face, face), 1e-3),
    )


def _rays_see_the_present_state(adapter: Adapter, settings: Settings) -> Finding:
    """A ball at 10 m/s is met where the state says it is, right after build and after a step, not one step behind."""
    dt, v, r = 0.01, 10.0, 0.1
    scene = Scene(bodies=(ball(p=(0.0, 0.0, 0.0), v=(v, 0.0, 0.0), radius=r),), gravity=(0.0, 0.0, 0.0))
    o, d = np.array([[10.0, 0.0, 0.0]]), np.array([[-1.0, 0.0, 0.0]])
    with built(adapter, scene, settings.with_dt(dt)) as simulation:
        first = float(simulation.cast(o, d, 50.0).distance[0])
        simulation.step(3)
        later = float(simulation.cast(o, d, 50.0).distance[0])
    return judge(
        near("range before any step [m]", first, 10.0 - r, 1e-3),
        near("range after 3 steps [m]", later, 10.0 - r - 3 * v * dt, 5e-3, "one step behind would be .1 m off"),
    )


def _rays_ask_their_own_simulation(adapter: Adapter, settings: Settings) -> Finding:
    """Two simulations are open at once, the target at 5 m in one and at 8 m in the other."""
    near_by, face = _target(adapter)
    far_off, _ = _target(adapter, 3.0)
    o, d = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]])
    with built(adapter, near_by, settings) as one, built(adapter, far_off, settings) as other:
        got = [float(simulation.cast(o, d, 50.0).distance[0]) for simulation in (one, other, one)]
    return judge(near("ranges in the one, the other and the one again [m]", got, (face, face + 3.0, face), 1e-4))


def _picture(adapter: Adapter, settings: Settings, scene: Scene, **changed: Any) -> Image:
    """What a camera at the origin of W sees that looks along z, of 64 by 48 pixels, unless changed."""
    asked: dict[str, Any] = {"width": 64, "height": 48, "focal_x": 40, "focal_y": 40, "centre_x": 32, "centre_y": 24, **changed}
    with built(adapter, scene, settings) as simulation:
        return simulation.render(Camera(name="camera", body=WORLD, rate=1.0, **asked))


def _image_is_z_depth(adapter: Adapter, settings: Settings) -> Finding:
    """A turned camera in the world sees a box that lies 1 m to its right, .75 m down and 4 m ahead, and nothing else."""
    look = axis_angle((1.0, -1.0, 1.0), 2 * pi / 3)
    R = rotation(look)
    centre = R @ np.array([1.0, 0.75, 4.0])
    box = static("box", Box(half_extents=(0.5, 0.5, 0.5)), p=(float(centre[0]), float(centre[1]), float(centre[2])))
    image = _picture(adapter, settings, Scene(bodies=(box,)), q_BS=look)
    right, down = 32 + round(40 * 1.0 / 3.5), 24 + round(40 * 0.75 / 3.5)
    return judge(
        that(image.depth.shape == (48, 64), f"shape of the image: got {image.depth.shape}, expected (48, 64)"),
        near("z-depth of the box's face [m]", image.depth[down, right], 3.5, 0.02, "z-depth, not range"),
        that(
            bool(np.isinf(image.depth[48 - down, 64 - right])),
            f"depth at the opposite pixel: got {image.depth[48 - down, 64 - right]}, expected inf",
        ),
    )


def _image_names_bodies(adapter: Adapter, settings: Settings) -> Finding:
    """A box to the left and one to the right, drawn with a smaller one, in front of a wall that fills the lower half."""
    small = PlacedShape(shape=Box(half_extents=(0.2, 0.2, 0.2)))
    right = replace(static("right", Box(half_extents=(0.5, 0.5, 0.5)), p=(1.0, 0.0, 4.0)), visual=(small,))
    scene = Scene(
        bodies=(
            static("wall", Box(half_extents=(20.0, 10.0, 0.5)), p=(0.0, 10.0, 8.0)),
            static("left", Box(half_extents=(0.5, 0.5, 0.5)), p=(-1.0, 0.0, 4.0)),
            right,
        )
    )
    image = _picture(adapter, settings, scene)
    got = [int(image.body[row, column]) for row, column in ((24, 21), (24, 42), (40, 32), (4, 32), (19, 42))]
    seen = np.isfinite(image.depth)
    odd = int((seen != (image.body >= 0)).sum())
    return judge(
        that(image.body.shape == (48, 64), f"shape of the bodies: got {image.body.shape}, expected (48, 64)"),
        that(
            got == [1, 2, 0, -1, -1],
            f"bodies at the left box, the right one, the wall, above it, and where the right one only touches: got {got}, "
            "expected [1, 2, 0, -1, -1], places in the scene",
        ),
        that(odd == 0, f"pixels with a depth but no body or a body but no depth: got {odd}, expected none"),
    )


def _pixel_centre_is_at_half(adapter: Adapter, settings: Settings) -> Finding:
    """The edges of a face cross the image a quarter of a pixel beyond the centres that they are to hold.

    Columns 20..40 and rows 12..35 have their centres within 20.25..40.75 and 12.25..35.75; were the centre of a pixel at one of
    its corners, the face would hold other ones.
    """
    low, high = np.array([20.25 - 32, 12.25 - 24]) / 40 * 4, np.array([40.75 - 32, 35.75 - 24]) / 40 * 4
    (x, y), (half_x, half_y) = (low + high) / 2, (high - low) / 2
    box = static("box", Box(half_extents=(float(half_x), float(half_y), 0.5)), p=(float(x), float(y), 4.5))
    seen = np.isfinite(_picture(adapter, settings, Scene(bodies=(box,))).depth)
    columns, rows = np.flatnonzero(seen.any(axis=0)), np.flatnonzero(seen.any(axis=1))
    got = [[int(one[0]), int(one[-1])] if len(one) else [] for one in (columns, rows)]
    return judge(
        that(got == [[20, 40], [12, 35]], f"first and last columns and rows: got {got}, expected [[20, 40], [12, 35]]"),
        that(int(seen.sum()) == 21 * 24, f"pixels of the face: got {int(seen.sum())}, expected {21 * 24}"),
    )


def _image_is_cut_near_the_camera(adapter: Adapter, settings: Settings) -> Finding:
    """A face at .1 m fills the image; a floor that runs under the camera to behind it shows below the horizon alone."""
    close = _picture(adapter, settings, Scene(bodies=(static("wall", Box(half_extents=(1.0, 1.0, 0.5)), p=(0.0, 0.0, 0.6)),)))
    behind = _picture(adapter, settings, Scene(bodies=(static("wall", Box(half_extents=(1.0, 1.0, 0.5)), p=(0.0, 0.0, -2.0)),)))
    floor = static("floor", Box(half_extents=(20.0, 0.5, 20.0)), p=(0.0, 1.5, 0.0))
    below = _picture(adapter, settings, Scene(bodies=(floor,))).depth
    rows = np.arange(30, 48)
    expected = np.repeat(40.0 / (rows + 0.5 - 24.0)[:, None], 64, axis=1)
    return judge(
        near("z-depths of a face at .1 m [m]", close.depth, np.full((48, 64), 0.1), 1e-3, "nothing of it is cut away"),
        that(bool(np.isinf(behind.depth).all()), "depths with a box behind the camera: got some, expected inf"),
        near("z-depths of the floor [m]", below[30:], expected, 0.02, "1 % of the least"),
        that(bool(np.isinf(below[:24]).all()), "depths above the horizon: got some, expected inf"),
    )


def _image_is_lit_by_sun_and_sky(adapter: Adapter, settings: Settings) -> Finding:
    """A face whose normal is 60 degrees off the sun sends back its colour times irradiance cos / pi + sky; no face, the sky."""
    colour, sun = np.array([0.8, 0.4, 0.1]), Sun(towards_W=(0.0, -sin(pi / 3), -0.5), irradiance=pi / 2, sky=0.3)
    look = Appearance(colour=(0.8, 0.4, 0.1))
    box = replace(static("box", Box(half_extents=(0.5, 0.5, 0.5)), p=(0.0, 0.0, 4.0)), appearance=look)
    image = _picture(adapter, settings, Scene(bodies=(box,), sun=sun))
    if image.colour is None:
        return Finding("failed", "colour: got none, expected (48, 64, 3)")
    # Light is at most .8 in all, so that 8 bits count in steps of .8/255; a rasteriser may round twice.
    grain = 2 * 0.8 / 255
    return judge(
        that(image.colour.shape == (48, 64, 3), f"shape of the colours: got {image.colour.shape}, expected (48, 64, 3)"),
        near("colour of the face", image.colour[24, 32], colour * (0.5 * 0.5 + 0.3), grain, "Lambert's law, 8 bits a colour"),
        near("colour of the sky", image.colour[2, 2], np.full(3, 0.3), grain),
    )


def _ray_traced_image_has_shadows(adapter: Adapter, settings: Settings) -> Finding:
    """Seen from the side of a sun above it, a plate of a metre keeps its light off the floor below, not beside."""
    white = Appearance(colour=(1.0, 1.0, 1.0))
    scene = Scene(
        bodies=(
            replace(static("floor", Box(half_extents=(20.0, 0.5, 20.0)), p=(0.0, 1.5, 0.0)), appearance=white),
            static("plate", Box(half_extents=(0.5, 0.05, 0.5)), p=(0.0, -0.5, 4.0)),
        ),
        sun=Sun(towards_W=(0.0, -1.0, 0.0), irradiance=pi / 2, sky=0.25),
    )
    image = _picture(adapter, settings, scene, renderer="ray_traced")
    if image.colour is None:
        return Finding("failed", "colour: got none, expected (48, 64, 3)")
    # The floor lies 1 m below: at 4 m ahead it is seen in row 24 + 40/4.
    return judge(
        near("floor under the plate", image.colour[34, 32], np.full(3, 0.25), 1e-2, "the sky alone"),
        near("floor beside it", image.colour[34, 52], np.full(3, 0.75), 1e-2, "sun and sky"),
    )


def noise_axes_are_independent(trajectory: Trajectory) -> Finding:
    """Are the channels of each stream (k, c) uncorrelated about their means, as separately seeded noise is?

    Equation: the correlation of k independent pairs has the standard deviation 1/sqrt(k); five of them are granted.
    """
    found = []
    for name, signal in trajectory.streams.items():
        if name.endswith("/time") or signal.ndim != 2 or len(signal) < 100:
            continue
        moving = signal[:, signal.std(axis=0) > 0]
        for a in range(moving.shape[1]):
            for b in range(a + 1, moving.shape[1]):
                r = float(np.corrcoef(moving[:, a], moving[:, b])[0, 1])
                found.append(near(f"correlation of axes {a} and {b} of {name}", r, 0.0, 5 / np.sqrt(len(signal))))
    return judge(*found) if found else Finding("not_applicable", "no stream with two noisy channels of 100 samples")


CHECKS = (
    ConformanceCheck(
        name="rays_match_closed_forms",
        question="Do rays on turned shapes return the closed-form range?",
        run=_rays_match_closed_forms,
        needs=Feature.RAYS,
    ),
    ConformanceCheck(
        name="ray_beyond_max_range_misses",
        question="Is a hit beyond max_range a miss, and the next one within it a hit?",
        run=_ray_beyond_max_range_misses,
        needs=Feature.RAYS,
        excusable=False,
    ),
    ConformanceCheck(
        name="ray_from_inside_meets_the_far_side",
        question="Does a ray that starts inside a solid meet its far side?",
        run=_ray_from_inside_meets_the_far_side,
        needs=Feature.RAYS,
    ),
    ConformanceCheck(
        name="ray_names_body_and_normal",
        question="Do hits name the body's place in the scene and the outward normal?",
        run=_ray_names_body_and_normal,
        needs=Feature.RAYS,
        excusable=False,
    ),
    ConformanceCheck(
        name="many_rays_all_answer",
        question="Does every ray of a large batch get its answer?",
        run=_many_rays_all_answer,
        needs=Feature.RAYS,
        excusable=False,
    ),
    ConformanceCheck(
        name="rays_see_the_present_state",
        question="Do rays meet bodies where the state says they are?",
        run=_rays_see_the_present_state,
        needs=Feature.RAYS | Feature.SPHERE,
        excusable=False,
    ),
    ConformanceCheck(
        name="rays_ask_their_own_simulation",
        question="With two simulations open, do rays meet the bodies of their own?",
        run=_rays_ask_their_own_simulation,
        needs=Feature.RAYS,
        excusable=False,
    ),
    ConformanceCheck(
        name="image_is_z_depth",
        question="Is the depth image z-depth in metres, x right, y down, inf where nothing is?",
        run=_image_is_z_depth,
        needs=Feature.RENDER | Feature.BOX,
    ),
    ConformanceCheck(
        name="image_names_bodies",
        question="Does an image name the place in the scene of what is drawn, by its visual shapes?",
        run=_image_names_bodies,
        needs=Feature.RENDER | Feature.BOX,
        excusable=False,
    ),
    ConformanceCheck(
        name="pixel_centre_is_at_half",
        question="Does a pixel show what lies at its centre, half a pixel from its corner?",
        run=_pixel_centre_is_at_half,
        needs=Feature.RENDER | Feature.BOX,
    ),
    ConformanceCheck(
        name="image_is_cut_near_the_camera",
        question="Is what stands close before the camera seen, and what reaches behind it cut?",
        run=_image_is_cut_near_the_camera,
        needs=Feature.RENDER | Feature.BOX,
    ),
    ConformanceCheck(
        name="image_is_lit_by_sun_and_sky",
        question="Are the colours of an image linear, and those of the bodies under the scene's sun and sky?",
        run=_image_is_lit_by_sun_and_sky,
        needs=Feature.RENDER | Feature.BOX,
    ),
    ConformanceCheck(
        name="ray_traced_image_has_shadows",
        question="Does a ray-traced image have shadows?",
        run=_ray_traced_image_has_shadows,
        needs=Feature.RAY_TRACING | Feature.BOX,
    ),
)
