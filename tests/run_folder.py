"""A run folder as the store keeps it, written from formulas: every status, every kind of gap, and names that attack.

The numbers are made, not measured: error = C dt^p + floor and cost = K / dt. Nothing in it says anything about a real engine.
"""

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import pandas as pd

__all__ = ["BAD_CASE", "HOSTILE", "LADDER", "STATUSES", "write_run_folder"]

STATUSES = ("passed", "failed", "diverged", "unsupported", "unavailable", "timeout", "crashed", "oom", "interrupted")
LADDER = [1 / 60, 1 / 120, 1 / 240, 1 / 480, 1 / 960, 1 / 1920]
HOSTILE = (
    "<script>window.attacked=1</script>",
    "</script><script>window.attacked=1</script>",
    "</title></style></textarea><img src=x onerror=window.attacked=1>",
    "javascript:window.attacked=1",
    "\u202egnp.exe",
    "=cmd|' /C calc'!A0",
    "\x1b[2J\x1b[31mred",
    "'\"><svg onload=window.attacked=1>",
    "{{ 7 * 7 }}",
    "datum.x; window.attacked=1",
    "x" * 1_000_000,
)
BAD_CASE = "bad_<script>window.attacked=1</script>"
ENGINES = {  # name: title, ours, order, error at dt = 1/240, cost per simulated second
    "reference": ("Plumbline reference", True, 2, 1.1e-4, 2.0e-2),
    "mujoco": ("MuJoCo", False, 1, 8.0e-4, 4.1e-3),
    "bullet": ("Bullet", False, 1, 2.3e-3, 6.3e-3),
    "dart": ("DART", False, 1, 1.2e-3, 3.1e-2),
}
CASES = {
    "flight_projectile": ("Thrown body", "position_error", "m", 1.0),
    "spin_asymmetric_top": ("Torque-free asymmetric top", "attitude_error", "rad", 3.0),
    "spin_intermediate_axis": ("Flip about the middle axis", "period_error", "s", 0.2),
    "joint_pendulum": ("Pendulum from 90 degrees", "angle_error", "rad", 5.0),
    "joint_chain": ("Chain with a heavy end", "joint_gap", "m", 0.3),
    "impact_bounce": ("Bouncing sphere", "height_error", "m", 8.0),
    "friction_stop": ("Box sliding to rest", "distance_error", "m", 0.9),
    "friction_creep": ("Box resting on an incline", "creep", "m", 0.05),
    "rest_table": ("Box on a table", "sink", "m", 0.01),
    "stack_tower": ("Tower of ten boxes", "top_offset", "m", 0.5),
}


def catalogue(hostile: bool) -> dict[str, Any]:
    """Cases and engines as a run writes them."""
    cases = {
        name: {
            "name": name,
            "family": name.split("_")[0],
            "title": title,
            "question": f"How far does the {title.lower()} stray from its truth as the time step shrinks?",
            "truth": "closed form" if k % 2 == 0 else "converged reference",
            "effects": ["gravity", "contact", "friction"][: 1 + k % 3],
            "source": "L. D. Landau & E. M. Lifshitz, Mechanics (1976), sec. 36; https://example.org/mechanics",
            "parameters": {"mass": 1.0, "speed": 2.0 + k},
            "duration": 2.0,
            "dt": 1 / 240,
            "ladder": LADDER,
            "headline": metric,
            "scale": scale,
            "converges": "smoothly" if name.split("_")[0] in ("flight", "spin", "joint") else "",
            "hard": {"parameter": "speed", "unit": "m/s", "easy": 1.0, "extreme": 100.0} if k % 3 == 0 else None,
            "checks": [
                {"metric": metric, "unit": unit, "at_most": None, "because": f"g dt t / 2 and {scale} % of room for rounding",
                 "start": 0.0, "end": None},
                {"metric": "energy_drift", "unit": "J", "at_most": 1e-2, "because": "one per cent of the energy at the start",
                 "start": 0.0, "end": 2.0},
            ],
            "bodies": 1 + k,
        }
        for k, (name, (title, metric, unit, scale)) in enumerate(CASES.items())
    }  # fmt: skip
    engines = {
        name: {
            "name": name,
            "title": title,
            "distribution": name,
            "version": "1.2.3",
            "unavailable": None,
            "ours": ours,
            "features": ["sphere", "box", "plane", "revolute"],
            "tracks": {
                "default": {"dt": 1 / 240, "source": "the vendor's defaults"},
                "tuned": {"dt": 1 / 240, "iterations": 50, "options": {"cone": "elliptic", "warm_start": True},
                          "source": "User guide, sec. 4, https://example.org/guide"},
            },
            "orders": {"made": 1 if name == "bullet" else 2},
            "known_failures": {} if ours else {"default/hidden_damping": "linear damping 0.04 unless set to 0"},
            "deviations": ["planes are boxes of 100 m"] if name == "dart" else [],
        }
        for name, (title, ours, _, _, _) in ENGINES.items()
    }  # fmt: skip
    engines["newton"] = engines["dart"] | {
        "name": "newton",
        "title": "Newton",
        "version": None,
        "unavailable": "package newton is not installed; pip install 'plumbline[newton]'",
        "deviations": [],
    }
    if hostile:
        cases[BAD_CASE] = cases["rest_table"] | {
            "name": BAD_CASE,
            "title": HOSTILE[0],
            "question": HOSTILE[1],
            "source": HOSTILE[3],
            "parameters": dict.fromkeys(HOSTILE[:10], HOSTILE[2]),
            "effects": list(HOSTILE[:10]),
            "headline": HOSTILE[7],
            "checks": [{"metric": t, "unit": t, "at_most": 1.0, "because": t, "start": 0.0, "end": None} for t in HOSTILE],
        }
        engines[HOSTILE[7]] = engines["dart"] | {
            "name": HOSTILE[7],
            "title": HOSTILE[2],
            "version": HOSTILE[5],
            "known_failures": {text: text for text in HOSTILE},
            "deviations": list(HOSTILE),
            "tracks": {"tuned": {"options": dict.fromkeys(HOSTILE, HOSTILE[0]), "source": HOSTILE[3]}, HOSTILE[0]: {}},
        }
    return {"cases": cases, "engines": engines}


