"""The planted faults of motion: gravity, frames, single steps, digits, forces, damping, sleep, clamps, and what is led."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plumbline.harness.adapter import Adapter, Feature
from plumbline.harness.conformance.frames import rotation
from plumbline.harness.scene import Body, Effect, Scene, Vector3, axis_angle, multiply, principal_inertia
from plumbline.harness.trajectory import Floats, State
from tests.planted_faults.fault import SLIDES, fault
from tests.planted_faults.planting import Rewritten, Wrapped, gravity_times, plant

_TOPS = ("spin_asymmetric_top", "spin_intermediate_axis", "spin_symmetric_top")
_SWINGS = (
    "joint_chain", "joint_conical_pendulum", "joint_double_pendulum", "joint_fourbar", "joint_limits", "joint_pendulum"
)  # fmt: skip
_FALLS = (
    "stand_quadruped", "stack_overhang", "stack_card_house", "stack_pyramid", "flight_*", "friction_*", "rest_*", "stack_tower",
    "impact_bounce", "spin_heavy_top", "tunnel_thin_mesh", *_SWINGS,
)  # fmt: skip
_TIMED = (
    "orbit_kepler", "joint_double_pendulum_chaotic", "flight_*", "spin_heavy_top", "spin_principal", "joint_spring",
    "impact_bounce", "impact_oblique", "impact_pairs", "sensor_imu_noise", *_TOPS, *_SWINGS, *SLIDES,
    "friction_rolling_resistance", "friction_turntable",
)  # fmt: skip
_UNDAMPED = (
    "orbit_kepler", "joint_double_pendulum_chaotic", "flight_*", "spin_principal", "joint_spring", "friction_backspin",
    "friction_roll_incline", "friction_slip_to_roll", "impact_cradle", "impact_gas", "impact_momentum", "impact_oblique",
    "impact_pairs", "sensor_imu_noise", *_TOPS, "joint_chain", "joint_conical_pendulum", "joint_double_pendulum",
    "joint_fourbar", "joint_pendulum", "friction_rolling_resistance",
)  # fmt: skip
"""Cases by what moves in them, as far as they notice the same faults."""

_POINT = Feature.MASS_POINT | Feature.FIXED | Feature.REVOLUTE
_LED = Feature.PRESCRIBED_MOTION | Feature.BOX | Feature.SPHERE

_TENTH = 10

Velocities = Mapping[str, tuple[Vector3, Vector3]]
_STILL: Vector3 = (0.0, 0.0, 0.0)


def _braked(engine: Adapter, rate: float) -> Adapter:
    """Velocities lose `rate` [1/s]: by the engine's own damping where it has one, else in the state behind its back."""

    class Damped(Rewritten):
        def edit(self, before: State, after: State, dt: float) -> bool:
            after.v_WB[:] *= 1 - rate * dt
            after.w_WB[:] *= 1 - rate * dt
            return True

    def slowed(body: Body) -> Body:
        if not body.movable:
            return body
        return replace(body, linear_damping=body.linear_damping + rate, angular_damping=body.angular_damping + rate)

    def change(scene: Scene) -> Scene:
        hidden = Effect.LINEAR_DAMPING | Effect.ANGULAR_DAMPING
        return replace(scene, bodies=tuple(slowed(body) for body in scene.bodies), narrow=scene.narrow & ~hidden)

    if Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING in engine.features:
        return plant(engine, scene=change)
    return plant(engine, simulation=Damped)


@fault("free_fall_has_the_size_and_sign_of_g", "gravity_is_a_vector", cases=_FALLS)
def gravity_upside_down(scene: Scene) -> Scene:
    """gravity with the wrong sign"""
    return gravity_times(scene, -1.0)


@fault(
    "free_fall_has_the_size_and_sign_of_g",
    "gravity_is_a_vector",
    cases=("flight_*", "friction_threshold", "impact_bounce", *_SWINGS),
)
def gravity_two_percent_strong(scene: Scene) -> Scene:
    """gravity times 1.02"""
    return gravity_times(scene, 1.02)


@fault("step_advances_exactly_dt", "free_fall_has_the_size_and_sign_of_g", cases=_TIMED)
def twice_the_time_step(engine: Adapter) -> Adapter:
    """each step advances 2 dt"""
    return plant(engine, settings=lambda settings: settings.with_dt(2 * settings.dt), simulation=Wrapped)


