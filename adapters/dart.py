"""DART 6.20 through its Python binding dartpy: rigid bodies in reduced coordinates, contacts as a boxed or conic LCP.

Tried with dartpy 6.20.0 (Python 3.11, Linux x86-64).

Sources:
    J. Lee et al., *DART: Dynamic Animation and Robotics Toolkit*, JOSS 3(22), 2018; the C++ sources of 6.20:
    `constraint/ContactSurface.cpp` (smaller friction, product of restitution), `constraint/NsgsFrictionSolver.hpp` (exact
    Coulomb cone), `simulation/World.cpp` (semi-implicit Euler); gz-physics, `dartsim/src/EntityManagementFeatures.cc`
    (Gazebo runs DART with the ODE collision detector, track 'tuned').

A body without joints is a skeleton of its own under a `FreeJoint`, whose six velocities are (w_WB, v_WB). Trees of joints
become skeletons in reduced coordinates, rooted at the world, at a kinematic body or at a free body; joints that would
close a loop become constraints. Which joint is cut is our choice: fixed, ball and plain revolute joints alone can be. The
option 'joints' has all of these ('constraints') or the ball joints of what spins ('auto') be constraints on free bodies.

Settings of DART that are no knobs here: contacts have an error reduction (0.01 of the depth a step, 1 mm/s at most), a
softness (1e-5) and an allowance (0) too, but dartpy has no ContactConstraint to set them by. Softness and allowance of joints'
constraints stand at the end of their range that errs least (1e-9, 0), and the error reduction of joints' stops never comes to
bear, as DART meets stops exactly. Thresholds of sleep matter where bodies sleep. NSGS and FBF have a law of associated
friction, which dilates, and one of boxes, which is Dantzig's; their inner steps, the random order of PGS and the
over-relaxation of the matrix-free solver are as the vendor chose them. More threads for a world save no CPU time
(100 boxes in 25 piles: 2.0 ms a step on one, 2.1 ms on two).

Deviations:
    * Joints that close loops, and those that are constraints by 'joints', have a gap of second order in the step: they hold
      velocities, and a share of the gap is taken back a step ('error_reduction', 0.01 by default, 0.2 on 'tuned' as in ODE).
      The share is a static variable of the vendor; the adapter sets it for the steps of each world.
    * Sub-steps are steps of dt/substeps, forces from outside held; contacts and their forces are those of the last one.
    * 'drives': 'servo' is DART's own motor. It holds the velocity (c u + k (target - x))/(c + dt k) by whatever force within
      the limit that takes, as a constraint beside contacts: another law than the scene's, as stiff as can be. It does not sag.
    * Passive springs and dampers are DART's joint springs: implicit, (m + dt d + dt^2 k) v' = m v - dt k (x - rest). So are
      drives (option 'drives': 'spring', the default); with a limit it is the same implicit law, solved by the adapter for the
      drives of a skeleton together and then cut off. DART answers contacts, limits and loops with the mass matrix that knows
      no spring, so that a machine in equilibrium on such springs sags and gains energy, in proportion to dt (a quadruped of
      0.4 m by more than a centimetre within a second at 1/240 s; a plain torque of the start of the step holds it, but
      explodes where dt^2 k or dt d is not small against the inertia). On 'tuned' ('auto'), where something can hold them,
      springs and drives are therefore torques of the velocity foreseen for the end of the step ('stable': stable PD control
      with what bore in the last step): the same law, under which an equilibrium stays. An impact is foreseen one step late.
    * Damping of a joint-free body is DART's joint damping (implicit) where that is v' = -c v, w' = -c w exactly (no
      angular damping, or a spherical inertia); otherwise a force and a torque of the start of the step over (1 + c dt).
    * No detector has every pair of shapes right (`WRONG_PAIRS`). FCL, the vendor's default, has no capsule (it puts a ball of
      0.1 m there), lets balls fall through meshes and cylinders sink into boxes and each other, and gives a box on a plane one
      contact, on which it rocks and slides by another friction. A scene in which such pairs can meet uses the ODE detector on
      both tracks, and the Bullet detector where capsules can meet boxes or cylinders, cylinders each other, or two hulls or
      meshes that move; `warnings()` says so on 'default'. Where neither has all pairs right the scene is refused.
    * Under the Bullet detector, which holds a solid on a plane at one point, a plane is a box that ends a kilometre away;
      and a cylinder that lies creeps by rolling, up to 1 cm/s.
    * DART reports no contacts of bodies that it has put to sleep (track 'default'); theirs are repeated as they were last
      seen, at most 0.1 s and 32 steps before.
    * Convex hulls and meshes pass through an OBJ file in single precision; a hull is the mesh of its surface.
    * Restitution acts above an approach of 0.1 m/s and returns at most 100 m/s; friction or restitution of 1e-3 and less
      does not exist and is refused.
    * Dantzig, PGS and the matrix-free solver bound friction along two axes, a box instead of a cone: sliding askew to them
      meets up to 1.41 times as much.
    * Rays are cast by DART's own detector in a group of its own; a ray that starts inside a solid reports the exit, and
      inside the half space of a plane distance 0.
    * No more than 1000 contacts of a step are kept (dartpy cannot raise that bound); `warnings()` says so where it is met.
    * Contact points are those of the start of the last step, with the forces of that step.
"""

import contextlib
import importlib
import importlib.metadata
import math
import os
import re
import sys
import tempfile
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from itertools import combinations, combinations_with_replacement
from pathlib import Path
from typing import Any, assert_never

import numpy as np

from harness.adapter import Adapter, Diverged, Emulation, Feature, Settings, SettingsError, Simulation, Unavailable, Unsupported
from harness.adapter.what_goes_in import check_rays, check_state, check_targets, check_wrench
from harness.scene import (
    Ball,
    Body,
    Box,
    Camera,
    Capsule,
    ConvexHull,
    Cylinder,
    Distance,
    Drive,
    Effect,
    Fixed,
    Joint,
    Plane,
    Prismatic,
    Quaternion,
    Revolute,
    Scene,
    Shape,
    Sphere,
    Spring,
    TriangleMesh,
    Vector3,
    rotation_matrix,
)
from harness.trajectory import Contacts, Floats, Hits, Image, Integers, State

__all__ = ["ADAPTER"]

INTEGRATOR = "semi_implicit_euler"
DETECTORS = ("fcl", "ode", "dart", "bullet")


def _pairs(*pairs: str) -> frozenset[str]:
    return frozenset("/".join(sorted(pair.split("/"))) for pair in pairs)


MESHES = frozenset({"convex_hull", "triangle_mesh"})
ROUND = _pairs("box/capsule", "box/cylinder", "capsule/cylinder", "cylinder/cylinder")
ON_PLANES = _pairs("plane/box", "plane/capsule", "plane/cylinder")
WRONG_PAIRS: Mapping[str, frozenset[str]] = {
    "fcl": ON_PLANES | ROUND | _pairs("capsule/capsule", "capsule/sphere"),
    "dart": ON_PLANES | ROUND,
    "ode": ROUND - {"box/cylinder"},
    "bullet": _pairs("cylinder/convex_hull", "cylinder/triangle_mesh", "box/triangle_mesh"),
}
"""The pairs of shapes that each detector lets sink, rock or slide by another friction; hulls and meshes see `_wrong`.

Heights lost in 3 s at 1/240 s, of 0.1 m: capsule on a box by ODE all of it, on the end of a cylinder 42 mm, box or cylinder on
a lying cylinder or capsule by ODE 4 mm, cylinder on a box by FCL 97 mm and by DART's own detector 126 mm; cylinder lying on a
mesh by Bullet 10 mm and more, on a hull 19 mm, box on a mesh 3 mm.
"""
SLAB = 1e3
"""Under the Bullet detector, which holds a solid on a plane at one point, a plane is a slab of these half extents [m]."""
SOLVERS = ("dantzig", "pgs", "matrix_free", "nsgs", "fbf")
DRIVES = ("spring", "stable", "servo")
"""How springs and drives act: as DART's joint springs, or as torques of the velocity foreseen for the end of the step; or,
drives alone, by DART's own motor, which holds a velocity."""
SERVO_NOTE = (
    "drives: DART's own servo holds the velocity (c u + k (target - x))/(c + dt k) by whatever force within the limit: another "
    "law than the scene's k (target - x) + c (u - x')"
)
JOINTS = ("constraints", "coordinates")
"""How a tree holds together: where DART has one for the joint, by constraints on free bodies, or by joints' coordinates.

In this order, since a search that stands at 'auto' turns to the first, and 'auto' mostly is the second.
"""
SMALLEST_COEFFICIENT = 1e-3
"""DART_FRICTION_COEFF_THRESHOLD and DART_RESTITUTION_COEFF_THRESHOLD: what is not above counts as zero."""
SPUN = 2.0
"""By how much faster than it swings a body must wobble to count as a top.

What swings on a circle has 1 at most, a disc on a stem as long as its radius that spins fast enough not to fall 3 and more.
"""
CONE_TOLERANCE = 1e-6
"""Where the conic solver of 'auto' stops. By the vendor's 1e-5 the case friction_wall_pinch errs by 21 mm at 1/240 s, by this
one by 8.2 mm, as the exact Dantzig does."""
MANY_BODIES = 16
"""Above this number of movable bodies 'auto' leaves the conic solver, whose cost grows fastest."""
MOST_CONTACTS = 1000
"""CollisionOption::maxNumContacts; dartpy hands out a copy of the option, so that it cannot be raised.

Beyond it the touching pairs share the budget, each keeping its deepest contact (ConstraintSolver.cpp).
"""
STEPS_UNCHECKED = 32
"""How many steps go by between two looks for NaN within one call of `step`."""
SLOW = 0.1
"""Below this [rad/s and m/s] a body may be put to sleep; the vendor's thresholds are 0.05 and 0.01."""
REMEMBERED_EVERY = 0.1
"""How often [s] the contacts of slow bodies are kept; a body falls asleep after 0.5 s of rest."""
FIRST_STEPS = 4
"""What rests from the start sleeps from the second step on, so that its contacts must be caught at once."""
STILL = 1e-3
"""A body that has moved less [m] since its contacts were last seen still rests on them."""
SLIDING = 0.999
"""From this share of its greatest friction on a contact slides rather than sticks."""
SHARED = 1e-10
"""Of the mean mobility: what makes redundant contacts share a load, too little to give way."""
LARGEST_SPEED = 1e100
"""Far above this [rad/s or m/s] the squares in the equations of motion overflow, and DART puts zero for accelerations."""
LONGEST_RAY = 1e9
"""A ray is a segment in DART [m]; beyond this its fraction loses the millimetre."""
_NOTHING = contextlib.nullcontext()
WORLD_FRAME = -1
"""The place of the world, and of every static body, in the graph of joints."""


