"""MuJoCo through its own Python package: generalised coordinates, soft convex contacts, one native call for many steps.

Tried with mujoco 4.0.0. Bodies hang in a forest of native joints, so that those have no gap; joints that close a loop become
equality constraints, distances become tendons. Each body's own frame M stands at the centre of mass along the principal axes.

Sources (MuJoCo documentation, by chapter): "Computation": numerical integration, constraint model, contact; "Modeling": solver
parameters, contact parameters, preventing slip; "Simulation": state and control, diagnostics; change log of 4.0.0 and 4.0.1.

Deviations:

* Contacts, limits and loop joints are soft: a body at rest sinks by micrometres, one that lands sinks by about speed times time
  constant, and a loop has a gap. A contact under friction creeps.
* There is no coefficient of restitution. For e > 0 the contact becomes a spring and damper whose damping ratio is solved
  for, on the discrete recursion that the engine steps, so that the mean rebound over all phases of the step is e; single
  rebounds scatter by the phase (about .02 at e = .5) and the body sinks in by about 3 v dt. An e > 0 below the least rebound of
  that family (about .03) is `Unsupported`; e = 0 keeps the usual contact, which is critically damped and cannot pull, so that
  a body that nothing presses down leaves with up to e^-2 = .135 of its speed. The law is exact for one point between a free
  body and a fixed one, and approximate where several contacts share a body. The discrete integrator damps every rebound:
  `Unsupported`.
* Friction with restitution needs the elliptic cone, whatever the track: a pyramid mixes the rebound into the friction. On
  the cone a slip still bends the rebound, while friction stays mu times the normal force. Measured with mu .1 to 1 at 1e-3: a
  slip up to the speed of approach by 5 %, up to three times that by -20..+13 % at e >= .5 and up to +43 % at e = .3; at ten
  times it by -25..+70 % and up to +154 %, at thirty times up to +137 % and +261 %. Neither impratio nor the slip correction
  changes that; a slower friction does (`friction_steps`), but stops less of the slip: as it is, a grip leaves up to e^-2 =
  .135 of it. A longer impact does too (`rebound_steps`): askew at e = .6 and mu = .3, 1/240 s, the worst of seven balls errs by
  .104 of the speed of approach with ten steps of either, by .084 with 40 and 60; heights of bounces err least with ten.
* Springs and drives in a scene where bodies can touch, and elsewhere those that swing by more than 1.5 rad a step, are stepped
  by the discrete integrator on tuned: it rests where the implicit one jitters, stands where that one blows up, and damps. An
  arm of 3, 2 and 1 kg on drives of 200 N m/rad and 2 N m s/rad, touching nothing, errs by .016 rad after .25 s at 1/240, by
  Euler .010, implicitfast .005.
* Sliding, torsional and rolling friction share one cone, so that each takes from the others; a coefficient below 1e-5 counts as
  1e-5 where another one is above zero.
* Friction is soft. With its time constant tc (on tuned the contact's, 20 ms at most), what slips by less than mu g tc/2 under
  its own weight is rubbed by a damper, 2 m v/tc; what slips faster by mu N, where N exceeds the weight by m (2 v/tc - mu g)
  mu/(1 + mu^2), so that it lifts. Neither impratio, the slip correction nor the tolerance changes that. `friction_steps` of
  2/mu rubs in full from a slip of g dt on, but lifts more (a cube at 3 m/s hops 19 to 37 mm for 1.4 to 2.4), and where balls
  slip it errs up to four times as much. So tuned lacks .01 to .2 of the weight of cubes at worst at 1/480 s and below, and up
  to 1.1 where balls roll against friction or on a turntable.
* The gyroscopic term is part of the bias force and cannot be switched off.
* Convex hulls and meshes are stored in single precision. A mesh collides as its hull: `Unsupported` in contact if concave.
* A kinematic body has an armature 1e12 times the mass of the scene: forces move it by that share. A joint between two bodies
  that are fixed to each other anyway lets them not collide.
* Damping of a body inside a joint tree is `Unsupported` unless its motion is that of one coordinate of its own.
* A revolute joint that closes a loop is held at two points of its axis, which is one constraint more than it needs.
* Images are rasterised: round shapes are polyhedra, depth is a single-precision buffer, colours have 8 bits, nothing casts
  a shadow, and what a surface mirrors or lets through is taken to be the sky.
* `contacts` are those that the last step was made with, at its start; under RK4 those of its last stage.

No knobs, though documented, tried over pendulums, loops, stops, impacts, friction, stacks and tunnelling at half the step of
each case: ls_tolerance, ccd_iterations, ccd_tolerance, multiccd, island and warmstart change no answer by more than rounding;
fewer ls_iterations lose a turntable; nativeccd off lets pass what must not; eulerdamp off errs by a third more; diagexact errs
four times as much under a mass ratio and opens a loop; refsafe off means nothing but below two steps, or one with the discrete
integrator. noslip_tolerance ends what noslip_iterations end too. The override (o_solref, o_solimp) says again what each contact
is told; margin and gap move the surface; the width of solimp means nothing at constant impedance; sleep, wind and fluids no
scene asks for; `speculative` follows the scene.
"""

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache
from itertools import pairwise
from typing import Any, assert_never

import numpy as np

from harness.adapter import Adapter, Diverged, Emulation, Feature, Settings, SettingsError, Unavailable, Unsupported
from harness.adapter.what_goes_in import check_rays, check_state, check_targets, check_wrench
from harness.scene import (
    WORLD,
    Ball,
    Body,
    Box,
    Camera,
    Capsule,
    ConvexHull,
    Cylinder,
    Distance,
    Effect,
    Fixed,
    Imu,
    Joint,
    Limits,
    PlacedShape,
    Plane,
    Prismatic,
    Revolute,
    Scene,
    Sphere,
    Surface,
    TriangleMesh,
    Vector3,
    multiply,
    rotation_matrix,
)
from harness.trajectory import Contacts, Floats, Hits, Image, Integers, State

__all__ = ["ADAPTER", "MujocoAdapter", "MujocoSimulation"]

INTEGRATORS = ("discrete", "euler", "rk4", "implicitfast", "implicit")
"""A search that turns a knob to the next value meets the discrete one beside Euler, and RK4 where that is refused."""
SOLVERS = ("pgs", "cg", "newton")
VENDOR_TIME_CONSTANT = 0.02
"""The time constant of MuJoCo's constraints [s] (solref[0])."""
LEAST_STEPS = 2.0
"""Time constants below this number of steps are raised to it by the engine, unless its integrator is the discrete one.

Source: MuJoCo, "Modeling", solver parameters; XML reference, option/flag/refsafe (the discrete integrator replaces what no step
resolves, time constant times damping ratio below a step, by the stiffest row that does not rebound).
"""
REBOUND_IMPEDANCE = 0.9999
"""Impedance of a contact that rebounds: its reference acceleration is taken as it is, with next to nothing of gravity."""
OPEN = 1e10
"""A bound that no coordinate reaches: MuJoCo calls a state above it diverged (mjMAXVAL)."""
KINEMATIC_ARMATURE = 1e12
"""Inertia of a kinematic body over that of all movable ones: a force then changes its velocity by rounding."""
RESOLVED_RATE = 0.1
"""Largest rate times step of a spring or damper that Euler is given in a scene with contacts: about 60 steps a period."""
RK4_RATE = 2.0
"""Largest rate |lambda| h of springs, dampers and drives that RK4 is given.

For a damper, z = -lambda h: RK4 multiplies by R(-z) = 1 - z + z^2/2 - z^3/6 + z^4/24, the implicit rule by 1/(1 + z), the
truth by e^-z; RK4 is the nearer one up to z = 2, where both say 1/3. For a spring it is so wherever both are stable.
The half disc |z| <= 2.6 of decaying motion lies in RK4's region of stability (2.785 on the real axis, 2.828 on the imaginary
one), so that at 2 rates may be off by a factor of 1.3.
"""
SPRING_RATE = 1.5
"""Largest rate w h of undamped springs and drives that the velocity-implicit rule is given: it takes positions explicitly.

Source: MuJoCo, "Computation", numerical integration: stable up to w h = 2; the discrete integrator alone is implicit in
position, stable at any step, and more damped below the limit. Over a step of w h = z the velocity-implicit rule (cos a =
1 - z^2/2) errs by 2 sin((a - z)/2), the discrete one by |1/(1 + i z) - e^(-i z)|: .20 against .59 at 1.5, equal at 1.96. At 1.5
rates may be off by a factor of 1.3, as for RK4.
"""
EXACT_ROWS = 200
"""Springs and dampers up to which their fastest mode is found exactly rather than bounded."""
RATE_SAMPLES = 16
"""Configurations at which the rates are read off besides the first one: joint-space inertia changes with the configuration."""
FAULTY_SPARSE = "4.0.0"
"""The version whose sparse factor of the Newton solver its makers call wrong (change log of 4.0.1)."""
DENSE_LIMIT = 1200
"""Coordinates up to which the dense factor is taken instead: its cost grows with their cube, its memory with their square."""
FATAL = slice(3, 6)
"""Places of BADQPOS, BADQVEL and BADQACC among mjData's warning counters."""
SLICES = 192
"""Corners of a drawn circle: a sphere is off by up to (1 - cos(pi/192)) of its radius, about 1.3e-4."""
COLLISION_GROUP, BOTH_GROUP, VISUAL_GROUP = 1, 0, 2
"""Geom groups: rays see shapes that collide, images see shapes that are drawn."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Options:
    """`Settings.options`; None is the vendor's default.

    Terms:
        by_scene: choose integrator and Jacobian by the scene where the settings leave them open.
        cone: 'pyramidal' or 'elliptic'. impratio: friction over normal stiffness. jacobian: 'dense', 'sparse', 'auto'.
        noslip_iterations, ls_iterations: of the slip correction and the line search.
        contact_steps: time constant of contacts without restitution in steps.
        contact_damping_ratio, contact_impedance: of the same.
        friction_steps: time constant of friction in steps, where it has rows of its own: on the elliptic cone, which friction
        with restitution always takes. None: as long as the impact with restitution, that of the contact without.
        limit_steps, limit_damping_ratio, limit_impedance: of the limits of joints and rods.
        loop_steps, loop_impedance: time constant in steps and impedance of loop joints and rods.
        slowest: what no time constant told in steps exceeds [s], but for rebounds; `resolved` says those that are used.
        rebound_steps: duration of an elastic impact in steps.
        refsafe, multiccd, nativeccd, island, warmstart, diagexact: flags of the engine. speculative: None follows the scene.
    """

    by_scene: bool = False
    cone: str | None = None
    impratio: float | None = None
    jacobian: str | None = None
    noslip_iterations: int | None = None
    ls_iterations: int | None = None
    contact_steps: float | None = None
    contact_damping_ratio: float | None = None
    contact_impedance: float | None = None
    limit_steps: float | None = None
    limit_damping_ratio: float | None = None
    limit_impedance: float | None = None
    loop_steps: float | None = None
    loop_impedance: float | None = None
    slowest: float | None = None
    rebound_steps: int = 10
    friction_steps: float | None = None
    refsafe: bool | None = None
    multiccd: bool | None = None
    nativeccd: bool | None = None
    island: bool | None = None
    warmstart: bool | None = None
    diagexact: bool | None = None
    speculative: bool | None = None


def _number(low: float, high: float) -> tuple[Callable[[Any], bool], str]:
    return lambda v: isinstance(v, int | float) and not isinstance(v, bool) and low <= v <= high, f"a number {low:g}..{high:g}"


def _integer(low: int, high: int) -> tuple[Callable[[Any], bool], str]:
    return lambda v: isinstance(v, int) and not isinstance(v, bool) and low <= v <= high, f"an integer {low}..{high}"


def _one_of(*names: str) -> tuple[Callable[[Any], bool], str]:
    return lambda v: v in names, f"one of {', '.join(names)}"


_TRUTH: tuple[Callable[[Any], bool], str] = (lambda v: isinstance(v, bool), "true or false")
_BOUNDS: Mapping[str, tuple[Callable[[Any], bool], str]] = {
    "cone": _one_of("pyramidal", "elliptic"),
    "impratio": _number(1e-3, 1e6),
    "jacobian": _one_of("dense", "sparse", "auto"),
    "noslip_iterations": _integer(0, 10_000),
    "ls_iterations": _integer(1, 10_000),
    "contact_steps": _number(0.01, 1e6),
    "contact_damping_ratio": _number(1e-3, 1e3),
    "contact_impedance": _number(0.001, 0.9999),
    "limit_steps": _number(2, 1e6),
    "limit_damping_ratio": _number(1e-3, 1e3),
    "limit_impedance": _number(0.001, 0.9999),
    "loop_steps": _number(2, 1e6),
    "loop_impedance": _number(0.001, 0.9999),
    "slowest": _number(1e-9, 1e6),
    "rebound_steps": _integer(4, 1000),
    "friction_steps": _number(0.01, 1e6),
}


def _options(settings: Settings) -> _Options:
    """The options, each checked; raises SettingsError."""
    known = {one.name for one in fields(_Options)}
    for name, value in settings.options.items():
        if name not in known:
            raise SettingsError(f"settings: option '{name}' is unknown to MuJoCo, expected some of {', '.join(sorted(known))}")
        holds, expected = _BOUNDS.get(name, _TRUTH)
        if value is not None and not holds(value):
            raise SettingsError(f"settings: option '{name}' is {value!r}, expected {expected}")
    for field, names in (("integrator", INTEGRATORS), ("solver", SOLVERS)):
        asked = getattr(settings, field)
        if asked is not None and asked not in names:
            raise SettingsError(f"settings: {field} '{asked}' is unknown to MuJoCo, expected one of {', '.join(names)}")
    return _Options(**{name: value for name, value in settings.options.items() if value is not None})


def _mujoco() -> Any:
    """The vendor's package, with its log file and console lines off: `warnings` and `Diverged` say the same."""
    try:
        import mujoco
    except (ImportError, OSError) as error:
        raise Unavailable(f"mujoco cannot be imported ({error}); pip install mujoco") from error
    log = mujoco.MjLogConfig.get()
    if log.logto_file or log.logto_console:
        log.logto_file = log.logto_console = False
        log.set()
    return mujoco


