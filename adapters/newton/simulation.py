"""A running world of Newton: two states that a solver steps between, by graphs of its kernels."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from plumbline.adapters.newton import contacts as touching
from plumbline.adapters.newton import rays
from plumbline.adapters.newton.joints import Driven
from plumbline.adapters.newton.led import Led, answer, turned
from plumbline.adapters.newton.stepper import Side, Stepper
from plumbline.adapters.newton.vendor import Vendor, view
from plumbline.harness.adapter import Notice, Settings, Unsupported
from plumbline.harness.adapter.distance_springs import DistanceSprings
from plumbline.harness.adapter.what_goes_in import check_state, check_targets, check_velocities, check_wrench
from plumbline.harness.scene import Camera, Scene, Vector3
from plumbline.harness.trajectory import Contacts, Floats, Hits, Image, State


@dataclass(slots=True)
class World:
    """What was made of a scene.

    Terms: links: Newton's numbers of bodies by name, -1 of what stands still. owners: by Newton's numbers of shapes the places
    of their bodies. solver: None where nothing moves. pipeline: finds contacts, where the solver does not do so itself.
    """

    vendor: Vendor
    model: Any
    solver: Any
    links: Mapping[str, int]
    owners: list[int]
    driven: Mapping[str, Driven]
    pipeline: Any = None
    springs: DistanceSprings | None = None
    notices: list[Notice] = field(default_factory=list)


class NewtonSimulation:
    """One world. Args: used: the resolved settings."""

    def __init__(self, scene: Scene, used: Settings, world: World) -> None:
        self._scene, self._used, self._world = scene, used, world
        self._start, self._h, self._begun = State.initial(scene), used.substep, False
        self._places = [k for k, body in enumerate(scene.bodies) if body.motion != "static"]
        self._rows = [world.links[scene.bodies[k].name] for k in self._places]
        self._stepper = Stepper(world.vendor, world.model, world.solver, world.pipeline, used.substep)
        self._led = [self._way(k) for k, body in enumerate(scene.bodies) if body.motion == "kinematic"]
        self._towed = any(int(parent) in {leader.row for leader in self._led} for parent in view(world.model.joint_parent))
        self._pushed: tuple[Floats, Floats] | None = None
        self._set_out()

    def _way(self, number: int) -> Led:
        """How a body is led from the start on."""
        start, model, row = self._start, self._world.model, self._world.links[self._scene.bodies[number].name]
        joint = int(np.flatnonzero(view(model.joint_child) == row)[0])
        at, rate_at = int(view(model.joint_q_start)[joint]), int(view(model.joint_qd_start)[joint])
        return Led(number, row, at, rate_at, *(a[number].copy() for a in (start.p_WB, start.q_WB, start.v_WB, start.w_WB)))

    def _set_out(self) -> None:
        """Both states at the start of the scene, and what drives ask for."""
        self._stepper.put(self._rows, self._start, self._places)
        for driven in self._world.driven.values():
            self._aim(driven, driven.drive.target)

    def _aim(self, driven: Driven, target: float) -> None:
        aim = driven.aim(target)
        self._stepper.aim(driven.number, aim.position, aim.rate, aim.push)

    @property
    def resolved(self) -> Settings:
        """What is used, defaults filled in."""
        return self._used

    @property
    def force_lead(self) -> float:
        """Semi-implicit Euler goes x + v dt + (1 + 1/k)/2 f dt^2 in k sub-steps."""
        return 0.5 if self._used.integrator == "rk4" else 0.5 * (1.0 - 1.0 / (self._used.substeps or 1))

    def step(self, count: int = 1) -> None:
        """Advance by count * dt. Raises: Diverged."""
        if self._world.solver is None:
            return
        busy = bool(self._led) or self._world.springs is not None
        for _ in range(count * (self._used.substeps or 1)):
            if busy:
                self._before()
            self._stepper.step()
            self._begun = True
            if busy:
                self._after()
        self._stepper.check()

    def _before(self) -> None:
        """Lead what is led, and push what springs push, in the coming sub-step."""
        if self._world.springs is not None:
            self._push(*self._sprung(self._world.springs))
        if self._led:
            side = self._stepper.here
            before = side.joint_qd.copy()
            self._lead(side, self._led)
            if self._towed and (before != side.joint_qd).any():
                answer(self._world.vendor.newton, self._world.model, side.state, side.joint_qd, before)

    def _sprung(self, springs: DistanceSprings) -> tuple[Floats, Floats]:
        """Forces [N] and torques [N m] of the springs between points beside those from outside, each (n, 3), in W."""
        present = State.empty(len(self._scene.bodies))
        self.state(present)
        f_B_W, tau_B_W = springs.forces(present)
        return (f_B_W, tau_B_W) if self._pushed is None else (f_B_W + self._pushed[0], tau_B_W + self._pushed[1])

    def _after(self) -> None:
        """What is led comes to where its velocity brings it, whatever single precision makes of that."""
        for leader in self._led:
            leader.p = leader.p + self._h * leader.v
            leader.q = turned(leader.w, self._h, leader.q)
        self._lead(self._stepper.here, self._led)
        if self._towed:
            self._stepper.follow(self._stepper.here)

    def _lead(self, side: Side, led: Sequence[Led]) -> None:
        """Tell a state where bodies are led, as bodies and as coordinates of their free joints."""
        for leader in led:
            side.q[leader.row, :3], side.q[leader.row, 3:] = leader.p, np.roll(leader.q, -1)
            side.qd[leader.row, :3], side.qd[leader.row, 3:] = leader.v, leader.w
            side.joint_q[leader.at : leader.at + 7], side.joint_qd[leader.rate_at : leader.rate_at + 6] = (
                side.q[leader.row],
                side.qd[leader.row],
            )

    def retime(self, dt: float) -> None:
        """The length [s] of each step from the next one on. Raises: Unsupported."""
        if self._world.springs is not None and self._world.springs.implicit:
            raise Unsupported(
                "steps of uneven lengths beside springs that are taken implicitly", "the last step has to be as long"
            )
        self._h = dt / (self._used.substeps or 1)
        self._stepper.retime(self._h)

    def state(self, out: State) -> None:
        """Write the present state into `out`. Raises: Diverged."""
        check_state(len(self._scene.bodies), out)
        start = self._start
        out.p_WB[:], out.q_WB[:], out.v_WB[:], out.w_WB[:] = start.p_WB, start.q_WB, start.v_WB, start.w_WB
        if not self._begun or not self._places:
            return
        self._stepper.get(self._rows, out, self._places)

    def contacts(self) -> Contacts:
        """The points of the last sub-step, where they are at its end. Raises: Unsupported."""
        if self._used.solver == "xpbd":
            raise Unsupported(
                "contacts of what rebounds", "XPBD tells forces of contacts approximately, and those of rebounds not at all"
            )
        if not self._begun or self._world.solver is None:
            return Contacts.none()
        before, after = self._stepper.there.q, self._stepper.here.q
        return touching.of_mujoco(self._world.solver, self._world.model, self._world.owners, before, after)

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hits, see `Simulation.cast`."""
        return rays.cast(
            self._world.vendor, self._world.model, self._world.owners, self._shown(), origins, directions, max_range
        )

    def caster(self, origins: Floats, directions: Floats, max_range: float) -> Callable[[], object]:
        """A function that casts these rays again and leaves Newton's own hits."""
        return rays.caster(self._world.vendor, self._world.model, self._shown(), origins, directions, max_range)

    def _shown(self) -> Callable[[], Any]:
        return lambda: self._stepper.here.state

    def render(self, camera: Camera, colour: bool = True) -> Image:  # noqa: ARG002  # nothing is drawn here
        """Raises: Unsupported."""
        raise Unsupported(f"image of camera '{camera.name}'", "Newton's pictures are not asked for here")

    def command(self, targets: Mapping[str, float]) -> None:
        """Targets of drives by joint, see `Simulation.command`."""
        check_targets(self._scene, targets)
        for name, target in targets.items():
            if name in self._world.driven:
                self._aim(self._world.driven[name], float(target))

    def prescribe(self, velocities: Mapping[str, tuple[Vector3, Vector3]]) -> None:
        """Set v_WB and w_WB of kinematic bodies."""
        check_velocities(self._scene, velocities)
        for name, (v, w) in velocities.items():
            for leader in self._led:
                if leader.number == self._scene.index(name):
                    leader.v, leader.w = np.array(v, dtype=np.float64), np.array(w, dtype=np.float64)

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Forces [N] and torques [N m] in W on each body, shapes (n, 3), that act from now on."""
        check_wrench(len(self._scene.bodies), f_B_W, tau_B_W)
        self._pushed = f_B_W.copy(), tau_B_W.copy()
        self._push(f_B_W, tau_B_W)

    def _push(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        moved = [(k, row) for k, row in zip(self._places, self._rows, strict=True) if self._scene.bodies[k].movable]
        places, rows = [k for k, _ in moved], [row for _, row in moved]
        for side in self._stepper.sides:
            side.f[rows, :3], side.f[rows, 3:] = f_B_W[places], tau_B_W[places]

    def warnings(self) -> tuple[Notice, ...]:
        """What is computed beside the scene."""
        return (*self._world.notices, *self._stepper.notices())

    def save(self) -> object:
        """All that decides the future, bit for bit."""
        return self._stepper.save(), [replace(leader) for leader in self._led], self._pushed, self._begun

    def restore(self, saved: object) -> None:
        """Back to a saved state."""
        arrays, led, self._pushed, self._begun = cast(tuple[list[Floats], list[Led], Any, bool], saved)
        self._stepper.restore(arrays)
        self._led = [replace(leader) for leader in led]

    def close(self) -> None:
        """Let go of the world; may be called twice."""
        self._stepper.close()
