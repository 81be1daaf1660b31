"""The planted faults of the contract: saves, refusals, settings, repetition, and what is claimed."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plumbline.harness.adapter import Adapter, Feature, Notice, Settings, Simulation, Unsupported
from plumbline.harness.scene import Body, Effect, Matrix3, Scene, principal_inertia
from plumbline.harness.trajectory import Floats, State
from tests.planted_faults.fault import fault
from tests.planted_faults.planting import Broken, Repaired, Wrapped, plant

_W, _D = Feature.WRENCH, Feature.PRISMATIC | Feature.DRIVES


def _rounded(body: Body) -> Matrix3:
    """The spherical inertia [kg m2] of the same trace."""
    mean = float(np.trace(np.asarray(body.inertia))) / 3
    return principal_inertia(mean, mean, mean)


class _Credulous(Broken):
    """Builds the nearest thing where the engine inside says Unsupported: the same bodies without shapes, joints and laws."""

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        try:
            return self.inner.build(scene, settings)
        except Unsupported:
            bare = tuple(
                replace(b, collision=(), linear_damping=0.0, angular_damping=0.0, inertia=_rounded(b))
                for b in scene.bodies
                if b.movable
            )
            return self.inner.build(Scene(bodies=bare, gravity=scene.gravity), settings)


@fault("nan_is_reported")
class nan_repaired_in_silence(Repaired):
    """a state that is not finite is replaced by the start at rest"""


@fault("save_and_restore_is_exact", needs=Feature.SAVE)
class save_keeps_nothing(Wrapped):
    """restore goes nowhere"""

    def save(self) -> object:
        return None

    def restore(self, saved: object) -> None:
        """Nowhere."""


@fault("unknown_option_is_refused")
def unknown_options_dropped(engine: Adapter) -> Adapter:
    """an option that the adapter does not know is ignored"""
    known = {name for settings in engine.tracks.values() for name in settings.options}

    def drop(settings: Settings) -> Settings:
        return replace(settings, options={k: v for k, v in settings.options.items() if k in known})

    return plant(engine, settings=drop)


@fault("unknown_integrator_is_refused", "unknown_solver_is_refused")
def unknown_methods_dropped(engine: Adapter) -> Adapter:
    """an integrator or solver that the engine does not have is replaced by its own"""
    return plant(engine, settings=lambda settings: replace(settings, integrator=None, solver=None))


@fault("claimed_features_build")
def claims_too_much(engine: Adapter) -> Adapter:
    """every feature is claimed"""
    return replace(plant(engine), features=~Feature.NONE)


@fault("close_may_be_called_twice")
class closes_once(Wrapped):
    """closing a second time fails"""

    _closed = False

    def close(self) -> None:
        if self._closed:
            raise RuntimeError("closed twice")
        self._closed = True
        self.inner.close()


@fault("resolved_settings_are_complete")
class resolved_says_nothing(Wrapped):
    """the settings in use are not told"""

    @property
    def resolved(self) -> Settings:
        return Settings()


@fault("state_is_written_into_the_given_arrays", "initial_state_comes_back")
class angular_velocity_not_written(Wrapped):
    """the caller's w is left as it was"""

    def state(self, out: State) -> None:
        self.inner.state(State(out.p_WB, out.q_WB, out.v_WB, out.w_WB.copy()))


@fault("heavy_on_light_is_finite_or_diverged", needs=Feature.BOX, cases=("flight_*", "rest_*"))
class nan_without_a_word(Wrapped):
    """positions become NaN after fifty steps and nobody says so"""

    _steps = 0

    def step(self, count: int = 1) -> None:
        self._steps += count
        self.inner.step(count)

    def state(self, out: State) -> None:
        self.inner.state(out)
        if self._steps > 50:
            out.p_WB[:] = np.nan


@fault("surplus_names_effects")
class surplus_by_no_name(Wrapped):
    """a surplus is declared that is no effect"""

    def warnings(self) -> tuple[Notice, ...]:
        return (Notice("magnetism", "surplus"),)


@fault("same_input_same_hash")
def not_repeatable(engine: Adapter) -> Adapter:
    """each build differs by a rounding"""
    builds = iter(range(1, 1_000_000_000))

    def nudge(scene: Scene) -> Scene:
        step = 1e-12 * next(builds)
        return replace(scene, bodies=tuple(replace(b, p_WB=(b.p_WB[0] + step, *b.p_WB[1:])) for b in scene.bodies))

    return plant(engine, scene=nudge)


@fault("two_simulations_share_no_state")
def simulations_entangled(engine: Adapter) -> Adapter:
    """stepping one simulation steps the others"""
    opened: list[Simulation] = []

    class Entangled(Wrapped):
        def start(self) -> None:
            opened.append(self.inner)

        def step(self, count: int = 1) -> None:
            for simulation in opened:
                simulation.step(count)

        def close(self) -> None:
            if self.inner in opened:
                opened.remove(self.inner)
            self.inner.close()

    return plant(engine, simulation=Entangled)


@fault("narrowed_gravity_is_left_out", "narrowed_contact_is_left_out", needs=Feature.SPHERE)
def narrowing_ignored(scene: Scene) -> Scene:
    """effects that the scene leaves out are simulated all the same, and not declared"""
    return replace(scene, narrow=Effect.NONE)


@fault("unclaimed_features_raise_unsupported")
def approximates_in_silence(engine: Adapter) -> Adapter:
    """what is not supported is left out without a word"""
    return plant(engine, _Credulous)


@fault("bad_wrenches_are_refused", needs=Feature.WRENCH)
class wrench_of_any_shape(Wrapped):
    """a wrench of a wrong shape, type or content is made to fit"""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        n = len(self.scene.bodies)
        made = (np.nan_to_num(np.resize(np.asarray(loads, dtype=np.float64), (n, 3))) for loads in (f_B_W, tau_B_W))
        self.inner.wrench(*made)


@fault("restore_brings_back_the_wrench", needs=Feature.SAVE | Feature.WRENCH)
class restore_keeps_the_wrench(Wrapped):
    """the wrench outlives a restore"""

    _last: tuple[Floats, Floats] | None = None

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        self.inner.wrench(f_B_W, tau_B_W)
        self._last = f_B_W.copy(), tau_B_W.copy()

    def restore(self, saved: object) -> None:
        self.inner.restore(saved)
        if self._last is not None:
            self.inner.wrench(*self._last)


@fault("restore_brings_back_the_targets", needs=Feature.SAVE | _D)
class restore_keeps_the_targets(Wrapped):
    """the targets of drives outlive a restore"""

    def start(self) -> None:
        self._last: dict[str, float] = {}

    def command(self, targets: Mapping[str, float]) -> None:
        self.inner.command(targets)
        self._last.update(targets)

    def restore(self, saved: object) -> None:
        self.inner.restore(saved)
        self.inner.command(self._last)
