"""MuJoCo through its own Python package: generalised coordinates, soft convex contacts, one native call for many steps.

Tried with mujoco 4.0.0. Bodies hang in a forest of native joints, so that those have no gap; joints that close a loop become
equality constraints, distances become tendons. Each body's own frame M stands at the centre of mass along the principal axes.

Sources (MuJoCo documentation, by chapter): "Computation": numerical integration, constraint model, contact; "Modeling": solver
parameters, contact parameters, preventing slip; "Simulation": state and control, diagnostics; XML reference: compiler, size;
change log of 4.0.0, release notes of 4.0.1.

Deviations:

* Contacts, limits and loop joints are soft: a body at rest sinks by micrometres, one that lands sinks by about speed times time
  constant, and a loop has a gap. A contact under friction creeps.
* There is no coefficient of restitution. For e > 0 the contact becomes a spring and damper whose damping ratio is solved
  for, on the discrete recursion that the engine steps, so that the mean rebound over all phases of the step is e; single
  rebounds scatter by the phase (about .02 at e = .5) and the body sinks in by about 3 v dt. An e > 0 below the least rebound of
  that family (about .03) is `Unsupported`; e = 0 keeps the usual contact, which is critically damped and cannot pull, so that
  a body that nothing presses down leaves with up to e^-2 = .135 of its speed. The law is exact for one point between a free
  body and a fixed one, and approximate where several contacts share a body. The discrete integrator damps every rebound:
  `Unsupported`.
* Friction with restitution needs the elliptic cone, whatever the track: a pyramid mixes the rebound into the friction. On
  the cone a slip still bends the rebound, while friction stays mu times the normal force. Measured with mu .1 to 1 at 1e-3: a
  slip up to the speed of approach by 5 %, up to three times that by -20..+13 % at e >= .5 and up to +43 % at e = .3; at ten
  times it by -25..+70 % and up to +154 %, at thirty times up to +137 % and +261 %. Neither impratio nor the slip correction
  changes that; a slower friction does (`friction_steps`), but stops less of the slip: as it is, a grip leaves up to e^-2 =
  .135 of it. A longer impact does too (`rebound_steps`): askew at e = .6 and mu = .3, 1/240 s, the worst of seven balls errs by
  .104 of the speed of approach with ten steps of either, by .084 with 40 and 60; heights of bounces err least with ten.
* Springs and drives in a scene where bodies can touch, and elsewhere those that swing by more than 1.5 rad a step, are stepped
  by the discrete integrator on tuned: it rests where the implicit one jitters, stands where that one blows up, and damps. An
  arm of 3, 2 and 1 kg on drives of 200 N m/rad and 2 N m s/rad, touching nothing, errs by .016 rad after .25 s at 1/240, by
  Euler .010, implicitfast .005.
* Where something fast would be pressed through something thin, by the speeds and widths that the scene starts with, contacts on
  tuned last two steps: at 1/240 s a wall of 1 cm holds 12 m/s for 4.7, posts rods of 11.2 rad/s for 5.6. What was stopped
  leaves faster: a ball of 50 m/s is 34 mm from the wall after a quarter of a second, not 15. What becomes fast later is not
  foreseen.
* Where a body may bear another many times as heavy, contacts on tuned take the greatest impedance, .9999: a cube under a
  thousand times its weight gives way by .28 mm for 2.83, at the same price. Elsewhere it would cost: 3.5 times as much for the
  pyramid of twenty boxes, 16 times for the heap of twenty balls.
* The damping of a drive is its actuator's (kv), which Euler takes explicitly, where that is stable by the step on the inertia
  that the contacts of the start leave; elsewhere it is the joint's, which Euler takes implicitly. `resolved` says which. The
  other one would be worse: a quadruped at 1/240 s gives way by .040 rad for .0031, a humanoid blows up that gives way by .0030.
* Sliding, torsional and rolling friction share one cone, so that each takes from the others; a coefficient below 1e-5 counts as
  1e-5 where another one is above zero.
* Friction is soft. With its time constant tc (on tuned the contact's, 20 ms at most), what slips by less than mu g tc/2 under
  its own weight is rubbed by a damper, 2 m v/tc; what slips faster by mu N, where N exceeds the weight by m (2 v/tc - mu g)
  mu/(1 + mu^2), so that it lifts. Neither impratio, the slip correction nor the tolerance
  changes that alone; an impratio of 1e-4 with the slip correction does: a ball slides into rolling as Coulomb says, to mu g dt,
  and a box neither hops nor errs, but what sticks creeps by mm/s. Tuned takes 1e-6 where balls alone move, which touch no other
  ball. `friction_steps` of
  2/mu rubs in full from a slip of g dt on, but lifts more (a cube at 3 m/s hops 19 to 37 mm for 1.4 to 2.4), and where balls
  slip it errs up to four times as much. So tuned lacks .01 to .2 of the weight of cubes at worst at 1/480 s and below, and up
  to 1.1 where balls roll against friction or on a turntable.
* The gyroscopic term is part of the bias force and cannot be switched off.
* Convex hulls and meshes are stored in single precision. A mesh collides as its hull: `Unsupported` in contact if concave.
* A kinematic body has an armature 1e12 times the mass of the scene: forces move it by that share. A joint between two bodies
  that are fixed to each other anyway lets them not collide.
* Damping of a body inside a joint tree is `Unsupported` unless its motion is that of one coordinate of its own.
* A revolute joint that closes a loop is held at two points of its axis, which is one constraint more than it needs.
* Images are rasterised: round shapes are polyhedra, depth is a single-precision buffer, colours have 8 bits, nothing casts
  a shadow, and what a surface mirrors or lets through is taken to be the sky.
* `contacts` are those that the last step was made with, at its start; under RK4 those of its last stage.

No knobs, though documented, tried over pendulums, loops, stops, impacts, friction, stacks and tunnelling at half the step of
each case: ls_tolerance, ccd_iterations, ccd_tolerance, multiccd, island and warmstart change no answer by more than rounding;
fewer ls_iterations lose a turntable; nativeccd off lets pass what must not; eulerdamp off errs by a third more; diagexact errs
four times as much under a mass ratio and opens a loop; refsafe off means nothing but below two steps, or one with the discrete
integrator. noslip_tolerance ends what noslip_iterations end too. The override (o_solref, o_solimp) says again what each contact
is told; margin and gap move the surface; the width of solimp means nothing at constant impedance; sleep, wind and fluids no
scene asks for; `speculative` follows the scene.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from plumbline.adapters.mujoco.build import build
from plumbline.adapters.mujoco.knob_trade_offs import KNOB_TRADE_OFFS
from plumbline.adapters.mujoco.many_worlds import MujocoWorlds
from plumbline.adapters.mujoco.options import INTEGRATORS, SOLVERS
from plumbline.adapters.mujoco.simulation import MujocoSimulation
from plumbline.adapters.mujoco.softness import VENDOR_TIME_CONSTANT
from plumbline.adapters.mujoco.vendor import mujoco_module
from plumbline.harness.adapter import Adapter, Emulation, Feature, Settings, Simulation, TradeOff, Unsupported
from plumbline.harness.adapter.many_worlds import Batch
from plumbline.harness.adapter.mass_points import POINTS_AS_BODIES, built_with_points
from plumbline.harness.scene import Effect, Scene

if TYPE_CHECKING:
    from pathlib import Path

    from plumbline.harness.scene.parity.canonical import Canonical
    from plumbline.harness.scene.parity.loaded import Loaded, Request
    from plumbline.harness.scene.parity.parting import Motion
    from plumbline.harness.trajectory import Floats

__all__ = ["ADAPTER"]


@dataclass(frozen=True, kw_only=True)
class MujocoAdapter(Adapter):
    """MuJoCo."""

    def version(self) -> str:
        """The installed version. Raises: Unavailable."""
        return str(mujoco_module().__version__)

    def load_robot(self, path: "Path", request: "Request") -> "Loaded":
        """What the package's own loader makes of a robot file. Raises: Unsupported, Unavailable."""
        from plumbline.adapters.mujoco.robot_loader import load

        if request.way:
            raise Unsupported(f"loader {request.way!r}", "there is one alone")
        return load(path, request)

    def move_robot(self, robot: "Canonical", motion: "Motion") -> "Floats":
        """The positions of a robot of facts that torques move. Raises: Unsupported, Unavailable."""
        from plumbline.adapters.mujoco.robot_motion import moved

        return moved(robot, motion)

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """Exactly this scene. Raises: Unsupported, Unavailable, SettingsError."""
        return built_with_points(lambda told: build(mujoco_module(), told, settings), scene)

    def build_batch(self, scene: Scene, settings: Settings, count: int) -> Batch:
        """States of one model; one simulation each where mass points stand in the scene. Raises: as `build`."""
        first = self.build(scene, settings)
        if isinstance(first, MujocoSimulation):
            return MujocoWorlds(first, count)
        first.close()
        return super().build_batch(scene, settings, count)


