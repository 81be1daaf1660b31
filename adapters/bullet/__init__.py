"""Bullet through its Python binding pybullet 3.2.7: rigid bodies, trees of joints, contacts and rays.

Sources:
    E. Coumans, Y. Bai, *PyBullet Quickstart Guide* (sections createMultiBody, changeDynamics, setPhysicsEngineParameter,
    setJointMotorControl2, rayTestBatch, Synthetic Camera Rendering); the C++ sources that pybullet 3.2.7 ships with.

Every body is put in its principal frame I (origin at the centre of mass), because Bullet knows diagonal inertia alone:
q_WB = q_WI q_BI*. A tree of joints becomes one multibody in reduced coordinates, whose links start at joint coordinate zero;
a joint that closes a loop becomes point-to-point or fixed constraints. With `joints` = "scene" so does the ball joint of a fast
top, whose body stays free: the reduced-coordinate ball joint has an explicit gyroscopic term and loses a top of 100 rad/s at
1/240 s (farther from its place than its pivot is), the constraint errs by 26 mm in one step and 5.5 mm in four, to 5000 rad/s.
So do hinges of fast rotors (`harness.adapter.fast_rotors`): a gimbal whose wheel spins at 150 rad/s and wobbles at 147 ends
with 3.4 times its energy after 2 s at 1/240 s and at 1e-3 s on links, on the wheel's constraint it keeps it to 1e-4.

Deviations:
    * Joints have no motor but what the scene says, on both tracks. pybullet puts one that asks for no velocity on every joint:
      on a hinge or slide it bears up to 1 N m s or N s a step (240 N m at 1/240 s, 1000 at 1 ms), on a ball joint no bound
      was met (2 t at 1 m), so that a pendulum of 1 kg hangs level for a minute. `default` is what a newcomer gets but for that.
    * Springs and drives act as torques that the adapter holds over each (sub)step (`TORQUE_CONTROL`), because Bullet's own
      position motor is a velocity constraint without a stiffness in N m/rad, and `PD_CONTROL`, which its manual does not name,
      holds the force of the step's start whatever the step. Where the torques of the step's start could
      reverse a velocity within it they are those of its end, linearly implicit, with the accelerations by all else that the
      (sub)step before had (`Actuation`). Machines without a fixed base are taken to be held at the points that bear them, as
      the step before left these: with the mobility of a foot in the air their hinges would tremble (humanoid, 1/240 s: 0.06
      rad), with the torques of the step's start they would fall at 1/120 s. What holds may give way, as wheels slip: no
      torque is such that a joint then goes beyond the rate at which its drive pushes no more, by more than what held drove it
      in the step before. With `drives` = "motor" Bullet's own motors drive, rigid up to their limit; no track takes them, as
      they are another law.
    * Dry friction in a joint is Bullet's own motor that asks for no velocity, with a bounded force: Coulomb's law; a joint that
      Bullet's motor drives cannot have it. A coupling is Bullet's gear, a velocity constraint: what it drifts is rounding.
    * A spring between points of two bodies (`Distance` with a spring) is a pair of forces of the adapter, held over each
      (sub)step: those of its start where no pose lets them reverse a velocity within it, else those of its end along the line,
      linearly implicit, stable at any stiffness and damped by it (`harness.adapter.distance_springs`). Across the line the
      force is that of the start: stable while h^2 f/(m l) < 4, f the tension, m the mass at the end of the line, l its length.
    * A fast rotor whose hinge is driven, sprung or limited stays on a link, and `warnings()` says how its wobble grows; it does
      so too where a constraint does not suffice: at a wobble of a fifth of a radian a step, or of a rotor that is uneven across
      its axis (moments of 1 to 4: at 1/960 s 86 % of the energy was lost within 2 s, where links end beyond 1e56 of it).
    * A kinematic body is a body of 1e12 times the scene's largest mass, held up against gravity, whose velocity is prescribed
      anew in every (sub)step: pybullet offers no way to flag a body as kinematic.
    * Sub-steps are steps of dt/substeps; where nothing acts from outside and no contact force is asked for, many go in one
      native call (numSubSteps), the same bit for bit. Contact forces are the mean over the sub-steps of a step, the
      points those of the last and all that bore a force before. On `tuned` no (sub)step is longer than 1/240 s, which the
      vendor says to leave as it is, or than 1/960 s where a fast top or rotor is held: a coarser dt costs and errs as that.
    * The gap at which a point of contact is let go is one for all worlds of a process (gContactBreakingThreshold): each world
      here sets its own again before it steps.
    * Friction may be left on a point that bears nothing: the solver bounds it by a normal force that it takes back later in the
      same step (a ball with backspin at 1/60 s: 0.11 of its weight, in the step in which slip ends).
    * Rays and images are taken in a second world that holds the same shapes at the present poses, so that a scene that never
      senses does not pay. Rays on spheres, capsules and cylinders err by millimetres at grazing incidence.
    * pybullet has no ellipsoid: it is refused, since a hull of corners rests on its faces; pictures draw one.
    * TinyRenderer draws balls, cylinders and capsules as hulls of 42 of their points, whose outlines sag by some 5 % of the
      radius, a plane as a square of a kilometre, and nothing nearer than 5 cm or beyond 100 m. Its shadows are off, since one
      falls on nearly all of a floor or on nothing; what a surface mirrors or lets through is taken to be the sky.
    * A turn of t > pi/4 in one (sub)step becomes 2 atan(4 t/pi tan(pi/8)), 1.38 for pi/2, although the angular velocity stays
      (ANGULAR_MOTION_THRESHOLD of btTransformUtil.h).
    * Hulls in compounds travel through a temporary OBJ file in single precision. Hulls in compounds and on links keep Bullet's
      collision margin and are 1 mm thicker.
    * Rebounds of multibodies (joints, rolling friction) gain up to 8 % of the speed of impact (contact ERP), and on `default`
      lose the gap that is left when the contact is found, divided by dt.
    * Where something with faces may meet a static plane, it meets a box in its place, as in pybullet_data's own plane.urdf,
      which ends a kilometre beyond all that moves at the start; what is round meets the plane. Bullet finds up to four points
      of two boxes at once, and of a plane one more a step: there a box that is set down at 1/240 s sinks by 0.2 mm, for 0.01,
      and at 1/15 s falls over. Twenty boxes at rest cost 1.6 times as much on a box. Rays and images see the plane.
    * Sliding. Maximal coordinates bound friction along two directions apart: the forces of a point may be up to sqrt(2) mu N
      and askew to its slip, and a ball slips down a groove at mu 0.05 by 4 % too slowly; two boxes slide right all the same,
      since between their points that cancels. On points that are found one a step they brake too much: at mu 0.5 a cylinder on
      its end slides down a box of 1.1 times the critical angle 0.66 of its way, a hull 0.88 (dt 1/240). Multibody coordinates
      bound each point by a cone, and brake what is found so a little too little, 1.10 and 1.07. Of faces that slide askew to
      Bullet's two directions at a normal they bear too little: a box on an incline of 1.15 times the critical angle, all turned
      by 45 degrees about the vertical, goes 1.8 times as fast as due and 20 degrees off, at any step and number of iterations.
      `tuned` takes them where friction may slide something, where anything moves at the start or is held on a face that slopes:
      for what is round, and for what has faces where its way lies along those directions or both are alike to it. It keeps
      maximal ones for what has faces elsewhere, for bodies that rebound, turn fast, are swept or damped, and for what stands
      level and still, which rests with a tenth of the speed that is left in multibody ones, at two thirds of the cost.
    * With restitution and friction at once, bodies that rest creep under a push below the limit of friction: at 0.9 of it and
      e = 0.5 by 1-4 mm in 1.5 s at dt 1/240, by 0.6 mm and less at 1/1000 (without restitution by 0.2 and 0.05 mm).
    * The solver stops early once no constraint's speed changes by more than the root of `tolerance` in an iteration: 3e-4 m/s
      at the vendor's 1e-7, where a humanoid trembles beyond its bound and a box on a slope creeps by 2e-5 m/s; `tuned` has
      1e-9.
    * A heavy body on a light one takes iterations by the ratio of their masses, on `tuned` 0.6 for each unit of it, from 200 to
      1200: a thousand on one costs 2.9 times as much as in 200, and errs by a tenth.
    * Rolling friction acts along two fixed directions, each with its own bound.
"""

