"""Engine options: what there is, within which bounds, what stands where the settings leave them open."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

from plumbline.harness.adapter import Settings, SettingsError

INTEGRATORS = ("discrete", "euler", "rk4", "implicitfast", "implicit")
"""A search that turns a knob to the next value meets the discrete one beside Euler, and RK4 where that is refused."""
SOLVERS = ("pgs", "cg", "newton")


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """`Settings.options`; None is the vendor's default.

    Terms:
        by_scene: choose integrator and Jacobian by the scene where the settings leave them open.
        cone: 'pyramidal' or 'elliptic'. impratio: friction over normal stiffness; rolling_impratio: the same, with the
            slip correction, where balls alone touch what holds them. jacobian: 'dense', 'sparse', 'auto'.
        noslip_iterations, ls_iterations: of the slip correction and the line search.
        contact_steps: time constant of contacts without restitution in steps. fast_steps: of those of them that would otherwise
        be pressed through; None: as of the others.
        contact_damping_ratio, contact_impedance: of the same; by scene, an impedance that is left open follows the loads.
        friction_steps: time constant of friction in steps, where it has rows of its own: on the elliptic cone, which friction
        with restitution always takes. None: as long as the impact with restitution, that of the contact without.
        limit_steps, limit_damping_ratio, limit_impedance: of the limits of joints and rods.
        loop_steps, loop_impedance: time constant in steps and impedance of loop joints, rods, couplings and the dry
        friction of joints.
        slowest: what no time constant told in steps exceeds [s], but for rebounds; `resolved` says those that are used.
        rebound_steps: duration of an elastic impact in steps.
        refsafe, multiccd, nativeccd, island, warmstart, diagexact: flags of the engine. speculative: None follows the scene.
    """

    by_scene: bool = False
    cone: str | None = None
    impratio: float | None = None
    rolling_impratio: float | None = None
    jacobian: str | None = None
    noslip_iterations: int | None = None
    ls_iterations: int | None = None
    contact_steps: float | None = None
    fast_steps: float | None = None
    contact_damping_ratio: float | None = None
    contact_impedance: float | None = None
    limit_steps: float | None = None
    limit_damping_ratio: float | None = None
    limit_impedance: float | None = None
    loop_steps: float | None = None
    loop_impedance: float | None = None
    slowest: float | None = None
    rebound_steps: int = 10
    friction_steps: float | None = None
    refsafe: bool | None = None
    multiccd: bool | None = None
    nativeccd: bool | None = None
    island: bool | None = None
    warmstart: bool | None = None
    diagexact: bool | None = None
    speculative: bool | None = None


def _number(low: float, high: float) -> tuple[Callable[[Any], bool], str]:
    return lambda v: isinstance(v, int | float) and not isinstance(v, bool) and low <= v <= high, f"a number {low:g}..{high:g}"


def _integer(low: int, high: int) -> tuple[Callable[[Any], bool], str]:
    return lambda v: isinstance(v, int) and not isinstance(v, bool) and low <= v <= high, f"an integer {low}..{high}"


def _one_of(*names: str) -> tuple[Callable[[Any], bool], str]:
    return lambda v: v in names, f"one of {', '.join(names)}"


_TRUE_OR_FALSE: tuple[Callable[[Any], bool], str] = (lambda v: isinstance(v, bool), "true or false")
BOUNDS: Mapping[str, tuple[Callable[[Any], bool], str]] = {
    "cone": _one_of("pyramidal", "elliptic"),
    "impratio": _number(1e-6, 1e6),
    "rolling_impratio": _number(1e-6, 1e6),
    "jacobian": _one_of("dense", "sparse", "auto"),
    "noslip_iterations": _integer(0, 10_000),
    "ls_iterations": _integer(1, 10_000),
    "contact_steps": _number(0.01, 1e6),
    "fast_steps": _number(0.01, 1e6),
    "contact_damping_ratio": _number(1e-3, 1e3),
    "contact_impedance": _number(0.001, 0.9999),
    "limit_steps": _number(2, 1e6),
    "limit_damping_ratio": _number(1e-3, 1e3),
    "limit_impedance": _number(0.001, 0.9999),
    "loop_steps": _number(2, 1e6),
    "loop_impedance": _number(0.001, 0.9999),
    "slowest": _number(1e-9, 1e6),
    "rebound_steps": _integer(4, 1000),
    "friction_steps": _number(0.01, 1e6),
}


def checked(settings: Settings) -> Options:
    """The options of some settings, each checked, with the names of integrator and solver. Raises: SettingsError."""
    known = {option.name for option in fields(Options)}
    for name, value in settings.options.items():
        if name not in known:
            raise SettingsError(f"settings: option '{name}' is unknown to MuJoCo, expected some of {', '.join(sorted(known))}")
        holds, expected = BOUNDS.get(name, _TRUE_OR_FALSE)
        if value is not None and not holds(value):
            raise SettingsError(f"settings: option '{name}' is {value!r}, expected {expected}")
    for field, names in (("integrator", INTEGRATORS), ("solver", SOLVERS)):
        asked = getattr(settings, field)
        if asked is not None and asked not in names:
            raise SettingsError(f"settings: {field} '{asked}' is unknown to MuJoCo, expected one of {', '.join(names)}")
    return Options(**{name: value for name, value in settings.options.items() if value is not None})
