"""The command line: the one place that knows every part; the module of a command is imported when it is called."""

import ast
from importlib import import_module
from pathlib import Path

import click
from click.shell_completion import CompletionItem

from plumbline.harness.cli.guard import Guarded

_IN_MODULE = {
    "installed": ("cases", "engines"),
    "check_command": ("check",),
    "run_command": ("run",),
    "run_folder": ("report", "reproduce", "serve", "show", "verify", "view"),
    "diff_command": ("diff",),
    "cluster_commands": ("merge",),
    "select_command": ("select",),
    "figure_command": ("figure",),
    "findings_command": ("findings",),
    "nightly_command": ("nightly",),
    "history_group": ("history",),
    "scene_commands": ("scene",),
    "parity_command": ("parity",),
    "warm_command": ("warm",),
}
_MODULE_OF = {name: module for module, names in _IN_MODULE.items() for name in names}


def _listed() -> click.Group:
    """A group of commands that only say what they are for, by the docstrings in their sources: nothing is imported."""
    commands = []
    for module, names in _IN_MODULE.items():
        tree = ast.parse(Path(__file__).with_name(f"{module}.py").read_text(encoding="utf-8"))
        functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
        commands += [click.Command(name, help=ast.get_docstring(functions[name])) for name in names]
    return click.Group(commands=commands, add_help_option=False)


class _Lazy(Guarded):
    """A group whose commands are imported when they are called, and no sooner."""

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of that name; None where there is none."""
        if cmd_name in _MODULE_OF:
            self.commands[cmd_name] = getattr(import_module(f"plumbline.harness.cli.{_MODULE_OF[cmd_name]}"), cmd_name)
        return super().get_command(ctx, cmd_name)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List all of them in the help."""
        _listed().format_commands(ctx, formatter)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """What a shell completes a word to."""
        listed = _listed()
        return listed.shell_complete(click.Context(listed), incomplete) + click.Command.shell_complete(self, ctx, incomplete)


@click.group(
    cls=_Lazy,
    commands={name: click.Command(name) for name in _MODULE_OF},
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(package_name="plumbline")
def main() -> None:
    """Compare rigid-body physics engines: what accuracy costs in time, and where each engine breaks."""


if __name__ == "__main__":
    main()
