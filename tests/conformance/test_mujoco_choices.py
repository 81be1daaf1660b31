"""What MuJoCo's tuned track chooses by the scene: matrices and where shapes stand."""

import importlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from adapters.mujoco.simulation import MujocoSimulation
from harness.case import Case
from harness.scene import Scene, Sphere
from tests.conformance.mujoco_scenes import DEFAULT, TUNED, built, hinge_at, on_ground, shaped_body


def scene_of(case: str, **parameters: Any) -> Scene:
    told: Case = importlib.import_module(f"cases.{case}").CASE
    return told.scene(**{**told.parameters, **parameters})


def model_of(simulation: MujocoSimulation) -> Any:
    return simulation._world.model


@pytest.mark.parametrize(
    ("case", "parameters", "chosen"),
    [
        # No constraint at all; free bodies, in threes; hinges whose feet touch the ground alone; loops of hinges.
        ("system_scaling", {"kind": "flight", "n": 64}, "auto"),
        ("system_scaling", {"kind": "chain", "n": 64}, "auto"),
        ("system_scaling", {"kind": "contact", "n": 64}, "auto"),
        ("stack_pile", {"n": 30}, "auto"),
        ("stand_quadruped", {"n": 4}, "auto"),
        ("joint_fourbar", {}, "dense"),
    ],
)
def test_dense_matrices_stand_in_for_the_sparse_factor_where_that_can_be_wrong(
    case: str, parameters: dict[str, Any], chosen: str
) -> None:
    scene = scene_of(case, **parameters)
    simulation = built(scene, TUNED)
    assert simulation.resolved.options["jacobian"] == chosen
    for warned in (simulation, built(scene, DEFAULT)):
        assert not [notice for notice in warned.warnings() if "sparse factor" in notice.text]


def test_hinged_bodies_that_can_touch_each_other_get_dense_matrices_on_tuned_and_a_notice_on_default() -> None:
    balls = [shaped_body(f"ball_{k}", Sphere(radius=0.1), (k, 0.0, 0.0)) for k in range(60)]
    hinges = tuple(hinge_at(f"hinge_{k}", "world", ball.name, (k, 0.0, 1.0)) for k, ball in enumerate(balls))
    scene = replace(on_ground(*balls), joints=hinges)
    assert built(scene, TUNED).resolved.options["jacobian"] == "dense"
    assert [notice for notice in built(scene, DEFAULT).warnings() if "sparse factor" in notice.text]


@pytest.mark.parametrize("settings", [DEFAULT, TUNED])
def test_what_stands_still_is_searched_by_a_tree_of_bounding_volumes_whether_or_not_anything_can_touch(settings: Any) -> None:
    # 50 solids and a floor in one body: a binary tree with so many leaves.
    assert model_of(built(scene_of("system_rays"), settings)).nbvh == 2 * 51 - 1


@pytest.mark.parametrize("case", ["stack_tower", "sensor_lidar_shapes"])
def test_contacts_and_rays_name_the_bodies_whose_shapes_stand_in_the_world(case: str) -> None:
    scene = scene_of(case)
    simulation = built(scene, TUNED)
    model, still = model_of(simulation), [k for k, body in enumerate(scene.bodies) if not body.movable]
    assert still
    for k in still:
        geom = model.geom(f"g{k}.0")
        assert geom.bodyid[0] == 0
        assert simulation._world.indices.owner[geom.id] == k
    simulation.step(2)
    contacts = simulation.contacts()
    assert set(np.concatenate((contacts.body_A, contacts.body_B)).tolist()) <= set(range(len(scene.bodies)))
