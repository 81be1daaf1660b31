"""Planted faults: engines broken in exactly one way each, which the checks must catch and name."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from harness.adapter import Adapter, Feature, Settings, Simulation, Unsupported
from harness.conformance.exact import rotation
from harness.conformance.faults import Repaired, Rewritten, Wrapped, plant
from harness.scene import (
    Body,
    Box,
    Effect,
    Matrix3,
    PlacedShape,
    Prismatic,
    Revolute,
    Scene,
    Sphere,
    Surface,
    principal_inertia,
)
from harness.trajectory import Contacts, Floats, Hits, State, Trajectory

__all__ = ["CONTROLS", "Control"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """One planted fault.

    Terms:
        name, fault: what is broken, in snake case and in words. caught_by: the conformance checks of which at least one must
        fail, each of which passes on the sound engine. needs: features without which the fault cannot show.
        plant: the adapter with the fault. spoil: the same for a recorded trajectory, for faults behind the engine.
        applies_to_cases: patterns of case names that should notice it as well.
    """

    name: str
    fault: str
    caught_by: tuple[str, ...]
    plant: Callable[[Adapter], Adapter] = lambda adapter: adapter
    spoil: Callable[[Trajectory], Trajectory] = lambda trajectory: trajectory
    needs: Feature = Feature.NONE
    applies_to_cases: tuple[str, ...] = ()

    @property
    def on_trajectory(self) -> bool:
        """Does the fault lie behind the engine, in recorded streams?"""
        return not self.caught_by or self.caught_by == ("noise_axes_are_independent",)


def _told(change: Callable[[Scene], Scene]) -> Callable[[Adapter], Adapter]:
    return lambda adapter: plant(adapter, scene=change)


def _with(simulation: Callable[[Simulation, Adapter, Scene, Settings], Simulation]) -> Callable[[Adapter], Adapter]:
    return lambda adapter: plant(adapter, simulation=simulation)


def _wrapped(kind: type[Wrapped]) -> Callable[[Adapter], Adapter]:
    return _with(lambda inner, _, scene, settings: kind(inner, scene, settings))


def _bodies(change: Callable[[Body], Body]) -> Callable[[Adapter], Adapter]:
    return _told(lambda scene: replace(scene, bodies=tuple(change(body) for body in scene.bodies)))


def _gravity(factor: float) -> Callable[[Adapter], Adapter]:
    def change(scene: Scene) -> Scene:
        x, y, z = scene.gravity
        return replace(scene, gravity=(factor * x, factor * y, factor * z))

    return _told(change)


def _surfaces(change: Callable[[Surface], Surface]) -> Callable[[Adapter], Adapter]:
    return _told(lambda scene: replace(scene, surfaces=tuple(change(surface) for surface in scene.surfaces)))


def _rougher(law: Surface) -> Surface:
    return replace(law, static_friction=1.05 * law.static_friction, kinetic_friction=1.05 * law.kinetic_friction)


def _swap_inertia(body: Body) -> Body:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
    return replace(body, inertia=((yy, xy, yz), (xy, xx, xz), (yz, xz, zz)))


def _double_extents(body: Body) -> Body:
    def doubled(placed: PlacedShape) -> PlacedShape:
        match placed.shape:
            case Box(half_extents=(a, b, c)):
                return replace(placed, shape=Box(half_extents=(2 * a, 2 * b, 2 * c)))
            case _:
                return placed

    return replace(body, collision=tuple(doubled(placed) for placed in body.collision))


def _capsule_to_sphere(body: Body) -> Body:
    kept = tuple(replace(p, shape=Sphere(radius=0.1)) if p.shape.type == "capsule" else p for p in body.collision)
    return replace(body, collision=kept)


def _joints(change: Callable[[Revolute | Prismatic], Any]) -> Callable[[Adapter], Adapter]:
    def apply(scene: Scene) -> Scene:
        return replace(scene, joints=tuple(change(j) if isinstance(j, Revolute | Prismatic) else j for j in scene.joints))

    return _told(apply)


def _stiffer(joint: Revolute | Prismatic) -> Revolute | Prismatic:
    return (
        joint if joint.spring is None else replace(joint, spring=replace(joint.spring, stiffness=1.1 * joint.spring.stiffness))
    )


class _NoGyroscopicTorque(Wrapped):
    """Adds w x I w to every body in each step, which takes the gyroscopic torque away."""

    def __init__(self, inner: Simulation, scene: Scene, settings: Settings) -> None:
        super().__init__(inner, scene, settings)
        n = len(scene.bodies)
        self._push: tuple[Floats, Floats] = np.zeros((n, 3)), np.zeros((n, 3))
        self._top = any(body.movable and np.ptp(np.linalg.eigvalsh(np.asarray(body.inertia))) > 0 for body in scene.bodies)

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Kept, to be applied together with what is added."""
        self._push = f_B_W.copy(), tau_B_W.copy()
        self.inner.wrench(f_B_W, tau_B_W)

    def step(self, count: int = 1) -> None:
        """Step by step with the torque of the present state."""
        if not self._top:
            self.inner.step(count)
            return
        for _ in range(count):
            state, tau = self.now(), self._push[1].copy()
            for k, body in enumerate(self.scene.bodies):
                if body.movable:
                    R = rotation(state.q_WB[k])
                    tau[k] += np.cross(state.w_WB[k], R @ np.asarray(body.inertia) @ R.T @ state.w_WB[k])
            self.inner.wrench(self._push[0], tau)
            self.inner.step()