@dataclass(frozen=True, slots=True)
class _Edge:
    """A body in its skeleton: `joint` holds it to `parent`, `sign` is -1 where the scene's parent hangs on its child."""

    body: int
    parent: int
    joint: Joint | None
    sign: float


@dataclass(slots=True)
class _Motor:
    """A joint coordinate with its spring and drive: what the adapter sets, or works out in every step."""

    joint: Any
    skeleton: Any
    spring: Spring
    drive: Drive
    target: float
    stable: bool = False
    servo: bool = False
    push: float = 0.0

    @property
    def limited(self) -> bool:
        return self.drive.limit is not None

    @property
    def works(self) -> bool:
        """Is there something to be worked out in every step?"""
        return self.stable or self.servo or self.limited or self.push != 0.0

    def pace(self, dt: float) -> float:
        """The velocity [rad/s or m/s] at the end of a step under which the drive pushes no more, which the servo holds."""
        k, c = self.drive.stiffness, self.drive.damping
        return (c * self.drive.target_velocity + k * (self.target - float(self.joint.getPosition(0)))) / (c + dt * k)

    def forces(self, v: float, dt: float) -> tuple[float, float]:
        """What spring and drive exert [N m or N], without a limit, where a step at the velocity v leads."""
        x = self.joint.getPosition(0) + dt * v
        spring, drive = self.spring, self.drive
        return (
            spring.stiffness * (spring.rest - x) - spring.damping * v,
            drive.stiffness * (self.target - x) + drive.damping * (drive.target_velocity - v),
        )

    def inertia(self, dt: float, saturated: bool) -> float:
        """What the joint's inertia seems to grow by [kg m2 or kg], as the forces fall while its velocity grows."""
        drive = Drive() if saturated else self.drive
        return dt * (self.spring.damping + drive.damping) + dt**2 * (self.spring.stiffness + drive.stiffness)

    def cut(self, force: float) -> float:
        """The drive's force within its limit."""
        limit = self.drive.limit if self.drive.limit is not None else math.inf
        return float(min(max(force, -limit), limit))

    def rest(self) -> None:
        """Let spring and unlimited drive share DART's joint spring; what its rest cannot hold becomes a constant push."""
        if self.stable:
            return
        spring, drive = self.spring, self.drive
        shared = not (self.limited or self.servo)
        k = spring.stiffness + (drive.stiffness if shared else 0.0)
        force = spring.stiffness * spring.rest
        if shared:
            force += drive.stiffness * self.target + drive.damping * drive.target_velocity
        # DART refuses a rest position outside of the limits and says so on the console only.
        rest = min(max(force / k, self.joint.getPositionLowerLimit(0)), self.joint.getPositionUpperLimit(0)) if k > 0 else 0.0
        if k > 0:
            self.joint.setSpringStiffness(0, k)
            self.joint.setRestPosition(0, rest)
            rest = float(self.joint.getRestPosition(0))
        self.joint.setDampingCoefficient(0, spring.damping + (drive.damping if shared else 0.0))
        self.push = force - k * rest


@dataclass(slots=True)
class _Hold:
    """What holds skeletons: for each of them, by its place, the rows (r, n) of its Jacobian; J v = 0 while it holds.

    Terms:
        one_sided: does the first row push only? pull: what else it is known to exert, impulses (n,) on each skeleton.
    """

    rows: dict[int, Floats]
    one_sided: bool = False
    pull: dict[int, Floats] = field(default_factory=dict)


@dataclass(slots=True)
class _Built:
    """What the builder hands to the simulation.

    Terms:
        nodes: one BodyNode for each body. free: bodies alone under a FreeJoint; linked: all other moving ones. belts: joints of
        kinematic bodies with (w_WB, v_WB). damped: (body, linear, angular damping [1/s]) that act as forces. shapes: for rays.
    """

    scene: Scene
    dart: Any
    world: Any
    resolved: Settings
    nodes: list[Any]
    # The first skeletons belong to the bodies of `free`, in their order.
    free: list[int] = field(default_factory=list)
    linked: list[int] = field(default_factory=list)
    skeletons: list[Any] = field(default_factory=list)
    belts: list[tuple[Any, Floats]] = field(default_factory=list)
    damped: list[tuple[int, float, float]] = field(default_factory=list)
    motors: dict[str, _Motor] = field(default_factory=dict)
    shapes: list[Any] = field(default_factory=list)
    loops: list[tuple[tuple[int, Floats], ...]] = field(default_factory=list)
    friction_solver: Any = None
    notes: list[str] = field(default_factory=list)

    @property
    def substeps(self) -> int:
        """How many steps DART takes for one of the scene's."""
        return self.resolved.substeps or 1


