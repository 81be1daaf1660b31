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
option 'joints' has all of these ('constraints') or the ball joints of what spins and the hinges of fast rotors ('auto') be
constraints on free bodies. A gimbal whose wheel spins at 150 rad/s and wobbles at 147 ends with 3.4 times its energy after 2 s
at 1/240 s and at 1e-3 s in coordinates; on the wheel's constraint, in steps of 1/960 s at most, it keeps it to 1e-4.

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
    * A fast rotor whose hinge is driven, sprung or limited stays in coordinates, and `warnings()` says how its wobble grows; it
      does so too where a constraint does not suffice: at a wobble of a fifth of a radian a step, or of a rotor that is uneven
      across its axis (moments of 1 to 4: at 1/960 s 53 % of the energy was lost within 2 s, where coordinates stop being
      finite).
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
    * A spring between points of two bodies (`Distance` with a spring) is a pair of forces of the adapter, held over each
      sub-step: those of its start where no pose lets them reverse a velocity within it, else those of its end along the line,
      linearly implicit, stable at any stiffness and damped by it (`harness.adapter.distance_springs`). Across the line the
      force is that of the start: stable while h^2 f/(m l) < 4, f the tension, m the mass at the end of the line, l its length.
    * Damping of a joint-free body is DART's joint damping (implicit) where that is v' = -c v, w' = -c w exactly (no
      angular damping, or a spherical inertia); otherwise a force and a torque of the start of the step over (1 + c dt).
    * No detector has every pair of shapes right (`WRONG_PAIRS`). FCL, the vendor's default, has no capsule (it puts a ball of
      0.1 m there), lets balls fall through meshes and cylinders sink into boxes and each other, and gives a box on a plane one
      contact, on which it rocks and slides by another friction. A scene in which such pairs can meet uses the ODE detector on
      both tracks, and the Bullet detector where capsules can meet boxes or cylinders, cylinders each other, or two hulls or
      meshes that move; `warnings()` says so on 'default'. Where neither has all pairs right the scene is refused.
    * The ODE detector misses some boxes whose edges are parallel to rounding: a box that leans over an edge along no axis of W
      is turned by its number times 1e-12 rad there (`shapes.ASKEW`).
    * An ellipsoid stands right under FCL alone, on planes, boxes and cylinders; its other pairs are refused, and so are rays
      in scenes with one, as DART's own detector meets a polyhedron in its place.
    * Under the Bullet detector, which holds a solid on a plane at one point, a plane is a box that ends a kilometre away;
      and a cylinder that lies creeps by rolling, up to 1 cm/s.
    * DART reports no contacts of bodies that it has put to sleep (track 'default'); theirs are repeated as they were last
      seen, at most 0.1 s and 32 steps before.
    * Convex hulls and meshes pass through an OBJ file in single precision; a hull is the mesh of its surface.
    * Restitution acts above an approach of 0.1 m/s and returns at most 100 m/s; friction or restitution of 1e-3 and less
      does not exist and is refused.
    * Dantzig, PGS and the matrix-free solver bound friction along two axes, a box instead of a cone: sliding askew to them
      meets up to 1.41 times as much. Dantzig bounds it besides by the normal force that there would be without friction: a
      block on a loose wedge as heavy is rubbed by .187 N at mu .2 (exactly mu/(1 + mu r s c/(1 + r s^2)), r the ratio of the
      masses, s and c of the slope of 30 degrees). On 'tuned' the conic solver has what leans; stacks and heaps keep the boxes.
    * What is swept without a matrix are free bodies' contacts, and those where the sweeps end within their greatest number;
      the others are Dantzig's, and all of them are beside a conic solver.
    * Rays are cast by DART's own detector in a group of its own; a ray that starts inside a solid reports the exit, and
      inside the half space of a plane distance 0.
    * No more than 1000 contacts of a step are kept (dartpy cannot raise that bound); `warnings()` says so where it is met.
    * Contact points are those of the start of the last step, with the forces of that step.
