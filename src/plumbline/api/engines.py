"""The engines of a run by name: installed ones, versions of them, and engines that Plumbline does not bring along."""

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from plumbline.harness.intake.safe_text import one_line, quoted

if TYPE_CHECKING:
    from plumbline.harness.adapter import Adapter
    from plumbline.harness.study.engine_versions import EngineVersion


def tell(sentence: str) -> None:
    """A line on standard error, of text that may come from elsewhere."""
    print(one_line(sentence), file=sys.stderr)


def _package(name: str) -> str:
    """The package of a wheel or distribution of this name, spelled as wheels do."""
    return name.partition("-")[0].lower() if name.endswith(".whl") else name.replace("-", "_").lower()


def _ensure(version: "EngineVersion", distribution: str, price: str = "") -> None:
    """Make the environment of an engine unless it is there, and say what came of it."""
    from plumbline.harness.run.make_environment import ensure

    tell(f"{version.name}: looking for its environment, which is made on first use{f' ({price})' if price else ''}")
    environment = ensure(version, distribution)
    tell(f"{version.name}: {f'unavailable: {environment.reason}' if environment.reason else 'ready'}")


def _welcome(adapter: "Adapter", agreed: bool) -> None:
    """Have an engine that plumbline does not bring along installed in an environment of its own.

    Raises: VersionError, where that is not agreed to.
    """
    from plumbline.harness.study.engine_versions import EngineVersion, VersionError
    from plumbline.harness.study.environments import home_of, inside, installed

    extra, name = adapter.extra, adapter.name
    if extra is None or inside() or installed(adapter.distribution):
        return
    if extra.hindrance:
        raise VersionError(f"engine '{name}' {extra.hindrance}")
    home = home_of(name)
    if not agreed and (home is None or not home.executable):
        raise VersionError(
            f"engine '{name}' is not installed: {adapter.distribution} would take {extra.price} in an environment of its own; "
            f"add --yes to install it there (in Python install=True), or: pip install 'plumbline[{name}]'"
        )
    _ensure(EngineVersion(name), adapter.distribution, extra.price)


def chosen_engines(texts: Sequence[str], agreed: bool = False) -> "dict[str, Adapter]":
    """The adapters that these texts name, `mujoco`, `mujoco==3.3.0` or `mujoco=my.whl`; all that are installed for none.

    Environments of versions that are not there are made, and of engines that are not installed if that is agreed to.

    Raises: PluginError; VersionError, where it is not, where an engine is no package of its own, or a wheel is another's.
    """
    from plumbline.harness.study import plugins
    from plumbline.harness.study.engine_versions import VersionError, version_wanted
    from plumbline.harness.study.environments import installed
    from plumbline.harness.study.study import twice

    if double := twice(texts):
        raise VersionError(f"engine {quoted(double)} is given twice, expected once")
    adapters: dict[str, Adapter] = {}
    for text in texts:
        version = version_wanted(text)
        if version is None:
            adapters[text] = plugins.adapter(text)
            _welcome(adapters[text], agreed)
            continue
        distribution = plugins.adapter(version.engine).distribution
        if distribution in ("", "plumbline"):
            raise VersionError(f"engine {quoted(text)}: {version.engine} has no versions of its own")
        if version.wheel is not None and _package(version.wheel.name) != _package(distribution):
            raise VersionError(f"engine {quoted(text)}: another package's, expected {distribution}'s")
        _ensure(version, distribution)
        adapters[version.name] = plugins.adapter(version.name)
    return adapters or {
        name: adapter
        for name, adapter in plugins.adapters().items()
        if adapter.extra is None or installed(adapter.distribution)
    }