class DartSimulation(Simulation):
    """One DART world."""

    def __init__(self, built: _Built) -> None:
        self._built: _Built | None = built
        self._rays: Any = None
        n = len(built.scene.bodies)
        self._wrench: tuple[Floats, Floats] | None = None
        self._last = State.initial(built.scene)
        self._movable = [i for i in range(n) if built.scene.bodies[i].movable]
        self._forced = bool(built.belts or built.damped or any(m.works for m in built.motors.values()))
        self._driven: dict[int, dict[str, _Motor]] = {}
        self._limits: list[tuple[int, Any]] = []
        self._skeleton_of: list[int | None] = [None] * n
        self._loose: list[Integers] = []
        if built.resolved.options["drives"] == "stable":
            self._survey(built)
        self._steps = 0
        self._crowded = False
        self._seen = (-math.inf, Contacts.none(), self._last.p_WB.copy())

    def _survey(self, built: _Built) -> None:
        """Whose drives are to be foreseen, and by what they can be held."""
        numbers = {skeleton.getName(): k for k, skeleton in enumerate(built.skeletons)}
        self._skeleton_of = [numbers.get(node.getSkeleton().getName()) for node in built.nodes]
        for name, motor in built.motors.items():
            self._driven.setdefault(numbers[motor.skeleton.getName()], {})[name] = motor
        for k, skeleton in enumerate(built.skeletons):
            joints = [skeleton.getJoint(i) for i in range(skeleton.getNumJoints())]
            held = built.dart.dynamics.ActuatorType.VELOCITY
            loose = [j.getIndexInSkeleton(i) for j in joints if j.getActuatorType() != held for i in range(j.getNumDofs())]
            self._loose.append(np.array(loose, dtype=np.int64))
            self._limits += [(k, j) for j in joints if j.getNumDofs() == 1 and j.areLimitsEnforced()]

    @property
    def _open(self) -> _Built:
        if self._built is None:
            raise RuntimeError("simulation: used after close")
        return self._built

    @property
    def resolved(self) -> Settings:
        """The settings that the world uses, read back from it."""
        return self._open.resolved

    def step(self, count: int = 1) -> None:
        """Advance by count * dt. Raises: Diverged."""
        built = self._open
        # Only constraints between bodies ask for it, and for a light world setting it is a part of a step's cost.
        with _correcting(built) if built.loops else _NOTHING:
            self._advance(built, count * built.substeps)

    def _advance(self, built: _Built, count: int) -> None:
        """Take `count` sub-steps. Raises: Diverged."""
        advance = built.world.step
        pushed = self._forced or self._wrench is not None
        while count > 0:
            # A run that broke is left early: DART would go on and fill the console with its repairs.
            few = min(count, 1 if built.resolved.options["deactivation"] and self._steps < FIRST_STEPS else STEPS_UNCHECKED)
            for _ in range(few):
                if pushed:
                    self._push(built)
                advance()
            count -= few
            self._steps += few
            self._check(built)

    def _push(self, built: _Built) -> None:
        """Forces and commands of the coming sub-step; DART forgets them after each."""
        if self._wrench is not None:
            for i in self._movable:
                built.nodes[i].addExtForce(self._wrench[0][i])
                built.nodes[i].addExtTorque(self._wrench[1][i], False)
        dt = built.world.getTimeStep()
        for i, c, d in built.damped:
            node, body = built.nodes[i], built.scene.bodies[i]
            node.addExtForce(-body.mass * c / (1 + c * dt) * node.getCOMLinearVelocity())
            R_WB = node.getWorldTransform().rotation()
            node.addExtTorque(-d / (1 + d * dt) * (R_WB @ np.asarray(body.inertia) @ R_WB.T @ node.getAngularVelocity()), False)
        for joint, velocity in built.belts:
            joint.setCommands(velocity)
        limited: dict[int, list[_Motor]] = {}
        for motor in built.motors.values():
            motor.joint.setCommand(0, motor.pace(dt) if motor.servo else motor.push)
            if motor.limited and not (motor.stable or motor.servo):
                limited.setdefault(id(motor.skeleton), []).append(motor)
        for motors in limited.values():
            self._drive(motors, dt)
        if self._driven:
            self._foresee(built, dt)

    def _drive(self, motors: list[_Motor], dt: float) -> None:
        """Limited drives: f = k (t - x') + c (u - v') with x' = x + dt v', v' = v + dt (a + M^-1 f), then cut off.

        a is the acceleration without them, M the mass matrix augmented by DART's implicit springs and dampers.
        """
        skeleton = motors[0].skeleton
        skeleton.computeForwardDynamics()
        places = [m.joint.getIndexInSkeleton(0) for m in motors]
        x, v, a = (np.asarray(f())[places] for f in (skeleton.getPositions, skeleton.getVelocities, skeleton.getAccelerations))
        mobility = np.linalg.inv(np.asarray(skeleton.getAugMassMatrix()))[np.ix_(places, places)]
        k, c = (np.array([getattr(m.drive, name) for m in motors]) for name in ("stiffness", "damping"))
        wanted = np.array([m.target for m in motors]), np.array([m.drive.target_velocity for m in motors])
        v_free = v + dt * a
        push = k * (wanted[0] - x - dt * v_free) + c * (wanted[1] - v_free)
        gain = dt * (c + dt * k)
        f = np.linalg.solve(np.eye(len(motors)) + gain[:, None] * mobility, push)
        for motor, force in zip(motors, f, strict=True):
            motor.joint.setCommand(0, motor.push + motor.cut(float(force)))

    def _foresee(self, built: _Built, dt: float) -> None:
        """Springs and drives as torques of the velocity v' that is foreseen for the end of the step (stable PD control).

        M (v' - u) = dt f(v') + J^T p and J v' = 0: u is what the step brings without springs and drives, f are their forces
        where v' leads, J the contacts, limits and loops that bore in the last step. DART finds p itself, under these torques.

        Source: J. Tan, K. Liu, G. Turk, Stable Proportional-Derivative Controllers, IEEE CG&A 31(4), 2011.
        """
        holds = self._holds(built, dt)
        reached, waiting = set[int](), list(self._driven)
        while waiting:
            if (one := waiting.pop()) not in reached:
                reached.add(one)
                waiting += [other for hold in holds if one in hold.rows for other in hold.rows]
        first, size, u = {}, 0, list[Floats]()
        for one in sorted(reached):
            skeleton = built.skeletons[one]
            skeleton.computeForwardDynamics()
            first[one] = size
            u.append(np.asarray(skeleton.getVelocities()) + dt * np.asarray(skeleton.getAccelerations()))
            size += len(u[-1])
        ahead = np.concatenate(u)
        bearing = [hold for hold in holds if reached.issuperset(hold.rows)]
        masses = {one: np.array(built.skeletons[one].getMassMatrix()) for one in reached}
        saturated: dict[str, float] = {}
        while True:
            mobility, push = np.zeros((size, size)), np.zeros(size)
            for one, mass in masses.items():
                gain = np.zeros(len(mass))
                for name, motor in self._driven.get(one, {}).items():
                    k = motor.joint.getIndexInSkeleton(0)
                    gain[k] = motor.inertia(dt, name in saturated)
                    spring, drive = motor.forces(ahead[first[one] + k], dt)
                    push[first[one] + k] = dt * (spring + saturated.get(name, drive))
                loose = self._loose[one]
                mobility[np.ix_(first[one] + loose, first[one] + loose)] = np.linalg.inv(
                    (mass + np.diag(gain))[np.ix_(loose, loose)]
                )
            end = _held(ahead, mobility, push, bearing, first)
            exceeded = False
            for one, motors in self._driven.items():
                for name, motor in motors.items():
                    spring, drive = motor.forces(end[first[one] + motor.joint.getIndexInSkeleton(0)], dt)
                    cut = saturated.get(name, motor.cut(drive))
                    motor.joint.setCommand(0, spring + cut)
                    if name not in saturated and cut != drive:
                        saturated[name], exceeded = cut, True
            if not exceeded:
                return

    def _holds(self, built: _Built, dt: float) -> list[_Hold]:
        """The contacts, limits and loops that bore in the last step; before the first one, whatever touches."""
        result = built.world.getLastCollisionResult()
        if self._steps == 0:
            solver = built.world.getConstraintSolver()
            result = built.dart.collision.CollisionResult()
            solver.getCollisionGroup().collide(solver.getCollisionOption(), result)
        jacobians: dict[int, Floats] = {}
        places: dict[int, Floats] = {}

        def of_point(place: int, point: Floats, along: Floats) -> tuple[int, Floats] | None:
            """Skeleton and rows of the velocities [m/s] of a point along directions (r, 3)."""
            one = self._skeleton_of[place]
            if one is None:
                return None
            node = built.nodes[place]
            if place not in jacobians:
                jacobians[place] = np.asarray(built.skeletons[one].getWorldJacobian(node))
                places[place] = np.asarray(node.getWorldTransform().translation())
            turn, way = jacobians[place][:3], jacobians[place][3:]
            return one, along @ way + np.cross(point - places[place], along) @ turn

        holds = []
        for contact in result.getContacts():
            force, normal = np.asarray(contact.force), np.asarray(contact.normal)
            load = float(force @ normal)
            if self._steps and load <= 0:
                continue
            objects = contact.collisionObject1, contact.collisionObject2
            grip = min(o.getShapeFrame().getDynamicsAspect().getFrictionCoeff() for o in objects)
            across = force - load * normal
            slides = grip <= SMALLEST_COEFFICIENT or (self._steps and math.hypot(*across) >= SLIDING * grip * load)
            along = normal[None] if slides else np.vstack((normal, _across(normal)))
            hold = _Hold({}, one_sided=True)
            for sign, object_ in zip((1.0, -1.0), objects, strict=True):
                found = of_point(_owner(object_), np.asarray(contact.point), np.vstack((along, across)))
                if found is not None:
                    one, rows = found
                    hold.rows[one] = hold.rows.get(one, 0.0) + sign * rows[:-1]
                    hold.pull[one] = hold.pull.get(one, 0.0) + sign * dt * rows[-1] * bool(slides)
            holds.append(hold)
        for one, joint in self._limits:
            impulse = joint.getConstraintImpulse(0)
            if impulse != 0:
                row = np.zeros((1, built.skeletons[one].getNumDofs()))
                row[0, joint.getIndexInSkeleton(0)] = math.copysign(1.0, impulse)
                holds.append(_Hold({one: row}, one_sided=True))
        for loop in built.loops:
            hold = _Hold({})
            for sign, (place, point) in zip((1.0, -1.0), loop, strict=False):
                X_WB = built.nodes[place].getWorldTransform()
                found = of_point(place, X_WB.translation() + X_WB.rotation() @ point, np.eye(3))
                if found is not None:
                    one, rows = found
                    hold.rows[one] = hold.rows.get(one, 0.0) + sign * rows
            holds.append(hold)
        return [hold for hold in holds if hold.rows]

    def _check(self, built: _Built) -> None:
        """DART replaces a pose that is not finite by the identity, but the velocities stay what they are: ask them."""
        if not built.skeletons:
            return
        fastest = float(np.abs(np.concatenate([s.getVelocities() for s in built.skeletons])).max(initial=0.0))
        if not fastest < LARGEST_SPEED:
            raise Diverged(
                f"a velocity of {fastest:g} rad/s or m/s after {self._steps} steps of {built.world.getTimeStep():g} s"
            )
        if built.resolved.options["deactivation"] and fastest < SLOW:
            self._remember(built)
        if not self._crowded and built.world.getLastCollisionResult().getNumContacts() >= MOST_CONTACTS:
            self._crowded = True

    def _remember(self, built: _Built) -> None:
        """Before slow bodies fall asleep, after which DART reports their contacts no more, keep them with their places."""
        if self._steps <= FIRST_STEPS or built.world.getTime() - self._seen[0] >= REMEMBERED_EVERY:
            contacts = self._reported(built)
            if len(contacts):
                self._seen = (built.world.getTime(), contacts, self._places(built))

    def _places(self, built: _Built) -> Floats:
        return np.array([node.getWorldTransform().translation() for node in built.nodes])

    def state(self, out: State) -> None:
        """Write the present state into the arrays of `out`."""
        check_state(len(self._open.scene.bodies), out)
        built, last = self._open, self._last
        if built.free:
            # A FreeJoint's coordinates are (rotation vector, p_WB) and (w_WB, v_WB): two reads instead of four.
            places = built.free
            x = np.array([s.getPositions() for s in built.skeletons[: len(places)]])
            v = np.array([s.getVelocities() for s in built.skeletons[: len(places)]])
            last.p_WB[places], last.v_WB[places], last.w_WB[places] = x[:, 3:], v[:, 3:], v[:, :3]
            self._turn(places, _quaternions(x[:, :3]))
        for i in built.linked:
            node = built.nodes[i]
            pose = node.getWorldTransform()
            last.p_WB[i], last.v_WB[i], last.w_WB[i] = (
                pose.translation(),
                node.getCOMLinearVelocity(),
                node.getAngularVelocity(),
            )
            self._turn([i], pose.quaternion().wxyz()[None])
        out.p_WB[:], out.q_WB[:], out.v_WB[:], out.w_WB[:] = last.p_WB, last.q_WB, last.v_WB, last.w_WB

    def _turn(self, places: list[int], q_WB: Floats) -> None:
        """Of the two quaternions of a rotation take the one next to the last answer, so that no component jumps."""
        flip = np.einsum("ij,ij->i", q_WB, self._last.q_WB[places]) < 0
        q_WB[flip] *= -1.0
        self._last.q_WB[places] = q_WB

    def contacts(self) -> Contacts:
        """The contacts of the last step, those of sleeping bodies as they were last seen."""
        built = self._open
        now, (_, seen, places) = self._reported(built), self._seen
        if not built.resolved.options["deactivation"] or not len(seen):
            return now
        awake = set(zip(now.body_A.tolist(), now.body_B.tolist(), strict=True))
        still = np.linalg.norm(self._places(built) - places, axis=1) < STILL
        keep = [still[a] and still[b] and (a, b) not in awake for a, b in zip(seen.body_A, seen.body_B, strict=True)]
        names = [f.name for f in fields(Contacts)]
        return Contacts(*(np.concatenate((getattr(now, n), getattr(seen, n)[keep])) for n in names))

    def _reported(self, built: _Built) -> Contacts:
        """What DART reports of the last step."""
        rows: list[tuple[int, int, Floats, Floats, float, Floats]] = []
        for contact in built.world.getLastCollisionResult().getContacts():
            # Normal and force belong to the first object, whichever body a detector puts there.
            b = _owner(contact.collisionObject1)
            a = _owner(contact.collisionObject2)
            if built.scene.bodies[a].movable or built.scene.bodies[b].movable:
                rows.append((a, b, contact.point, contact.normal, -contact.penetrationDepth, contact.force))
        if not rows:
            return Contacts.none()
        a_, b_, point, normal, gap, force = zip(*rows, strict=True)
        return Contacts.of(a_, b_, np.array(point), np.array(normal), np.array(gap), np.array(force))

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hit of each ray within max_range [m], by DART's own detector."""
        built = self._open
        collision = built.dart.collision
        check_rays(origins, directions, max_range)
        if max_range > LONGEST_RAY:
            raise ValueError(f"cast: max_range {max_range} m, expected at most {LONGEST_RAY:g}")
        if self._rays is None:
            self._rays = collision.DARTCollisionDetector().createCollisionGroup()
            for node in built.shapes:
                self._rays.addShapeFrame(node)
        distance: Floats = np.full(len(origins), np.inf)
        body: Integers = np.full(len(origins), -1, dtype=np.int64)
        normal: Floats = np.zeros((len(origins), 3))
        option = collision.RaycastOption(False, True)
        for r, (start, end) in enumerate(zip(origins, origins + max_range * directions, strict=True)):
            result = collision.RaycastResult()
            if built.shapes and self._rays.raycast(start, end, option, result):
                hit = result.mRayHits[0]
                distance[r] = max(hit.mFraction * max_range, 0.0)
                body[r] = _owner(hit.mCollisionObject)
                normal[r] = hit.mNormal
        return Hits(distance, body, normal)

    def render(self, camera: Camera, colour: bool = True) -> Image:  # noqa: ARG002  (the contract's signature; DART draws nothing)
        """Not there. Raises: Unsupported."""
        raise Unsupported("render", "dartpy draws through OpenSceneGraph into a window only; it has no headless picture")

    def command(self, targets: Mapping[str, float]) -> None:
        """Set the targets [rad or m] of drives by the names of their joints."""
        motors, scene = self._open.motors, self._open.scene
        check_targets(scene, targets)
        for name, target in targets.items():
            if name not in motors or Effect.DRIVES not in scene.effects:
                continue
            motor = motors[name]
            motor.target = float(target)
            motor.rest()
            self._forced = self._forced or motor.works

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Apply f_B_W (n, 3) N and tau_B_W (n, 3) N m in every step from now on; fixed and kinematic bodies take no notice."""
        check_wrench(len(self._open.scene.bodies), f_B_W, tau_B_W)
        f, tau = f_B_W.copy(), tau_B_W.copy()
        self._wrench = (f, tau) if f.any() or tau.any() else None

    def warnings(self) -> tuple[str, ...]:
        """Stand-in detectors, surplus effects, the vendor's messages while building, and solves that stopped early."""
        built = self._open
        notes = list(built.notes)
        if built.friction_solver is not None:
            stats = built.friction_solver.getStats()
            if stats.numAcceptedAtCap or stats.numFailed:
                notes.append(
                    f"{built.resolved.solver}: of {stats.numSolves} solves {stats.numAcceptedAtCap} stopped at the greatest "
                    f"number of iterations and {stats.numFailed} were left to PGS"
                )
        if self._crowded:
            notes.append(f"contacts reached {MOST_CONTACTS}, which the pairs then share; dartpy cannot raise the bound")
        return tuple(notes)

    def save(self) -> object:
        """Not there. Raises: Unsupported."""
        raise Unsupported(
            "save",
            "the FCL and Bullet detectors keep memory that dartpy does not hand out; a run cannot be repeated",
        )

    def restore(self, saved: object) -> None:  # noqa: ARG002  (the contract's signature; there is nothing saved)
        """Not there. Raises: Unsupported."""
        raise Unsupported("restore", "the FCL and Bullet detectors keep memory that dartpy does not hand out")

    def close(self) -> None:
        """Free the world."""
        self._rays = None
        self._built = None


