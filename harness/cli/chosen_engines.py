"""The engines of a run as the command line names them: installed ones, and versions in environments of their own."""

from typing import TYPE_CHECKING

import click

from plumbline.harness.cli.guard import say
from plumbline.harness.intake.safe_text import quoted

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plumbline.harness.adapter import Adapter


def _package(name: str) -> str:
    """The package of a wheel or distribution of this name, spelled as wheels do."""
    return name.partition("-")[0].lower() if name.endswith(".whl") else name.replace("-", "_").lower()


def _welcome(adapter: "Adapter", agreed: bool) -> None:
    """Have an engine installed, in an environment of its own, that plumbline does not bring along. Raises: UsageError."""
    from plumbline.harness.run.make_environment import ensure
    from plumbline.harness.study.engine_versions import EngineVersion
    from plumbline.harness.study.environments import home_of, inside, installed

    extra, name = adapter.extra, adapter.name
    if extra is None or inside() or installed(adapter.distribution):
        return
    if extra.hindrance:
        raise click.UsageError(f"engine '{name}' {extra.hindrance}")
    home = home_of(name)
    if not agreed and (home is None or not home.executable):
        raise click.UsageError(
            f"engine '{name}' is not installed: {adapter.distribution} would take {extra.price} in an environment of its own; "
            f"add --yes to install it there, or: pip install 'plumbline[{name}]'"
        )
    say(f"{name}: looking for its environment, which is made on first use ({extra.price})", err=True)
    environment = ensure(EngineVersion(name), adapter.distribution)
    say(f"{name}: {f'unavailable: {environment.reason}' if environment.reason else 'ready'}", err=True)


def chosen_engines(texts: "Sequence[str]", agreed: bool = False) -> "dict[str, Adapter]":
    """The adapters that these texts name; all that are installed beside plumbline for none.

    Environments of versions that are not there are made, and of engines that are not installed where that is agreed to.

    Raises: PluginError, VersionError; UsageError, where it is not; BadParameter, where the engine is no package of its own, or
    a wheel is another's.
    """
    from plumbline.harness.run.make_environment import ensure
    from plumbline.harness.study import plugins
    from plumbline.harness.study.engine_versions import version_wanted
    from plumbline.harness.study.environments import installed

    adapters: dict[str, Adapter] = {}
    for text in texts:
        version = version_wanted(text)
        if version is None:
            adapters[text] = plugins.adapter(text)
            _welcome(adapters[text], agreed)
            continue
        distribution = plugins.adapter(version.engine).distribution
        if distribution in ("", "plumbline"):
            raise click.BadParameter(f"{quoted(text)}: {version.engine} has no versions of its own", param_hint="--engine")
        if version.wheel is not None and _package(version.wheel.name) != _package(distribution):
            raise click.BadParameter(f"{quoted(text)}: another package's, expected {distribution}'s", param_hint="--engine")
        say(f"{version.name}: looking for its environment, which is made on first use", err=True)
        environment = ensure(version, distribution)
        say(f"{version.name}: {f'unavailable: {environment.reason}' if environment.reason else 'ready'}", err=True)
        adapters[version.name] = plugins.adapter(version.name)
    return adapters or {
        name: adapter
        for name, adapter in plugins.adapters().items()
        if adapter.extra is None or installed(adapter.distribution)
    }
