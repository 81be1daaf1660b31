"""The engine's kernels compiled before tests start: those of studies, and those that tests alone call.

`python -m tests.warm_up --workers N`, which is quick if all are stored. Processes that run tests would meet the same kernels at
the same time, and one of them would wait while the other compiles.
"""

import argparse
import os
import sys
from dataclasses import replace

from plumbline.adapters.reference import ADAPTER
from plumbline.adapters.reference.kernels import above_ground, cast, group, many_worlds, stage, step
from plumbline.harness.adapter.kernels import KernelGroup, Kernels
from plumbline.harness.run.warm_up import warm_up

__all__ = ["kernels"]


def kernels() -> Kernels:
    """All that the tests of `make test` call."""
    studied = ADAPTER.kernels()
    return replace(studied, groups=(*studied.groups, *_of_tests())) if studied.groups else studied


def _of_tests() -> tuple[KernelGroup, ...]:
    """What no study calls: options that no track and no knob sets."""
    from plumbline.engine.options import BROAD_PHASES

    phases = [name for name in BROAD_PHASES if name != "uniform_grid"]
    held = "steps.joint_coordinates_held.step_joint_coordinates"
    return (
        step("contacts", "steps.islands.step_islands"),
        step("contacts", "steps.shared_sweeps.step_contact_coloured"),
        step("contacts", "steps.shared_sweeps.step_contact_jacobi"),
        step("contacts", "steps.shared_sweeps.step_spheres_coloured"),
        stage("contacts", "contact.colours.sort_pairs"),
        step("joint coordinates", f"{held}_touching_and_closing"),
        step("joint coordinates", f"{held}_closing"),
        group("rays", ("rays.tiles_parallel.cast_tiles_parallel",), _cast_on_two_threads),
        *(stage("broad phases", f"broad.{name}.find_pairs") for name in phases),
        *(stage("broad phases", f"broad.{name}.find_pairs_parallel") for name in phases),
        *(stage("broad phases", f"broad.volumes.{name}.drop_apart") for name in ("obb", "sphere")),
        group("free bodies", ("steps.many_worlds.advance_worlds_parallel",), lambda: many_worlds(2)),
    )


def _cast_on_two_threads() -> None:
    from plumbline import engine

    cast(above_ground(engine.Sphere(0.1), contacts=False), threads=2)


def main(workers: int) -> int:
    """Compile what the cache lacks. Returns: how many groups could not be compiled."""
    wanted = [number for number, each in enumerate(kernels().groups) if not each.is_stored()]
    failures = warm_up("kernels", kernels, wanted, ADAPTER.loads, workers) if wanted else []
    print(*failures, sep="\n", end="\n" if failures else "", file=sys.stderr)
    return len(failures)


if __name__ == "__main__":
    from tests import warm_up as this  # other processes know it by this name

    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="how many processes compile")
    sys.exit(this.main(asked.parse_args().workers))
