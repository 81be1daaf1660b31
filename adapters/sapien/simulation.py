"""A world of SAPIEN as it runs: stepping, state, contacts, rays, and what acts on it from outside."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbline.adapters.sapien.joints import Driven
from plumbline.harness.adapter import Diverged, Notice, Settings, Unsupported
from plumbline.harness.adapter.distance_springs import DistanceSprings
from plumbline.harness.adapter.what_goes_in import check_rays, check_state, check_targets, check_velocities, check_wrench
from plumbline.harness.scene import Camera, Scene, Vector3, axis_angle, multiply
from plumbline.harness.trajectory import Contacts, Floats, Hits, Image, State


@dataclass(slots=True)
class World:
    """What was made of a scene. Terms: components: by the number of the body. shape: gives bodies their shapes for rays."""

    sapien: Any
    scene: Any
    system: Any
    components: dict[int, Any] = field(default_factory=dict)
    driven: dict[str, Driven] = field(default_factory=dict)
    notices: list[Notice] = field(default_factory=list)
    shape: Callable[[], Any] | None = None
    springs: DistanceSprings | None = None


@dataclass(slots=True)
class Led:
    """A kinematic body. Terms: p, q: where it is; v, w: how it moves until told otherwise [m, m/s, rad/s]."""

    component: Any
    p: Floats
    q: tuple[float, float, float, float]
    v: Floats
    w: Floats

    def lead(self, sapien: Any, h: float) -> None:
        """Send it to where it is after h [s]."""
        self.p = self.p + h * self.v
        speed = float(np.linalg.norm(self.w))
        if speed > 0:
            x, y, z = (self.w / speed).tolist()
            self.q = multiply(axis_angle((x, y, z), speed * h), self.q)
        self.component.set_kinematic_target(sapien.Pose(self.p.tolist(), list(self.q)))


def in_a_row(numbers: Sequence[int]) -> slice | list[int]:
    """Numbers as an index of arrays, which is a third of the work where they follow each other."""
    first = numbers[0] if numbers else 0
    whole = range(first, first + len(numbers))
    return slice(whole.start, whole.stop) if list(numbers) == list(whole) else list(numbers)


class SapienSimulation:
    """One world. Args: used: the resolved settings."""

    def __init__(self, scene: Scene, used: Settings, world: World) -> None:
        self._scene, self._used, self._world = scene, used, world
        self._start, self._h = State.initial(scene), used.substep
        self._moving = [k for k, body in enumerate(scene.bodies) if body.movable]
        self._views = [world.components[k] for k in self._moving]
        rows = {body: row for row, body in enumerate(world.system.rigid_dynamic_components)}
        self._packed_bodies = len(rows)
        free = {k: rows[body] for k, body in zip(self._moving, self._views, strict=True) if body in rows}
        self._free, self._rows = in_a_row(list(free)), in_a_row(list(free.values()))
        self._links = [(k, body) for k, body in zip(self._moving, self._views, strict=True) if body not in rows]
        start = self._start
        self._led = {
            k: Led(world.components[k], start.p_WB[k], body.q_WB, start.v_WB[k], start.w_WB[k])
            for k, body in enumerate(scene.bodies)
            if body.motion == "kinematic"
        }
        self._pushed: list[tuple[Any, list[float], list[float]]] = []
        self._begun = False

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
        advance, sapien = self._world.system.step, self._world.sapien
        led, pushed, sprung = [*self._led.values()], self._pushed, self._world.springs is not None
        for _ in range(count * (self._used.substeps or 1)):
            for body in led:
                body.lead(sapien, self._h)
            for component, force, torque in (*pushed, *self._sprung()) if sprung else pushed:
                component.add_force_torque(force, torque)
            advance()
            self._begun = True
        if not np.isfinite(self._packed()).all():
            raise Diverged("SAPIEN: a pose or a velocity stopped being finite")

    def _packed(self) -> npt.NDArray[np.float32]:
        """All of the system's numbers: q, p, v and w of each body, and then what each articulation has.

        A system packs these in less time than the binding takes for the pose of one body.
        """
        return np.frombuffer(self._world.system.pack(), dtype=np.float32)

    def _sprung(self) -> list[tuple[Any, list[float], list[float]]]:
        """What the springs between points of two bodies push in the coming sub-step."""
        if self._world.springs is None:
            return []
        present = State.empty(len(self._scene.bodies))
        self.state(present)
        return self._pushes(*self._world.springs.forces(present))

    def _pushes(self, f_B_W: Floats, tau_B_W: Floats) -> list[tuple[Any, list[float], list[float]]]:
        """Forces [N] and torques [N m], each (n, 3), by component; bodies that nothing pushes are left out."""
        return [
            (body, f_B_W[k].tolist(), tau_B_W[k].tolist())
            for k, body in zip(self._moving, self._views, strict=True)
            if f_B_W[k].any() or tau_B_W[k].any()
        ]

    def retime(self, dt: float) -> None:
        """The length [s] of each step from the next one on. Raises: Unsupported."""
        if self._world.springs is not None and self._world.springs.implicit:
            raise Unsupported(
                "steps of uneven lengths beside springs that are taken implicitly", "the last step has to be as long"
            )
        self._h = dt / (self._used.substeps or 1)
        self._world.system.timestep = self._h

    def state(self, out: State) -> None:
        """Write the present state into `out`."""
        check_state(len(self._scene.bodies), out)
        start = self._start
        out.p_WB[:], out.q_WB[:], out.v_WB[:], out.w_WB[:] = start.p_WB, start.q_WB, start.v_WB, start.w_WB
        if not self._begun:
            return
        for k, led in self._led.items():
            out.p_WB[k], out.q_WB[k], out.v_WB[k], out.w_WB[k] = led.p, led.q, led.v, led.w
        free = self._packed()[: 13 * self._packed_bodies].reshape(-1, 13)[self._rows]
        out.q_WB[self._free], out.p_WB[self._free] = free[:, :4], free[:, 4:7]
        out.v_WB[self._free], out.w_WB[self._free] = free[:, 7:10], free[:, 10:]
        for k, link in self._links:
            at = link.entity_pose
            out.p_WB[k], out.q_WB[k] = at.p, at.q
            out.v_WB[k], out.w_WB[k] = link.linear_velocity, link.angular_velocity
        out.q_WB[:] /= np.sqrt(np.einsum("ij,ij->i", out.q_WB, out.q_WB))[:, np.newaxis]

    def contacts(self) -> Contacts:
        """The points of the last sub-step that overlap or bear a force, of which SAPIEN tells the normal part alone."""
        a, b, points, normals, gaps, forces = [], [], [], [], [], []
        for contact in self._world.system.get_contacts():
            second, first = (int(body.entity.name) for body in contact.bodies)
            for point in contact.points:
                if point.separation > 0 and not point.impulse.any():
                    continue
                a.append(first)
                b.append(second)
                points.append(point.position)
                normals.append(point.normal)
                gaps.append(point.separation)
                forces.append(point.impulse / self._h)
        return Contacts.of(a, b, points, normals, gaps, forces) if a else Contacts.none()

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hits, see `Simulation.cast`."""
        crossings = self.caster(origins, directions, max_range)()
        hits = Hits(np.full(len(crossings), np.inf), np.full(len(crossings), -1, dtype=np.int64), np.zeros((len(crossings), 3)))
        for k, hit in enumerate(crossings):
            if hit is not None and hit.distance <= max_range:
                hits.distance[k], hits.body[k], hits.normal_W[k] = hit.distance, int(hit.component.entity.name), hit.normal
        return hits

    def caster(self, origins: Floats, directions: Floats, max_range: float) -> Callable[[], list[Any]]:
        """A function that casts these rays again and gives the binding's own hits."""
        check_rays(origins, directions, max_range)
        if self._world.shape is not None:
            self._world.shape()
            self._world.shape = None
        meets, rays = self._world.system.raycast, list(zip(origins.tolist(), directions.tolist(), strict=True))
        return lambda: [meets(origin, direction, max_range) for origin, direction in rays]

    def render(self, camera: Camera, colour: bool = True) -> Image:  # noqa: ARG002  # nothing is drawn here
        """Raises: Unsupported."""
        raise Unsupported(f"image of camera '{camera.name}'", "SAPIEN draws by Vulkan, which is not asked of a machine here")

    def command(self, targets: Mapping[str, float]) -> None:
        """Targets of drives by joint, see `Simulation.command`."""
        check_targets(self._scene, targets)
        for name, target in targets.items():
            if name in self._world.driven:
                self._world.driven[name].aim(float(target))

    def prescribe(self, velocities: Mapping[str, tuple[Vector3, Vector3]]) -> None:
        """Set v_WB and w_WB of kinematic bodies."""
        check_velocities(self._scene, velocities)
        for name, (v, w) in velocities.items():
            led = self._led[self._scene.index(name)]
            led.v, led.w = np.array(v, dtype=np.float64), np.array(w, dtype=np.float64)

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Forces [N] and torques [N m] in W on each body, shapes (n, 3), that act from now on."""
        check_wrench(len(self._scene.bodies), f_B_W, tau_B_W)
        self._pushed = self._pushes(f_B_W, tau_B_W)

    def warnings(self) -> tuple[Notice, ...]:
        """What is computed beside the scene."""
        return tuple(self._world.notices)

    def save(self) -> object:
        """Raises: Unsupported."""
        raise Unsupported("save", "SAPIEN packs poses and velocities, without what its solver starts from")

    def restore(self, saved: object) -> None:  # noqa: ARG002  # nothing is saved
        """Raises: Unsupported."""
        raise Unsupported("restore", "SAPIEN packs poses and velocities, without what its solver starts from")

    def close(self) -> None:
        """Let go of the world; may be called twice."""
        self._views, self._links, self._free, self._pushed, self._led = [], [], [], [], {}