def _flag(mj: Any, kind: str, name: str) -> int:
    return int(getattr(getattr(mj, kind), name))


# -- Simulation ----------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Places:
    """Where the scene's bodies, shapes and drives stand in the compiled model.

    Terms:
        body (n,): MuJoCo's body of each body of the scene. scene_body (nbody,): the way back, -1 for the world.
        q_MB (n, 4): from B to the principal frame M, or None where all of them agree. single: no body hangs on another one.
        drives: actuator by joint. inertial: places of accelerometer and gyroscope in the sensor data, by sensor.
        remarks: effects that could not be left out, known faults.
    """

    body: Integers
    scene_body: Integers
    q_MB: Floats | None
    single: bool
    drives: Mapping[str, int]
    inertial: Mapping[str, tuple[int, int]]
    remarks: tuple[str, ...]


class MujocoSimulation:
    """One scene in one `MjData`."""

    def __init__(self, mj: Any, model: Any, scene: Scene, settings: Settings, resolved: Settings, places: _Places) -> None:
        self._mj, self._m, self._scene = mj, model, scene
        self._d = mj.MjData(model)
        self._resolved, self._places = resolved, places
        self._substeps = settings.substeps or 1
        self._advance = mj.mj_step
        self._numbers = self._d.warning.number
        self._clean = self._numbers.tobytes()
        self._movable = np.array([k for k, b in enumerate(scene.bodies) if b.movable], dtype=np.int64)
        self._root = model.body_rootid[places.body]
        self._window: tuple[Any, Any, Any] | None = None
        self._felt: Any = None

    @property
    def resolved(self) -> Settings:
        """The settings read back from the compiled model."""
        return self._resolved

    @property
    def force_lead(self) -> float:
        """RK4 moves exactly under a force that it holds; the others go x + v dt + (k + 1)/(2 k) f dt^2 in k sub-steps."""
        if self._m.opt.integrator == _flag(self._mj, "mjtIntegrator", "mjINT_RK4"):
            return 0.5
        return (self._substeps - 1) / (2 * self._substeps)

    def step(self, count: int = 1) -> None:
        """Advance by count * dt in one native call. Raises: Diverged."""
        self._advance(self._m, self._d, count * self._substeps)
        # One comparison of bytes is all that a step pays for being watched.
        if self._numbers.tobytes() != self._clean:
            self._examine()

    def _examine(self) -> None:
        if self._numbers[FATAL].any():
            raise Diverged(f"NaN, Inf or a value above {OPEN:g} ({'; '.join(self._counted())}) by time {self._d.time:.9g} s")
        self._clean = self._numbers.tobytes()

    def _counted(self) -> list[str]:
        names = ("INERTIA", "CONTACTFULL", "CNSTRFULL", "BADQPOS", "BADQVEL", "BADQACC", "BADCTRL")
        return [f"{name} x{number}" for name, number in zip(names, self._numbers, strict=True) if number]

    def _pose(self) -> None:
        """Poses and velocities of the present coordinates; `mj_step` leaves those of before the step and computes them anew."""
        self._mj.mj_kinematics(self._m, self._d)
        self._mj.mj_comPos(self._m, self._d)
        self._mj.mj_comVel(self._m, self._d)

    def state(self, out: State) -> None:
        """Write p_WB, q_WB, v_WB and w_WB."""
        check_state(len(self._places.body), out)
        self._pose()
        d, body = self._d, self._places.body
        out.p_WB[:] = d.xpos[body]
        q_WM, q_MB = d.xquat[body], self._places.q_MB
        out.q_WB[:] = q_WM if q_MB is None else _product(q_WM, q_MB)
        motion = d.cvel[body]
        out.w_WB[:] = motion[:, :3]
        out.v_WB[:] = motion[:, 3:]
        if not self._places.single:
            # cvel belongs to the point that lies at the centre of mass of the whole tree.
            out.v_WB[:] += _cross(motion[:, :3], d.xpos[body] - d.subtree_com[self._root])

    def contacts(self) -> Contacts:
        """The contacts of the last step with their forces on B."""
        mj, m, d = self._mj, self._m, self._d
        k = d.ncon
        if not k:
            return Contacts.none()
        contact = d.contact
        force, one = np.zeros((k, 3)), np.zeros(6)
        frame = np.array(contact.frame).reshape(k, 3, 3)
        for place in range(k):
            mj.mj_contactForce(m, d, place, one)
            force[place] = one[:3] @ frame[place]
        body = self._places.scene_body[m.geom_bodyid[np.array(contact.geom).reshape(k, 2)]]
        return Contacts.of(body[:, 0], body[:, 1], np.array(contact.pos), frame[:, 0], np.array(contact.dist), force)

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hit of each ray, one native call for each run of equal origins."""
        m = self._m
        geom, distance, normal = self.caster(origins, directions, max_range)()
        # The engine's cutoff leaves out whole shapes, not hits.
        hit = (geom >= 0) & (distance >= 0) & (distance <= max_range)
        body = np.where(hit, self._places.scene_body[m.geom_bodyid[np.where(hit, geom, 0)]] if m.ngeom else -1, -1)
        return Hits(np.where(hit, distance, np.inf), body.astype(np.int64), np.where(hit[:, None], normal, 0.0))

    def caster(self, origins: Floats, directions: Floats, max_range: float) -> Callable[[], tuple[Any, Floats, Floats]]:
        """A function that casts these rays and gives geoms (r,), distances (r,) m, -1 for none, and normals (r, 3)."""
        check_rays(origins, directions, max_range)
        mj, m, d = self._mj, self._m, self._d
        start = np.ascontiguousarray(origins, dtype=np.float64)
        ray = np.ascontiguousarray(directions, dtype=np.float64)
        r = len(ray)
        geom, distance, normal = np.full(r, -1, dtype=np.int32), np.full(r, -1.0), np.zeros((r, 3))
        seen = np.array([group in (BOTH_GROUP, COLLISION_GROUP) for group in range(6)], dtype=np.uint8)
        turns = np.flatnonzero((start[1:] != start[:-1]).any(axis=1)) + 1
        parts = [
            (start[a], ray[a:b].reshape(-1), geom[a:b], distance[a:b], normal[a:b].reshape(-1), b - a)
            for a, b in pairwise([0, *turns.tolist(), r] if r else [])
        ]

        def cast() -> tuple[Any, Floats, Floats]:
            mj.mj_kinematics(m, d)
            for origin, rays, geoms, distances, normals, count in parts:
                mj.mj_multiRay(m, d, origin, rays, seen, True, -1, geoms, distances, normals, count, max_range)
            return geom, distance, normal

        return cast

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """By OpenGL on EGL: depth and bodies in one pass, where every geom has a number for its colour; colours in another."""
        if camera.renderer != "rasterised":
            raise Unsupported(f"ray-traced image of camera '{camera.name}'", "MuJoCo draws by OpenGL's z-buffer alone")
        mj = self._mj
        gl, _, view = self._surface(camera)
        gl.make_current()
        self._pose()
        drawn = mj.MjvOption()
        drawn.geomgroup[:] = [group in (BOTH_GROUP, VISUAL_GROUP) for group in range(6)]
        mj.mjv_updateScene(self._m, self._d, drawn, None, mj.MjvCamera(), mj.mjtCatBit.mjCAT_ALL.value, view)
        near, far = 0.01, max(100.0, 50 * float(self._m.stat.extent))
        self._aim(view, camera, near, far)
        raw, numbers = self._pass(camera, numbered=True)
        # The buffer holds reversed z: 1 at `near`, 0 at `far` and where nothing was drawn.
        with np.errstate(divide="ignore"):
            depth = np.where(raw > 0, near * far / (near + raw * (far - near)), np.inf)
        owner = np.full(view.maxgeom + 1, -1, dtype=np.int64)
        for geom in view.geoms[: view.ngeom]:
            owner[geom.segid + 1] = self._places.scene_body[self._m.geom_bodyid[geom.objid]]
        body = owner[numbers.astype(np.int64) @ (1, 256, 65536)]
        return Image(depth, np.where(raw > 0, body, -1), self._painted(camera, body) if colour else None)

    def _pass(self, camera: Camera, numbered: bool) -> tuple[Floats, Any]:
        """Draw the scene: the depth buffer (h, w) and the colours (h, w, 3) of 8 bits, from the top down."""
        mj = self._mj
        assert self._window is not None
        _, context, view = self._window
        view.flags[mj.mjtRndFlag.mjRND_SEGMENT] = view.flags[mj.mjtRndFlag.mjRND_IDCOLOR] = int(numbered)
        rectangle = mj.MjrRect(0, 0, camera.width, camera.height)
        depth, colour = (
            np.zeros((camera.height, camera.width), np.float32),
            np.zeros((camera.height, camera.width, 3), np.uint8),
        )
        mj.mjr_render(rectangle, view, context)
        mj.mjr_readPixels(colour, depth, rectangle, context)
        return depth[::-1].astype(np.float64), colour[::-1]

    def _painted(self, camera: Camera, body: Integers) -> Floats:
        """Linear colours under the scene's sun and sky, without shadows; what does not scatter shows the sky.

        OpenGL adds and multiplies plain numbers in 0..1, so the light is scaled down to that and the picture up again.
        """
        assert self._window is not None
        view, sun = self._window[2], self._scene.sun
        direct, looks = sun.irradiance / math.pi, [one.appearance for one in self._scene.bodies]
        scale = max(direct + sun.sky, 1e-300)
        for geom in view.geoms[: view.ngeom]:
            look = looks[self._places.scene_body[self._m.geom_bodyid[geom.objid]]]
            geom.rgba[:] = (*(look.scatters * share for share in look.colour), 1.0)
            geom.emission = geom.specular = geom.shininess = geom.reflectance = 0.0
        view.nlight, light = 1, view.lights[0]
        light.type, light.headlight, light.castshadow = self._mj.mjtLightType.mjLIGHT_DIRECTIONAL, 0, 0
        light.dir[:] = -np.array(sun.towards_W)
        light.ambient[:], light.diffuse[:], light.specular[:] = sun.sky / scale, direct / scale, 0.0
        _, shades = self._pass(camera, numbered=False)
        through = np.array([*(1.0 - look.scatters for look in looks), 1.0])[body]
        painted: Floats = np.where((body >= 0)[..., None], shades * (scale / 255.0), 0.0) + (sun.sky * through)[..., None]
        return painted

    def _surface(self, camera: Camera) -> tuple[Any, Any, Any]:
        mj, buffer = self._mj, self._m.vis.global_
        if self._window is not None and camera.width <= buffer.offwidth and camera.height <= buffer.offheight:
            return self._window
        self._free_window()
        # One sample a pixel: the depth of several is that of any of them. Spheres are drawn as polyhedra, here fine ones.
        quality = self._m.vis.quality
        quality.offsamples, quality.numslices, quality.numstacks = 0, SLICES, SLICES // 2
        buffer.offwidth, buffer.offheight = max(camera.width, buffer.offwidth), max(camera.height, buffer.offheight)
        try:
            from mujoco.egl import GLContext

            gl = GLContext(buffer.offwidth, buffer.offheight)
            gl.make_current()
            context = mj.MjrContext(self._m, mj.mjtFontScale.mjFONTSCALE_100.value)
            mj.mjr_setBuffer(mj.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
        except Exception as error:
            raise Unsupported(
                "render", f"no OpenGL context through EGL on this machine ({type(error).__name__}: {error})"
            ) from error
        context.readDepthMap = mj.mjtDepthMap.mjDEPTH_ZEROFAR
        view = mj.MjvScene(self._m, max(1000, 2 * self._m.ngeom + 100))
        for effect in ("SHADOW", "REFLECTION", "HAZE", "FOG", "SKYBOX"):
            view.flags[getattr(mj.mjtRndFlag, f"mjRND_{effect}")] = 0
        self._window = (gl, context, view)
        return self._window

    def _aim(self, view: Any, camera: Camera, near: float, far: float) -> None:
        """The pinhole of `camera`: along +z of S, x right, y down."""
        p_WB, q_WB = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
        if camera.body != WORLD:
            place = self._scene.index(camera.body)
            body = self._places.body[place]
            p_WB, q_WB = self._d.xpos[body], self._d.xquat[body]
            if self._places.q_MB is not None:
                q_WB = _product(q_WB[None], self._places.q_MB[place][None])[0]
        R_WB = _matrix(q_WB)
        R_WS = R_WB @ _matrix(camera.q_BS)
        left, right = -camera.centre_x / camera.focal_x * near, (camera.width - camera.centre_x) / camera.focal_x * near
        for eye in view.camera:
            eye.pos[:], eye.forward[:], eye.up[:] = p_WB + R_WB @ camera.p_BS, R_WS[:, 2], -R_WS[:, 1]
            eye.frustum_near, eye.frustum_far = near, far
            eye.frustum_center, eye.frustum_width = (left + right) / 2, (right - left) / 2
            eye.frustum_top = camera.centre_y / camera.focal_y * near
            eye.frustum_bottom = -(camera.height - camera.centre_y) / camera.focal_y * near

    def inertial(self, name: str) -> tuple[Floats, Floats]:
        """Specific force [m/s2] and angular velocity [rad/s] in S, each (3,), by MuJoCo's own sensors at this instant.

        `mj_step` leaves what sensors said before the step; a forward pass here would move the warm start of the next one. So
        the pass is made on a copy, under the forces, the wrench included, that the present state has been told.
        """
        mj, m = self._mj, self._m
        if name not in self._places.inertial:
            raise ValueError(f"inertial: '{name}', expected one of {', '.join(self._places.inertial) or 'none'}")
        if self._felt is None:
            self._felt = mj.MjData(m)
        kind = _flag(mj, "mjtState", "mjSTATE_INTEGRATION")
        state = np.empty(mj.mj_stateSize(m, kind))
        mj.mj_getState(m, self._d, state, kind)
        mj.mj_setState(m, self._felt, state, kind)
        without = m.opt.disableflags
        needed = _flag(mj, "mjtDisableBit", "mjDSBL_SENSOR")
        if Effect.GRAVITY not in self._scene.narrow:
            # Where nothing can fall the effect is left out of the steps, but what stands still feels its support.
            needed |= _flag(mj, "mjtDisableBit", "mjDSBL_GRAVITY")
        m.opt.disableflags = without & ~needed
        try:
            mj.mj_forward(m, self._felt)
        finally:
            m.opt.disableflags = without
        force, rate = self._places.inertial[name]
        said = self._felt.sensordata
        return said[force : force + 3].copy(), said[rate : rate + 3].copy()

    def command(self, targets: Mapping[str, float]) -> None:
        """Set the targets of drives [rad or m]."""
        check_targets(self._scene, targets)
        for name, target in targets.items():
            if name in self._places.drives:
                self._d.ctrl[self._places.drives[name]] = target

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Force [N] at the centre of mass and torque [N m] in W on every movable body, in every step from now on."""
        check_wrench(len(self._places.body), f_B_W, tau_B_W)
        rows = self._places.body[self._movable]
        self._d.xfrc_applied[rows, :3] = f_B_W[self._movable]
        self._d.xfrc_applied[rows, 3:] = tau_B_W[self._movable]

    def warnings(self) -> tuple[str, ...]:
        """The engine's counters and the effects that could not be left out."""
        return (*self._places.remarks, *(f"mujoco: {one}" for one in self._counted()))

    def save(self) -> object:
        """Everything that `mj_step` reads, warm start included (mjSTATE_INTEGRATION)."""
        kind = _flag(self._mj, "mjtState", "mjSTATE_INTEGRATION")
        saved = np.empty(self._mj.mj_stateSize(self._m, kind))
        self._mj.mj_getState(self._m, self._d, saved, kind)
        return saved

    def restore(self, saved: object) -> None:
        """Back to a saved state; `contacts` are then those of that state."""
        if not isinstance(saved, np.ndarray):
            raise TypeError(f"restore: got {type(saved).__name__}, expected what save returned")
        self._mj.mj_setState(self._m, self._d, saved, _flag(self._mj, "mjtState", "mjSTATE_INTEGRATION"))
        self._numbers[:] = 0
        self._clean = self._numbers.tobytes()
        # Idempotent: the warm start stays as it was restored.
        self._mj.mj_forward(self._m, self._d)

    def close(self) -> None:
        """Free the window; the model is freed with the last reference to it."""
        self._free_window()

    def _free_window(self) -> None:
        if self._window is not None:
            gl, context, _ = self._window
            self._window = None
            gl.make_current()
            context.free()
            gl.free()