@contextlib.contextmanager
def _correcting(built: _Built) -> Iterator[None]:
    """While a world steps, DART's one error reduction parameter is that world's; other worlds have their own."""
    constraint = built.dart.constraint.DynamicJointConstraint
    usual, own = constraint.getErrorReductionParameter(), built.resolved.options["error_reduction"]
    if usual == own:
        yield
        return
    constraint.setErrorReductionParameter(own)
    try:
        yield
    finally:
        constraint.setErrorReductionParameter(usual)


def _owner(collision_object: Any) -> int:
    """The place in the scene of the body that a collision object belongs to; the name of its shape begins with it."""
    return int(collision_object.getShapeFrame().getName().split("/", 1)[0])


def _held(ahead: Floats, mobility: Floats, push: Floats, holds: list[_Hold], first: Mapping[int, int]) -> Floats:
    """Velocities (n,) after the impulses `push` and those by which holds bear; a one-sided hold that would pull lets go.

    Terms:
        ahead: velocities (n,) without impulses. mobility (n, n). first: the place of each skeleton's first coordinate.
    """
    push = push.copy()
    for hold in holds:
        for one, impulse in hold.pull.items():
            push[first[one] : first[one] + len(impulse)] += impulse
    free: Floats = ahead + mobility @ push
    while holds:
        starts = np.cumsum([0, *(len(next(iter(hold.rows.values()))) for hold in holds)])
        jacobian = np.zeros((starts[-1], len(ahead)))
        for hold, start in zip(holds, starts, strict=False):
            for one, rows in hold.rows.items():
                jacobian[start : start + len(rows), first[one] : first[one] + rows.shape[1]] = rows
        given = jacobian @ mobility @ jacobian.T
        given[np.diag_indices_from(given)] += SHARED * np.trace(given) / len(given) + np.finfo(np.float64).tiny
        p = np.linalg.solve(given, -jacobian @ free)
        kept = [hold for hold, start in zip(holds, starts, strict=False) if not (hold.one_sided and p[start] < 0)]
        if len(kept) == len(holds):
            return free + mobility @ jacobian.T @ p
        holds = kept
    return free


def _across(normal: Floats) -> Floats:
    """Two directions (2, 3) across a unit vector and each other."""
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    return np.vstack((first, np.cross(normal, first)))


def _quaternions(turn: Floats) -> Floats:
    """Unit quaternions (w, x, y, z) of rotation vectors [rad], shape (n, 3) to (n, 4)."""
    half = np.linalg.norm(turn, axis=1) / 2
    # numpy's sinc is sin(pi x)/(pi x), and so finite at zero.
    return np.column_stack((np.cos(half), turn * (0.5 * np.sinc(half / np.pi))[:, None]))


@contextlib.contextmanager
def _overheard(lines: list[str]) -> Iterator[None]:
    """Turn the vendor's console (file descriptors 1 and 2) into lines, so that it neither pollutes an output nor gets lost."""
    sys.stdout.flush()
    sys.stderr.flush()
    with tempfile.TemporaryFile() as heard:
        kept = os.dup(1), os.dup(2)
        os.dup2(heard.fileno(), 1)
        os.dup2(heard.fileno(), 2)
        try:
            yield
        finally:
            for descriptor, target in zip(kept, (1, 2), strict=True):
                os.dup2(descriptor, target)
                os.close(descriptor)
            heard.seek(0)
            text = re.sub(r"\x1b\[[0-9;]*m", "", heard.read().decode(errors="replace"))
            lines.extend(dict.fromkeys(line.strip() for line in text.splitlines() if line.strip()))


def _classes(scene: Scene) -> dict[tuple[str, bool], int]:
    """How many bodies with shapes there are of each (material, movable)."""
    found: dict[tuple[str, bool], int] = {}
    for body in scene.bodies:
        if body.collision:
            found[body.material, body.movable] = found.get((body.material, body.movable), 0) + 1
    return found


Kind = tuple[str, bool]


def _coefficients(scene: Scene) -> dict[Kind, tuple[float, float]]:
    """(friction, restitution) for each (material, movable) so that DART's rules give every pair's law exactly.

    Friction: min(f_a, f_b) = mu_ab has a solution only if f_a = max over b of mu_ab is one. Restitution: r_a r_b = e_ab.
    Raises: Unsupported.
    """
    effects, kinds = scene.effects, _classes(scene)
    laws, apart = {s.pair: s for s in scene.surfaces}, {frozenset(pair) for pair in scene.apart}
    friction: dict[tuple[Kind, Kind], float] = {}
    bounce: dict[tuple[Kind, Kind], float] = {}
    for a in kinds:
        for b in kinds:
            if b < a or not (a[1] or b[1]) or (a == b and kinds[a] < 2) or frozenset((a[0], b[0])) in apart:
                continue
            law = laws[frozenset((a[0], b[0]))]
            name = f"surface {law.between[0]}/{law.between[1]}"
            if Effect.ROLLING_FRICTION in effects and law.rolling_friction > 0:
                raise Unsupported(name, "DART has no rolling friction")
            if Effect.TORSIONAL_FRICTION in effects and law.torsional_friction > 0:
                raise Unsupported(name, "DART has no torsional friction")
            mu = law.kinetic_friction if Effect.FRICTION in effects else 0.0
            if Effect.FRICTION in effects and law.static_friction > law.kinetic_friction:
                raise Unsupported(name, f"DART has one coefficient, not static {law.static_friction} above kinetic {mu}")
            e = law.restitution if Effect.RESTITUTION in effects else 0.0
            for what, value in (("friction", mu), ("restitution", e)):
                if 0 < value <= SMALLEST_COEFFICIENT:
                    raise Unsupported(name, f"DART takes a {what} of {SMALLEST_COEFFICIENT} and less for zero, got {value}")
            friction[a, b], bounce[a, b] = mu, e
    f = {kind: max((mu for pair, mu in friction.items() if kind in pair), default=0.0) for kind in kinds}
    for (a, b), mu in friction.items():
        if min(f[a], f[b]) != mu:
            raise Unsupported(
                f"surface {a[0]}/{b[0]}",
                f"DART takes the smaller of two numbers, one for each material; none give {mu} here beside the others",
            )
    r = _factors(kinds, bounce)
    return {kind: (f[kind], r[kind]) for kind in kinds}


def _factors(kinds: Mapping[Kind, int], wanted: Mapping[tuple[Kind, Kind], float]) -> dict[Kind, float]:
    """Numbers r in 0..1 with r_a r_b = e for each wanted pair. Raises: Unsupported.

    Over each connected part of the graph of pairs log r_a = s t + o with s = +-1; t is free unless a cycle is odd.
    """
    near: dict[Kind, list[tuple[Kind, float]]] = {kind: [] for kind in kinds}
    for (a, b), e in wanted.items():
        if e > 0:
            near[a].append((b, math.log(e)))
            near[b].append((a, math.log(e)))
    r: dict[Kind, float] = {}
    for start in kinds:
        if start in r:
            continue
        if not near[start]:
            r[start] = 0.0
            continue
        line: dict[Kind, tuple[float, float]] = {start: (1.0, 0.0)}
        fixed: float | None = None
        queue = deque([start])
        while queue:
            a = queue.popleft()
            s, o = line[a]
            for b, log_e in near[a]:
                if b not in line:
                    line[b] = (-s, log_e - o)
                    queue.append(b)
                elif line[b][0] == s:
                    fixed = (log_e - o - line[b][1]) / (2 * s)
        low = max((o for s, o in line.values() if s < 0), default=-math.inf)
        high = min(-o for s, o in line.values() if s > 0)
        t = fixed if fixed is not None else (low + high) / 2
        for kind, (s, o) in line.items():
            r[kind] = min(math.exp(s * t + o), 1.0)
    for (a, b), e in wanted.items():
        if abs(r[a] * r[b] - e) > 1e-12:
            raise Unsupported(
                f"surface {a[0]}/{b[0]}",
                f"DART multiplies two numbers in 0..1, one for each material; none give {e} here beside the others",
            )
    return r


