"""Many worlds of one scene in one model of Newton, whose kernels step them all."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plumbline.adapters.newton.joints import Driven
from plumbline.adapters.newton.stepper import Stepper
from plumbline.harness.adapter import Notice, Settings
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import State


@dataclass(frozen=True, slots=True)
class Layout:
    """How worlds lie in a model, one after the other.

    Terms: links: Newton's numbers of the bodies of the first one, -1 of what stands still. driven: its drives.
    """

    count: int
    links: Mapping[str, int]
    driven: Mapping[str, Driven]


class NewtonWorlds:
    """Equal worlds, stepped together. Args: used: the resolved settings."""

    def __init__(self, scene: Scene, used: Settings, stepper: Stepper, layout: Layout, notices: tuple[Notice, ...]) -> None:
        self._scene, self._used, self._stepper, self._layout = scene, used, stepper, layout
        self._notices, self._begun, self._start = notices, False, State.initial(scene)
        self._places = [k for k, body in enumerate(scene.bodies) if body.motion != "static"]
        self._rows = np.array([layout.links[scene.bodies[k].name] for k in self._places])
        self._each = stepper.model.body_count // layout.count
        self._set_out()

    def _set_out(self) -> None:
        """Every world at the start of the scene, with what drives ask for."""
        stepper, model = self._stepper, self._stepper.model
        for world in range(self._layout.count):
            stepper.put(self._rows + world * self._each, self._start, self._places)
        joints = model.joint_count // self._layout.count
        for driven in self._layout.driven.values():
            aim = driven.aim(driven.drive.target)
            for world in range(self._layout.count):
                stepper.aim(driven.number + world * joints, aim.position, aim.rate, aim.push)

    @property
    def resolved(self) -> Settings:
        """What is used in every world."""
        return self._used

    @property
    def worlds(self) -> int:
        """How many there are."""
        return self._layout.count

    def step(self, count: int = 1) -> None:
        """Advance every world by count * dt. Raises: Diverged."""
        for _ in range(count * (self._used.substeps or 1)):
            self._stepper.step()
        self._begun = self._begun or count > 0
        self._stepper.check()

    def state(self, world: int, out: State) -> None:
        """Write the present state of a world into `out`. Raises: Diverged."""
        start = self._start
        out.p_WB[:], out.q_WB[:], out.v_WB[:], out.w_WB[:] = start.p_WB, start.q_WB, start.v_WB, start.w_WB
        if self._begun:
            self._stepper.get(self._rows + world * self._each, out, self._places)

    def warnings(self) -> tuple[Notice, ...]:
        """What is computed beside the scene, and what there was no room for."""
        return (*self._notices, *self._stepper.notices())

    def close(self) -> None:
        """Let go of the worlds; may be called twice."""
        self._stepper.close()
