"""Where a night's searches begin: limits at the brackets that were found, prices on the fronts that are known."""

from dataclasses import replace
from pathlib import Path

import pytest

from plumbline.harness.findings.limits_found import searches
from plumbline.harness.history.folder import Night
from plumbline.harness.history.known_searches import BESIDE
from plumbline.harness.scene import Scene
from plumbline.harness.study.experiment import Experiment, Limit
from plumbline.harness.study.study import Study
from plumbline.harness.trajectory import State
from tests.nights import Fault, asked, drawn, night, planted

LIMIT = Study(
    name="limit",
    recordings=False,
    experiments=(
        Experiment(
            name="speeds",
            cases=("spin_fast",),
            tracks=("tuned",),
            timing=False,
            limit=Limit(scan=3, within=2.0, members=2, parts=(1,)),
        ),
    ),
)
FRONT = Study(
    name="front",
    recordings=False,
    experiments=(Experiment(name="fronts", cases=("flight_projectile",), dt=(1 / 60, 1 / 240), sweep=4, samples=3),),
)


def brackets(last: Night) -> set[tuple[float | None, float | None]]:
    """What the searches of a night found."""
    return {(search.held, search.broke) for search in searches(last.store())}


def test_a_limit_is_tried_at_its_bracket_and_searched_where_that_moved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn(monkeypatch, 0.0)
    what, root = asked(LIMIT, engines=("mujoco",)), tmp_path / "h"
    with planted() as computed:
        first_night, _, _ = night(root, what)
    (held, broke) = next(iter(brackets(first_night)))
    assert held is not None
    assert broke is not None
    assert len(computed) > 3
    with planted() as recalled:
        second, _, _ = night(root, what)
    assert recalled == []
    assert brackets(second) == {(held, broke)}
    with planted(Fault(engine="mujoco")) as tried:
        third, news, _ = night(root, what)
    assert brackets(third) == {(held, broke)}
    assert len(tried) == 3  # the study's own first value, what held, what broke
    assert news is not None
    assert not [row for row in news.changes.rows if row.kind == "limit"]
    with planted(Fault(engine="mujoco", scene=faster)):
        _, worse, _ = night(root, replace(what, gated=("mujoco",)))
    assert worse is not None
    assert "limit" in {row.kind for row in worse.regressions(("mujoco",))}


def faster(scene: Scene) -> Scene:
    """Every body spins twenty times as fast as was asked: what is asked breaks so much earlier."""
    return replace(scene, bodies=tuple(replace(body, w_WB=tuple(20.0 * speed for speed in body.w_WB)) for body in scene.bodies))


def far_off(state: State) -> None:
    """Where no joint holds a body."""
    state.p_WB[:] += 10.0


def test_a_front_is_clocked_again_without_being_searched_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn(monkeypatch, 0.0)
    what, root = asked(FRONT, engines=("mujoco",)), tmp_path / "h"
    with planted() as searched:
        first_night, _, all_clocked = night(root, what)
    with planted() as recalled:
        second, _, account = night(root, what)
    assert recalled == []
    assert len(second.store().trials) == len(first_night.store().trials)
    assert BESIDE <= account["clocked"] <= all_clocked["clocked"]
    with planted(Fault(engine="mujoco")) as again:
        third, _, changed = night(root, what)
    # The four of the study, the front and two beside it, which may be among the four: prices decide. No knob is turned anew.
    assert 4 <= len(again) < len(searched)
    assert len(again) == len(third.store().trials)
    assert changed["clocked"] > 0
    front = third.store().trials
    with planted(Fault(engine="mujoco", state=far_off)) as anew:
        night(root, what)
    assert len(anew) > len(front)
