"""The reference engine of this repository (`engine/`): Runge-Kutta or semi-implicit Euler, direct joints, soft sub-stepped
contact.

Sources:
    E. Catto, *Solver2D*, 2024 (sub-stepped soft contact: four sub-steps, contact stiffness a quarter of the sub-step's rate,
    relaxing sweeps); Hairer, Lubich, Wanner, *Geometric Numerical Integration*, chapters IV and VII (projection, SHAKE).

Deviations:
    * Contacts are springs with a frequency of at most a quarter of the sub-step's rate, so resting bodies sink in by
      micrometres. Under links in joint coordinates, on what stands still, they are a hundred times as
      stiff, unless 'contact_hertz' asks for less.
    * Under uneven steps (`retime`) contacts are softer in steps longer than dt, and as stiff as under dt in shorter ones. Where
      bodies sleep, uneven steps are `Unsupported`.
    * Approaches slower than four times what gravity gives in one sub-step do not bounce.
    * Without the effect `continuous_collision`, contacts are made ahead of time up to half the thickness of the thinner shape.
      With it they are made for the way of the whole step unless the option 'continuous' is 'swept': that costs least and knows
      joints and every solver, but a body that just misses another may be turned aside by a contact that never comes about.
    * Swept, the world stops at each impact of a step. Beside joints, and with the solver 'exact', `build` raises `Unsupported`.
    * Bodies that nothing touches in a step follow the integrator; touched ones follow semi-implicit Euler in sub-steps.
    * The integrators of free bodies (all but semi-implicit Euler and Runge-Kutta) build no scene with contacts, and of joints
      implicit midpoint and Dormand-Prince trees alone.
    * With dry friction in a joint the track 'tuned' takes semi-implicit Euler in its sub-steps, as it does with contacts.
    * A spring or drive too stiff for the explicit stages of Runge-Kutta is taken implicitly, which adds numerical damping.
    * Limits stop without a rebound. A joint holds no body whose principal moments of inertia differ by more than 1e10, as of a
      rod a metre long and 4 micrometres thick: `build` raises `Unsupported`.
    * A triangle mesh is a one-sided surface: it stops what comes from its outer side, and one that lies whole within a solid is
      not pushed out. One that forces move must be closed, and its collision is not swept: else it is `Unsupported`.
      With the option 'level_of_detail' a mesh collides, and meets rays, as its sphere, box, hull or convex pieces; an
      open mesh has none, and decomposition needs CoACD: both are `Unsupported`.
    * Trees of joints are solved in joint coordinates on both tracks, those in contact unless more bodies are loose than
      they have links. Semi-implicit Euler moves trees that nothing touches as it does bodies with coordinates of their own,
      but for 1e-8 of the way of a sub-step unless 'step_tolerance' asks for less. With contacts the soft solver and
      semi-implicit Euler alone know them, and both tracks take these, in one sub-step unless masses are unlike or the
      settings say how many. With loops the option 'coordinates' as 'joint' takes them, and 'automatic' leaves them in the
      bodies' own. A joint that closes a loop has no law there: limits, springs, drives, rotors and friction of its own are
      `Unsupported`. Coupled joints, and bodies without mass, are taken in joint coordinates or not at all; so are springs
      between two points beside these, and loops that they are part of: `Unsupported`.
    * Against a face, a cylinder's cap is a polygon of 16 corners on its rim.
    * Bodies already in touch take a blow as one: of five touching balls hit by one, the four move on together. So do bodies
      whose gap closes in the same sub-step. The solver 'exact' goes from blow to blow, but not to pairs that were too far apart
      when its step began. Of 160 pairs of balls that fall 1 m (masses 1 : 1 to 1000 : 1, e = 0.3 to 1, 0.1 to 6 mm apart, a
      step's way being 4.4 mm at dt = 1e-3) the soft solver in four sub-steps has 106 right, in eight 126, exact contacts 136,
      with Runge-Kutta 145, sequential impulses 59; exact contacts have all those right whose masses are 10 : 1 or more unlike.
    * More than three contacts of one body leave open how they share its load. The soft solver shares it evenly where a body
      stands on what does not move, with one normal, outside of worlds solved island by island; elsewhere the order of bodies
      decides, unless the option 'sweeps' is 'jacobi'.
    * Boxes tumbling on a plane without friction at e = 1 gain energy in proportion to dt: 0.2 % in 0.5 s at dt = 1e-3.
    * Restitution is Newton's, of normal velocities: u_after = -e u_before. Where friction acts off the centre of mass, that law
      itself can give energy (Kane and Levinson, *Dynamics*, 1985; Stronge, *Impact Mechanics*, 2000): of 300 blows of a
      tumbling box on a plane at e = 1 and mu = 0.3, 13 % gained some, at most 27 %; at e = 0.5 none did. With the solver
      'exact' points that strike together take the largest common share of their e at which they gain nothing; `warnings` counts
      such blows.
    * With the solver 'exact' contacts are hard: Coulomb's law is solved once per sub-step (one, unless set), and
      `warnings` and `resolved` name the largest residual. Depths are kept from growing, not worked off. A solve that misses its
      tolerance within the option 'effort' (50 ms, counted in matrices) is answered by the best that was found, and counted.
      Joints are held beside contacts, in the bodies' own coordinates, with springs, drives, rotors and stops; dry friction,
      limits of speed and limited drives in joints, static above kinetic friction, and rolling and torsional friction are not
      known: `build` raises `Unsupported`.
    * The solver 'sequential_impulses' (one sub-step of ten sweeps, unless set) works depths off apart from the velocities.
      Beside joints `build` raises `Unsupported`.
    * Rasterised pictures have neither shadows nor mirrors nor glass: what does not scatter shows the sky. In ray-traced ones
      all bodies, clear ones too, keep the sun off what lies behind them, and the whole sky lights every surface.
    * On the track 'tuned' the scene decides ('suited', see `suited`): contacts are exact where few bodies of unlike masses
      have weight or springs would give way under them (four to eight times the cost of a soft step), sequential impulses where
      bodies start inside each other.
    * Sub-steps find no contacts, and Runge-Kutta takes dt whole where nothing touches. With the option 'steps' so many of them
      are steps of their own; 'tuned' asks for it where a body turns far in dt, or without continuous collision goes far. Where
      trees of joints turn farther than a radian in each of these, it takes implicit midpoint.
"""

