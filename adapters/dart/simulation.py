"""One DART world: steps, states, contacts."""

import contextlib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from plumbline.adapters.dart.built import Built
from plumbline.adapters.dart.contacts import FIRST_STEPS, MOST_CONTACTS, SLOW, LastSeen, reported
from plumbline.adapters.dart.drives import Pushes
from plumbline.adapters.dart.forces import Wrenches, push
from plumbline.adapters.dart.reactions import reactions
from plumbline.adapters.dart.rotors import Rotors
from plumbline.adapters.dart.sensing import Caster
from plumbline.adapters.dart.stable_pd import Foresight
from plumbline.adapters.dart.vectors import quaternions
from plumbline.adapters.dart.vendor import correcting
from plumbline.harness.adapter import Diverged, Notice, Settings, Simulation, Unsupported
from plumbline.harness.adapter.distance_springs import DistanceSprings
from plumbline.harness.adapter.what_goes_in import check_state, check_targets, check_velocities, check_wrench
from plumbline.harness.scene import Camera, Effect, Vector3
from plumbline.harness.trajectory import Contacts, Floats, Hits, Image, State
from plumbline.harness.trajectory.joint_states import JointStates

STEPS_UNCHECKED = 32
"""How many steps go by between two looks for NaN within one call of `step`."""
LARGEST_SPEED = 1e100
"""Far above this [rad/s or m/s] the squares in the equations of motion overflow, and DART puts zero for accelerations."""
_NOTHING = contextlib.nullcontext()