def _touching(scene: Scene) -> list[Body]:
    return [b for b in scene.bodies if b.collision] if Effect.CONTACT in scene.effects else []


def _meetings(scene: Scene) -> set[tuple[str, str, bool]]:
    """The pairs of shapes that can meet, each with its types in alphabetical order: and can both of them move?"""
    joined = scene.joined()
    apart = {frozenset(pair) for pair in scene.apart}
    groups: dict[tuple[str, bool, frozenset[str]], list[str]] = {}
    for body in _touching(scene):
        types = frozenset(placed.shape.type for placed in body.collision)
        groups.setdefault((body.material, body.movable, types), []).append(body.name)
    found = set()
    for (one, ones), (other, others) in combinations_with_replacement(groups.items(), 2):
        if not (one[1] or other[1]) or frozenset((one[0], other[0])) in apart:
            continue
        if any(a != b and frozenset((a, b)) not in joined for a in ones for b in others):
            found |= {(min(a, b), max(a, b), one[1] and other[1]) for a in one[2] for b in other[2]}
    return found


def _wrong(detector: str, meetings: set[tuple[str, str, bool]]) -> list[str]:
    """The pairs among `meetings` that a detector has wrong, as 'box/capsule'."""
    found = set()
    for a, b, both in meetings:
        meshes = len(MESHES & {a, b}) if a != b else 2 * (a in MESHES)
        # Balls fall through meshes by FCL, hulls by DART's own detector; two that move push each other sideways by ODE.
        loose = meshes > 0 if detector in ("fcl", "dart") else detector == "ode" and both and meshes == 2
        if loose or f"{a}/{b}" in WRONG_PAIRS[detector]:
            found.add(f"{a}/{b}")
    return sorted(found)


def _detector(scene: Scene, asked: str | None, notes: list[str]) -> str:
    """The detector of this scene: None is the vendor's default, 'auto' one that has every pair that can meet right.

    Raises: Unsupported.
    """
    meetings = _meetings(scene)
    if asked in DETECTORS:
        if wrong := _wrong(asked, meetings):
            raise Unsupported(
                f"{', '.join(wrong)} with the '{asked}' detector",
                "it lets such pairs sink, rock or slide by another friction; expected 'auto' or another detector",
            )
        return asked
    if asked is None and not _wrong("fcl", meetings):
        return "fcl"
    right = next((name for name in ("ode", "bullet") if not _wrong(name, meetings)), None)
    if right is None:
        raise Unsupported(
            ", ".join(_wrong("ode", meetings) + _wrong("bullet", meetings)),
            "of these pairs DART's ODE detector has the former wrong and its Bullet detector the latter; none has all right",
        )
    if asked is None:
        notes.append(
            f"detector: FCL, the vendor's default, has {', '.join(_wrong('fcl', meetings))} wrong; '{right}' stands in"
        )
    return right


def _reach(shape: Shape) -> float:
    """Radius [m] of the ball about the origin of S that holds the shape."""
    match shape:
        case Sphere(radius=r):
            return r
        case Box(half_extents=half):
            return math.hypot(*half)
        case Capsule(radius=r, half_length=h):
            return r + h
        case Cylinder(radius=r, half_length=h):
            return math.hypot(r, h)
        case Plane():
            return math.inf
        case ConvexHull(vertices=vertices) | TriangleMesh(vertices=vertices):
            return float(np.linalg.norm(np.asarray(vertices), axis=1).max())
        case _:
            assert_never(shape)


def _solver(scene: Scene, asked: str | None) -> str:
    """'auto': the exact cone where bodies slide on their own, Dantzig where they lean on each other or are many.

    On stacks the conic solvers cost some hundred times as much and stop at their iteration cap; stacks hardly slide.
    """
    if asked != "auto":
        return asked or "dantzig"
    bodies = [b for b in _touching(scene) if b.movable]
    if Effect.FRICTION not in scene.effects or not bodies or len(bodies) > MANY_BODIES:
        return "dantzig"
    p_WB = np.array([b.p_WB for b in bodies])
    reach = np.array([max(math.hypot(*p.p_BS) + _reach(p.shape) for p in b.collision) for b in bodies])
    gap = np.linalg.norm(p_WB[:, None] - p_WB[None], axis=2) - 1.01 * (reach[:, None] + reach[None])
    np.fill_diagonal(gap, np.inf)
    return "dantzig" if (gap <= 0).any() else "nsgs"


def _validated(settings: Settings) -> dict[str, Any]:
    """The options with their defaults. Raises: SettingsError."""
    known = {
        "detector": (None, "auto", *DETECTORS),
        "deactivation": (None, True, False),
        "split_impulse": (None, True, False),
        "drives": (None, "auto", *DRIVES),
        "joints": (None, "auto", *JOINTS),
    }
    share = settings.options.get("error_reduction")
    if share is not None and not (type(share) in (int, float) and 0 <= share <= 1):
        raise SettingsError(f"settings: option 'error_reduction' {share!r}, expected a share of an error, 0..1")
    for name, value in settings.options.items():
        if name == "error_reduction":
            continue
        if name not in known:
            raise SettingsError(
                f"settings: option '{name}' is unknown to dart, expected some of {', '.join(known)}, error_reduction"
            )
        allowed = known[name]
        if not any(value is one or (isinstance(one, str) and value == one) for one in allowed):
            raise SettingsError(f"settings: option '{name}' {value!r}, expected one of {allowed}")
    if settings.integrator not in (None, INTEGRATOR):
        raise SettingsError(f"settings: integrator '{settings.integrator}', expected '{INTEGRATOR}', the only one of dart")
    if settings.solver not in (None, "auto", *SOLVERS):
        raise SettingsError(f"settings: solver '{settings.solver}', expected one of auto, {', '.join(SOLVERS)}")
    if settings.solver in (None, "dantzig") and (settings.iterations is not None or settings.tolerance is not None):
        raise SettingsError("settings: iterations or tolerance; dantzig pivots to the exact solution, expected neither")
    return {name: settings.options.get(name) for name in (*known, "error_reduction")}


def _ends(scene: Scene, joint: Joint) -> tuple[int, int]:
    """The places of parent and child; static bodies are the world."""
    places = []
    for name in (joint.parent, joint.child):
        place = next((i for i, b in enumerate(scene.bodies) if b.name == name), WORLD_FRAME)
        places.append(WORLD_FRAME if place >= 0 and scene.bodies[place].motion == "static" else place)
    return places[0], places[1]


def _cuttable(joint: Joint) -> bool:
    """Has DART a loop-closing constraint for it?"""
    if isinstance(joint, Revolute):
        return joint.limits is None and joint.spring is None and joint.drive is None
    return isinstance(joint, Fixed | Ball)


def _wobble(body: Body, anchor: Floats) -> float:
    """The rate [rad/s] at which a body that is held at `anchor` [m, in W] wobbles about its spin by Euler's equations.

    w' = I^-1 (I w x w), linearised at the initial w; I about the anchor, in B.
    """
    R_WB = np.array(rotation_matrix(body.q_WB))
    moments = _about(body, anchor)
    w = R_WB.T @ np.array(body.w_WB)
    turned = np.linalg.solve(moments, _cross(moments @ w) - _cross(w) @ moments)
    return float(np.abs(np.linalg.eigvals(turned).imag).max())


def _swing(scene: Scene, body: Body, anchor: Floats) -> float:
    """The rate [rad/s] at which gravity would have that body swing, at most."""
    g = float(np.linalg.norm(scene.gravity)) if Effect.GRAVITY in scene.effects else 0.0
    lever = float(np.linalg.norm(np.array(body.p_WB) - anchor))
    return math.sqrt(body.mass * g * lever / float(np.linalg.eigvalsh(_about(body, anchor))[-1]))


def _about(body: Body, anchor: Floats) -> Floats:
    """The moments (3, 3) [kg m2] of a body about a point in W, along the axes of B."""
    R_WB = np.array(rotation_matrix(body.q_WB))
    lever = _cross(R_WB.T @ (np.array(body.p_WB) - anchor))
    return np.asarray(body.inertia) + body.mass * lever.T @ lever


def _cross(a: Floats) -> Floats:
    """The matrix (3, 3) of a x."""
    return np.cross(np.eye(3), a).T


def _spun(scene: Scene, joint: Joint) -> bool:
    """Is this a ball joint of a body that spins: that wobbles faster by SPUN than it would swing?"""
    if not isinstance(joint, Ball):
        return False
    anchor = np.array(joint.anchor_W)
    held = [scene.bodies[i] for i in _ends(scene, joint) if i != WORLD_FRAME]
    return any(body.movable and _wobble(body, anchor) > SPUN * _swing(scene, body, anchor) for body in held)


def _constrained(scene: Scene, joints: tuple[Joint, ...], how: str) -> list[Joint]:
    """The joints that shall be constraints on free bodies: none, all that can be, or ('auto') those of tops.

    DART's explicit step turns the velocities of a BallJoint, which are those in the body, and so lengthens them by (W h)^2/2 a
    step, W the rate of the wobble; those of a FreeJoint are in W, where a top's spin turns nothing. Without spin coordinates
    are better: they leave no gap.
    """
    if how == "coordinates":
        return []
    return [joint for joint in joints if (_spun(scene, joint) if how == "auto" else _cuttable(joint))]