@fault("gyroscopic_term_is_present", needs=Feature.WRENCH, cases=("spin_heavy_top", *_TOPS))
class no_gyroscopic_torque(Wrapped):
    """the term w x I w is dropped"""

    def start(self) -> None:
        n = len(self.scene.bodies)
        self._push: tuple[Floats, Floats] = np.zeros((n, 3)), np.zeros((n, 3))
        self._top = any(body.movable and np.ptp(np.linalg.eigvalsh(np.asarray(body.inertia))) > 0 for body in self.scene.bodies)

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        self._push = f_B_W.copy(), tau_B_W.copy()
        self.inner.wrench(f_B_W, tau_B_W)

    def step(self, count: int = 1) -> None:
        if not self._top:
            self.inner.step(count)
            return
        for _ in range(count):
            state, tau = self.now(), self._push[1].copy()
            for k, body in enumerate(self.scene.bodies):
                if body.movable:
                    R = rotation(state.q_WB[k])
                    # A spin whose square overflows is what a check asks for; the engine is told, and answers as it does.
                    with np.errstate(all="ignore"):
                        tau[k] += np.cross(state.w_WB[k], R @ np.asarray(body.inertia) @ R.T @ state.w_WB[k])
            self.inner.wrench(self._push[0], tau)
            self.inner.step()


@fault(
    "angular_velocity_is_in_W",
    "initial_state_comes_back",
    cases=("stand_hit", "spin_fast", "impact_gas", "impact_momentum", "impact_oblique", *_TOPS),
)
class angular_velocity_in_the_body_frame(Wrapped):
    """w is handed out in B"""

    def state(self, out: State) -> None:
        self.inner.state(out)
        for k in range(len(out.w_WB)):
            out.w_WB[k] = rotation(out.q_WB[k]).T @ out.w_WB[k]


@fault("quaternion_is_wxyz", "initial_state_comes_back", cases=("spin_principal", *_TOPS))
class quaternion_scalar_last(Wrapped):
    """quaternions are handed out as (x, y, z, w)"""

    def state(self, out: State) -> None:
        self.inner.state(out)
        out.q_WB[:] = np.roll(out.q_WB, -1, axis=1)


@fault("inertia_is_in_B", cases=("stand_hit", "spin_asymmetric_top", "spin_intermediate_axis"))
def inertia_axes_exchanged(body: Body) -> Body:
    """the first two rows and columns of the inertia are exchanged"""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
    return replace(body, inertia=((yy, xy, yz), (xy, xx, xz), (yz, xz, zz)))


@fault("hidden_damping_is_off", cases=_UNDAMPED)
def hidden_damping(engine: Adapter) -> Adapter:
    """velocities lose 4 % a second"""
    return _braked(engine, 0.04)


@fault("sleeping_is_off", cases=("friction_threshold", "friction_wall_pinch"))
class sleeping(Rewritten):
    """bodies slower than .1 m/s for .1 s are put to sleep

    Where all sleep and nothing pushes, the engine inside is not stepped: it would be built anew in each step.
    """

    def start(self) -> None:
        self._quiet = np.zeros(len(self.scene.bodies))

    def _step_inside(self) -> None:
        pushed = self._push is not None and any(load.any() for load in self._push)
        if pushed or not (self._quiet > 0.1).all():
            super()._step_inside()

    def edit(self, before: State, after: State, dt: float) -> bool:
        slow = (np.linalg.norm(after.v_WB, axis=1) < 0.1) & (np.linalg.norm(after.w_WB, axis=1) < 0.1)
        self._quiet[:] = np.where(slow, self._quiet + dt, 0.0)
        asleep = self._quiet > 0.1
        if not (asleep.any() and (after.v_WB[asleep].any() or after.w_WB[asleep].any())):
            return False
        for target, source in ((after.p_WB, before.p_WB), (after.q_WB, before.q_WB)):
            target[asleep] = source[asleep]
        after.v_WB[asleep], after.w_WB[asleep] = 0.0, 0.0
        return True


@fault("step_advances_exactly_dt", cases=("flight_*", "spin_principal", "sensor_imu_noise"))
class state_one_step_behind(Wrapped):
    """the state is that of one step ago"""

    def start(self) -> None:
        self._before = self.now()

    def step(self, count: int = 1) -> None:
        if count > 1:
            self.inner.step(count - 1)
        self._before = self.now()
        self.inner.step()

    def state(self, out: State) -> None:
        for target, source in zip(
            (out.p_WB, out.q_WB, out.v_WB, out.w_WB),
            (self._before.p_WB, self._before.q_WB, self._before.v_WB, self._before.w_WB),
            strict=True,
        ):
            target[:] = source


@fault("velocity_is_not_clamped")
class velocity_clamped(Rewritten):
    """100 m/s and 100 rad/s are the most"""

    def edit(self, before: State, after: State, dt: float) -> bool:
        cut = False
        for array in (after.v_WB, after.w_WB):
            size = np.linalg.norm(array, axis=1, keepdims=True)
            if (size > 100.0).any():
                array[:] *= np.minimum(1.0, 100.0 / np.maximum(size, 1e-300))
                cut = True
        return cut


