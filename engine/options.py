"""How a world is solved."""

from dataclasses import dataclass
from typing import Annotated

from plumbline.engine.describe.check import Described, between, not_negative, one_of, positive, whole

ADAPTIVE = "dormand_prince"
FREE_INTEGRATORS = {
    "explicit_euler": "plumbline.engine.integrate.runge_kutta",
    "velocity_verlet": "plumbline.engine.integrate.composition",
    "implicit_midpoint": "plumbline.engine.integrate.implicit_midpoint",
    "splitting_4": "plumbline.engine.integrate.composition",
    "splitting_8": "plumbline.engine.integrate.composition",
    ADAPTIVE: "plumbline.engine.integrate.runge_kutta",
}
"""Integrators of bodies that neither joints nor contacts can touch, with the module of each."""
TOLERANCES = {"semi_implicit_euler": 1e-11, ADAPTIVE: 1e-12}
"""What is asked of a step where nothing is said."""
INTEGRATORS = ("semi_implicit_euler", "rk4", *FREE_INTEGRATORS)
BROAD_PHASES = ("uniform_grid", "octree", "sweep_and_prune", "bvh", "brute_force")
BOUNDING_VOLUMES = ("aabb", "obb", "sphere")
SOLVERS = ("tgs_soft", "exact", "sequential_impulses")
CONTINUOUS = ("off", "speculative", "swept")
MAXIMAL, JOINT, AUTOMATIC = "maximal", "joint", "automatic"
COORDINATES = (MAXIMAL, JOINT, AUTOMATIC)
GAUSS_SEIDEL, COLOURED, JACOBI = "gauss_seidel", "coloured", "jacobi"
SWEEPS = (GAUSS_SEIDEL, COLOURED, JACOBI)
LEVELS = ("sphere", "box", "hull", "decomposition", "mesh")


