"""Where the reference engine takes eleven worlds, to the last bit, on every processor.

A state is made of sums, products, quotients and square roots in the order of the engine's text, each rounded as IEEE 754 says,
so a hash holds wherever that is kept: what was tried stands in docs/method.md. After an intended change of the engine, renew
them by

    python -m tests.golden.engine_states

and say in the commit what changed them.
"""

import hashlib
import json
import os
import platform
import subprocess
import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol

import llvmlite.binding as llvm
import numpy as np
from numpy.typing import NDArray

from plumbline import engine
from tests.solid_meshes import box

FILE = Path(__file__).parent / "engine_states.json"
STEPS = 240
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
ROUGH = {("default", "default"): engine.Surface(static_friction=0.6, kinetic_friction=0.5, restitution=0.2)}


class Steps(Protocol):
    """A world, or several."""

    def step(self, count: int) -> None:
        """Advance."""

    def state(self) -> NDArray[np.float64]:
        """The state of all bodies."""


@cache
def known() -> dict[str, Any]:
    """drawn: numbers from which worlds are built; hashes: of each world's state; states: these, (n, 13)."""
    stored: dict[str, Any] = json.loads(FILE.read_text())
    return stored


def free_box(threads: int) -> engine.World:
    """A box that spins about its middle axis."""
    body = engine.Body(inertia=np.diag([1.0, 2.0, 3.0]), w_WB=(0.01, 5.0, 0.02), v_WB=(1.0, 0.5, 3.0))
    return engine.World([body], options=engine.Options(threads=threads))


def stack(threads: int) -> engine.World:
    """Two stacks of boxes, set down askew."""
    bodies = [
        engine.Body(
            name=f"{i}-{k}", inertia=0.04 / 6 * np.eye(3), shapes=[engine.Placed(engine.Box((0.1, 0.1, 0.1)))],
            p_WB=(i + 0.01 * k, 0, 0.101 + 0.201 * k),
        )
        for i in range(2)
        for k in range(5)
    ]  # fmt: skip
    return engine.World([GROUND, *bodies], surfaces=ROUGH, options=engine.Options(threads=threads))


def pile(threads: int) -> engine.World:
    """A heap of every shape beside another."""
    wedge = engine.ConvexHull([(-0.1, -0.1, -0.08), (0.1, -0.1, -0.08), (0, 0.12, -0.08), (0, 0, 0.12)])
    shapes = (engine.Sphere(0.1), engine.Box((0.1, 0.08, 0.12)), engine.Capsule(0.06, 0.1), engine.Cylinder(0.08, 0.1), wedge)
    bodies = [
        engine.Body(
            name=f"b{k}", inertia=np.diag([0.01, 0.012, 0.014]), shapes=[engine.Placed(shapes[k % 5])], q_WB=row[:4],
            p_WB=(3.0 * (k % 2) + row[4], row[5], 0.2 + 0.12 * k),
        )
        for k, row in enumerate(known()["drawn"]["pile"])
    ]  # fmt: skip
    return engine.World([GROUND, *bodies], surfaces=ROUGH, options=engine.Options(threads=threads))


def chain(threads: int, coordinates: str = "maximal") -> engine.World:
    """A chain of five links that swings from the horizontal."""
    links = [engine.Body(name=f"b{k}", inertia=0.01 * np.eye(3), p_WB=(0.2 * k + 0.1, 0, 0)) for k in range(5)]
    ends = [engine.WORLD, *(body.name for body in links)]
    joints = [
        engine.Revolute(name=f"j{k}", parent=ends[k], child=ends[k + 1], anchor_W=(0.2 * k, 0, 0), axis_W=(0, 1, 0.1 * k))
        for k in range(5)
    ]
    return engine.World(links, joints, options=engine.Options(threads=threads, coordinates=coordinates))


def tree(threads: int) -> engine.World:
    """That chain in joint coordinates."""
    return chain(threads, "joint")


