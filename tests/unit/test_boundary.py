"""What is handed to an engine is refused by name where it is no array of the right shape, type and content."""

from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter.what_goes_in import DIRECTION, check_rays, check_state, check_targets, check_wrench
from plumbline.harness.conformance.scenes import free
from plumbline.harness.scene import WORLD, Drive, Prismatic, Scene
from plumbline.harness.trajectory import State

SLIDE = Prismatic(name="slide", parent=WORLD, child="body", anchor_W=(0, 0, 0), axis_W=(1, 0, 0), drive=Drive(stiffness=1.0))
SCENE = Scene(bodies=(free(),), joints=(SLIDE,))


def test_a_wrench_of_the_right_shape_passes_however_large_its_numbers() -> None:
    check_wrench(2, np.zeros((2, 3)), np.ones((2, 3)))
    # The square of 1e200 overflows; the number itself is finite.
    check_wrench(1, np.full((1, 3), 1e200), np.zeros((1, 3)))


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        (np.zeros(3), r"float64 \(3,\), expected float64 \(2, 3\) N"),
        (np.zeros((3, 3)), r"float64 \(3, 3\), expected float64 \(2, 3\) N"),
        (np.zeros((2, 3), dtype=np.float32), r"float32 \(2, 3\), expected float64"),
        ([[0.0] * 3] * 2, "got list, expected an array"),
        (np.array([[0.0, 0.0, 0.0], [0.0, np.nan, 0.0]]), r"got nan at \(1, 1\), expected finite"),
        (np.array([[0.0, 0.0, np.inf], [0.0, 0.0, 0.0]]), r"got inf at \(0, 2\), expected finite"),
    ],
)
def test_a_wrench_that_is_none_is_refused_with_what_was_got(bad: Any, said: str) -> None:
    with pytest.raises(ValueError, match="f_B_W: .*" + said):
        check_wrench(2, bad, np.zeros((2, 3)))
    with pytest.raises(ValueError, match="tau_B_W: .*" + said):
        check_wrench(2, np.zeros((2, 3)), bad)


def test_directions_are_unit_to_single_precision_and_no_worse() -> None:
    draw = np.random.default_rng(1).normal(size=(1000, 3))
    d = draw / np.linalg.norm(draw, axis=1)[:, None]
    check_rays(np.zeros((1000, 3)), d.astype(np.float32).astype(np.float64), 10.0)
    d[7] *= 1 + DIRECTION
    with pytest.raises(ValueError, match=r"direction 7 has the length 1\.000001"):
        check_rays(np.zeros((1000, 3)), d, 10.0)


@pytest.mark.parametrize("reach", [0.0, -1.0, float("nan"), float("inf"), "far", None])
def test_a_reach_that_is_none_is_refused(reach: Any) -> None:
    with pytest.raises(ValueError, match="max_range"):
        check_rays(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), reach)


def test_no_ray_at_all_is_a_cast_of_none() -> None:
    check_rays(np.zeros((0, 3)), np.zeros((0, 3)), 1.0)


@pytest.mark.parametrize(("name", "target"), [("nobody", 0.0), ("slide", float("nan")), ("slide", "far"), ("slide", None)])
def test_a_target_that_is_none_is_refused_with_the_joint(name: str, target: Any) -> None:
    check_targets(SCENE, {"slide": np.float64(0.5)})
    with pytest.raises(ValueError, match=f"command: .*{name}"):
        check_targets(SCENE, {name: target})


@pytest.mark.parametrize("name", ["p_WB", "q_WB", "v_WB", "w_WB"])
@pytest.mark.parametrize("bad", [np.zeros((1, 3)), np.zeros((2, 2)), np.zeros((2, 3), dtype=np.float32), [0.0]])
def test_a_state_that_does_not_fit_is_refused_by_the_name_of_its_array(name: str, bad: Any) -> None:
    arrays = {"p_WB": np.zeros((2, 3)), "q_WB": np.zeros((2, 4)), "v_WB": np.zeros((2, 3)), "w_WB": np.zeros((2, 3))}
    check_state(2, State(**arrays))
    with pytest.raises(ValueError, match=f"state: {name}"):
        check_state(2, State(**{**arrays, name: bad}))
