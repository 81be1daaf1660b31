"""Checks that an effect which a scene leaves out is not simulated, or is declared as surplus."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from numpy.typing import ArrayLike

from plumbline.harness.adapter import Feature
from plumbline.harness.adapter.notice import as_notices
from plumbline.harness.conformance.check import Comparisons, check, firm, near, said, that
from plumbline.harness.conformance.checks.contact.contacts import SOFT_REBOUND
from plumbline.harness.conformance.engine import COARSE, FINE, Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN, TURNED, X, Y
from plumbline.harness.conformance.scenes import G, ball, block, damped, free, on_ground, prismatic, without_gravity
from plumbline.harness.scene import Drive, Effect, Scene
from plumbline.harness.trajectory import State

_SPIN = (3.0, 1.0, -2.0)
_DRIVE = Drive(stiffness=100.0, damping=1.0, target=1.0)


def _on_slide(drive: Drive | None = None) -> Scene:
    return Scene(bodies=(free(),), joints=(prismatic("slide", "body", ORIGIN, X, drive=drive),))


@dataclass(frozen=True, slots=True)
class _LeftOut:
    """A scene in which an effect would show, and what is read of the state after `duration` [s] without it."""

    effect: str
    needs: Feature
    scene: Callable[[Engine], Scene]
    duration: float
    dt: float
    what: str
    read: Callable[[State], ArrayLike]
    expected: ArrayLike
    within: float

    def __call__(self, engine: Engine) -> Comparisons:
        """The effect is absent, or a notice names it as surplus."""
        effect = Effect[self.effect.upper().replace(" ", "_")]
        scene = replace(self.scene(engine), narrow=effect)
        with engine.built(scene, self.dt) as simulation:
            simulation.step(round(self.duration / self.dt))
            end, notices = state_of(simulation, scene), as_notices(simulation.warnings())
        absent = near(self.what, self.read(end), self.expected, self.within)
        surplus = [notice for notice in notices if notice.kind == "surplus" and notice.effect is effect]
        if absent.holds:
            yield absent
        elif surplus:
            yield said(f"declared: {surplus[0]}")
        else:
            got = list(map(str, notices))
            yield that(False, f"{absent.text}; got warnings {got}, expected none of the effect or 'surplus: {effect.names[0]}'")


_ROWS = (
    _LeftOut(
        "gravity", Feature.NONE, lambda _: Scene(bodies=(free(),)), 0.1, COARSE,
        "v_WB without gravity [m/s]", lambda end: end.v_WB[0], ORIGIN, 1e-6,
    ),
    _LeftOut(
        "contact", Feature.SPHERE, lambda engine: on_ground(engine, ball()), 0.1, FINE,
        "v_z of a ball that meets nothing [m/s]", lambda end: end.v_WB[1, 2], -G * 0.1, 0.02,
    ),
    _LeftOut(
        "friction", Feature.BOX, lambda engine: on_ground(engine, block(v=(2.0, 0.0, 0.0))), 0.2, FINE,
        "v_x of a box without friction [m/s]", lambda end: end.v_WB[1, 0], 2.0, 0.15,
    ),
    _LeftOut(
        "restitution", Feature.SPHERE | Feature.RESTITUTION,
        lambda engine: on_ground(engine, ball(p=(0.0, 0.0, 0.11), v=(0.0, 0.0, -2.0)), friction=0.0, restitution=0.8),
        0.08, FINE, "rebound without restitution", lambda end: max(0.0, float(end.v_WB[1, 2])) / 2.0, 0.0, SOFT_REBOUND,
    ),
    _LeftOut(
        "gyroscopic", Feature.NONE, lambda _: without_gravity(free(moments=(0.1, 0.2, 0.25), q=TURNED, w=_SPIN)), 0.1, FINE,
        "w_WB without gyroscopic torque [rad/s]", lambda end: end.w_WB[0], _SPIN, 0.02,
    ),
    _LeftOut(
        "joints", Feature.PRISMATIC, lambda _: _on_slide(), 0.1, COARSE,
        "v_z of a body that nothing holds [m/s]", lambda end: end.v_WB[0, 2], -G * 0.1, 0.02,
    ),
    _LeftOut(
        "drives", Feature.PRISMATIC | Feature.DRIVES, lambda _: _on_slide(_DRIVE), 0.1, COARSE,
        "v_x of a body that nothing drives [m/s]", lambda end: end.v_WB[0, 0], 0.0, 1e-4,
    ),
    _LeftOut(
        "linear damping", Feature.LINEAR_DAMPING, lambda _: without_gravity(damped(free(v=X), linear=3.0)), 0.1, COARSE,
        "v_x without damping [m/s]", lambda end: end.v_WB[0, 0], 1.0, 0.05,
    ),
    _LeftOut(
        "angular damping", Feature.ANGULAR_DAMPING, lambda _: without_gravity(damped(free(w=Y), angular=3.0)), 0.1, COARSE,
        "w_y without damping [rad/s]", lambda end: end.w_WB[0, 1], 1.0, 0.05,
    ),
)  # fmt: skip

for _row in _ROWS:
    check(
        f"Where a scene leaves out {_row.effect}, is it absent, or declared as surplus?",
        _row.needs,
        name=f"narrowed_{_row.effect.replace(' ', '_')}_is_left_out",
    )(_row)


@firm("Does every notice of a surplus or missing effect name one effect?")
def surplus_names_effects(engine: Engine) -> Comparisons:
    """A scene that asks for gravity alone, of a body with unequal moments at rest: the notices name what else is computed."""
    with engine.built(Scene(bodies=(free(moments=(0.1, 0.2, 0.25)),)), None) as simulation:
        simulation.step(5)
        got = [notice for notice in as_notices(simulation.warnings()) if notice.kind != "note"]
    nameless = [str(notice) for notice in got if notice.effect is None or len(notice.effect.names) != 1]
    yield that(not nameless, f"notices of surplus or missing effects without the one they are about: {nameless}")
    surplus = [str(notice) for notice in got if notice.kind == "surplus"]
    yield said(f"surplus effects declared: {surplus or 'none'}")
