"""A template is compiled by the first report of a machine; what is kept of it is run only where it belongs to the text."""

from collections.abc import Callable
from pathlib import Path

import pytest
from jinja2 import DictLoader, Environment

from plumbline.reports.html import template
from plumbline.reports.html.template import CompiledTemplates

TEXT = "{{ greeting }}, {{ 'world'|loud }}"


def loud(text: str) -> str:
    return f"{text}!"


@pytest.fixture
def rendered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[str, int]]:
    """What comes of a text in a new environment, and how often it was compiled for that."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    compiled: list[str] = []
    compile_it = Environment.compile

    def counted(self: Environment, source: str, *more: object, **named: object) -> object:
        compiled.append(source)
        return compile_it(self, source, *more, **named)  # type: ignore[call-overload]

    monkeypatch.setattr(Environment, "compile", counted)

    def render(text: str = TEXT) -> tuple[str, int]:
        before = len(compiled)
        environment = Environment(loader=DictLoader({"page": text}), bytecode_cache=CompiledTemplates([loud]))
        environment.filters["loud"] = loud
        said = environment.get_template("page").render(greeting="Hello")
        return said, len(compiled) - before

    return render


def kept(folder: Path) -> list[Path]:
    return sorted((folder / "plumbline" / "templates").iterdir())


def test_a_text_is_compiled_once_and_another_one_anew(rendered: Callable[..., tuple[str, int]], tmp_path: Path) -> None:
    assert [rendered(), rendered()] == [("Hello, world!", 1), ("Hello, world!", 0)]
    assert [rendered(f"{TEXT}?"), rendered(), rendered(f"{TEXT}?")] == [
        ("Hello, world!?", 1),
        ("Hello, world!", 0),
        ("Hello, world!?", 0),
    ]
    assert len(kept(tmp_path)) == 2


@pytest.mark.parametrize("damage", ["flipped", "cut", "emptied", "exchanged"])
def test_what_is_damaged_is_compiled_anew_and_mended(
    damage: str, rendered: Callable[..., tuple[str, int]], tmp_path: Path
) -> None:
    rendered("{{ greeting }}")
    (other,) = kept(tmp_path)
    rendered()
    (path,) = {*kept(tmp_path)} - {other}
    whole = path.read_bytes()
    path.write_bytes(
        {
            "flipped": whole[:-9] + bytes([whole[-9] ^ 1]) + whole[-8:],
            "cut": whole[:-9],
            "emptied": b"",
            "exchanged": other.read_bytes(),
        }[damage]
    )
    assert [rendered(), rendered()] == [("Hello, world!", 1), ("Hello, world!", 0)]
    assert path.read_bytes() == whole


def test_a_filter_that_changes_is_felt(
    rendered: Callable[..., tuple[str, int]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What it makes of a constant stands in the compiled text."""
    rendered()
    (tmp_path / "changed.py").write_text("def loud(text):\n    return f'{text}!!'\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    from changed import loud as louder  # type: ignore[import-not-found]

    monkeypatch.setitem(globals(), "loud", louder)
    assert rendered() == ("Hello, world!!", 1)


def test_a_cache_that_can_be_none_costs_the_time_alone(
    rendered: Callable[..., tuple[str, int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    assert [rendered(), rendered()] == [("Hello, world!", 1), ("Hello, world!", 1)]


def test_the_templates_of_a_report_are_kept() -> None:
    assert isinstance(template.environment().bytecode_cache, CompiledTemplates)
