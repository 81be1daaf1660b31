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


def chosen_engines(texts: "Sequence[str]") -> "dict[str, Adapter]":
    """The adapters that these texts name; all that there are for none. Environments that are not there are made.

    Raises: PluginError, VersionError; BadParameter, where the engine is no package of its own, or a wheel is another's.
    """
    from plumbline.harness.run.make_environment import ensure
    from plumbline.harness.study import plugins
    from plumbline.harness.study.engine_versions import version_wanted

    adapters: dict[str, Adapter] = {}
    for text in texts:
        version = version_wanted(text)
        if version is None:
            adapters[text] = plugins.adapter(text)
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
    return adapters or plugins.adapters()