from dataclasses import dataclass

from plumbline.adapters.reference.advantages import ADVANTAGES
from plumbline.adapters.reference.build import build, build_batch, compile_for
from plumbline.adapters.reference.kernels import kernels
from plumbline.adapters.reference.knob_trade_offs import KNOB_TRADE_OFFS
from plumbline.adapters.reference.options import EXACT, SEQUENTIAL, SOFT, SUITED
from plumbline.adapters.reference.vendor import engine_version
from plumbline.harness.adapter import Adapter, Feature, Settings, Simulation, TradeOff
from plumbline.harness.adapter.many_worlds import Batch
from plumbline.harness.adapter.mass_points import built_with_points, with_inertia
from plumbline.harness.scene import Effect, Scene

__all__ = ["ADAPTER"]


@dataclass(frozen=True, kw_only=True)
class ReferenceAdapter(Adapter):
    """The reference engine."""

    def version(self) -> str:
        """Version and digest of the engine's sources. Raises: Unavailable."""
        return engine_version()

    def compile(self, scene: Scene, settings: Settings) -> None:
        """Compile what the scene's steps, rays and pictures need. Raises: as `build`."""
        compile_for(scene, settings)

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """Exactly this scene under these settings. Raises: Unsupported, SettingsError."""
        return built_with_points(lambda told: build(told, settings), scene)

    def build_batch(self, scene: Scene, settings: Settings, count: int) -> Batch:
        """Worlds in one array where the engine knows them so, else one after the other. Raises: Unsupported, SettingsError."""
        batch = build_batch(with_inertia(scene), settings, count)
        return super().build_batch(scene, settings, count) if batch is None else batch


_ROUNDED = (
    "a position a thousand kilometres away is rounded in each sub-step, and tuned takes eight for the default's four: 7.8e-8 "
    "for 4.4e-8 m at 1/240 s"
)