def spheres(threads: int) -> engine.World:
    """Thirty balls that fall into two heaps."""
    bodies = [
        engine.Body(
            name=f"b{k}", inertia=0.004 * np.eye(3), shapes=[engine.Placed(engine.Sphere(0.1))],
            p_WB=(4.0 * (k % 2) + x, y, 0.15 + 0.1 * k),
        )
        for k, (x, y) in enumerate(known()["drawn"]["spheres"])
    ]  # fmt: skip
    return engine.World([GROUND, *bodies], surfaces=ROUGH, options=engine.Options(threads=threads))


def swept(_threads: int) -> engine.World:
    """A box that spins and a ball, both thrown at a thin wall at 40 m/s."""
    wall = engine.Body(
        name="wall", motion="static", shapes=[engine.Placed(engine.Box((0.005, 1.0, 1.0)))], p_WB=(1.0, 0.0, 1.0)
    )
    ball = engine.Body(
        name="ball", inertia=0.004 * np.eye(3), shapes=[engine.Placed(engine.Sphere(0.05))], p_WB=(0.0, 0.3, 1.0),
        v_WB=(40.0, 0.0, 1.0),
    )  # fmt: skip
    brick = engine.Body(
        name="brick", inertia=np.diag([0.002, 0.003, 0.004]), shapes=[engine.Placed(engine.Box((0.1, 0.05, 0.03)))],
        p_WB=(0.0, -0.3, 1.0), v_WB=(40.0, 1.0, 0.0), w_WB=(3.0, 20.0, 5.0),
    )  # fmt: skip
    return engine.World([GROUND, wall, ball, brick], surfaces=ROUGH, options=engine.Options(continuous="swept"))


def meshes(threads: int) -> engine.World:
    """Two blocks of triangles, which fall on each other and on the ground."""
    blocks = [
        engine.Body(
            name=f"block {k}", inertia=np.diag([0.007, 0.008, 0.005]), shapes=[engine.Placed(box((0.1, 0.08, 0.12)))],
            p_WB=(0.03 * k, 0.02 * k, 0.3 + 0.3 * k), q_WB=(0.8, 0.36 - 0.1 * k, 0.48, 0.1),
        )
        for k in range(2)
    ]  # fmt: skip
    return engine.World([GROUND, *blocks], surfaces=ROUGH, options=engine.Options(threads=threads))


def loop(threads: int) -> engine.World:
    """Four bars in joint coordinates, of which the last joint closes a loop."""
    places = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.3), (0.6, 0.0, 0.5), (0.5, 0.0, 0.0))
    bars = [
        engine.Body(
            name=f"b{k}",
            inertia=0.01 * np.eye(3),
            p_WB=tuple((a + b) / 2 for a, b in zip(places[k], places[k + 1], strict=True)),
        )
        for k in range(3)
    ]
    ends = [engine.WORLD, *(body.name for body in bars), engine.WORLD]
    joints = [
        engine.Revolute(name=f"j{k}", parent=ends[k], child=ends[k + 1], anchor_W=places[k], axis_W=(0, 1, 0)) for k in range(4)
    ]
    return engine.World(bars, joints, options=engine.Options(threads=threads, coordinates="joint"))


def runge_kutta(threads: int) -> engine.World:
    """A chain of three links on ball joints that turn fast, and drag, under RK4."""
    links = [
        engine.Body(
            name=f"b{k}", inertia=np.array([[0.01, 0.002, 0.0], [0.002, 0.012, 0.001], [0.0, 0.001, 0.02]]),
            p_WB=(0.2 * k + 0.1, 0, 0), angular_damping=0.1,
        )
        for k in range(3)
    ]  # fmt: skip
    ends = [engine.WORLD, *(body.name for body in links)]
    joints = [engine.Ball(name=f"j{k}", parent=ends[k], child=ends[k + 1], anchor_W=(0.2 * k, 0, 0)) for k in range(3)]
    options = engine.Options(threads=threads, integrator="rk4", coordinates="joint")
    return engine.World(links, joints, options=options)


