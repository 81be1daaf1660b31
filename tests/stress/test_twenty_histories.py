"""Forty planted histories: what each night says of them, and how its gate ends. The table of docs/nightly.md is made here.

Two engines, two cases, sixteen answers a night, clocks by formula with noise of one per cent where nothing else is said.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from datetime import datetime, timedelta, tzinfo
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plumbline.harness.case import Case
from plumbline.harness.history import folder, night_policy
from plumbline.harness.history import night as night_module
from plumbline.harness.history.folder import opened
from plumbline.harness.history.night_policy import NightWish
from plumbline.harness.history.sentences import open_since, reasons, without_answers
from plumbline.harness.run import campaign, resume
from plumbline.harness.store.machine_fingerprint import fingerprint
from plumbline.harness.store.record import Record
from plumbline.harness.study import plugins
from tests import nights as planting
from tests.nights import NONE, STUDY, Fault, asked, drawn, night, one_ulp_off, planted, rougher
from tests.unit.test_gate import restless

DOCUMENT = Path(__file__).parents[2] / "docs" / "nightly.md"
ENGINES = ("reference", "mujoco")
ANY = -1


@contextmanager
def crash(engine: str, fault: Fault = NONE, case: str = "") -> Iterator[None]:
    """Every answer of an engine, or of a case on it, is a crash, beside a fault in another."""
    with planted(fault):
        answers, sources = campaign.run_isolated, campaign.sources_of

        def dead(*arguments: Any) -> Iterator[Record]:
            for record in answers(*arguments):
                lost = replace(record, status="crashed", reason="signal 11", measurements=(), trajectory_hash=None, warnings=())
                yield lost if record.engine == engine and case in ("", record.case) else record

        def others(name: str, of: str) -> dict[str, str]:
            return {**sources(name, of), **({"adapter": "that crashes"} if of == engine else {})}

        campaign.run_isolated, campaign.sources_of = dead, others
        yield


@contextmanager
def version(number: str, fault: Fault = NONE) -> Iterator[None]:
    """Both engines are of another version."""
    with pytest.MonkeyPatch.context() as patch, planted(fault):
        patch.setattr(campaign, "version_of", lambda _adapter: (number, None))
        yield


@contextmanager
def noise(share: float, fault: Fault = NONE) -> Iterator[None]:
    """Samples stray by so much."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(planting, "NOISE", share)
        with planted(fault):
            yield


@contextmanager
def clock(days: float, fault: Fault = NONE) -> Iterator[None]:
    """The machine's clock is so far ahead of this one."""

    class Shifted(datetime):
        @classmethod
        def now(cls, tz: tzinfo | None = None) -> datetime:  # type: ignore[override]
            return datetime.now(tz) + timedelta(days=days)

    with pytest.MonkeyPatch.context() as patch, planted(fault):
        for module in (night_module, folder):
            patch.setattr(module, "datetime", Shifted)
        yield


@contextmanager
def other_machine(fault: Fault = NONE, slow: float = 1.6) -> Iterator[None]:
    """Another machine, on which everything is so many times as dear."""

    def named() -> dict[str, Any]:
        return {**fingerprint(), "processor": "another"}

    with pytest.MonkeyPatch.context() as patch, planted(fault):
        for module in (campaign, night_policy):
            patch.setattr(module, "fingerprint", named)
        patch.setattr(planting, "SLOW", slow)
        yield


@contextmanager
def other_parameters(fault: Fault = NONE) -> Iterator[None]:
    """One case is of other parameters than before."""
    plain = plugins.case

    def case(name: str) -> Case:
        found = plain(name)
        return replace(found, parameters=replace(found.parameters, speed=2.5)) if name == "friction_stop" else found

    with pytest.MonkeyPatch.context() as patch, planted(fault):
        patch.setattr(plugins, "case", case)
        yield


class Killed(BaseException):
    """What a killed night ends by."""


