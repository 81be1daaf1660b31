"""A scene becomes a DART world."""

from dataclasses import replace
from typing import Any

import numpy as np

from plumbline.adapters.dart.bodies import add_bodies, start
from plumbline.adapters.dart.built import Built
from plumbline.adapters.dart.detectors import choose_detector, keep_apart
from plumbline.adapters.dart.joints import add_constraints
from plumbline.adapters.dart.options import INTEGRATOR, validated
from plumbline.adapters.dart.simulation import DartSimulation
from plumbline.adapters.dart.solvers import choose_solver, set_solver
from plumbline.adapters.dart.spinning_tops import substeps_of
from plumbline.adapters.dart.surfaces import coefficients
from plumbline.adapters.dart.trees import check_velocities, constrained_joints, cuttable, forest
from plumbline.adapters.dart.vendor import overheard
from plumbline.harness.adapter import Notice, Settings, SettingsError, Unsupported
from plumbline.harness.adapter.carried_laws import refuse_tendons
from plumbline.harness.adapter.distance_springs import DistanceSprings, is_distance_spring
from plumbline.harness.adapter.fast_rotors import rotor_notices
from plumbline.harness.scene import Effect, Scene


def build(dart: Any, scene: Scene, settings: Settings) -> DartSimulation:
    """Exactly this scene under these settings. Raises: Unsupported, SettingsError."""
    options, effects = validated(settings), scene.effects
    touching = Effect.CONTACT in effects
    every_joint = scene.joints if Effect.JOINTS in effects else ()
    joints = tuple(joint for joint in every_joint if not is_distance_spring(joint))
    if Effect.JOINTS in effects:
        refuse_tendons(scene)
    by_kind = coefficients(scene) if touching else {}
    for effect, why in (
        (Effect.ROLLING_FRICTION, "DART has no rolling friction"),
        (Effect.TORSIONAL_FRICTION, "DART has no torsional friction"),
    ):
        if effect in effects:
            raise Unsupported(effect.names[0].replace("_", " "), why)
    for joint in joints:
        check_velocities(scene, joint)
    constrained = constrained_joints(scene, joints, options["joints"] or "coordinates")
    if settings.substeps is None:
        settings = replace(settings, substeps=substeps_of(scene, settings.dt, options["joints"]))
    # What was asked for as 'auto' may turn out to be one of the two.
    every = len(constrained) == sum(map(cuttable, joints))
    options["joints"] = "coordinates" if not constrained else "constraints" if every else "auto"
    edges, cut = forest(scene, joints, constrained)
    options["drives"] = options["drives"] or "spring"
    if options["drives"] == "auto":
        held = touching or cut or any(getattr(joint, "limits", None) for joint in joints)
        options["drives"] = "stable" if held else "spring"
    heard: list[str] = []
    with overheard(heard):
        built = _empty(dart, scene, settings, options)
        add_bodies(built, edges, by_kind)
        start(built)
        add_constraints(built, cut)
        keep_apart(built)
    built.springs = DistanceSprings.of(scene, every_joint, built.world.getTimeStep())
    # The one message that says what it does not do: the request that it claims to ignore takes effect (see `resolved`).
    built.notices += [Notice(f"dart: {line}") for line in heard if "primary LCP solver that is the same" not in line]
    built.notices += _surplus(scene)
    built.notices += rotor_notices(scene, joints, {joint.name for joint in constrained}, built.world.getTimeStep())
    return DartSimulation(built)


def _empty(dart: Any, scene: Scene, settings: Settings, options: dict[str, Any]) -> Built:
    """A world without bodies under these settings, and what it says of them. Raises: SettingsError, Unsupported."""
    world = dart.simulation.World("scene")
    substeps = settings.substeps or 1
    h = settings.dt / substeps
    world.setTimeStep(h)
    if world.getTimeStep() != h:
        raise SettingsError(f"settings: a step of {h} s, dart keeps {world.getTimeStep()} s")
    world.setGravity(scene.gravity if Effect.GRAVITY in scene.effects else (0.0, 0.0, 0.0))
    notices: list[Notice] = []
    swept = choose_solver(scene, settings.solver) == "matrix_free"
    detector = choose_detector(scene, options["detector"], notices, swept)
    world.setCollisionDetector(getattr(dart.simulation.CollisionDetectorType, detector.upper()))
    sleeping = world.getDeactivationOptions()
    if options["deactivation"] is not None:
        sleeping.mEnabled = options["deactivation"]
        world.setDeactivationOptions(sleeping)
    solver = world.getConstraintSolver()
    if options["split_impulse"] is not None:
        solver.setSplitImpulseEnabled(options["split_impulse"])
    used = set_solver(dart, world, scene, settings)
    share = options["error_reduction"]
    if share is None:
        share = dart.constraint.DynamicJointConstraint.getErrorReductionParameter()
    resolved = Settings(
        dt=settings.dt,
        substeps=substeps,
        iterations=used.iterations,
        integrator=INTEGRATOR,
        solver=used.name,
        tolerance=used.tolerance,
        options={
            "detector": world.getCollisionDetector().getType(),
            "deactivation": bool(world.getDeactivationOptions().mEnabled),
            "split_impulse": bool(solver.isSplitImpulseEnabled()),
            "drives": options["drives"],
            "joints": options["joints"],
            "error_reduction": float(share),
        },
        source=settings.source,
    )
    return Built(scene, dart, world, resolved, nodes=[None] * len(scene.bodies), cone=used.cone, notices=notices)


def _surplus(scene: Scene) -> list[Notice]:
    """What DART computes unasked, and what it cannot be asked for."""
    notices = []
    if Effect.CONTINUOUS_COLLISION in scene.effects:
        text = "continuous collision, of which dartpy's step has none"
        notices.append(Notice(text, "missing", Effect.CONTINUOUS_COLLISION))
    spins = False
    for body in scene.bodies:
        low, _, high = np.linalg.eigvalsh(np.asarray(body.inertia))
        spins = spins or (body.movable and high - low > 1e-12 * high)
    if spins and Effect.GYROSCOPIC not in scene.effects:
        text = "gyroscopic terms, which DART's equations of motion always hold"
        notices.append(Notice(text, "surplus", Effect.GYROSCOPIC))
    return notices
