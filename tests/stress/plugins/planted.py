"""A third party's engine with one of many faults, chosen by the option `fault`, and the case that asks for all its channels."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from planted_deeds import MIDDLE, Fault
from planted_faults import BY_NAME

from plumbline.harness.adapter import Adapter, Feature, Settings
from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.metrics import errors
from plumbline.harness.scene import Body, Camera, Imu, Lidar, Scene
from plumbline.harness.trajectory import Contacts, Floats, Hits, Image, State, Trajectory

POSITION = errors.position_error_max


class Falling:
    """Semi-implicit Euler of bodies in free fall that touch, and see nothing; one answer is as the fault has it."""

    def __init__(self, scene: Scene, settings: Settings, fault: Fault | None) -> None:
        self._resolved, self._dt, self._gravity = settings, settings.dt, np.array(scene.gravity)
        self._state, self._fault, self._steps = State.initial(scene), fault, 0

    def _told(self, place: str, answer: Any, *more: Any) -> Any:
        return self._fault.change(answer, *more) if self._fault is not None and self._fault.place == place else answer

    @property
    def resolved(self) -> Any:
        return self._told("resolved", self._resolved)

    def step(self, count: int = 1) -> None:
        for _ in range(count):
            self._steps += 1
            if self._steps == MIDDLE:
                self._told("step", None)
            self._state.v_WB[:] += self._gravity * self._dt
            self._state.p_WB[:] += self._state.v_WB * self._dt

    def state(self, out: State) -> None:
        left = self._fault.change if self._fault is not None and self._fault.place == "unwritten" else ""
        for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
            if name != left:
                getattr(out, name)[:] = getattr(self._state, name)
        self._told("state", out, self._steps)

    def contacts(self) -> Any:
        return self._told("contacts", Contacts.of([0], [1], [[0, 0, 0]], [[0, 0, 1]], [0.0], [[0, 0, 0]]))

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Any:
        if self._fault is not None and self._fault.place == "cast_mutating":
            directions[0] = -directions[0]
        rays = len(directions)
        return self._told("cast", Hits(np.full(rays, np.inf), np.full(rays, -1), np.zeros((rays, 3))))

    def render(self, camera: Camera, colour: bool = True) -> Any:
        shape = camera.height, camera.width
        return self._told("render", Image(np.full(shape, np.inf), np.full(shape, -1), np.zeros((*shape, 3))))

    def inertial(self, name: str) -> Any:
        return self._told("inertial", (np.zeros(3), np.zeros(3)))

    def warnings(self) -> Any:
        return self._told("warnings", ())

    def close(self) -> None:
        self._told("close", None)


@dataclass(frozen=True, kw_only=True)
class Planted(Adapter):
    """The engine."""

    title: str = "falling bodies with a planted fault"
    distribution: str = "faulty"
    features: Feature = Feature.CONTACTS | Feature.CONTACT_FORCES | Feature.RAYS | Feature.RENDER
    tracks: dict[str, Settings] = field(default_factory=lambda: {"default": Settings(), "tuned": Settings()})

    def version(self) -> str:
        return "1.0"

    def build(self, scene: Scene, settings: Settings) -> Any:
        fault = BY_NAME[settings.options["fault"]] if settings.options else None
        if fault is not None and fault.place == "build":
            fault.change()
        return Falling(scene, settings, fault)


PLANTED = Planted(name="planted")


def _scene(_: Parameters) -> Scene:
    return Scene(
        bodies=(Body(name="ball", v_WB=(1.0, 0.0, 0.0)), Body(name="other", p_WB=(0.0, 5.0, 0.0))),
        sensors=(
            Imu(name="imu", body="ball", rate=10.0),
            Lidar(name="lidar", body="ball", rate=10.0, channels=1, columns=4, elevation_low=0.0, elevation_high=0.0),
            Camera(name="camera", body="ball", rate=10.0, width=4, height=3, centre_x=2.0, centre_y=1.5),
        ),
    )


def _truth(instants: Floats, _: Parameters) -> Trajectory:
    truth = Trajectory.of(instants, 2)
    truth.p_WB[:, 0, 0] = instants
    truth.p_WB[:, 1, 1] = 5.0
    truth.p_WB[:, :, 2] = -9.81 * instants[:, None] ** 2 / 2
    truth.v_WB[:, 0, 0] = 1.0
    truth.v_WB[:, :, 2] = -9.81 * instants[:, None]
    return truth


CASE = Case(
    name="stress_channels",
    title="Free fall with every channel asked for",
    question="Do two balls fall half g t squared while everything is read?",
    source="Galilei",
    truth="closed form",
    scene=_scene,
    expected=_truth,
    checks=(
        Check(
            metric=POSITION,
            at_most=lambda dt, _: 9.81 * dt * 0.5 / 2 * 1.001,
            because="semi-implicit Euler errs by g dt t/2 at t = 0.5 s; a thousandth on top for rounding",
        ),
    ),
    duration=0.5,
    dt=0.01,
    sample_interval=0.1,
    with_contacts=True,
    headline="position_error_max",
)
