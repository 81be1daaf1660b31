"""Up to when a motion can be foreseen: by perturbed starts that part on most engines, not by steps that do not agree."""

import numpy as np
import pytest

from plumbline.harness.findings.agreement.perturbed_starts import Outlook, _parted, foreseeable_until
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.findings.agreement.words import beyond_words
from plumbline.harness.scene import Body, Scene
from plumbline.harness.search.own_limits import OwnLimit
from plumbline.harness.statistics.student import mean_of
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.parting import NOTHING, extent

BALL = Scene(bodies=(Body.ball("ball", 0.1),))
TIME = np.arange(181) / 60


def outlook(engine: str, parted: float | None, track: str = "tuned") -> Outlook:
    mean = mean_of([1.0, 1.1])
    return Outlook(
        case="c", engine=engine, track=track, parted=parted, since=0.4, starts=8, dt=1e-3, substeps=1, speed=mean, height=mean,
        spread=mean, last_speed=mean,
    )  # fmt: skip


def agreement(*engines: str) -> Agreement:
    nothing = OwnLimit(kind="converges", horizons={}, rungs=())
    sides = [Side(engine=name, track="tuned", ours=name == "ours", word="converges", why="", limit=nothing) for name in engines]
    return Agreement(case="c", where="", duration=3.0, scale=NOTHING, granted=0.0, sides=tuple(sides), differences=())


def test_most_engines_have_to_part() -> None:
    sides = agreement("a", "b", "c", "ours")
    together, apart = [outlook("a", None), outlook("b", None)], outlook("c", 0.8)
    assert foreseeable_until(sides, [*together, apart]) is None
    assert foreseeable_until(sides, [outlook("a", 0.5), outlook("b", None), apart]) == 0.8
    assert foreseeable_until(sides, [*together, apart, outlook("ours", 0.3)]) is None
    assert foreseeable_until(sides, []) is None


def test_the_tuned_track_speaks_for_an_engine() -> None:
    both = [outlook("a", 0.2, "default"), outlook("a", None), outlook("b", 0.5)]
    assert foreseeable_until(agreement("a", "b"), both) is None
    assert foreseeable_until(agreement("a", "b"), both[:1] + both[2:]) == 0.5


def test_no_sentence_says_that_nothing_can_be_foreseen_where_starts_stay_together() -> None:
    sides = agreement("a", "b", "c")
    (calm,) = beyond_words([], [outlook(name, None) for name in "abc"], sides, {})
    assert calm == "Of 8 perturbed starts on each engine all stay together."
    (own,) = beyond_words([], [outlook("a", 0.8), outlook("b", None), outlook("c", None)], sides, {})
    assert own.startswith("Perturbed starts part on a tuned (0.8 s) and stay together on most engines")
    first, second = beyond_words([], [outlook(name, 0.8) for name in "abc"], sides, {})
    assert first.endswith("beyond 0.8 s poses cannot be foreseen.")
    assert second.startswith("Means over 8 of them from 0.4 s on: a tuned rms speed 1.05")


def runs(*paths: Floats) -> list[dict[str, Floats]]:
    still = np.zeros((len(TIME), 1, 4))
    still[..., 0] = 1.0
    at = [np.stack([path, 0 * TIME, 0 * TIME], axis=1)[:, None] for path in paths]
    return [{"time": TIME, "p_WB": p, "q_WB": still, "v_WB": 0 * p, "w_WB": 0 * p} for p in at]


def test_starts_that_fall_apart_by_the_tilt_alone_have_not_parted() -> None:
    """Gravity that differs by 2e-4 leads what flies g t^2 1e-4 aside, 8.8 mm in 3 s: a twelfth of the ball's size."""
    scale, fall = extent(BALL), 9.81 * TIME**2 * 1e-4
    assert fall[-1] > 3 * 0.01 * float(scale.size[0])
    assert _parted(runs(0 * TIME, fall), BALL, scale) is None
    chaos = 1e-4 * np.exp(3 * TIME)
    parted = _parted(runs(0 * TIME, 0 * TIME, chaos), BALL, scale)
    # 1 % of the size and twice the fall, met by exp(3 t): between 1 and 2 s.
    allowed = 0.01 * float(scale.size[0]) + 4e-4 * (float(scale.size[0]) + 9.81 * TIME**2 / 2)
    assert parted == pytest.approx(TIME[np.flatnonzero(chaos > allowed)[0]])
