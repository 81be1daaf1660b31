"""A state of the reference engine is made of sums and products that every processor rounds alike, in the order of the text."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROUNDED = {"sqrt", "floor", "ceil", "trunc", "copysign", "fabs", "isfinite", "isinf", "isnan", "gcd", "inf", "nan", "pi"}
"""Of `math`: what IEEE 754 rounds correctly, what rounds nothing, and numbers."""
LIBRARY = {
    *("arccos", "arcsin", "arctan", "arctan2", "arccosh", "arcsinh", "arctanh", "cos", "cosh", "sin", "sinh", "tan", "tanh"),
    *("exp", "exp2", "expm1", "log", "log10", "log1p", "log2", "logaddexp", "cbrt", "hypot", "power", "float_power"),
    *("convolve", "correlate", "cov", "corrcoef", "dot", "einsum", "inner", "interp", "kron", "linalg", "matmul", "outer"),
    *("polyfit", "roots", "tensordot", "vdot", "matvec", "vecdot", "vecmat", "fft", "trapezoid"),
}
"""Of NumPy: what asks a library of linear algebra, or functions whose last bits go with the processor's instructions."""
EXCEPTIONS = {
    "engine/respond/exact": "the exact solver keeps LAPACK: it certifies its answer to a tolerance, and promises no bits",
    "engine/build/polyhedra.py": "Quickhull says which corners make a facet, a choice and not a number: SciPy's hulls",
    "engine/images/eye.py": "up to where a lens is one to one: a root of a cubic, of pictures and of no state",
}
"""Where such things may stand, and why. Outside of WHOLE only the names of SciPy are let in."""
WHOLE = ("engine/respond/exact", "engine/images/eye.py")


def calls(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """What a file asks of a library: the line, and the text of it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp) and (
            isinstance(node.op, ast.MatMult) or (isinstance(node.op, ast.Pow) and not _whole(node))
        ):
            yield node.lineno, ast.unparse(node)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            module, name = node.value.id, node.attr
            if (module == "np" and name in LIBRARY) or (module == "math" and name not in ROUNDED) or name == "dot":
                yield node.lineno, ast.unparse(node)
        elif isinstance(node, ast.Attribute) and node.attr == "dot":
            yield node.lineno, ast.unparse(node)
        elif isinstance(node, ast.ImportFrom) and node.module == "math":
            yield from ((node.lineno, f"math.{one.name}") for one in node.names if one.name not in ROUNDED)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("numpy"):
            yield from ((node.lineno, f"np.{one.name}") for one in node.names if one.name in LIBRARY)
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else [node.module or ""]
            yield from ((node.lineno, name) for name in names if name.partition(".")[0] == "scipy")


def _whole(power: ast.BinOp) -> bool:
    """Are both sides of a power written as whole numbers, so that the interpreter works it out exactly?"""
    return all(isinstance(side, ast.Constant) and isinstance(side.value, int) for side in (power.left, power.right))


def asked(path: Path) -> list[str]:
    """What a file asks of libraries and may not."""
    name = path.relative_to(ROOT).as_posix()
    if name.startswith(WHOLE):
        return []
    found = [f"{name}:{line}: {text}" for line, text in sorted(calls(ast.parse(path.read_text(encoding="utf-8"))))]
    return [one for one in found if name not in EXCEPTIONS or "scipy" not in one]


@pytest.mark.parametrize("package", ["engine", "adapters/reference"])
def test_no_library_rounds_a_state(package: str) -> None:
    assert [one for path in sorted((ROOT / package).rglob("*.py")) for one in asked(path)] == []


@pytest.mark.parametrize("name", EXCEPTIONS)
def test_an_exception_is_still_one(name: str) -> None:
    where = ROOT / name
    files = where.rglob("*.py") if where.is_dir() else [where]
    assert any(True for path in files for _ in calls(ast.parse(path.read_text())))


@pytest.mark.parametrize(
    "text",
    [
        "a @ b", "a.dot(b)", "np.linalg.norm(a)", "np.hypot(a, b)", "x ** 0.5", "x ** 2", "math.cos(x)",
        "from math import hypot", "import scipy.linalg", "from scipy.spatial import ConvexHull", "np.einsum('ij,j', a, b)",
        "np.cov(a)", "np.power(a, 2)",
    ],
)  # fmt: skip
def test_what_a_library_rounds_is_seen(text: str) -> None:
    assert list(calls(ast.parse(text)))


@pytest.mark.parametrize("text", ["math.sqrt(x)", "np.sqrt(a)", "dot(a, b)", "2**20", "a * b + c", "f(**options)", "math.pi"])
def test_what_every_processor_rounds_alike_is_let_in(text: str) -> None:
    assert not list(calls(ast.parse(text)))
