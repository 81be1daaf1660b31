"""Springs and drives of one multibody: the efforts that are held over a (sub)step."""

import math
from dataclasses import dataclass, field

import numpy as np

from plumbline.adapters.bullet.effective_mass import Footing, Skeleton
from plumbline.adapters.bullet.vendor import LIFTED, Port
from plumbline.harness.scene import Drive, Spring, Vector3
from plumbline.harness.trajectory import Floats


@dataclass(slots=True)
class Actuator:
    """A spring, a drive and a rotor on one joint of one multibody."""

    joint: str
    link: int
    position: float
    spring: Spring | None
    drive: Drive | None
    target: float
    armature: float = 0.0

    def effort(self, q: float, rate: float) -> float:
        """The torque or force [N m or N] at joint coordinate q (from the initial pose) and its rate."""
        x, total = self.position + q, 0.0
        if self.spring is not None:
            total -= self.spring.stiffness * (x - self.spring.rest) + self.spring.damping * rate
        if self.drive is not None:
            pull = self.drive.stiffness * (self.target - x) + self.drive.damping * (self.drive.target_velocity - rate)
            pull += self.drive.feedforward or 0.0
            limit = self.drive.limit
            total += pull if limit is None else min(max(pull, -limit), limit)
        return total


@dataclass(slots=True)
class Actuation:
    """The springs, drives and rotors of one multibody, as efforts that are held over a step of h.

    Where some pose may let the efforts of the step's start reverse a velocity within the step, they are those of its end:
    tau = tau(q + h v', v') with v' = v + h (a + W tau). W is the mobility of the joints, with the points held that stand on
    something; a, the accelerations by all else (gravity, limits, inertial forces, contacts that come and go), is what it was in
    the step before. At the start, and when other points are held than before, it is gravity's. What holds may give way within
    the step, if a wheel slips or a foot lifts off: the efforts are bounded for that (`_bounded`).

    A rotor resists by -armature (v' - v)/h: a damper of armature/h at the step's end, and what it brakes at its start handed
    back.

    Source: Tan, Liu, Turk, Stable Proportional-Derivative Controllers, IEEE CG&A 31 (2011) 34; there a comes from the equations
    of motion, which know nothing of contacts.

    Terms:
        skeleton: None where the efforts of the step's start will do. reach (a,): how far coordinates may move [rad or m] before
        the mobility is worked out anew; what else it was enters a, so that a mobility of a while ago makes no error but one of
        the step's own order.
    """

    actuators: tuple[Actuator, ...]
    h: float
    skeleton: Skeleton | None
    reach: Floats
    footing: Footing
    gravity: Vector3
    motors: tuple[Actuator, ...] = ()
    """Drives that are left to Bullet's own motors."""
    pose: Floats | None = None
    """Where the mobility was worked out."""
    stance: tuple[tuple[int, int], ...] = ()
    """The links that were held there, and in how many directions each point."""
    fall: Floats = field(init=False)
    """The accelerations by gravity there."""
    push: Floats = field(init=False)
    """The mobility times h: changes of the rates by unit efforts held over a step."""
    yielding: Floats = field(init=False)
    """1/(1 + push impedance), with no drive at its limit."""
    unpushed: Floats | None = None
    """The rates that the efforts of the step before alone would have led to."""
    loose: Floats = field(init=False)
    """The push if nothing were held."""
    unheld: Floats | None = None
    """The rates that those efforts would have led to if nothing had been held."""
    springs: Floats = field(init=False)
    """Stiffness, damping and rest, (3, a)."""
    rotors: Floats = field(init=False)
    """Armatures, (a,)."""
    drives: Floats = field(init=False)
    """Stiffness, damping, target velocity, limit and feedforward, (5, a)."""

    def __post_init__(self) -> None:
        if not self.actuators:
            return
        springs = [a.spring or Spring() for a in self.actuators]
        drives = [a.drive or Drive() for a in self.actuators]
        self.springs = np.array([(s.stiffness, s.damping, s.rest) for s in springs]).T
        self.rotors = np.array([a.armature for a in self.actuators])
        limits = [math.inf if d.limit is None else d.limit for d in drives]
        self.drives = np.array(
            [
                (d.stiffness, d.damping, d.target_velocity, limit, d.feedforward or 0.0)
                for d, limit in zip(drives, limits, strict=True)
            ]
        ).T

    def efforts(self, port: Port, number: int) -> list[float]:
        """The torques or forces (a,) N m or N of the coming step."""
        if not self.actuators:
            return []
        states = port.bullet.getJointStates(number, [a.link for a in self.actuators], physicsClientId=port.client)
        if self.skeleton is None:
            return [a.effort(state[0], state[1]) for a, state in zip(self.actuators, states, strict=True)]
        x = np.array([a.position + state[0] for a, state in zip(self.actuators, states, strict=True)])
        v = np.array([state[1] for state in states])
        (k, c, free), (stiff, damped, target_velocity, limit, constant), h = self.springs, self.drives, self.h
        rotors = self.rotors / h
        passive, active = c + h * k + rotors, damped + h * stiff
        start = self.pose is None
        held = self.footing.held(port, number, start)
        stance = tuple(sorted((hold.link, len(hold.rows)) for hold in held))
        rest = k * (x - free) - rotors * v
        pull = stiff * ([a.target for a in self.actuators] - x) + damped * target_velocity + constant
        if self.pose is None or stance != self.stance or (np.abs(x - self.pose) > self.reach).any():
            mobility, self.fall, loose = self.skeleton.response(port, number, self.gravity, held, 0.0 if start else h)
            self.yielding = np.linalg.inv(np.eye(len(x)) + h * mobility * (passive + active))
            if self.pose is None or stance != self.stance:
                self.unpushed = None
            self.pose, self.push, self.stance, self.loose = x, h * mobility, stance, h * loose
            if self.unheld is None:
                # At the start a drive with a stiffness bears what it exerts where it stands, others what gravity asks of them.
                weight = np.linalg.lstsq(mobility, self.fall, rcond=None)[0]
                self.unheld = v - self.loose @ np.where(stiff > 0.0, np.clip(rest - pull, -limit, limit), weight)
        most = pull - rest
        onward = v + h * self.fall if self.unpushed is None else 2 * v - self.unpushed
        end = self.yielding @ (onward + self.push @ (pull - rest))
        # A drive beyond its limit is a constant, which may bring the next one to its own.
        while (beyond := np.abs(pull - active * end) > limit).any():
            pull = np.where(beyond, np.copysign(limit, pull - active * end), pull)
            active = np.where(beyond, 0.0, active)
            end = np.linalg.solve(np.eye(len(x)) + self.push * (passive + active), onward + self.push @ (pull - rest))
        total = pull - active * end - rest - passive * end
        if held:
            total = self._bounded(total, v, most, passive + damped + h * stiff)
        self.unpushed = v + self.push @ total
        self.unheld = v + self.loose @ total
        efforts: list[float] = total.tolist()
        return efforts

    def _bounded(self, total: Floats, v: Floats, most: Floats, impedance: Floats) -> Floats:
        """Efforts (a,) that are safe if what holds gives way: a wheel that slips is far more mobile than one that rolls.

        None then drives its coordinate further beyond the rate `most`/`impedance`, at which it would push no more, than what
        held drove it in the step before. None is raised or turned round.
        """
        assert self.unheld is not None
        sign, reaction = np.sign(total), v - self.unheld
        idle = np.divide(most, impedance, out=np.copysign(LIFTED, most), where=impedance > 0)
        excess = v + reaction + self.loose @ total - idle - sign * np.abs(reaction)
        beyond = sign * excess > 0.0
        if not beyond.any():
            return total
        bounded, less = total.copy(), total[beyond] - np.linalg.solve(self.loose[np.ix_(beyond, beyond)], excess[beyond])
        bounded[beyond] = sign[beyond] * np.clip(sign[beyond] * less, 0.0, np.abs(total[beyond]))
        return bounded
