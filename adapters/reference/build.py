"""What the adapter makes of a scene: one world, many worlds, compiled code."""

from typing import TYPE_CHECKING

from plumbline.adapters.reference.batch import ReferenceBatch
from plumbline.adapters.reference.choose_solver import on_feet, suited
from plumbline.adapters.reference.options import EULER, SOFT, SUITED, engine_options, resolved_settings, steps_in
from plumbline.adapters.reference.simulation import ReferenceSimulation
from plumbline.adapters.reference.world import make_world
from plumbline.harness.adapter import Settings
from plumbline.harness.scene import Camera, Scene

if TYPE_CHECKING:
    from plumbline import engine

__all__ = ["build", "build_batch", "compile_for"]


def build(scene: Scene, settings: Settings) -> ReferenceSimulation:
    """Exactly this scene under these settings. Raises: Unsupported, SettingsError."""
    world, options = _world(scene, settings)
    return ReferenceSimulation(world, scene, resolved_settings(settings, options, world), steps_in(settings, options))


def build_batch(scene: Scene, settings: Settings, count: int) -> ReferenceBatch | None:
    """Worlds in one array; None where these cannot be: the exact solver, swept collision, worlds with threads of their own.

    Raises: Unsupported, SettingsError.
    """
    from plumbline import engine

    world, options = _world(scene, settings)
    try:
        worlds = engine.Batch.replicate(world, count)
        return ReferenceBatch(worlds, resolved_settings(settings, options, world), steps_in(settings, options))
    except (engine.NotSupported, ValueError):
        return None


def compile_for(scene: Scene, settings: Settings) -> None:
    """Compile what the scene's steps, rays and pictures need. Raises: Unsupported, SettingsError."""
    from plumbline import engine

    world, _ = _world(scene, settings)
    world.compile()
    if scene.sensors:
        world.cast([[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], 1.0)
    for renderer in {sensor.renderer for sensor in scene.sensors if isinstance(sensor, Camera)}:
        world.render(engine.Eye(width=2, height=2), renderer)


def _world(scene: Scene, settings: Settings) -> "tuple[engine.World, engine.Options]":
    """A world at the start of the scene, and its options, with a solver of the engine where the scene is to choose it.

    Raises: Unsupported, SettingsError.
    """
    settled, world = settings, None
    if settings.solver == SUITED:
        settled, world = suited(scene, settings)
    elif settings.substeps is None and settings.solver in (None, SOFT) and settings.integrator in (None, EULER):
        settled, world = on_feet(scene, settings)
    options = engine_options(scene, settled)
    return world or make_world(scene, options), options
