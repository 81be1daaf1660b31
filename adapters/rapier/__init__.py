"""Rapier through its official Python binding rapier3d: rigid bodies in single precision, contacts as stiff springs.

Tried with rapier3d 0.36.1 (Python 3.11, Linux x86-64).

Sources:
    rapier.rs, user guide, *Python*: `joint_constraints` (reduced coordinates for robots); the docstrings of the binding and of
    `IntegrationParameters` (iterations, softness, prediction); the Rust sources of 0.35.2.

A step is `num_solver_iterations` sub-steps of semi-implicit Euler (`substeps`, 4 by default) with `num_internal_pgs_iterations`
sweeps each (`iterations`, 1). A contact is a spring of a natural frequency: 30 Hz between bodies, 60 Hz against what stands
still, whatever the step, with a damping ratio of 10, so that ten boxes sag by 25 mm. On 'tuned' it is an eighth of the rate
of sub-steps ('contact_rate'), a quarter beside drives, at a ratio of 1: at a quarter an arch of hulls trembles, at half boxes
jitter and fly apart, and at a ratio of 10 a column trembles if friction is solved in the biased pass too, without which boxes
creep. The vendor has no such advice. A step is three of the vendor's there ('detect_every'): points of a contact turn with a
ball until its end, when rebounds come too. The law of each pair of materials stands on the colliders where all pairs have one;
elsewhere a hook of the solver sets it (0.6 us a touching pair and step).

Deviations:
    * Everything is single precision. What spins freely under gyroscopic forces gains some 2e-7 of its energy in each sub-step
      by rounding: below steps of 1/300 s the error of a free top grows as the step shrinks. A body whose moments are alike
      needs none of them, is told none, and keeps its spin.
    * Speeds beyond 1e18 are refused by the first step.
    * Friction has one coefficient. 'simplified', the default, is a cone; 'coulomb' is a box that errs by 15 % along the axes of
      a box of 0.2 m and by 8 % between them. 'simplified' brakes the spin of a face too; that of a ball, and rolling, never.
    * Of a contact's force 'simplified' tells the normal part alone, 'coulomb' two numbers along directions that it does not
      tell: forces of contacts are not claimed, and nothing is judged by them. Points are of the start of the vendor's last
      step, means over its sub-steps.
    * Contacts of links have the friction of 'coulomb', whatever is told: on a floor that a multibody hangs on, a turned box
      slides up to 12 % further, and aside. What stands still is no link here: another body without shapes bears it.
    * Joints between free bodies ('joints': 'impulse', the default) are constraints of 1e6 Hz: a pendulum of 60 degrees loses
      1.8 % of m g l in 10 s at 4 sub-steps of 1/960 s. A chain of ten opens by 1.6 mm. 'multibody', on 'tuned', has trees of
      hinges, slides and fixed joints in reduced coordinates (0.2 %). Balls, what is damped or prescribed, what closes loops,
      and velocities that joints do not allow stay with constraints: a hinge that closes a loop of hinges stops multibodies
      dead, a ball takes 13 % of the energy in a second, a point of the plane stops them where cranks and coupler lie in a
      line. Rotors are of reduced coordinates alone, which trees with one take on 'default' too.
    * A sub-step of 'default' sweeps once over all: motors along a chain of impulse joints do not carry the load that they
      should (a quadruped is 43 mm off after half a second, 4.8 at 16 sweeps, 5.2 in reduced coordinates), feet sink by 2.2 mm
      on contacts of 60 Hz, and creep, since friction is not solved in the pass that corrects positions ('friction_in_bias').
    * An angle of a joint that is a constraint is counted modulo a turn, and who passes a stop by more than lies between both
      is pulled to the other: trees with one limit or limits less than .25 rad short of a turn apart, with springs and
      drives half a turn from the start, or with bodies without mass are in reduced coordinates on 'default' too, or refused.
    * A joint has one motor: springs, drives and dry friction beside each other are motors of joints that hold nothing. Their
      law k (x0 - x) + c (u - x') is taken at the end of each sub-step; dry friction is a motor towards rest, cut off.
    * A rod is a spring of 1e9 N/m. A distance is bounded from above alone.
    * Damping of bodies is v' = v/(1 + c dt) over a whole step.
    * Rays meet cylinders by an iteration that stops 0.5 mm off, 10 mm at a graze, and rays that pass their rims by up to some
      5 mm too. Inside of a mesh they meet the next face.
    * Kinematic bodies go h v in each sub-step, rounded: 31 um are lost on 0.5 m at 12 sub-steps of 1/12 ms, and 3.5 mm nine
      metres from the origin. On 'tuned' they are put back on their path before each step ('on_path').
    * Continuous collision is automatic against what stands still, and told for other bodies where the scene calls for it; on
      'tuned' contacts are foreseen as far as a body moves in a step, without which 500 m/s pass a wall of 1 cm.
    * Sleep, cuts of speed and turn, recycled and clustered contacts, and inner edges of meshes that push are the vendor's
      defaults, off on 'tuned': recycling lets balls that pass at 4 mm kick each other by 0.3 m/s; clustering leaves no force on
      the points of meshes and compounds.
"""

