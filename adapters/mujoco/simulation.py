"""A model of MuJoCo as it runs: stepping, state, contacts, and what acts on it from outside."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from plumbline.adapters.mujoco.frames import cross
from plumbline.adapters.mujoco.images import Renderer
from plumbline.adapters.mujoco.inertial import Inertial
from plumbline.adapters.mujoco.joint_states import JointReader
from plumbline.adapters.mujoco.prescribed import prescribe
from plumbline.adapters.mujoco.rays import cast, caster
from plumbline.adapters.mujoco.vendor import OPEN, counters, fatal, flag
from plumbline.adapters.mujoco.world import World
from plumbline.harness.adapter import Diverged, Notice, Settings, Unsupported
from plumbline.harness.adapter.between import write_between
from plumbline.harness.adapter.rotations import products
from plumbline.harness.adapter.what_goes_in import check_state, check_targets, check_velocities, check_wrench
from plumbline.harness.scene import Camera, Vector3
from plumbline.harness.trajectory import Contacts, Floats, Hits, Image, State
from plumbline.harness.trajectory.joint_states import JointStates


class MujocoSimulation:
    """One scene in one `MjData`."""

    def __init__(self, world: World, resolved: Settings, notices: tuple[Notice, ...]) -> None:
        self._world, self._resolved, self._notices = world, resolved, notices
        self._mj, self._m, self._d, self._indices = world.mj, world.model, world.state, world.indices
        self._substeps = resolved.substeps or 1
        self._advance = world.mj.mj_step
        self._kind = flag(world.mj, "mjtState", "mjSTATE_INTEGRATION")
        self._numbers = self._d.warning.number
        self._clean = self._numbers.tobytes()
        self._movable = np.array([k for k, b in enumerate(world.scene.bodies) if b.movable and not b.massless], dtype=np.int64)
        self._massless = [k for k, b in enumerate(world.scene.bodies) if b.massless]
        hung = self._indices.hung
        self._natives = {
            chain.joints: np.array([hung[world.scene.joints[k].name].native for k in chain.joints])
            for chain in self._indices.chains
        }
        self._root = self._m.body_rootid[self._indices.body]
        self._renderer, self._inertial, self._joints = Renderer(world), Inertial(world), JointReader(world)

    @property
    def resolved(self) -> Settings:
        """The settings read back from the compiled model."""
        return self._resolved

    @property
    def force_lead(self) -> float:
        """RK4 moves exactly under a force that it holds; the others go x + v dt + (k + 1)/(2 k) f dt^2 in k sub-steps."""
        if self._m.opt.integrator == flag(self._mj, "mjtIntegrator", "mjINT_RK4"):
            return 0.5
        return (self._substeps - 1) / (2 * self._substeps)

    def step(self, count: int = 1) -> None:
        """Advance by count * dt in one native call. Raises: Diverged."""
        self._advance(self._m, self._d, count * self._substeps)
        # One comparison of bytes is all that a step pays for being watched.
        if self._numbers.tobytes() != self._clean:
            self._examine()

    def retime(self, dt: float) -> None:
        """The length [s] of each step from the next one on; time constants of constraints stay those of the built step."""
        self._m.opt.timestep = dt / self._substeps

    def _examine(self) -> None:
        """Has a counter risen that says that the state is lost? Raises: Diverged."""
        if self._numbers[fatal(self._mj)].any():
            raise Diverged(f"NaN, Inf or a value above {OPEN:g} ({'; '.join(self._counted())}) by time {self._d.time:.9g} s")
        self._clean = self._numbers.tobytes()

    def _counted(self) -> list[str]:
        """The vendor's warnings, with how often each was given."""
        return [f"{name} x{number}" for name, number in zip(counters(self._mj), self._numbers, strict=True) if number]

    def state(self, out: State) -> None:
        """Write p_WB, q_WB, v_WB and w_WB."""
        check_state(len(self._indices.body), out)
        self._world.renew_poses()
        d, body = self._d, self._indices.body
        out.p_WB[:] = d.xpos[body]
        q_WM, q_MB = d.xquat[body], self._indices.q_MB
        out.q_WB[:] = q_WM if q_MB is None else products(q_WM, q_MB)
        motion = d.cvel[body]
        out.w_WB[:] = motion[:, :3]
        out.v_WB[:] = motion[:, 3:]
        if not self._indices.single:
            # cvel belongs to the point that lies at the centre of mass of the whole tree.
            out.v_WB[:] += cross(motion[:, :3], d.xpos[body] - d.subtree_com[self._root])
        for chain in self._indices.chains:
            natives = self._natives[chain.joints]
            at, dof = self._m.jnt_qposadr[natives], self._m.jnt_dofadr[natives]
            write_between(self._world.scene, chain, d.qpos[at], d.qvel[dof], out)

    def contacts(self) -> Contacts:
        """The contacts of the last step with their forces on B."""
        mj, m, d = self._mj, self._m, self._d
        count = d.ncon
        if not count:
            return Contacts.none()
        contact = d.contact
        force, wrench = np.zeros((count, 3)), np.zeros(6)
        frame = np.array(contact.frame).reshape(count, 3, 3)
        for k in range(count):
            mj.mj_contactForce(m, d, k, wrench)
            force[k] = wrench[:3] @ frame[k]
        body = self._indices.owner[np.array(contact.geom).reshape(count, 2)]
        return Contacts.of(body[:, 0], body[:, 1], np.array(contact.pos), frame[:, 0], np.array(contact.dist), force)

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hit of each ray, see `Simulation.cast`."""
        return cast(self._world, origins, directions, max_range)

    def caster(self, origins: Floats, directions: Floats, max_range: float) -> Callable[[], tuple[Any, Floats, Floats]]:
        """A function that casts these rays again, into arrays of geoms, distances [m] and normals made beforehand."""
        return caster(self._world, origins, directions, max_range)

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """The picture of MuJoCo's own renderer. Raises: Unsupported."""
        return self._renderer.render(camera, colour)

    def inertial(self, name: str) -> tuple[Floats, Floats]:
        """Specific force [m/s2] and angular velocity [rad/s] in S, each (3,), by MuJoCo's own sensors at this instant."""
        return self._inertial.read(name)

    def joint_states(self) -> JointStates:
        """What the engine holds of the scene's joints at this instant, see `harness.adapter`."""
        return self._joints.read()

    def command(self, targets: Mapping[str, float]) -> None:
        """Set the targets of drives [rad or m]."""
        check_targets(self._world.scene, targets)
        for name, target in targets.items():
            if name in self._indices.drives:
                self._d.ctrl[self._indices.drives[name]] = target

    def prescribe(self, velocities: Mapping[str, tuple[Vector3, Vector3]]) -> None:
        """Set v_WB and w_WB of kinematic bodies."""
        check_velocities(self._world.scene, velocities)
        prescribe(self._world, velocities)

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Force [N] at the centre of mass and torque [N m] in W on every movable body, in every step from now on.

        Raises: Unsupported, of one on a body without mass.
        """
        check_wrench(len(self._indices.body), f_B_W, tau_B_W)
        if np.any(f_B_W[self._massless]) or np.any(tau_B_W[self._massless]):
            raise Unsupported("a force on a body without mass", "in MuJoCo it is joints of the body behind it")
        rows = self._indices.body[self._movable]
        self._d.xfrc_applied[rows, :3] = f_B_W[self._movable]
        self._d.xfrc_applied[rows, 3:] = tau_B_W[self._movable]

    def warnings(self) -> tuple[Notice, ...]:
        """The engine's counters and the effects that could not be left out."""
        return (*self._notices, *(Notice(f"mujoco: {counted}") for counted in self._counted()))

    def save(self) -> object:
        """Everything that `mj_step` reads, warm start included (mjSTATE_INTEGRATION)."""
        return self.integration()

    def restore(self, saved: object) -> None:
        """Back to a saved state; `contacts` are then those of that state."""
        if not isinstance(saved, np.ndarray):
            raise TypeError(f"restore: got {type(saved).__name__}, expected what save returned")
        self.continue_from(saved)
        self._numbers[:] = 0
        self._clean = self._numbers.tobytes()
        # Idempotent: the warm start stays as it was restored.
        self._mj.mj_forward(self._m, self._d)

    def integration(self, out: Floats | None = None) -> Floats:
        """The same, written into `out` where it is given."""
        row: Floats = np.empty(self._mj.mj_stateSize(self._m, self._kind)) if out is None else out
        self._mj.mj_getState(self._m, self._d, row, self._kind)
        return row

    def continue_from(self, row: Floats) -> None:
        """Step on from there; what follows from the coordinates is left as it was."""
        self._mj.mj_setState(self._m, self._d, row, self._kind)

    def close(self) -> None:
        """Free the window; the model is freed with the last reference to it."""
        self._renderer.close()
