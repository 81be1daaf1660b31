"""The one boundary between the harness and an engine.

An adapter file holds one frozen `Adapter` subclass and ends in `ADAPTER = ...`. Its stations, in this order: docstring (engine,
version tried, sources, section *Deviations*), constants, the `Simulation`, the builder, the `Adapter`, `ADAPTER`. A package has
the first and the last two in its `__init__` and one station a file. The vendor's package is imported inside functions only.

The contract, proven by `harness.conformance`:

* `build` takes the scene exactly as it is or raises `Unsupported(what, why)`; it never approximates in silence. What cannot
  be avoided stands under *Deviations*.
* Two bodies touch only where `scene.collides(a, b)`: pairs of materials in `scene.apart` and pairs held by a joint never do.
* States come in the order of `scene.bodies`, static and kinematic bodies included; p_WB is the centre of mass, q_WB is
  (w, x, y, z), velocities are of the centre of mass and in W. After `build`, `state` gives the scene's initial state.
* `step(count)` advances exactly count * dt; where the engine can, in one native call.
* `Settings` fields left None are the vendor's defaults. `dt` is always given. An option that the adapter does not know is an
  error (`SettingsError`). `Simulation.resolved` says what the engine really uses.
* Tracks: `default` is what a newcomer gets (the vendor's physics defaults left alone: damping, sleeping, clamps, pyramids),
  though frames, units, order, finiteness, shapes, and the scene's own material law are right; `tuned` switches off what
  the scene does not ask for and follows the vendor's recommendation for this kind of scene, with the source cited.
* The point of a contact lies half-way between the two surfaces, along its normal: gap/2 off each.
* Only the effects in `scene.effects` are simulated; what cannot be switched off is listed in `warnings()` as a `Notice` of kind
  'surplus' with its effect.
* Continuous collision is a means, not a law of the scene: where an engine lacks it, or its vendor leaves it off on `default`,
  a scene that calls for it runs without, and `warnings()` has a `Notice` of kind 'missing' with that effect.
* What comes back is checked too: quaternions have norm 1, `warnings()` holds texts and notices, `resolved` text, Python's own
  numbers and lists and names of such; contacts, hits, pictures and inertial readings are arrays as `harness.trajectory` says
  (see `harness.adapter.what_comes_out`). What breaks that is a crash with a reason, and costs its own cell. What `state` leaves
  out is not finite.
* Arrays that are handed in are checked at one door, `harness.adapter.what_goes_in`: `wrench`, `cast`, `caster`, `command` and
  `state` raise `ValueError` for a wrong shape, type or content before the engine sees them.
* A state that stopped being finite is never repaired: after a silent auto-reset or repair, `step` raises `Diverged`.
* Seven things may be offered beyond the protocol. For sensors: `Simulation.inertial(name)`, what the engine's own accelerometer
  and gyroscope [m/s2, rad/s], each (3,) in S, say at this instant for the scene's sensor of that name. For the clock:
  `build_batch`, many worlds of one scene on one thread, and `Simulation.caster(origins, directions, max_range)`, a function
  that casts the same rays again into arrays made beforehand. For forces told anew before each step: `Simulation.force_lead`,
  the share of a step after whose start a force held over it is to be evaluated (see `harness.case.forces`); 0 unless said.
  For joints: `Simulation.joint_states()`, the coordinates, rates and reactions that the engine itself holds of the scene's
  joints at this instant (see `harness.trajectory.joint_states`), NaN where it holds none; `harness.adapter.joints.joints_of`
  reads every engine's, from the poses of the bodies where the engine says nothing. For bodies whose motion is prescribed:
  `Simulation.prescribe(velocities)`, (v_WB, w_WB) [m/s, rad/s] by the names of such bodies, which hold from the next step on
  until told otherwise. What is joined to such a body follows by its joints alone, and contacts meet it at its velocity.
  For steps of uneven lengths: `Simulation.retime(dt)`, the length [s] of each step from the next one on, sub-steps dividing it,
  which raises `Unsupported` where what a step takes over from the last one would not fit.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Flag, auto
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbline.harness.adapter.kernels import Kernels
from plumbline.harness.adapter.many_worlds import Batch, Turns
from plumbline.harness.adapter.settings import Settings
from plumbline.harness.adapter.simulation import Simulation
from plumbline.harness.adapter.trade_off import Advantage, Extra, TradeOff, check_named
from plumbline.harness.scene import Effect, Scene
from plumbline.harness.trajectory import Floats

if TYPE_CHECKING:
    from plumbline.harness.scene.parity.canonical import Canonical
    from plumbline.harness.scene.parity.loaded import Loaded, Request
    from plumbline.harness.scene.parity.parting import Motion


class Feature(Flag):
    """What an engine can express; conformance builds a scene for each claimed one and expects `Unsupported` for the others."""

    NONE = 0
    SPHERE = auto()
    BOX = auto()
    CAPSULE = auto()
    CYLINDER = auto()
    ELLIPSOID = auto()
    PLANE = auto()
    CONVEX_HULL = auto()
    TRIANGLE_MESH = auto()
    MOVING_MESH = auto()
    """A triangle mesh, convex or not, of a body that forces move."""
    COMPOUND = auto()
    FULL_INERTIA = auto()
    """Products of inertia: principal axes turned against B."""
    KINEMATIC = auto()
    PRESCRIBED_MOTION = auto()
    """Kinematic bodies whose velocities are told anew before each step."""
    MASS_POINT = auto()
    """Bodies without inertia, which nothing turns or which are fixed to others."""
    MASSLESS = auto()
    """Bodies without mass between joints: several joints, one after the other, that move one body."""
    FIXED = auto()
    BALL = auto()
    REVOLUTE = auto()
    PRISMATIC = auto()
    DISTANCE = auto()
    DISTANCE_SPRING = auto()
    """A spring and damper between two points, which holds nothing."""
    CLOSED_LOOP = auto()
    LIMITS = auto()
    SPRINGS = auto()
    DRIVES = auto()
    ARMATURE = auto()
    """Inertia of rotors, along joint coordinates alone."""
    FRICTION_LOSS = auto()
    """Dry friction along joint coordinates."""
    SPEED_LIMIT = auto()
    """A hard bound of a joint coordinate's rate, whose reaction acts on both bodies."""
    COUPLING = auto()
    """Joint coordinates tied to each other linearly."""
    FEEDFORWARD = auto()
    """A constant torque or force in a drive's law, and so motors."""
    TENDON = auto()
    """Springs, drives and limits along linear combinations of joint coordinates."""
    PAIR_FRICTION = auto()
    """Friction per pair of materials, whatever the pairs."""
    STATIC_FRICTION = auto()
    """Static friction above kinetic friction."""
    ROLLING_FRICTION = auto()
    TORSIONAL_FRICTION = auto()
    RESTITUTION = auto()
    LINEAR_DAMPING = auto()
    ANGULAR_DAMPING = auto()
    CONTINUOUS_COLLISION = auto()
    CONTACTS = auto()
    CONTACT_FORCES = auto()
    RAYS = auto()
    RENDER = auto()
    RAY_TRACING = auto()
    """Pictures with shadows, reflection and refraction, through any lens."""
    WRENCH = auto()
    SAVE = auto()
    NATIVE_STEPS = auto()
    STEP_LENGTHS = auto()
    """Steps whose length is told anew before each."""

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the bits that are set, in lower case, in the order of definition."""
        return tuple(feature.name.lower() for feature in Feature if feature in self and feature.name is not None)


class Unsupported(Exception):
    """The engine cannot express `what`; `why` says which property of the engine stands against it."""

    def __init__(self, what: str, why: str) -> None:
        super().__init__(f"{what}: {why}")
        self.what, self.why = what, why


class Unavailable(Exception):
    """The engine is not installed or cannot be loaded; the text says why and what to do."""


class Diverged(Exception):
    """The engine's state stopped being finite, or the engine reset or repaired it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Emulation:
    """A law that the adapter makes, because its engine has none of its own or none that says the same.

    Terms:
        feature: one of those that the adapter claims. how: what the engine lacks and what stands for it, as a sentence without
        its full stop. where: what confines it, as a clause; '' where every scene with the feature has it. tracks: those on
        which it does.
    """

    feature: Feature
    how: str
    where: str = ""
    tracks: tuple[str, ...] = ("default", "tuned")


