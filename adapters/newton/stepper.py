"""Two states of a model between which a solver steps, by graphs of its kernels.

A step is some hundred kernels. Called one by one from Python they take a hundred times as long on the processor as from a graph
that was captured of them: 12 ms of CPU time against 0.05 ms for a box on a plane over MuJoCo-Warp. Newton's own examples step
from such graphs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.adapters.newton.vendor import Vendor, view
from plumbline.harness.adapter import Diverged, Notice
from plumbline.harness.trajectory import Floats, Integers, State


@dataclass(slots=True)
class Side:
    """One of the two states, with views of its arrays.

    Terms: q (l, 7): positions and quaternions (x, y, z, w) of Newton's bodies. qd, f (l, 6): velocities of centres of mass and
    angular ones, forces and torques, in W. joint_q, joint_qd: coordinates and rates.
    """

    state: Any
    q: Floats
    qd: Floats
    f: Floats
    joint_q: Floats
    joint_qd: Floats

    @classmethod
    def of(cls, state: Any) -> "Side":
        """A state of a model, whose arrays are seen in place."""
        shapes = {"body_q": (0, 7), "body_qd": (0, 6), "body_f": (0, 6), "joint_q": (0,), "joint_qd": (0,)}
        arrays = ((getattr(state, name), shape) for name, shape in shapes.items())
        return cls(state, *(np.zeros(shape) if array is None else view(array) for array, shape in arrays))


class NoContacts:
    """A pipeline of what touches nothing."""

    def contacts(self) -> None:
        """There are none."""

    def collide(self, state: Any, contacts: None) -> None:
        """Nothing is found."""


class Stepper:
    """Steps a model.

    Args: solver: None where nothing moves. pipeline: finds contacts where the solver does not. h: a step [s].
    """

    def __init__(self, vendor: Vendor, model: Any, solver: Any, pipeline: Any, h: float) -> None:
        self.model, self.solver, self.control = model, solver, model.control()
        self.sides = (Side.of(model.state()), Side.of(model.state()))
        self.contacts = None if pipeline is None else pipeline.contacts()
        self._vendor, self._pipeline, self._h = vendor, pipeline, h
        self._now, self._even, self._lost = 0, True, False
        self._graphs: list[Any] = [None, None]
        self._data = getattr(solver, "mjw_data", None)
        self._overflow = np.zeros(1, dtype=np.int32) if self._data is None else view(self._data.overflow)
        self._found = None if self.contacts is None else view(self.contacts.rigid_contact_count)

    @property
    def here(self) -> Side:
        """The present state."""
        return self.sides[self._now]

    @property
    def there(self) -> Side:
        """The state of the step before, which the next one writes over."""
        return self.sides[1 - self._now]

    def step(self) -> None:
        """One step from the present state to the other, which is the present one then."""
        if not self._even:
            self._launch()
        else:
            if self._graphs[self._now] is None:
                with self._vendor.warp.ScopedCapture(device="cpu", force_module_load=False) as capture:
                    self._launch()
                self._graphs[self._now] = capture.graph
            self._vendor.warp.capture_launch(self._graphs[self._now])
        found = self._found is not None and self._found[0] > self.contacts.rigid_contact_max
        self._lost = self._lost or bool(found) or bool(self._overflow.any())
        self._now = 1 - self._now

    def put(self, rows: Sequence[int] | Integers, start: State, places: list[int]) -> None:
        """Both states where bodies start, as bodies and as coordinates of joints.

        Args: rows: Newton's numbers of the places.
        """
        rows = np.asarray(rows, dtype=np.int64)
        for side in self.sides:
            # What single precision has not becomes infinite, and is told in the first step.
            with np.errstate(over="ignore"):
                side.q[rows, :3], side.q[rows, 3:] = start.p_WB[places], np.roll(start.q_WB[places], -1, axis=1)
                side.qd[rows, :3], side.qd[rows, 3:] = start.v_WB[places], start.w_WB[places]
            if self.model.joint_count:
                self._vendor.newton.eval_ik(self.model, side.state, side.state.joint_q, side.state.joint_qd)

    def get(self, rows: Sequence[int] | Integers, out: State, places: list[int]) -> None:
        """Write bodies into `out`. Args: rows: Newton's numbers of the places. Raises: Diverged."""
        rows, side = np.asarray(rows, dtype=np.int64), self.here
        turned = np.roll(side.q[rows, 3:], 1, axis=1).astype(np.float64)
        norms = np.linalg.norm(turned, axis=1, keepdims=True)
        if not (np.isfinite(side.q[rows, :3]).all() and np.isfinite(norms).all() and norms.all()):
            raise Diverged("Newton: a pose stopped being finite")
        out.p_WB[places], out.q_WB[places] = side.q[rows, :3], turned / norms
        out.v_WB[places], out.w_WB[places] = side.qd[rows, :3], side.qd[rows, 3:]

    def follow(self, side: Side) -> None:
        """Poses and velocities of bodies that the coordinates and rates of a state mean."""
        state = side.state
        self._vendor.newton.eval_fk(self.model, state.joint_q, state.joint_qd, state)

    def aim(self, joint: int, position: float, rate: float, push: float) -> None:
        """What the drive of a joint asks for from now on [rad or m, rad/s or m/s, N m or N]. Args: joint: Newton's number."""
        at = int(view(self.model.joint_qd_start)[joint])
        view(self.control.joint_target_q)[int(view(self.model.joint_target_q_start)[joint])] = position
        view(self.control.joint_target_qd)[at] = rate
        view(self.control.joint_f)[at] = push

    def _launch(self) -> None:
        """The kernels of a step, one by one."""
        if self._pipeline is not None:
            self._pipeline.collide(self.here.state, self.contacts)
        self.solver.step(self.here.state, self.there.state, self.control, self.contacts, self._h)

    def retime(self, h: float) -> None:
        """Another length [s] from the next step on; a graph holds its own, so that kernels are called one by one then."""
        self._h, self._even = h, False

    def check(self) -> None:
        """Raises: Diverged, where a number stopped being finite."""
        if not (np.isfinite(self.here.q).all() and np.isfinite(self.here.qd).all()):
            raise Diverged("Newton: a pose or velocity stopped being finite")

    def _decisive(self) -> list[Floats]:
        """Views of all that decides the future: the present state, what drives ask for, what the solver takes over."""
        side, control = self.here, self.control
        targets = [view(a) for a in (control.joint_target_q, control.joint_target_qd, control.joint_f) if a is not None]
        warm = [] if self._data is None else [view(self._data.qacc_warmstart)]
        return [side.q, side.qd, side.f, side.joint_q, side.joint_qd, *targets, *warm]

    def save(self) -> list[Floats]:
        """Copies of all that decides the future."""
        return [array.copy() for array in self._decisive()]

    def restore(self, saved: list[Floats]) -> None:
        """Back to a saved state; forces act on both states."""
        for own, value in zip(self._decisive(), saved, strict=True):
            own[:] = value
        self.there.f[:] = self.here.f

    def notices(self) -> tuple[Notice, ...]:
        """What there was no room for."""
        text = "Newton had no room for all contacts or constraints of a step"
        return (Notice(text, "capacity"),) if self._lost else ()

    def close(self) -> None:
        """Let go of the graphs."""
        self._graphs = [None, None]
