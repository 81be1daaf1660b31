"""The engine's own sines, exponentials, eigenvectors and the like, against a hundred digits and against the same in Python."""

import math
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mpmath
import numba
import numpy as np
import pytest
from numpy.typing import NDArray

from plumbline.engine.compile.jit import jit_is_off
from plumbline.engine.maths import arrays, elementary
from plumbline.engine.maths.floats import fma, from_word, word

Array = NDArray[np.float64]
POINTS = pytest.mark.parametrize("count", [3_000, pytest.param(100_000, marks=pytest.mark.slow)])
FUNCTIONS = ("cos", "sin", "exp", "expm1", "log", "fifth_root", "atan2", "hypot", "fma")
mp: Any = mpmath.mp
njit: Any = numba.njit


@njit
def values(which: int, x: Array, y: Array, out: Array) -> None:
    for k in range(x.shape[0]):
        if which < 2:
            out[k] = elementary.cos_sin(x[k])[which]
        elif which == 2:
            out[k] = elementary.exp(x[k])
        elif which == 3:
            out[k] = elementary.expm1(x[k])
        elif which == 4:
            out[k] = elementary.log(x[k])
        elif which == 5:
            out[k] = elementary.fifth_root(x[k])
        elif which == 6:
            out[k] = elementary.atan2(y[k], x[k])
        elif which == 7:
            out[k] = elementary.hypot(x[k], y[k])
        else:
            out[k] = fma(x[k], y[k], -1.0)


def of(name: str, x: Any, y: Any = 0.0) -> Array:
    """A function of the engine at many arguments."""
    first = np.atleast_1d(np.asarray(x, float))
    out = np.empty(first.shape)
    values(FUNCTIONS.index(name), first, np.broadcast_to(np.asarray(y, float), first.shape).copy(), out)
    return out


def worst(found: Array, exact: Callable[[int], Any]) -> float:
    """The largest error in units of the last place."""
    largest = 0.0
    for k, value in enumerate(found.tolist()):
        true = exact(k)
        largest = max(largest, abs(float((mp.mpf(value) - true) / math.ulp(float(true)))))
    return largest


def spread(low: int, high: int, seed: int, count: int) -> Array:
    """Numbers of both signs whose exponents of two are spread evenly."""
    rng = np.random.default_rng(seed)
    return rng.choice([-1.0, 1.0], count) * np.ldexp(rng.uniform(1.0, 2.0, count), rng.integers(low, high, count))


def even(low: float, high: float, seed: int, count: int) -> Array:
    """Numbers spread evenly."""
    return np.random.default_rng(seed).uniform(low, high, count)


