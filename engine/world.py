"""A world of bodies, joints and surfaces: advance, read, cast rays into, save it (over 400 lines: one class, the interface)."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.articulated.assembly import grow_world, has_same_trees, motion_of, with_trees
from plumbline.engine.articulated.forest import chosen_forest
from plumbline.engine.broad.choice import choose_broad_phase, load_search, load_volume, search_pairs
from plumbline.engine.build.assembly import assemble_world, islands_know, may_touch, moves_meshes, spheres_only, wants_islands
from plumbline.engine.build.initial_rates import check_initial_rates, check_slenderness
from plumbline.engine.build.joint_order import elimination_order
from plumbline.engine.contact.points import Contacts, fit_impulses, manifold_points, sphere_points
from plumbline.engine.describe.bodies import Body, Surface
from plumbline.engine.describe.check import finite, number, whole
from plumbline.engine.describe.errors import Diverged, NotSupported
from plumbline.engine.describe.joints import Joint, Tendon
from plumbline.engine.describe.optics import Sun
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.status import CONVEX_PENDING, DIVERGED, DONE, FULL, OPEN_JOINT, SEARCH_PENDING, UNSOLVED
from plumbline.engine.options import COLOURED, GAUSS_SEIDEL, Options
from plumbline.engine.rays.cast import as_rays, cast_on_shapes
from plumbline.engine.rays.hits import Hits
from plumbline.engine.steps.choice import Kernels, choose_step, joint_coordinates_step, load_collide, load_sorting, unsmooth_of

if TYPE_CHECKING:
    from plumbline.engine.images.eye import Eye, Picture
    from plumbline.engine.images.paths import Paths
    from plumbline.engine.rays.tree import RayTree
    from plumbline.engine.respond.exact.steps import Certificate
    from plumbline.engine.swept.steps import Impacts

GEOMETRIES = ("collision", "visual")
RENDERERS = ("rasterised", "ray_traced")


class World:
    """A world whose stages are chosen, once, by what it contains.

    Args:
        bodies: as described; joints: likewise, with the tendons over their coordinates; names are unique. surfaces: the law of
        each pair of materials, in either order; other pairs are frictionless and do not bounce. gravity (3,) m/s2. options: how
        to solve. apart: pairs of materials that never touch. sun: the light that pictures are taken in.
    Raises: ValueError naming the element, field and value; NotSupported for open meshes that forces move or that are to be had
        at a level of detail, for swept collision of meshes that forces move, for an integrator of free bodies where there are
        joints or contacts, for initial velocities that a joint forbids, for bodies too thin for joints (`build.initial_rates`),
        for what the exact solver lacks, and for joints beside contacts where these are swept or solved by sequential impulses.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        joints: Sequence[Joint | Tendon] = (),
        surfaces: Mapping[tuple[str, str], Surface] | None = None,
        gravity: Sequence[float] = (0.0, 0.0, -9.81),
        options: Options | None = None,
        apart: Sequence[tuple[str, str]] = (),
        sun: Sun | None = None,
    ) -> None:
        self.options = options or Options()
        self._dt = self.options.dt
        if self.options.level_of_detail is not None:
            from plumbline.engine.build.level_of_detail import at_level

            bodies = at_level(bodies, self.options.level_of_detail)
        tendons = [each for each in joints if isinstance(each, Tendon)]
        joints = elimination_order(bodies, [each for each in joints if not isinstance(each, Tendon)])
        self.sun = sun or Sun()
        self.touching = self.options.contacts and may_touch(bodies)
        forest = chosen_forest(bodies, joints, self.options, self.touching, tendons)
        islands = self.touching and forest is None and wants_islands(bodies, joints, self.options)
        self._floats, self._ints = assemble_world(bodies, joints, surfaces or {}, gravity, self.options, apart, islands)
        check_initial_rates(bodies, joints)
        check_slenderness(bodies, joints)
        self._joint_names = [joint.name for joint in joints]
        self._joints = {name: j for j, name in enumerate(self._joint_names)}
        self._names = [body.name for body in bodies]
        kinds = at.int_table(self._ints, at.SHAPE_KIND)
        self._polyhedral = bool((kinds[:, at.TYPE] >= at.HULL).any())
        self.moving_meshes = any(moves_meshes(body) for body in bodies)
        self._tree: RayTree | None = None
        self._bodies = tuple(bodies)
        self._drawn = self if all(body.visual is None for body in bodies) else None
        self.jointed = bool(joints)
        self.spheres = self.touching and spheres_only(bodies, joints, surfaces or {}, self.options)
        self.broad_phase = choose_broad_phase(self.options.broad_phase, len(kinds))
        volume, threads = self.options.bounding_volume, self.options.threads
        self.sweeps = self.options.sweeps if self.touching else GAUSS_SEIDEL
        coloured = self.sweeps == COLOURED
        self._find_pairs = load_search(self.broad_phase, volume, len(kinds), threads, coloured) if self.touching else None
        self._drop_apart = load_volume(volume) if self.touching else None
        at.int_table(self._ints, at.COUNT)[0, at.BROAD] = int(self._find_pairs is not None)
        if self.touching and self.options.sleeping and not islands_know(self.options):
            raise NotSupported("sleep", "islands are known to the soft solver alone, without swept collision")
        self._sort_pairs = load_sorting(coloured)
        if self.sweeps != GAUSS_SEIDEL and (joints or self.options.sleeping or not islands_know(self.options)):
            raise NotSupported(f"sweeps '{self.sweeps}'", "the soft solver has them, without joints, sleep and swept collision")
        self._exact = None
        if self.touching and self.options.solver == "exact":
            from plumbline.engine.respond.exact.steps import ExactSteps

            self._exact = ExactSteps(self.options, (surfaces or {}).values(), joints)
        self.in_joint_coordinates = forest is not None
        unsmooth = unsmooth_of(joints)
        if forest is not None:
            self._floats, self._ints = with_trees(self._floats, self._ints, forest)
            self._step = joint_coordinates_step(self.touching, bool(forest.closing), self.options, unsmooth)
        else:
            self._step = self._exact or choose_step(self.touching, self.jointed, self.options, self.spheres, islands, unsmooth)
        self._swept = None
        if self.touching and self.options.continuous == "swept":
            if self.jointed or self._exact is not None:
                raise NotSupported(
                    f"swept collision with {'joints' if self.jointed else 'the exact solver'}",
                    "a step in parts is known to the soft solver and to sequential impulses, without joints",
                )
            if self.moving_meshes:
                raise NotSupported("swept collision of triangle meshes that forces move", "triangles at rest cross each other")
            from plumbline.engine.swept.steps import SweptSteps

            search = None if self._find_pairs is None else partial(search_pairs, self._find_pairs, self._drop_apart)
            self._step = self._swept = SweptSteps(self.options, self._step, search, len(self._names), len(kinds))

    @property
    def certificate(self) -> "Certificate | None":
        """What the exact solver certifies of all steps done so far; None where another solver, or none, was at work."""
        return None if self._exact is None else self._exact.certificate

    @property
    def impacts(self) -> "Impacts | None":
        """The impacts of all steps so far; None where collision is not swept."""
        return None if self._swept is None else self._swept.impacts

    @property
    def stages(self) -> tuple[str, ...]:
        """The stages that a step of this world runs."""
        collision = ("broad phase", "narrow phase", "contact solver") if self.touching else ()
        return ("integrator", *collision, *(("joints",) if self.jointed else ()))

    @property
    def substeps(self) -> int:
        """The parts in which dt is taken: one where rk4 advances all that there is, since nothing can touch."""
        return 1 if self.options.integrator == "rk4" and not self.touching else self.options.substeps

    @property
    def steps(self) -> int:
        """Steps done since the start."""
        return int(at.int_table(self._ints, at.COUNT)[0, at.STEPS])

    def step(self, count: int = 1) -> None:
        """Advance by count * dt in one compiled call.

        Raises: Diverged, ValueError for count < 0.
        """
        count = whole("world", "step count", count, 0)
        while count > 0:
            done, status = self._step(self._floats, self._ints, count)
            count -= done
            if status != DONE:
                self._resume(status)

    def retime(self, dt: float) -> None:
        """The length [s] of each step from the next one on, sub-steps dividing it; contacts are as stiff as it resolves, or
        as it was built where it resolves more.

        Raises: ValueError; NotSupported where bodies sleep.
        """
        if self.options.sleeping:
            raise NotSupported("steps of uneven lengths beside sleep", "sleeping contacts keep the impulses of their last step")
        self._dt = dt = number("world", "dt", dt)
        if dt <= 0.0:
            raise ValueError(f"world: dt {dt} s, expected above 0")
        setting = at.float_table(self._floats, self._ints, at.SETTING)[0]
        setting[at.DT] = setting[at.WHOLE_STEP] = dt
        for steps in (self._exact, self._swept):
            if steps is not None:
                steps.retime(dt)
        if self.touching and self._swept is None:
            fit_impulses(self._floats, self._ints, dt)

    def _resume(self, status: int) -> None:
        """Do what has to be done before a world that stopped with a status goes on. Raises: Diverged."""
        why = self.why_lost(status)
        if why:
            raise Diverged(self.steps, why)
        if status == CONVEX_PENDING:
            load_collide(self.moving_meshes)(self._floats, self._ints)
        if status == FULL or (status == SEARCH_PENDING and self._search() == FULL):
            self._floats, self._ints = grow_world(self._floats, self._ints, self.in_joint_coordinates)

    def why_lost(self, status: int) -> str:
        """Why a world that stopped with a status goes on no more; empty where it does."""
        if status == DIVERGED:
            return "the state is not finite"
        if status == UNSOLVED:
            return f"integrator '{self.options.integrator}' found no solution for so long a step"
        if status < OPEN_JOINT:
            return ""
        gap = at.float_table(self._floats, self._ints, at.SETTING)[0, at.OPEN_GAP]
        return f"joint '{self._joint_names[status - OPEN_JOINT]}' stays open by {gap:.3g} m or rad"

    def compile(self) -> None:
        """Compile, or load from the cache, every stage that a step may run, by taking one: for a world to be thrown away."""
        with suppress(Diverged):
            self.step(1)
        if self._swept is not None:
            self._swept.compile(self._floats, self._ints)
        if self._exact is not None:
            self._exact.compile(self._floats, self._ints)
        if self.touching and self._polyhedral:
            load_collide(self.moving_meshes)(self._floats, self._ints)

    def _search(self) -> int:
        """Find the pairs of the coming step. Returns: DONE, or FULL."""
        assert self._find_pairs is not None
        status = search_pairs(self._find_pairs, self._drop_apart, self._floats, self._ints)
        if status == DONE and self._sort_pairs is not None:
            self._sort_pairs(self._floats, self._ints)
        return status

    def state(self) -> Floats:
        """A view of the state (n, 13): p_WB 3 m, q_WB 4 (w, x, y, z), v_WB 3 m/s, w_WB 3 rad/s. Valid until the next step.

        In joint coordinates it follows from these: what is written there is lost.
        """
        return at.float_table(self._floats, self._ints, at.STATE)[:-1]

    def asleep(self) -> NDArray[np.bool_]:
        """Which bodies (n,) sleep."""
        if not (self.touching and self.options.sleeping):
            return np.zeros(len(self._names), bool)
        return at.int_table(self._ints, at.ISLAND)[:-1, at.ASLEEP] > 0

    def set_load(self, f_B_W: Any, tau_B_W: Any) -> None:
        """Apply forces (n, 3) N at the centres of mass and torques (n, 3) N m, in W, from now on. Raises: ValueError."""
        load = at.float_table(self._floats, self._ints, at.LOAD)
        force, torque = self._per_body("f_B_W", f_B_W, "N"), self._per_body("tau_B_W", tau_B_W, "N m")
        load[:-1, :3], load[:-1, 3:] = force, torque

    def _per_body(self, field: str, value: Any, unit: str) -> Floats:
        """One vector (n, 3) for each body. Raises: ValueError naming the first body whose vector is not finite."""
        n = len(self._names)
        try:
            return finite("world", field, value, (n, 3), unit)
        except ValueError:
            table = np.asarray(value)
            if table.shape == (n, 3) and table.dtype.kind == "f":
                bad = int((~np.isfinite(table)).any(axis=1).argmax())
                finite(f"body '{self._names[bad]}'", field, table[bad], (3,), unit)
            raise

    def add_force(self, body: int, f_W: Any, point_W: Any) -> None:
        """Add a force [N] at a point [m], both in W, to the load on a body: f at the centre of mass and (point - p_WB) x f.

        Raises: ValueError.
        """
        if whole("world", "body", body, 0) >= len(self._names):
            raise ValueError(f"world: body {body}, expected at most {len(self._names) - 1}")
        f, point = finite("world", "f_W", f_W, (3,), "N"), finite("world", "point_W", point_W, (3,), "m")
        load = at.float_table(self._floats, self._ints, at.LOAD)
        load[body, :3] += f
        load[body, 3:] += np.cross(point - self.state()[body, :3], f)

    def prescribe(self, body: int, v_WB: Any, w_WB: Any) -> None:
        """Give a kinematic body the velocities (3,) m/s and (3,) rad/s in W, which it keeps. Raises: ValueError."""
        if not 0 <= body < len(self._names) or self._bodies[body].motion != "kinematic":
            raise ValueError(f"world: body {body} is not kinematic, which a prescribed velocity is for")
        label = f"body '{self._names[body]}'"
        row = self.state()[body]
        velocity, spin = finite(label, "v_WB", v_WB, (3,), "m/s"), finite(label, "w_WB", w_WB, (3,), "rad/s")
        row[at.V : at.V + 3], row[at.W : at.W + 3] = velocity, spin

    def command(self, joint: str, target: float, target_velocity: float | None = None) -> None:
        """Set the target [rad or m] of a drive, and its target velocity unless None. Raises: ValueError without a drive."""
        j = self._joints.get(joint)
        if j is None or not at.int_table(self._ints, at.JOINT_KIND)[j, at.HAS] & at.HAS_DRIVE:
            raise ValueError(f"joint '{joint}': has no drive to command")
        row = at.float_table(self._floats, self._ints, at.JOINT)[j]
        row[at.DRIVE + 2] = finite(f"joint '{joint}'", "target", target, (), "rad or m")
        if target_velocity is not None:
            row[at.DRIVE + 3] = finite(f"joint '{joint}'", "target_velocity", target_velocity, (), "rad/s or m/s")

    def reaction(self, joint: str) -> Floats:
        """What a joint carried over the last step, springs and drives included: force [N] and torque [N m], (6,), on its child.

        The mean over the step, in W, about the child's anchor (of a fixed joint, its centre of mass); NaN before any step.
        Raises: ValueError for an unknown joint.
        """
        if joint not in self._joints:
            raise ValueError(f"joint '{joint}': not in this world, expected one of {', '.join(self._joint_names)}")
        if self.steps == 0:
            return np.full(6, np.nan)
        total = at.float_table(self._floats, self._ints, at.JOINT)[self._joints[joint], at.REACTION : at.REACTION + 6]
        mean: Floats = total / self._dt
        return mean

    def joint_motion(self, joint: str) -> tuple[float, float]:
        """The coordinate [rad or m] of a hinge or slide, turns counted, and its rate; NaN outside of joint coordinates."""
        return motion_of(self._floats, self._ints, self._joints[joint]) if self.in_joint_coordinates else (math.nan, math.nan)

    def contacts(self) -> Contacts:
        """The contact points of the last step, with the force of the whole step; of a swept one, those of all its parts."""
        count = int(at.int_table(self._ints, at.COUNT)[0, at.MANIFOLDS]) if self.touching else 0
        points = sphere_points if self.spheres else manifold_points
        last = points(self._floats, self._ints, count, self.options.margin, self._dt)
        return last if self._swept is None else self._swept.joined(last)

    def cast(
        self, origins: Any, directions: Any, max_range: float = np.inf, *, geometry: str = "collision", threads: int = 1
    ) -> Hits:
        """The first hit of each ray within max_range [m].

        Args:
            origins (r, 3) m, or (3,) for all rays; directions (r, 3), of any length; both in W. Neighbouring rays are faster
            when they are alike, row by row in an image or a scan. geometry: 'collision' or 'visual', the shapes that a body is
            drawn with.
        Raises: ValueError for shapes that do not fit, values that are not finite, a direction of length zero, or other choices.
        """
        if geometry not in GEOMETRIES or threads < 1:
            expected = f"{' or '.join(GEOMETRIES)}, at least 1"
            raise ValueError(f"rays: geometry '{geometry}', threads {threads}, expected {expected}")
        if not number("rays", "max_range", max_range) >= 0:
            raise ValueError(f"rays: max_range {max_range} m, expected at least 0")
        if geometry == "visual" and self._drawn is not self:
            return self._as_drawn().cast(origins, directions, max_range, threads=threads)
        o, d = as_rays(origins, directions)
        hits = cast_on_shapes(self._floats, self._ints, o, d, float(max_range), threads)
        if self._polyhedral:
            from plumbline.engine.rays.polyhedra import cast_on_polyhedra
            from plumbline.engine.rays.tree import ray_tree

            self._tree = tree = self._tree or ray_tree(self._floats, self._ints)
            cast_on_polyhedra(self._floats, self._ints, tree, o, d, float(max_range), hits)
        return hits

    def render(self, eye: "Eye", method: str = "rasterised", colour: bool = True, threads: int = 1) -> "Picture":
        """What an eye sees of the visual shapes.

        Args: method: 'rasterised', a z-buffer that knows sun and sky but no shadow, mirror or glass; or 'ray_traced', with
            hard shadows, mirrors and refraction. There all bodies keep the sun off, clear ones too, and no light comes from
            the sun by mirrors or through glass. colour: whether colours are wanted. threads: of the rays.
        Raises: ValueError for another method, or a lens that shows nothing at some pixel; NotSupported for a lens of a
            rasterised picture.
        """
        if method not in RENDERERS:
            raise ValueError(f"picture: method '{method}', expected {' or '.join(RENDERERS)}")
        from plumbline.engine.images.draw import rasterised, ray_traced

        drawn = self._as_drawn()
        if method == "rasterised":
            return rasterised(drawn._floats, drawn._ints, self._bodies, self.sun, eye, colour)
        return ray_traced(partial(drawn.cast, threads=threads), self._bodies, self.sun, eye, colour)

    def trace(self, origins: Any, directions: Any, bounces: int = 12) -> "Paths":
        """The ways of rays of light with origins (r, 3) m and directions (r, 3), over mirrors and through clear solids.

        Raises: ValueError as `cast`.
        """
        from plumbline.engine.images.paths import traced_paths

        o, d = as_rays(origins, directions)
        return traced_paths(self._as_drawn().cast, self._bodies, o, d, whole("rays", "bounces", bounces, 0))

    def _as_drawn(self) -> "World":
        """A world of the bodies with their visual shapes, where they are now."""
        if self._drawn is None:
            self._drawn = World(
                [replace(body, shapes=body.looks, visual=None, motion="kinematic") for body in self._bodies],
                options=Options(contacts=False),
            )
        self._drawn.state()[:] = self.state()
        return self._drawn

    def save(self) -> tuple[Floats, Ints]:
        """All that decides the future, bit for bit, warm-start impulses included."""
        return self._floats.copy(), self._ints.copy()

    def restore(self, saved: tuple[Floats, Ints]) -> None:
        """Back to a saved state of this world. Raises: ValueError for that of a world with other bodies, shapes or joints."""
        columns = [at.BODIES, at.SHAPES, at.JOINTS]
        got, own = (at.int_table(ints, at.COUNT)[0, columns].tolist() for ints in (saved[1], self._ints))
        if got != own or (self.in_joint_coordinates and not has_same_trees(self._ints, saved[1])):
            raise ValueError(f"world: saved state of {got} bodies, shapes and joints, expected {own} in the same coordinates")
        self._floats, self._ints = saved[0].copy(), saved[1].copy()

    def adopt(self, floats: Floats, ints: Ints) -> None:
        """Work in this memory from now on, which holds a saved state of this world."""
        self._floats, self._ints = floats, ints

    @property
    def kernels(self) -> Kernels:
        """The compiled functions that advance this world in its memory."""
        return Kernels(self._step, self._find_pairs, self._drop_apart, self.moving_meshes)