"""

import importlib.metadata
from dataclasses import dataclass
from typing import TYPE_CHECKING

from plumbline.adapters.dart.build import build
from plumbline.adapters.dart.detectors import DETECTORS
from plumbline.adapters.dart.knob_trade_offs import KNOB_TRADE_OFFS
from plumbline.adapters.dart.options import DRIVES, INTEGRATOR, JOINTS
from plumbline.adapters.dart.solvers import SOLVERS
from plumbline.adapters.dart.vendor import load
from plumbline.harness.adapter import Adapter, Emulation, Feature, Settings, Simulation, TradeOff, Unsupported
from plumbline.harness.adapter.mass_points import POINTS_AS_BODIES, built_with_points
from plumbline.harness.scene import Effect, Scene

if TYPE_CHECKING:
    from pathlib import Path

    from plumbline.harness.scene.parity.loaded import Loaded, Request

__all__ = ["ADAPTER"]


_ENFORCED = "DART tutorial Biped: bounds are enforced only after Joint.setLimitEnforcement(True)"


@dataclass(frozen=True, kw_only=True)
class DartAdapter(Adapter):
    """DART through dartpy."""

    def version(self) -> str:
        """The installed version of dartpy. Raises: Unavailable."""
        load()
        return importlib.metadata.version("dartpy")

    def load_robot(self, path: "Path", request: "Request") -> "Loaded":
        """What the package's own loader makes of a robot file. Raises: Unsupported, Unavailable."""
        from plumbline.adapters.dart.robot_loader import load

        if request.way:
            raise Unsupported(f"loader {request.way!r}", "there is one alone")
        return load(path, request)

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """Exactly this scene under these settings. Raises: Unsupported, Unavailable, SettingsError."""
        return built_with_points(lambda told: build(load(), told, settings), scene)


_SWEPT = (
    "the exact cone is swept to 1e-5 where Dantzig pivots its box to rounding: 1.2e-6 m/s of creep for 6.7e-8 at 1/240 s, a "
    "ninth of the bound; Dantzig under tuned's other settings creeps as the default does, and is wrong askew to its axes by "
    "up to 1.41"
)