@contextmanager
def dying(fault: Fault = NONE) -> Iterator[None]:
    """The night is killed behind five answers."""
    with planted(fault):
        answers = campaign.run_isolated

        def until_dead(*arguments: Any) -> Iterator[Record]:
            yield from islice(answers(*arguments), 5)
            raise Killed

        campaign.run_isolated = until_dead
        yield


@contextmanager
def gone_on(fault: Fault) -> Iterator[None]:
    """By an engine of other sources than when the night began."""
    with pytest.MonkeyPatch.context() as patch, planted(fault):
        patch.setattr(resume, "what_changed", lambda _case, engine, *_: "its source" if engine == fault.engine else "")
        yield


@contextmanager
def unstable(slow: float) -> Iterator[None]:
    """Our engine's samples stray by half, and one case is so many times as dear."""
    with planted():
        campaign.clock_group = restless({"friction_stop": slow}, [])
        yield


@dataclass(frozen=True)
class Planted:
    """Terms: nights: what each stands under; asks: what those ask that do not ask for all. codes: of the gate on both engines;
    none where any night may be the one that ends with 1. says: by the number of a night from 0, or of `ANY`, what stands in its
    lines; '' for none of any change."""

    name: str
    nights: Sequence[Callable[[], AbstractContextManager[Any]]]
    codes: Sequence[int]
    says: dict[int, str]
    asks: dict[int, Callable[[], NightWish]] | None = None
    share: float = 0.0
    killed: tuple[int, ...] = ()


def dear(times: float, engine: str = "reference", scene: Any = planting._as_it_is) -> Callable[[], AbstractContextManager[Any]]:
    return partial(planted, Fault(engine=engine, price=times, scene=scene))


