"""Many worlds of MuJoCo, and scenes of many bodies."""

import numpy as np

from plumbline.adapters.mujoco import ADAPTER
from plumbline.adapters.mujoco.arena import MANY
from plumbline.adapters.mujoco.many_worlds import MujocoWorlds
from plumbline.harness.adapter import Settings
from plumbline.harness.scene import Scene, Sphere
from plumbline.harness.trajectory import State
from tests.conformance.mujoco_scenes import BOTH, TUNED, built, on_ground, shaped_body, stack


def balls(count: int) -> Scene:
    return on_ground(*(shaped_body(f"ball_{k}", Sphere(radius=0.1), (k % 40, k // 40, 0.2)) for k in range(count)), mu=0.5)


@BOTH
def test_worlds_of_one_model_go_bit_for_bit_as_one_alone_does(settings: Settings) -> None:
    scene = stack(3)
    alone, together = built(scene, settings), ADAPTER.build_batch(scene, settings.with_dt(1e-3), 3)
    assert isinstance(together, MujocoWorlds)
    assert (together.worlds, together.resolved) == (3, alone.resolved)
    one, other = State.empty(len(scene.bodies)), State.empty(len(scene.bodies))
    for steps in (1, 4, 45):
        alone.step(steps)
        together.step(steps)
        alone.state(one)
        for world in (2, 0, 1):
            together.state(world, other)
            for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
                np.testing.assert_array_equal(getattr(other, name), getattr(one, name))
    together.close()


def test_the_engine_guesses_its_memory_up_to_a_number_of_bodies_and_is_told_beyond() -> None:
    """The guess for so many is 2.6 GB, told are 132 MB, of which the contacts that the balls fall into take a tenth."""
    guessed, told = (built(balls(count), TUNED, 1 / 240) for count in (MANY - 1, MANY))
    assert guessed.resolved.options["arena_bytes"] > 2e9
    assert told.resolved.options["arena_bytes"] < 2e8
    told.step(40)
    assert not [notice for notice in told.warnings() if "FULL" in notice.text]
    assert told._world.state.maxuse_arena < 0.5 * told.resolved.options["arena_bytes"]
