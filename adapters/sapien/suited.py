"""The solver for a scene, as the track 'tuned' chooses it."""

from plumbline.harness.adapter.motors import motors_of
from plumbline.harness.scene import Effect, Prismatic, Revolute, Scene

__all__ = ["PARTING", "suited"]

UNLIKE = 100.0
"""Ratio of masses above which PGS errs more than TGS in what stands: under 100 kg a box of a kilogram sinks by 1.5 and 1.1 mm,
under a tonne by 25 and 1.3; up to 30 kg TGS errs more, and trembles."""
PARTING = 0.1
"""How fast [m/s] PGS moves bodies apart that are inside each other (`PxRigidBody::setMaxDepenetrationVelocity`). What an
iteration moves is a velocity, of which the last one leaves some: without a bound a box that starts a quarter within another is
thrown out at 4.9 m/s, at 1 m/s at .44, at .1 at .0009; eight cubes that collide lose 1.4 times the angular momentum that they
lose as PhysX comes, at 1 m/s as many, at .1 .4 times."""


def suited(scene: Scene, constrained: bool) -> str:
    """'tgs' or 'pgs'.

    TGS moves bodies within a step, in as many parts as it has iterations; PhysX has it for large mass ratios, long chains and
    jointed systems, and says that it may bring in energy where it corrects errors (API reference, `PxSolverType`). It is taken

    * where something rebounds, or has torsional friction, which PGS does not know;
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
    if (Effect.RESTITUTION | Effect.TORSIONAL_FRICTION) & effects:
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
