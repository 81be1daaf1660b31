"""A free top run by each integrator, and its true attitude, for tests of integrators."""

import numpy as np

from plumbline import engine
from plumbline.cases.spin_asymmetric_top import CASE
from plumbline.harness.trajectory import Trajectory

__all__ = ["MOMENTS", "SPIN", "KICKED", "options_of", "run", "top", "angle_between", "true_attitude", "matrix"]


MOMENTS = np.array([1.0, 2.0, 3.0])
SPIN = (0.5, 0.7, 1.2)
KICKED = ("velocity_verlet", "implicit_midpoint", "splitting_4", "splitting_8")


def options_of(integrator: str, dt: float, **more: object) -> engine.Options:
    """One step of the integrator per dt: the adaptive one is told to take whatever error that has."""
    loose = {"step_tolerance": 1e-2} if integrator == "dormand_prince" else {}
    return engine.Options(**{"dt": dt, "substeps": 1, "integrator": integrator, **loose, **more})  # type: ignore[arg-type]


def run(
    body: engine.Body, options: engine.Options, seconds: float, gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    load: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None,
) -> np.ndarray:  # fmt: skip
    world = engine.World([body], gravity=gravity, options=options)
    if load is not None:
        world.set_load([load[0]], [load[1]])
    world.step(round(seconds / options.dt))
    return np.array(world.state()[0])


def top(**changes: object) -> engine.Body:
    return engine.Body(**{"inertia": np.diag(MOMENTS), "w_WB": SPIN, **changes})  # type: ignore[arg-type]


def angle_between(q: np.ndarray, true: np.ndarray) -> float:
    """The small angle [rad] between two attitudes."""
    return 2 * float(min(np.linalg.norm(q - true), np.linalg.norm(q + true)))


def true_attitude(seconds: float) -> np.ndarray:
    """q_WB of the free top by elliptic functions."""
    assert CASE.expected is not None
    truth = CASE.expected(np.array([seconds]), CASE.at(moments=tuple(MOMENTS), spin=SPIN))
    assert isinstance(truth, Trajectory)
    return np.asarray(truth.q_WB[0, 0])


def matrix(q: np.ndarray) -> np.ndarray:
    w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