@dataclass(frozen=True, slots=True, kw_only=True)
class Options(Described):
    """The choices of a solver.

    Terms:
        dt [s]; substeps per dt of contacts and of every integrator but rk4; iterations: sweeps with the position error;
        relaxations: sweeps without it; integrator: of bodies that no contact touches; step_tolerance [1]: largest estimated
        relative error of one step of dormand_prince (None: 1e-12), or share of a sub-step's way that the rounds of
        semi_implicit_euler in joint coordinates may leave out (None: 1e-11); broad_phase (None: by the number of shapes);
        bounding_volume: what two shapes are compared by, after their axis-aligned boxes; level_of_detail: what triangle meshes
        collide and meet rays as, while pictures show them as they are (None: as they are); threads: how many, of those that
        Numba was started with, share the broad phase, and the islands of a world under the soft solver that is not one of
        spheres alone, without changing a bit of the answer; contact_hertz [Hz] (None: as stiff as a sub-step allows, a quarter
        of its rate) and contact_damping_ratio of the soft contact; max_push [m/s]: fastest correction of penetration;
        bounce_speed [m/s]: slower approaches do not bounce (None: four times what gravity gives in a sub-step); margin [m]:
        contacts are made at least this far ahead; contacts, gyroscopic: whether these effects are simulated; continuous:
        collision of fast bodies, 'speculative' makes contacts for the way of the whole step, 'swept' stops the world at each
        impact; solver: of contacts, 'exact' solves Coulomb's law itself once per sub-step, without iterations, relaxations and
        springs, down to the relative residual `tolerance`, or to the best answer that is found for `effort` [ms], counted in
        matrices of known cost and not by a clock; 'sequential_impulses' sweeps `iterations` times over velocities and
        once more over positions, without relaxations and springs; sleeping: whether an island of which all bodies have been
        slower than sleep_speed [m/s] for sleep_time [s] stands still until something outside of it changes, where
        sqrt(2 E / m) of the kinetic energy E is a body's speed; it errs by up to sleep_speed in velocity, and keeps down what
        accelerates by less than sleep_speed / sleep_time. With it a world of spheres alone is solved by manifolds like any
        other, not by the solver of spheres. coordinates: of bodies held by joints, 'maximal' six of each body's own, with the
        joints as constraints; 'joint' those that the joints leave, with loops as constraints on top, and contacts under
        the soft solver and semi-implicit Euler alone; 'automatic' these where joints make trees of bodies that are no
        points and close no loops, unless the other options know no contacts there or most bodies that may touch are loose, and
        wherever joints are coupled or bodies without mass, else the former (None: 'maximal' under rk4, else 'automatic').
        sweeps: of the soft solver, 'gauss_seidel' over contacts in the order in which they are found, each seeing what those
        before it gave; without joints also 'coloured', that by bands of the world, of which those of one colour move no common
        body, or 'jacobi', all points from the velocities of before the sweep, on split masses, so that the order of contacts
        shows in the rounding of sums alone, but contacts are as many times softer as a body has points. Under both, `threads`
        share the contacts of one island as of many, without changing a bit of the answer. Under 'jacobi' a world of spheres
        alone is solved by manifolds like any other.
    """

    dt: Annotated[float, positive, "s"] = 1 / 240
    substeps: Annotated[int, whole, 1] = 4
    iterations: Annotated[int, whole, 1] = 2
    relaxations: Annotated[int, whole, 0] = 1
    integrator: Annotated[str, one_of, INTEGRATORS] = "semi_implicit_euler"
    # Below 1e-14 the estimate of an error is round-off, which no shorter step makes smaller.
    step_tolerance: Annotated[float | None, between, 1e-14, 1e-2] = None
    broad_phase: Annotated[str | None, one_of, BROAD_PHASES] = None
    bounding_volume: Annotated[str, one_of, BOUNDING_VOLUMES] = "aabb"
    level_of_detail: Annotated[str | None, one_of, LEVELS] = None
    threads: Annotated[int, whole, 1] = 1
    contact_hertz: Annotated[float | None, positive, "Hz"] = None
    contact_damping_ratio: Annotated[float, not_negative, ""] = 10.0
    max_push: Annotated[float, positive, "m/s"] = 3.0
    bounce_speed: Annotated[float | None, not_negative, "m/s"] = None
    margin: Annotated[float, not_negative, "m"] = 1e-3
    contacts: bool = True
    gyroscopic: bool = True
    continuous: Annotated[str, one_of, CONTINUOUS] = "off"
    solver: Annotated[str, one_of, SOLVERS] = "tgs_soft"
    tolerance: Annotated[float, positive, ""] = 1e-11
    effort: Annotated[float, positive, "ms"] = 50.0
    sleeping: bool = False
    sleep_speed: Annotated[float, positive, "m/s"] = 1e-3
    sleep_time: Annotated[float, positive, "s"] = 0.5
    coordinates: Annotated[str | None, one_of, COORDINATES] = None
    sweeps: Annotated[str, one_of, SWEEPS] = GAUSS_SEIDEL

    def __post_init__(self) -> None:
        self.check_fields()
        if self.step_tolerance is not None and self.integrator not in TOLERANCES:
            raise ValueError(
                f"options: step_tolerance {self.step_tolerance}, but integrator '{self.integrator}' does not adapt"
            )

    @property
    def used_step_tolerance(self) -> float | None:
        """What is asked of a step [1], or `TOLERANCES`; None for integrators that know none."""
        return self.step_tolerance or TOLERANCES.get(self.integrator)

    @property
    def used_coordinates(self) -> str:
        """The coordinates of bodies held by joints, as chosen."""
        return self.coordinates or (MAXIMAL if self.integrator == "rk4" else AUTOMATIC)

    @property
    def stiffest_hertz(self) -> float:
        """The highest frequency [Hz] of a contact that a sub-step resolves."""
        return 0.25 * self.substeps / self.dt