@dataclass(frozen=True, kw_only=True)
class Adapter(ABC):
    """One engine.

    Terms:
        name: as on the command line. distribution: the package that is installed. title: as in the report. features: what it
        claims. tracks: 'default' and 'tuned'. knobs: setting name (or 'options.<name>') to the values its users would try.
        acts_on: for knobs that mean nothing in other scenes, the effects of which a scene calls for one; a test holds it to be
        true. remedies: by name, a knob and the value that its documentation turns it to where a motion breaks. known_failures:
        '<track>/<check>' of conformance to the reason, run as strict expected failures. trade_offs: where 'default' or one knob
        turned beats 'tuned', and why; the study `dominance` holds it true. deviations: what every answer of this engine
        carries, whatever the track. emulated: the features that it claims and the adapter makes, with how; all others are the
        engine's own. laws: the functions, 'module:name' or 'module:class.name', by which it works such features out in every
        step: a price tells which share of it they took. advantages: of the engine that the others are compared with, why it
        errs least where it does: '<track>/<case>'. orders: what each integrator, by its name in `Simulation.resolved`, promises
        for smooth motion. staggered: tracks on which the velocities of joined bodies are handed out as they were a sub-step
        before their positions. compile_allowance [s]: what an engine that compiles itself on first use may take for that, once,
        beyond a trial's deadline. kernels: a function at the top of a module, which tells what such an engine can compile
        beforehand (`plumbline warm`); raises Unavailable. threads: numbers of threads that one world can be stepped on, by its
        option 'threads'; none where it takes one. loads: modules that take long to load and say nothing when they are; accuracy
        runs start with them loaded. single_precision: the engine computes in single precision, so that its states have seven
        digits. licence: of the package, an SPDX identifier; '' where it is not known. platforms: for which its package index
        has wheels, as '<system>-<machine>': linux-x86_64, linux-aarch64, macos-arm64, windows-x86_64. loaders: the ways in
        which its own package reads a robot file, '' for its defaults; none where it reads none. loader_defaults: by loader and
        ending of a file, the quantities that its documentation says it changes, each with the place that says so. extra: what
        installing it takes, of an engine that plumbline does not depend on.
    """

    name: str
    title: str
    distribution: str
    features: Feature
    tracks: Mapping[str, Settings]
    knobs: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    acts_on: Mapping[str, Effect] = field(default_factory=dict)
    remedies: Mapping[str, tuple[str, Any]] = field(default_factory=dict)
    known_failures: Mapping[str, str] = field(default_factory=dict)
    trade_offs: tuple[TradeOff, ...] = ()
    deviations: tuple[str, ...] = ()
    emulated: tuple[Emulation, ...] = ()
    laws: tuple[str, ...] = ()
    advantages: Mapping[str, Advantage] = field(default_factory=dict)
    orders: Mapping[str, int] = field(default_factory=dict)
    staggered: tuple[str, ...] = ()
    compile_allowance: float = 0.0
    kernels: Callable[[], Kernels] = Kernels
    threads: tuple[int, ...] = ()
    loads: tuple[str, ...] = ()
    single_precision: bool = False
    licence: str = ""
    platforms: tuple[str, ...] = ()
    loaders: tuple[str, ...] = ()
    loader_defaults: Mapping[tuple[str, str], Mapping[str, str]] = field(default_factory=dict)
    extra: Extra | None = None

    def __post_init__(self) -> None:
        for emulation in self.emulated:
            where = f"adapter '{self.name}': emulated {'|'.join(emulation.feature.names)}"
            if len(emulation.feature.names) != 1 or emulation.feature not in self.features:
                raise ValueError(f"{where}: expected one feature that the adapter claims")
            if not emulation.how.strip() or not emulation.tracks or not set(emulation.tracks) <= set(self.tracks):
                raise ValueError(f"{where}: expected how, and on which of the tracks {', '.join(self.tracks)}")
        check_named(self.name, self.trade_offs, self.knobs)

    def knobs_in(self, scene: Scene) -> tuple[str, ...]:
        """The knobs that may mean something in this scene."""
        return tuple(knob for knob in self.knobs if knob not in self.acts_on or self.acts_on[knob] & scene.effects)

    def compile(self, scene: Scene, settings: Settings) -> None:  # noqa: B027  most engines come compiled
        """Compile what this scene needs, where the engine does such a thing; a deadline begins after it. Raises: as `build`."""

    def load_robot(self, path: Path, request: "Request") -> "Loaded":
        """What the engine's own package makes of a robot file (URDF or MJCF), read back by its own means.

        Args: request: which of `loaders`, how a root is held, where packages lie. Raises: Unsupported, Unavailable.
        """
        raise Unsupported(f"{path.name} by loader {request.way!r}", f"{self.title} has no loader of its own for URDF and MJCF")

    def move_robot(self, robot: "Canonical", motion: "Motion") -> Floats:  # noqa: ARG002  # an engine may decline
        """Positions of a robot in canonical form that torques move: (samples, joints, 4), DT apart from the start on.

        Each is the coordinate [rad or m] and zeros, or the quaternion of a ball or free joint in W.

        Raises: Unsupported, Unavailable.
        """
        raise Unsupported(f"the motion of {robot.source}", f"{self.title} moves scenes alone")

    @abstractmethod
    def version(self) -> str:
        """The installed version. Raises: Unavailable."""

    @abstractmethod
    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """Exactly this scene under these settings. Raises: Unsupported, Unavailable, SettingsError."""

    def build_batch(self, scene: Scene, settings: Settings, count: int) -> Batch:
        """`count` equal worlds that are stepped together; one simulation each, unless an adapter knows better.

        Raises: Unsupported, Unavailable, SettingsError.
        """
        made: list[Simulation] = []
        try:
            for _ in range(count):
                made.append(self.build(scene, settings))
        except BaseException:
            for simulation in made:
                simulation.close()
            raise
        return Turns(made)