def _matrix(q: Sequence[float] | Floats) -> Floats:
    w, x, y, z = (float(c) for c in q)
    return np.array(rotation_matrix((w, x, y, z)))


def _product(a: Floats, b: Floats) -> Floats:
    """Row by row the Hamilton product of quaternions, shapes (n, 4)."""
    aw, ax, ay, az = a.T
    bw, bx, by, bz = b.T
    return np.stack(
        (
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ),
        axis=-1,
    )


def _cross(a: Floats, b: Floats) -> Floats:
    """Row by row the cross product, shapes (n, 3); several times faster than numpy's for short arrays."""
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]


# -- Builder: the law of contact -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Law:
    """A pair's contact in MuJoCo's words: friction is (slide, torsion, roll); solref_friction None: as solref."""

    condim: int
    friction: tuple[float, float, float]
    solref: tuple[float, float]
    solimp: tuple[float, ...] | None
    solref_friction: tuple[float, float] | None = None


def _rebound(z: Floats | float, steps: int, fine: int) -> float:
    """Mean restitution over phases of a spring and damper that cannot pull, of damping ratio z, lasting `steps` steps.

    Equation: x'' = max(0, -2 z w x' - w^2 x), stepped by the semi-implicit rule in steps of 1/fine, with
    w = (pi - 2 asin z)/(cos(asin z) steps) below z = 1 and its limit 2/steps above.
    """
    if z < 1 - 1e-9:
        p = math.asin(z)
        w = (math.pi - 2 * p) / (math.cos(p) * steps * fine)
    else:
        w = 2 / (steps * fine)
    phases = (np.arange(128) + 0.5) / 128
    x, v = -phases, np.full(128, -1.0)
    flying = np.zeros(128, dtype=bool)
    for _ in range(40 * steps * fine):
        push = np.where(flying, 0.0, np.maximum(0.0, -2 * z * w * v - w * w * x))
        v = v + push
        x = x + v
        flying |= (x >= 0) | ((push == 0) & (v > 0))
        if flying.all():
            break
    return float(np.where(flying, v, 0.0).mean())


