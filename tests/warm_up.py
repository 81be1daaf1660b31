"""The engine's kernels compiled before tests start: `python -m tests.warm_up --workers N`, which is quick where all are kept.

Two processes that run tests meet the same kernels at the same time, and one of them waits while the other compiles: what
compiles takes twice as long as it must. Here each entry goes to one process, and all of a family to the same one as long as
the other has something else to do: a process that has typed what two entries share uses it for both.
"""

import argparse
import multiprocessing
import os
import time
from collections.abc import Callable, Iterator, Sequence, Set
from importlib import import_module
from itertools import chain
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, NamedTuple

import engine
from engine.compile.jit import cache_directory, jit_is_off
from engine.options import BROAD_PHASES, FREE_INTEGRATORS
from engine.steps.many_worlds import FLOATS, INTS, types

__all__ = ["FAMILIES", "FAMILY", "JOBS", "Job", "following", "is_kept", "lacking", "warm_up"]


class Job(NamedTuple):
    """What one process compiles at a time.

    Terms: entries: compiled functions as `module.function`, below `engine`. compile: has them all compiled or loaded.
    """

    entries: tuple[str, ...]
    compile: Callable[[], None]


def _typed(entry: str, *arguments: Any) -> Job:
    """An entry for arguments of these types."""
    module, _, name = entry.rpartition(".")
    return Job((entry,), lambda: getattr(import_module(f"engine.{module}"), name).compile(arguments))


def _step(entry: str) -> Job:
    """A step (floats, ints, steps), or a search (floats, ints, threads)."""
    return _typed(entry, FLOATS, INTS, types.int64)


def _stage(entry: str) -> Job:
    """A stage (floats, ints)."""
    return _typed(entry, FLOATS, INTS)


TABLE, NUMBERS = types.Array(types.float64, 2, "C"), types.Array(types.int64, 2, "C")
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
HULL = engine.ConvexHull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
EYE = engine.Eye(width=8, height=8, focal_x=4.0, focal_y=4.0, centre_x=4.0, centre_y=4.0)


def _world(shape: engine.Shape, **options: object) -> engine.World:
    """A body above the ground."""
    body = engine.Body(name="body", shapes=[engine.Placed(shape)], p_WB=(0, 0, 0.05))
    return engine.World([GROUND, body], options=engine.Options(**options))  # type: ignore[arg-type]


def _exact() -> None:
    _world(engine.Sphere(0.1), solver="exact").compile()


def _exact_jointed() -> None:
    ball = engine.Body(name="ball", shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(0, 0, 0.05))
    held = engine.Ball(name="held", parent=engine.WORLD, child="ball", anchor_W=(0, 0, 0.05))
    engine.World([GROUND, ball], [held], options=engine.Options(solver="exact")).compile()


def _swept() -> None:
    _world(engine.Sphere(0.1), continuous="swept").compile()


def _side_by_side() -> None:
    for threads in (1, 2):
        engine.Batch.replicate(engine.World([engine.Body(name="body")]), 2, threads).step()


def _rays() -> None:
    world = _world(HULL, contacts=False)
    for method, threads in (("tiles", 1), ("tiles", 2), ("brute_force", 1)):
        world.cast([(0.1, 0.1, 3)], [(0, 0, -1)], method=method, threads=threads)


def _pictures() -> None:
    world = _world(engine.Sphere(0.1), contacts=False)
    for method in ("rasterised", "ray_traced"):
        world.render(EYE, method)


