"""Settings held against what an engine knows: options by their values or range, one integrator, the names of its solvers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from plumbline.harness.adapter.settings import Settings, SettingsError


@dataclass(frozen=True, slots=True)
class Between:
    """An option that is a number in a range."""

    least: float
    most: float

    def __contains__(self, value: object) -> bool:
        return isinstance(value, int | float) and not isinstance(value, bool) and self.least <= value <= self.most

    def __str__(self) -> str:
        return f"a number {self.least:g}..{self.most:g}"


def checked_options(
    engine: str, settings: Settings, choices: Mapping[str, Sequence[Any] | Between], integrator: str, solvers: Sequence[str]
) -> dict[str, Any]:
    """All options, None where the settings leave one to the vendor.

    Args: engine: its title. choices: by option, the values that it may have. integrator: the engine's only one.
    Raises: SettingsError.
    """
    for name, value in settings.options.items():
        if name not in choices:
            raise SettingsError(f"settings: option '{name}' is unknown to {engine}, expected some of {', '.join(choices)}")
        allowed = choices[name]
        # Of values in a row True is not 1.
        same_type = isinstance(allowed, Between) or any(type(value) is type(choice) for choice in allowed)
        if value is not None and not (same_type and value in allowed):
            expected = str(allowed) if isinstance(allowed, Between) else f"one of {', '.join(map(repr, allowed))}"
            raise SettingsError(f"settings: option '{name}' is {value!r}, expected {expected}")
    if settings.integrator not in (None, integrator):
        raise SettingsError(f"settings: integrator '{settings.integrator}', expected '{integrator}', {engine}'s only one")
    if settings.solver not in (None, *solvers):
        raise SettingsError(f"settings: solver '{settings.solver}', expected one of {', '.join(solvers)}")
    if settings.tolerance is not None:
        raise SettingsError(
            f"settings: tolerance {settings.tolerance}, expected none: {engine} iterates a fixed number of times"
        )
    return {name: settings.options.get(name) for name in choices}