F = Feature
ADAPTER = ReferenceAdapter(
    name="reference",
    title="Plumbline reference engine",
    distribution="plumbline",
    licence="Apache-2.0",
    platforms=("linux-x86_64", "linux-aarch64", "macos-arm64", "windows-x86_64"),
    features=F.SPHERE | F.BOX | F.CAPSULE | F.CYLINDER | F.ELLIPSOID | F.PLANE | F.CONVEX_HULL | F.TRIANGLE_MESH
    | F.MOVING_MESH | F.COMPOUND | F.FULL_INERTIA | F.KINEMATIC | F.PRESCRIBED_MOTION | F.MASS_POINT | F.MASSLESS | F.FIXED
    | F.BALL
    | F.REVOLUTE | F.PRISMATIC
    | F.DISTANCE | F.DISTANCE_SPRING | F.CLOSED_LOOP | F.LIMITS | F.SPRINGS | F.DRIVES | F.FEEDFORWARD
    | F.ARMATURE | F.FRICTION_LOSS | F.SPEED_LIMIT | F.COUPLING | F.TENDON
    | F.PAIR_FRICTION | F.STATIC_FRICTION | F.ROLLING_FRICTION | F.TORSIONAL_FRICTION
    | F.RESTITUTION | F.LINEAR_DAMPING | F.ANGULAR_DAMPING | F.CONTINUOUS_COLLISION | F.CONTACTS | F.CONTACT_FORCES | F.RAYS
    | F.RENDER | F.RAY_TRACING | F.WRENCH | F.SAVE | F.NATIVE_STEPS | F.STEP_LENGTHS,
    tracks={
        "default": Settings(
            integrator="semi_implicit_euler",
            source="Catto, Solver2D, 2024: semi-implicit Euler in four sub-steps of two sweeps; in one of four where trees of "
            "joints touch something, whose contacts are answered whole in a sub-step of any length (Featherstone, Rigid Body "
            "Dynamics Algorithms, 2008, chapter 11): a humanoid stands with a smaller error in a third of the time",
        ),
        "tuned": Settings(
            substeps=8,
            iterations=2,
            integrator="rk4",
            solver=SUITED,
            options={"coordinates": "automatic"},
            source="Hairer, Norsett, Wanner I, section II.1 (order four for smooth motion); Catto, Solver2D, 2024 (more "
            "sub-steps rather than more iterations); exact contacts where few bodies of unlike masses, or too many for soft "
            "springs, stand on each other, "
            "split impulses (Catto, GDC 2006) where bodies start inside each other; joint coordinates for trees of joints "
            "(Featherstone, Rigid Body Dynamics Algorithms, 2008)",
        ),
    },
    knobs={
        "solver": (EXACT, SEQUENTIAL, SOFT),
        "substeps": (1, 2, 4, 8, 16),
        "iterations": (1, 2, 4, 8),
        "integrator": (
            "semi_implicit_euler", "rk4", "explicit_euler", "velocity_verlet", "implicit_midpoint", "splitting_4",
            "splitting_8", "dormand_prince",
        ),
        "options.continuous": ("speculative", "swept"),
        "options.coordinates": ("maximal", "automatic"),
        "options.contact_hertz": (60.0, 120.0, 240.0, 480.0, 960.0),
    },
    acts_on={
        **dict.fromkeys(("solver", "iterations", "options.contact_hertz"), Effect.CONTACT),
        "options.continuous": Effect.CONTINUOUS_COLLISION,
        "options.coordinates": Effect.JOINTS,
    },
    trade_offs=(
        TradeOff(cases=("joint_long_run",), at=("ladder",), why=(
            "Runge-Kutta loses a share of z^5/144 of an amplitude a radian, z being the phase of a step; SHAKE is symplectic: "
            "at 1/20 s 9.5e-6 against 1.4e-9, the bound being 3.8e-4; at 1/120 s Runge-Kutta errs less"
        )),
        TradeOff(cases=("system_far_origin",), at=("own step", "ladder"), why=_ROUNDED),
        *KNOB_TRADE_OFFS,
    ),
    threads=(2, 4),
    known_failures={
        f"{track}/pair_distance_spring_and_second_joint_of_a_body": (
            "bodies without mass are in joint coordinates alone, of which springs between two points are no law: `Unsupported`"
        )
        for track in ("default", "tuned")
    },
    deviations=(
        "Contacts are springs of at most a quarter of the sub-step's rate; resting bodies sink in by micrometres.",
        "Approaches slower than four times what gravity gives in one sub-step do not bounce.",
        "Gaps that close in the same sub-step are one blow; the solver 'exact' takes nearly all blows in their order.",
        "Among moving bodies, and with unlike normals, the order of bodies decides how redundant contacts share a load.",
        "Boxes that tumble at e = 1 without friction gain energy in proportion to the step: 0.2 % in 0.5 s at 1e-3.",
        "Restitution is Newton's law, which off the centre of mass gives energy with friction: at e = 1 up to a quarter; the "
        "solver 'exact' then takes less of it.",
        "A body that just misses another may be turned aside by speculative contacts, unless collision is swept.",
        "A triangle mesh is a one-sided surface; one that forces move must be closed, and its collision is not swept.",
        "Against a face, a cylinder's cap is a polygon of 16 corners on its rim.",
        "Ray-traced pictures: clear bodies cast the shadows of dark ones, and nothing keeps the light of the sky off.",
    ),
    advantages=ADVANTAGES,
    orders={
        "explicit_euler": 1, "semi_implicit_euler": 1, "velocity_verlet": 2, "implicit_midpoint": 2, "rk4": 4, "splitting_4": 4,
        "splitting_8": 8,
    },
    compile_allowance=900.0,
    kernels=kernels,
    loads=("plumbline.engine.steps.smooth", "plumbline.engine.steps.contact", "plumbline.engine.compile.prepared"),
)  # fmt: skip