@cache
def _elastic(e: float, h: float, steps: int, fine: int) -> tuple[float, float]:
    """solref in its direct form (-stiffness, -damping) per unit mass whose mean rebound is e, by bisection over z.

    Source: MuJoCo, "Modeling", solver parameters (negative solref); the damping ratio is ours.
    """
    low, high = 0.0, steps / 4
    if e < _rebound(high, steps, fine):
        raise Unsupported(f"restitution {e:g}", f"MuJoCo's soft contact rebounds by {_rebound(high, steps, fine):.3f} at least")
    if e >= _rebound(low, steps, fine):
        high = low
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if _rebound(middle, steps, fine) > e else (low, middle)
    p = math.asin(min(low, 1.0))
    w = ((math.pi - 2 * p) / math.cos(p) if low < 1 - 1e-9 else 2.0) / (steps * h)
    return (-w * w, -2 * low * w if low > 0 else -1e-9 * w)


def _law(surface: Surface, effects: Effect, options: _Options, h: float, integrator: str | None) -> _Law:
    """The contact of one pair of materials. Raises: Unsupported."""
    where = "/".join(surface.between)
    slide = surface.kinetic_friction if Effect.FRICTION in effects else 0.0
    torsion = surface.torsional_friction if Effect.TORSIONAL_FRICTION in effects else 0.0
    roll = surface.rolling_friction if Effect.ROLLING_FRICTION in effects else 0.0
    if Effect.FRICTION in effects and surface.static_friction != surface.kinetic_friction:
        raise Unsupported(
            f"surface {where}: static friction {surface.static_friction:g} above kinetic friction {surface.kinetic_friction:g}",
            "MuJoCo has one coefficient of sliding friction",
        )
    condim = 6 if roll > 0 else 4 if torsion > 0 else 3 if slide > 0 else 1
    e = surface.restitution if Effect.RESTITUTION in effects else 0.0
    if e > 0:
        if integrator == "discrete":
            raise Unsupported(f"surface {where}: restitution under the discrete integrator", "it damps every rebound")
        # The four stages of Runge and Kutta follow the continuous law, which many fine steps stand for.
        solref = _elastic(e, h, options.rebound_steps, 16 if integrator == "rk4" else 1)
        # Friction has a reference of its own, whatever the rebound, by default as slow as the impact lasts: e^-2 of a slip that
        # could be stopped is left. A faster one stops more of it and, on the cone, bends the rebound the more (see Deviations).
        steps = options.rebound_steps if options.friction_steps is None else options.friction_steps
        firm = (steps * h, 1.0) if condim > 1 else None
        return _Law(condim, (slide, torsion, roll), solref, _impedance(REBOUND_IMPEDANCE), firm)
    constant = _time_constant(options.contact_steps, h, options.slowest)
    impedance = None if options.contact_impedance is None else _impedance(options.contact_impedance)
    own = _friction_constant(options, h) if condim > 1 else None
    firm = None if own is None else (own, 1.0)
    return _Law(condim, (slide, torsion, roll), (constant, options.contact_damping_ratio or 1.0), impedance, firm)


def _impedance(d: float) -> tuple[float, ...]:
    """solimp of the constant impedance d: the share of the reference in the acceleration of a constraint."""
    return (d, d, 0.001, 0.5, 2.0)


def _time_constant(steps: float | None, h: float, slowest: float | None) -> float:
    """The time constant [s] that is asked for: told in steps and bounded by `slowest`, or the vendor's."""
    return VENDOR_TIME_CONSTANT if steps is None else min(steps * h, math.inf if slowest is None else slowest)


def _friction_constant(options: _Options, h: float) -> float | None:
    """The time constant [s] of friction that is told of its own; None where it has none: a pyramid has no rows for it."""
    if options.friction_steps is None or options.cone != "elliptic":
        return None
    return _time_constant(options.friction_steps, h, options.slowest)


def _touching(scene: Scene) -> dict[frozenset[str], Surface]:
    """The laws of the pairs of materials of which two bodies can touch."""
    apart = {frozenset(pair) for pair in scene.apart}
    moved: dict[str, int] = {}
    kinds: set[str] = set()
    for body in scene.bodies:
        if body.collision:
            kinds.add(body.material)
            moved[body.material] = moved.get(body.material, 0) + body.movable
    still = {b.material for b in scene.bodies if b.collision and not b.movable}
    laws = {}
    for surface in scene.surfaces:
        a, b = surface.between
        if not {a, b} <= kinds or surface.pair in apart or not (moved[a] or moved[b]):
            continue
        if a != b or moved[a] > 1 or a in still:
            laws[surface.pair] = surface
    return laws


def _ranked(laws: Mapping[frozenset[str], _Law], materials: Sequence[str]) -> tuple[dict[str, tuple[int, _Law]], list[str]]:
    """Priorities that make MuJoCo's rule (the geom of higher priority decides) give each pair its own law.

    A material qualifies when all its laws with the materials below it are the same; taking any that qualifies is complete,
    since it still qualifies among fewer. Those that are left need explicit pairs, as does a law with a reference for friction.
    """
    left, ranked = list(materials), {}
    while left:
        for a in left:
            own = {laws[pair] for b in left if (pair := frozenset((a, b))) in laws}
            if len(own) <= 1 and all(law.solref_friction is None for law in own):
                ranked[a] = (len(left), next(iter(own), None))
                left.remove(a)
                break
        else:
            break
    return {a: (rank, law) for a, (rank, law) in ranked.items() if law is not None}, left


# -- Builder: the forest of joints ---------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Link:
    """How a body hangs in the forest: below body `above` (-1: the world) by `joint`, `turned` if the scene's child is above."""

    body: int
    above: int
    joint: Joint | None
    turned: bool = False


def _keenness(joint: Joint) -> int:
    """The lower, the sooner a joint becomes native: what has no equality constraint first, the exact ones last."""
    if isinstance(joint, Prismatic):
        return 0
    if isinstance(joint, Revolute):
        return 1 if joint.limits or joint.spring or joint.drive else 2
    return 3 if isinstance(joint, Fixed) else 4


def _forest(scene: Scene, joints: Sequence[Joint]) -> tuple[list[_Link], list[Joint]]:
    """Links from the roots down, and the joints that close loops (Kruskal's spanning forest)."""
    n = len(scene.bodies)
    index = {body.name: k for k, body in enumerate(scene.bodies)} | {WORLD: -1}
    boss = [k if body.movable else n for k, body in enumerate(scene.bodies)] + [n]

    def top(k: int) -> int:
        while boss[k] != k:
            boss[k] = boss[boss[k]]
            k = boss[k]
        return k

    beside: dict[int, list[tuple[int, Joint, bool]]] = {}
    loops: list[Joint] = []
    for joint in sorted((j for j in joints if not isinstance(j, Distance)), key=_keenness):
        a, b = index[joint.parent], index[joint.child]
        if top(a) == top(b):
            loops.append(joint)
            continue
        boss[top(a)] = top(b)
        beside.setdefault(a, []).append((b, joint, False))
        beside.setdefault(b, []).append((a, joint, True))
    links: list[_Link] = []
    reached: set[int] = set()

    def grow(root: int) -> None:
        queue = deque([root])
        reached.add(root)
        while queue:
            above = queue.popleft()
            for below, joint, turned in beside.get(above, ()):
                if below not in reached:
                    reached.add(below)
                    links.append(_Link(below, above, joint, turned))
                    queue.append(below)

    still = [k for k, body in enumerate(scene.bodies) if not body.movable]
    links.extend(_Link(k, -1, None) for k in still)
    reached.update(still)
    for root in (-1, *still):
        grow(root)
    for k in range(n):
        if k not in reached:
            links.append(_Link(k, -1, None))
            grow(k)
    return links, loops


# -- Builder: the model --------------------------------------------------------------------------------------------------------