def row(case: str, engine: str, track: str, dt: float, **changes: Any) -> dict[str, Any]:
    """One trial with the columns of the table; passed unless told otherwise. Bullet's tuned steps are 1/240 s at most."""
    cost = ENGINES.get(engine, ENGINES["dart"])[4] * (1 / 240) / dt
    parts = max(1, math.ceil(240 * dt - 1e-9)) if (engine, track) == ("bullet", "tuned") else 1
    name = f"{abs(hash_of(case, engine, track, dt)):016x}"[:16]
    plain = {
        "trial": name, "study": "quick", "experiment": "ladder", "case": case,
        "parameters": json.dumps({"mass": 1.0}), "engine": engine, "engine_version": "1.2.3", "track": track, "dt": dt,
        "settings": json.dumps({"dt": dt, **({"iterations": 50} if track == "tuned" else {})}),
        "resolved": json.dumps({"dt": dt, "substeps": parts, "iterations": 50, "integrator": "made", "solver": "pgs"}),
        "seed": 0,
        "status": "passed", "reason": "every check holds", "sim_seconds": 2.0, "steps": round(2 / dt),
        "cpu_per_sim_s": cost, "cpu_low": 0.93 * cost, "cpu_high": 1.09 * cost, "wall_per_sim_s": 1.01 * cost,
        "realtime_factor": 1 / (1.01 * cost), "unstable_timing": False, "trajectory_hash": name,
        "warnings": "[]", "detail": "", "unit": "step", "cpu_per_unit": cost * dt, "cpu_per_unit_low": 0.93 * cost * dt,
        "cpu_per_unit_high": 1.09 * cost * dt, "rough_cost": 1.2 * cost,
        "rough_ratio": math.nan, "clocks": "work", "workers": 1, "round": 0, "alteration": "{}", "members": 1, "remedy": "",
        "remedied": "", "substep": math.nan, "parts": 0, "sources": "{}", "answered_on": "", "clocked_on": "", "clocked": "",
        "emulated": math.nan, "timing_note": "", "recalled": "", "again": "", "trajectory_kept": True,
        "motion": "", "simulated_as": "",
    }  # fmt: skip
    return plain | changes


def hash_of(*parts: Any) -> int:
    """A number that is the same in every process."""
    import hashlib

    return int(hashlib.sha256(repr(parts).encode()).hexdigest()[:16], 16)


def untimed() -> dict[str, Any]:
    """The columns of a trial without a timing run."""
    columns = ("cpu_per_sim_s", "cpu_low", "cpu_high", "wall_per_sim_s", "realtime_factor")
    none = dict.fromkeys((*columns, "cpu_per_unit", "cpu_per_unit_low", "cpu_per_unit_high"), math.nan)
    return none | {"unstable_timing": None, "unit": None}


