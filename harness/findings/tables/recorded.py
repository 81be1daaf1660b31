"""A recorded robot beside every engine: how far its joints are off, and what friction, damping or a delay would explain of it.

The error of a joint is what was measured less the finest run of an engine's track. Each fit stands alone and is no proof:

* delay: the run is taken `delay` later, the one of 0..`LATEST` in steps of a millisecond that leaves least.
* friction, damping: what the drive of the joint, and the inertia that it carries at the start, answer to a torque -sign(x')
  or -x' of the measured motion: I r'' + (d + c) r' + (k + s) r = torque, with the drive's d and k and the spring's c and s.
  The error is fitted by a multiple of r, which is then the dry friction [N m, N] or the damping [N m s, N s/m] that the
  model lacks.

The share explained is 1 less the sum of squares that is left over that before.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.findings.columns import Column, Table, names, plain
from plumbline.harness.findings.once import once
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import Prismatic, Revolute, Scene
from plumbline.harness.store.imported_scenes import states_of
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import carried, joint_coordinate


def _explains(name: str) -> Column:
    return Column("explains", lambda row: f"{100 * getattr(row, f'{name}_explains'):.0f} %")


LATEST = 0.2
"""Seconds: the longest delay that is looked for."""
FINE = 1e-3
"""Seconds: of its grid, and at most of the steps in which an answer to a torque is worked out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JointError:
    """One joint on one engine and track.

    Terms: rms, largest [rad or m]: of the error up to `until` [s]. friction, damping, delay: fitted, in the joint's units and
    seconds; friction_explains, damping_explains, delay_explains: the share of the error that each alone takes away.
    """

    case: str
    engine: str
    track: str
    joint: str
    unit: str
    until: float
    rms: float
    largest: float
    friction: float
    friction_explains: float
    damping: float
    damping_explains: float
    delay: float
    delay_explains: float
    trial: str


@once
def joint_errors(store: Store) -> tuple[JointError, ...]:
    """Of all scenes that a recorded robot stands beside."""
    return tuple(error for agreement in agreements(store) for error in _of(store, agreement))


def _of(store: Store, agreement: Agreement) -> Iterator[JointError]:
    measured, scene = states_of(store.folder, agreement.case), agreement.scene
    if measured is None or scene is None:
        return
    joints = {joint.name: joint for joint in scene.joints if isinstance(joint, Revolute | Prismatic)}
    if strangers := [name for name in measured["positions"] if name not in joints]:
        raise StoreError(
            f"{store.folder}: {measured['source']} has positions of {quoted(strangers[0])}, no joint of {agreement.case}"
        )
    for side in agreement.sides:
        rung = side.limit.finest
        if rung is None or rung.run is None:
            continue
        run = rung.run
        within = run.time <= measured["time"][-1] + 1e-9
        time = run.time[within]
        for name, values in measured["positions"].items():
            joint = joints[name]
            truth, model = np.interp(time, measured["time"], values), joint_coordinate(scene, joint, run)[within]
            error, rate = truth - model, np.gradient(truth, time)
            friction, damping = (_answering(error, _answer(scene, joint, torque, time)) for torque in (-np.sign(rate), -rate))
            delay = _delayed(time, truth, model)
            yield JointError(
                case=agreement.case, engine=side.engine, track=side.track, joint=name,
                unit="rad" if isinstance(joint, Revolute) else "m", until=float(time[-1]),
                rms=float(np.sqrt(np.mean(error**2))), largest=float(np.abs(error).max()), friction=friction[0],
                friction_explains=friction[1], damping=damping[0], damping_explains=damping[1], delay=delay[0],
                delay_explains=delay[1], trial=rung.trial,
            )  # fmt: skip


def _answering(error: Floats, answer: Floats) -> tuple[float, float]:
    """The multiple of an answer that fits an error best, none below 0, and the share that it takes away."""
    own, whole = float(answer @ answer), float(error @ error)
    size = max(float(answer @ error) / own, 0.0) if own > 0 else 0.0
    return size, 1 - float(np.sum((error - size * answer) ** 2)) / whole if whole > 0 else 0.0


def _delayed(time: Floats, truth: Floats, model: Floats) -> tuple[float, float]:
    whole = float(np.sum((truth - model) ** 2))
    delays = np.arange(0.0, min(LATEST, float(time[-1]) / 2) + FINE / 2, FINE)
    left = [float(np.sum((truth - np.interp(time - delay, time, model)) ** 2)) for delay in delays]
    best = int(np.argmin(left))
    return float(delays[best]), 1 - left[best] / whole if whole > 0 else 0.0


def _answer(scene: Scene, joint: Revolute | Prismatic, torque: Floats, time: Floats) -> Floats:
    """What a joint's coordinate does under a torque (t,) of 1 beside its drive, from rest, by implicit steps of FINE."""
    spring, drive = joint.spring, joint.drive
    k = (spring.stiffness if spring else 0.0) + (drive.stiffness if drive else 0.0)
    d = (spring.damping if spring else 0.0) + (drive.damping if drive else 0.0)
    inertia = carried(scene, joint)
    at = np.arange(0.0, float(time[-1]) + FINE / 2, FINE)
    push = torque[np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 1)]
    x = v = 0.0
    path = np.zeros(len(at))
    for step in range(1, len(at)):
        v = (inertia * v + FINE * (push[step] - k * x)) / (inertia + FINE * d + FINE**2 * k)
        x += FINE * v
        path[step] = x
    answer: Floats = np.interp(time, at, path)
    return answer


def recorded_words(errors: Sequence[JointError], titles: Mapping[str, str]) -> list[str]:
    """For each engine and track the joint that is farthest off, and the fit that explains most of its error."""
    lines = []
    for engine, track in dict.fromkeys((error.engine, error.track) for error in errors):
        worst = max((error for error in errors if (error.engine, error.track) == (engine, track)), key=lambda error: error.rms)
        force = {"rad": "N m", "m": "N"}[worst.unit]
        fits = [
            (worst.friction_explains, f"a dry friction of {worst.friction:.3g} {force}"),
            (worst.damping_explains, f"a damping of {worst.damping:.3g} {force} s/{worst.unit}"),
            (worst.delay_explains, f"a delay of {1e3 * worst.delay:.0f} ms"),
        ]
        share, words = max(fits)
        fit = f"; {words} alone would explain {100 * share:.0f} % of it (a fit)" if share >= 0.01 else "; no fit explains it"
        who = f"{titles.get(engine, engine)}, {track}: '{worst.joint}'"
        lines.append(f"{who} is {worst.rms:.3g} {worst.unit} rms off the recorded robot, {worst.largest:.3g} at most{fit}.")
    return lines


TABLE = Table(
    holds=names(JointError),
    objects=joint_errors,
    shown=(
        *plain("engine", "track", "joint"),
        Column("rms", lambda row: f"{row.rms:.3g} {row.unit}"),
        *plain("largest=largest:.3g", "friction (fit)=friction:.3g"),
        _explains("friction"),
        Column("damping (fit)", "damping", ".3g"),
        _explains("damping"),
        Column("delay (fit)", "delay", ".3g", " s"),
        _explains("delay"),
    ),
    sentences=lambda errors: recorded_words(errors, {}),
)