class _Builder:
    """Writes the scene into an `MjSpec`, compiles it and sets what only a compiled model takes."""

    def __init__(self, mj: Any, scene: Scene, settings: Settings) -> None:
        self.mj, self.scene, self.settings = mj, scene, settings
        self.options = _options(settings)
        self.effects = scene.effects
        self.h = settings.dt / (settings.substeps or 1)
        self.joints = scene.joints if Effect.JOINTS in self.effects else ()
        self.links, self.loops = _forest(scene, self.joints)
        self.index = {body.name: k for k, body in enumerate(scene.bodies)}
        self.moments, self.q_BM = zip(*(_principal(body) for body in scene.bodies), strict=True)
        self.q_WM = [np.array(multiply(b.q_WB, q)) for b, q in zip(scene.bodies, self.q_BM, strict=True)]
        self.R_WM = [_matrix(q) for q in self.q_WM]
        self.p = [np.array(body.p_WB) for body in scene.bodies]
        self.spec = mj.MjSpec()
        self.parts: dict[int, Any] = {}
        self.meshes = 0
        self.drives: dict[str, int] = {}
        self.own: list[str] = []
        self.tolerance_scale = 1.0
        self.rebounds = False

    def simulation(self) -> MujocoSimulation:
        """The compiled scene in its initial state. Raises: Unsupported."""
        self._solver()
        laws = self._laws()
        for link in self.links:
            self._body(link)
        self._shapes(laws)
        for joint in self.loops:
            self._loop(joint)
        for joint in self.joints:
            if isinstance(joint, Distance):
                self._distance(joint)
        if Effect.DRIVES in self.effects:
            self._actuators()
        if Effect.SENSING in self.effects:
            self._inertial()
        try:
            model = self.spec.compile()
        except (ValueError, RuntimeError, self.mj.FatalError) as error:
            raise Unsupported("scene", f"MuJoCo's compiler refuses it: {str(error).strip()}") from error
        self._settle(model)
        simulation = MujocoSimulation(self.mj, model, self.scene, self.settings, self._resolved(model), self._places(model))
        self._start(model, simulation)
        return simulation

    def _solver(self) -> None:
        """Settings and effects as options and flags of the model."""
        mj, option, settings, choice = self.mj, self.spec.option, self.settings, self.options
        self.spec.compiler.degree = False
        option.timestep, option.gravity = self.h, self.scene.gravity
        if settings.iterations is not None:
            option.iterations = settings.iterations
        if settings.tolerance is not None:
            option.tolerance = settings.tolerance
        if settings.solver is not None:
            option.solver = _flag(mj, "mjtSolver", f"mjSOL_{settings.solver.upper()}")
        if settings.integrator is not None:
            option.integrator = _flag(mj, "mjtIntegrator", f"mjINT_{settings.integrator.upper()}")
        if choice.cone is not None:
            option.cone = _flag(mj, "mjtCone", f"mjCONE_{choice.cone.upper()}")
        if choice.jacobian is not None:
            option.jacobian = _flag(mj, "mjtJacobian", f"mjJAC_{choice.jacobian.upper()}")
        for name in ("impratio", "noslip_iterations", "ls_iterations"):
            if getattr(choice, name) is not None:
                setattr(option, name, getattr(choice, name))
        # A reset on NaN would hide it; the filter between parent and child knows nothing of `collide`: excludes stand for it.
        off = {"AUTORESET": True, "FILTERPARENT": True}
        off |= {"CONTACT": Effect.CONTACT not in self.effects, "GRAVITY": Effect.GRAVITY not in self.effects}
        for name in ("multiccd", "nativeccd", "island", "warmstart", "refsafe"):
            off[name.upper()] = getattr(choice, name) is False
        called = Effect.CONTINUOUS_COLLISION in self.effects
        speculative = choice.by_scene and called if choice.speculative is None else choice.speculative
        self.passable = called and not speculative
        on = {"SPECULATIVE": speculative, "DIAGEXACT": choice.diagexact is True}
        option.disableflags |= sum(_flag(mj, "mjtDisableBit", f"mjDSBL_{name}") for name, set_ in off.items() if set_)
        option.enableflags |= sum(_flag(mj, "mjtEnableBit", f"mjENBL_{name}") for name, set_ in on.items() if set_)

    def _laws(self) -> dict[frozenset[str], _Law]:
        if Effect.CONTACT not in self.effects:
            return {}
        known: dict[Surface, _Law] = {}
        laws = {}
        for pair, surface in _touching(self.scene).items():
            if surface not in known:
                known[surface] = _law(surface, self.effects, self.options, self.h, self.settings.integrator)
            laws[pair] = known[surface]
        self.rebounds = any(law.solref[0] < 0 for law in laws.values())
        if any(law.solref_friction is not None for law in laws.values()):
            if self.options.cone == "pyramidal":
                raise Unsupported("friction with restitution on a pyramidal cone", "MuJoCo's pyramid mixes the two directions")
            self.spec.option.cone = _flag(self.mj, "mjtCone", "mjCONE_ELLIPTIC")
        return laws

    def _prescribed(self, body: Body) -> bool:
        return body.motion == "kinematic" and (any(body.v_WB) or any(body.w_WB))

    def _body(self, link: _Link) -> None:
        """One body with its native joint, its frame M against that of the body above."""
        mj, body, k = self.mj, self.scene.bodies[link.body], link.body
        p_PM, q_PM = self.p[k], self.q_WM[k]
        above = self.spec.worldbody
        if link.above >= 0:
            R_WP, q_WP = self.R_WM[link.above], self.q_WM[link.above]
            above = self.parts[link.above]
            p_PM = R_WP.T @ (p_PM - self.p[link.above])
            q_PM = np.array(multiply((q_WP[0], -q_WP[1], -q_WP[2], -q_WP[3]), tuple(q_PM)))
        part = above.add_body(name=f"b{k}", pos=p_PM, quat=q_PM)
        part.explicitinertial, part.mass, part.inertia = True, body.mass, self.moments[k]
        # Left open, the inertial frame is not M: 4.0.0 takes the body's place in its parent for it.
        part.ipos, part.iquat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
        self.parts[k] = part
        if self._prescribed(body):
            movable = sum(b.mass for b in self.scene.bodies if b.movable) or 1.0
            reach = max([1.0, *(float(np.linalg.norm(p - self.p[k])) for p in self.p)])
            part.inertia, part.mass, part.gravcomp = [1.0, 1.0, 1.0], 1.0, 1.0
            part.add_joint(
                name=f"f{k}", type=mj.mjtJoint.mjJNT_FREE, armature=KINEMATIC_ARMATURE * max(1.0, movable) * reach**2
            )
        elif body.movable and link.joint is None:
            part.add_freejoint(name=f"f{k}")
        elif link.joint is not None:
            self._native(part, link, link.joint)

    def _native(self, part: Any, link: _Link, joint: Joint) -> None:
        mj, k = self.mj, link.body
        if isinstance(joint, Fixed):
            return
        assert not isinstance(joint, Distance)
        anchor = self.R_WM[k].T @ (np.array(joint.anchor_W) - self.p[k])
        if isinstance(joint, Ball):
            part.add_joint(name=f"f{k}", type=mj.mjtJoint.mjJNT_BALL, pos=anchor)
            return
        kind = mj.mjtJoint.mjJNT_HINGE if isinstance(joint, Revolute) else mj.mjtJoint.mjJNT_SLIDE
        axis = self.R_WM[k].T @ np.array(joint.axis_W) * (-1.0 if link.turned else 1.0)
        made = part.add_joint(name=f"f{k}", type=kind, pos=anchor, axis=axis, ref=joint.position)
        bounds = _range(joint)
        if bounds is not None:
            made.limited, made.range = mj.mjtLimited.mjLIMITED_TRUE, bounds
            self._stop(made)
        if joint.spring is not None:
            made.stiffness, made.damping = [joint.spring.stiffness, 0, 0], [joint.spring.damping, 0, 0]
            made.springref = joint.spring.rest

    def _shapes(self, laws: Mapping[frozenset[str], _Law]) -> None:
        """Geoms with their surfaces; whose pair's law no priority gives, an explicit pair does."""
        bodies = self.scene.bodies
        materials = sorted({b.material for b in bodies if b.collision})
        ranked, left = _ranked(laws, materials)
        masks = self._masks(materials)
        for link in self.links:
            body, part = bodies[link.body], self.parts[link.body]
            for number, placed in enumerate(body.collision):
                geom = self._geom(part, link.body, placed, f"g{link.body}.{number}")
                geom.group = BOTH_GROUP if body.visual is None else COLLISION_GROUP
                if Effect.CONTACT in self.effects:
                    geom.contype, geom.conaffinity = masks[body.material]
                    if body.material in ranked:
                        geom.priority, law = ranked[body.material]
                        self._surface(geom, law)
                        geom.friction = law.friction
                else:
                    geom.contype = geom.conaffinity = 0
            for number, placed in enumerate(body.visual or ()):
                geom = self._geom(part, link.body, placed, f"v{link.body}.{number}", drawn=True)
                geom.contype, geom.conaffinity, geom.group = 0, 0, VISUAL_GROUP
        if Effect.CONTACT in self.effects:
            self._exclude()
            self._pairs(laws, left)

    @staticmethod
    def _surface(geom: Any, law: _Law) -> None:
        geom.condim, geom.solref = law.condim, law.solref
        if law.solimp is not None:
            geom.solimp = law.solimp

    def _masks(self, materials: Sequence[str]) -> dict[str, tuple[int, int]]:
        """contype and conaffinity: a bit for each material that stands apart from some other, one bit for all others."""
        apart = [frozenset(pair) for pair in self.scene.apart]
        lonely = [m for m in materials if any(m in pair for pair in apart)]
        if len(lonely) > 30:
            raise Unsupported(f"{len(lonely)} materials apart from others", "MuJoCo's collision masks have 31 bits")
        bit = {m: 2 << lonely.index(m) if m in lonely else 1 for m in materials}
        return {m: (bit[m], sum({bit[o] for o in materials if frozenset((m, o)) not in apart})) for m in materials}

    def _exclude(self) -> None:
        bodies = self.scene.bodies
        still = [b.name for b in bodies if not b.movable and b.collision]
        moving = [b.name for b in bodies if self._prescribed(b) and b.collision]
        pairs = {frozenset((a, b)) for a in still for b in moving if a != b}
        pairs |= {pair for pair in self.scene.joined() if WORLD not in pair}
        for a, b in sorted(tuple(sorted(pair)) for pair in pairs):
            self.spec.add_exclude(bodyname1=f"b{self.index[a]}", bodyname2=f"b{self.index[b]}")

    def _pairs(self, laws: Mapping[frozenset[str], _Law], left: Sequence[str]) -> None:
        bodies = [(k, b) for k, b in enumerate(self.scene.bodies) if b.material in left and b.collision]
        for place, (i, a) in enumerate(bodies):
            for j, b in bodies[place + 1 :]:
                law = laws.get(frozenset((a.material, b.material)))
                if law is None or not self.scene.collides(a, b):
                    continue
                for x in range(len(a.collision)):
                    for y in range(len(b.collision)):
                        pair = self.spec.add_pair(geomname1=f"g{i}.{x}", geomname2=f"g{j}.{y}")
                        self._surface(pair, law)
                        if law.solref_friction is not None:
                            pair.solreffriction = law.solref_friction
                        slide, torsion, roll = law.friction
                        pair.friction = [slide, slide, torsion, roll, roll]

    def _geom(self, part: Any, k: int, placed: PlacedShape, name: str, drawn: bool = False) -> Any:
        """One shape, its pose S turned from B to M."""
        kinds, shape, body = self.mj.mjtGeom, placed.shape, self.scene.bodies[k]
        q_BM = self.q_BM[k]
        back = (q_BM[0], -q_BM[1], -q_BM[2], -q_BM[3])
        place: dict[str, Any] = {"pos": _matrix(back) @ placed.p_BS, "quat": multiply(back, placed.q_BS), "name": name}
        match shape:
            case Sphere(radius=r):
                return part.add_geom(type=kinds.mjGEOM_SPHERE, size=[r, 0, 0], **place)
            case Box(half_extents=half):
                return part.add_geom(type=kinds.mjGEOM_BOX, size=half, **place)
            case Capsule(radius=r, half_length=l):
                return part.add_geom(type=kinds.mjGEOM_CAPSULE, size=[r, l, 0], **place)
            case Cylinder(radius=r, half_length=l):
                return part.add_geom(type=kinds.mjGEOM_CYLINDER, size=[r, l, 0], **place)
            case Plane(normal=n):
                if self._prescribed(body):
                    raise Unsupported(
                        f"body '{body.name}': a plane that moves", "MuJoCo's planes are part of static bodies only"
                    )
                place["quat"] = multiply(place["quat"], _upright(n))
                return part.add_geom(type=kinds.mjGEOM_PLANE, size=[0, 0, 1], **place)
            case ConvexHull(vertices=vertices):
                return part.add_geom(type=kinds.mjGEOM_MESH, meshname=self._mesh(vertices, None), **place)
            case TriangleMesh(vertices=vertices, faces=faces):
                if Effect.CONTACT in self.effects and not drawn and not _convex(np.array(vertices), np.array(faces)):
                    raise Unsupported(
                        f"body '{body.name}': a mesh that is not convex and closed", "MuJoCo collides a mesh as its hull"
                    )
                return part.add_geom(type=kinds.mjGEOM_MESH, meshname=self._mesh(vertices, faces), **place)
            case _ as other:
                assert_never(other)

    def _inertial(self) -> None:
        """Sites with MuJoCo's accelerometer and gyroscope for the inertial sensors that ask for them."""
        kinds, site = self.mj.mjtSensor, self.mj.mjtObj.mjOBJ_SITE
        for sensor in self.scene.sensors:
            if not isinstance(sensor, Imu) or sensor.reading != "native":
                continue
            part, back = self.spec.worldbody, (1.0, 0.0, 0.0, 0.0)
            if sensor.body != WORLD:
                k = self.index[sensor.body]
                w, x, y, z = self.q_BM[k]
                part, back = self.parts[k], (w, -x, -y, -z)
            place = {"pos": _matrix(back) @ sensor.p_BS, "quat": multiply(back, sensor.q_BS)}
            part.add_site(name=f"s:{sensor.name}", **place)
            for word, kind in (("force", kinds.mjSENS_ACCELEROMETER), ("rate", kinds.mjSENS_GYRO)):
                self.spec.add_sensor(name=f"{word}:{sensor.name}", type=kind, objtype=site, objname=f"s:{sensor.name}")
            self.own.append(sensor.name)

    def _mesh(self, vertices: Sequence[Vector3], faces: Sequence[tuple[int, int, int]] | None) -> str:
        name = f"m{self.meshes}"
        self.meshes += 1
        mesh = self.spec.add_mesh(name=name)
        mesh.uservert = [float(c) for vertex in vertices for c in vertex]
        if faces is not None:
            mesh.userface = [int(c) for face in faces for c in face]
            # Exact volume would refuse open meshes, which rays may see; the inertia is given by the scene in any case.
            mesh.inertia = self.mj.mjtMeshInertia.mjMESH_INERTIA_SHELL
        return name

    def _loop(self, joint: Joint) -> None:
        """An equality constraint for a joint that closes a loop. Raises: Unsupported."""
        assert not isinstance(joint, Distance)
        extra = next((x for x in ("limits", "spring", "drive") if getattr(joint, x, None) is not None), None)
        if isinstance(joint, Prismatic) or extra is not None:
            what = f"joint '{joint.name}': a {joint.type} joint{f' with {extra}' if extra else ''} that closes a loop"
            raise Unsupported(
                what, "MuJoCo closes loops by points and welds; every other joint of this loop has a coordinate of its own too"
            )
        kinds, k = self.mj.mjtEq, self.index[joint.child]
        if isinstance(joint, Fixed):
            made = self._equality(joint, kinds.mjEQ_WELD)
            # Anchor, then a relative pose of zeros (read off the initial one), then the weight of rotation [m].
            made.data = [*([0.0] * 10), 1.0, 0.0]
            return
        points = [np.array(joint.anchor_W)]
        if isinstance(joint, Revolute):
            arm = max(float(np.linalg.norm(points[0] - self.p[k])), 1e-3)
            points = [points[0] + side * arm * np.array(joint.axis_W) for side in (-1.0, 1.0)]
        for point in points:
            made = self._equality(joint, kinds.mjEQ_CONNECT)
            made.data = [*(self.R_WM[k].T @ (point - self.p[k])), *([0.0] * 9)]

    def _equality(self, joint: Joint, kind: Any) -> Any:
        """The constraint between the child and the parent; the child is never the world."""
        parent = "world" if joint.parent == WORLD else f"b{self.index[joint.parent]}"
        made = self.spec.add_equality(
            type=kind, objtype=self.mj.mjtObj.mjOBJ_BODY, name1=f"b{self.index[joint.child]}", name2=parent
        )
        self._hold(made)
        return made

    def _hold(self, constraint: Any) -> None:
        """How stiffly a loop or a rod is held."""
        constraint.solref = [_time_constant(self.options.loop_steps, self.h, self.options.slowest), 1.0]
        if self.options.loop_impedance is not None:
            constraint.solimp = _impedance(self.options.loop_impedance)

    def _stop(self, limited: Any) -> None:
        """How a coordinate or a tendon is stopped at its limits."""
        choice = self.options
        limited.solref_limit = [_time_constant(choice.limit_steps, self.h, choice.slowest), choice.limit_damping_ratio or 1.0]
        if choice.limit_impedance is not None:
            limited.solimp_limit = _impedance(choice.limit_impedance)

    def _distance(self, joint: Distance) -> None:
        """A tendon between two sites: limited, sprung, or held at its length."""
        ends = ((joint.parent, joint.anchor_W, "a"), (joint.child, joint.child_anchor_W, "b"))
        tendon = self.spec.add_tendon(name=f"t.{joint.name}")
        for name, anchor, end in ends:
            point, part = np.array(anchor), self.spec.worldbody
            if name != WORLD:
                k = self.index[name]
                point, part = self.R_WM[k].T @ (point - self.p[k]), self.parts[k]
            part.add_site(name=f"s.{joint.name}.{end}", pos=point)
            tendon.wrap_site(f"s.{joint.name}.{end}")
        if joint.spring is not None:
            tendon.stiffness, tendon.damping = [joint.spring.stiffness, 0, 0], [joint.spring.damping, 0, 0]
            tendon.springlength = [joint.spring.rest, joint.spring.rest]
        bounds = _range(joint)
        if bounds is not None:
            tendon.limited, tendon.range = self.mj.mjtLimited.mjLIMITED_TRUE, bounds
            self._stop(tendon)
        elif joint.spring is None:
            held = self.spec.add_equality(type=self.mj.mjtEq.mjEQ_TENDON, name1=f"t.{joint.name}")
            held.objtype, held.data = self.mj.mjtObj.mjOBJ_TENDON, [0.0] * 12
            self._hold(held)

    def _actuators(self) -> None:
        """PD drives: force = stiffness ctrl + damping target_velocity - stiffness x - damping x', cut off at the limit."""
        mj = self.mj
        native = {link.joint.name: link.body for link in self.links if link.joint is not None}
        for joint in self.joints:
            drive = getattr(joint, "drive", None)
            if drive is None:
                continue
            made = self.spec.add_actuator(
                name=f"d.{joint.name}", target=f"f{native[joint.name]}", trntype=mj.mjtTrn.mjTRN_JOINT
            )
            made.gaintype, made.gainprm = mj.mjtGain.mjGAIN_FIXED, [drive.stiffness, *([0.0] * 9)]
            bias = [drive.damping * drive.target_velocity, -drive.stiffness, -drive.damping]
            made.biastype, made.biasprm = mj.mjtBias.mjBIAS_AFFINE, [*bias, *([0.0] * 7)]
            if drive.limit is not None:
                made.forcelimited, made.forcerange = mj.mjtLimited.mjLIMITED_TRUE, [-drive.limit, drive.limit]
            self.drives[joint.name] = len(self.drives)

    def _settle(self, model: Any) -> None:
        """What only a compiled model takes: damping per coordinate, the scale of the solver, the choices by scene."""
        mj, option = self.mj, model.opt
        self._dampen(model)
        if self.own:
            # Asked between the steps, they would cost in every one.
            option.disableflags |= _flag(mj, "mjtDisableBit", "mjDSBL_SENSOR")
        driven = [model.joint(f"f{k}").dofadr[0] for k, b in enumerate(self.scene.bodies) if self._prescribed(b)]
        if driven:
            # The tolerance is relative to the mean inertia of the model, which the armature of kinematic bodies must not raise.
            kept = np.setdiff1d(np.arange(model.nv), [adr + i for adr in driven for i in range(6)])
            own = float(model.dof_M0[kept].mean()) if len(kept) else 1.0
            self.tolerance_scale = own / float(model.dof_M0.mean())
            option.tolerance *= self.tolerance_scale
        if not self.options.by_scene:
            return
        if self.settings.integrator is None:
            if Effect.CONTACT not in self.effects:
                rate, frequency = self._stiffest(model)
                name = "RK4" if rate <= RK4_RATE else "IMPLICITFAST" if frequency <= SPRING_RATE else "DISCRETE"
            elif self._fastest(model) > RESOLVED_RATE:
                # The discrete map damps a rebound away; the implicit one jitters in contact, but bears both.
                name = "IMPLICITFAST" if self.rebounds else "DISCRETE"
            else:
                name = "EULER"
            option.integrator = _flag(mj, "mjtIntegrator", f"mjINT_{name}")
        if self.options.jacobian is None and mj.__version__ == FAULTY_SPARSE and model.nv <= DENSE_LIMIT:
            option.jacobian = _flag(mj, "mjtJacobian", "mjJAC_DENSE")

    def _resisted(self, model: Any) -> tuple[Floats, Floats, Integers]:
        """Stiffness and damping (nv,) of coordinates by springs, dampers and drives; where each joint's coordinates begin."""
        stiffness, damping, dof = np.zeros(model.nv), np.array(model.dof_damping), np.array(model.jnt_dofadr)
        stiffness[dof] += model.jnt_stiffness
        for place in self.drives.values():
            adr = dof[model.actuator_trnid[place, 0]]
            stiffness[adr] -= model.actuator_biasprm[place, 1]
            damping[adr] -= model.actuator_biasprm[place, 2]
        return stiffness, damping, dof

    def _fastest(self, model: Any) -> float:
        """The largest rate times step of springs, dampers and drives: sqrt(k/m) h or c/m h."""
        h, rate = self.h, 0.0
        stiffness, damping, dof = self._resisted(model)
        groups = (
            (stiffness[dof], damping[dof], model.dof_invweight0[dof]),
            (model.tendon_stiffness, model.tendon_damping, model.tendon_invweight0),
        )
        for k, c, w in groups:
            if len(w):
                rate = max(rate, h * float(np.sqrt(k * w).max()), h * float((c * w).max()))
        return rate

    def _stiffest(self, model: Any) -> tuple[float, float]:
        """Bounds of |lambda| h over the modes of springs, dampers and drives, on joint-space inertia, over configurations:
        as they are, and undamped.

        Equation: a mode x of M q'' + C q' + K q = 0 has lambda^2 x'Mx + lambda x'Cx + x'Kx = 0, thus with c and k the largest
        eigenvalues of M^-1 C and M^-1 K, |lambda|^2 <= c |lambda| + k. Source: Tisseur, Meerbergen, SIAM Review 43 (2001).
        """
        mj = self.mj
        stiffness, damping, _ = self._resisted(model)
        if not (stiffness.any() or damping.any() or model.tendon_stiffness.any() or model.tendon_damping.any()):
            return 0.0, 0.0
        d, random = mj.MjData(model), np.random.default_rng(0)
        rigid = bool((model.jnt_type == _flag(mj, "mjtJoint", "mjJNT_FREE")).all())
        worst, undamped = 0.0, 0.0
        for sample in range(1 if rigid else 1 + RATE_SAMPLES):
            if sample:
                self._scatter(model, d, random)
            mj.mj_fwdPosition(model, d)
            lines = np.zeros((model.ntendon, model.nv))
            if model.ntendon:
                mj.mju_sparse2dense(lines, d.ten_J, model.ten_J_rownnz, model.ten_J_rowadr, model.ten_J_colind)
            c = self._largest(model, d, damping, model.tendon_damping, lines)
            k = self._largest(model, d, stiffness, model.tendon_stiffness, lines)
            worst, undamped = max(worst, (c + math.sqrt(c * c + 4 * k)) / 2), max(undamped, math.sqrt(k))
        return worst * self.h, undamped * self.h

    def _largest(self, model: Any, d: Any, own: Floats, along: Floats, lines: Floats) -> float:
        """The largest eigenvalue of M^-1 (diag(own) + lines' diag(along) lines); of many rows a bound, the largest row sum."""
        rows = np.vstack((np.diag(np.sqrt(own))[own > 0], np.sqrt(along)[:, None] * lines))
        if not rows.any():
            return 0.0
        moved = np.empty_like(rows)
        self.mj.mj_solveM(model, d, moved, np.ascontiguousarray(rows))
        product = rows @ moved.T
        return float(np.linalg.eigvalsh(product)[-1] if len(rows) <= EXACT_ROWS else np.abs(product).sum(axis=1).max())

    def _scatter(self, model: Any, d: Any, random: np.random.Generator) -> None:
        """Turn every hinge and ball by chance, within limits; what flies or slides freely stays."""
        kinds = self.mj.mjtJoint
        for joint in range(model.njnt):
            adr, kind = model.jnt_qposadr[joint], model.jnt_type[joint]
            limited = bool(model.jnt_limited[joint])
            if kind == int(kinds.mjJNT_BALL):
                q = random.normal(size=4)
                d.qpos[adr : adr + 4] = q / np.linalg.norm(q)
            elif kind == int(kinds.mjJNT_HINGE) or (kind == int(kinds.mjJNT_SLIDE) and limited):
                low, high = model.jnt_range[joint] if limited else (-math.pi, math.pi)
                start = float(model.qpos0[adr])
                d.qpos[adr] = random.uniform(max(low, start - 2 * math.pi), min(high, start + 2 * math.pi))

    def _dampen(self, model: Any) -> None:
        """Q = -c J^T (m v, I w) as damping of coordinates, where a diagonal of coefficients can say it. Raises: Unsupported."""
        for link in self.links:
            body, k, joint = self.scene.bodies[link.body], link.body, link.joint
            linear = body.linear_damping if Effect.LINEAR_DAMPING in self.effects else 0.0
            angular = body.angular_damping if Effect.ANGULAR_DAMPING in self.effects else 0.0
            if not body.movable or (linear == 0 and angular == 0):
                continue
            if joint is None:
                adr = model.joint(f"f{k}").dofadr[0]
                model.dof_damping[adr : adr + 3] += linear * body.mass
                model.dof_damping[adr + 3 : adr + 6] += angular * np.array(self.moments[k])
                continue
            grounded = link.above < 0 or (not (above := self.scene.bodies[link.above]).movable and not self._prescribed(above))
            if grounded and isinstance(joint, Fixed):
                continue
            if not grounded or not isinstance(joint, Revolute | Prismatic):
                raise Unsupported(
                    f"body '{body.name}': damping of a body held by {joint.type} joint '{joint.name}'",
                    "MuJoCo damps coordinates, not bodies",
                )
            adr, axis = model.joint(f"f{k}").dofadr[0], np.array(joint.axis_W)
            if isinstance(joint, Prismatic):
                model.dof_damping[adr] += linear * body.mass
            else:
                arm = np.cross(axis, self.p[k] - np.array(joint.anchor_W))
                turn = self.R_WM[k].T @ axis
                model.dof_damping[adr] += linear * body.mass * float(arm @ arm) + angular * float(turn**2 @ self.moments[k])

    def _start(self, model: Any, simulation: MujocoSimulation) -> None:
        """Velocities of the coordinates from those of the bodies, proven by reading them back. Raises: Unsupported."""
        d, bodies = simulation._d, self.scene.bodies
        for name, place in self.drives.items():
            d.ctrl[place] = next(
                j.drive.target for j in self.joints if j.name == name and not isinstance(j, Fixed | Ball | Distance) and j.drive
            )
        for link in self.links:
            body, k, joint = bodies[link.body], link.body, link.joint
            if isinstance(joint, Fixed) or (joint is None and not body.movable and not self._prescribed(body)):
                continue
            adr = model.joint(f"f{k}").dofadr[0]
            v, w = np.array(body.v_WB), np.array(body.w_WB)
            if joint is None:
                d.qvel[adr : adr + 3], d.qvel[adr + 3 : adr + 6] = v, self.R_WM[k].T @ w
                continue
            assert not isinstance(joint, Distance)
            above_v, above_w = np.zeros(3), np.zeros(3)
            if link.above >= 0:
                above = bodies[link.above]
                above_w = np.array(above.w_WB)
                above_v = np.array(above.v_WB) + np.cross(above_w, np.array(joint.anchor_W) - self.p[link.above])
            if isinstance(joint, Ball):
                d.qvel[adr : adr + 3] = self.R_WM[k].T @ (w - above_w)
                continue
            axis = np.array(joint.axis_W) * (-1.0 if link.turned else 1.0)
            at_anchor = v + np.cross(w, np.array(joint.anchor_W) - self.p[k])
            d.qvel[adr] = axis @ (w - above_w) if isinstance(joint, Revolute) else axis @ (at_anchor - above_v)
        self.mj.mj_forward(model, d)
        if simulation._numbers[FATAL].any():
            raise Unsupported("initial state", "a coordinate or velocity lies above MuJoCo's bound of 1e10")
        self._agree(simulation)

    def _agree(self, simulation: MujocoSimulation) -> None:
        """The joints must let the bodies move as the scene says. Raises: Unsupported."""
        asked, got = State.initial(self.scene), State.empty(len(self.scene.bodies))
        simulation.state(got)
        speed = 1e-9 + 1e-7 * max(float(np.abs(asked.v_WB).max()), float(np.abs(asked.w_WB).max()))
        why = "generalised coordinates hold no velocity that a joint forbids"
        for k, body in enumerate(self.scene.bodies):
            gap = max(float(np.abs(asked.v_WB[k] - got.v_WB[k]).max()), float(np.abs(asked.w_WB[k] - got.w_WB[k]).max()))
            if gap > speed:
                motion = f"v_WB {body.v_WB}, w_WB {body.w_WB} against its joints, which allow {got.v_WB[k]}, {got.w_WB[k]}"
                raise Unsupported(f"body '{body.name}': {motion}", why)
        d = simulation._d
        held = d.efc_type == _flag(self.mj, "mjtConstraint", "mjCNSTR_EQUALITY")
        if held.any() and float(np.abs(d.efc_vel[held]).max()) > speed:
            raise Unsupported(
                f"velocities that open a loop or stretch a rod by {float(np.abs(d.efc_vel[held]).max()):.3g} m/s", why
            )

    def _places(self, model: Any) -> _Places:
        body = np.array([model.body(f"b{k}").id for k in range(len(self.scene.bodies))], dtype=np.int64)
        scene_body = np.full(model.nbody, -1, dtype=np.int64)
        scene_body[body] = np.arange(len(body))
        q_BM = np.array(self.q_BM)
        turned = bool((q_BM != (1.0, 0.0, 0.0, 0.0)).any())
        remarks = []
        if Effect.GYROSCOPIC not in self.effects and any(b.movable for b in self.scene.bodies):
            remarks.append("surplus: gyroscopic terms are part of the bias force")
        if self.passable:
            remarks.append("missing: continuous_collision: speculative contacts are off unless asked for")
        sparse = _flag(self.mj, "mjtJacobian", "mjJAC_DENSE") != model.opt.jacobian and model.nv >= 60
        if sparse and self.mj.__version__ == FAULTY_SPARSE and self.settings.solver in (None, "newton"):
            remarks.append(
                "mujoco 4.0.0: the sparse factor of the Newton solver is wrong for some models, by its makers' account"
            )
        return _Places(
            body,
            scene_body,
            q_BM * (1.0, -1.0, -1.0, -1.0) if turned else None,
            all(link.above < 0 and (link.joint is None or isinstance(link.joint, Fixed)) for link in self.links),
            dict(self.drives),
            {name: (int(model.sensor(f"force:{name}").adr[0]), int(model.sensor(f"rate:{name}").adr[0])) for name in self.own},
            tuple(remarks),
        )

    def _resolved(self, model: Any) -> Settings:
        mj, option = self.mj, model.opt
        substeps, choice, own = self.settings.substeps or 1, self.options, self.options.friction_steps
        free = option.integrator == _flag(mj, "mjtIntegrator", "mjINT_DISCRETE") or choice.refsafe is False
        least = 0.0 if free else LEAST_STEPS * self.h
        contact = _time_constant(choice.contact_steps, self.h, choice.slowest)
        flags = {
            "disabled": ("mjtDisableBit", "mjDSBL_", option.disableflags),
            "enabled": ("mjtEnableBit", "mjENBL_", option.enableflags),
        }
        used: dict[str, Any] = {
            "cone": mj.mjtCone(option.cone).name.removeprefix("mjCONE_").lower(),
            "jacobian": mj.mjtJacobian(option.jacobian).name.removeprefix("mjJAC_").lower(),
            "impratio": float(option.impratio),
            "noslip_iterations": int(option.noslip_iterations),
            "ls_iterations": int(option.ls_iterations),
            "rebound_steps": choice.rebound_steps,
            "friction_steps": choice.rebound_steps if self.rebounds and own is None else own,
            "contact_time_constant": max(least, contact),
            "friction_time_constant": max(least, _friction_constant(choice, self.h) or contact),
            "contact_damping_ratio": self.options.contact_damping_ratio or 1.0,
            "contact_impedance": self.options.contact_impedance or "0.9..0.95",
            "limit_time_constant": max(least, _time_constant(choice.limit_steps, self.h, choice.slowest)),
            "limit_damping_ratio": self.options.limit_damping_ratio or 1.0,
            "limit_impedance": self.options.limit_impedance or "0.9..0.95",
            "loop_time_constant": max(least, _time_constant(choice.loop_steps, self.h, choice.slowest)),
            "loop_impedance": self.options.loop_impedance or "0.9..0.95",
            "by_scene": self.options.by_scene,
        }
        for word, (kind, prefix, bits) in flags.items():
            members = getattr(mj, kind).__members__.items()
            used[word] = [n.removeprefix(prefix).lower() for n, bit in members if n.startswith(prefix) and int(bit) & int(bits)]
        return Settings(
            dt=float(option.timestep) * substeps,
            substeps=substeps,
            iterations=int(option.iterations),
            integrator=mj.mjtIntegrator(option.integrator).name.removeprefix("mjINT_").lower(),
            solver=mj.mjtSolver(option.solver).name.removeprefix("mjSOL_").lower(),
            tolerance=float(option.tolerance) / self.tolerance_scale,
            options=used,
            source=self.settings.source,
        )


