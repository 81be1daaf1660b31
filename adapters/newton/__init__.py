"""Newton 1.8: rigid bodies on Warp, by its solver over MuJoCo-Warp and by XPBD; single precision, here on the processor.

Tried with newton 1.8.0, mujoco-warp 4.0.0 and warp-lang 1.19.0 (Python 3.11, Linux x86-64).
"""

import importlib.metadata
from dataclasses import dataclass

from plumbline.adapters.newton.build import build, build_worlds, together
from plumbline.adapters.newton.options import SOLVERS
from plumbline.adapters.newton.vendor import load
from plumbline.harness.adapter import Adapter, Emulation, Extra, Feature, Settings, Simulation
from plumbline.harness.adapter.many_worlds import Batch
from plumbline.harness.adapter.mass_points import POINTS_AS_BODIES, built_with_points
from plumbline.harness.scene import Scene

__all__ = ["ADAPTER"]


@dataclass(frozen=True, kw_only=True)
class NewtonAdapter(Adapter):
    """Newton."""

    def version(self) -> str:
        """The installed version of newton. Raises: Unavailable."""
        load()
        return importlib.metadata.version("newton")

    def compile(self, scene: Scene, settings: Settings) -> None:
        """The kernels of this scene. Raises: as `build`."""
        simulation = self.build(scene, settings)
        simulation.step(2)
        simulation.close()

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """Exactly this scene under these settings. Raises: Unsupported, Unavailable, SettingsError."""
        return built_with_points(lambda told: build(load(), told, settings), scene)

    def build_batch(self, scene: Scene, settings: Settings, count: int) -> Batch:
        """Worlds of one model, which one step steps together; one simulation each where each is led. Raises: as `build`."""
        if together(scene):
            return build_worlds(load(), scene, settings, count)
        return super().build_batch(scene, settings, count)


ADAPTER = NewtonAdapter(
    name="newton",
    title="Newton",
    distribution="newton",
    licence="Apache-2.0",
    platforms=("linux-x86_64", "linux-aarch64", "macos-arm64", "windows-x86_64"),
    extra=Extra(megabytes=564, seconds=5),
    single_precision=True,
    features=(
        Feature.SPHERE
        | Feature.BOX
        | Feature.CAPSULE
        | Feature.CYLINDER
        | Feature.ELLIPSOID
        | Feature.PLANE
        | Feature.CONVEX_HULL
        | Feature.TRIANGLE_MESH
        | Feature.COMPOUND
        | Feature.FULL_INERTIA
        | Feature.KINEMATIC
        | Feature.PRESCRIBED_MOTION
        | Feature.MASS_POINT
        | Feature.FIXED
        | Feature.BALL
        | Feature.REVOLUTE
        | Feature.PRISMATIC
        | Feature.DISTANCE_SPRING
        | Feature.CLOSED_LOOP
        | Feature.LIMITS
        | Feature.SPRINGS
        | Feature.DRIVES
        | Feature.ARMATURE
        | Feature.FRICTION_LOSS
        | Feature.FEEDFORWARD
        | Feature.RESTITUTION
        | Feature.LINEAR_DAMPING
        | Feature.ANGULAR_DAMPING
        | Feature.CONTACTS
        | Feature.CONTACT_FORCES
        | Feature.RAYS
        | Feature.WRENCH
        | Feature.SAVE
        | Feature.STEP_LENGTHS
    ),
    tracks={
        "default": Settings(source="newton 1.8.0 as it comes"),
        "tuned": Settings(
            options={
                "cone": "elliptic",
                "impratio": 10.0,
                "contact_steps": 20.0,
                "contact_damping_ratio": 1.2,
                "limit_steps": 2.0,
            },
            source="",
        ),
    },
    knobs={"solver": SOLVERS, "substeps": (1, 2, 4, 8)},
    loads=("newton",),
    compile_allowance=900.0,
    orders={"implicitfast": 1, "euler": 1, "rk4": 4, "semi_implicit_euler": 1},
    emulated=(Emulation(feature=Feature.MASS_POINT, how=POINTS_AS_BODIES),),
)