@fault("body_order_is_kept", "initial_state_comes_back")
class body_order_permuted(Wrapped):
    """the first body comes last"""

    def state(self, out: State) -> None:
        self.inner.state(out)
        for array in (out.p_WB, out.q_WB, out.v_WB, out.w_WB):
            array[:] = np.roll(array, -1, axis=0)


@fault("wrench_has_sign_and_size", needs=Feature.WRENCH)
def mass_ten_percent_light(body: Body) -> Body:
    """masses times .9"""
    return replace(body, mass=0.9 * body.mass)


@fault("wrench_has_sign_and_size", needs=Feature.WRENCH)
class wrench_reversed(Wrapped):
    """forces push the other way"""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        self.inner.wrench(-f_B_W, -tau_B_W)


@fault("initial_state_comes_back", cases=("flight_*", "spin_heavy_top", "spin_principal", *_TOPS))
def initial_velocity_dropped(body: Body) -> Body:
    """every body starts from rest"""
    return replace(body, v_WB=(0.0, 0.0, 0.0), w_WB=(0.0, 0.0, 0.0))


@fault("gravity_has_three_digits")
def gravity_half_a_percent_weak(scene: Scene) -> Scene:
    """gravity times .995"""
    return gravity_times(scene, 0.995)


@fault("gravity_has_three_digits")
def gravity_a_thousandth_weak(scene: Scene) -> Scene:
    """gravity times .999"""
    return gravity_times(scene, 0.999)


@fault("steps_are_even")
def uneven_steps(engine: Adapter) -> Adapter:
    """steps of .9 and 1.1 dt in turns"""

    class Uneven(Wrapped):
        _odd = False

        def step(self, count: int = 1) -> None:
            for _ in range(count):
                self.inner.step(_TENTH + 1 if self._odd else _TENTH - 1)
                self._odd = not self._odd

    return plant(engine, settings=lambda settings: settings.with_dt(settings.dt / _TENTH), simulation=Uneven)


@fault("step_lengths_are_kept", needs=Feature.STEP_LENGTHS)
class step_lengths_ignored(Wrapped):
    """every step is dt long, whatever is told for it"""

    def retime(self, dt: float) -> None:
        """Not heard."""


@fault("no_step_is_no_step")
class no_step_is_a_step(Wrapped):
    """step(0) takes a step"""

    def step(self, count: int = 1) -> None:
        self.inner.step(max(count, 1))


@fault("nothing_brakes_a_free_body", needs=Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING, name="damping_of_1e-4_a_second")
def damping_of_a_ten_thousandth_a_second(engine: Adapter) -> Adapter:
    """velocities lose 1e-4 of themselves a second"""
    return _braked(engine, 1e-4)


@fault("nothing_brakes_a_free_body", needs=Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING, name="damping_of_1e-5_a_second")
def damping_of_a_hundred_thousandth_a_second(engine: Adapter) -> Adapter:
    """velocities lose 1e-5 of themselves a second"""
    return _braked(engine, 1e-5)


@fault("slow_motion_is_motion")
class slow_is_still(Wrapped):
    """speeds below 1e-3 m/s and rad/s are read as 0"""

    threshold = 1e-3

    def state(self, out: State) -> None:
        self.inner.state(out)
        for array in (out.v_WB, out.w_WB):
            array[np.linalg.norm(array, axis=1) < self.threshold] = 0.0


@fault("slow_motion_is_motion")
class micrometres_are_still(slow_is_still):
    """speeds of 1e-6 m/s and rad/s are read as 0"""

    threshold = 1.001e-6


@fault("states_have_double_precision")
class states_in_single_precision(Wrapped):
    """states are handed out in float32 where float64 is claimed"""

    def state(self, out: State) -> None:
        self.inner.state(out)
        for array in (out.p_WB, out.q_WB, out.v_WB, out.w_WB):
            array[:] = array.astype(np.float32)


@fault("push_acts_at_the_centre_of_mass", needs=Feature.WRENCH | Feature.SPHERE)
class push_at_the_shapes(Wrapped):
    """forces act where the first shape is, not at the centre of mass"""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        tau, state = tau_B_W.copy(), self.now()
        for k, body in enumerate(self.scene.bodies):
            if body.movable and body.collision:
                tau[k] += np.cross(rotation(state.q_WB[k]) @ np.array(body.collision[0].p_BS), f_B_W[k])
        self.inner.wrench(f_B_W, tau)


@fault("wrench_has_sign_and_size", needs=Feature.WRENCH)
class torque_dropped(Wrapped):
    """torques handed in are forgotten"""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        self.inner.wrench(f_B_W, np.zeros_like(tau_B_W))