class Together:
    """Worlds of a batch, their bodies one after the other."""

    def __init__(self, worlds: Sequence[engine.World], threads: int) -> None:
        self._batch = engine.Batch(worlds, threads)

    def step(self, count: int) -> None:
        """Advance."""
        self._batch.step(count)

    def state(self) -> NDArray[np.float64]:
        """(n, 13)."""
        return self._batch.state().reshape(-1, 13)


def batch(threads: int) -> Together:
    """The two chains, and one of the balls' heaps twice."""
    return Together([chain(1), tree(1), chain(1)], threads)


WORLDS: dict[str, Callable[[int], Steps]] = {
    build.__name__: build
    for build in (free_box, stack, pile, chain, tree, spheres, swept, meshes, loop, runge_kutta, batch)
}  # fmt: skip


def last_state(name: str, threads: int) -> NDArray[np.float64]:
    """The state of a world, (n, 13), after a second."""
    world = WORLDS[name](threads)
    world.step(STEPS)
    return np.array(world.state())


def digest(state: NDArray[np.float64]) -> str:
    """The hash of a state: of its bits, whatever order of bytes a processor has."""
    return hashlib.sha256(np.ascontiguousarray(state).astype("<f8").tobytes()).hexdigest()


def difference(name: str, found: NDArray[np.float64]) -> str:
    """Where a state first differs from the one that is known, by how much, and on what; empty where it does not."""
    expected = np.array(known()["states"][name])
    if digest(found) == known()["hashes"][name]:
        return ""
    rows, columns = np.nonzero(found != expected)
    if len(rows) == 0:
        return f"{name}: the signs of zeros differ, on {machine()}"
    body, column = int(rows[0]), int(columns[0])
    part = next(word for word, end in (("p_WB", 3), ("q_WB", 7), ("v_WB", 10), ("w_WB", 13)) if column < end)
    here, there = float(found[body, column]), float(expected[body, column])
    off, most = abs(here - there) / np.spacing(abs(there)), np.abs(found - expected).max()
    return (
        f"{name}: {part} of body {body} is {here!r}, expected {there!r}, {off:.3g} units in the last place off; {len(rows)} of "
        f"{found.size} numbers differ, by at most {most:.3g}, on {machine()}; please report this line where the project is "
        "kept: no processor should change a bit"
    )


def machine() -> str:
    """The processor, NumPy's BLAS kernels, and the versions of what numbers come from."""
    import numba
    from threadpoolctl import threadpool_info

    blas = " ".join(sorted({info.get("architecture", "") for info in threadpool_info() if "numpy" in info["filepath"]}))
    versions = f"NumPy {np.__version__}, Numba {numba.__version__}, LLVM {'.'.join(map(str, llvm.llvm_version_info))}"
    return f"{platform.machine()} {llvm.get_host_cpu_name()}, BLAS kernels {blas}, {' '.join(platform.libc_ver())}, {versions}"


def states_elsewhere(environment: dict[str, str], names: Sequence[str], *flags: str) -> dict[str, str]:
    """The hashes of worlds on one thread in a fresh process.

    Args: environment: what is set there; flags: of the interpreter.
    """
    with TemporaryDirectory() as folder:
        asked = {**os.environ, "PLUMBLINE_KERNEL_CACHE": folder, **environment}
        command, root = [sys.executable, *flags, "-m", "tests.golden.engine_states", *names], Path(__file__).parents[2]
        said = subprocess.run(command, env=asked, capture_output=True, text=True, check=False, cwd=root)
    if said.returncode != 0:
        raise RuntimeError(said.stderr)
    hashes: dict[str, str] = json.loads(said.stdout)
    return hashes


def _renew() -> None:
    states = {name: last_state(name, 1) for name in WORLDS}
    told = {
        "drawn": known()["drawn"],
        "hashes": {name: digest(state) for name, state in states.items()},
        "states": {name: state.tolist() for name, state in states.items()},
    }
    FILE.write_text(json.dumps(told, indent=1) + "\n")


if __name__ == "__main__":
    if sys.argv[1:]:
        print(json.dumps({name: digest(last_state(name, 1)) for name in sys.argv[1:]}))
    else:
        _renew()