import importlib.metadata
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from plumbline.adapters.bullet.build import build_world
from plumbline.adapters.bullet.knob_trade_offs import KNOB_TRADE_OFFS
from plumbline.adapters.bullet.options import VENDOR_STEP, checked, iterations_of, substeps_of
from plumbline.adapters.bullet.vendor import LIFTED, connected, pybullet_module
from plumbline.harness.adapter import Adapter, Emulation, Feature, Settings, Simulation, TradeOff, Unavailable
from plumbline.harness.adapter.mass_points import POINTS_AS_BODIES, built_with_points
from plumbline.harness.scene import Effect, Scene

if TYPE_CHECKING:
    from pathlib import Path

    from plumbline.harness.scene.parity.loaded import Loaded, Request

__all__ = ["ADAPTER"]


@dataclass(frozen=True, kw_only=True)
class BulletAdapter(Adapter):
    """Bullet through pybullet."""

    def version(self) -> str:
        """The installed version. Raises: Unavailable."""
        try:
            return importlib.metadata.version(self.distribution)
        except importlib.metadata.PackageNotFoundError as error:
            raise Unavailable("pybullet is not installed; it publishes wheels for Python 3.10 and 3.11 only") from error

    def load_robot(self, path: "Path", request: "Request") -> "Loaded":
        """What the package's own loader makes of a robot file. Raises: Unsupported, Unavailable."""
        from plumbline.adapters.bullet.robot_loader import load

        return load(path, request)

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """Exactly this scene in a private world. Raises: Unsupported, Unavailable, SettingsError."""
        options = checked(settings)

        def built(told: Scene) -> Simulation:
            taken = replace(
                settings,
                substeps=substeps_of(told, settings, options),
                iterations=iterations_of(told, settings, options),
            )
            port = connected(pybullet_module())
            try:
                return build_world(port, told, taken, options)
            except BaseException:
                port.call("disconnect")
                raise

        return built_with_points(built, scene)