class _BodyAngularVelocity(Wrapped):
    """Hands out w in B."""

    def state(self, out: State) -> None:
        """As inside, w turned into B."""
        self.inner.state(out)
        for k in range(len(out.w_WB)):
            out.w_WB[k] = rotation(out.q_WB[k]).T @ out.w_WB[k]


class _ScalarLast(Wrapped):
    """Hands out (x, y, z, w)."""

    def state(self, out: State) -> None:
        """As inside, the quaternion's components in another order."""
        self.inner.state(out)
        out.q_WB[:] = np.roll(out.q_WB, -1, axis=1)


class _Shuffled(Wrapped):
    """Hands out the bodies in another order."""

    def state(self, out: State) -> None:
        """As inside, the first body last."""
        self.inner.state(out)
        for array in (out.p_WB, out.q_WB, out.v_WB, out.w_WB):
            array[:] = np.roll(array, -1, axis=0)


class _OneStepBehind(Wrapped):
    """Hands out the state of one step ago."""

    def __init__(self, inner: Simulation, scene: Scene, settings: Settings) -> None:
        super().__init__(inner, scene, settings)
        self._before = self.now()

    def step(self, count: int = 1) -> None:
        """As inside; the state before the last step is kept."""
        if count > 1:
            self.inner.step(count - 1)
        self._before = self.now()
        self.inner.step()

    def state(self, out: State) -> None:
        """The kept state."""
        for target, source in zip(
            (out.p_WB, out.q_WB, out.v_WB, out.w_WB),
            (self._before.p_WB, self._before.q_WB, self._before.v_WB, self._before.w_WB),
            strict=True,
        ):
            target[:] = source


class _FlippedNormal(Wrapped):
    """Hands out normals from B to A."""

    def contacts(self) -> Contacts:
        """As inside, the normal turned round."""
        got = self.inner.contacts()
        return replace(got, normal_W=-got.normal_W)


class _PositiveGap(Wrapped):
    """Hands out penetration as a positive number."""

    def contacts(self) -> Contacts:
        """As inside, the gap with the other sign."""
        got = self.inner.contacts()
        return replace(got, gap=-got.gap)


class _HalfForce(Wrapped):
    """Loses half of each contact force, as one who reads two impulses as one would."""

    def contacts(self) -> Contacts:
        """As inside, the forces halved."""
        got = self.inner.contacts()
        return replace(got, force_W=got.force_W / 2)


class _EndlessRays(Wrapped):
    """Casts further than asked."""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """As inside, ten times as far."""
        return self.inner.cast(origins, directions, 10 * max_range)


class _ReversedWrench(Wrapped):
    """Pushes the other way."""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """As inside, with the other sign."""
        self.inner.wrench(-f_B_W, -tau_B_W)


class _ForgetfulSave(Wrapped):
    """Keeps nothing in a save, so that restore goes nowhere."""

    def save(self) -> object:
        """Nothing."""
        return None

    def restore(self, saved: object) -> None:
        """Nowhere."""


