"""Where the sparse factor of MuJoCo 4.0.0 is wrong, in MuJoCo's own words: its accelerations beside those of dense matrices.

Source: release notes of 4.0.1, issue 3767 (rows with different descendants are merged into one supernode where the Jacobian of
the constraints is sparse: slow convergence, wrong accelerations, divergence).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vendor.mujoco_world import mujoco

pytestmark = pytest.mark.mujoco
if mujoco.__version__ != "4.0.0":
    pytest.skip("the fault is that of 4.0.0 alone", allow_module_level=True)

Pairs = Sequence[tuple[int, int]]
SIX = [f'<joint type="{kind}" axis="{axis}"/>' for kind in ("slide", "hinge") for axis in ("0 0 1", "0 1 0", "1 0 0")]
HINGE, FREE, BALL = '<joint axis=".3 .8 .5"/>', "<freejoint/>", '<joint type="ball"/>'
ROUNDING = 1e-9
"""Share of the largest acceleration: what two ways to solve for some hundred coordinates may differ by."""
DRAWN = 60


def body(name: int, joints: str, below: str = "") -> str:
    inertial = '<inertial pos=".1 .05 0" mass="1" diaginertia=".01 .02 .025"/>'
    return f'<body name="b{name}" pos="{0.2 * name!r} 0 0">{joints}{inertial}{below}</body>'


def tied(joints: str, count: int, pairs: Pairs) -> str:
    """So many bodies in the world, each with these joints, and a point that the two of each pair have in common."""
    points = "".join(f'<connect body1="b{a}" body2="b{b}" anchor=".2 .1 .3"/>' for a, b in pairs)
    bodies = "".join(body(k, joints) for k in range(count))
    return f"<worldbody>{bodies}</worldbody><equality>{points}</equality>"


def difference(model: str, random: np.random.Generator) -> tuple[float, int]:
    """By what share accelerations on sparse and dense matrices differ, and how many steps Newton takes on sparse ones."""
    found: list[NDArray[np.float64]] = []
    steps = 0
    moving = random.normal(size=1000)
    for kind in ("dense", "sparse"):
        told: Any = mujoco.MjModel.from_xml_string(f'<mujoco><option jacobian="{kind}" tolerance="1e-15"/>{model}</mujoco>')
        data = mujoco.MjData(told)
        data.qvel[:] = moving[: told.nv]
        mujoco.mj_forward(told, data)
        found.append(data.qacc.copy())
        steps = int(data.solver_niter.max())
    return float(np.abs(found[0] - found[1]).max() / np.abs(found[0]).max()), steps


def drawn_pairs(random: np.random.Generator, count: int) -> Pairs:
    many = int(random.integers(count - 1, 2 * count))
    return [(int(a), int(b)) for a, b in (random.choice(count, 2, replace=False) for _ in range(many))]


def wrong(joints: str) -> int:
    """In how many of 60 drawn models with these joints the accelerations differ by more than rounding."""
    random = np.random.default_rng(0)
    counts = random.integers(5, 20, DRAWN).tolist()
    return sum(difference(tied(joints, n, drawn_pairs(random, n)), random)[0] > ROUNDING for n in counts)


def test_a_ring_of_four_coupled_slides_with_a_fifth_hung_on_is_solved_wrong() -> None:
    slides = "".join(body(k, f'<joint name="j{k}" type="slide"/>') for k in range(5))
    ties = "".join(f'<joint joint1="j{a}" joint2="j{b}"/>' for a, b in ((0, 2), (0, 4), (1, 2), (1, 4), (2, 3)))
    error, steps = difference(f"<worldbody>{slides}</worldbody><equality>{ties}</equality>", np.random.default_rng(0))
    # All constraints are equalities, which a right factor solves in one step.
    assert error > 0.1
    assert steps == 100


@pytest.mark.parametrize("count", [1, 2, 4, 5])
def test_bodies_of_one_two_four_or_five_single_coordinates_are_solved_wrong_where_they_are_tied(count: int) -> None:
    assert wrong("".join(SIX[:count])) > 0


@pytest.mark.parametrize("joints", ["".join(SIX[:3]), "".join(SIX), BALL, FREE])
def test_bodies_whose_coordinates_come_in_threes_are_solved_right(joints: str) -> None:
    assert wrong(joints) == 0


@pytest.mark.parametrize("law", ['condim="1"', 'condim="3"', 'condim="6"'])
@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
def test_heaps_of_free_balls_are_solved_right(law: str, cone: str) -> None:
    random = np.random.default_rng(0)
    for count in random.integers(5, 40, DRAWN // 3).tolist():
        places = random.uniform(0.0, 0.16 * count ** (1 / 3), (count, 3)).tolist()
        balls = "".join(
            f'<body pos="{x!r} {y!r} {z!r}"><freejoint/><geom size=".1" mass="1" {law}/></body>' for x, y, z in places
        )
        told = f'<option cone="{cone}"/><worldbody>{balls}</worldbody>'
        assert difference(told, random)[0] < ROUNDING


@pytest.mark.parametrize("more", ['<flag island="enable"/>', '<flag island="disable"/>'])
def test_trees_of_hinges_that_are_tied_to_the_ground_alone_are_solved_right(more: str) -> None:
    """With dry friction in every hinge as well: no constraint couples two branches."""
    random = np.random.default_rng(0)
    for count in random.integers(8, 40, DRAWN).tolist():
        roots = int(random.integers(1, 6))
        above = [-1 if k < roots else int(random.integers(0, k)) for k in range(count)]

        def part(k: int, above: Sequence[int]) -> str:
            joints = FREE if above[k] < 0 and k % 2 else '<joint axis=".3 .8 .5" frictionloss=".1"/>'
            return body(k, joints, "".join(part(j, above) for j, up in enumerate(above) if up == k))

        held = "".join(f'<connect body1="b{k}" anchor=".2 .1 .3"/>' for k in random.choice(count, 5).tolist())
        trees = "".join(part(k, above) for k in range(roots))
        told = f"<option>{more}</option><worldbody>{trees}</worldbody><equality>{held}</equality>"
        assert difference(told, random)[0] < ROUNDING


def test_without_a_constraint_no_factor_is_asked_for() -> None:
    flying = f"<worldbody>{''.join(body(k, HINGE) for k in range(70))}</worldbody>"
    error, steps = difference(flying, np.random.default_rng(0))
    assert error == 0.0
    assert steps == 0