FAMILIES: tuple[tuple[Job, ...], ...] = (
    (
        _step("steps.contact_jointed.step_contact_jointed"),
        _step("steps.islands_jointed.step_islands_jointed"),
        _step("steps.islands.step_islands"),
        _step("steps.islands.step_islands_parallel"),
        Job(("swept.earliest.earliest_impact", "swept.strike.place_bodies", "swept.strike.strike"), _swept),
        _step("steps.contact.step_contact"),
        _step("steps.sequential.step_sequential_impulses"),
        _step("steps.contact_coloured.step_contact_coloured"),
        _step("steps.contact_jacobi.step_contact_jacobi"),
        _step("steps.spheres.step_spheres"),
        _step("steps.spheres_coloured.step_spheres_coloured"),
        Job(
            tuple(
                f"respond.exact.{name}"
                for name in (
                    "kernels.begin_step",
                    "kernels.kick_touched",
                    "kernels.drift_touched",
                    "assembly.write_closing",
                    "assembly.write_frames",
                    "assembly.write_problem",
                    "assembly.give_impulses",
                    "certificate.largest_breach",
                    "finish.finish_from",
                    "scaling.write_scaled",
                    "look.look_at",
                )
            ),
            _exact,
        ),
        Job(tuple(f"respond.exact.joint_kernels.{name}" for name in ("write_joint_rows", "look_at_joints")), _exact_jointed),
        _stage("contact.colours.sort_pairs"),
        _stage("contact.collide_convex.collide_convex"),
        _stage("contact.collide_meshes.collide_meshes"),
        _typed("contact.measure_convex.measure_convex", FLOATS, INTS, types.int64, types.int64, TABLE, TABLE, TABLE),
        _typed("contact.measure_triangles.measure_triangles", TABLE, TABLE, NUMBERS, TABLE),
    ),
    (
        _step("steps.smooth.step_jointed_euler"),
        _step("steps.smooth.step_jointed_runge_kutta"),
        _step("steps.joint_coordinates.step_joint_coordinates_euler"),
        _step("steps.joint_coordinates.step_joint_coordinates_runge_kutta"),
        _step("steps.joint_coordinates.step_joint_coordinates_midpoint"),
        _step("steps.joint_coordinates.step_joint_coordinates_adaptive"),
        _step("steps.joint_coordinates_held.step_joint_coordinates_touching"),
        _step("steps.joint_coordinates_held.step_joint_coordinates_touching_and_closing"),
        _step("steps.joint_coordinates_held.step_joint_coordinates_closing"),
    ),
    (
        Job(
            tuple(
                f"rays.{name}"
                for name in (
                    "tiles.cast_tiles",
                    "tiles_parallel.cast_tiles_parallel",
                    "one_by_one.cast_rays",
                    "polyhedra.cast_on_polyhedra",
                )
            ),
            _rays,
        ),
        Job(
            tuple(
                f"images.{name}"
                for name in (
                    "rasteriser.rasterise",
                    "shading.shade",
                    "shading.name_bodies",
                    "scatter.scatter",
                    "scatter.add_unshaded",
                    "lens.look",
                )
            ),
            _pictures,
        ),
    ),
    (
        *(_stage(f"broad.{name}.find_pairs") for name in BROAD_PHASES),
        *(_step(f"broad.parallel.{name}.find_candidates") for name in BROAD_PHASES),
        _step("broad.parallel.pairs.write_pairs"),
        *(_stage(f"broad.volumes.{name}.drop_apart") for name in ("obb", "sphere")),
    ),
    (
        _step("steps.smooth.step_free"),
        *(_step(f"{module.removeprefix('engine.')}.step_{name}") for name, module in FREE_INTEGRATORS.items()),
        _typed("islands.islands.connected_components", NUMBERS, NUMBERS, NUMBERS),
        Job(("steps.many_worlds.advance_worlds", "steps.many_worlds.advance_worlds_parallel"), _side_by_side),
    ),
)
"""All that the tests of `make test` use: what is made of much the same kernels together, the dearest first."""
JOBS = tuple(chain.from_iterable(FAMILIES))
FAMILY = tuple(family for family, jobs in enumerate(FAMILIES) for _ in jobs)
"""That of each job."""


def is_kept(entry: str) -> bool:
    """Whether the cache holds machine code of an entry of today's sources. Args: entry: as `Job`."""
    module, _, name = entry.rpartition(".")
    path = Path(engine.__file__).parent.joinpath(*module.split(".")).with_suffix(".py")
    return any(cache_directory(path).glob(f"{path.stem}.{name}-*.nbi"))


def lacking() -> Iterator[int]:
    """The numbers of the jobs that have something to compile."""
    return (number for number, job in enumerate(JOBS) if not all(map(is_kept, job.entries)))


def following(waiting: Sequence[int], begun: Sequence[Set[int]], process: int) -> int:
    """The job that a process takes next: of a family that it has begun, else of one that none has, else the first that waits.

    Args: waiting: numbers of jobs, at least one. begun: by process, the families of the jobs that it has taken.
    """
    own = [number for number in waiting if FAMILY[number] in begun[process]]
    fresh = [number for number in waiting if not any(FAMILY[number] in families for families in begun)]
    return (own or fresh or waiting)[0]


def _serve(asked: Connection) -> None:
    """Compile the jobs whose numbers come in, each answered by what it took of the processor [s]; none is the end."""
    while (number := asked.recv()) is not None:
        before = time.process_time()
        JOBS[number].compile()
        asked.send(time.process_time() - before)


def warm_up(workers: int) -> None:
    """Compile what the cache lacks, on several processes, and say what it took. Raises: EOFError: one of them has died."""
    if jit_is_off():
        return
    waiting = list(lacking())
    if not waiting:
        return
    import_module("engine.compile.prepared")
    print(f"compiling {len(waiting)} of {len(JOBS)} groups of the engine's kernels")
    context = multiprocessing.get_context("fork")
    servers = list[Connection]()
    for _ in range(min(workers, len(waiting))):
        ours, theirs = context.Pipe()
        context.Process(target=_serve, args=(theirs,), daemon=True).start()
        theirs.close()
        servers.append(ours)
    begun: list[set[int]] = [set() for _ in servers]
    running: dict[Connection, int] = {}

    def hand_out(process: int) -> None:
        if waiting:
            number = following(waiting, begun, process)
            waiting.remove(number)
            begun[process].add(FAMILY[number])
            running[servers[process]] = number
        servers[process].send(running.get(servers[process]))

    for process in range(len(servers)):
        hand_out(process)
    while running:
        for server in wait(list(running)):
            seconds = server.recv()
            print(f"{seconds:7.1f} s  {', '.join(JOBS[running.pop(server)].entries)}", flush=True)
            hand_out(servers.index(server))


if __name__ == "__main__":
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="how many processes compile")
    warm_up(asked.parse_args().workers)
