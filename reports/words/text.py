"""Strings and numbers as people read them, safe in HTML and in file names."""

import json
import math
import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import PurePath
from typing import Any

from plumbline.harness.case.undropped import OWN
from plumbline.harness.findings.parameter_words import beside, whole_part
from plumbline.harness.intake import safe_text
from plumbline.harness.intake.safe_text import LONGEST
from plumbline.harness.store.record import digest

TIMES = "\N{MULTIPLICATION SIGN}"
NONE = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"
UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def visible(text: str) -> str:
    """The text with control and direction-changing characters spelled out, and its tail cut off."""
    if len(text) <= LONGEST and text.isprintable():
        return text  # nearly all, and a report asks it of a million
    tail = "" if len(text) <= LONGEST else f" … ({len(text) - LONGEST} characters more)"
    return safe_text.visible(text[:LONGEST]) + tail


def amount(value: Any, digits: int = 3) -> str:
    """A number with so many significant digits; powers of ten beyond 1e-3..1e5; a dash where there is none."""
    if value is None or not isinstance(value, (int, float)) or isinstance(value, bool):
        return NONE
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    if value == 0:
        return "0"
    if 1e-3 <= abs(value) < 1e5:
        if isinstance(value, int):
            return str(value)
        if abs(value) >= 10 ** (digits - 1):
            return f"{float(f'{value:.{digits - 1}e}'):.0f}"
        places = digits - 1 - math.floor(math.log10(abs(value)))
        text = f"{value:.{places}f}"
        return text.rstrip("0").rstrip(".") if "." in text else text
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    raised = f"10{str(int(exponent)).translate(SUPERSCRIPT)}"
    return {"1": raised, "-1": f"-{raised}"}.get(mantissa, f"{mantissa}{TIMES}{raised}")


def duration(seconds: float | None, digits: int = 3) -> str:
    """A time in the unit that leaves few digits: '12.3 µs', '4 ms', '2.5 s'; a dash where there is none."""
    if seconds is None or not math.isfinite(seconds) or seconds <= 0:
        return NONE
    size, name = next(((size, name) for size, name in UNITS if float(f"{seconds:.{digits - 1}e}") >= size), UNITS[-1])
    return f"{amount(seconds / size, digits)} {name}"


def power(exponent: int) -> str:
    """A power of ten: '10⁻³'; 1 and 10 are themselves."""
    return str(10**exponent) if exponent in (0, 1) else f"10{str(exponent).translate(SUPERSCRIPT)}"


POWER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([-+]?\d+)(?!\w|\.\w)")


POINT = re.compile(r"(?<![\w.)])\.(?=\d)")


SQUARED = re.compile(r"(?<![\w/])(kg m|m/s|rad/s|deg/s|kg/m)([23])(?!\w)")


def powers(text: str) -> str:
    """Prose with its numbers and units as the tables write them: 10⁻⁴ for 1e-4, 0.3 for .3, kg m² for kg m2."""
    text = SQUARED.sub(lambda found: found[1] + found[2].translate(SUPERSCRIPT), text)
    raised = POWER.sub(lambda found: f"{'' if found[1] == '1' else found[1] + TIMES}{power(int(found[2]))}", text)
    return POINT.sub("0.", raised)


EXPONENT = re.compile(r"(?<=[\w)])\^(-?\d+)")


def formula(text: str) -> str:
    """A formula of one line with its powers raised: 'b²' for 'b^2', 'Rᵀ' for 'R^T'."""
    return EXPONENT.sub(lambda found: found[1].translate(SUPERSCRIPT), text).replace("^T", "ᵀ")


def unit_text(unit: str) -> str:
    """A unit as people write it: 'm/s²' for 'm/s2', 'kg m²' for 'kg m2'."""
    return re.sub(r"(?<=[a-z])-?\d+\b", lambda found: found[0].translate(SUPERSCRIPT), unit)


def knobs(track: str) -> str:
    """The settings of a search in words: 'tuned, split impulse on, erp 10⁻⁷' for 'tuned, split_impulse True, erp 1e-07'."""
    words = re.sub(r"\bTrue\b", "on", re.sub(r"\bFalse\b", "off", track))
    return powers(words).replace("_", " ")


def plural(count: int, noun: str, several: str = "") -> str:
    """'1 case', '2 cases'; `several` where it is not the noun and an s: '2 axes'."""
    return f"{count} {noun}" if count == 1 else f"{count} {several or noun + 's'}"


def join_words(words: Iterable[str]) -> str:
    """'a, b and c'."""
    listed = list(words)
    return listed[0] if len(listed) == 1 else f"{', '.join(listed[:-1])} and {listed[-1]}" if listed else ""


def slug(name: str) -> str:
    """A file name from any string: itself where it is plain, otherwise its plain characters and a digest.

    Of a scene of one's own it has the file's name, not its path.
    """
    if re.fullmatch(r"[A-Za-z0-9_-]{1,80}", name):
        return name
    if name.startswith(OWN):
        return f"scene_{re.sub(r'[^A-Za-z0-9_-]+', '_', PurePath(name).stem)[:40].strip('_')}-{digest(name)[:8]}"
    return f"{re.sub(r'[^A-Za-z0-9_-]+', '_', name)[:40].strip('_')}-{digest(name)[:8]}"


def settings_text(settings: str | Mapping[str, Any]) -> str:
    """Settings on one line: 'dt 1/240 s, iterations 50, options.cone elliptic'; the source is left to its own column."""
    return _settings_of_json(settings) if isinstance(settings, str) else _settings_line(settings)


@lru_cache(maxsize=4096)
def _settings_of_json(text: str) -> str:
    """The same of settings as a table has them: trials share theirs with many others."""
    try:
        return _settings_line(json.loads(text))
    except ValueError:
        return text


def _settings_line(settings: Any) -> str:
    if not isinstance(settings, Mapping):
        return str(settings)
    flat: list[str] = []
    for name, value in settings.items():
        if name == "source" or value in (None, "", {}):
            continue
        if isinstance(value, Mapping):
            flat += [f"{inner} {_knob_value(inner, v)}" for inner, v in value.items()]
        else:
            flat.append(f"{name} {_knob_value(name, value)}")
    return ", ".join(flat)


def _knob_value(name: str, value: Any) -> str:
    """A knob's value; a time step, of whatever, as people write it."""
    return step(value) if name == "dt" or name.endswith("_step") else plain_value(value)


def step(dt: Any, substeps: int | None = 1) -> str:
    """A time step [s] as people write it: '1/60 s (4 sub-steps)', or '3.3 ms' where it is no whole part of a second."""
    if not isinstance(dt, int | float) or isinstance(dt, bool) or not 0 < dt < math.inf:
        return plain_value(dt)
    return (whole_part(dt) or duration(dt)) + beside(substeps)


def plain_value(value: Any) -> str:
    """One setting's or parameter's value; short for numbers."""
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
