"""A world of Bullet as it runs: stepping, state, contacts, and what acts on it from outside."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from plumbline.adapters.bullet.bodies_made import Assembly
from plumbline.adapters.bullet.drives import Actuation
from plumbline.adapters.bullet.native_steps import advance
from plumbline.adapters.bullet.options import substep
from plumbline.adapters.bullet.reactions import ReactionReader
from plumbline.adapters.bullet.sensing import Twin
from plumbline.adapters.bullet.vendor import CONTACT_BREAKING, LIFTED, break_contacts_at, breaks
from plumbline.harness.adapter import Diverged, Notice, Settings, Unsupported
from plumbline.harness.adapter.rotations import IDENTITY, products
from plumbline.harness.adapter.rotors import Blows
from plumbline.harness.adapter.what_goes_in import check_rays, check_state, check_targets, check_velocities, check_wrench
from plumbline.harness.scene import Camera, Scene, Vector3
from plumbline.harness.trajectory import Contacts, Floats, Hits, Image, State
from plumbline.harness.trajectory.joint_states import JointStates

Pushes = tuple[tuple[int, int, Any, Any], ...]
"""(number, link, force in W [N], torque in W [N m]) of bodies."""


class BulletSimulation:
    """A private world of Bullet in the binding's direct mode."""

    def __init__(self, scene: Scene, settings: Settings, made: Assembly) -> None:
        self._port, self._scene, self._made = made.port, scene, made
        self._substeps = settings.substeps or 1
        self._resolved = settings
        self._notices = tuple(made.notices)
        self._breaks: float = settings.options["contact_breaking"]
        self._start = State.initial(scene)
        moving = [place for place, _ in made.bases] + [place for links in made.linked.values() for place in links]
        self._moving = np.array(moving, dtype=np.int64)
        self._still = np.setdiff1d(np.arange(len(scene.bodies)), self._moving)
        turns = made.q_IB[self._moving]
        self._turned = np.flatnonzero((turns != np.array(IDENTITY)).any(axis=1))
        self._turns = turns[self._turned]
        self._drives = {
            a.joint: a for group in made.actuators.values() for a in (*group.actuators, *group.motors) if a.drive is not None
        }
        self._pushed: Pushes = ()
        self._reactions = ReactionReader(scene, made, settings.dt / self._substeps)
        self._h = substep(settings)
        self._twin: Twin | None = None
        self._open = True
        self._watched = False
        self._touched: list[list[Any]] = []

    @property
    def resolved(self) -> Settings:
        """What is used, defaults filled in."""
        return self._resolved

    @property
    def force_lead(self) -> float:
        """Semi-implicit Euler goes x + v dt + (1 + 1/k)/2 f dt^2 in k sub-steps."""
        return 0.5 * (1.0 - 1.0 / self._substeps)

    def step(self, count: int = 1) -> None:
        """Advance by count * dt. Raises: Diverged."""
        p, client, made, steps = self._port.bullet, self._port.client, self._made, count * self._substeps
        acts = bool(made.actuators or made.prescribed or made.springs or self._pushed)
        if breaks["at"] != self._breaks:
            break_contacts_at(self._port, self._breaks)
        self._touched = []
        self._reactions.stepped(count)
        if acts or made.blows is not None or (self._watched and self._substeps > 1):
            for left in range(steps, 0, -1):
                if acts:
                    self._act()
                p.stepSimulation(physicsClientId=client)
                if made.blows is not None:
                    self._look_for_blows(made.blows)
                if self._watched and 1 < left <= self._substeps:
                    self._touched.append(self._points())
        else:
            advance(self._port, steps, self._h)
        self._check()

    def _look_for_blows(self, blows: Blows) -> None:
        """Has nothing struck a tree with rotors in the last sub-step? Raises: Unsupported."""
        coordinates, address = self._made.coordinates, self._made.address

        def coordinate(name: str) -> float:
            number, link, position = coordinates[name]
            return position + float(self._port.call("getJointState", number, link)[0])

        points = [c for c in self._points() if c[8] <= 0 or c[9] > 0]
        blows.check(coordinate, {address[end] for c in points for end in ((c[1], c[3]), (c[2], c[4]))})

    def retime(self, dt: float) -> None:
        """The length [s] of each step from the next one on. Raises: Unsupported."""
        made, h = self._made, dt / self._substeps
        if any(group.skeleton is not None for group in made.actuators.values()) or getattr(made.springs, "implicit", False):
            raise Unsupported(
                "steps of uneven lengths beside springs or drives that are taken implicitly",
                "the rates that they lead to are foreseen from the step before, which has to be as long",
            )
        self._port.call("setTimeStep", h)
        self._h = h
        for group in made.actuators.values():
            group.h = h
        for belt in made.prescribed:
            belt.h = h
        self._reactions.retime(h)

    def _act(self) -> None:
        """Prescribe velocities, apply springs, drives and wrenches for the coming (sub)step."""
        p, client = self._port.bullet, self._port.client
        for belt in self._made.prescribed:
            belt.push(self._port)
        for number, actuation in self._made.actuators.items():
            links = [a.link for a in actuation.actuators]
            try:
                efforts = actuation.efforts(self._port, number)
            except np.linalg.LinAlgError as error:
                raise Diverged(
                    f"the linear system of the drives has no solution ({error}): the machine has flown apart"
                ) from error
            if links:
                p.setJointMotorControlArray(number, links, p.TORQUE_CONTROL, forces=efforts, physicsClientId=client)
            if actuation.motors:
                self._drive(number, actuation)
        for number, link, force, torque in (*self._pushed, *self._sprung()):
            if link < 0:
                position = p.getBasePositionAndOrientation(number, physicsClientId=client)[0]
            else:
                position = p.getLinkState(number, link, computeForwardKinematics=1, physicsClientId=client)[0]
            p.applyExternalForce(number, link, force, position, p.WORLD_FRAME, physicsClientId=client)
            p.applyExternalTorque(number, link, torque, p.WORLD_FRAME, physicsClientId=client)

    def _sprung(self) -> Pushes:
        """What the springs between points of two bodies push in the coming (sub)step."""
        if self._made.springs is None:
            return ()
        present = State.empty(len(self._scene.bodies))
        self.state(present)
        return self._pushes(*self._made.springs.forces(present))

    def _pushes(self, f_B_W: Floats, tau_B_W: Floats) -> Pushes:
        """Forces [N] and torques [N m], each (n, 3), by Bullet's numbers; bodies that nothing pushes are left out."""
        return tuple(
            (number, link, f_B_W[place].tolist(), tau_B_W[place].tolist())
            for (number, link), place in self._made.address.items()
            if self._scene.bodies[place].movable and (f_B_W[place].any() or tau_B_W[place].any())
        )

    def _drive(self, number: int, actuation: Actuation) -> None:
        """Tell Bullet's own motors where to: v' = gain (target - q)/h + rate, with all the force that takes, to the limit."""
        links, targets, gains, rates, limits = [], [], [], [], []
        for motor in actuation.motors:
            assert motor.drive is not None
            k, d = motor.drive.stiffness, motor.drive.damping
            rigid = d + actuation.h * k
            links.append(motor.link)
            targets.append(motor.target - motor.position)
            # The velocity at which the drive's own law would have no torque left at the end of the step.
            gains.append(actuation.h * k / rigid)
            rates.append(d * motor.drive.target_velocity / rigid)
            limits.append(LIFTED if motor.drive.limit is None else motor.drive.limit)
        p = self._port.bullet
        p.setJointMotorControlArray(
            number,
            links,
            p.POSITION_CONTROL,
            targetPositions=targets,
            targetVelocities=rates,
            forces=limits,
            positionGains=gains,
            velocityGains=[1.0] * len(links),
            physicsClientId=self._port.client,
        )

    def _check(self) -> None:
        """Are all velocities finite? Bullet never says so itself."""
        p, client, total = self._port.bullet, self._port.client, 0.0
        for _, number in self._made.bases:
            v, w = p.getBaseVelocity(number, physicsClientId=client)
            total += v[0] + v[1] + v[2] + w[0] + w[1] + w[2]
        for number, places in self._made.linked.items():
            for joint in p.getJointStatesMultiDof(number, range(len(places)), physicsClientId=client):
                total += sum(joint[0]) + sum(joint[1])
        if not math.isfinite(total):
            raise Diverged("Bullet: a velocity stopped being finite")

    def state(self, out: State) -> None:
        """Write the present state into `out`. Raises: Diverged."""
        check_state(len(self._scene.bodies), out)
        p, client = self._port.bullet, self._port.client
        pose, twist = p.getBasePositionAndOrientation, p.getBaseVelocity
        rows: list[tuple[float, ...]] = []
        for _, number in self._made.bases:
            position, turn = pose(number, physicsClientId=client)
            v, w = twist(number, physicsClientId=client)
            rows.append(position + turn + v + w)
        for number, places in self._made.linked.items():
            links = range(len(places))
            for link in p.getLinkStates(
                number, links, computeLinkVelocity=1, computeForwardKinematics=1, physicsClientId=client
            ):
                rows.append(link[0] + link[1] + link[6] + link[7])
        still, moving = self._still, self._moving
        if len(still):
            for target, source in zip(_channels(out), _channels(self._start), strict=True):
                target[still] = source[still]
        if not rows:
            return
        table = np.array(rows)
        if not math.isfinite(table.sum()):
            raise Diverged("Bullet: a pose or velocity stopped being finite")
        q = table[:, [6, 3, 4, 5]]
        if len(self._turned):
            q[self._turned] = products(q[self._turned], self._turns)
        out.p_WB[moving], out.q_WB[moving] = table[:, :3], q
        out.v_WB[moving], out.w_WB[moving] = table[:, 7:10], table[:, 10:]

    def joint_states(self) -> JointStates:
        """Coordinates, rates and reactions of the joints of multibodies; of what closes a loop pybullet tells nothing."""
        states = JointStates.unknown(self._scene)
        for k, joint in enumerate(self._scene.joints):
            if joint.name in self._made.coordinates:
                number, link, position = self._made.coordinates[joint.name]
                q, rate = self._port.call("getJointState", number, link)[:2]
                states.coordinate[k], states.rate[k] = position + q, rate
        present = State.empty(len(self._scene.bodies))
        self.state(present)
        states.reaction[:] = self._reactions.read(present)
        return states

    def _points(self) -> list[Any]:
        """The binding's tuples of the points that touched or bore a force in the last sub-step.

        A point that the solver left alone keeps the impulse of the step that last solved it: so does each with a gap where a
        body waits until it touches. All others are solved, and a force across a gap is one of this step: friction too, which
        the solver may leave behind on a point whose normal force it has taken back.
        """
        waiting = self._made.waiting
        return [
            c
            for c in self._port.call("getContactPoints")
            if c[8] <= 0 or ((c[9] or c[10] or c[12]) and (c[1], c[3]) not in waiting and (c[2], c[4]) not in waiting)
        ]

    def contacts(self) -> Contacts:
        """The points that touch or bear a force, see `Simulation.contacts`; forces are means over the sub-steps of a step."""
        # From the first question on every sub-step is listened to: the forces of a step are the mean over its sub-steps.
        self._watched = True
        address, earlier = self._made.address, self._touched
        points = self._points()
        share = 1.0 / (1 + len(earlier))
        points += [c for some in earlier for c in some if c[9] or c[10] or c[12]]
        if not points:
            return Contacts.none()
        normal = -np.array([c[7] for c in points])
        along, across = np.array([c[11] for c in points]), np.array([c[13] for c in points])
        sizes = np.array([(c[9], c[10], c[12]) for c in points])
        force = share * (sizes[:, :1] * normal - sizes[:, 1:2] * along - sizes[:, 2:] * across)
        return Contacts.of(
            [address[c[1], c[3]] for c in points],
            [address[c[2], c[4]] for c in points],
            (np.array([c[5] for c in points]) + np.array([c[6] for c in points])) / 2,
            normal,
            [c[8] for c in points],
            force,
        )

    def _sensed(self) -> Twin:
        if self._twin is None:
            self._twin = Twin.of(self._port.bullet, self._scene, self._resolved.options["margin"])
        present = State.empty(len(self._scene.bodies))
        self.state(present)
        self._twin.place(present, self._moving)
        return self._twin

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hits, see `Simulation.cast`."""
        check_rays(origins, directions, max_range)
        return self._sensed().cast(origins, directions, max_range)

    def caster(self, origins: Floats, directions: Floats, max_range: float) -> Callable[[], object]:
        """A function that casts these rays again into the shapes as they lie now."""
        check_rays(origins, directions, max_range)
        return self._sensed().caster(origins, directions, max_range)

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """The picture of TinyRenderer, see `Simulation.render`. Raises: Unsupported."""
        if camera.renderer != "rasterised":
            raise Unsupported(f"ray-traced image of camera '{camera.name}'", "TinyRenderer draws by a z-buffer alone")
        return self._sensed().render(camera, self._scene, colour)

    def command(self, targets: Mapping[str, float]) -> None:
        """Targets of drives by joint, see `Simulation.command`."""
        check_targets(self._scene, targets)
        for name, target in targets.items():
            if name in self._drives:
                self._drives[name].target = float(target)

    def prescribe(self, velocities: Mapping[str, tuple[Vector3, Vector3]]) -> None:
        """Set v_WB and w_WB of kinematic bodies."""
        check_velocities(self._scene, velocities)
        for belt in self._made.prescribed:
            if belt.body in velocities:
                belt.aim = velocities[belt.body]

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Forces [N] and torques [N m] in W on each body, shapes (n, 3), that act from now on."""
        check_wrench(len(self._scene.bodies), f_B_W, tau_B_W)
        self._pushed = self._pushes(f_B_W, tau_B_W)

    def warnings(self) -> tuple[Notice, ...]:
        """What the engine computes beside the scene."""
        return self._notices

    def save(self) -> object:
        """Raises: Unsupported."""
        raise Unsupported("save", "Bullet's restoreState goes on otherwise in maximal coordinates")

    def restore(self, saved: object) -> None:  # noqa: ARG002 -- the protocol's name
        """Raises: Unsupported."""
        raise Unsupported("restore", "Bullet's restoreState goes on otherwise in maximal coordinates")

    def close(self) -> None:
        """Free the world and its twin; a second time does nothing."""
        if self._twin is not None:
            self._twin.close()
            self._twin = None
        if self._open:
            self._open = False
            break_contacts_at(self._port, CONTACT_BREAKING)
            self._port.call("disconnect")


def _channels(state: State) -> tuple[Floats, ...]:
    return state.p_WB, state.q_WB, state.v_WB, state.w_WB