ADAPTER = DartAdapter(
    loaders=("",),
    loader_defaults={("", ending): dict.fromkeys(("lower", "upper"), _ENFORCED) for ending in (".urdf", ".xml", ".mjcf")},
    name="dart",
    title="DART",
    distribution="dartpy",
    licence="BSD-2-Clause",
    platforms=("linux-x86_64", "linux-aarch64", "macos-arm64", "windows-x86_64"),
    features=(
        Feature.SPHERE
        | Feature.BOX
        | Feature.CAPSULE
        | Feature.CYLINDER
        | Feature.ELLIPSOID
        | Feature.PLANE
        | Feature.CONVEX_HULL
        | Feature.TRIANGLE_MESH
        | Feature.MOVING_MESH
        | Feature.COMPOUND
        | Feature.FULL_INERTIA
        | Feature.KINEMATIC
        | Feature.PRESCRIBED_MOTION
        | Feature.MASS_POINT
        | Feature.MASSLESS
        | Feature.FIXED
        | Feature.BALL
        | Feature.REVOLUTE
        | Feature.PRISMATIC
        | Feature.DISTANCE_SPRING
        | Feature.CLOSED_LOOP
        | Feature.LIMITS
        | Feature.SPRINGS
        | Feature.DRIVES
        | Feature.ARMATURE
        | Feature.FRICTION_LOSS
        | Feature.SPEED_LIMIT
        | Feature.FEEDFORWARD
        | Feature.RESTITUTION
        | Feature.LINEAR_DAMPING
        | Feature.ANGULAR_DAMPING
        | Feature.CONTACTS
        | Feature.CONTACT_FORCES
        | Feature.RAYS
        | Feature.WRENCH
        | Feature.STEP_LENGTHS
    ),
    tracks={
        "default": Settings(source="dartpy 6.20.0 as it comes: FCL, Dantzig, deactivation on"),
        "tuned": Settings(
            solver="auto",
            options={"detector": "auto", "deactivation": False, "drives": "auto", "joints": "auto", "error_reduction": 0.2},
            source="reduced-coordinate joints but for tops, whose ball joints are constraints, and fast rotors, whose hinges "
            "are, in steps of 1/960 s at most, with ODE's default of 0.2 for error reduction; ODE detector: the default of "
            "Gazebo's DART plugin (gz-physics, dartsim), Bullet's where ODE has a pair of shapes wrong, by heights after 3 s; "
            "exact friction cone, to 1e-6 where gravity gives more than 0.08 m/s a step: DART 6.20, NsgsFrictionSolver.hpp; "
            "Dantzig, the vendor's default, for level stacks, machines and more than 16 bodies; heaps swept without a matrix, "
            "on DART's own detector: MatrixFreeContactSolverOptions of BoxedLcpConstraintSolver.hpp; stable PD control of what "
            "contacts hold (Tan, Liu, Turk 2011), as in DART's own examples of controllers",
        ),
    },
    known_failures={
        "default/friction_is_isotropic": "Dantzig, the default solver, bounds friction along two axes: a box, not a cone",
    },
    trade_offs=(
        TradeOff(cases=("friction_creep",), at=("own step", "ladder"), why=_SWEPT),
        TradeOff(
            cases=("friction_turntable",),
            at=("ladder",),
            why=(
                "what the detectors find of a ball on a plane: with FCL in the place of ODE tuned errs as the default does, "
                ".037 for .075 m at 1/60 s, with Bullet's as with ODE; from 1/480 s on all err alike. Boxes slide right on "
                "planes with ODE alone"
            ),
        ),
        *KNOB_TRADE_OFFS,
    ),
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
            feature=Feature.MASS_POINT,
            how=POINTS_AS_BODIES,
        ),
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
            feature=Feature.ARMATURE,
            how="DART's joints have no inertia of their own; the rotor is one of its implicit dampers, armature over the step, "
            "and a force of the adapter takes back what it brakes, until a contact or a stop strikes the tree: there the run "
            "ends",
        ),
        Emulation(
            feature=Feature.DISTANCE_SPRING,
            how="dartpy has no spring between points of two bodies; the adapter works out a pair of forces for each sub-step",
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
    laws=(
        "plumbline.adapters.dart.stable_pd:Foresight.foresee",
        "plumbline.adapters.dart.drives:Pushes.set",
        "plumbline.adapters.dart.rotors:Rotors.lead",
        "plumbline.adapters.dart.forces:damp",
        "plumbline.adapters.dart.simulation:DartSimulation._sprung",
    ),
    deviations=(
        "a joint that closes a loop, on 'tuned' also the ball joint of a top and the hinge of a fast rotor, is a velocity "
        "constraint and has a gap, of which "
        "a share is taken back a step: 0.01, on 'tuned' 0.2",
        "a fast rotor in coordinates, as on a driven, sprung or limited hinge, wobbles at a rate W that grows by e^(W^2 h/2) a "
        "second in steps of h; a constraint takes the energy of one that is uneven across its axis",
        "drives by DART's own servo ('drives': 'servo') hold a velocity and do not sag: another law than the scene's",
        "springs, dampers and drives are implicit and damp by themselves",
        "springs between points of two bodies are forces of the adapter, too stiff ones linearly implicit along the line; "
        "across it stable while h^2 f/(m l) < 4, with f the tension and l the length",
        "beside contact implicit drives sag and gain energy, so that on 'tuned' they are stable PD control there",
        "where FCL, the vendor's default, has shapes wrong (capsules, hulls, meshes, cylinders on boxes or cylinders, solids "
        "on planes), ODE or Bullet detects; what neither has right is refused",
        "under the ODE detector, which misses boxes whose edges are parallel to rounding, a box that leans is turned by its "
        "number times 1e-12 rad",
        "hulls and meshes lose digits beyond single precision",
        "rays in a scene with an ellipsoid are refused, and its contacts but for those with planes, boxes and cylinders",
        "restitution acts above an approach of 0.1 m/s and returns at most 100 m/s",
        "the friction of Dantzig, PGS and the matrix-free solver is a box: up to 1.41 times as strong askew to its axes",
        "rays from inside a solid report the exit",
    ),
)
