"""Where the reference engine takes six worlds: their states, which hold to rounding everywhere, and hashes, to the last bit.

The text of a kernel says which products are rounded with the sums that they stand in, so processors that have the instruction
give the same bits; a hash holds for these, one C library, one Numba, one LLVM and the kernels of NumPy's linear algebra, by
which a world is built: these go with the processor. What it makes of a state to have no such
instruction has been measured, by compiling without any of the processor's own; another machine may differ a hundred times as
much. After an intended change of the engine, renew states and the hashes of this machine by

    python tests/golden/engine_states.py

and say in the commit what changed them; hashes of other machines are dropped then, for they are of the old engine.
"""

import hashlib
import json
import os
import platform
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from numpy.typing import NDArray

import engine

FILE = Path(__file__).parent / "engine_states.json"
STEPS = 240
COMPARED = {"pile": 90}
"""Steps after which states are compared, STEPS unless said: by then a rounding in the heap of all shapes has grown to 3e-5, and
to a tenth of a metre by the end."""
ROOM = 100.0
"""How many times the measured difference another machine may make: roundings elsewhere fall otherwise, but are as large."""
LEAST = 1e-14
"""The least such difference: a few roundings of a metre."""
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
ROUGH = {("default", "default"): engine.Surface(static_friction=0.6, kinetic_friction=0.5, restitution=0.2)}


def machine() -> str:
    """The family of processors, whether it fuses products and sums, NumPy's BLAS kernels, and the versions of the C library,
    Numba and LLVM."""
    import numba
    from threadpoolctl import threadpool_info

    blas = " ".join(sorted({info.get("architecture", "") for info in threadpool_info() if "numpy" in info["filepath"]}))
    versions = f"{' '.join(platform.libc_ver())}, numba {numba.__version__}, LLVM {'.'.join(map(str, llvm.llvm_version_info))}"
    return f"{platform.machine()} {'with' if fuses() else 'without'} fused multiply-add, BLAS {blas}, {versions}"


def fuses() -> bool:
    """Whether this processor has an instruction for a product and a sum; ARM's all have."""
    return platform.machine() == "aarch64" or bool(dict(llvm.get_host_cpu_features()).get("fma", False))


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
    rng = np.random.default_rng(5)
    wedge = engine.ConvexHull([(-0.1, -0.1, -0.08), (0.1, -0.1, -0.08), (0, 0.12, -0.08), (0, 0, 0.12)])
    shapes = (engine.Sphere(0.1), engine.Box((0.1, 0.08, 0.12)), engine.Capsule(0.06, 0.1), engine.Cylinder(0.08, 0.1), wedge)
    bodies = [
        engine.Body(
            name=f"b{k}", inertia=np.diag([0.01, 0.012, 0.014]), shapes=[engine.Placed(shapes[k % 5])], q_WB=rng.normal(size=4),
            p_WB=(3.0 * (k % 2) + rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), 0.2 + 0.12 * k),
        )
        for k in range(10)
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
    rng = np.random.default_rng(11)
    bodies = [
        engine.Body(
            name=f"b{k}", inertia=0.004 * np.eye(3), shapes=[engine.Placed(engine.Sphere(0.1))],
            p_WB=(4.0 * (k % 2) + rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2), 0.15 + 0.1 * k),
        )
        for k in range(30)
    ]  # fmt: skip
    return engine.World([GROUND, *bodies], surfaces=ROUGH, options=engine.Options(threads=threads))


WORLDS: dict[str, Callable[[int], engine.World]] = {
    build.__name__: build for build in (free_box, stack, pile, chain, tree, spheres)
}  # fmt: skip


def last_state(name: str, threads: int) -> str:
    """The hash of the state of a world after a second."""
    world = WORLDS[name](threads)
    world.step(STEPS)
    return hashlib.sha256(world.state().tobytes()).hexdigest()


def compared_state(name: str) -> NDArray[np.float64]:
    """The state of a world, (n, 13), at the step at which it is compared."""
    world = WORLDS[name](1)
    world.step(COMPARED.get(name, STEPS))
    return world.state().copy()


def known() -> dict[str, Any]:
    """hashes: of each world by machine. states: of each world; spread: how far another rounding moves them, at most."""
    stored: dict[str, Any] = json.loads(FILE.read_text())
    return stored


def tolerance(name: str) -> float:
    """How far a state may be from the one that is known, on a machine whose hashes are not."""
    return ROOM * max(LEAST, float(known()["spread"][name]))


def _rounded_otherwise() -> dict[str, NDArray[np.float64]]:
    """The states as they come out without the instructions that this processor has beyond its family's first."""
    states = json.loads(_said_elsewhere("generic", "", "states"))
    return {name: np.array(state) for name, state in states.items()}


def last_state_on(processor: str, features: str, name: str) -> str:
    """As `last_state` on one thread, of code for another processor; features: as LLVM writes them."""
    return _said_elsewhere(processor, features, "hash", name).strip()


def _said_elsewhere(processor: str, features: str, *asked: str) -> str:
    """What this file prints where kernels are compiled for another processor."""
    with TemporaryDirectory() as folder:
        target = {"NUMBA_CPU_NAME": processor, "NUMBA_CPU_FEATURES": features, "PLUMBLINE_KERNEL_CACHE": folder}
        return subprocess.run(
            [sys.executable, __file__, *asked], env={**os.environ, **target}, capture_output=True, text=True, check=True
        ).stdout


def _renew() -> None:
    states, others = {name: compared_state(name) for name in WORLDS}, _rounded_otherwise()
    told = {
        "hashes": {machine(): {name: last_state(name, 1) for name in WORLDS}},
        "spread": {name: float(np.abs(states[name] - others[name]).max()) for name in WORLDS},
        "states": {name: state.tolist() for name, state in states.items()},
    }
    FILE.write_text(json.dumps(told, indent=1) + "\n")


if __name__ == "__main__":
    if sys.argv[1:] == ["states"]:
        print(json.dumps({name: compared_state(name).tolist() for name in WORLDS}))
    elif sys.argv[1:2] == ["hash"]:
        print(last_state(sys.argv[2], 1))
    else:
        _renew()
