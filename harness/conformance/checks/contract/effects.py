"""Checks that an effect which a scene leaves out is not simulated, or is declared as surplus."""

from collections.abc import Callable

from plumbline.harness.adapter import Adapter, Feature, Notice, Settings
from plumbline.harness.adapter.notice import as_notices
from plumbline.harness.conformance.check import CheckResult, Compared, Run, check, judge, near
from plumbline.harness.conformance.checks.contact.contacts import SOFT_REBOUND
from plumbline.harness.conformance.room import COARSE, FINE, built, state_of
from plumbline.harness.conformance.scenes import TURNED, G, ball, block, damped, floor, free, ground
from plumbline.harness.scene import WORLD, Drive, Effect, Prismatic, Scene
from plumbline.harness.trajectory import State


def _left_out(effect: str, needs: Feature = Feature.NONE) -> Callable[[Run], Run]:
    """The check of a scene that leaves out an effect."""
    return check(f"Where a scene leaves out {effect}, is it absent, or declared as surplus?", needs)


def _run(adapter: Adapter, scene: Scene, settings: Settings, duration: float) -> tuple[State, tuple[Notice, ...]]:
    with built(adapter, scene, settings) as simulation:
        simulation.step(round(duration / settings.dt))
        return state_of(simulation, scene), as_notices(simulation.warnings())


def _or_surplus(comparison: Compared, effect: Effect, notices: tuple[Notice, ...]) -> CheckResult:
    """The effect is absent, or a notice names it as surplus."""
    if not comparison.holds:
        for notice in notices:
            if notice.kind == "surplus" and notice.effect is effect:
                return CheckResult("passed", f"declared: {notice}")
        got = list(map(str, notices))
        return CheckResult(
            "failed", f"{comparison.text}; got warnings {got}, expected none of the effect or 'surplus: {effect.names[0]}'"
        )
    return judge(comparison)


@_left_out("gravity")
def narrowed_gravity_is_left_out(adapter: Adapter, settings: Settings) -> CheckResult:
    end, warnings = _run(adapter, Scene(bodies=(free(),), narrow=Effect.GRAVITY), settings.with_dt(COARSE), 0.1)
    return _or_surplus(near("v_WB without gravity [m/s]", end.v_WB[0], (0, 0, 0), 1e-6), Effect.GRAVITY, warnings)


@_left_out("contact", Feature.SPHERE)
def narrowed_contact_is_left_out(adapter: Adapter, settings: Settings) -> CheckResult:
    scene = Scene(bodies=(floor(adapter), ball()), surfaces=(ground(0.5),), narrow=Effect.CONTACT)
    end, warnings = _run(adapter, scene, settings.with_dt(FINE), 0.1)
    return _or_surplus(near("v_z of a ball that meets nothing [m/s]", end.v_WB[1, 2], -G * 0.1, 0.02), Effect.CONTACT, warnings)


@_left_out("friction", Feature.BOX)
def narrowed_friction_is_left_out(adapter: Adapter, settings: Settings) -> CheckResult:
    scene = Scene(bodies=(floor(adapter), block(v=(2.0, 0.0, 0.0))), surfaces=(ground(0.5),), narrow=Effect.FRICTION)
    end, warnings = _run(adapter, scene, settings.with_dt(FINE), 0.2)
    return _or_surplus(near("v_x of a box without friction [m/s]", end.v_WB[1, 0], 2.0, 0.15), Effect.FRICTION, warnings)


@_left_out("restitution", Feature.SPHERE | Feature.RESTITUTION)
def narrowed_restitution_is_left_out(adapter: Adapter, settings: Settings) -> CheckResult:
    dropped = ball(p=(0.0, 0.0, 0.11), v=(0.0, 0.0, -2.0))
    scene = Scene(bodies=(floor(adapter), dropped), surfaces=(ground(restitution=0.8),), narrow=Effect.RESTITUTION)
    end, warnings = _run(adapter, scene, settings.with_dt(FINE), 0.08)
    rebound = max(0.0, float(end.v_WB[1, 2])) / 2.0
    return _or_surplus(near("rebound without restitution", rebound, 0.0, SOFT_REBOUND), Effect.RESTITUTION, warnings)


