"""A world of the engine as it runs: stepping, state, contacts, rays, and what acts on it from outside."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, cast

import numpy as np

from plumbline.adapters.reference.joints import shift_of_target
from plumbline.adapters.reference.sensing import picture
from plumbline.harness.adapter import Diverged, Notice, Settings, Unsupported
from plumbline.harness.adapter.what_goes_in import check_rays, check_state, check_targets, check_velocities, check_wrench
from plumbline.harness.scene import Camera, Effect, Prismatic, Revolute, Scene, Vector3
from plumbline.harness.trajectory import Contacts, Floats, Hits, Image, Integers, State
from plumbline.harness.trajectory.joint_states import JointStates

if TYPE_CHECKING:
    from plumbline import engine

__all__ = ["ReferenceSimulation"]


class ReferenceSimulation:
    """One world of the engine. Args: resolved: what it uses; steps: of the engine in one dt."""

    def __init__(self, world: "engine.World", scene: Scene, resolved: Settings, steps: int) -> None:
        self._world, self._scene, self._resolved, self._steps = world, scene, resolved, steps
        self._watched, self._touched = False, list["engine.Contacts"]()
        acting = scene.joints if Effect.DRIVES in scene.effects else ()
        self._shifts = {
            j.name: shift_of_target(j.drive) for j in acting if isinstance(j, Revolute | Prismatic) and j.drive is not None
        }

    @property
    def resolved(self) -> Settings:
        """What the engine uses; with hard contacts, the largest residual so far, and how many solves missed the tolerance."""
        certificate = self._world.certificate
        if certificate is None or certificate.solves == 0:
            return self._resolved
        worst = {"residual": certificate.residual, "missed": certificate.missed}
        return replace(self._resolved, options={**self._resolved.options, **worst})

    @property
    def force_lead(self) -> float:
        """Euler's methods go x + v dt + (1 +- 1/k)/2 f dt^2 in k sub-steps, + semi-implicit, - explicit; the rest is exact."""
        used = self._world.options
        share = {"semi_implicit_euler": -1.0, "explicit_euler": 1.0}.get(used.integrator, 0.0) / (self._steps * used.substeps)
        return 0.5 * (1.0 + share)

    def step(self, count: int = 1) -> None:
        """Advance by count * dt. Raises: Diverged, Unsupported."""
        from plumbline import engine

        listened = self._steps - 1 if self._watched and count > 0 else 0
        try:
            self._world.step(count * self._steps - listened)
            self._touched = []
            for _ in range(listened):
                self._touched.append(self._world.contacts())
                self._world.step(1)
        except engine.Diverged as error:
            raise Diverged(str(error)) from error
        except engine.NotSupported as error:
            raise Unsupported(error.what, error.why) from error

    def retime(self, dt: float) -> None:
        """The length [s] of each step from the next one on. Raises: Unsupported."""
        from plumbline import engine

        try:
            self._world.retime(dt / self._steps)
        except engine.NotSupported as error:
            raise Unsupported(error.what, error.why) from error

    def state(self, out: State) -> None:
        """Write the present state into `out`."""
        table = self._world.state()
        check_state(len(table), out)
        out.p_WB[:], out.q_WB[:], out.v_WB[:], out.w_WB[:] = table[:, :3], table[:, 3:7], table[:, 7:10], table[:, 10:]

    def joint_states(self) -> JointStates:
        """Reactions of the last step; coordinates where the engine has them, which follow from the poses elsewhere."""
        states = JointStates.unknown(self._scene)
        if Effect.JOINTS in self._scene.effects:
            for k, joint in enumerate(self._scene.joints):
                states.reaction[k] = self._world.reaction(joint.name)
                states.coordinate[k], states.rate[k] = self._world.joint_motion(joint.name)
        return states

    def contacts(self) -> Contacts:
        """The contacts of the last dt, of each of its steps those that it found, with the share of their forces in the mean."""
        self._watched = self._steps > 1
        parts = [*self._touched, self._world.contacts()]
        if len(parts) == 1:
            found = parts[0]
            return Contacts.of(found.bodies[:, 0], found.bodies[:, 1], found.point, found.normal, found.gap, found.force)
        bodies, point, normal, gap, force = (
            np.concatenate([getattr(part, name) for part in parts]) for name in ("bodies", "point", "normal", "gap", "force")
        )
        return Contacts.of(bodies[:, 0], bodies[:, 1], point, normal, gap, force / len(parts))

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hit of each ray, see `Simulation.cast`."""
        check_rays(origins, directions, max_range)
        # One origin told r times over is told once.
        hits = self._world.cast(origins[:1] if origins.strides[0] == 0 else origins, directions, max_range)
        return Hits(distance=hits.distance, body=hits.body, normal_W=hits.normal)

    def caster(self, origins: Floats, directions: Floats, max_range: float) -> Callable[[], object]:
        """A function that casts these rays again and gives the engine's own hits."""
        check_rays(origins, directions, max_range)
        return partial(self._world.cast, origins[:1] if origins.strides[0] == 0 else origins, directions, max_range)

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """The engine's own picture. Raises: Unsupported."""
        return picture(self._world, self._scene, camera, colour)

    def command(self, targets: Mapping[str, float]) -> None:
        """Set the targets [rad or m] of drives, those that act."""
        check_targets(self._scene, targets)
        for name, target in targets.items():
            if name in self._shifts:
                self._world.command(name, float(target) + self._shifts[name])

    def prescribe(self, velocities: Mapping[str, tuple[Vector3, Vector3]]) -> None:
        """Set v_WB and w_WB of kinematic bodies."""
        check_velocities(self._scene, velocities)
        for name, (v, w) in velocities.items():
            self._world.prescribe(self._scene.index(name), v, w)

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Forces [N] and torques [N m] in W on each body, shapes (n, 3), that act from now on."""
        check_wrench(len(self._scene.bodies), f_B_W, tau_B_W)
        self._world.set_load(f_B_W, tau_B_W)

    def warnings(self) -> tuple[Notice, ...]:
        """Steps with too many impacts, and how well hard contacts were solved."""
        impacts = self._world.impacts
        if impacts is not None and impacts.crowded > 0:
            text = f"swept: {impacts.crowded} steps had too many impacts and were ended with speculative contacts"
            return (Notice(text),)
        certificate = self._world.certificate
        if certificate is None or certificate.solves == 0:
            return ()
        crowded = (
            f"; {certificate.crowded} sub-steps had too many blows and took the last as one" if certificate.crowded else ""
        )
        precision = f"exact: relative residual at most {certificate.residual:.1g} over {certificate.solves} solves"
        missed = (
            f", {certificate.missed} of them above the tolerance {self._resolved.tolerance:g}, answered by the best that "
            f"{self._world.options.effort:g} ms found"
            if certificate.missed
            else ""
        )
        lessened = (
            f"; {certificate.lessened} blows had less than their restitution, which would have given energy"
            if certificate.lessened
            else ""
        )
        return (Notice(precision + missed + crowded + lessened),)

    def save(self) -> object:
        """Both arrays of the world."""
        return self._world.save()

    def restore(self, saved: object) -> None:
        """Back to a saved state."""
        self._world.restore(cast(tuple[Floats, Integers], saved))
        self._touched = []

    def close(self) -> None:
        """Nothing to free: the world is arrays."""
