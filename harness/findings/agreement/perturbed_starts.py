"""What stays defined beyond the horizon: what each run shows of itself, and means over ensembles of perturbed starts.

Where neighbouring runs part, no pose can be right or wrong. Laws can: energy is not won from nothing, joints hold, bodies do
not share space, contacts push and do not pull. Each is judged by the hundredth that poses are judged by, of what it is
measured in: the energy in play, the size of what moves, the weight. And means over starts can be compared, with their
intervals.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.case.starts import TOLERANCE as BUILT
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.findings.parameter_words import substeps_of
from plumbline.harness.findings.spoken import SPOKEN
from plumbline.harness.scene import Scene
from plumbline.harness.scene.file import parse
from plumbline.harness.search.own_limits import ANSWERED, TOLERANCE, place_of
from plumbline.harness.search.refined_ladder import start_name
from plumbline.harness.statistics.student import Mean, mean_of
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import movable, rotate_back
from plumbline.harness.trajectory.parting import Extent, apart, common

_STATES = ("time", "p_WB", "q_WB", "v_WB", "w_WB")

LAWS: Mapping[str, str] = SPOKEN["laws"]
"""Metrics, and what they are called in a sentence."""
OBSERVED = ("signorini_residual", "cone_residual", "dissipation_residual")
"""Shown and not judged: a blow is thousands of weights within a step, and a ten-thousandth of it more than a hundredth of
one."""
LENGTHS = ("joint_gap_max", "penetration")
"""Measured in metres: what they are a share of is the size of what moves."""
LAST = 0.1
"""Of the run: at its end things are at rest or not."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Balance:
    """One law in the finest run of an engine. Terms: value: as a share of the energy in play, the size or the weight; radians
    where it is an angle. holds: is it within a hundredth? None where that is not asked."""

    case: str
    engine: str
    track: str
    law: str
    value: float
    holds: bool | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Outlook:
    """What an engine's perturbed starts come to beyond the horizon, as means with intervals.

    Terms:
        parted [s]: from then on they lie apart by more than the tolerance and what gravity's tilt does to a free fall; None
        where they never do. since [s]: from then on the means are taken. starts: how many. dt [s], and the sub-steps that it
        was taken in. speed: root mean square of the bodies' speed [sizes per second]. height: of the common centre of mass
        above its start [sizes]. spread: root mean square distance of bodies from it [sizes]. last_speed: as speed, over the
        last tenth of the run.
    """

    case: str
    engine: str
    track: str
    parted: float | None
    since: float
    starts: int
    dt: float
    substeps: int
    speed: Mean
    height: Mean
    spread: Mean
    last_speed: Mean


def horizon_of(agreement: Agreement) -> float:
    """The time [s] from which no pose is known any more: where the last limit of a side ends that is known at all."""
    return agreement.until if agreement.limit is not None else max((side.limit.until for side in agreement.sides), default=0.0)


def balances(store: Store, agreement: Agreement) -> list[Balance]:
    """The laws that could be measured, in each side's finest run that answered."""
    table = store.measurements
    largest = float(agreement.scale.size.min(initial=np.inf))
    measured = []
    for side in agreement.sides:
        mine = table[:0] if side.limit.finest is None else table[table["trial"] == side.limit.finest.trial]
        for row in mine.to_dict("records"):
            value = float(row["value"])
            if row["metric"] in LAWS and np.isfinite(value):
                share = value / largest if row["metric"] in LENGTHS else value
                measured.append(
                    Balance(
                        case=agreement.case, engine=side.engine, track=side.track, law=str(row["metric"]), value=share,
                        holds=None if row["metric"] in OBSERVED else share <= TOLERANCE,
                    )
                )  # fmt: skip
    return measured


