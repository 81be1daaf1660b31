"""A world of Rapier as it runs: stepping, state, contacts, rays, and what acts on it from outside."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from plumbline.adapters.rapier import rays
from plumbline.adapters.rapier.joints import DriveTold, check_target
from plumbline.adapters.rapier.led import Led
from plumbline.adapters.rapier.options import vendor_steps
from plumbline.harness.adapter import Diverged, Notice, Settings, Unsupported
from plumbline.harness.adapter.motors import drive_motor
from plumbline.harness.adapter.what_goes_in import check_state, check_targets, check_velocities, check_wrench
from plumbline.harness.scene import Camera, Scene, Vector3
from plumbline.harness.trajectory import Contacts, Floats, Hits, Image, State


@dataclass(slots=True)
class Made:
    """What was made of a scene. Terms: handles: of its bodies. owners: by the index of a collider, the place of its body."""

    rapier: Any
    world: Any
    handles: list[Any] = field(default_factory=list)
    owners: dict[int, int] = field(default_factory=dict)
    drives: dict[str, DriveTold] = field(default_factory=dict)
    notices: list[Notice] = field(default_factory=list)
    unseen: Callable[[], None] | None = None
    """Gives the bodies their shapes, where they are there for rays alone."""


GREATEST = 1e18
"""A length [m] or speed whose square single precision still holds."""


class RapierSimulation:
    """One world. Args: used: the resolved settings."""

    def __init__(self, scene: Scene, used: Settings, contents: Made) -> None:
        self._scene, self._used, self._contents = scene, used, contents
        self._start = State.initial(scene)
        self._moving = [k for k, body in enumerate(scene.bodies) if body.motion != "static"]
        self._beyond = (
            not max(np.abs(array).max(initial=0.0) for array in (self._start.p_WB, self._start.v_WB, self._start.w_WB))
            <= GREATEST
        )
        self._hooks, self._steps = contents.world.physics_hooks, vendor_steps(used)
        on_path = used.options["on_path"]
        self._led = {k: Led.of(b) for k, b in enumerate(scene.bodies) if on_path and b.motion == "kinematic"}
        self._begun = False
        self._see()

    def _see(self) -> None:
        """Take views of the bodies that move."""
        bodies = self._contents.world.rigid_bodies
        self._views = [bodies[self._contents.handles[k]] for k in self._moving]

    @property
    def resolved(self) -> Settings:
        """What is used, defaults filled in."""
        return self._used

    @property
    def force_lead(self) -> float:
        """Semi-implicit Euler goes x + v dt + (1 + 1/k)/2 f dt^2 in k sub-steps."""
        return 0.5 * (1.0 - 1.0 / (self._used.substeps or 1))

    def step(self, count: int = 1) -> None:
        """Advance by count * dt. Raises: Diverged."""
        if self._beyond:
            raise Diverged(f"Rapier: a number of the start is beyond {GREATEST:g}, where the squares of single precision end")
        world, self._begun = self._contents.world, self._begun or count > 0
        dt, led = world.integration_parameters.dt, [(self._views[self._moving.index(k)], each) for k, each in self._led.items()]
        for _ in range(count * self._steps):
            for view, each in led:
                each.put_back(self._contents.rapier, view)
            world.step()
            for _, each in led:
                each.go(dt)
            if not world.quarantine.is_empty:
                raise Diverged("Rapier: a body's pose or velocity stopped being finite; it was put back and disabled")

    def retime(self, dt: float) -> None:
        """The length [s] of each step from the next one on."""
        self._contents.world.integration_parameters.dt = dt / self._steps

    def state(self, out: State) -> None:
        """Write the present state into `out`. Raises: Diverged."""
        check_state(len(self._scene.bodies), out)
        start = self._start
        out.p_WB[:], out.q_WB[:], out.v_WB[:], out.w_WB[:] = start.p_WB, start.q_WB, start.v_WB, start.w_WB
        # A multibody takes up its velocities in its first step.
        if not self._views or not self._begun:
            return
        rows = []
        for body in self._views:
            p, q, v, w = body.translation, body.rotation, body.linvel, body.angvel
            rows.append((p.x, p.y, p.z, q.w, q.i, q.j, q.k, v.x, v.y, v.z, w.x, w.y, w.z))
        table = np.array(rows)
        if not math.isfinite(table.sum()):
            raise Diverged("Rapier: a pose or velocity stopped being finite")
        moving = self._moving
        out.p_WB[moving], out.q_WB[moving] = table[:, :3], table[:, 3:7]
        out.v_WB[moving], out.w_WB[moving] = table[:, 7:10], table[:, 10:]

    def contacts(self) -> Contacts:
        """The points of the vendor's last step that overlap or bear a force, of which Rapier tells the normal part alone."""
        contents, dt = self._contents, self._contents.world.integration_parameters.dt
        a, b, points, normals, gaps, sizes = [], [], [], [], [], []
        for pair in contents.world.narrow_phase.contact_pairs():
            first, second = pair.collider1, pair.collider2
            pose_first, pose_second = (contents.world.colliders[handle].position for handle in (first, second))
            for manifold in pair.manifolds:
                n = manifold.data.normal
                for point in manifold.points:
                    if point.dist > 0 and point.impulse == 0:
                        continue
                    p, q = pose_first.transform_point(point.local_p1), pose_second.transform_point(point.local_p2)
                    a.append(contents.owners[first.index])
                    b.append(contents.owners[second.index])
                    points.append(((p.x + q.x) / 2, (p.y + q.y) / 2, (p.z + q.z) / 2))
                    normals.append((n.x, n.y, n.z))
                    # What Rapier tells of the gap is of the start of the step, before the bodies moved.
                    gaps.append((q.x - p.x) * n.x + (q.y - p.y) * n.y + (q.z - p.z) * n.z)
                    sizes.append(point.impulse / dt)
        normal = np.array(normals).reshape(-1, 3)
        return Contacts.of(a, b, points, normal, gaps, np.array(sizes)[:, None] * normal) if a else Contacts.none()

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hits, see `Simulation.cast`."""
        self._shape()
        return rays.cast(self._contents.rapier, self._contents.world, self._contents.owners, origins, directions, max_range)

    def caster(self, origins: Floats, directions: Floats, max_range: float) -> Callable[[], object]:
        """A function that casts these rays again and gives the binding's own hits."""
        self._shape()
        return rays.caster(self._contents.rapier, self._contents.world, origins, directions, max_range)

    def _shape(self) -> None:
        """Shapes that touch nothing, before the first ray meets them."""
        if self._contents.unseen is not None:
            self._contents.unseen()
            self._contents.unseen = None

    def render(self, camera: Camera, colour: bool = True) -> Image:  # noqa: ARG002  # there is nothing to draw with
        """Raises: Unsupported."""
        raise Unsupported(f"image of camera '{camera.name}'", "Rapier draws no pictures")

    def command(self, targets: Mapping[str, float]) -> None:
        """Targets of drives by joint, see `Simulation.command`. Raises: ValueError, Unsupported."""
        check_targets(self._scene, targets)
        for name, target in targets.items():
            if name not in self._contents.drives:
                continue
            driven = self._contents.drives[name]
            law = drive_motor(driven.drive, float(target), driven.position)
            check_target(name, driven.wraps and law.stiffness > 0, law.target)
            world, motor = self._contents.world, (driven.axis, law.target, law.rate, law.stiffness, law.damping)
            if driven.reduced:
                multibody, link = world.multibody_joints.get(driven.joint)
                multibody.set_link_motor(link, *motor)
            else:
                world.impulse_joints.get(driven.joint).data.set_motor(*motor)
            world.wake_up_all()

    def prescribe(self, velocities: Mapping[str, tuple[Vector3, Vector3]]) -> None:
        """Set v_WB and w_WB of kinematic bodies."""
        check_velocities(self._scene, velocities)
        for name, (v, w) in velocities.items():
            number = self._scene.index(name)
            view = self._views[self._moving.index(number)]
            view.linvel, view.angvel = tuple(map(float, v)), tuple(map(float, w))
            if number in self._led:
                self._led[number].v, self._led[number].w = np.array(v, dtype=np.float64), np.array(w, dtype=np.float64)

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Forces [N] and torques [N m] in W on each body, shapes (n, 3), that act from now on."""
        check_wrench(len(self._scene.bodies), f_B_W, tau_B_W)
        for body_index, body in zip(self._moving, self._views, strict=True):
            if self._scene.bodies[body_index].movable:
                body.reset_forces()
                body.reset_torques()
                if f_B_W[body_index].any():
                    body.add_force(f_B_W[body_index].tolist())
                if tau_B_W[body_index].any():
                    body.add_torque(tau_B_W[body_index].tolist())

    def warnings(self) -> tuple[Notice, ...]:
        """What is computed beside the scene."""
        return tuple(self._contents.notices)

    def save(self) -> object:
        """The vendor's snapshot of the world."""
        return self._contents.world.snapshot(), self._begun, {k: replace(led) for k, led in self._led.items()}

    def restore(self, saved: object) -> None:
        """Back to a saved state: a new world with the same handles, without hooks, which are set again."""
        snapshot, self._begun, led = cast(tuple[bytes, bool, dict[int, Led]], saved)
        self._led = {k: replace(each) for k, each in led.items()}
        self._contents.world = self._contents.rapier.PhysicsWorld.restore(snapshot)
        if self._hooks is not None:
            self._contents.world.physics_hooks = self._hooks
        self._see()

    def close(self) -> None:
        """Let go of the world; may be called twice."""
        self._views = []