@fault("products_of_inertia_count", needs=Feature.FULL_INERTIA)
def products_of_inertia_dropped(body: Body) -> Body:
    """the inertia keeps its diagonal alone"""
    (xx, _, _), (_, yy, _), (_, _, zz) = body.inertia
    return replace(body, inertia=((xx, 0.0, 0.0), (0.0, yy, 0.0), (0.0, 0.0, zz)))


@fault("kinematic_body_keeps_its_velocity", needs=Feature.KINEMATIC | Feature.BOX)
class kinematic_stands_still(Wrapped):
    """kinematic bodies stand where they started"""

    def state(self, out: State) -> None:
        self.inner.state(out)
        start = State.initial(self.scene)
        for k, body in enumerate(self.scene.bodies):
            if body.motion == "kinematic":
                out.p_WB[k], out.q_WB[k] = start.p_WB[k], start.q_WB[k]


@fault(
    "prescribed_motion_is_where_its_law_has_it",
    "prescribed_plate_takes_along_what_friction_can",
    "prescribed_platform_lifts_what_it_meets",
    "prescribed_paddle_sweeps_a_ball_outwards",
    needs=_LED,
)
class prescribed_motion_ignored(Wrapped):
    """bodies whose motion is prescribed stay where they are"""

    def prescribe(self, velocities: Velocities) -> None:
        """Without it they would keep the velocity that they start with."""
        self.inner.prescribe(dict.fromkeys(velocities, (_STILL, _STILL)))


@fault("prescribed_motion_is_where_its_law_has_it", needs=_LED)
class prescribed_motion_a_step_late(Wrapped):
    """bodies whose motion is prescribed are a step late"""

    def start(self) -> None:
        self._before: Velocities = {}

    def prescribe(self, velocities: Velocities) -> None:
        self.inner.prescribe(self._before)
        self._before = velocities


@fault("prescribed_motion_is_where_its_law_has_it", "prescribed_paddle_sweeps_a_ball_outwards", needs=_LED)
class prescribed_turn_in_place(Wrapped):
    """bodies that are turned about an axis turn about their own middle"""

    def prescribe(self, velocities: Velocities) -> None:
        self.inner.prescribe({name: (_STILL if any(w) else v, w) for name, (v, w) in velocities.items()})


@fault("prescribed_plate_takes_along_what_friction_can", needs=_LED)
class prescribed_motion_without_velocity(Rewritten):
    """bodies whose motion is prescribed are put in their places and have no velocity"""

    def start(self) -> None:
        self._velocities: Velocities = {}

    def prescribe(self, velocities: Velocities) -> None:
        self._velocities = velocities

    def edit(self, before: State, after: State, dt: float) -> bool:
        for name, (v, w) in self._velocities.items():
            k = self.scene.index(name)
            after.p_WB[k] += dt * np.array(v)
            speed = float(np.linalg.norm(w))
            if speed > 0.0:
                q_w, q_x, q_y, q_z = (float(c) for c in after.q_WB[k])
                after.q_WB[k] = multiply(axis_angle(w, speed * dt), (q_w, q_x, q_y, q_z))
            after.v_WB[k] = after.w_WB[k] = 0.0
        return bool(self._velocities)


@fault("mass_point_counts_where_it_is_fixed", needs=_POINT)
def mass_point_given_an_extent(body: Body) -> Body:
    """a mass point is silently a ball of 1 m"""
    moment = 0.4 * body.mass
    return replace(body, inertia=principal_inertia(moment, moment, moment)) if body.mass_point else body


@fault("mass_point_flies_and_hangs", needs=_POINT | Feature.DISTANCE_SPRING)
def mass_point_ten_percent_light(body: Body) -> Body:
    """mass points weigh .9 of what they should"""
    return replace(body, mass=0.9 * body.mass) if body.mass_point else body


@fault("force_lead_is_what_a_step_shows", needs=Feature.WRENCH)
class lead_of_forces_too_long(Wrapped):
    """forces are said to act half a step later than they do"""

    @property
    def force_lead(self) -> float:
        """The share of a step."""
        return 0.5 + float(self.inner.force_lead)  # type: ignore[attr-defined]  # what an engine may offer


@fault("strong_damping_brings_to_rest", needs=Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING)
def strong_damping_dropped(body: Body) -> Body:
    """damping of more than 100/s is left out"""
    return replace(body, linear_damping=0.0, angular_damping=0.0) if body.linear_damping > 100.0 else body


@fault("strong_damping_brings_what_hangs_to_rest", needs=Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING | Feature.REVOLUTE)
def strong_damping_of_what_hangs_dropped(scene: Scene) -> Scene:
    """damping of more than 100/s is left out of bodies that hang on a joint"""
    hung = {joint.child for joint in scene.joints}
    return replace(scene, bodies=tuple(strong_damping_dropped(b) if b.name in hung else b for b in scene.bodies))
