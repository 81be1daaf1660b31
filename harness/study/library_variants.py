"""Variants of the numeric libraries that a run is repeated with: the code that they choose on another processor.

Each is chosen by an environment variable that acts as a process starts: OpenBLAS takes the kernels of one processor, NumPy does
without its wider instructions, the C library without those of its functions (sin, cos, exp, log, pow, atan2) that round a
product and a sum at once.

Source: README of OpenBLAS, section "DYNAMIC_ARCH"; NumPy's manual, section "CPU build options"; glibc's manual, section
"Hardware Capability Tunables".
"""

import os
import platform
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.lib import introspect
from threadpoolctl import threadpool_info

from plumbline.harness.case.alteration import Variables
from plumbline.harness.intake.safe_text import quoted

_NAMED_SINCE = (2, 33)
"""The release of glibc from which on its features have the names that stand below."""


@dataclass(frozen=True, slots=True)
class LibraryVariant:
    """A choice of code in one library.

    Terms:
        name: that tables show. variables: that choose it. flags: of the processor, as Linux names them, that the code needs, or
        without which nothing is switched off. missing: why the library of this machine would not heed them; '' if it does.
    """

    name: str
    variables: Variables
    flags: tuple[str, ...]
    missing: Callable[[], str]


def _openblas() -> str:
    found = sorted({library["internal_api"] for library in threadpool_info() if library["user_api"] == "blas"})
    return "" if "openblas" in found else f"NumPy uses {', '.join(found) or 'no BLAS that is known'}, expected OpenBLAS"


def _numpy() -> str:
    code = str(introspect.opt_func_info("^add$"))
    return "" if "X86_V3" in code else f"NumPy {np.__version__} has no code of the name X86_V3"


def _glibc() -> str:
    name, version = platform.libc_ver()
    known = name == "glibc" and tuple(int(number) for number in version.split(".")) >= _NAMED_SINCE
    return "" if known else f"the C library is {name or 'unknown'} {version}, expected glibc 2.33 or later"


LIBRARY_VARIANTS = (
    LibraryVariant("BLAS for Prescott", (("OPENBLAS_CORETYPE", "Prescott"),), ("pni",), _openblas),
    LibraryVariant("BLAS for Haswell", (("OPENBLAS_CORETYPE", "Haswell"),), ("avx2", "fma"), _openblas),
    LibraryVariant(
        "BLAS for SkylakeX",
        (("OPENBLAS_CORETYPE", "SkylakeX"),),
        ("avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl"),
        _openblas,
    ),
    LibraryVariant(
        "NumPy without AVX2", (("NPY_DISABLE_CPU_FEATURES", "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"),), ("avx2",), _numpy
    ),
    LibraryVariant("C library without FMA", (("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX2,-FMA"),), ("fma",), _glibc),
)
"""The same on every machine, so that its parts of a study fit those of others. OpenBLAS as NumPy's wheels have it answers with
Haswell's kernels when asked for Zen's."""


def obstacle(variables: Variables) -> str:
    """Why no run on this machine can have these environment variables; '' if one can.

    What the user has set stays as it is.
    """
    for name, _ in variables:
        if name in os.environ:
            return f"{name} is {quoted(os.environ[name])} in the environment already, and is left so"
    for variant in LIBRARY_VARIANTS:
        if variant.variables == variables:
            lacking = [flag for flag in variant.flags if flag not in _processor_flags()]
            return f"/proc/cpuinfo names no {', '.join(lacking)}" if lacking else variant.missing()
    return ""


def _processor_flags() -> frozenset[str]:
    """What the processor has, as Linux names it; nothing on other systems."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines() if path.is_file() else []
    return frozenset(next((line.partition(":")[2].split() for line in lines if line.startswith("flags")), []))
