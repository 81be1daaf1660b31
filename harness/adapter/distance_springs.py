"""Springs and dampers between points of two bodies, as forces that an adapter whose engine has none gives the bodies each step.

The field calls the element a translational spring-damper. With l the distance of the anchors and u the unit vector from the
parent's to the child's, the child is pushed by f u at its anchor and the parent by -f u, f = k (rest - l) - c l'.

Where no pose can let the force of a step's start reverse a velocity within the step, f is that force: with semi-implicit Euler
the pair is symplectic and a spring keeps its energy. Elsewhere f is the force of the step's end, linearly implicit along u:

    f = k (rest - l - h l'_1) - c l'_1,    l'_1 = l' + h (a + W f)

W is the mobility of the lines, J M^-1 J^T over the bodies as if nothing else held them; a is what all else (gravity, joints,
contacts) did to l' in the step before. Joints and contacts only take from the mobility, and with too great a W the force merely
follows late: where the true mobility w is at most W the recursion of l' and f is stable at every stiffness (its determinant
tends to 1 - w/W). At rest l' = 0 and h (a + W f) = 0, so that an equilibrium is the scene's. u is that of the step's start: a
line under tension f swings across itself stably while h^2 f W/l < 4.

Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems, 1989, section 9.2.4 (the element); Tan, Liu, Turk,
Stable Proportional-Derivative Controllers, IEEE CG&A 31 (2011) 34 (the force of the step's end).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.harness.scene import WORLD, Distance, Effect, Joint, Scene
from plumbline.harness.trajectory import Floats, Integers, State
from plumbline.harness.trajectory.kinematics import rotate_back


def is_distance_spring(joint: Joint) -> bool:
    """Is the joint a force alone: a distance with a spring, and neither kept nor bounded?"""
    return isinstance(joint, Distance) and joint.spring is not None and joint.limits is None


@dataclass(slots=True)
class DistanceSprings:
    """The distance springs of a scene.

    Terms:
        ends (2, s): places of parents and children among the bodies, -1 for the world. anchors (2, s, 3): in B, in W for the
        world [m]. law (3, s): stiffness, damping, rest. lightness (n,): 1/mass, and turning (n, 3, 3): inverse inertia in B,
        both 0 of bodies that forces do not move. h [s]: the step. implicit: are the forces those of the step's end?
    """

    ends: Integers
    anchors: Floats
    law: Floats
    lightness: Floats
    turning: Floats
    gravity: Floats
    h: float
    implicit: bool
    unpushed: Floats | None = None
    """The rates (s,) that the forces of the step before alone would have led to."""

    @classmethod
    def of(cls, scene: Scene, joints: Sequence[Joint], h: float) -> "DistanceSprings | None":
        """The springs among these joints under a step of h [s]; None where there are none."""
        springs = [j for j in joints if isinstance(j, Distance) and is_distance_spring(j)]
        if not springs:
            return None
        bodies = scene.bodies
        ends = np.array([[-1 if n == WORLD else scene.index(n) for n in (j.parent, j.child)] for j in springs]).T
        points = np.array([[j.anchor_W for j in springs], [j.child_anchor_W for j in springs]], dtype=np.float64)
        p = np.array([*(b.p_WB for b in bodies), (0.0, 0.0, 0.0)])
        q = np.array([*(b.q_WB for b in bodies), (1.0, 0.0, 0.0, 0.0)])
        law = np.array([(j.spring.stiffness, j.spring.damping, j.spring.rest) for j in springs if j.spring]).T
        made = cls(
            ends=ends,
            anchors=rotate_back(q[ends], points - p[ends]),
            law=law,
            lightness=np.array([1.0 / b.mass if b.movable and b.mass else 0.0 for b in bodies] + [0.0]),
            turning=np.array(
                [np.linalg.inv(b.inertia) if b.movable and b.mass else np.zeros((3, 3)) for b in bodies] + [np.zeros((3, 3))]
            ),
            gravity=np.asarray(scene.gravity) * float(Effect.GRAVITY in scene.effects),
            h=h,
            implicit=False,
        )
        made.implicit = made._reversing()
        return made

    def _reversing(self) -> bool:
        """May the forces of a step's start reverse a velocity within it, in some pose?

        They do not while the eigenvalues of h W (C + h K/2) stay below 1. Their sum, the trace, bounds the greatest; an arm r
        is at most |r|^2 times the greatest inverse moment mobile, whichever way the line runs.
        """
        loosest = np.array([np.linalg.eigvalsh(t)[-1] for t in self.turning])
        mobile = self.lightness[self.ends] + np.sum(self.anchors**2, axis=-1) * loosest[self.ends]
        k, c, _ = self.law
        return bool(np.sum(self.h * (c + self.h * k / 2) * mobile.sum(axis=0)) >= 1.0)

    def forces(self, state: State) -> tuple[Floats, Floats]:
        """Forces (n, 3) N at the centres of mass and torques (n, 3) N m on the bodies, in W, for the step that begins here."""
        ends, (k, c, free) = self.ends, self.law
        p, q, v, w = (self._at_ends(a, at_rest) for a, at_rest in zip(_channels(state), _WORLD_AT_REST, strict=True))
        arms = _turned(q, self.anchors)
        points, speeds = p + arms, v + _cross(w, arms)
        way = points[1] - points[0]
        length = np.sqrt(np.einsum("sx,sx->s", way, way))
        if not length.all():
            # Two anchors at one point have no line; as in the other engines any will do.
            way[length == 0.0] = (0.0, 0.0, 1.0)
        line = way / np.where(length > 0.0, length, 1.0)[:, None]
        rate = np.einsum("sx,sx->s", speeds[1] - speeds[0], line)
        f = self._at_the_end(q, arms, line, length, rate) if self.implicit else k * (free - length) - c * rate
        push = _SIGNS * (f[:, None] * line)
        turn = _cross(arms, push)
        force, torque = np.zeros((2, len(self.lightness), 3))
        for end in range(2):
            for spring, body in enumerate(ends[end].tolist()):
                force[body] += push[end, spring]
                torque[body] += turn[end, spring]
        return force[:-1], torque[:-1]

    def _at_ends(self, values: Floats, at_rest: Floats) -> Floats:
        """The values (2, s, ...) of the bodies at the ends; of the world, which is place -1, those of what never moves."""
        return np.vstack((values, at_rest))[self.ends]

    def _at_the_end(self, q: Floats, arms: Floats, line: Floats, length: Floats, rate: Floats) -> Floats:
        """The forces (s,) N of the step's end."""
        h, (k, c, free), s = self.h, self.law, len(rate)
        pull, turn = np.zeros((2, s, len(self.lightness), 3))
        lever = _turned(q * _CONJUGATE, _cross(arms, np.broadcast_to(line, arms.shape)))
        for end, sign in ((0, -1.0), (1, 1.0)):
            pull[np.arange(s), self.ends[end]] += sign * line
            turn[np.arange(s), self.ends[end]] += sign * lever[end]
        moved = pull * self.lightness[:, None]
        turned = np.einsum("nxy,sny->snx", self.turning, turn)
        W = pull.reshape(s, -1) @ moved.reshape(s, -1).T + turn.reshape(s, -1) @ turned.reshape(s, -1).T
        if self.unpushed is None:
            fall = self.gravity * (self.lightness > 0.0)[:, None]
            onward = rate + h * np.einsum("snx,nx->s", pull, fall)
        else:
            onward = 2.0 * rate - self.unpushed
        stiff = c + h * k
        f: Floats = np.linalg.solve(np.eye(s) + h * stiff[:, None] * W, k * (free - length) - stiff * onward)
        self.unpushed = rate + h * W @ f
        return f


_SIGNS = np.array([[[-1.0]], [[1.0]]])
_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])
_WORLD_AT_REST = (np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3), np.zeros(3))


def _channels(state: State) -> tuple[Floats, Floats, Floats, Floats]:
    return state.p_WB, state.q_WB, state.v_WB, state.w_WB


def _cross(a: Floats, b: Floats) -> Floats:
    """a x b, (..., 3): numpy's own takes five times as long for a few rows."""
    product = np.empty(a.shape)
    product[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    product[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    product[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def _turned(q: Floats, vector: Floats) -> Floats:
    """The vectors (..., 3) turned by unit quaternions (..., 4)."""
    u = q[..., 1:]
    t = 2.0 * _cross(u, vector)
    return vector + q[..., :1] * t + _cross(u, t)
