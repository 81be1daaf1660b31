"""Rapier through its official Python binding rapier3d: rigid bodies in single precision, contacts as stiff springs in sub-steps.

Tried with rapier3d 0.36.1 (Python 3.11, Linux x86-64).

Deviations:
    * to be written
"""

import importlib.metadata
from dataclasses import dataclass

from plumbline.adapters.rapier.build import build
from plumbline.adapters.rapier.options import FRICTION, INTEGRATOR
from plumbline.adapters.rapier.vendor import load
from plumbline.harness.adapter import Adapter, Emulation, Extra, Feature, Settings, Simulation
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
        return built_with_points(lambda told: build(load(), told, settings), scene)


_SLEPT = "what creeps slower than 0.05 m/s is put to sleep on its way"
_RAYS = (
    "rays meet cylinders by an iteration (GJK) that stops 0.5 mm off, normals by 0.014 rad; planes, at a graze and 50 m, 0.06 mm "
    "off by single precision"
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
            substeps=12,
            options={
                "sleeping": False,
                "contact_rate": 0.25,
                "recycling": False,
                "clustering": False,
                "capped": False,
                "soft_ccd": True,
                "inner_edges": False,
            },
            source="12 iterations: IntegrationParameters, 'demanding scenarios, stacks, complex machinery'",
        ),
    },
    known_failures={
        "default/fast_spin_is_not_cut": "turns are cut at 45 degrees a step, unless a body is told allow_fast_rotation",
        "default/huge_state_is_not_reset": "speeds are cut at 400 m/s (normalized_max_linear_velocity)",
        "default/sleeping_is_off": "bodies slower than 0.05 m/s and 0.5 rad/s sleep after half a second, also without contact",
        "default/target_velocity_acts": _SLEPT,
        "default/dry_friction_holds": _SLEPT,
        "default/dry_friction_beside_a_drive": _SLEPT,
        "default/near_miss_leaves_no_trace": "contact_recycling keeps contacts of pairs that move by less than 5 cm, as they were",
        "default/joint_damping_is_off": "impulse joints take 1.4 % of a pendulum's energy in 3 s at 4 sub-steps of 1/960 s",
        **{f"{track}/rays_match_closed_forms": _RAYS for track in ("default", "tuned")},
        **{f"{track}/ray_from_inside_meets_the_far_side": _RAYS for track in ("default", "tuned")},
        "tuned/prescribed_platform_lifts_what_it_meets": (
            "a prescribed body moves by h v in each of 12 sub-steps in single precision: 26 um are lost on 0.5 m at 1 ms"
        ),
    },
    knobs={
        "substeps": (1, 4, 8, 12, 16),
        "iterations": (1, 2, 4, 8),
        "options.friction_model": FRICTION,
        "options.contact_rate": (0.0625, 0.125, 0.25),
        "options.sleeping": (True, False),
    },
    acts_on={"options.friction_model": Effect.FRICTION, "options.contact_rate": Effect.CONTACT},
    loads=("rapier3d",),
    orders={INTEGRATOR: 1},
    emulated=(Emulation(feature=Feature.MASS_POINT, how=POINTS_AS_BODIES),),
)