ANGLES: dict[str, Callable[[int], Array]] = {
    "small": lambda count: even(-4.0, 4.0, 1, count),
    "far": lambda count: even(-1e6, 1e6, 2, count),
    "huge": lambda count: spread(20, 1023, 3, count // 10),
    "tiny": lambda count: spread(-1070, 0, 4, count),
    "near quarters of a turn": lambda count: np.round(even(0.0, 1e6, 5, count // 10)) * (math.pi / 2),
    # The first is the double nearest to a multiple of pi/2: Muller, Elementary Functions, 3rd ed., table 11.1.
    "the worst": lambda _: np.array([6381956970095103.0 * 2.0**797, math.pi / 4, 0.7853981633974484, 8e5, 799999.9999999999]),
}


@POINTS
@pytest.mark.parametrize("kind", ANGLES)
def test_sines_and_cosines(kind: str, count: int) -> None:
    x = ANGLES[kind](count)
    with mp.workprec(1200 if kind in ("huge", "the worst") else 160):
        assert worst(of("cos", x), lambda k: mp.cos(mp.mpf(x[k]))) < 1.0
        assert worst(of("sin", x), lambda k: mp.sin(mp.mpf(x[k]))) < 1.0


@POINTS
@pytest.mark.parametrize(
    ("name", "exact", "arguments", "bound"),
    [
        ("exp", mpmath.exp, lambda count: even(-745.0, 709.7, 1, count), 1.0),
        ("exp", mpmath.exp, lambda count: spread(-60, 1, 2, count), 1.0),
        ("expm1", mpmath.expm1, lambda count: even(-45.0, 709.7, 3, count), 2.0),
        ("expm1", mpmath.expm1, lambda count: spread(-1070, 1, 4, count), 2.0),
        ("log", mpmath.log, lambda count: np.abs(spread(-1074, 1023, 5, count)), 1.0),
        ("log", mpmath.log, lambda count: even(0.5, 2.0, 6, count), 1.0),
        ("fifth_root", lambda x: mpmath.root(x, 5), lambda count: np.abs(spread(-1074, 1023, 7, count)), 1.0),
    ],
)
def test_a_function_of_one_number(
    name: str, exact: Callable[[Any], Any], arguments: Callable[[int], Array], bound: float, count: int
) -> None:
    x = arguments(count)
    with mp.workprec(160):
        assert worst(of(name, x), lambda k: exact(mp.mpf(x[k]))) < bound


@POINTS
@pytest.mark.parametrize(("low", "high"), [(-2, 3), (-40, 40), (-500, 500)])
def test_angles_and_lengths_of_two_numbers(low: int, high: int, count: int) -> None:
    x, y = spread(low, high, 1, count), spread(low, high, 2, count)
    with mp.workprec(160):
        assert worst(of("atan2", x, y), lambda k: mp.atan2(mp.mpf(y[k]), mp.mpf(x[k]))) < 1.0
        assert worst(of("hypot", x, y), lambda k: mp.hypot(mp.mpf(x[k]), mp.mpf(y[k]))) < 2.0


INF, NAN, LEAST = math.inf, math.nan, 5e-324


@pytest.mark.parametrize(
    ("name", "x", "y", "expected"),
    [
        ("cos", 0.0, 0.0, 1.0), ("sin", 0.0, 0.0, 0.0), ("sin", -0.0, 0.0, -0.0), ("sin", LEAST, 0.0, LEAST),
        ("cos", INF, 0.0, NAN), ("sin", -INF, 0.0, NAN), ("sin", NAN, 0.0, NAN), ("cos", NAN, 0.0, NAN),
        ("exp", 0.0, 0.0, 1.0), ("exp", INF, 0.0, INF), ("exp", -INF, 0.0, 0.0), ("exp", NAN, 0.0, NAN),
        ("exp", 710.0, 0.0, INF),
        ("exp", -745.0, 0.0, LEAST), ("exp", -746.0, 0.0, 0.0), ("exp", 1e308, 0.0, INF),
        ("expm1", -0.0, 0.0, -0.0), ("expm1", LEAST, 0.0, LEAST), ("expm1", INF, 0.0, INF), ("expm1", -INF, 0.0, -1.0),
        ("expm1", NAN, 0.0, NAN), ("log", 1.0, 0.0, 0.0), ("log", 0.0, 0.0, -INF), ("log", -0.0, 0.0, -INF),
        ("log", -1.0, 0.0, NAN), ("log", INF, 0.0, INF), ("log", NAN, 0.0, NAN), ("log", -INF, 0.0, NAN),
        ("fifth_root", 0.0, 0.0, 0.0), ("fifth_root", INF, 0.0, INF), ("fifth_root", -1.0, 0.0, NAN),
        ("fifth_root", NAN, 0.0, NAN),
        ("hypot", 0.0, -0.0, 0.0), ("hypot", INF, NAN, INF), ("hypot", -INF, 1.0, INF), ("hypot", NAN, 1.0, NAN),
        ("hypot", 1e308, 1e308, 1.4142135623730951e308), ("hypot", 3 * LEAST, 4 * LEAST, 5 * LEAST), ("hypot", 0.0, NAN, NAN),
        ("atan2", NAN, 1.0, NAN), ("atan2", 1.0, NAN, NAN), ("fma", INF, 0.0, NAN),
        ("fma", 1.0 + 2.0**-30, 1.0 - 2.0**-30, -(2.0**-60)),
        *(("atan2", x, y, math.atan2(y, x)) for x in (0.0, -0.0, 1.0, -1.0, INF, -INF, LEAST, -1e308)
          for y in (0.0, -0.0, INF, -INF)),
        ("atan2", LEAST, LEAST, math.pi / 4), ("atan2", 1e308, 1e308, math.pi / 4), ("atan2", 1e-308, 1e308, math.pi / 2),
    ],
)  # fmt: skip
def test_zeros_infinities_and_what_is_no_number(name: str, x: float, y: float, expected: float) -> None:
    (found,) = of(name, x, y).tolist()
    assert (
        math.isnan(found)
        if math.isnan(expected)
        else (found, math.copysign(1.0, found)) == (expected, math.copysign(1.0, expected))
    )


@pytest.mark.skipif(jit_is_off(), reason="compares compiled code with Python")
def test_compiled_code_and_python_give_the_same_bits(tmp_path: Path) -> None:
    x, y = np.concatenate([spread(-1074, 1023, 1, 400), spread(-3, 8, 2, 400)]), spread(-40, 40, 3, 800)
    np.save(tmp_path / "given.npy", np.array([x, y]))
    text = (
        "import sys, numpy; sys.path[:0] = sys.argv[1:2]; from tests.unit.test_engine_elementary import FUNCTIONS, of;"
        "x, y = numpy.load(sys.argv[2] + '/given.npy');"
        "numpy.save(sys.argv[2] + '/found.npy', [of(name, x, y) for name in FUNCTIONS])"
    )
    command = [sys.executable, "-c", text, str(Path(__file__).parents[2]), str(tmp_path)]
    subprocess.run(command, env={**os.environ, "NUMBA_DISABLE_JIT": "1"}, check=True)
    for name, found in zip(FUNCTIONS, np.load(tmp_path / "found.npy"), strict=True):
        assert found.tobytes() == of(name, x, y).tobytes(), name


def test_a_word_is_the_bits_of_a_float() -> None:
    if jit_is_off():
        assert word(-2.0) == -(1 << 62)
        assert from_word(word(math.pi)) == math.pi


def symmetric(seed: int) -> Array:
    """Matrices that are symmetric: of any size, nearly diagonal, with moments alike or far apart."""
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    moments = 10.0 ** rng.uniform(-6, 6) * np.array(
        [[1.0, 2.0, 3.0], [1.0, 1.0, 1.0 + 1e-12 * seed], [1.0, 1e9, 1e9]][seed % 3]
    )
    whole = turn @ np.diag(moments) @ turn.T
    return np.asarray((whole + whole.T) / 2)


@pytest.mark.parametrize("seed", range(60))
def test_eigenvectors_determinants_and_inverses(seed: int) -> None:
    m = symmetric(seed)
    size = np.abs(m).max()
    moments, axes = arrays.eigen(m)
    assert moments == pytest.approx(np.linalg.eigvalsh(m), rel=1e-13, abs=4e-15 * size)
    assert arrays.eigenvalues(m).tolist() == moments.tolist()
    assert axes.T @ axes == pytest.approx(np.eye(3), abs=4e-15)
    assert axes @ np.diag(moments) @ axes.T == pytest.approx(m, abs=4e-15 * size)
    assert (np.abs(axes).max(axis=0) == axes.max(axis=0)).all()
    assert arrays.det(m) == pytest.approx(np.linalg.det(m), abs=1e-14 * size**3)
    assert arrays.inverse(m) @ m == pytest.approx(np.eye(3), abs=1e-13 * np.linalg.cond(m))
    assert (arrays.inverse(m) == arrays.inverse(m).T).all()


def test_the_eigenvectors_of_a_diagonal_matrix_are_not_rounded() -> None:
    moments, axes = arrays.eigen(np.diag([3.0, 1.0, 2.0]))
    assert moments.tolist() == [1.0, 2.0, 3.0]
    assert axes.tolist() == [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    assert arrays.inverse(np.diag([3.0, 1.0, 2.0])).tolist() == np.diag([1 / 3.0, 1.0, 0.5]).tolist()


def test_products_are_those_of_numpy_to_rounding() -> None:
    rng = np.random.default_rng(1)
    a, b, v, many = rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), rng.normal(size=3), rng.normal(size=(7, 3))
    assert arrays.mat_mat(a, b) == pytest.approx(a @ b, abs=1e-14)
    assert arrays.mat_vec(a, v) == pytest.approx(a @ v, abs=1e-14)
    assert arrays.mat_vec(a, many) == pytest.approx(many @ a.T, abs=1e-14)
    assert arrays.norm(many) == pytest.approx(np.linalg.norm(many, axis=1), rel=1e-15)
    assert arrays.norm(arrays.unit(many)) == pytest.approx(np.ones(7), rel=1e-15)
    assert arrays.cross(v, a[0]).tolist() == np.cross(v, a[0]).tolist()