_DAMPED = "vendor default: a multibody loses 0.04 (1 + |v|) v a second, linear and angular, also where the scene says 0"
_CLAMPED = "vendor default: a multibody's velocities are damped by 0.04 (1 + |v|) v and clamped to 100 m/s and 100 rad/s"
_PHASE = (
    "the rod passes the stop by what is left of its step, up to 0.02 rad at 1/240 s. The hidden damping of the default only "
    "moves that phase: with it tuned errs as the default does (.0023 for .0166 rad), without it the default as tuned; at "
    "1/120 and 1/480 s tuned is the better one"
)
_LEAD = (
    "a velocity that is differenced over a step tells of its middle, dt/2 late, as tuned shows to four digits; the hidden "
    "damping of the default runs ahead of the motion and hides up to two thirds of that, and without it the default errs as "
    "tuned does"
)
_FAR = (
    "without its hidden damping the default errs as tuned does a thousand kilometres away, 6.1e-9 for 2.3e-9 m at 1/240 s and "
    "3.9e-8 for 6.2e-9 m at 1/960 s"
)
_THICK = (
    "the vendor's collision margin holds a face 1 mm off the facets, and so hides most of the 1.7 mm that 320 of them lie "
    "within the ball; tuned leaves them where they are: its face is off them by .27 mm for .99 at 1/240 s"
)
_FROM_INSIDE = "Bullet casts a ray as a point swept against each shape and reports no hit of a shape that it starts in"
_GRAZING = (
    "Bullet's ray test (GJK convex cast) ends within a millimetre of the surface along its normal, whatever the settings: "
    "millimetres short at grazing incidence"
)
_CAUGHT = (
    "vendor default: a body that comes within the contact margin is braked to just touch, which takes up to all of its rebound"
)