def _principal(body: Body) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
    """Principal moments [kg m2] and q_BM; a tensor that is diagonal already is left as it stands."""
    tensor = np.asarray(body.inertia)
    moments, axes = np.diag(tensor).copy(), np.eye(3)
    if np.abs(tensor - np.diag(moments)).max() > 0:
        moments, axes = np.linalg.eigh((tensor + tensor.T) / 2)
        if np.linalg.det(axes) < 0:
            axes[:, 0] *= -1
    # The scene grants rounding in the triangle inequality; MuJoCo's compiler grants none.
    largest = int(np.argmax(moments))
    moments[largest] = min(moments[largest], float(moments.sum() - moments[largest]))
    return (float(moments[0]), float(moments[1]), float(moments[2])), _quaternion(axes)


def _quaternion(R: Floats) -> tuple[float, float, float, float]:
    """The unit quaternion of a rotation matrix.

    Source: Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1 (1978).
    """
    trace = float(np.trace(R))
    squares = np.array([trace, R[0, 0], R[1, 1], R[2, 2]])
    big = int(np.argmax(squares))
    q = np.empty(4)
    q[big] = 1 + (trace if big == 0 else 2 * squares[big] - trace)
    if big == 0:
        q[1:] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    else:
        i, j, k = big - 1, big % 3, (big + 1) % 3
        q[0] = R[k, j] - R[j, k]
        q[1 + j], q[1 + k] = R[j, i] + R[i, j], R[k, i] + R[i, k]
    q /= np.linalg.norm(q)
    return (float(q[0]), float(q[1]), float(q[2]), float(q[3]))