def _forest(scene: Scene, joints: tuple[Joint, ...], constrained: list[Joint]) -> tuple[list[_Edge], list[Joint]]:
    """The bodies that are not static, parents first, and all joints that are constraints: those given and what closes a loop.

    Raises: Unsupported.
    """
    moving = [i for i, b in enumerate(scene.bodies) if b.motion != "static"]
    group = {i: i for i in (WORLD_FRAME, *moving)}
    anchored = {WORLD_FRAME, *(i for i in moving if not scene.bodies[i].movable)}

    def root(i: int) -> int:
        while group[i] != i:
            group[i] = group[group[i]]
            i = group[i]
        return i

    kept: dict[int, list[tuple[int, Joint, float]]] = {i: [] for i in group}
    cut = list(constrained)
    for joint in sorted((joint for joint in joints if joint not in cut), key=_cuttable):
        parent, child = _ends(scene, joint)
        a, b = root(parent), root(child)
        if a == b or (a in anchored and b in anchored):
            if not _cuttable(joint):
                raise Unsupported(
                    f"joint '{joint.name}'",
                    f"it closes a loop, and DART has no such constraint for {joint.type} joints, limits, springs and drives",
                )
            cut.append(joint)
            continue
        group[a if b in anchored else b] = b if b in anchored else a
        kept[parent].append((child, joint, 1.0))
        kept[child].append((parent, joint, -1.0))
    edges: list[_Edge] = []
    seen = {WORLD_FRAME}
    for start in (WORLD_FRAME, *sorted(moving, key=lambda i: scene.bodies[i].movable)):
        if start in seen and start != WORLD_FRAME:
            continue
        if start != WORLD_FRAME:
            edges.append(_Edge(start, WORLD_FRAME, None, 1.0))
            seen.add(start)
        queue = deque([start])
        while queue:
            i = queue.popleft()
            for k, joint, sign in kept[i]:
                if k not in seen:
                    seen.add(k)
                    edges.append(_Edge(k, i, joint, sign))
                    queue.append(k)
    return edges, cut


def _velocity_at(body: Body | None, point: Floats) -> tuple[Floats, Floats]:
    """(v, w) in W of the point [m, in W] that is fixed in the body at time 0; None is the world."""
    if body is None:
        return np.zeros(3), np.zeros(3)
    w = np.array(body.w_WB)
    return np.array(body.v_WB) + np.cross(w, point - np.array(body.p_WB)), w


def _check_velocities(scene: Scene, joint: Joint) -> None:
    """Do the initial velocities obey the joint? Raises: Unsupported."""
    if isinstance(joint, Distance):
        raise Unsupported(
            f"joint '{joint.name}'", "DART has no distance joint and no constraint that keeps or bounds a distance"
        )
    parent, child = (None if i == WORLD_FRAME else scene.bodies[i] for i in _ends(scene, joint))
    held = child if child is not None else parent
    assert held is not None
    anchor = np.array(held.p_WB if isinstance(joint, Fixed) else joint.anchor_W)
    (v_P, w_P), (v_C, w_C) = _velocity_at(parent, anchor), _velocity_at(child, anchor)
    dv, dw = v_C - v_P, w_C - w_P
    match joint:
        case Fixed():
            wrong = np.concatenate((dv, dw))
        case Ball():
            wrong = dv
        case Revolute(axis_W=axis):
            wrong = np.concatenate((dv, np.cross(axis, dw)))
        case Prismatic(axis_W=axis):
            wrong = np.concatenate((np.cross(axis, dv), dw))
        case _:
            assert_never(joint)
    speed = max(float(np.abs(np.concatenate((v_P, w_P, v_C, w_C))).max()), 1.0)
    if float(np.abs(wrong).max()) > 1e-6 * speed:
        raise Unsupported(
            f"joint '{joint.name}'",
            f"DART holds a joint by its coordinates; the initial velocities of '{joint.parent}' and '{joint.child}' break it "
            f"by {float(np.abs(wrong).max()):.3g}, expected velocities that the joint allows",
        )


