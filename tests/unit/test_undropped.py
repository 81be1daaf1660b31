"""What a user drops of a robot, as a number: each engine that has it is run with it too, and says how far that moves a body."""

import html
import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from plumbline.harness.case.alteration import UNDROPPED, Alteration
from plumbline.harness.cli.own_scene import closing_words
from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.omissions import Omission, omissions
from plumbline.harness.findings.tables import agreement as table
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.scene import Revolute
from plumbline.harness.scene.importers.companion import Companion, JointWish
from plumbline.harness.store.imported_scenes import keep, unsound
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Refinement
from plumbline.harness.study.study import Study, study_of
from plumbline.reports.pages.scene import PAGE
from plumbline.reports.words.text import powers
from tests.in_process import in_this_process
from tests.robot_files import imported, mjcf, row

pytestmark = pytest.mark.usefixtures("mjcf_here")
MASS, LEVER, INERTIA, GRAVITY = 2.0, 0.5, 0.03, 9.81
ROTOR, DRY = 0.4, 1.5
"""kg m2 and N m: beside 0.53 kg m2 and 9.81 N m of the arm itself."""
DURATION, FINEST = 0.5, 1 / 960
ARM = mjcf(
    f'<joint name="j" type="hinge" axis="0 1 0" armature="{ROTOR}" frictionloss="{DRY}"/>'
    f'<inertial pos="{LEVER} 0 0" mass="{MASS}" diaginertia="0.02 {INERTIA} 0.04"/>',
    f'<option gravity="0 0 -{GRAVITY}"/>',
)
"""Held out level and let go, it falls one way for half a second, so that its dry friction has one sign."""


@dataclass(frozen=True)
class Done:
    store: Store
    found: dict[str, Omission]


@pytest.fixture(scope="module")
def fallen(tmp_path_factory: pytest.TempPathFactory) -> Done:
    folder = tmp_path_factory.mktemp("undropped")
    robot = imported(folder, ARM, Companion(duration=DURATION), drop=frozenset({"armature", "friction_loss"}))
    case = plugins.case(f"{plugins.SCENE_PREFIX}{keep(folder / 'run', robot)}")
    refine = Refinement(finest=FINEST, member_dt=FINEST, members=0, further=0)
    ladder = replace(study_of(case).experiments[0], tracks=("tuned",), timing=False, refine=refine)
    study = Study(name="scene", recordings=False, experiments=(ladder,))
    adapters = {name: plugins.adapter(name) for name in ("mujoco", "dart", "reference")}
    with pytest.MonkeyPatch.context() as patch:
        in_this_process(patch)
        store = carry_out(study, folder / "run", {case.name: case}, adapters, workers=1, resume=False)
    (one,) = agreements(store)
    return Done(store, {each.engine: each for each in omissions(store, one)})


def angles(rotor: float, dry: float, time: NDArray[np.float64]) -> NDArray[np.float64]:
    """The angle below level (t, 2) [rad], and its rate, of an arm that falls one way."""
    inertia = INERTIA + MASS * LEVER**2 + rotor

    def rate(_: float, y: NDArray[np.float64]) -> list[float]:
        return [y[1], (MASS * GRAVITY * LEVER * np.cos(y[0]) - dry) / inertia]

    found: NDArray[np.float64] = solve_ivp(rate, (0.0, DURATION), [0.0, 0.0], t_eval=time, rtol=1e-11, atol=1e-12).y.T
    return found