sound = partial(planted, NONE)
rough = dear(1.0, scene=rougher)
only_mujoco = partial(asked, engines=("mujoco",))
only_flight = partial(asked, replace(STUDY, experiments=STUDY.experiments[1:]))
default_alone = partial(asked, replace(STUDY, experiments=tuple(replace(e, tracks=("default",)) for e in STUDY.experiments)))
other_study = partial(asked, replace(STUDY, name="other"))
fewer_steps = partial(asked, replace(STUDY, experiments=(STUDY.experiments[0], replace(STUDY.experiments[1], dt=(1 / 60,)))))
renamed = partial(asked, replace(STUDY, experiments=tuple(replace(e, name=f"{e.name}_2") for e in STUDY.experiments)))
HISTORIES = (
    Planted("a step of 15 %", (sound, dear(1.15), dear(1.15)), (0, 1, 0), {1: "reference: as a whole", 2: ""}),
    Planted("a step of 30 % in the other engine", (sound, dear(1.3, "mujoco")), (0, 1), {1: "mujoco: as a whole"}),
    Planted("a step down by 20 %", (sound, dear(0.8)), (0, 0), {1: "cheaper"}),
    Planted("a step of 3 %, below what one night tells", (sound, dear(1.03), dear(1.03)), (0, 0, 0), {1: "", 2: ""}),
    Planted("a spike of 50 %", (sound, dear(1.5), sound), (0, 1, 0), {1: "as a whole", 2: "cheaper"}),
    Planted(
        "a drift of 0.7 % a night over 33, noise of 2 %",
        tuple(dear(1.007**k * float(np.exp(stray))) for k, stray in enumerate(np.random.default_rng(5).normal(0, 0.02, 33))),
        (),
        {ANY: "reference: as a whole"},
    ),
    Planted("3 % more friction", (sound, rough, rough), (0, 1, 0), {1: "friction_stop on reference", 2: ""}),
    Planted("the same, mended", (sound, rough, sound), (0, 1, 0), {2: "now passed"}),
    Planted(
        "one last bit by another source",
        (sound, partial(planted, Fault(engine="reference", state=one_ulp_off)), sound),
        (0, 0, 0),
        {1: ""},
    ),
    Planted(
        "one last bit under the same digest",
        (sound, partial(planted, Fault(engine="mujoco", state=one_ulp_off, known=False))),
        (0, 1),
        {1: "same digest, another answer"},
        share=1.0,
    ),
    Planted(
        "a crash", (sound, partial(crash, "mujoco"), partial(crash, "mujoco")), (0, 1, 1), {1: "lost: crashed", 2: "no answer"}
    ),
    Planted("a crash, repaired", (sound, partial(crash, "mujoco"), sound), (0, 1, 0), {2: "crashed, now passed"}),
    Planted(
        "a crash, repaired with a fault",
        (sound, partial(crash, "reference"), rough),
        (0, 1, 1),
        {2: "passed, now failed"},
    ),
    Planted("a crash from the first night on", (partial(crash, "mujoco"),) * 2, (1, 1), {0: "no answer", 1: "no answer"}),
    Planted(
        "one case that crashes",
        (sound, partial(crash, "mujoco", case="friction_stop"), sound),
        (0, 1, 0),
        {1: "friction_stop on mujoco", 2: "crashed, now"},
    ),
    Planted("a new version, nothing else", (sound, partial(version, "9.0")), (0, 0), {1: ""}),
    Planted(
        "a new version that is 30 % dearer",
        (sound, partial(version, "9.0", Fault(engine="mujoco", price=1.3))),
        (0, 1),
        {1: "dearer"},
    ),
    Planted(
        "a night of the other engine alone, then a fault",
        (sound, sound, rough),
        (0, 0, 1),
        {2: "friction_stop on reference"},
        asks={1: only_mujoco},
    ),
    Planted(
        "a night of one case alone, then a fault", (sound, sound, rough), (0, 0, 1), {2: "friction_stop"}, asks={1: only_flight}
    ),
    Planted(
        "a night of one track alone, then 30 % dearer",
        (sound, sound, dear(1.3)),
        (0, 0, 1),
        {2: "dearer: 1.3 times"},
        asks={1: default_alone},
    ),
    Planted("noise of 4 % alone, six nights", (partial(noise, 0.04),) * 6, (0,) * 6, dict.fromkeys(range(1, 6), "")),
    Planted("two at once in one engine", (sound, dear(1.25, scene=rougher)), (0, 1), {1: "friction_stop on reference"}),
    Planted(
        "two at once: a crash, and the other dearer",
        (sound, partial(crash, "mujoco", Fault(engine="reference", price=1.3))),
        (0, 1),
        {1: "lost: crashed"},
    ),
    Planted("dearer by clocks that stray", (partial(unstable, 1.0), partial(unstable, 3.1)), (0, 0), {1: "unconfirmed"}),
    Planted(
        "five nights of another study, then a fault",
        (*(sound,) * 6, rough),
        (*(0,) * 6, 1),
        {6: "friction_stop on reference"},
        asks=dict.fromkeys(range(1, 6), other_study),
    ),
    Planted(
        "five nights of fewer steps, then 30 % dearer with a fault",
        (*(sound,) * 6, dear(1.3, scene=rougher)),
        (*(0,) * 6, 1),
        {6: "friction_stop on reference"},
        asks=dict.fromkeys(range(1, 6), fewer_steps),
    ),
    Planted("a rise of 1 % a night over 33", tuple(dear(1.01**k) for k in range(33)), (), {ANY: "reference: as a whole"}),
    Planted("a rise of 3 % a night over 12", tuple(dear(1.03**k) for k in range(12)), (), {4: "reference: as a whole"}),
    Planted(
        "a new version by its suffix alone, dearer with a fault",
        (partial(version, "3.3.0"), partial(version, "3.3.0.post1", Fault(engine="reference", price=1.3, scene=rougher))),
        (0, 1),
        {1: "friction_stop on reference"},
    ),
    Planted(
        "a fault in the night in which the experiments are renamed",
        (sound, rough, rough),
        (0, 1, 0),
        {1: "friction_stop on reference"},
        asks={1: renamed, 2: renamed},
    ),
    Planted(
        "the clock set back by a day, then a fault",
        (partial(clock, 1.0), sound, rough),
        (0, 0, 1),
        {1: "", 2: "friction_stop on reference"},
    ),
    Planted(
        "the clock set back by an hour in the night of a fault",
        (sound, partial(clock, -1 / 24, Fault(engine="reference", scene=rougher))),
        (0, 1),
        {1: "friction_stop on reference"},
    ),
    Planted(
        "one night named a month ahead, then 20 % dearer",
        (sound, partial(clock, 30.0), dear(1.2)),
        (0, 0, 1),
        {1: "", 2: "reference: as a whole"},
    ),
    Planted("a night on a slower machine, nothing else", (sound, other_machine, sound), (0, 0, 0), {1: "", 2: ""}),
    Planted(
        "a fault in the night on a slower machine",
        (sound, partial(other_machine, Fault(engine="reference", scene=rougher))),
        (0, 1),
        {1: "friction_stop on reference"},
    ),
    Planted(
        "20 % dearer in the night on a slower machine",
        (sound, partial(other_machine, Fault(engine="reference", price=1.2))),
        (0, 0),
        {1: ""},
    ),
    Planted(
        "20 % dearer behind a night on a slower machine",
        (sound, other_machine, dear(1.2)),
        (0, 0, 1),
        {2: "reference: as a whole"},
    ),
    Planted(
        "a night killed half-way, gone on with by an engine with a fault",
        (sound, dying, partial(gone_on, Fault(engine="reference", scene=rougher))),
        (0, 1),
        {1: "friction_stop on reference"},
        share=1.0,
        killed=(1,),
    ),
    Planted(
        "a night killed half-way, gone on with 20 % dearer",
        (sound, dying, partial(planted, Fault(engine="reference", price=1.2, known=False))),
        (0, 1),
        {1: "reference: as a whole"},
        share=1.0,
        killed=(1,),
    ),
    Planted(
        "a fault in the night that changes a case's parameters",
        (sound, partial(other_parameters, Fault(engine="reference", scene=rougher))),
        (0, 0),
        {1: ""},
    ),
)


