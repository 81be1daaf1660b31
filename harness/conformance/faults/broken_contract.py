"""The planted faults of the contract: saves, closing, settings, refusals, and simulations that share something."""

from dataclasses import dataclass, replace

import numpy as np

from harness.adapter import Adapter, Settings, Simulation, Unsupported
from harness.conformance.faults.plant import Wrapped, plant
from harness.scene import (
    Body,
    Matrix3,
    Scene,
    principal_inertia,
)

__all__ = [
    "ClosesOnce",
    "Credulous",
    "ForgetfulSave",
    "OddWarnings",
    "Taciturn",
    "approximating",
    "deaf_to_methods",
    "deaf_to_options",
    "entangled",
    "rounded",
    "unrepeatable",
]


class ForgetfulSave(Wrapped):
    """Keeps nothing in a save, so that restore goes nowhere."""

    def save(self) -> object:
        """Nothing."""
        return None

    def restore(self, saved: object) -> None:
        """Nowhere."""


class ClosesOnce(Wrapped):
    """Fails when it is closed a second time."""

    _closed = False

    def close(self) -> None:
        """As inside, once."""
        if self._closed:
            raise RuntimeError("closed twice")
        self._closed = True
        self.inner.close()


class Taciturn(Wrapped):
    """Does not say what the engine uses."""

    @property
    def resolved(self) -> Settings:
        """Settings without content."""
        return Settings()


class OddWarnings(Wrapped):
    """Declares a surplus that is no effect."""

    def warnings(self) -> tuple[str, ...]:
        """One odd warning."""
        return ("surplus: magnetism",)


def unrepeatable(adapter: Adapter) -> Adapter:
    """Each build starts from another rounding of the same scene."""
    builds = iter(range(1, 1_000_000_000))

    def nudge(scene: Scene) -> Scene:
        step = 1e-12 * next(builds)
        return replace(scene, bodies=tuple(replace(b, p_WB=(b.p_WB[0] + step, *b.p_WB[1:])) for b in scene.bodies))

    return plant(adapter, scene=nudge)


def entangled(adapter: Adapter) -> Adapter:
    """Stepping one simulation steps all that are open, as one world behind all of them would."""
    opened: list[Simulation] = []

    class Entangled(Wrapped):
        def step(self, count: int = 1) -> None:
            for simulation in opened:
                simulation.step(count)

        def close(self) -> None:
            if self.inner in opened:
                opened.remove(self.inner)
            self.inner.close()

    def join(inner: Simulation, _: Adapter, scene: Scene, settings: Settings) -> Simulation:
        opened.append(inner)
        return Entangled(inner, scene, settings)

    return plant(adapter, simulation=join)


def deaf_to_methods(adapter: Adapter) -> Adapter:
    """An integrator or solver by an unknown name is replaced by the engine's own without a word."""

    def drop(settings: Settings) -> Settings:
        return replace(settings, integrator=None, solver=None)

    return plant(adapter, settings=drop)


def deaf_to_options(adapter: Adapter) -> Adapter:
    """Unknown options are dropped without a word."""
    known = {name for settings in adapter.tracks.values() for name in settings.options}

    def drop(settings: Settings) -> Settings:
        return replace(settings, options={k: v for k, v in settings.options.items() if k in known})

    return plant(adapter, settings=drop)


@dataclass(frozen=True, kw_only=True)
class Credulous(Adapter):
    """Builds the nearest thing where the engine inside says Unsupported: the same bodies without shapes, joints and laws."""

    inner: Adapter

    def version(self) -> str:
        """The version of the engine inside. Raises: Unavailable."""
        return self.inner.version()

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """What the engine inside can, or something like it. Raises: Unavailable, SettingsError."""
        try:
            return self.inner.build(scene, settings)
        except Unsupported:
            bare = tuple(
                replace(b, collision=(), linear_damping=0.0, angular_damping=0.0, inertia=rounded(b))
                for b in scene.bodies
                if b.movable
            )
            return self.inner.build(Scene(bodies=bare, gravity=scene.gravity), settings)


def rounded(body: Body) -> Matrix3:
    """The spherical inertia [kg m2] of the same trace."""
    mean = float(np.trace(np.asarray(body.inertia))) / 3
    return principal_inertia(mean, mean, mean)


def approximating(adapter: Adapter) -> Adapter:
    """What is not supported is left out without a word."""
    return Credulous(
        name=adapter.name,
        title=adapter.title,
        distribution=adapter.distribution,
        features=adapter.features,
        tracks=adapter.tracks,
        inner=adapter,
    )