ADAPTER = BulletAdapter(
    loaders=("", "URDF_USE_INERTIA_FROM_FILE"),
    loader_defaults={("", ".urdf"): {"inertia": "PyBullet Quickstart Guide, loadURDF, flags: URDF_USE_INERTIA_FROM_FILE"}},
    name="bullet",
    title="Bullet",
    distribution="pybullet",
    licence="Zlib",
    platforms=("linux-x86_64",),
    features=~(
        Feature.ELLIPSOID
        | Feature.DISTANCE
        | Feature.SPEED_LIMIT
        | Feature.TENDON
        | Feature.PAIR_FRICTION
        | Feature.STATIC_FRICTION
        | Feature.RAY_TRACING
        | Feature.SAVE
    ),
    tracks={
        "default": Settings(
            source="pybullet 3.2.7 as installed, but for the motors that it puts on every joint, which are off: on a hinge "
            "they bear up to 1 N m s a step, 240 N m at 1/240 s, and hold a pendulum of 1 kg level for a minute"
        ),
        "tuned": Settings(
            tolerance=1e-9,
            options={
                "coordinates": "scene",
                "iterations": "scene",
                "damping": "scene",
                "joints": "scene",
                "longest_step": VENDOR_STEP,
                "velocity_limit": LIFTED,
                "margin": 0.0,
                "restitution": "touching",
                "restitution_threshold": 0.01,
                "warm_starting": 0.85,
            },
            source=(
                "PyBullet Quickstart Guide, setPhysicsEngineParameter (numSolverIterations, solverResidualThreshold, "
                "restitutionVelocityThreshold, useSplitImpulse) and changeDynamics (damping, maxJointVelocity, "
                "contactProcessingThreshold, contactSlop), setTimeStep (best left at 240 Hz: iterations and ERPs are tuned to "
                "it), numSubSteps (longer steps), createConstraint (a fast top: 5.5 mm off, lost by a link; rotors alike). "
                "Warm starting by "
                "btContactSolverInfo's 0.85, of which pybullet leaves 0.1: a mass ratio of 1000 errs by 9 mm, not 100, and "
                "a stack rests with a sixth of the jitter. Coordinates by the scene, from measurements in pybullet 3.2.7: "
                "maximal ones have the implicit gyroscopic term, continuous collision and rebounds without contact ERP (e = 1 "
                "gives 1.000 at dt 1/240, 1e-3 and 2e-5, multibody 1.01-1.07), and rest more quietly for two thirds of the "
                "cost; multibody ones bound friction by a cone (a ball in a groove: 1.000 of mu N, maximal 1.414), which is "
                "right for faces along its two directions alone, and have rolling and torsional friction. Residual threshold "
                "1e-9, the square of a speed of 3e-5 m/s: the vendor's 1e-7 leaves 3e-4. Iterations by the mass ratio of free "
                "bodies: the sag of one cube on another depends on their share alone. Contact slop 1e-6 m/s times dt where "
                "bodies rebound, since a rebound loses slop/dt: with the vendor's 1e-5 m e = 1 gives 0.6 at 2e-5"
            ),
        ),
    },
    knobs={
        "substeps": (1, 2, 4, 8),
        "iterations": (5, 10, 50, 200, 1000),
        "solver": ("si", "dantzig", "pgs"),
        "tolerance": (1e-7, 1e-9, 0.0),
        "options.coordinates": ("multibody", "maximal", "scene"),
        "options.joints": ("links", "constraints", "scene"),
        "options.drives": ("torque", "motor"),
        "options.erp": (0.1, 0.2, 0.8),
        "options.contact_erp": (0.08, 0.2, 0.8),
        "options.contact_slop": (1e-4, 1e-5, 1e-6, 0.0),
        "options.contact_breaking": (0.001, 0.02),
        "options.warm_starting": (0.0, 0.1, 0.85),
    },
    acts_on={
        **dict.fromkeys(("iterations", "solver", "tolerance"), Effect.CONTACT | Effect.JOINTS),
        **dict.fromkeys(("options.contact_erp", "options.contact_slop", "options.contact_breaking"), Effect.CONTACT),
        **dict.fromkeys(("options.joints", "options.erp"), Effect.JOINTS),
        "options.warm_starting": Effect.CONTACT | Effect.JOINTS,
        "options.drives": Effect.DRIVES,
    },
    known_failures={
        "default/continuous_collision_stops_a_fast_ball": "bodies are multibodies by default, which Bullet cannot sweep",
        "default/hidden_damping_is_off": _DAMPED,
        "default/nothing_brakes_a_free_body": _DAMPED,
        "default/velocity_is_not_clamped": _CLAMPED,
        "default/sleeping_is_off": _DAMPED,
        "default/gyroscopic_term_is_present": _DAMPED,
        "default/restitution_of_a_pair": _CAUGHT,
        "default/mean_restitution_of_a_pair": _CAUGHT,
        "default/friction_has_its_size": _DAMPED,
        "default/frictionless_is_frictionless": _DAMPED,
        "default/rolling_is_free_without_rolling_friction": _DAMPED,
        "default/rolling_friction_brakes": _DAMPED,
        "default/torsional_friction_brakes": _DAMPED,
        "default/joint_pendulum_period": _DAMPED,
        "default/joint_damping_is_off": _DAMPED,
        "default/spring_frequency": _DAMPED,
        "default/armature_adds_inertia": _DAMPED,
        "default/armature_acts_between_bodies": _DAMPED,
        "default/dry_friction_brakes": _DAMPED,
        "default/coupled_coordinates_move_as_one": _DAMPED,
        "default/several_joints_move_one_body": _DAMPED,
        "default/distance_spring_has_its_frequency": _DAMPED,
        "default/distance_spring_pulls_where_it_is_tied": _DAMPED,
        "default/mass_point_flies_and_hangs": _DAMPED,
        "default/mass_point_counts_where_it_is_fixed": _DAMPED,
        "default/huge_state_is_not_reset": _CLAMPED,
        "default/rays_match_closed_forms": _GRAZING,
        "tuned/rays_match_closed_forms": _GRAZING,
        "default/ray_from_inside_meets_the_far_side": _FROM_INSIDE,
        "tuned/ray_from_inside_meets_the_far_side": _FROM_INSIDE,
    },
    trade_offs=(
        TradeOff(cases=("joint_limits",), at=("own step", "ladder"), why=_PHASE),
        TradeOff(cases=("sensor_imu_lag",), at=("own step", "ladder"), why=_LEAD),
        TradeOff(
            cases=("stack_heavy_on_two",),
            why=(
                "how two bodies share a load is left open by statics, and settled by the phase of the landing: tuned .003 to "
                ".030 over the ladder in no order, default .004 to .20; the geometric mean of the ratio is .90"
            ),
        ),
        TradeOff(cases=("system_level_of_detail",), at=("own step", "ladder"), why=_THICK),
        TradeOff(cases=("system_far_origin",), at=("own step", "ladder"), why=_FAR),
        *KNOB_TRADE_OFFS,
    ),
    orders={"semi_implicit_euler": 1},
    emulated=(
        Emulation(
            feature=Feature.MASS_POINT,
            how=POINTS_AS_BODIES,
        ),
        Emulation(
            feature=Feature.SPRINGS,
            how="pybullet's PD_CONTROL holds the force of a step's start over it and blows up where that is long; the adapter works "
            "out a torque for each (sub)step",
        ),
        Emulation(
            feature=Feature.DRIVES,
            how="Bullet's position motor is a velocity constraint without a stiffness in N m/rad, its PD_CONTROL the torque of a "
            "step's start, held over it; the adapter works out a torque for each (sub)step",
        ),
        Emulation(
            feature=Feature.ARMATURE,
            how="pybullet's multibody has no inertia along a joint coordinate; the adapter works out a torque for each "
            "(sub)step, with the accelerations by all else of the one before, until a contact or a stop strikes the tree, "
            "which ends the run",
        ),
        Emulation(
            feature=Feature.DISTANCE_SPRING,
            how="pybullet has no spring between points of two bodies; the adapter works out a pair of forces for each "
            "(sub)step",
        ),
        Emulation(
            feature=Feature.KINEMATIC,
            how="pybullet has no kinematic body; it is one of 1e12 times the greatest mass, told its velocity each (sub)step",
        ),
        Emulation(
            feature=Feature.CLOSED_LOOP,
            how="pybullet closes loops by points and fixed frames; a revolute joint is two points of its axis, each held",
            where="where a revolute joint closes the loop",
        ),
    ),
    laws=(
        "plumbline.adapters.bullet.drives:Actuation.efforts",
        "plumbline.adapters.bullet.simulation:BulletSimulation._drive",
        "plumbline.adapters.bullet.simulation:BulletSimulation._sprung",
        "plumbline.adapters.bullet.kinematic_bodies:Belt.push",
    ),
    deviations=(
        "the motors that pybullet puts on every joint are off on both tracks; they bear up to 1 N m s a step on a hinge, 240 "
        "N m at 1/240 s, and hold a pendulum of 1 kg level for a minute",
        "springs and drives are torques of the adapter, held over each (sub)step; linearly implicit wherever those of its "
        "start could reverse a velocity within it, with the feet held that bore a force in the step before, and bounded for "
        "the case that these give way",
        "springs between points of two bodies are forces of the adapter, too stiff ones linearly implicit along the line; "
        "across it stable while h^2 f/(m l) < 4, with f the tension and l the length",
        "a fast rotor on a driven, sprung or limited hinge is a link, whose wobble at W grows by e^(W^2 h/2) a second in steps "
        "of h; other hinges of fast rotors are constraints on tuned, which take energy of a rotor that is uneven across it",
        "kinematic bodies are bodies of 1e12 times the greatest mass whose velocity is prescribed anew in each (sub)step",
        "contact forces are the mean over the sub-steps; friction may be left on a point that bears nothing",
        "rays and images are taken in a second world of the same shapes at the present poses; grazing rays miss by millimetres",
        "in images round shapes are hulls of 42 of their points; colours have 8 bits, and TinyRenderer's shadows are off",
        "a ray that starts inside a solid meets nothing of that solid",
        "a turn of t > pi/4 in one (sub)step becomes 2 atan(4 t/pi tan(pi/8)), 1.38 for pi/2; the angular velocity stays",
        "hulls in compounds and on links are 1 mm thicker (collision margin); in compounds they have single precision",
        "rebounds of multibodies (joints, rolling friction) gain up to 8 % of the speed of impact (contact ERP)",
        "bodies with faces meet a box in place of a static plane, which ends a kilometre beyond all that moves at the start",
        "friction of a point in maximal coordinates, which tuned keeps for what rebounds, turns fast, is swept or damped, "
        "stands level and still, or has faces that slide askew to Bullet's directions, goes up to sqrt(2) mu N and askew to "
        "the slip",
        "in multibody coordinates, the default's, faces that slide askew to Bullet's two directions at a normal, by 45 "
        "degrees, are braked by 7 % less than mu N and go off their way",
        "what slides on contacts that are found one point a step (hulls, and cylinders on boxes) goes 1.02-1.10 of its way",
        "static and kinetic friction are one; friction, restitution and their like are products of two numbers",
    ),
)