class _Builder:
    """Puts one scene into one DART world."""

    def __init__(self, dart: Any, scene: Scene, settings: Settings) -> None:
        self.dart, self.scene, self.settings = dart, scene, settings
        self.options = _validated(settings)
        self.effects = scene.effects
        self.touching = Effect.CONTACT in self.effects
        self.joints = scene.joints if Effect.JOINTS in self.effects else ()
        self.coefficients = _coefficients(scene) if self.touching else {}
        self.notes: list[str] = []
        self.built: _Built

    def build(self) -> DartSimulation:
        """The simulation. Raises: Unsupported."""
        scene, effects = self.scene, self.effects
        for effect, why in (
            (Effect.ROLLING_FRICTION, "DART has no rolling friction"),
            (Effect.TORSIONAL_FRICTION, "DART has no torsional friction"),
        ):
            if effect in effects:
                raise Unsupported(effect.names[0].replace("_", " "), why)
        for joint in self.joints:
            _check_velocities(scene, joint)
        constrained = _constrained(scene, self.joints, self.options["joints"] or "coordinates")
        # What was asked for as 'auto' may turn out to be one of the two.
        every = len(constrained) == sum(map(_cuttable, self.joints))
        self.held_by = "coordinates" if not constrained else "constraints" if every else "auto"
        edges, cut = _forest(scene, self.joints, constrained)
        self.drives = self.options["drives"] or "spring"
        if self.drives == "auto":
            held = self.touching or cut or any(getattr(joint, "limits", None) for joint in self.joints)
            self.drives = "stable" if held else "spring"
        heard: list[str] = []
        with _overheard(heard):
            world = self._world()
            self._bodies(edges)
            for skeleton in self._skeletons:
                world.addSkeleton(skeleton)
            self._start()
            self._loops(cut)
            self._filter()
        # The one message that says what it does not do: the request that it claims to ignore takes effect (see `resolved`).
        self.built.notes += [f"dart: {line}" for line in heard if "primary LCP solver that is the same" not in line]
        self._surplus()
        return DartSimulation(self.built)

    def _world(self) -> Any:
        dart, settings = self.dart, self.settings
        simulation, constraint = dart.simulation, dart.constraint
        world = simulation.World("scene")
        substeps = settings.substeps or 1
        h = settings.dt / substeps
        world.setTimeStep(h)
        if world.getTimeStep() != h:
            raise SettingsError(f"settings: a step of {h} s, dart keeps {world.getTimeStep()} s")
        world.setGravity(self.scene.gravity if Effect.GRAVITY in self.effects else (0.0, 0.0, 0.0))
        detector = _detector(self.scene, self.options["detector"], self.notes)
        world.setCollisionDetector(getattr(simulation.CollisionDetectorType, detector.upper()))
        sleeping = world.getDeactivationOptions()
        if self.options["deactivation"] is not None:
            sleeping.mEnabled = self.options["deactivation"]
            world.setDeactivationOptions(sleeping)
        solver = world.getConstraintSolver()
        if self.options["split_impulse"] is not None:
            solver.setSplitImpulseEnabled(self.options["split_impulse"])
        name = _solver(self.scene, settings.solver)
        iterations, tolerance, friction_solver = settings.iterations, settings.tolerance, None
        if settings.solver == "auto" and tolerance is None:
            tolerance = CONE_TOLERANCE
        if name in ("nsgs", "fbf"):
            friction_solver = constraint.NsgsFrictionSolver() if name == "nsgs" else constraint.FbfFrictionSolver()
            most = "maxSweeps" if name == "nsgs" else "maxOuterIterations"
            choice = friction_solver.getOptions()
            if iterations is not None:
                setattr(choice, most, iterations)
            if tolerance is not None:
                choice.tolerance = tolerance
            friction_solver.setOptions(choice)
            solver.setBoxedLcpSolver(friction_solver)
            choice = friction_solver.getOptions()
            iterations, tolerance = int(getattr(choice, most)), float(choice.tolerance)
        elif name == "pgs":
            pgs, choice = solver.getSecondaryBoxedLcpSolver(), constraint.PgsBoxedLcpSolverOption()
            if iterations is not None:
                choice.mMaxIteration = iterations
            if tolerance is not None:
                # Of these two the relative one, 1e-3 by default, ends the sweeps whatever the other says.
                choice.mDeltaXThreshold = choice.mRelativeDeltaXTolerance = tolerance
            pgs.setOption(choice)
            solver.setBoxedLcpSolver(pgs)
            iterations, tolerance = int(choice.mMaxIteration), float(choice.mDeltaXThreshold)
        elif name == "matrix_free":
            swept = solver.getMatrixFreeContactSolverOptions()
            swept.mEnabled, swept.mMinRows = True, 1
            if iterations is not None:
                swept.mMaxIterations = iterations
            if tolerance is not None:
                swept.mDeltaTolerance = swept.mRelativeDeltaTolerance = tolerance
            solver.setMatrixFreeContactSolverOptions(swept)
            swept = solver.getMatrixFreeContactSolverOptions()
            iterations, tolerance = int(swept.mMaxIterations), float(swept.mDeltaTolerance)
        else:
            iterations = tolerance = None
        kinds = {
            "DantzigBoxedLcpSolver": "dantzig",
            "PgsBoxedLcpSolver": "pgs",
            "NsgsFrictionSolver": "nsgs",
            "FbfFrictionSolver": "fbf",
        }
        resolved = Settings(
            dt=settings.dt,
            substeps=substeps,
            iterations=iterations,
            integrator=INTEGRATOR,
            solver="matrix_free"
            if solver.getMatrixFreeContactSolverOptions().mEnabled
            else kinds[solver.getBoxedLcpSolver().getType()],
            tolerance=tolerance,
            options={
                "detector": world.getCollisionDetector().getType(),
                "deactivation": bool(world.getDeactivationOptions().mEnabled),
                "split_impulse": bool(solver.isSplitImpulseEnabled()),
                "drives": self.drives,
                "joints": self.held_by,
                "error_reduction": self._share(),
            },
            source=settings.source,
        )
        self.built = _Built(self.scene, dart, world, resolved, [None] * len(self.scene.bodies))
        self.built.notes, self.built.friction_solver = self.notes, friction_solver
        self._skeletons: list[Any] = []
        return world

    def _share(self) -> float:
        """By how much [1] of its error a constraint between bodies is corrected in a step."""
        share = self.options["error_reduction"]
        return float(self.dart.constraint.DynamicJointConstraint.getErrorReductionParameter() if share is None else share)

    def _pose(self, p: Vector3 | Floats, q: Quaternion = (1.0, 0.0, 0.0, 0.0)) -> Any:
        pose = self.dart.math.Isometry3()
        pose.set_rotation(np.array(rotation_matrix(q)))
        pose.set_translation(np.asarray(p, dtype=np.float64))
        return pose

    def _bodies(self, edges: list[_Edge]) -> None:
        """Skeletons, nodes, joints, masses and shapes; joint-free bodies first, in the order that `state` reads them."""
        dynamics, built = self.dart.dynamics, self.built
        parents = {e.parent for e in edges if e.joint is not None}
        alone = [e for e in edges if e.joint is None and e.body not in parents]
        edges[:] = alone + [e for e in edges if not (e.joint is None and e.body not in parents)]
        built.free = [e.body for e in alone]
        built.linked = [e.body for e in edges[len(alone) :]]
        for edge in edges:
            body = self.scene.bodies[edge.body]
            if edge.parent == WORLD_FRAME:
                skeleton = dynamics.Skeleton(f"skeleton {edge.body}")
                self._skeletons.append(skeleton)
                built.skeletons.append(skeleton)
                joint, node = self._pair(skeleton, edge)
            else:
                joint, node = self._pair(built.nodes[edge.parent], edge)
                node.getSkeleton().enableSelfCollisionCheck()
                node.getSkeleton().enableAdjacentBodyCheck()
            joint.setName(f"joint {edge.body}")
            node.setName(f"body {edge.body}")
            node.setInertia(dynamics.Inertia(body.mass, np.zeros(3), np.asarray(body.inertia)))
            built.nodes[edge.body] = node
            self._shape_nodes(edge.body)
            self._damp(edge, joint, edge.body in built.free)
        for i, body in enumerate(self.scene.bodies):
            if body.motion == "static":
                skeleton = dynamics.Skeleton(f"skeleton {i}")
                joint, node = skeleton.createWeldJointAndBodyNodePair()
                joint.setTransformFromParentBodyNode(self._pose(body.p_WB, body.q_WB))
                node.setName(f"body {i}")
                skeleton.setMobile(False)
                built.nodes[i] = node
                self._skeletons.append(skeleton)
                self._shape_nodes(i)

    def _pair(self, owner: Any, edge: _Edge) -> tuple[Any, Any]:
        """The joint of an edge and its body, placed so that DART's coordinate is the scene's."""
        joint, body = edge.joint, self.scene.bodies[edge.body]
        X_WC = self._pose(body.p_WB, body.q_WB)
        if joint is None:
            free, node = owner.createFreeJointAndBodyNodePair()
            if not body.movable:
                free.setActuatorType(self.dart.dynamics.ActuatorType.VELOCITY)
                velocity = np.array([*body.w_WB, *body.v_WB])
                if velocity.any():
                    self.built.belts.append((free, velocity))
            free.setTransform(X_WC)
            free.setVelocities(np.array([*body.w_WB, *body.v_WB]))
            return free, node
        parent = None if edge.parent == WORLD_FRAME else self.scene.bodies[edge.parent]
        X_PW = self._pose((0.0, 0.0, 0.0)) if parent is None else self._pose(parent.p_WB, parent.q_WB).inverse()
        if isinstance(joint, Fixed):
            made, node = owner.createWeldJointAndBodyNodePair()
            made.setTransformFromParentBodyNode(X_PW.multiply(X_WC))
            return made, node
        assert not isinstance(joint, Distance)
        X_WA = self._pose(joint.anchor_W)
        X_PA = X_PW.multiply(X_WA)
        X_CA = X_WC.inverse().multiply(X_WA)
        if isinstance(joint, Ball):
            made, node = owner.createBallJointAndBodyNodePair()
        else:
            axis = edge.sign * np.array(joint.axis_W)
            # At coordinate `position` the bodies stand as the scene has them; so zero lies that far back.
            back = self.dart.math.Isometry3()
            if isinstance(joint, Revolute):
                made, node = owner.createRevoluteJointAndBodyNodePair()
                back.set_rotation(np.asarray(self.dart.math.expMapRot(-joint.position * axis)))
            else:
                made, node = owner.createPrismaticJointAndBodyNodePair()
                back.set_translation(-joint.position * axis)
            X_PA = X_PA.multiply(back)
            made.setAxis(axis)
            self._coordinate(made, node, joint)
        made.setTransformFromParentBodyNode(X_PA)
        made.setTransformFromChildBodyNode(X_CA)
        return made, node

    def _coordinate(self, made: Any, node: Any, joint: Revolute | Prismatic) -> None:
        """Position, limits, spring and drive of a joint of one coordinate."""
        made.setPosition(0, joint.position)
        if joint.limits is not None:
            made.setLimitEnforcement(True)
            if joint.limits.lower is not None:
                made.setPositionLowerLimit(0, joint.limits.lower)
            if joint.limits.upper is not None:
                made.setPositionUpperLimit(0, joint.limits.upper)
        drive = joint.drive if Effect.DRIVES in self.effects else None
        if joint.spring is not None or drive is not None:
            motor = _Motor(
                made,
                node.getSkeleton(),
                joint.spring or Spring(),
                drive or Drive(),
                (drive or Drive()).target,
                stable=self.drives == "stable",
                servo=self.drives == "servo" and drive is not None and drive.stiffness + drive.damping > 0,
            )
            motor.rest()
            if motor.servo:
                self._servo(motor, joint.name)
            self.built.motors[joint.name] = motor

    def _servo(self, motor: _Motor, name: str) -> None:
        """Let DART's own motor drive a joint. Raises: Unsupported."""
        if motor.push != 0.0:
            raise Unsupported(
                f"joint '{name}'", "a servo of DART takes no force beside, as a spring that rests beyond a limit is"
            )
        motor.joint.setActuatorType(self.dart.dynamics.ActuatorType.SERVO)
        if motor.drive.limit is not None:
            motor.joint.setForceLowerLimit(0, -motor.drive.limit)
            motor.joint.setForceUpperLimit(0, motor.drive.limit)
        if SERVO_NOTE not in self.notes:
            self.notes.append(SERVO_NOTE)

    def _damp(self, edge: _Edge, joint: Any, alone: bool) -> None:
        body = self.scene.bodies[edge.body]
        c = body.linear_damping if Effect.LINEAR_DAMPING in self.effects else 0.0
        d = body.angular_damping if Effect.ANGULAR_DAMPING in self.effects else 0.0
        if not body.movable or (c == 0 and d == 0):
            return
        low, _, high = np.linalg.eigvalsh(np.asarray(body.inertia))
        if alone and (d == 0 or high - low <= 1e-12 * high):
            for k in range(3):
                joint.setDampingCoefficient(k, d * float(high))
                joint.setDampingCoefficient(3 + k, c * body.mass)
        else:
            self.built.damped.append((edge.body, c, d))

    def _shape_nodes(self, place: int) -> None:
        """The body's shapes: for contact if the scene has any, else for rays alone."""
        body, node = self.scene.bodies[place], self.built.nodes[place]
        for k, placed in enumerate(body.collision):
            shape_node = node.createShapeNode(self._shape(placed.shape), f"{place}/{k}")
            X_BS = self._pose(placed.p_BS, placed.q_BS)
            shape_node.setRelativeTransform(X_BS)
            self.built.shapes.append(shape_node)
            if isinstance(placed.shape, Plane) and self.built.resolved.options["detector"] == "bullet":
                # Rays still meet the plane itself.
                shape_node = node.createShapeNode(self._shape(Box(half_extents=(SLAB, SLAB, SLAB))), f"{place}/{k}/slab")
                down = self.dart.math.Isometry3()
                normal = np.array(placed.shape.normal)
                down.set_rotation(np.vstack((_across(normal), normal)).T)
                down.set_translation(-SLAB * normal)
                shape_node.setRelativeTransform(X_BS.multiply(down))
            if self.touching:
                shape_node.createCollisionAspect()
                shape_node.createDynamicsAspect()
                friction, restitution = self.coefficients[body.material, body.movable]
                aspect = shape_node.getDynamicsAspect()
                aspect.setFrictionCoeff(friction)
                aspect.setRestitutionCoeff(restitution)

    def _shape(self, shape: Shape) -> Any:
        dynamics = self.dart.dynamics
        match shape:
            case Sphere(radius=r):
                return dynamics.SphereShape(r)
            case Box(half_extents=half):
                return dynamics.BoxShape(2 * np.array(half))
            case Capsule(radius=r, half_length=h):
                return dynamics.CapsuleShape(r, 2 * h)
            case Cylinder(radius=r, half_length=h):
                return dynamics.CylinderShape(r, 2 * h)
            case Plane(normal=n):
                return dynamics.PlaneShape(np.array(n), 0.0)
            case ConvexHull(vertices=vertices):
                return self._mesh(*_surface(np.asarray(vertices)))
            case TriangleMesh(vertices=vertices, faces=faces):
                return self._mesh(np.asarray(vertices), np.asarray(faces))
            case _:
                assert_never(shape)

    def _mesh(self, vertices: Floats, faces: Integers) -> Any:
        """A MeshShape: dartpy cannot make one from arrays, but its URDF reader can from a file."""
        dart = self.dart
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "mesh.obj"
            lines = ["v {:.17g} {:.17g} {:.17g}".format(*v) for v in vertices.tolist()]
            lines += ["f {} {} {}".format(*f) for f in (faces + 1).tolist()]
            path.write_text("\n".join(lines) + "\n", encoding="ascii")
            urdf = (
                '<robot name="mesh"><link name="mesh"><collision><geometry>'
                f'<mesh filename="{path.as_uri()}"/></geometry></collision></link></robot>'
            )
            reader, files = dart.utils.DartLoader(), dart.common.LocalResourceRetriever()
            skeleton = reader.parseSkeletonString(urdf, dart.common.Uri("file:///"), files)
        if skeleton is None:
            raise Unsupported("mesh", f"dartpy's reader refused {len(vertices)} vertices and {len(faces)} faces")
        return skeleton.getBodyNode(0).getShapeNode(0).getShape()

    def _start(self) -> None:
        """Initial velocities of trees of joints: the rates of the coordinates that give every body the scene's velocity."""
        trees: dict[int, tuple[Any, list[int]]] = {}
        for i in self.built.linked:
            skeleton = self.built.nodes[i].getSkeleton()
            trees.setdefault(id(skeleton), (skeleton, []))[1].append(i)
        for skeleton, places in trees.values():
            if skeleton.getNumDofs() == 0:
                continue
            jacobian = np.vstack([np.asarray(skeleton.getWorldJacobian(self.built.nodes[i])) for i in places])
            bodies = [self.scene.bodies[i] for i in places]
            wanted = np.concatenate([np.array([*b.w_WB, *b.v_WB]) for b in bodies])
            if wanted.any():
                skeleton.setVelocities(np.linalg.lstsq(jacobian, wanted, rcond=None)[0])
            else:
                skeleton.resetVelocities()

    def _loops(self, cut: list[Joint]) -> None:
        constraint, built = self.dart.constraint, self.built
        solver = built.world.getConstraintSolver()
        for joint in cut:
            places = [i for i in _ends(self.scene, joint) if i != WORLD_FRAME]
            nodes = [built.nodes[i] for i in places]
            assert not isinstance(joint, Distance)
            anchor = np.array(self.scene.bodies[places[0]].p_WB if isinstance(joint, Fixed) else joint.anchor_W)
            lever = max(float(np.linalg.norm(np.asarray(node.getCOM()) - anchor)) for node in nodes) or 1.0
            match joint:
                case Fixed():
                    solver.addConstraint(constraint.WeldJointConstraint(*nodes))
                    common = anchor + lever * np.eye(3)
                case Ball():
                    common = anchor[None]
                case Revolute(axis_W=axis):
                    common = anchor + np.outer((0.0, lever), axis)
                case _:
                    raise AssertionError(f"joint '{joint.name}' cannot be cut")
            for point in common:
                if not isinstance(joint, Fixed):
                    solver.addConstraint(constraint.BallJointConstraint(*nodes, point))
                back = [node.getWorldTransform().inverse() for node in nodes]
                built.loops.append(
                    tuple((i, X.rotation() @ point + X.translation()) for i, X in zip(places, back, strict=True))
                )

    def _filter(self) -> None:
        """Keep joined bodies, and materials that are apart, from colliding."""
        if not self.touching or not (self.scene.joined() or self.scene.apart):
            return
        option = self.built.world.getConstraintSolver().getCollisionOption()
        solid = [(body, node) for body, node in zip(self.scene.bodies, self.built.nodes, strict=True) if body.collision]
        for (a, node_a), (b, node_b) in combinations(solid, 2):
            if (a.movable or b.movable) and not self.scene.collides(a, b):
                option.collisionFilter.addBodyNodePairToBlackList(node_a, node_b)

    def _surplus(self) -> None:
        """What DART computes unasked, and what it cannot be asked for."""
        if Effect.CONTINUOUS_COLLISION in self.effects:
            self.built.notes.append("missing: continuous_collision: dartpy's step has none")
        spins = False
        for body in self.scene.bodies:
            low, _, high = np.linalg.eigvalsh(np.asarray(body.inertia))
            spins = spins or (body.movable and high - low > 1e-12 * high)
        if spins and Effect.GYROSCOPIC not in self.effects:
            self.built.notes.append("surplus: gyroscopic, DART's equations of motion always hold the term")