def outlooks(store: Store, agreement: Agreement) -> list[Outlook]:
    """The ensemble result of each track that was run from perturbed starts."""
    trials = store.trials
    names = trials["alteration"].str.contains(f'"name": "{start_name(1)[:-1]}', regex=False)
    rows = trials[(trials["case"] == agreement.case) & names & trials["status"].isin(ANSWERED)]
    since, ensembles = horizon_of(agreement), []
    for (engine, track), members in rows.groupby(["engine", "track"], sort=False):
        runs = [store.trajectory(name) for name in members["trajectory_hash"]]
        scene = parse(str(runs[0]["scene"]), "scene.json")
        numbers = [_numbers(run, scene, agreement.scale, since) for run in runs]
        ensembles.append(
            Outlook(
                case=agreement.case,
                engine=str(engine),
                track=str(track),
                parted=_parted(runs, scene, agreement.scale),
                since=since,
                starts=len(runs),
                dt=float(members["dt"].iloc[0]),
                substeps=substeps_of(str(members["resolved"].iloc[0])),
                **{name: mean_of([each[name] for each in numbers]) for name in ("speed", "height", "spread", "last_speed")},
            )
        )
    return ensembles


def foreseeable_until(agreement: Agreement, ensembles: Sequence[Outlook]) -> float | None:
    """The time [s] from which poses cannot be foreseen: by then neighbouring starts have parted on most engines that people can
    deploy, each on its tuned track where it has one. None where they stay together: what parts on few is theirs."""
    ours = {side.engine for side in agreement.sides if side.ours}
    by_engine: dict[str, float] = {}
    for each in sorted(ensembles, key=lambda each: each.track != "tuned"):
        if each.engine not in ours:
            by_engine.setdefault(each.engine, np.inf if each.parted is None else each.parted)
    ranked = sorted(by_engine.values())
    most = ranked[len(ranked) // 2] if ranked else np.inf
    return most if np.isfinite(most) else None


def _parted(runs: Sequence[Mapping[str, Any]], scene: Scene, scale: Extent) -> float | None:
    """When [s] the starts of an ensemble have parted from the first of them; None where they stay together.

    Two starts differ by 2 `BUILT` of a width and of gravity's direction, and what flies is g t^2 / 2 times that off; as much
    again where it rolls, since it turns then about a point no nearer than its radius of gyration.
    """
    first, *others = common([Trajectory(*(run[name] for name in _STATES)) for run in runs])
    tilt = 4 * BUILT * (1.0 + float(np.linalg.norm(scene.gravity)) * first.time**2 / 2 / float(scale.size.min(initial=np.inf)))
    far = np.max([apart(other, first, scale) for other in others], axis=0, initial=0.0)
    beyond = np.flatnonzero(far > TOLERANCE + tilt)
    return float(first.time[beyond[0]]) if len(beyond) else None


def _numbers(run: Mapping[str, Any], scene: Scene, scale: Extent, since: float) -> dict[str, float]:
    """The statistics of one run."""
    places, time = movable(scene), run["time"]
    size = scale.largest
    mass = np.array([scene.bodies[index].mass for index in places.tolist()])
    share = mass / mass.sum()
    start, end = place_of(time, since), place_of(time, float(time[-1]) * (1 - LAST))
    speed = _speeds(run, scene, places.tolist(), share)
    centre = np.einsum("i,tij->tj", share, run["p_WB"][:, places])
    up = -np.array(scene.gravity) / max(float(np.linalg.norm(scene.gravity)), 1e-300)
    off = np.linalg.norm(run["p_WB"][:, places] - centre[:, None], axis=-1)
    return {
        "speed": float(np.sqrt(np.mean(speed[start:]))) / size,
        "height": float(np.mean((centre[start:] - centre[0]) @ up)) / size,
        "spread": float(np.sqrt(np.mean(off[start:] ** 2 @ share))) / size,
        "last_speed": float(np.sqrt(np.mean(speed[end:]))) / size,
    }


def _speeds(run: Mapping[str, Any], scene: Scene, places: Sequence[int], share: Floats) -> Floats:
    """Twice the kinetic energy over the mass, (t,) m2/s2: turning counts as it does in energy."""
    total = np.zeros(len(run["time"]))
    for weight, index in zip(share, places, strict=True):
        body = scene.bodies[index]
        w_B = rotate_back(run["q_WB"][:, index], run["w_WB"][:, index])
        total += weight * np.sum(run["v_WB"][:, index] ** 2, axis=1)
        total += weight / body.mass * np.einsum("ti,ij,tj->t", w_B, np.array(body.inertia), w_B)
    return total