def _upright(normal: Vector3) -> tuple[float, float, float, float]:
    """The rotation that turns z into `normal`."""
    n = np.array(normal)
    if n[2] < -1 + 1e-12:
        return (0.0, 1.0, 0.0, 0.0)
    q = np.array([1 + n[2], -n[1], n[0], 0.0])
    q /= np.linalg.norm(q)
    return (float(q[0]), float(q[1]), float(q[2]), float(q[3]))


def _range(joint: Joint) -> list[float] | None:
    """Both bounds of a coordinate, open ones beyond reach. Raises: Unsupported."""
    limits: Limits | None = getattr(joint, "limits", None)
    if limits is None or (limits.lower is None and limits.upper is None):
        return None
    lower = -OPEN if limits.lower is None else limits.lower
    upper = OPEN if limits.upper is None else limits.upper
    if lower >= upper:
        raise Unsupported(f"joint '{joint.name}': limits {lower:g}..{upper:g} of no width", "MuJoCo's ranges have a width")
    return [lower, upper]


def _convex(vertices: Floats, faces: Integers) -> bool:
    """Is the mesh closed, with no vertex above any face by more than rounding of single precision?"""
    edges = {(int(f[i]), int(f[(i + 1) % 3])) for f in faces for i in range(3)}
    if any((b, a) not in edges for a, b in edges):
        return False
    size = float(np.ptp(vertices, axis=0).max())
    for face in faces:
        a, b, c = vertices[face]
        normal = np.cross(b - a, c - a)
        if float(((vertices - a) @ normal).max()) > 1e-6 * size * float(np.linalg.norm(normal)):
            return False
    return True


