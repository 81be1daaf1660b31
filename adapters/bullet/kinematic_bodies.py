"""Kinematic bodies: bases of a mass that nothing moves, which are given their velocity in each (sub)step."""

from dataclasses import dataclass

from plumbline.adapters.bullet.vendor import Port
from plumbline.harness.scene import Vector3


@dataclass(slots=True)
class Belt:
    """A kinematic body.

    Terms:
        number: Bullet's. mass [kg], which is its moments [kg m2] too. gravity [m/s2]: that it is held up against. h [s]: a
        (sub)step. velocity: v_WB [m/s] and w_WB [rad/s] that it has. aim: those that it is to have.
    """

    body: str
    number: int
    mass: float
    gravity: Vector3
    h: float
    velocity: tuple[Vector3, Vector3]
    aim: tuple[Vector3, Vector3]

    def push(self, port: Port) -> None:
        """Prescribe the velocities for the coming (sub)step.

        A change is a force over the (sub)step: written into the base alone it would take along what hangs on it, whose joint
        rates stay.
        """
        p, client = port.bullet, port.client
        position = p.getBasePositionAndOrientation(self.number, physicsClientId=client)[0]
        p.resetBaseVelocity(self.number, *self.velocity, physicsClientId=client)
        weight = [-self.mass * g for g in self.gravity]
        if self.aim != self.velocity:
            share = self.mass / self.h
            (v, w), (to_v, to_w) = self.velocity, self.aim
            weight = [f + share * (b - a) for f, a, b in zip(weight, v, to_v, strict=True)]
            torque = [share * (b - a) for a, b in zip(w, to_w, strict=True)]
            p.applyExternalTorque(self.number, -1, torque, p.WORLD_FRAME, physicsClientId=client)
            self.velocity = self.aim
        p.applyExternalForce(self.number, -1, weight, position, p.WORLD_FRAME, physicsClientId=client)