def tables(hostile: bool) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Trials and measurements."""
    trials, measurements = [], []
    for c, (case, (_, metric, unit, scale)) in enumerate(CASES.items()):
        for track in ("default", "tuned"):
            for engine in (*ENGINES, "newton"):
                for k, dt in enumerate(LADDER):
                    if engine == "newton":
                        gone = "package newton is not installed"
                        trials.append(row(case, engine, track, dt, status="unavailable", reason=gone, **untimed()))
                        continue
                    _, _, order, at_240, _ = ENGINES[engine]
                    spread = 0.5 + (hash_of(case, engine) % 1000) / 500
                    worse = 2.2 if track == "default" and engine != "reference" else 1.0
                    floor = 1e-7 if order == 2 else 0.0
                    error = scale * (worse * spread * at_240 * (dt * 240) ** order + floor)
                    if case == "flight_projectile" and engine == "reference" and k > 3:
                        error = 0.0
                    bound = 3e-3 * scale * (dt * 240)
                    trial = row(case, engine, track, dt)
                    if case == "joint_chain" and engine == "bullet" and k == 0:
                        trial |= {"status": "diverged", "reason": "by step 14 of 120: not finite", **untimed()}
                    elif case == "friction_stop" and engine == "mujoco" and k == 5:
                        trial |= untimed()
                    elif case == "stack_tower" and engine == "dart" and track == "default":
                        trial |= {"status": STATUSES[2 + k], "reason": f"planted: {STATUSES[2 + k]}", **untimed()}
                    elif case == "friction_creep" and engine == "bullet":
                        trial |= {"status": "unsupported", "reason": "static friction: one coefficient only", **untimed()}
                    elif case == "rest_table" and engine == "dart" and k == 2:
                        trial |= {"status": "timeout", "reason": "no answer within 60 s", **untimed()}
                    elif error > bound:
                        trial |= {"status": "failed", "reason": f"{metric} = {error:.4g} {unit}, bound {bound:.4g}"}
                    if c == 5 and k == 1:
                        trial |= {"unstable_timing": True, "cpu_high": 2.5 * trial["cpu_per_sim_s"]}
                    trials.append(trial)
                    if trial["status"] in ("passed", "failed"):
                        name = trial["trial"]
                        fields = {"trial": name, "unit": unit, "because": "as derived", "passed": error <= bound}
                        measurements += [
                            fields | {"metric": metric, "value": error, "at_most": bound},
                            fields | {"metric": "energy_drift", "value": error / 50, "unit": "J", "at_most": 1e-2,
                                      "passed": error / 50 <= 1e-2},
                            fields | {"metric": "contact_gap", "value": math.nan, "at_most": math.nan, "passed": None,
                                      "because": "not measurable: no contact"},
                        ]  # fmt: skip
    if hostile:
        for text, status in zip(HOSTILE, (*STATUSES, "passed", "failed"), strict=True):
            trial = row(BAD_CASE, HOSTILE[7], "tuned", 1 / 240, status=status, reason=text, detail=text)
            trial |= {
                "trial": f"{hash_of(text):016x}"[:16],
                "settings": json.dumps({"options": {text: text}}),
                "experiment": text,
            }
            trials.append(trial | {"warnings": json.dumps([text]), "engine_version": text})
            measurements += [
                {"trial": trial["trial"], "metric": metric, "value": value, "unit": text, "at_most": 1.0, "passed": True,
                 "because": text}
                for metric, value in ((HOSTILE[7], 0.5), (text[:200], math.inf))
            ]  # fmt: skip
    return trials, measurements


@cache
def _files(hostile: bool, only: tuple[str, ...]) -> dict[str, bytes]:
    """What is written, by name: the same each time."""
    trials, measurements = tables(hostile)
    if only:
        trials = [trial for trial in trials if trial["case"] in only]
    kept = {trial["trial"] for trial in trials}
    samples = [
        {
            "trial": t["trial"],
            "process": 0,
            "block": b,
            "steps": 500,
            "cpu": 0.05,
            "wall": 0.051,
            "canary": 1e-3,
            "switches": 0,
            "units": 1,
        }
        for t in trials[:20]
        for b in range(5)
    ]
    machine = {
        "processor": HOSTILE[0] if hostile else "Example CPU at 3 GHz", "cores": 8, "memory_mb": 16000, "system": "Linux 6.1",
        "python": "3.11.9", "packages": {"numpy": "2.1.0", "mujoco": "4.0.0"}, "load": [0.4, 0.3, 0.2],
        "started": "2025-01-02T03:04:05+00:00", "finished": "2025-01-02T03:05:06+00:00",
        "command": ["plumbline", "run", "quick", "--out", "build/quick"],
    }  # fmt: skip
    study = 'name = "quick"\ntitle = "A slice of everything"\npurpose = "A look at all engines within a minute"\n'
    return {
        "trials.parquet": pd.DataFrame(trials).astype({"unstable_timing": "boolean"}).to_parquet(index=False),
        "measurements.parquet": pd.DataFrame([m for m in measurements if m["trial"] in kept])
        .astype({"passed": "boolean"})
        .to_parquet(index=False),
        "samples.parquet": pd.DataFrame(samples).to_parquet(index=False),
        "catalogue.json": json.dumps(catalogue(hostile)).encode(),
        "machine.json": json.dumps(machine).encode(),
        "study.toml": study.encode(),
        "recordings/joint_pendulum.rrd": b"RRF2",
    }


def write_run_folder(folder: Path, *, hostile: bool = False, only: tuple[str, ...] = ()) -> Path:
    """Write the run folder and give it back; `only` keeps these cases."""
    (folder / "recordings").mkdir(parents=True, exist_ok=True)
    for name, content in _files(hostile, only).items():
        (folder / name).write_bytes(content)
    return folder
