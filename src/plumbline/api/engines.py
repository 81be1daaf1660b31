"""The engines of a run by name: installed ones, and versions in environments of their own."""

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from plumbline.harness.intake.safe_text import one_line, quoted

if TYPE_CHECKING:
    from plumbline.harness.adapter import Adapter


def _package(name: str) -> str:
    """The package of a wheel or distribution of this name, spelled as wheels do."""
    return name.partition("-")[0].lower() if name.endswith(".whl") else name.replace("-", "_").lower()


def tell(sentence: str) -> None:
    """A line on standard error, of text that may come from elsewhere."""
    print(one_line(sentence), file=sys.stderr)


def chosen_engines(texts: Sequence[str]) -> "dict[str, Adapter]":
    """The adapters that these texts name, `mujoco`, `mujoco==3.3.0` or `mujoco=my.whl`; all that there are for none.

    Environments that are not there are made, which is said on standard error.

    Raises: PluginError; VersionError, where the engine is no package of its own, or a wheel is another's.
    """
    from plumbline.harness.run.make_environment import ensure
    from plumbline.harness.study import plugins
    from plumbline.harness.study.engine_versions import VersionError, version_wanted
    from plumbline.harness.study.roll_call import twice

    if double := twice(texts):
        raise VersionError(f"engine {quoted(double)} is given twice, expected once")
    adapters: dict[str, Adapter] = {}
    for text in texts:
        version = version_wanted(text)
        if version is None:
            adapters[text] = plugins.adapter(text)
            continue
        distribution = plugins.adapter(version.engine).distribution
        if distribution in ("", "plumbline"):
            raise VersionError(f"engine {quoted(text)}: {version.engine} has no versions of its own")
        if version.wheel is not None and _package(version.wheel.name) != _package(distribution):
            raise VersionError(f"engine {quoted(text)}: another package's, expected {distribution}'s")
        tell(f"{version.name}: looking for its environment, which is made on first use")
        environment = ensure(version, distribution)
        tell(f"{version.name}: {f'unavailable: {environment.reason}' if environment.reason else 'ready'}")
        adapters[version.name] = plugins.adapter(version.name)
    return adapters or plugins.adapters()
