"""PhysX 5 on the CPU through SAPIEN 3: rigid bodies and articulations in single precision, contacts by TGS or PGS.

Tried with sapien 3.0.3 (PhysX 5.3.1; Python 3.11, Linux x86-64).

Sources:
    SAPIEN 3, `wrapper/articulation_builder.py` and the stubs of `sapien.physx`; NVIDIA, PhysX 5 guide, *Rigid Body Dynamics*
    (TGS, iterations, bounce threshold) and *Articulations*, and API reference (`PxSolverType`, `PxRigidBody`); Macklin et al.,
    *Small Steps in Physics Simulation*, SCA 2019.

Trees of hinges, slides and fixed joints are articulations, as SAPIEN's own loader has them; each that hangs on the world, or on
a body that stands still, has a root of its own without shapes. Balls, rods, what closes loops, and what is damped or prescribed
are constraints between bodies. What SAPIEN sets for the process (gravity, solver, iterations, offsets) is told again before
each world.

Deviations:
    * Everything is single precision. Under TGS each step gives a spin 5e-7 of itself, even that of a ball: 5.5e-4 in 4 s at
      1/240 s, four times as much at 1 ms; under PGS it does not.
    * Of the force of a contact SAPIEN tells the normal part alone: forces of contacts are not claimed, and nothing is judged by
      them. Points are of the last sub-step.
    * A pair of materials has the mean of two numbers; laws that no numbers give are refused, and so is static friction above
      kinetic: between .4 and .6 PhysX holds a box at a slope of .45 and lets it slide at .5.
    * Torsional friction is that of a patch of contact: its radius, the larger of two, times mu N; under TGS, which 'tuned'
      takes there. PGS knows none.
    * A cylinder is a prism of 32 sides whose edges lie on it: faces lie 0.48 % of the radius within, and rays meet those.
    * Nothing rebounds below the bounce threshold, 2 m/s by default, 1 mm/s on 'tuned'. What is turned before it touches meets
      no friction: contacts begin at 10 mm, on 'tuned' at a micrometre where things rebound without gravity.
    * A ray that starts within a solid meets it where it starts. The point of a contact lies on one of the two surfaces, by the
      shapes that meet: half the gap off.
    * The limits of swing of SAPIEN's constraints do nothing: hinges, slides and welds that are constraints are held at a second
      point, a metre along their axis. Under PGS velocities fit the poses at the start of the sub-step, and joints take the
      turning of a body that is led for nought: 'tuned' takes TGS for constraints, and PGS that is told is refused for these.
    * Continuous collision is switched on for a scene and for none of its bodies: scenes that call for it run without.
    * Under TGS drives of constraints exceed their law, by 5 % at 10 iterations and 1 % at 50, and under both solvers they take
      the limit of a force for that of an impulse: springs and drives are
      made in articulations alone, and refused on balls and in loops. A joint has one drive: a spring beside a drive with a
      limit is refused. A spring between points of two bodies lags under PGS by 9 mm of 0.2 m at 1 ms, so the adapter works out
      its forces, those of the start of each sub-step, or of its end where a pose could let them reverse a velocity
      (`harness.adapter.distance_springs`).
    * The friction of PhysX's joints grows with what they bear: a drive towards rest, cut off at the bound, stands for dry
      friction. Joined bodies do not touch. A stop of a constraint beyond half a turn holds nothing, and is refused.
    * Sub-steps are steps of dt/substeps, forces from outside held over each.
    * A hull has 255 corners at most. Meshes that move collide with all but planes, for which a box stands where there are any,
      and other meshes, which are refused.
    * SAPIEN packs poses and velocities, by which the state is read, without what its solver starts from: nothing is saved.
      Pictures need Vulkan.
    * Gyroscopic terms cannot be switched off. On 'default' bodies lose 0.05 of their spin a second, and links of their speed
      too, turns are cut at 100 rad/s (links 50, and 10 m/s), and what moves by 2 mm/s or less for 0.4 s sleeps, in mid air too.
"""

import importlib.metadata
from dataclasses import dataclass