class DartSimulation(Simulation):
    """One DART world."""

    def __init__(self, built: Built) -> None:
        self._built: Built | None = built
        self._caster: Caster | None = None
        self._wrench: Wrenches | None = None
        self._last = State.initial(built.scene)
        self._movable = [i for i, body in enumerate(built.scene.bodies) if body.movable]
        self._rotors = Rotors(built) if built.rotors else None
        self._forced = bool(built.belts or built.damped or built.rotors or any(m.works for m in built.motors.values()))
        self._pushes = Pushes(built.motors.values())
        stable = built.motors and built.resolved.options["drives"] == "stable"
        self._foresight = Foresight(built) if stable else None
        self._last_seen = LastSeen(built) if built.resolved.options["deactivation"] else None
        self._steps = 0
        self._crowded = False

    @property
    def _open(self) -> Built:
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
        with correcting(built.dart, built.resolved.options["error_reduction"]) if built.loops else _NOTHING:
            self._advance(built, count * built.substeps)

    def retime(self, dt: float) -> None:
        """The length [s] of each step from the next one on. Raises: Unsupported."""
        built = self._open
        if built.springs is not None and built.springs.implicit:
            raise Unsupported(
                "steps of uneven lengths beside a spring between two points that is taken implicitly",
                "the rate that it leads to is foreseen from the step before, which has to be as long",
            )
        if self._rotors is not None:
            raise Unsupported("steps of uneven lengths beside rotors", "each is a damper of DART, made for one length")
        built.world.setTimeStep(dt / built.substeps)

    def _advance(self, built: Built, count: int) -> None:
        """Take `count` sub-steps. Raises: Diverged."""
        advance = built.world.step
        pushed = self._forced or self._wrench is not None or built.springs is not None
        while count > 0:
            # A run that broke is left early: DART would go on and fill the console with its repairs.
            few = min(count, 1 if self._last_seen and self._steps < FIRST_STEPS else STEPS_UNCHECKED)
            for _ in range(few):
                if pushed:
                    if self._rotors is not None:
                        self._rotors.lead()
                    push(built, self._loads(built), self._movable, self._pushes)
                    if self._foresight:
                        self._foresight.foresee(self._steps > 0)
                advance()
                if self._rotors is not None:
                    self._rotors.check()
            count -= few
            self._steps += few
            self._check(built)

    def _loads(self, built: Built) -> Wrenches | None:
        """What pushes the bodies in the coming sub-step: from outside, and springs between points of two of them."""
        if built.springs is None:
            return self._wrench
        force, torque = self._sprung(built, built.springs)
        return (force, torque) if self._wrench is None else (force + self._wrench[0], torque + self._wrench[1])

    def _sprung(self, built: Built, springs: DistanceSprings) -> Wrenches:
        """What springs between points push in the coming sub-step."""
        present = State.empty(len(built.scene.bodies))
        self.state(present)
        return springs.forces(present)

    def _check(self, built: Built) -> None:
        """DART replaces a pose that is not finite by the identity, but the velocities stay what they are: ask them."""
        if not built.skeletons:
            return
        fastest = float(np.abs(np.concatenate([s.getVelocities() for s in built.skeletons])).max(initial=0.0))
        if not fastest < LARGEST_SPEED:
            raise Diverged(
                f"a velocity of {fastest:g} rad/s or m/s after {self._steps} steps of {built.world.getTimeStep():g} s"
            )
        if self._last_seen and fastest < SLOW:
            self._last_seen.look(self._steps)
        if not self._crowded and built.world.getLastCollisionResult().getNumContacts() >= MOST_CONTACTS:
            self._crowded = True

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
            self._turn(places, quaternions(x[:, :3]))
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

    def joint_states(self) -> JointStates:
        """Coordinates, rates and reactions of the joints of skeletons; of what is a constraint dartpy tells nothing."""
        scene = self._open.scene
        states = JointStates.unknown(scene)
        for k, joint in enumerate(scene.joints):
            if joint.name in self._open.coordinates:
                made = self._open.coordinates[joint.name]
                states.coordinate[k], states.rate[k] = made.getPosition(0), made.getVelocity(0)
        if self._steps > 0:
            present = State.empty(len(scene.bodies))
            self.state(present)
            states.reaction[:] = reactions(self._open, present)
        return states

    def contacts(self) -> Contacts:
        """The contacts of the last step, those of sleeping bodies as they were last seen."""
        now = reported(self._open)
        return self._last_seen.beside(now) if self._last_seen else now

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hit of each ray within max_range [m], by DART's own detector."""
        return self._rays.cast(origins, directions, max_range)

    def caster(self, origins: Floats, directions: Floats, max_range: float) -> Callable[[], list[Any]]:
        """A function that casts these rays again into the shapes as they lie."""
        return self._rays.caster(origins, directions, max_range)

    @property
    def _rays(self) -> Caster:
        self._caster = self._caster or Caster(self._open)
        return self._caster

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

    def prescribe(self, velocities: Mapping[str, tuple[Vector3, Vector3]]) -> None:
        """Set v_WB and w_WB of kinematic bodies, whose joints are DART's velocity actuators."""
        check_velocities(self._open.scene, velocities)
        belts = self._open.belts
        for name, (v, w) in velocities.items():
            belts[name] = belts[name][0], np.array([*w, *v])

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Apply f_B_W (n, 3) N and tau_B_W (n, 3) N m in every step from now on; fixed and kinematic bodies take no notice."""
        check_wrench(len(self._open.scene.bodies), f_B_W, tau_B_W)
        f, tau = f_B_W.copy(), tau_B_W.copy()
        self._wrench = (f, tau) if f.any() or tau.any() else None

    def warnings(self) -> tuple[Notice, ...]:
        """Stand-in detectors, surplus effects, the vendor's messages while building, and solves that stopped early."""
        built = self._open
        notices = list(built.notices)
        if built.cone is not None:
            stats = built.cone.getStats()
            if stats.numAcceptedAtCap or stats.numFailed:
                text = (
                    f"{built.resolved.solver}: of {stats.numSolves} solves {stats.numAcceptedAtCap} stopped at the greatest "
                    f"number of iterations and {stats.numFailed} were left to PGS"
                )
                notices.append(Notice(text))
        if self._crowded:
            text = f"contacts reached {MOST_CONTACTS}, which the pairs then share; dartpy cannot raise the bound"
            notices.append(Notice(text, "capacity"))
        return tuple(notices)

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
        self._caster = self._foresight = self._last_seen = None
        self._built = None