class _ClosesOnce(Wrapped):
    """Fails when it is closed a second time."""

    _closed = False

    def close(self) -> None:
        """As inside, once."""
        if self._closed:
            raise RuntimeError("closed twice")
        self._closed = True
        self.inner.close()


class _Taciturn(Wrapped):
    """Does not say what the engine uses."""

    @property
    def resolved(self) -> Settings:
        """Settings without content."""
        return Settings()


class _NoSpinWritten(Wrapped):
    """Leaves w as it finds it."""

    def state(self, out: State) -> None:
        """As inside, without w."""
        self.inner.state(State(out.p_WB, out.q_WB, out.v_WB, out.w_WB.copy()))


class _NanWithoutAWord(Wrapped):
    """After some steps positions are NaN, and no exception says so."""

    _steps = 0

    def step(self, count: int = 1) -> None:
        """As inside, counted."""
        self._steps += count
        self.inner.step(count)

    def state(self, out: State) -> None:
        """As inside, NaN after fifty steps."""
        self.inner.state(out)
        if self._steps > 50:
            out.p_WB[:] = np.nan


class _OddWarnings(Wrapped):
    """Declares a surplus that is no effect."""

    def warnings(self) -> tuple[str, ...]:
        """One odd warning."""
        return ("surplus: magnetism",)


def _unrepeatable(adapter: Adapter) -> Adapter:
    """Each build starts from another rounding of the same scene."""
    builds = iter(range(1, 1_000_000_000))

    def nudge(scene: Scene) -> Scene:
        step = 1e-12 * next(builds)
        return replace(scene, bodies=tuple(replace(b, p_WB=(b.p_WB[0] + step, *b.p_WB[1:])) for b in scene.bodies))

    return plant(adapter, scene=nudge)


def _entangled(adapter: Adapter) -> Adapter:
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


def _deaf_to_methods(adapter: Adapter) -> Adapter:
    """An integrator or solver by an unknown name is replaced by the engine's own without a word."""

    def drop(settings: Settings) -> Settings:
        return replace(settings, integrator=None, solver=None)

    return plant(adapter, settings=drop)