@pytest.mark.parametrize("engine", ["mujoco", "reference"])
def test_the_number_is_that_of_an_independent_integration(fallen: Done, engine: str) -> None:
    """A step places a body with the rate of one of its ends, so that an engine of the first order is off by no more than a step
    of the largest rate in either run. A chord is no longer than its arc."""
    found = fallen.found[engine]
    assert found.kinds == ("armature", "friction_loss")
    assert found.until == pytest.approx(DURATION, abs=1 / 60 + 1e-9)
    time = np.arange(0.0, found.until + 1e-9, 1 / 60)
    without, whole = angles(0.0, 0.0, time), angles(ROTOR, DRY, time)
    turn = np.abs(without[:, 0] - whole[:, 0]).max()
    off = found.dt * (np.abs(without[:, 1]).max() + np.abs(whole[:, 1]).max())
    assert turn > 50 * off
    assert found.angle == pytest.approx(turn, abs=off)
    assert found.position == pytest.approx(2 * LEVER * np.sin(turn / 2), abs=LEVER * off)


def test_an_engine_that_lacks_it_says_so_by_name(fallen: Done) -> None:
    lacking = fallen.found["dart"]
    assert lacking.position is None
    assert "unsupported" in lacking.why
    assert "armature" in lacking.why


def test_such_runs_are_told_apart_and_do_not_vote(fallen: Done) -> None:
    store = fallen.store
    altered = store.trials[store.trials["alteration"].str.contains(UNDROPPED)]
    assert len(altered) == 3
    assert not set(altered["trial"]) & set(store.asked["trial"])
    (one,) = agreements(store)
    assert not set(altered["trial"]) & {rung.trial for side in one.sides for rung in side.limit.rungs}
    assert {side.word for side in one.sides} == {"agrees"}
    assert list(unsound(store.folder)) == []


def test_table_end_of_the_run_and_page_say_it(fallen: Done) -> None:
    rows = {line["engine"]: line for line in table.TABLE.rows(fallen.store)}
    assert rows["mujoco"]["left_out"] == "armature friction_loss"
    assert rows["mujoco"]["omission_turn"] == fallen.found["mujoco"].angle
    assert rows["dart"]["omission"] is None
    said = [sentence for sentence in closing_words(fallen.store) if "leaving out armature and friction_loss" in sentence]
    assert len(said) == 3
    (page,) = (str(text) for name, text in PAGE.render(fallen.store).items() if name.endswith(".html"))
    assert powers(said[0]) in html.unescape(page)
    assert UNDROPPED in page


def test_only_what_is_dropped_of_the_robot_makes_a_second_scene(tmp_path: Path) -> None:
    assert imported(tmp_path, ARM).undropped is None
    assert imported(tmp_path, ARM, drop=frozenset({"mimic"})).undropped is None
    one = imported(tmp_path, ARM, drop=frozenset({"armature"}))
    assert one.undropped == imported(tmp_path, ARM).scene
    (joint,) = one.scene.joints
    assert isinstance(joint, Revolute)
    assert (joint.armature, joint.friction_loss) == (None, DRY)


def test_a_dropped_tie_that_cannot_be_read_is_said(tmp_path: Path) -> None:
    """Its user starts a follower elsewhere than its tie does: with the tie, that is refused."""
    pair = mjcf(
        '<joint name="j" axis="0 1 0"/><inertial pos="0.5 0 0" mass="2" diaginertia="0.02 0.03 0.04"/>'
        '<body name="hand" pos="1 0 0"><joint name="k" axis="0 1 0"/>'
        '<inertial pos="0.1 0 0" mass="1" diaginertia="0.02 0.03 0.04"/></body>',
        '<equality><joint joint1="k" joint2="j" polycoef="0 2 0 0 0"/></equality>',
    )
    free = imported(tmp_path, pair, drop=frozenset({"mimic"}))
    assert free.undropped == imported(tmp_path, pair).scene
    elsewhere = imported(tmp_path, pair, Companion(joints={"k": JointWish(position=0.3)}), drop=frozenset({"mimic"}))
    assert elsewhere.undropped is None
    assert "says where it starts" in row(elsewhere, "drop").consequence


def test_an_alteration_is_read_back() -> None:
    whole = Alteration(name=UNDROPPED, undropped=("armature", "mimic"))
    assert Alteration.from_plain(json.loads(json.dumps(whole.plain()))) == whole