from plumbline.adapters.sapien.build import build
from plumbline.adapters.sapien.options import INTEGRATOR, SOLVERS, UNBOUNDED
from plumbline.adapters.sapien.vendor import load
from plumbline.harness.adapter import Adapter, Emulation, Extra, Feature, Settings, Simulation, TradeOff
from plumbline.harness.adapter.mass_points import POINTS_AS_BODIES, built_with_points
from plumbline.harness.scene import Effect, Scene

__all__ = ["ADAPTER"]


@dataclass(frozen=True, kw_only=True)
class SapienAdapter(Adapter):
    """PhysX through SAPIEN."""

    def version(self) -> str:
        """The installed version of SAPIEN. Raises: Unavailable."""
        load()
        return importlib.metadata.version("sapien")

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """Exactly this scene under these settings. Raises: Unsupported, Unavailable, SettingsError."""
        return built_with_points(lambda turned: build(load(), turned, settings), scene)


_RAYS = "cylinders are prisms of 32 sides; planes 0.05 mm off, at a graze and within 50 m, by single precision"
_POINTS = "points of contacts lie on one of the two surfaces, by the shapes that meet: half the gap off"
_MISSED = "joints of what hangs on a ball or a led body are constraints, whose drives exceed their law under TGS: refused"
_LOOSE = {
    "drive": _MISSED,
    "friction_loss": _MISSED,
    "one_sided_limit": "joints of what hangs on a ball or a led body are constraints: stops hold within half a turn alone",
}
_INSIDE = "a ray that starts in a solid of PhysX meets it where it starts"

