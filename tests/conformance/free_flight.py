"""A third party's engine that knows free flight alone: Runge-Kutta of fourth order, no shapes, no joints, no contacts."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from plumbline.harness.adapter import Adapter, Diverged, Feature, Settings, SettingsError, Unsupported
from plumbline.harness.adapter.what_goes_in import check_state, check_wrench
from plumbline.harness.scene import Camera, Effect, Scene, multiply, rotation_matrix
from plumbline.harness.trajectory import Contacts, Floats, Hits, Image, State

__all__ = ["ADAPTER", "Flight", "FreeFlight"]

NEXT, LAST = [1, 2, 0], [2, 0, 1]
"""Axes in turn: a x b = a[NEXT] b[LAST] - a[LAST] b[NEXT]."""


class Flight:
    """Bodies in free flight, one column each: p_WB, q_WB, v_WB and w_B."""

    def __init__(self, scene: Scene, settings: Settings) -> None:
        self._settings, self._bodies = settings, scene.bodies
        self._moves = np.array([body.movable for body in scene.bodies])
        self._gravity = np.array(scene.gravity) * (Effect.GRAVITY in scene.effects)
        self._turning = Effect.GYROSCOPIC in scene.effects
        self._inertia = np.array([body.inertia for body in scene.bodies])
        self._inverse = np.linalg.inv(self._inertia)
        self._mass = np.array([[body.mass] for body in scene.bodies])
        damped = [(Effect.LINEAR_DAMPING, "linear_damping"), (Effect.ANGULAR_DAMPING, "angular_damping")]
        self._damping = [
            np.array([[getattr(body, name) * (effect in scene.effects)] for body in scene.bodies]) for effect, name in damped
        ]
        start = State.initial(scene)
        w_B = np.einsum("nij,ni->nj", self._rotations(start.q_WB), start.w_WB)
        self._y = np.hstack((start.p_WB, start.q_WB, start.v_WB, w_B))
        self._f, self._tau = np.zeros((len(scene.bodies), 3)), np.zeros((len(scene.bodies), 3))

    @property
    def resolved(self) -> Settings:
        return replace(self._settings, substeps=self._settings.substeps or 1, integrator="rk4")

    @staticmethod
    def _rotations(q: Floats) -> Floats:
        return np.array([rotation_matrix((w, x, y, z)) for w, x, y, z in q], dtype=np.float64)

    def _rate(self, y: Floats) -> Floats:
        q, v, w = y[:, 3:7], y[:, 7:10], y[:, 10:]
        tau_B = np.einsum("nij,ni->nj", self._rotations(q), self._tau) if self._tau.any() else self._tau
        if self._turning:
            L = np.einsum("nij,nj->ni", self._inertia, w)
            tau_B = tau_B - (w[:, NEXT] * L[:, LAST] - w[:, LAST] * L[:, NEXT])
        spin = np.einsum("nij,nj->ni", self._inverse, tau_B) - self._damping[1] * w
        push = self._gravity + self._f / self._mass - self._damping[0] * v
        half = 0.5 * np.array([multiply((a, b, c, d), (0.0, x, y, z)) for (a, b, c, d), (x, y, z) in zip(q, w, strict=True)])
        rate: Floats = np.hstack((v, half, push, spin)) * self._moves[:, None]
        return rate

    def step(self, count: int = 1) -> None:
        substeps = self._settings.substeps or 1
        h = self._settings.dt / substeps
        for _ in range(count * substeps):
            with np.errstate(all="ignore"):
                k1 = self._rate(self._y)
                k2 = self._rate(self._y + h / 2 * k1)
                k3 = self._rate(self._y + h / 2 * k2)
                k4 = self._rate(self._y + h * k3)
                y = self._y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
                y[:, 3:7] /= np.linalg.norm(y[:, 3:7], axis=1, keepdims=True)
            if not np.isfinite(y).all():
                raise Diverged("the state is not finite")
            self._y = y

    def state(self, out: State) -> None:
        check_state(len(self._y), out)
        out.p_WB[:], out.q_WB[:], out.v_WB[:] = self._y[:, :3], self._y[:, 3:7], self._y[:, 7:10]
        out.w_WB[:] = np.einsum("nij,nj->ni", self._rotations(self._y[:, 3:7]), self._y[:, 10:])

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        check_wrench(len(self._y), f_B_W, tau_B_W)
        self._f, self._tau = f_B_W.copy(), tau_B_W.copy()

    def save(self) -> object:
        return self._y.copy(), self._f.copy(), self._tau.copy()

    def restore(self, saved: object) -> None:
        assert isinstance(saved, tuple)
        self._y, self._f, self._tau = (array.copy() for array in saved)

    def contacts(self) -> Contacts:
        raise Unsupported("contacts", "free flight meets nothing")

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        raise Unsupported("rays", "free flight has no shapes")

    def render(self, camera: Camera, colour: bool = True) -> Image:
        raise Unsupported("render", "free flight has no shapes")

    def command(self, targets: Mapping[str, float]) -> None:
        raise Unsupported("drives", "free flight has no joints")

    def warnings(self) -> tuple[str, ...]:
        return ()

    def close(self) -> None:
        return None


@dataclass(frozen=True, kw_only=True)
class FreeFlight(Adapter):
    """The adapter of the engine above."""

    def version(self) -> str:
        return "1.0"

    def build(self, scene: Scene, settings: Settings) -> Flight:
        for name in settings.options:
            raise SettingsError(f"settings: options.{name} is unknown, expected none")
        if settings.integrator not in (None, "rk4"):
            raise SettingsError(f"settings: integrator {settings.integrator!r}, expected 'rk4'")
        if settings.solver is not None:
            raise SettingsError(f"settings: solver {settings.solver!r}, expected none")
        for body in scene.bodies:
            if body.collision:
                raise Unsupported(f"body '{body.name}': shapes", "free flight meets nothing")
            if body.mass_point:
                raise Unsupported(f"body '{body.name}': a mass point", "free flight turns what has an inertia")
            if body.motion == "kinematic":
                raise Unsupported(f"body '{body.name}': kinematic motion", "free flight knows forces alone")
        if scene.joints:
            raise Unsupported(f"joint '{scene.joints[0].name}'", "free flight knows no constraint")
        return Flight(scene, settings)


ADAPTER = FreeFlight(
    name="freeflight",
    title="Free flight",
    distribution="freeflight",
    features=Feature.FULL_INERTIA | Feature.WRENCH | Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING | Feature.SAVE,
    tracks={"default": Settings(), "tuned": Settings(substeps=2)},
)