ADAPTER = MujocoAdapter(
    loaders=("",),
    name="mujoco",
    title="MuJoCo",
    distribution="mujoco",
    licence="Apache-2.0",
    platforms=("linux-x86_64", "linux-aarch64", "macos-arm64", "windows-x86_64"),
    features=~(Feature.MOVING_MESH | Feature.STATIC_FRICTION | Feature.SPEED_LIMIT | Feature.RAY_TRACING),
    tracks={
        "default": Settings(
            source="MuJoCo's own defaults: Euler, Newton, 100 iterations, tolerance 1e-8, pyramidal cone, impratio 1"
        ),
        "tuned": Settings(
            tolerance=1e-10,
            options={
                "by_scene": True,
                "cone": "elliptic",
                "impratio": 10.0,
                "rolling_impratio": 1e-6,
                "contact_steps": 20.0,
                "fast_steps": 2.0,
                "contact_damping_ratio": 1.2,
                "limit_steps": 2.0,
                "limit_damping_ratio": 1.7,
                "limit_impedance": 0.999,
                "slowest": VENDOR_TIME_CONSTANT,
                "loop_steps": 2.0,
                "loop_impedance": 0.999,
            },
            source=(
                "MuJoCo documentation: 'Modeling', preventing slip (elliptic cone, impratio above 1) and solver parameters"
                " (time constant at least twice the time step, which contacts take that would be pressed through "
                "otherwise; measured here: of others, below 20 steps contacts lift what slides, below damping ratio 1.2 "
                "they rebound; impedance .999, .9999 under many times a body's weight; a stop, along which nothing slides,"
                " is held at two steps, and of ratio 1.7 returns a rod by .008 rad where one of 1 does by .05; the "
                "emulated rebound lasts ten steps: with them bounces err least in height over the ladder); 'Computation', "
                "numerical integration (RK4 for smooth motion whose springs and dampers it resolves, implicit for stiffer "
                "dampers, discrete for stiffer springs; measured here: in contact the implicit one jitters where Euler "
                "rests); release notes of 4.0.1 (sparse factor of 4.0.0: dense Jacobian where constraints couple the "
                "branches of hinged trees, alone); friction of balls that touch what stands alone left to the slip "
                "correction ('Computation', noslip; measured here)"
            ),
        ),
    },
    knobs={
        "integrator": INTEGRATORS,
        "substeps": (1, 2, 4, 8),
        "solver": SOLVERS,
        "iterations": (5, 20, 100),
        "tolerance": (1e-6, 1e-8, 1e-10, 1e-12),
        "options.cone": ("pyramidal", "elliptic"),
        "options.impratio": (1.0, 10.0, 100.0),
        "options.noslip_iterations": (0, 5, 20),
        # A search turns a knob to its next value first. Where steps are long, tuned's `slowest` decides what 20 steps and more
        # are: four of them are the first that tell, and so is a shorter `slowest`.
        "options.contact_steps": (40.0, 20.0, 4.0, 2.0, 0.5),
        "options.fast_steps": (2.0, 5.0, 20.0),
        "options.contact_damping_ratio": (0.5, 1.0, 1.2, 2.0),
        "options.contact_impedance": (0.95, 0.999, 0.9999),
        "options.friction_steps": (2.0, 5.0, 10.0, 20.0, 40.0),
        "options.rebound_steps": (5, 10, 20, 40, 80),
        "options.limit_steps": (2.0, 5.0, 20.0),
        "options.limit_damping_ratio": (1.0, 1.7, 3.0),
        "options.loop_steps": (2.0, 5.0, 20.0),
        "options.loop_impedance": (0.95, 0.999, 0.9999),
        "options.slowest": (0.1, VENDOR_TIME_CONSTANT, 0.005, 0.001),
        "options.jacobian": ("auto", "dense", "sparse"),
    },
    acts_on={
        **dict.fromkeys(("solver", "iterations", "tolerance", "options.jacobian"), Effect.CONTACT | Effect.JOINTS),
        **dict.fromkeys(
            ("options.cone", "options.contact_steps", "options.fast_steps", "options.contact_damping_ratio"), Effect.CONTACT
        ),
        "options.contact_impedance": Effect.CONTACT,
        **dict.fromkeys(("options.impratio", "options.friction_steps"), Effect.FRICTION),
        "options.noslip_iterations": Effect.FRICTION | Effect.JOINTS,
        "options.rebound_steps": Effect.RESTITUTION,
        **dict.fromkeys(("options.limit_steps", "options.limit_damping_ratio"), Effect.JOINTS),
        **dict.fromkeys(("options.loop_steps", "options.loop_impedance"), Effect.JOINTS),
    },
    remedies={
        "contact of two steps": ("options.contact_steps", 2.0),
        "contact damping ratio .5": ("options.contact_damping_ratio", 0.5),
        "contact damping ratio 2": ("options.contact_damping_ratio", 2.0),
    },
    known_failures={
        "default/continuous_collision_stops_a_fast_ball": "the vendor leaves speculative contacts off",
        "default/friction_is_isotropic": "the vendor's default cone is a pyramid: friction towards its edges is up to 41 % off",
        "default/rolling_friction_brakes": "the vendor's default cone is a pyramid: it weakens rolling friction by 15 %",
        "default/distance_joint_keeps_its_length": (
            "the vendor's default time constant of constraints is .02 s: a rod that is let fall gives way by .7 %"
        ),
        "default/dry_friction_beside_a_drive": (
            "the vendor's default softness of dry friction: what it holds creeps, under two thirds of the bound by .8 mm/s"
        ),
        "default/coupled_coordinates_move_as_one": (
            "the vendor's default time constant of constraints is .02 s: coupled joints let fall part by .02 m/s at first"
        ),
    },
    trade_offs=(
        TradeOff(
            cases=("friction_painleve",),
            at=("ladder",),
            why=(
                "contacts of 20 steps are stiffer than the vendor's below 1e-3 s, and lift what slides: at 1/7680 s .0070 "
                "against .0007; 40 steps bring .0006, but lose what stands and what must not pass: at 1/1920 s a pyramid "
                "drifts .029 mm for .007, and a thin mesh lets 9 % through for none"
            ),
        ),
        TradeOff(
            cases=("joint_long_run",),
            at=("ladder",),
            why=(
                "RK4 loses a share of z^5/144 of an amplitude a radian, z being the phase of a step; Euler is symplectic: at "
                "1/20 s 9.5e-6 against 1.5e-7, the bound being 3.8e-4; from 1/90 s down RK4 errs less"
            ),
        ),
        TradeOff(
            cases=("orbit_kepler",),
            at=("ladder",),
            why=(
                "told its force once a step, RK4 drifts, kicks and drifts, and is of second order as the default: within an "
                "eighth of it but at 1/60 s, where the textbook's drift, kick and drift itself measures the same 20.8 rad as "
                "it passes the middle of its path 98 times in 100 turns; the angle at the end errs by 4.14 rad, by 4.23 on "
                "default"
            ),
        ),
        TradeOff(
            cases=("stack_pile",),
            at=("ladder",),
            why=(
                "where a pile comes to rest in steps of 1/60 s is chance: .0131 against .0071, and .0062 to .0107 under five "
                "other settings of cone, impratio, damping ratio and impedance; from 1/480 s down tuned errs less"
            ),
        ),
        *KNOB_TRADE_OFFS,
    ),
    loads=("mujoco",),
    orders={"euler": 1, "implicit": 1, "implicitfast": 1, "discrete": 1, "rk4": 4},
    emulated=(
        Emulation(
            feature=Feature.MASS_POINT,
            how=POINTS_AS_BODIES,
        ),
        Emulation(
            feature=Feature.RESTITUTION,
            how="MuJoCo has no coefficient of restitution; the contact is given a stiffness and a damping whose mean rebound "
            "is e, and friction beside it a time constant of its own",
        ),
        Emulation(
            feature=Feature.KINEMATIC,
            how="MuJoCo has no body of prescribed velocity; it is a free one with an armature of 1e12 times the scene's mass",
        ),
        Emulation(
            feature=Feature.CLOSED_LOOP,
            how="MuJoCo closes loops by points and welds; a revolute joint is two points of its axis, each held together",
            where="where a revolute joint closes the loop",
        ),
    ),
    deviations=(
        "contacts, limits and loop joints are soft: they sink, creep and gap",
        "MuJoCo has no restitution: the adapter emulates it by a spring and damper, calibrated to the mean rebound; single "
        "rebounds scatter with the phase of the step",
        "a slip bends a rebound: by up to 20 % up to three times the speed of approach (43 % at e = .3), by more where faster",
        "without restitution a contact is critically damped and cannot pull: it gives back up to .135 of the speed of impact",
        "sliding, torsional and rolling friction share one cone",
        "friction is soft: a damper to slips below half of mu g times its time constant; faster ones press bodies apart",
        "the gyroscopic term cannot be switched off",
        "meshes and hulls are held in single precision, and a mesh collides as its hull",
    ),
)