ADAPTER = SapienAdapter(
    name="sapien",
    title="PhysX (SAPIEN)",
    distribution="sapien",
    licence="MIT",
    platforms=("linux-x86_64", "windows-x86_64"),
    extra=Extra(megabytes=385, seconds=4),
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
        | Feature.SPEED_LIMIT
        | Feature.FEEDFORWARD
        | Feature.TORSIONAL_FRICTION
        | Feature.RESTITUTION
        | Feature.LINEAR_DAMPING
        | Feature.ANGULAR_DAMPING
        | Feature.CONTACTS
        | Feature.RAYS
        | Feature.WRENCH
        | Feature.STEP_LENGTHS
    ),
    tracks={
        "default": Settings(source="sapien 3.0.3 as it comes"),
        "tuned": Settings(
            options={
                "by_scene": True,
                "bounce_threshold": 1e-3,
                "sleeping": False,
                "capped": False,
                "damping": "scene",
            },
            source="TGS for constraints and unlike masses: PhysX 5 API reference, PxSolverType; no bounce threshold, sleep, "
            "caps of velocity and damping that the scene does not ask for, and under PGS overlaps part by 0.1 m/s at most: "
            "PhysX 5 guide, Rigid Body Dynamics; 255 iterations for machines on light feet: API reference, "
            "setSolverIterationCounts; else 50, TGS for springs, bounces and what turns on its feet, and else PGS, with "
            "contacts from a touch on where things rebound: our own measurements (six boxes at rest tremble by 13 mm/s under "
            "TGS at 10, by 0.09 mm/s under PGS at 50; a ball on a turntable is off by 60 times its bound under PGS, by .2 "
            "under TGS)",
        ),
    },
    known_failures={
        **{
            f"default/{check}": "links and bodies lose 0.05 of their spin a second by default"
            for check in (
                "hidden_damping_is_off",
                "nothing_brakes_a_free_body",
                "gyroscopic_term_is_present",
                "mass_point_counts_where_it_is_fixed",
                "rolling_is_free_without_rolling_friction",
                "joint_pendulum_period",
                "joint_damping_is_off",
                "armature_adds_inertia",
                "dry_friction_brakes",
            )
        },
        "default/speed_limit_is_reached_and_kept": "spin is damped, and what hangs on a joint turns with it",
        "default/velocity_is_not_clamped": "turns are cut at 100 rad/s",
        "default/sleeping_is_off": "spin is damped; what is asked drifts by 5 mm/s, and sleep comes at 2",
        **{f"{track}/rays_match_closed_forms": _RAYS for track in ("default", "tuned")},
        **{f"{track}/ray_from_inside_meets_the_far_side": _INSIDE for track in ("default", "tuned")},
        **{f"{track}/contact_point_is_half_way": _POINTS for track in ("default", "tuned")},
        **{
            f"{track}/{check}": "a joint of PhysX has one drive: dry friction beside a spring or drive is refused"
            for track in ("default", "tuned")
            for check in ("dry_friction_beside_a_drive", "pair_drive_and_friction_loss")
        },
        **{
            f"{track}/{pair}": why
            for track in ("default", "tuned")
            for noun, why in _LOOSE.items()
            for pair in (f"pair_ball_and_{noun}", f"pair_{noun}_and_prescribed_body")
        },
    },
    knobs={
        "solver": SOLVERS,
        "substeps": (1, 2, 4, 8),
        "iterations": (4, 10, 25, 50, 100, 255),
        "options.velocity_iterations": (0, 1, 4, 8),
        "options.bounce_threshold": (2.0, 0.2, 1e-3),
        "options.contact_offset": (0.02, 0.01, 0.002),
        "options.max_depenetration_velocity": (UNBOUNDED, 1.0, 0.1),
    },
    acts_on={
        "options.bounce_threshold": Effect.RESTITUTION,
        "options.contact_offset": Effect.CONTACT,
        "options.max_depenetration_velocity": Effect.CONTACT,
        **dict.fromkeys(("iterations", "options.velocity_iterations"), Effect.CONTACT | Effect.JOINTS),
    },
    loads=("sapien",),
    orders={INTEGRATOR: 1},
    staggered=("tuned",),
    trade_offs=(
        TradeOff(
            cases=("spin_fast",),
            why="PGS, which keeps a ball's spin and rests where TGS trembles, errs 1.27 times as much as TGS in the attitude "
            "of a fast top, and over the ladder .88 times; every check holds under both",
        ),
        TradeOff(
            cases=("friction_painleve", "friction_spinning"),
            at=("own step", "ladder"),
            why="0.05 of a spin a second, which bodies come with and the scenes do not have, makes up for part of an error: of "
            "a stool on its feet, which friction brakes by 1.8 % less than Coulomb's law, .132 rad/s becomes .043, of a rod's "
            "way to where it locks 1.07 mm .81",
        ),
        TradeOff(
            cases=("rest_jitter",),
            at=("own step", "ladder"),
            why="what moves by 2 mm/s or less for .4 s sleeps as it comes, boxes at rest and what drifts in mid air; with "
            "nothing asleep boxes tremble by .15 mm/s under PGS and by 1 under TGS",
        ),
        TradeOff(
            cases=("impact_bounce",),
            at=("ladder",),
            why="1.22 times in the mean over the ladder, by its coarsest step (.0168 for .011, where every check holds) and "
            "roundings at the finest; at the case's own step both err alike",
        ),
        TradeOff(
            cases=("system_invariance",),
            at=("own step", "ladder"),
            why="roundings of single precision: on a floor that is turned a box slides 16 um astray under PGS, and .7 mm at "
            "1/1920 s, where a top errs by 14 um and .1 mm by default; under TGS at 50 iterations a ball errs by .5 and 2.5 mm",
        ),
    ),
    deviations=(
        "single precision: under TGS each step gives a spin 5e-7 of itself",
        "of the force of a contact only the normal part can be read, so none is judged",
        "cylinders are prisms of 32 sides, 0.48 % of the radius within",
    ),
    laws=("plumbline.adapters.sapien.simulation:SapienSimulation._sprung",),
    emulated=(
        Emulation(feature=Feature.MASS_POINT, how=POINTS_AS_BODIES),
        Emulation(feature=Feature.FRICTION_LOSS, how="a drive towards rest, cut off at the bound, stands for dry friction"),
        Emulation(
            feature=Feature.DISTANCE_SPRING,
            how="under PGS the spring of PhysX's distance joint lags, by 9 mm of 0.2 m at 10 rad/s and 1 ms; the adapter works "
            "out a pair of forces for each sub-step, under TGS too",
        ),
    ),
)
