"""The solver for a scene, its iterations and where contacts begin, as the track 'tuned' chooses them."""

from collections.abc import Iterable

from plumbline.harness.adapter.motors import motors_of
from plumbline.harness.adapter.reduced_trees import JointTree
from plumbline.harness.scene import WORLD, Effect, Prismatic, Revolute, Scene

__all__ = ["PARTING", "TOUCH", "iterations_for", "suited"]

UNLIKE = 100.0
"""Ratio of masses above which PGS errs more than TGS in what stands: under 100 kg a box of a kilogram sinks by 1.5 and 1.1 mm,
under a tonne by 25 and 1.3; up to 30 kg TGS errs more, and trembles."""
PARTING = 0.1
"""How fast [m/s] PGS moves bodies apart that are inside each other (`PxRigidBody::setMaxDepenetrationVelocity`). What an
iteration moves is a velocity, of which the last one leaves some: without a bound a box that starts a quarter within another is
thrown out at 4.9 m/s, at 1 m/s at .44, at .1 at .0009; eight cubes that collide lose 1.4 times the angular momentum that they
lose as PhysX comes, at 1 m/s as many, at .1 .4 times."""
TOUCH = 1e-6
"""The gap [m] at which contacts begin where things rebound under PGS (`PxShape::setContactOffset`). PGS turns what has
overlapped by an exact impulse, and what it foresees wrongly; either solver turns a ball that has 8 mm to go at 2 m/s before it
touches, so that no friction acts. Seven balls on rough ground err by 1e-6 m/s so, under TGS by .15, and by .96 where contacts
begin at 10 mm; a gas keeps its angular momentum to a millionth, under TGS to 6e-4. At .1 mm a cradle fails in 1/3840 s."""
FEW, MANY = 50, 255
"""Iterations: for most scenes, and the most that PhysX takes."""


def suited(scene: Scene, constrained: bool) -> str:
    """'tgs' or 'pgs'.

    TGS moves bodies within a step, in as many parts as it has iterations; PhysX has it for large mass ratios, long chains and
    jointed systems, and says that it may bring in energy where it corrects errors (API reference, `PxSolverType`). It is taken

    * where there is torsional friction, which PGS does not know;
    * where something rebounds and gravity brings it to rest: a bounce errs by a tenth of what it does under PGS, which without
      gravity is exact, if contacts begin at a touch (`TOUCH`);
    * for joints that are constraints: PGS reads them at the start of a step, by which a conical pendulum errs 9 times as much,
      a four-bar 25 times, and takes the turning of a body that is led for nought;
    * for springs and drives of trees where nothing touches: a spring errs 47 times as much under PGS;
    * where gravity presses together, without drives, what is led or turns at the start: what rolls on a table that is led, or
      spins on its feet, PGS brakes wrongly. In what slides PGS errs less, across directions by 24 times;
    * where masses that may touch are more unlike than `UNLIKE`.

    PGS keeps what rests quiet, holds what drives keep in its place, and keeps the spin of a free ball and the attitude of a
    free tree, of which each iteration of TGS loses something to rounding.

    Args: constrained: is a joint not in reduced coordinates?
    """
    effects = scene.effects
    touching = Effect.CONTACT in effects
    if Effect.TORSIONAL_FRICTION in effects or Effect.RESTITUTION | Effect.GRAVITY in effects:
        return "tgs"
    if Effect.JOINTS in effects:
        moved = any(motors_of(joint, effects) for joint in scene.joints if isinstance(joint, Revolute | Prismatic))
        if constrained or (moved and not touching):
            return "tgs"
    if not touching or Effect.DRIVES in effects or Effect.GRAVITY not in effects:
        return "pgs"
    solid = [body for body in scene.bodies if body.collision]
    masses = [body.mass for body in solid if body.movable]
    turning = any(body.motion == "kinematic" or (body.movable and any(body.w_WB)) for body in solid)
    return "tgs" if turning or max(masses, default=0.0) > UNLIKE * min(masses, default=1.0) else "pgs"


def iterations_for(scene: Scene, trees: Iterable[JointTree]) -> int:
    """`MANY` where a machine on drives stands or works with parts lighter than all of it by more than `UNLIKE`, else `FEW`.

    PhysX asks for more in articulations with drives that touch, strong drives and large ratios of masses (API reference,
    `PxArticulationReducedCoordinate::setSolverIterationCounts`): a humanoid of 70 kg on feet of .66 kg sways by 61 mrad at 50,
    by 17 at 100, 2.7 at 200 and 1.1 at 255, at 4 times the price; a quadruped, of 75 times its shanks, by 7 urad at 50.
    """
    if Effect.CONTACT | Effect.DRIVES | Effect.GRAVITY not in scene.effects:
        return FEW
    for tree in trees:
        names = {tree.root, *(branch.node for branch in tree.branches)} - {WORLD}
        parts = [body for body in map(scene.body, names) if body.movable]
        touching = [body.mass for body in parts if body.collision]
        if touching and sum(body.mass for body in parts) > UNLIKE * min(touching):
            return MANY
    return FEW