def carried_out(history: Planted, root: Path) -> Iterator[tuple[int, list[str], int]]:
    """Of each night the exit code of its gate, its sentences, and how many regressions of earlier nights still stand."""
    for number, under in enumerate(history.nights):
        with pytest.MonkeyPatch.context() as patch:
            drawn(patch, history.share)
            if number in history.killed:
                with under(), pytest.raises(Killed):
                    night(root, asked())
                continue
            with under():
                last, news, account = night(root, ((history.asks or {}).get(number) or asked)())
        said = [*(row["sentence"] for row in account["told"]), *without_answers(account, ENGINES)]
        said += [f"{row['sentence']}" for row in account["unconfirmed"]]
        before = [each.plan for each in opened(root).whole_nights() if each != last]
        yield int(bool(reasons(news, account, ENGINES, 0.0))), said, len(open_since(before, {}, (), account["told"]))


def in_words(code: int, said: Sequence[str], standing: int) -> str:
    """A night in a cell of the table: what weighs most, how many more there are, and how the gate ends."""
    first = said[0].split(": stop_distance")[0].rstrip(".").replace("|", "/") if said else "nothing"
    first = re.sub(r"since \d{8}T\d{6}Z", "since an earlier night", first)
    more = f" (+{len(said) - 1})" if len(said) > 1 else ""
    return f"{first}{more}{f'; {standing} still worse' if standing else ''}{', **exit 1**' if code else ''}"


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("history", HISTORIES, ids=lambda history: history.name)
def test_each_night_of_a_planted_history_says_what_was_planted(history: Planted, tmp_path: Path) -> None:
    nights = list(carried_out(history, tmp_path / "h"))
    print(f"ROW| {history.name} | {' / '.join(in_words(*each) for each in nights if each[1] or each is nights[-1])} |")
    for number, words in history.says.items():
        said = nights[number][1] if number != ANY else [text for _, texts, _ in nights for text in texts]
        assert any(words in text for text in said) if words else not said, (number, said)
    codes = [code for code, _, _ in nights]
    assert codes == list(history.codes) if history.codes else 1 in codes
    assert f"| {history.name} |" in DOCUMENT.read_text()
