"""Checks that rays and pictures show what there is now: bodies that are moved by nothing but the scene, and no step ago."""

import numpy as np

from harness.adapter import Adapter, Feature, Settings
from harness.conformance.check import Finding, check, judge, near, that
from harness.conformance.runs import built
from harness.conformance.scenes import static
from harness.scene import WORLD, Body, Box, Camera, PlacedShape, Scene, Shape, Sphere

_DT, _SPEED = 0.01, 10.0


def _coming(motion: str) -> Scene:
    """A body of half a metre that comes down from 6 m at 10 m/s, .1 m a step, kinematic or thrown."""
    shape: Shape = Box(half_extents=(0.5, 0.5, 0.5))
    body = Body(
        name="body",
        motion=motion,  # type: ignore[arg-type]
        collision=(PlacedShape(shape=shape),),
        p_WB=(0.0, 0.0, 6.0),
        v_WB=(0.0, 0.0, -_SPEED),
    )
    behind = static("behind", Sphere(radius=1.0), p=(0.0, 0.0, 20.0), material="far")
    return Scene(bodies=(behind, body), apart=(("far", body.material),), gravity=(0.0, 0.0, 0.0))


@check(
    "Do rays meet kinematic bodies, and where they are now?",
    Feature.RAYS | Feature.KINEMATIC | Feature.BOX | Feature.SPHERE,
    firm=True,
)
def rays_meet_kinematic_bodies(adapter: Adapter, settings: Settings) -> Finding:
    o, d = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]])
    with built(adapter, _coming("kinematic"), settings.with_dt(_DT)) as simulation:
        first = simulation.cast(o, d, 50.0)
        simulation.step(4)
        later = simulation.cast(o, d, 50.0)
    return judge(
        near(
            "range to a kinematic body, before any step and after 4 [m]",
            [first.distance[0], later.distance[0]],
            (5.5, 5.1),
            1e-3,
        ),
        that(
            first.body.tolist() == later.body.tolist() == [1],
            f"bodies: got {first.body.tolist()} and {later.body.tolist()}, expected [1]: it stands before the other",
        ),
    )


@check("Does a picture show where bodies are now, not a step ago?", Feature.RENDER | Feature.BOX | Feature.SPHERE, firm=True)
def pictures_show_the_present(adapter: Adapter, settings: Settings) -> Finding:
    camera = Camera(name="camera", body=WORLD, rate=1.0, width=16, height=16, focal_x=20, focal_y=20, centre_x=8, centre_y=8)
    with built(adapter, _coming("dynamic"), settings.with_dt(_DT)) as simulation:
        depths = [float(simulation.render(camera).depth[8, 8])]
        for steps in (1, 3):
            simulation.step(steps)
            depths.append(float(simulation.render(camera).depth[8, 8]))
    because = "a step is .1 m; depth buffers have a few millimetres"
    return judge(near("depth of a box that comes at .1 m a step [m]", depths, (5.5, 5.4, 5.1), 0.02, because))
