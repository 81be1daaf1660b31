"""How a world is solved."""

from dataclasses import dataclass

from plumbline.engine.describe.check import not_negative, positive, whole

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
CHOICES: dict[str, tuple[str | None, ...]] = {
    "integrator": INTEGRATORS,
    "broad_phase": (*BROAD_PHASES, None),
    "bounding_volume": BOUNDING_VOLUMES,
    "level_of_detail": (*LEVELS, None),
    "solver": SOLVERS,
    "sweeps": SWEEPS,
    "continuous": CONTINUOUS,
    "coordinates": (*COORDINATES, None),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
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

    dt: float = 1 / 240
    substeps: int = 4
    iterations: int = 2
    relaxations: int = 1
    integrator: str = "semi_implicit_euler"
    step_tolerance: float | None = None
    broad_phase: str | None = None
    bounding_volume: str = "aabb"
    level_of_detail: str | None = None
    threads: int = 1
    contact_hertz: float | None = None
    contact_damping_ratio: float = 10.0
    max_push: float = 3.0
    bounce_speed: float | None = None
    margin: float = 1e-3
    contacts: bool = True
    gyroscopic: bool = True
    continuous: str = "off"
    solver: str = "tgs_soft"
    tolerance: float = 1e-11
    effort: float = 50.0
    sleeping: bool = False
    sleep_speed: float = 1e-3
    sleep_time: float = 0.5
    coordinates: str | None = None
    sweeps: str = GAUSS_SEIDEL

    def __post_init__(self) -> None:
        positive("options", "dt", self.dt, "s")
        for name, least in (("substeps", 1), ("iterations", 1), ("relaxations", 0), ("threads", 1)):
            whole("options", name, getattr(self, name), least)
        for name, choices in CHOICES.items():
            if getattr(self, name) not in choices:
                expected = ", ".join(one for one in choices if one is not None)
                raise ValueError(f"options: {name} {getattr(self, name)!r}, expected one of {expected}")
        if self.step_tolerance is not None:
            if self.integrator not in TOLERANCES:
                raise ValueError(
                    f"options: step_tolerance {self.step_tolerance}, but integrator '{self.integrator}' does not adapt"
                )
            # Below 1e-14 the estimate is round-off, which no shorter step makes smaller.
            if not 1e-14 <= self.step_tolerance <= 1e-2:
                raise ValueError(f"options: step_tolerance {self.step_tolerance}, expected 1e-14..1e-2")
        positive("options", "tolerance", self.tolerance, "")
        positive("options", "effort", self.effort, "ms")
        if self.contact_hertz is not None:
            positive("options", "contact_hertz", self.contact_hertz, "Hz")
        not_negative("options", "contact_damping_ratio", self.contact_damping_ratio, "")
        positive("options", "max_push", self.max_push, "m/s")
        not_negative("options", "margin", self.margin, "m")
        if self.bounce_speed is not None:
            not_negative("options", "bounce_speed", self.bounce_speed, "m/s")
        positive("options", "sleep_speed", self.sleep_speed, "m/s")
        positive("options", "sleep_time", self.sleep_time, "s")

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