import importlib.metadata
from dataclasses import dataclass

from plumbline.adapters.rapier.build import build
from plumbline.adapters.rapier.options import FRICTION, INTEGRATOR, JOINTS
from plumbline.adapters.rapier.vendor import load
from plumbline.harness.adapter import Adapter, Emulation, Extra, Feature, Settings, Simulation, TradeOff
from plumbline.harness.adapter.mass_points import POINTS_AS_BODIES, built_with_points
from plumbline.harness.scene import Effect, Scene

__all__ = ["ADAPTER"]


@dataclass(frozen=True, kw_only=True)
class RapierAdapter(Adapter):
    """Rapier through rapier3d."""

    def version(self) -> str:
        """The installed version of rapier3d. Raises: Unavailable."""
        load()
        return importlib.metadata.version("rapier3d")

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """Exactly this scene under these settings. Raises: Unsupported, Unavailable, SettingsError."""
        return built_with_points(lambda turned: build(load(), turned, settings), scene)


_SLEPT = "what creeps slower than 0.1 m/s is put to sleep on its way"
_RAYS = (
    "rays meet cylinders by an iteration (GJK) that stops 0.5 mm off, normals by 0.014 rad; planes 0.06 mm off, at a graze and "
    "within 50 m, by single precision"
)

ADAPTER = RapierAdapter(
    name="rapier",
    title="Rapier",
    distribution="rapier3d",
    licence="Apache-2.0",
    platforms=("linux-x86_64", "linux-aarch64", "macos-arm64", "windows-x86_64"),
    extra=Extra(megabytes=20, seconds=2),
    single_precision=True,
    features=(
        Feature.SPHERE
        | Feature.BOX
        | Feature.CAPSULE
        | Feature.CYLINDER
        | Feature.PLANE
        | Feature.CONVEX_HULL
        | Feature.TRIANGLE_MESH
        | Feature.MOVING_MESH
        | Feature.COMPOUND
        | Feature.FULL_INERTIA
        | Feature.KINEMATIC
        | Feature.PRESCRIBED_MOTION
        | Feature.MASS_POINT
        | Feature.MASSLESS
        | Feature.FIXED
        | Feature.BALL
        | Feature.REVOLUTE
        | Feature.PRISMATIC
        | Feature.DISTANCE
        | Feature.DISTANCE_SPRING
        | Feature.CLOSED_LOOP
        | Feature.LIMITS
        | Feature.SPRINGS
        | Feature.DRIVES
        | Feature.ARMATURE
        | Feature.FRICTION_LOSS
        | Feature.FEEDFORWARD
        | Feature.PAIR_FRICTION
        | Feature.RESTITUTION
        | Feature.LINEAR_DAMPING
        | Feature.ANGULAR_DAMPING
        | Feature.CONTINUOUS_COLLISION
        | Feature.CONTACTS
        | Feature.RAYS
        | Feature.WRENCH
        | Feature.SAVE
        | Feature.STEP_LENGTHS
    ),
    tracks={
        "default": Settings(source="rapier3d 0.36.1 as it comes: 4 iterations, each a sub-step; sleeping on"),
        "tuned": Settings(
            options={
                "sleeping": False,
                "contact_damping_ratio": 1.0,
                "friction_in_bias": True,
                "detect_every": 4,
                "prediction": 0.002,
                "recycling": False,
                "clustering": False,
                "capped": False,
                "soft_ccd": True,
                "inner_edges": False,
                "joints": "multibody",
                "on_path": True,
                "by_scene": True,
            },
            source="12 iterations where something is solved: IntegrationParameters, '8-12: demanding scenarios, stacks, "
            "complex machinery', in steps of four, which its dt calls more accurate; prediction of 2 mm: the default that "
            "its documentation tells; reduced coordinates for robots: user guide, joint_constraints; inner edges: "
            "TriMeshFlags; frequency and damping of contacts, friction in the biased pass, recycling and clustering: our own "
            "measurements, no advice of the vendor",
        ),
    },
    known_failures={
        "default/fast_spin_is_not_cut": "turns are cut at 45 degrees a step, unless a body is told allow_fast_rotation",
        "default/huge_state_is_not_reset": "speeds are cut at 400 m/s (normalized_max_linear_velocity)",
        "default/sleeping_is_off": "bodies slower than 0.1 m/s and 0.5 rad/s sleep after half a second, also without contact",
        "default/target_velocity_acts": _SLEPT,
        "default/dry_friction_holds": _SLEPT,
        "default/dry_friction_beside_a_drive": _SLEPT,
        "default/near_miss_leaves_no_trace": "contact_recycling keeps contacts as they were over 5 cm of motion",
        "default/joint_damping_is_off": "impulse joints take 1.4 % of a pendulum's energy in 3 s at 4 sub-steps of 1/960 s",
        **{f"{track}/rays_match_closed_forms": _RAYS for track in ("default", "tuned")},
        **{f"{track}/ray_from_inside_meets_the_far_side": _RAYS for track in ("default", "tuned")},
        # A ball, a spring between points or a led body bars the whole tree that hangs together from reduced coordinates.
        **{
            f"{track}/{pair}": "Rapier's links without mass are of reduced coordinates: not beside a ball, spring or led body"
            for track in ("default", "tuned")
            for pair in (
                "pair_ball_and_second_joint_of_a_body",
                "pair_distance_spring_and_second_joint_of_a_body",
                "pair_second_joint_of_a_body_and_prescribed_body",
            )
        },
    },
    knobs={
        "substeps": (1, 4, 8, 12, 16),
        "iterations": (1, 2, 4, 8),
        "options.friction_model": FRICTION,
        "options.friction_in_bias": (True, False),
        "options.contact_rate": (0.0625, 0.125, 0.25),
        "options.contact_damping_ratio": (1.0, 10.0),
        "options.detect_every": (0, 4),
        "options.prediction": (0.002, 0.02),
        "options.sleeping": (True, False),
        "options.joints": JOINTS,
    },
    acts_on={
        **dict.fromkeys(("options.friction_model", "options.friction_in_bias"), Effect.FRICTION),
        **dict.fromkeys(
            tuple(f"options.{name}" for name in ("contact_rate", "contact_damping_ratio", "detect_every", "prediction")),
            Effect.CONTACT,
        ),
        "options.joints": Effect.JOINTS,
    },
    trade_offs=(
        TradeOff(
            cases=("rest_jitter",),
            at=("own step", "ladder"),
            why="bodies that sleep do not tremble: 0 against 1.5e-5 m/s of a column of five, the bound being 3.4e-5; but "
            "whatever is slower than .1 m/s is put to sleep on its way",
        ),
        TradeOff(
            cases=("impact_gas",),
            at=("own step",),
            why="which impacts come to pass is chance: at the case's own seed the energy grows by 2.4e-3 of itself a second "
            "against 4.8e-5, over eight seeds by 2.8e-3 against 1.0e-2",
        ),
        TradeOff(
            cases=("system_invariance",),
            at=("own step", "ladder"),
            why="roundings of single precision in a second, 5.7e-5 m against 4.2e-5; 3.8e-5 to 7.8e-5 under seven other "
            "frequencies and damping ratios of contacts",
        ),
        TradeOff(
            cases=("friction_isotropy",),
            at=("ladder",),
            why="each of 12 sub-steps rounds where 4 are taken: at 1/1920 s how far a box slides differs by 2.5e-4 of itself "
            "between directions against 1.7e-5, at 1/240 s by 1.5e-5 on both",
        ),
        TradeOff(
            cases=("stack_overhang",),
            at=("ladder",),
            why="stacks near their limit rock on critically damped springs: it is off by 1.8 to 7.5 % at 1/60, 1/960 and "
            "1/1920 s, by none at three other steps; at a damping ratio of 4 by none, but an arch of hulls and a column "
            "tremble at 4.7e-3 and 6.8e-5 m/s for bounds of 3.4e-3 and 3.4e-5",
        ),
        TradeOff(
            cases=("stack_overlap_recovery",),
            at=("ladder",),
            why="stiff contacts open an overlap of a quarter within some steps, at up to 1 m/s; corrected at .1 m/s at most it "
            "opens quietly, but then contacts bear no more than that speed's share of a sub-step's fall, and 100 kg sink "
            "143 mm into a kilogram for .4",
        ),
    ),
    loads=("rapier3d",),
    orders={INTEGRATOR: 1},
    staggered=("tuned",),
    deviations=(
        "single precision: gyroscopic forces give a free top 2e-7 of its energy in each sub-step",
        "of the force of a contact 'simplified' friction tells the normal part alone, 'coulomb' two numbers along directions "
        "that it does not tell, so none is judged",
        "contacts are springs: ten boxes sag by 25 mm on 'default', by less than 0.1 mm on 'tuned' at 1/240 s",
    ),
    emulated=(
        Emulation(feature=Feature.MASS_POINT, how=POINTS_AS_BODIES),
        Emulation(feature=Feature.FRICTION_LOSS, how="a motor towards rest, cut off at the bound, stands for dry friction"),
        Emulation(feature=Feature.DISTANCE, how="a spring of 1e9 N/m stands for a rod", where="where no limits are told"),
    ),
)
