"""The functions that the engine compiles for the trials of studies, most of which call the same few.

Groups of one family are made of much the same kernels; in each family the one that takes longest comes first.
"""

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from plumbline.adapters.reference.vendor import check_cache
from plumbline.harness.adapter.kernels import KernelGroup, Kernels

if TYPE_CHECKING:
    from plumbline import engine

__all__ = [
    "above_ground", "cast", "group", "is_stored", "kernels", "many_worlds", "stage", "step", "typed",
]  # fmt: skip

CONTACTS, JOINT_COORDINATES, RAYS, FREE = "contacts", "joint coordinates", "rays", "free bodies"


def is_stored(entry: str) -> bool:
    """Does the cache hold machine code of an entry of today's sources? Args: entry: `module.function`, below `engine`."""
    from plumbline import engine
    from plumbline.engine.compile.jit import cache_directory

    module, _, name = entry.rpartition(".")
    path = Path(engine.__file__).parent.joinpath(*module.split(".")).with_suffix(".py")
    return any(cache_directory(path).rglob(f"{path.stem}.{name}-*.nbc"))


def group(family: str, entries: tuple[str, ...], compile: Callable[[], None], first: bool = False) -> KernelGroup:  # noqa: A002
    """What a function compiles all at once. Args: entries: as `is_stored` takes them."""
    return KernelGroup(
        names=entries, compile=compile, is_stored=lambda: all(map(is_stored, entries)), family=family, first=first
    )


def typed(family: str, entry: str, types: str, first: bool = False) -> KernelGroup:
    """An entry for arguments of these types: F floats and I integers of a world, n a number, T and N tables of each kind."""

    def compile_entry() -> None:
        from plumbline.engine.steps.many_worlds import FLOATS, INTS
        from plumbline.engine.steps.many_worlds import types as numba

        tables = numba.Array(numba.float64, 2, "C"), numba.Array(numba.int64, 2, "C")
        known = dict(zip("FInTN", (FLOATS, INTS, numba.int64, *tables), strict=True))
        module, _, name = entry.rpartition(".")
        getattr(import_module(f"plumbline.engine.{module}"), name).compile(tuple(known[letter] for letter in types))

    return group(family, (entry,), compile_entry, first)


def step(family: str, entry: str, first: bool = False) -> KernelGroup:
    """A step (floats, ints, steps), or a search (floats, ints, threads)."""
    return typed(family, entry, "FIn", first)


def stage(family: str, entry: str, first: bool = False) -> KernelGroup:
    """A stage (floats, ints)."""
    return typed(family, entry, "FI", first)


def kernels() -> Kernels:
    """What the scenes of studies call, on both tracks and with every knob turned. Raises: Unavailable."""
    check_cache()
    from plumbline import engine
    from plumbline.engine.compile.jit import cache_directory, jit_is_off
    from plumbline.engine.options import FREE_INTEGRATORS

    if jit_is_off():
        return Kernels(notes=("NUMBA_DISABLE_JIT is set: functions run as plain Python, and take a hundred times longer",))
    held = "steps.joint_coordinates_held.step_joint_coordinates"
    free = "steps.joint_coordinates.step_joint_coordinates"
    groups = (
        step(JOINT_COORDINATES, f"{held}_touching", first=True),
        step(CONTACTS, "steps.contact.step_contact", first=True),
        step(CONTACTS, "steps.spheres.step_spheres", first=True),
        step(JOINT_COORDINATES, f"{free}_euler", first=True),
        step(JOINT_COORDINATES, f"{free}_runge_kutta", first=True),
        group(RAYS, ("rays.tiles.cast_tiles",), _tiles, first=True),
        stage(CONTACTS, "broad.uniform_grid.find_pairs", first=True),
        step(FREE, "steps.smooth.step_free", first=True),
        step(CONTACTS, "steps.contact_jointed.step_contact_jointed"),
        step(CONTACTS, "steps.islands_jointed.step_islands_jointed"),
        step(CONTACTS, "steps.islands.step_islands_parallel"),
        step(CONTACTS, "steps.sequential.step_sequential_impulses"),
        group(CONTACTS, SWEPT, _swept),
        group(CONTACTS, EXACT, _exact),
        group(CONTACTS, EXACT_JOINTS, _exact_joints),
        stage(CONTACTS, "contact.collide_convex.collide_convex"),
        stage(CONTACTS, "contact.collide_meshes.collide_meshes"),
        step(JOINT_COORDINATES, "steps.smooth.step_jointed_euler"),
        step(JOINT_COORDINATES, "steps.smooth.step_jointed_runge_kutta"),
        step(JOINT_COORDINATES, f"{free}_midpoint"),
        step(JOINT_COORDINATES, f"{free}_adaptive"),
        group(RAYS, ("rays.polyhedra.cast_on_polyhedra",), _polyhedra),
        group(RAYS, IMAGES, _pictures),
        stage(FREE, "broad.uniform_grid.find_pairs_parallel"),
        *(step(FREE, f"{module.removeprefix('plumbline.engine.')}.step_{name}") for name, module in FREE_INTEGRATORS.items()),
        group(FREE, ("steps.many_worlds.advance_worlds",), many_worlds),
    )
    return Kernels(groups=groups, folder=str(cache_directory(Path(engine.__file__)).parent), notes=_notes())