@_left_out("gyroscopic")
def narrowed_gyroscopic_is_left_out(adapter: Adapter, settings: Settings) -> CheckResult:
    body = free(moments=(0.1, 0.2, 0.25), q=TURNED, w=(3.0, 1.0, -2.0))
    scene = Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0), narrow=Effect.GYROSCOPIC)
    end, warnings = _run(adapter, scene, settings.with_dt(FINE), 0.1)
    return _or_surplus(
        near("w_WB without gyroscopic torque [rad/s]", end.w_WB[0], body.w_WB, 0.02), Effect.GYROSCOPIC, warnings
    )


@_left_out("joints", Feature.PRISMATIC)
def narrowed_joints_is_left_out(adapter: Adapter, settings: Settings) -> CheckResult:
    joint = Prismatic(name="slide", parent=WORLD, child="body", anchor_W=(0.0, 0.0, 0.0), axis_W=(1.0, 0.0, 0.0))
    end, warnings = _run(adapter, Scene(bodies=(free(),), joints=(joint,), narrow=Effect.JOINTS), settings.with_dt(COARSE), 0.1)
    return _or_surplus(near("v_z of a body that nothing holds [m/s]", end.v_WB[0, 2], -G * 0.1, 0.02), Effect.JOINTS, warnings)


@_left_out("drives", Feature.PRISMATIC | Feature.DRIVES)
def narrowed_drives_is_left_out(adapter: Adapter, settings: Settings) -> CheckResult:
    joint = Prismatic(
        name="slide",
        parent=WORLD,
        child="body",
        anchor_W=(0.0, 0.0, 0.0),
        axis_W=(1.0, 0.0, 0.0),
        drive=Drive(stiffness=100.0, damping=1.0, target=1.0),
    )
    end, warnings = _run(adapter, Scene(bodies=(free(),), joints=(joint,), narrow=Effect.DRIVES), settings.with_dt(COARSE), 0.1)
    return _or_surplus(near("v_x of a body that nothing drives [m/s]", end.v_WB[0, 0], 0.0, 1e-4), Effect.DRIVES, warnings)


@_left_out("linear damping", Feature.LINEAR_DAMPING)
def narrowed_linear_damping_is_left_out(adapter: Adapter, settings: Settings) -> CheckResult:
    body = damped(free(v=(1.0, 0.0, 0.0)), linear=3.0)
    scene = Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0), narrow=Effect.LINEAR_DAMPING)
    end, warnings = _run(adapter, scene, settings.with_dt(COARSE), 0.1)
    return _or_surplus(near("v_x without damping [m/s]", end.v_WB[0, 0], 1.0, 0.05), Effect.LINEAR_DAMPING, warnings)


@_left_out("angular damping", Feature.ANGULAR_DAMPING)
def narrowed_angular_damping_is_left_out(adapter: Adapter, settings: Settings) -> CheckResult:
    body = damped(free(w=(0.0, 1.0, 0.0)), angular=3.0)
    scene = Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0), narrow=Effect.ANGULAR_DAMPING)
    end, warnings = _run(adapter, scene, settings.with_dt(COARSE), 0.1)
    return _or_surplus(near("w_y without damping [rad/s]", end.w_WB[0, 1], 1.0, 0.05), Effect.ANGULAR_DAMPING, warnings)


@check("Does every notice of a surplus or missing effect name one effect?", firm=True)
def surplus_names_effects(adapter: Adapter, settings: Settings) -> CheckResult:
    """A scene that asks for gravity alone, of a body with unequal moments at rest: the notices name what else is computed."""
    with built(adapter, Scene(bodies=(free(moments=(0.1, 0.2, 0.25)),)), settings) as simulation:
        simulation.step(5)
        got = [notice for notice in as_notices(simulation.warnings()) if notice.kind != "note"]
    nameless = [str(notice) for notice in got if notice.effect is None or len(notice.effect.names) != 1]
    if nameless:
        return CheckResult("failed", f"notices of surplus or missing effects without the one they are about: {nameless}")
    surplus = [str(notice) for notice in got if notice.kind == "surplus"]
    return CheckResult("passed", f"surplus effects declared: {surplus or 'none'}")