# -- Adapter -------------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class MujocoAdapter(Adapter):
    """MuJoCo."""

    def version(self) -> str:
        """The installed version. Raises: Unavailable."""
        return str(_mujoco().__version__)

    def build(self, scene: Scene, settings: Settings) -> MujocoSimulation:
        """Exactly this scene. Raises: Unsupported, Unavailable, SettingsError."""
        return _Builder(_mujoco(), scene, settings).simulation()


ADAPTER = MujocoAdapter(
    name="mujoco",
    title="MuJoCo",
    distribution="mujoco",
    features=~(Feature.STATIC_FRICTION | Feature.RAY_TRACING),
    tracks={
        "default": Settings(
            source="MuJoCo's own defaults: Euler, Newton, 100 iterations, tolerance 1e-8, pyramidal cone, impratio 1"
        ),
        "tuned": Settings(
            tolerance=1e-10,
            options={
                "by_scene": True,
                "cone": "elliptic",
                "impratio": 10.0,
                "contact_steps": 20.0,
                "contact_damping_ratio": 1.2,
                "contact_impedance": 0.999,
                "limit_steps": 2.0,
                "limit_damping_ratio": 1.7,
                "limit_impedance": 0.999,
                "slowest": VENDOR_TIME_CONSTANT,
                "loop_steps": 2.0,
                "loop_impedance": 0.999,
            },
            source=(
                "MuJoCo documentation: 'Modeling', preventing slip (elliptic cone, impratio above 1) and solver parameters "
                "(time constant at least twice the time step; measured here: below 20 steps contacts lift what slides, below "
                "damping ratio 1.2 they rebound; a stop, along which nothing slides, is held at two steps, and of ratio 1.7 "
                "returns a rod by .008 rad where one of 1 does by .05; the emulated rebound lasts ten steps: with them bounces "
                "err least in height over the ladder); 'Computation', numerical integration (RK4 for smooth scenes whose "
                "springs and dampers it resolves, implicit for stiffer dampers, discrete for stiffer springs; measured here: "
                "in contact the implicit one jitters where Euler rests); change log of 4.0.1 (sparse factor of 4.0.0: dense "
                "Jacobian)"
            ),
        ),
    },
    knobs={
        "integrator": INTEGRATORS,
        "substeps": (1, 2, 4, 8),
        "solver": SOLVERS,
        "iterations": (5, 20, 100),
        "tolerance": (1e-6, 1e-8, 1e-10, 1e-12),
        "options.cone": ("pyramidal", "elliptic"),
        "options.impratio": (1.0, 10.0, 100.0),
        "options.noslip_iterations": (0, 5, 20),
        # A search turns a knob to its next value first. Where steps are long, tuned's `slowest` decides what 20 steps and more
        # are: four of them are the first that tell, and so is a shorter `slowest`.
        "options.contact_steps": (40.0, 20.0, 4.0, 2.0, 0.5),
        "options.contact_damping_ratio": (1.0, 1.2, 2.0),
        "options.contact_impedance": (0.95, 0.999, 0.9999),
        "options.friction_steps": (2.0, 5.0, 10.0, 20.0, 40.0),
        "options.rebound_steps": (5, 10, 20, 40, 80),
        "options.limit_steps": (2.0, 5.0, 20.0),
        "options.limit_damping_ratio": (1.0, 1.7, 3.0),
        "options.loop_steps": (2.0, 5.0, 20.0),
        "options.loop_impedance": (0.95, 0.999, 0.9999),
        "options.slowest": (0.1, VENDOR_TIME_CONSTANT, 0.005, 0.001),
        "options.jacobian": ("auto", "dense", "sparse"),
    },
    acts_on={
        **dict.fromkeys(("solver", "iterations", "tolerance", "options.jacobian"), Effect.CONTACT | Effect.JOINTS),
        **dict.fromkeys(("options.cone", "options.contact_steps", "options.contact_damping_ratio"), Effect.CONTACT),
        "options.contact_impedance": Effect.CONTACT,
        **dict.fromkeys(("options.impratio", "options.friction_steps"), Effect.FRICTION),
        "options.noslip_iterations": Effect.FRICTION | Effect.JOINTS,
        "options.rebound_steps": Effect.RESTITUTION,
        **dict.fromkeys(("options.limit_steps", "options.limit_damping_ratio"), Effect.JOINTS),
        **dict.fromkeys(("options.loop_steps", "options.loop_impedance"), Effect.JOINTS),
    },
    known_failures={
        "default/continuous_collision_stops_a_fast_ball": "the vendor leaves speculative contacts off",
        "default/friction_is_isotropic": "the vendor's default cone is a pyramid: friction towards its edges is up to 41 % off",
        "default/rolling_friction_brakes": "the vendor's default cone is a pyramid: it weakens rolling friction by 15 %",
        "default/distance_joint_keeps_its_length": (
            "the vendor's default time constant of constraints is .02 s: a rod that is let fall gives way by .7 %"
        ),
    },
    trade_offs={
        "friction_backspin/ladder": (
            "a ball that slides hops on a soft contact, and where it lands is chance: at six steps .94 to 2.1 times the "
            "error of the default, between .16 and 1.9 m/s; a damping ratio of 1 only moves the scatter"
        ),
        "friction_painleve/ladder": (
            "contacts of 20 steps are stiffer than the vendor's below 1e-3 s, and lift what slides: at 1/7680 s .0070 "
            "against .0007; 40 steps bring .0006, but lose what stands and what must not pass: at 1/1920 s a pyramid "
            "drifts .029 mm for .007, and a thin mesh lets 9 % through for none"
        ),
        "joint_long_run/ladder": (
            "RK4 loses a share of z^5/144 of an amplitude a radian, z being the phase of a step; Euler is symplectic: at "
            "1/20 s 9.5e-6 against 1.5e-7, the bound being 3.8e-4; from 1/90 s down RK4 errs less"
        ),
        "orbit_kepler/ladder": (
            "told its force once a step, RK4 drifts, kicks and drifts, and is of second order as the default: within an "
            "eighth of it but at 1/60 s, where the textbook's drift, kick and drift itself measures the same 20.8 rad as "
            "it passes the middle of its path 98 times in 100 turns; the angle at the end errs by 4.14 rad, by 4.23 on "
            "default"
        ),
        "stack_pile/ladder": (
            "where a pile comes to rest in steps of 1/60 s is chance: .0131 against .0071, and .0062 to .0107 under five "
            "other settings of cone, impratio, damping ratio and impedance; from 1/480 s down tuned errs less"
        ),
    },
    loads=("mujoco",),
    orders={"euler": 1, "implicit": 1, "implicitfast": 1, "discrete": 1, "rk4": 4},
    emulated=(
        Emulation(
            feature=Feature.RESTITUTION,
            how="MuJoCo has no coefficient of restitution; the contact is given a stiffness and a damping whose mean rebound "
            "is e, and friction beside it a time constant of its own",
        ),
        Emulation(
            feature=Feature.KINEMATIC,
            how="MuJoCo has no body of prescribed velocity; it is a free one with an armature of 1e12 times the scene's mass",
        ),
        Emulation(
            feature=Feature.CLOSED_LOOP,
            how="MuJoCo closes loops by points and welds; a revolute joint is two points of its axis, each held together",
            where="where a revolute joint closes the loop",
        ),
    ),
    deviations=(
        "contacts, limits and loop joints are soft: they sink, creep and gap",
        "MuJoCo has no restitution: the adapter emulates it by a spring and damper, calibrated to the mean rebound; single "
        "rebounds scatter with the phase of the step",
        "a slip bends a rebound: by up to 20 % up to three times the speed of approach (43 % at e = .3), by more where faster",
        "without restitution a contact is critically damped and cannot pull: it gives back up to .135 of the speed of impact",
        "sliding, torsional and rolling friction share one cone",
        "friction is soft: a damper to slips below half of mu g times its time constant; faster ones press bodies apart",
        "the gyroscopic term cannot be switched off",
        "meshes and hulls are held in single precision, and a mesh collides as its hull",
    ),
)