def _damped(inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> Simulation:
    def edit(_: State, after: State, dt: float) -> bool:
        after.v_WB[:] *= 1 - 0.04 * dt
        after.w_WB[:] *= 1 - 0.04 * dt
        return True

    return Rewritten(inner, adapter, scene, settings, edit)


def _clamped(inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> Simulation:
    def edit(_: State, after: State, __: float) -> bool:
        cut = False
        for array in (after.v_WB, after.w_WB):
            size = np.linalg.norm(array, axis=1, keepdims=True)
            if (size > 100.0).any():
                array[:] *= np.minimum(1.0, 100.0 / np.maximum(size, 1e-300))
                cut = True
        return cut

    return Rewritten(inner, adapter, scene, settings, edit)


def _sleepy(inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> Simulation:
    """Below .1 m/s and .1 rad/s for .1 s a body is put to sleep; a faster push wakes it."""
    quiet = np.zeros(len(scene.bodies))

    def edit(before: State, after: State, dt: float) -> bool:
        slow = (np.linalg.norm(after.v_WB, axis=1) < 0.1) & (np.linalg.norm(after.w_WB, axis=1) < 0.1)
        quiet[:] = np.where(slow, quiet + dt, 0.0)
        asleep = quiet > 0.1
        if not (asleep.any() and (after.v_WB[asleep].any() or after.w_WB[asleep].any())):
            return False
        for target, source in ((after.p_WB, before.p_WB), (after.q_WB, before.q_WB)):
            target[asleep] = source[asleep]
        after.v_WB[asleep], after.w_WB[asleep] = 0.0, 0.0
        return True

    return Rewritten(inner, adapter, scene, settings, edit)


def _repairing(inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> Simulation:
    return Repaired(inner, adapter, scene, settings, lambda *_: False)


def _twice_the_step(adapter: Adapter) -> Adapter:
    return plant(
        adapter,
        settings=lambda settings: settings.with_dt(2 * settings.dt),
        simulation=lambda inner, _, scene, settings: Wrapped(inner, scene, settings),
    )


def _deaf_to_options(adapter: Adapter) -> Adapter:
    """Unknown options are dropped without a word."""
    known = {name for settings in adapter.tracks.values() for name in settings.options}

    def drop(settings: Settings) -> Settings:
        return replace(settings, options={k: v for k, v in settings.options.items() if k in known})

    return plant(adapter, settings=drop)


@dataclass(frozen=True, kw_only=True)
class _Credulous(Adapter):
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
                replace(b, collision=(), linear_damping=0.0, angular_damping=0.0, inertia=_round(b))
                for b in scene.bodies
                if b.movable
            )
            return self.inner.build(Scene(bodies=bare, gravity=scene.gravity), settings)


def _round(body: Body) -> Matrix3:
    mean = float(np.trace(np.asarray(body.inertia))) / 3
    return principal_inertia(mean, mean, mean)


def _approximating(adapter: Adapter) -> Adapter:
    return _Credulous(
        name=adapter.name,
        title=adapter.title,
        distribution=adapter.distribution,
        features=adapter.features,
        tracks=adapter.tracks,
        inner=adapter,
    )


def _share_seed(trajectory: Trajectory) -> Trajectory:
    """Every channel of a stream (k, c) gets the noise of the first one about its own mean, as one seed for all axes gives."""
    streams = dict(trajectory.streams)
    for name, signal in trajectory.streams.items():
        if not name.endswith("/time") and signal.ndim == 2 and len(signal) > 2:
            noise = signal[:, :1] - signal[:, :1].mean(axis=0)
            streams[name] = signal.mean(axis=0) + np.repeat(noise, signal.shape[1], axis=1)
    return replace(trajectory, streams=streams)


_C, _W = Feature.BOX | Feature.CONTACTS, Feature.WRENCH
_FALL = "free_fall_has_the_size_and_sign_of_g"

CONTROLS: tuple[Control, ...] = (
    Control(
        name="gravity_upside_down",
        fault="gravity with the wrong sign",
        plant=_gravity(-1.0),
        caught_by=(_FALL, "gravity_is_a_vector"),
        applies_to_cases=("flight_*", "rest_*", "joint_*"),
    ),
    Control(
        name="gravity_two_percent_strong",
        fault="gravity times 1.02",
        plant=_gravity(1.02),
        caught_by=(_FALL, "gravity_is_a_vector"),
        applies_to_cases=("flight_*", "joint_*"),
    ),
    Control(
        name="friction_five_percent_strong",
        fault="friction times 1.05",
        plant=_surfaces(_rougher),
        caught_by=("friction_has_its_size",),
        needs=Feature.BOX,
        applies_to_cases=("friction_*",),
    ),
    Control(
        name="twice_the_time_step",
        fault="each step advances 2 dt",
        plant=_twice_the_step,
        caught_by=("step_advances_exactly_dt", _FALL),
        applies_to_cases=("flight_*", "spin_*", "joint_*"),
    ),
    Control(
        name="no_gyroscopic_torque",
        fault="the term w x I w is dropped",
        plant=_wrapped(_NoGyroscopicTorque),
        caught_by=("gyroscopic_term_is_present",),
        needs=_W,
        applies_to_cases=("spin_*",),
    ),
    Control(
        name="angular_velocity_in_the_body_frame",
        fault="w is handed out in B",
        plant=_wrapped(_BodyAngularVelocity),
        caught_by=("angular_velocity_is_in_W", "initial_state_comes_back"),
        applies_to_cases=("spin_*",),
    ),
    Control(
        name="quaternion_scalar_last",
        fault="quaternions are handed out as (x, y, z, w)",
        plant=_wrapped(_ScalarLast),
        caught_by=("quaternion_is_wxyz", "initial_state_comes_back"),
        applies_to_cases=("spin_*",),
    ),
    Control(
        name="inertia_axes_exchanged",
        fault="the first two rows and columns of the inertia are exchanged",
        plant=_bodies(_swap_inertia),
        caught_by=("inertia_is_in_B",),
        applies_to_cases=("spin_*",),
    ),
    Control(
        name="hidden_damping",
        fault="velocities lose 4 % a second",
        plant=_with(_damped),
        caught_by=("hidden_damping_is_off",),
        applies_to_cases=("flight_*", "spin_*"),
    ),
    Control(
        name="sleeping",
        fault="bodies slower than .1 m/s for .1 s are put to sleep",
        plant=_with(_sleepy),
        caught_by=("sleeping_is_off",),
        applies_to_cases=("flight_*",),
    ),
    Control(
        name="state_one_step_behind",
        fault="the state is that of one step ago",
        plant=_wrapped(_OneStepBehind),
        caught_by=("step_advances_exactly_dt",),
        applies_to_cases=("flight_*", "joint_*"),
    ),
    Control(
        name="noise_from_one_seed",
        fault="all axes of a sensor draw the same noise",
        spoil=_share_seed,
        caught_by=("noise_axes_are_independent",),
        applies_to_cases=("sensor_*",),
    ),
    Control(
        name="extents_taken_as_full",
        fault="boxes are twice as large",
        plant=_bodies(_double_extents),
        caught_by=("box_extents_are_half",),
        needs=Feature.BOX,
        applies_to_cases=("rest_*", "stack_*"),
    ),
    Control(
        name="velocity_clamped",
        fault="100 m/s and 100 rad/s are the most",
        plant=_with(_clamped),
        caught_by=("velocity_is_not_clamped",),
        applies_to_cases=("tunnel_*",),
    ),
    Control(
        name="nan_repaired_in_silence",
        fault="a state that is not finite is replaced by the start at rest",
        plant=_with(_repairing),
        caught_by=("nan_is_reported",),
    ),
    Control(
        name="body_order_permuted",
        fault="the first body comes last",
        plant=_wrapped(_Shuffled),
        caught_by=("body_order_is_kept", "initial_state_comes_back"),
    ),
    Control(
        name="contact_normal_flipped",
        fault="normals point from B to A",
        plant=_wrapped(_FlippedNormal),
        caught_by=("contact_normal_points_from_A_to_B",),
        needs=_C,
    ),
    Control(
        name="gap_positive_in_penetration",
        fault="penetration is handed out as a positive gap",
        plant=_wrapped(_PositiveGap),
        caught_by=("gap_is_negative_in_penetration",),
        needs=_C | Feature.SPHERE,
    ),
    Control(
        name="contact_force_halved",
        fault="contact forces are half as large",
        plant=_wrapped(_HalfForce),
        caught_by=("contact_forces_carry_the_weight",),
        needs=_C | Feature.CONTACT_FORCES,
    ),
    Control(
        name="restitution_squared",
        fault="a combination rule multiplies the restitution with itself",
        plant=_surfaces(lambda law: replace(law, restitution=law.restitution**2)),
        caught_by=("restitution_of_a_pair",),
        needs=Feature.SPHERE | Feature.RESTITUTION,
        applies_to_cases=("impact_*",),
    ),
    Control(
        name="capsule_replaced_by_a_sphere",
        fault="a capsule is silently a sphere of .1 m",
        plant=_bodies(_capsule_to_sphere),
        caught_by=("capsule_is_a_capsule",),
        needs=Feature.CAPSULE | Feature.SPHERE,
    ),
    Control(
        name="mass_ten_percent_light",
        fault="masses times .9",
        plant=_bodies(lambda body: replace(body, mass=0.9 * body.mass)),
        caught_by=("wrench_has_sign_and_size",),
        needs=_W,
    ),
    Control(
        name="wrench_reversed",
        fault="forces push the other way",
        plant=_wrapped(_ReversedWrench),
        caught_by=("wrench_has_sign_and_size",),
        needs=_W,
    ),
    Control(
        name="rays_without_end",
        fault="rays reach ten times as far as asked",
        plant=_wrapped(_EndlessRays),
        caught_by=("ray_beyond_max_range_misses",),
        needs=Feature.RAYS,
        applies_to_cases=("sensor_*",),
    ),
    Control(
        name="save_keeps_nothing",
        fault="restore goes nowhere",
        plant=_wrapped(_ForgetfulSave),
        caught_by=("save_and_restore_is_exact",),
        needs=Feature.SAVE,
    ),
    Control(
        name="limits_dropped",
        fault="joint limits are ignored",
        plant=_joints(lambda joint: replace(joint, limits=None)),
        caught_by=("limits_hold",),
        needs=Feature.REVOLUTE | Feature.LIMITS,
    ),
    Control(
        name="spring_ten_percent_stiff",
        fault="joint springs are 10 % too stiff",
        plant=_joints(_stiffer),
        caught_by=("spring_frequency",),
        needs=Feature.PRISMATIC | Feature.SPRINGS,
        applies_to_cases=("joint_*",),
    ),
    Control(
        name="initial_velocity_dropped",
        fault="every body starts from rest",
        plant=_bodies(lambda body: replace(body, v_WB=(0.0, 0.0, 0.0), w_WB=(0.0, 0.0, 0.0))),
        caught_by=("initial_state_comes_back",),
        applies_to_cases=("flight_*", "spin_*"),
    ),
    Control(
        name="unknown_options_dropped",
        fault="an option that the adapter does not know is ignored",
        plant=_deaf_to_options,
        caught_by=("unknown_option_is_refused",),
    ),
    Control(
        name="unknown_methods_dropped",
        fault="an integrator or solver that the engine does not have is replaced by its own",
        plant=_deaf_to_methods,
        caught_by=("unknown_integrator_is_refused", "unknown_solver_is_refused"),
    ),
    Control(
        name="claims_too_much",
        fault="every feature is claimed",
        plant=lambda adapter: replace(plant(adapter), features=~Feature.NONE),
        caught_by=("claimed_features_build",),
    ),
    Control(
        name="closes_once",
        fault="closing a second time fails",
        plant=_wrapped(_ClosesOnce),
        caught_by=("close_may_be_called_twice",),
    ),
    Control(
        name="resolved_says_nothing",
        fault="the settings in use are not told",
        plant=_wrapped(_Taciturn),
        caught_by=("resolved_settings_are_complete",),
    ),
    Control(
        name="angular_velocity_not_written",
        fault="the caller's w is left as it was",
        plant=_wrapped(_NoSpinWritten),
        caught_by=("state_is_written_into_the_given_arrays", "initial_state_comes_back"),
    ),
    Control(
        name="nan_without_a_word",
        fault="positions become NaN after fifty steps and nobody says so",
        plant=_wrapped(_NanWithoutAWord),
        caught_by=("heavy_on_light_is_finite_or_diverged",),
        needs=Feature.BOX,
        applies_to_cases=("*",),
    ),
    Control(
        name="surplus_by_no_name",
        fault="a surplus is declared that is no effect",
        plant=_wrapped(_OddWarnings),
        caught_by=("surplus_names_effects",),
    ),
    Control(
        name="not_repeatable",
        fault="each build differs by a rounding",
        plant=_unrepeatable,
        caught_by=("same_input_same_hash",),
    ),
    Control(
        name="simulations_entangled",
        fault="stepping one simulation steps the others",
        plant=_entangled,
        caught_by=("two_simulations_share_no_state",),
    ),
    Control(
        name="joined_bodies_collide",
        fault="bodies held by a joint collide all the same",
        plant=_told(lambda scene: replace(scene, joints=tuple(replace(joint, collide=True) for joint in scene.joints))),
        caught_by=("joined_bodies_do_not_collide",),
        needs=Feature.REVOLUTE | Feature.BOX,
    ),
    Control(
        name="joined_bodies_never_collide",
        fault="bodies held by a joint pass through each other although the joint lets them collide",
        plant=_told(lambda scene: replace(scene, joints=tuple(replace(joint, collide=False) for joint in scene.joints))),
        caught_by=("joined_bodies_collide_when_told",),
        needs=Feature.REVOLUTE | Feature.BOX,
    ),
    Control(
        name="narrowing_ignored",
        fault="effects that the scene leaves out are simulated all the same, and not declared",
        plant=_told(lambda scene: replace(scene, narrow=Effect.NONE)),
        caught_by=("narrowed_gravity_is_left_out", "narrowed_contact_is_left_out"),
        needs=Feature.SPHERE,
    ),
    Control(
        name="static_friction_dropped",
        fault="only kinetic friction acts",
        plant=_surfaces(lambda law: replace(law, static_friction=law.kinetic_friction)),
        caught_by=("static_friction_above_kinetic",),
        needs=Feature.BOX | Feature.STATIC_FRICTION,
        applies_to_cases=("friction_*",),
    ),
    Control(
        name="approximates_in_silence",
        fault="what is not supported is left out without a word",
        plant=_approximating,
        caught_by=("unclaimed_features_raise_unsupported",),
    ),
)
"""Every planted fault."""