def _surface(points: Floats) -> tuple[Floats, Integers]:
    """Vertices and faces, counter-clockwise from outside, of the convex hull of points (n, 3) m."""
    from scipy.spatial import ConvexHull as Hull

    hull = Hull(points)
    faces = np.array(hull.simplices, dtype=np.int64)
    corners = points[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", across, hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    used = np.unique(faces)
    return points[used], np.searchsorted(used, faces).astype(np.int64)


@dataclass(frozen=True, kw_only=True)
class DartAdapter(Adapter):
    """DART through dartpy."""

    def version(self) -> str:
        """The installed version of dartpy. Raises: Unavailable."""
        _load()
        return importlib.metadata.version("dartpy")

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """Exactly this scene under these settings. Raises: Unsupported, Unavailable, SettingsError."""
        return _Builder(_load(), scene, settings).build()


def _load() -> Any:
    try:
        return importlib.import_module("dartpy")
    except ImportError as error:
        raise Unavailable(f"dartpy cannot be imported ({error}); install dartpy 6.20 or later") from error


_SWEPT = (
    "the exact cone is swept to 1e-6 where Dantzig pivots its box to rounding: 1.2e-6 m/s of creep for 6.7e-8 at 1/240 s, a "
    "ninth of the bound; Dantzig under tuned's other settings creeps as the default does, and is wrong askew to its axes by "
    "up to 1.41"
)

ADAPTER = DartAdapter(
    name="dart",
    title="DART",
    distribution="dartpy",
    features=(
        Feature.SPHERE
        | Feature.BOX
        | Feature.CAPSULE
        | Feature.CYLINDER
        | Feature.PLANE
        | Feature.CONVEX_HULL
        | Feature.TRIANGLE_MESH
        | Feature.COMPOUND
        | Feature.FULL_INERTIA
        | Feature.KINEMATIC
        | Feature.FIXED
        | Feature.BALL
        | Feature.REVOLUTE
        | Feature.PRISMATIC
        | Feature.CLOSED_LOOP
        | Feature.LIMITS
        | Feature.SPRINGS
        | Feature.DRIVES
        | Feature.RESTITUTION
        | Feature.LINEAR_DAMPING
        | Feature.ANGULAR_DAMPING
        | Feature.CONTACTS
        | Feature.CONTACT_FORCES
        | Feature.RAYS
        | Feature.WRENCH
    ),
    tracks={
        "default": Settings(source="dartpy 6.20.0 as it comes: FCL, Dantzig, deactivation on"),
        "tuned": Settings(
            solver="auto",
            options={"detector": "auto", "deactivation": False, "drives": "auto", "joints": "auto", "error_reduction": 0.2},
            source="reduced-coordinate joints but for tops, whose ball joints are constraints, with ODE's default of 0.2 "
            "for error reduction; ODE detector: the default of Gazebo's DART plugin (gz-physics, dartsim), Bullet's where "
            "ODE has a pair of shapes wrong, by heights after 3 s; exact friction cone, to 1e-6: DART 6.20, "
            "NsgsFrictionSolver.hpp; Dantzig for bodies that lean on each other: the vendor's default; stable PD control of "
            "what contacts hold (Tan, Liu, Turk 2011), as in DART's own examples of controllers",
        ),
    },
    known_failures={
        "default/friction_is_isotropic": "Dantzig, the default solver, bounds friction along two axes: a box, not a cone",
    },
    trade_offs={
        "friction_creep": _SWEPT,
        "friction_creep/ladder": _SWEPT,
        "friction_turntable/ladder": (
            "what the detectors find of a ball on a plane: with FCL in the place of ODE tuned errs as the default does, .037 "
            "for .075 m at 1/60 s, with Bullet's as with ODE; from 1/480 s on all err alike. Boxes slide right on planes with "
            "ODE alone"
        ),
        "stack_arch/ladder": (
            "exact to the cone's 1e-6, where Dantzig pivots to rounding: 3.4e-5 for 1.8e-5 at 1/1920 s; alike at coarser steps"
        ),
    },
    knobs={
        "solver": SOLVERS,
        "substeps": (1, 2, 4, 8),
        "iterations": (30, 100, 300, 1000),
        "tolerance": (1e-4, 1e-5, 1e-7),
        "options.detector": DETECTORS,
        "options.deactivation": (True, False),
        "options.split_impulse": (True, False),
        "options.drives": DRIVES,
        "options.joints": JOINTS,
        "options.error_reduction": (0.01, 0.1, 0.2, 0.5),
    },
    acts_on={
        **dict.fromkeys(("solver", "iterations", "tolerance", "options.error_reduction"), Effect.CONTACT | Effect.JOINTS),
        **dict.fromkeys(("options.detector", "options.split_impulse"), Effect.CONTACT),
        "options.joints": Effect.JOINTS,
        "options.drives": Effect.DRIVES,
    },
    loads=("dartpy",),
    orders={INTEGRATOR: 1},
    emulated=(
        Emulation(
            feature=Feature.SPRINGS,
            how="the adapter works out a torque for each step (stable PD control); else it is DART's own joint spring",
            where="where contacts, limits or loops can hold the joint",
            tracks=("tuned",),
        ),
        Emulation(
            feature=Feature.DRIVES,
            how="the adapter works out a torque for each step, by the implicit law that DART's joint spring has; else it is "
            "that spring with its rest at the target",
            where="where the drive has a limit",
            tracks=("default",),
        ),
        Emulation(
            feature=Feature.DRIVES,
            how="the adapter works out a torque for each step (stable PD control); else it is DART's own joint spring with its "
            "rest at the target",
            where="where contacts, limits or loops can hold the joint, or the drive has a limit",
            tracks=("tuned",),
        ),
        Emulation(
            feature=Feature.LINEAR_DAMPING,
            how="DART damps joints, not bodies; a force of the adapter stands for it; else it is DART's own joint damping",
            where="where joints hold the body, or it has an uneven inertia and angular damping",
        ),
        Emulation(
            feature=Feature.ANGULAR_DAMPING,
            how="DART damps joints, not bodies; a torque of the adapter stands for it; else it is DART's own joint damping",
            where="where joints hold the body, or its inertia is uneven",
        ),
        Emulation(
            feature=Feature.CLOSED_LOOP,
            how="a revolute joint is two points of its axis, each held together by DART's own ball joint constraint",
            where="where a revolute joint closes the loop",
        ),
    ),
    deviations=(
        "a joint that closes a loop, on 'tuned' also the ball joint of a top, is a velocity constraint and has a gap, of which "
        "a share is taken back a step: 0.01, on 'tuned' 0.2",
        "drives by DART's own servo ('drives': 'servo') hold a velocity and do not sag: another law than the scene's",
        "springs, dampers and drives are implicit and damp by themselves",
        "beside contact implicit drives sag and gain energy, so that on 'tuned' they are stable PD control there",
        "where FCL, the vendor's default, has shapes wrong (capsules, hulls, meshes, cylinders on boxes or cylinders, solids "
        "on planes), ODE or Bullet detects; what neither has right is refused",
        "hulls and meshes lose digits beyond single precision",
        "restitution acts above an approach of 0.1 m/s and returns at most 100 m/s",
        "the friction of Dantzig, PGS and the matrix-free solver is a box: up to 1.41 times as strong askew to its axes",
        "rays from inside a solid report the exit",
    ),
)
