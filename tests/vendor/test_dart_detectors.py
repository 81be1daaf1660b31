"""Which pairs of shapes DART's collision detectors hold, and which they let sink, in dartpy's own words."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.vendor.dart_world import UP, G, dartpy, make_ground, make_mover, make_pose, make_world

pytestmark = pytest.mark.dart

DT, R = 1 / 240, 0.1
SUNK = G * DT**2
"""What a body falls in the step before a contact is found [m]: who rests gives way by less, who sinks by more."""
SIDE = (np.pi / 2, 0.0, 0.0)


def _mesh(folder: Path, half: tuple[float, float, float]) -> Any:
    """A box as a triangle mesh; dartpy makes one from a file only."""
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = ["1 2 4", "1 4 3", "5 7 8", "5 8 6", "1 5 6", "1 6 2", "3 4 8", "3 8 7", "1 3 7", "1 7 5", "2 6 8", "2 8 4"]
    lines = ["v {} {} {}".format(*(a * b for a, b in zip(corner, half, strict=True))) for corner in corners]
    path = folder / "box.obj"
    path.write_text("\n".join(lines + [f"f {face}" for face in faces]) + "\n", encoding="ascii")
    geometry = f'<geometry><mesh filename="{path.as_uri()}"/></geometry>'
    urdf = f'<robot name="m"><link name="m"><collision>{geometry}</collision></link></robot>'
    reader, files = dartpy.utils.DartLoader(), dartpy.common.LocalResourceRetriever()
    return reader.parseSkeletonString(urdf, dartpy.common.Uri("file:///"), files).getBodyNode(0).getShapeNode(0).getShape()


def _shapes(folder: Path) -> dict[str, tuple[Any, Any]]:
    """Supports by name: shape, and its pose with the top at z = 0."""
    dynamics = dartpy.dynamics
    return {
        "plane": (dynamics.PlaneShape(np.array([0.0, 0.0, 1.0]), 0.0), make_pose(UP, 0.0)),
        "box": (dynamics.BoxShape(np.array([1.0, 1.0, 0.2])), make_pose(UP, -0.1)),
        "end of a cylinder": (dynamics.CylinderShape(0.5, 0.2), make_pose(UP, -0.1)),
        "lying cylinder": (dynamics.CylinderShape(0.5, 0.6), make_pose((0.0, np.pi / 2, 0.0), -0.5)),
        "lying capsule": (dynamics.CapsuleShape(0.5, 0.6), make_pose((0.0, np.pi / 2, 0.0), -0.5)),
        "mesh": (_mesh(folder, (0.5, 0.5, 0.1)), make_pose(UP, -0.1)),
    }


def _movers() -> dict[str, tuple[Any, Any]]:
    """Movers by name: shape, and its pose above z = 0, which it touches with its centre at R."""
    dynamics = dartpy.dynamics
    return {
        "box": (dynamics.BoxShape(np.full(3, 2 * R)), make_pose(UP, R)),
        "capsule": (dynamics.CapsuleShape(R, 0.3), make_pose(SIDE, R)),
        "lying cylinder": (dynamics.CylinderShape(R, 0.3), make_pose(SIDE, R)),
        "standing cylinder": (dynamics.CylinderShape(R, 2 * R), make_pose(UP, R)),
    }


def _lost(folder: Path, detector: str, support: str, mover: str, askew: bool = False) -> float:
    """The height [m] that a body has lost 3 s after it was laid down, in the middle or turned beside it."""
    world = make_world(detector, DT)
    make_ground(world, *_shapes(folder)[support])
    shape, pose = _movers()[mover]
    if askew:
        pose.set_rotation(dartpy.math.expMapRot(np.array([0.0, 0.0, 0.3])) @ pose.rotation())
        pose.set_translation(np.array([0.13, 0.07, R]))
    node = make_mover(world, shape, pose)
    for _ in range(720):
        world.step()
    return R - float(node.getWorldTransform().translation()[2])


@pytest.mark.parametrize(
    ("detector", "support", "mover"),
    [
        ("ode", "box", "capsule"),
        ("ode", "lying capsule", "box"),
        ("ode", "end of a cylinder", "capsule"),
        ("ode", "lying capsule", "standing cylinder"),
        ("ode", "end of a cylinder", "lying cylinder"),
        ("ode", "lying cylinder", "standing cylinder"),
        ("fcl", "box", "capsule"),
        ("fcl", "box", "standing cylinder"),
        ("fcl", "box", "lying cylinder"),
        ("fcl", "lying cylinder", "box"),
        ("fcl", "end of a cylinder", "lying cylinder"),
        ("dart", "box", "lying cylinder"),
        ("dart", "end of a cylinder", "capsule"),
        ("dart", "end of a cylinder", "lying cylinder"),
        ("dart", "lying capsule", "box"),
        ("bullet", "mesh", "lying cylinder"),
        ("bullet", "mesh", "standing cylinder"),
        ("bullet", "mesh", "box"),
    ],
)
def test_pairs_that_a_detector_has_wrong_sink(tmp_path: Path, detector: str, support: str, mover: str) -> None:
    assert _lost(tmp_path, detector, support, mover, askew=support == "mesh") > SUNK


@pytest.mark.parametrize("mover", ["box", "capsule", "lying cylinder", "standing cylinder"])
@pytest.mark.parametrize("support", ["box", "end of a cylinder", "lying cylinder", "lying capsule"])
def test_the_bullet_detector_holds_every_pair_of_round_and_flat_shapes(tmp_path: Path, support: str, mover: str) -> None:
    assert abs(_lost(tmp_path, "bullet", support, mover)) < SUNK


@pytest.mark.parametrize("detector", ["fcl", "dart", "bullet"])
def test_a_box_on_a_plane_has_one_contact_by_every_detector_but_ode(tmp_path: Path, detector: str) -> None:
    counts = []
    for name in (detector, "ode"):
        world = make_world(name, DT)
        make_ground(world, *_shapes(tmp_path)["plane"])
        make_mover(world, _movers()["box"][0], make_pose(UP, R - 1e-4))
        world.step()
        counts.append(world.getLastCollisionResult().getNumContacts())
    assert counts == [1, 4]