SWEPT = ("swept.earliest.earliest_impact", "swept.strike.place_bodies", "swept.strike.strike")
EXACT = (
    *(f"respond.exact.kernels.{name}" for name in ("begin_step", "kick_touched", "drift_touched")),
    *(f"respond.exact.kernels.{name}" for name in ("write_contacts", "write_problem", "give_impulses")),
    "respond.exact.law.largest_breach",
    "respond.exact.finish.finish_from",
    "respond.exact.law.write_scaled",
    "respond.exact.trace.look_at",
)
EXACT_JOINTS = ("respond.exact.kernels.write_joint_rows", "respond.exact.kernels.look_at_joints")
IMAGES = (
    "images.rasteriser.rasterise",
    *(f"images.shading.{name}" for name in ("shade", "name_bodies")),
    *(f"images.scatter.{name}" for name in ("scatter", "add_unshaded")),
    "images.lens.look",
)


def _notes() -> tuple[str, ...]:
    from plumbline.engine.compile.jit import LINKED, SWITCH, linker

    if linker() is not None:
        return ()
    known = " and ".join(f"Numba {version}" for version in LINKED)
    return (f"compiling takes three to seven times longer: {SWITCH} is off, or this is not {known}, which the linker knows",)


def _swept() -> None:
    from plumbline import engine

    above_ground(engine.Sphere(0.1), continuous="swept").compile()


def _exact() -> None:
    from plumbline import engine

    above_ground(engine.Sphere(0.1), solver="exact").compile()


def _exact_joints() -> None:
    """A ball that lies on the ground and hangs on it."""
    from plumbline import engine

    hanging = engine.Ball(name="anchor", parent=engine.WORLD, child="body", anchor_W=(0, 0, 0.15))
    above_ground(engine.Sphere(0.1), (hanging,), solver="exact", coordinates="maximal").step()


def _tiles() -> None:
    from plumbline import engine

    cast(above_ground(engine.Sphere(0.1), contacts=False))


def _polyhedra() -> None:
    from plumbline import engine

    hull = engine.ConvexHull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    cast(above_ground(hull, contacts=False))


def cast(world: "engine.World", threads: int = 1) -> None:
    """Cast a ray down on a body."""
    world.cast([(0.1, 0.1, 3)], [(0, 0, -1)], threads=threads)


def _pictures() -> None:
    from plumbline import engine

    eye = engine.Eye(width=8, height=8, focal_x=4.0, focal_y=4.0, centre_x=4.0, centre_y=4.0)
    for method in ("rasterised", "ray_traced"):
        above_ground(engine.Sphere(0.1), contacts=False).render(eye, method)


def many_worlds(threads: int = 1) -> None:
    """Step two worlds side by side."""
    from plumbline import engine

    engine.Batch.replicate(engine.World([engine.Body(name="body")]), 2, threads).step()


def above_ground(shape: "engine.Shape", joints: "Sequence[engine.Joint]" = (), **options: object) -> "engine.World":
    """A world of a body above the ground. Args: joints: that it hangs on."""
    from plumbline import engine

    ground = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
    body = engine.Body(name="body", shapes=[engine.Placed(shape)], p_WB=(0, 0, 0.05))
    return engine.World([ground, body], joints, options=engine.Options(**options))  # type: ignore[arg-type]
