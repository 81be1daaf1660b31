"""Black balls under an even sky, seen in a mirror and through a thick pane: does light go where Snell and Fresnel send it?"""

from dataclasses import replace

import numpy as np

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.metrics.cameras import colour_error_max, colour_error_median, silhouette_iou
from plumbline.harness.scene import Appearance, Body, Box, Camera, Scene, Sphere, Sun, Vector3, axis_angle
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.sensors.sight import Sight
from plumbline.harness.sensors.true_views import stamps_up_to, true_frames, true_sight
from plumbline.harness.trajectory import Floats, State, Trajectory

RATE = 10.0
INDEX, HALF_THICKNESS = 1.5, 0.15
APART = 100.0
"""The two scenes stand this far [m] from each other along x, so that neither shows in the other."""
PIECES = 12
"""Ways out of the pane that are followed; what the pane still holds then, less than 1e-9, is taken to end in the sky."""
REACH = 50.0
BLACK = Appearance(colour=(0.0, 0.0, 0.0))


class P(Parameters):
    tilt: float = 0.5


def _ball(name: str, radius: float, p_WB: Vector3) -> Body:
    return Body.fixed(name, Sphere(radius=radius), p_WB=p_WB, appearance=BLACK)


def _sheet(name: str, half: Vector3, p_WB: Vector3, axis: Vector3, tilt: float, look: Appearance) -> Body:
    return Body.fixed(name, Box(half_extents=half), p_WB=p_WB, q_WB=axis_angle(axis, tilt), appearance=look)


def _camera(name: str, x: float) -> Camera:
    return Camera(
        name=name,
        body="world",
        rate=RATE,
        p_BS=(x, 0.0, 0.0),
        width=160,
        height=120,
        focal_x=150.0,
        focal_y=150.0,
        centre_x=80.0,
        centre_y=60.0,
        renderer="ray_traced",
    )


def scene(p: P) -> Scene:
    """Sheets that fill their camera's picture, turned by `tilt` [rad] out of it; no sun, a sky of 1, all balls black."""
    bodies = (
        _sheet("mirror", (9.0, 9.0, 0.1), (0.0, 0.0, 4.0), (1.0, 0.3, 0.0), p.tilt, Appearance(mirror=1.0)),
        _ball("behind", 0.8, (0.3, 3.0, -1.0)),
        _ball("before", 0.3, (-0.5, 0.4, 2.2)),
        _ball("above", 0.7, (-1.5, 4.6, 1.0)),
        _sheet(
            "pane",
            (9.0, 9.0, HALF_THICKNESS),
            (APART, 0.0, 2.5),
            (0.3, 1.0, 0.0),
            p.tilt,
            Appearance(transmission=1.0, refractive_index=INDEX),
        ),
        _ball("beyond", 0.5, (APART + 0.2, 0.1, 4.5)),
        _ball("far", 1.2, (APART - 1.6, -0.9, 7.0)),
        _ball("beside", 0.9, (APART - 3.2, -0.6, 0.2)),
    )
    sun = Sun(irradiance=0.0, sky=1.0)
    return Scene(bodies=bodies, sensors=(_camera("facing", 0.0), _camera("through", APART)), gravity=(0.0, 0.0, 0.0), sun=sun)


def _bright(scene: Scene, origins: Floats, directions: Floats) -> Floats:
    """What a ray through air brings: 0 from a black ball, 1 from the sky, (r,). Sheets are left behind by then."""
    balls = replace(
        scene, bodies=tuple(body for body in scene.bodies if isinstance(body.collision[0].shape, Sphere)), sensors=()
    )
    return np.isinf(first_hits(balls, State.initial(balls), origins, directions, REACH).distance).astype(np.float64)


def _mirrored(directions: Floats, normal: Floats) -> Floats:
    flipped: Floats = directions - 2.0 * np.sum(directions * normal, axis=1)[:, None] * normal
    return flipped


def _fresnel(cosine: Floats) -> tuple[Floats, Floats]:
    """Share of unpolarised light that a surface of the pane sends back, and the cosine inside, (r,) each."""
    inside = np.sqrt(1.0 - (1.0 - np.square(cosine)) / INDEX**2)
    across = ((cosine - INDEX * inside) / (cosine + INDEX * inside)) ** 2
    along = ((inside - INDEX * cosine) / (inside + INDEX * cosine)) ** 2
    return (across + along) / 2.0, inside


def _in_mirror(scene: Scene, sight: Sight) -> Floats:
    return _bright(scene, sight.point_W, _mirrored(sight.directions_W, sight.normal_W))


def _in_pane(scene: Scene, sight: Sight) -> Floats:
    """The light that the front sends back, and what comes out of the back and the front by turns.

    Each surface is taken to meet unpolarised light, as ray tracers do, so that the m-th way out carries (1 - R)^2 R^m.
    """
    normal, point, direction = sight.normal_W, sight.point_W, sight.directions_W
    cosine = -np.sum(direction * normal, axis=1)
    share, inside = _fresnel(cosine)
    back = _mirrored(direction, normal)
    total = share * _bright(scene, point, back)
    # From one face to the other a ray moves 2 h tan along the face; the sine inside is the outer one over the index.
    along = (direction + cosine[:, None] * normal) / INDEX
    crossing = 2.0 * HALF_THICKNESS / inside
    held = (1.0 - share) ** 2
    for piece in range(PIECES):
        point = point + crossing[:, None] * along
        out = point - (2.0 * HALF_THICKNESS * normal if piece % 2 == 0 else 0.0)
        total = total + held * _bright(scene, out, direction if piece % 2 == 0 else back)
        held = held * share
    return total + held / (1.0 - share)


def expected(time: Floats, p: P) -> Trajectory:
    """Nothing moves; the colour of each pixel is the sum over its light's ways."""
    stage = scene(p)
    truth = Trajectory.at_rest(stage, time)
    stamps = stamps_up_to(float(truth.time[-1]), RATE) if len(truth) else truth.time
    streams: dict[str, Floats] = {}
    for camera, sheet, light in zip(stage.sensors, ("mirror", "pane"), (_in_mirror, _in_pane), strict=True):
        assert isinstance(camera, Camera)
        sight = true_sight(stage, camera, State.initial(stage))
        grey = np.where(sight.body == stage.index(sheet), light(stage, sight), 0.0).reshape(camera.height, camera.width)
        streams |= true_frames(stage, camera, stamps)
        streams[f"{camera.name}/colour"] = np.broadcast_to(grey[None, :, :, None], (len(stamps), *grey.shape, 3)).copy()
    return replace(truth, streams=streams)


CASE = Case.of(
    globals(),
    title="Mirror and pane",
    question="Does a picture show what a mirror and a thick pane show, each ghost with Fresnel's share of the light?",
    source="Born, Wolf, Principles of Optics, 7th ed., sections 1.5 and 7.6 (laws of Snell and Fresnel; plane plates)",
    truth="closed form",
    duration=0.05,
    sample_interval=0.05,
    # What is seen does not depend on the time step: one is enough.
    ladder=(1 / 240,),
    checks=(
        Check(
            colour_error_max,
            1.2e-4,
            "a tracer may take a ray that carries less than 1e-4 of a pixel's light for the sky: that ray and its "
            "echoes in the pane make 1e-4/(1 - R) with R up to 0.12; a refractive index wrong by 0.01 shows as 2e-3; no pixel "
            "lies so close to an edge that rounding decides it",
        ),
        Check(silhouette_iou, 0.999, "what a ray meets first does not depend on what light does there"),
    ),
    observe=(colour_error_median,),
)
