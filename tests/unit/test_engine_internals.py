"""What the engine uses of Numba beyond what Numba documents: in one folder, all of it listed, and each name still there."""

import ast
import builtins
import importlib
import operator
import re
import tomllib
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numba
import pytest

from engine.compile.internals import FILES, INTERNALS

pytestmark = pytest.mark.compiler

ROOT = Path(__file__).parents[2]
ONLY = tuple(ROOT / "engine" / "compile" / f"{name}.py" for name in FILES)
LIST = ROOT / "engine" / "compile" / "internals.py"
PUBLIC = {"numba", "numba.extending"}
"""What may be imported of Numba anywhere in the engine."""
COMMON = {
    *("codegen", "compile", "finalize", "flags", "initialize", "library", "signature", "state"),
    *(
        "apply",
        "args",
        "blocks",
        "cast",
        "fastmath",
        "guard",
        "return_type",
        "kws",
        "match",
        "op",
        "rewrites",
        "templates",
        "typeof",
        "Expr",
    ),
}
"""Names of `INTERNALS` that other things have as well, so that they say nothing about who uses Numba."""
THEIRS, OURS = re.compile(r"numba|llvmlite"), re.compile(r"^[ \t]*(?:from|import)\b.*\bengine\b", re.MULTILINE)
"""What stands in a file that names them, and in one that may hand them on where it has their names: any other is not parsed."""
OWN = {
    *("alone", "inline", "raises", "seldom"),  # libraries
    *("counter", "fused", "known_step"),  # lower_kernel
    "_known",  # remembered
}
"""Attributes in those files of their own classes."""
PLAIN = {name for kind in (str, list, dict) for name in dir(kind)} | {
    *("NUMBA_NUM_THREADS", "config", "types", "unliteral", "none", "return_type", "args", "CPointer"),  # what Numba documents
    *("call", "inttoptr", "extract_value"),  # the builder of llvmlite, documented
    *("clone", "functions", "global_variables", "linkage", "link_in", "name", "preserve"),  # its modules, documented
    *("as_bitcode", "is_declaration", "parse_assembly"),  # of the same
    *("alloca", "fneg", "gep", "goto_entry_block", "icmp_signed", "insert_value", "inbounds", "mul", "sdiv", "select", "store"),
    *("attributes", "blocks", "declare_intrinsic", "instructions", "operands", "opname", "pointee", "terminator", "type"),
    *("add_function_attribute", "add_instruction_combine_pass", "add_simplify_cfg_pass", "add_sroa_pass", "data_layout", "run"),
    *("create_new_function_pass_manager", "binding", "ir", "module"),  # of llvmlite, documented too
    *("Array", "BaseTuple", "CPointer", "Dispatcher", "Function", "Integer", "IntegerLiteral", "Number", "Optional", "Type"),
    *(
        "UniTuple",
        "Any",
        "itemsize",
        "lhs_only",
        "meminfo",
        "strides",
        "dtype",
        "float64",
        "instance_class",
        "int64",
        "intp",
        "layout",
        "literal",
        "literal_value",
        "ndim",
        "signed",
    ),
    *("StructModel", "analysis_only", "builder", "context", "dispatcher", "mutates_CFG", "body", "value", "target"),  # Numba's
    *("__name__", "_asdict", "bound", "BytesIO", "getvalue", "load", "loads", "read", "strict"),  # Python's own
    *("add", "empty", "getitem", "iadd", "isub", "setitem", "sub", "zeros", "data", "shape", "start", "stop", "step", "count"),
}


def added(a: float, b: float) -> float:
    return a + b


@pytest.fixture(scope="module")
def specimens(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """One of each of what `INTERNALS` describes by words, caught while Numba compiles a function."""
    from numba.core import ir
    from numba.core.compiler import CompilerBase, DefaultPassBuilder
    from numba.core.cpu import CPUTargetOptions

    base: Any = CompilerBase
    builder: Any = DefaultPassBuilder
    accepted: Any = CPUTargetOptions
    statements: Any = ir
    caught: dict[str, Any] = {}

    class Catching(base):  # type: ignore[misc]  # Numba's stubs do not know it
        def define_pipelines(self) -> list[Any]:
            caught["compiler"], caught["state"] = self, self.state
            return [builder.define_nopython_pipeline(self.state)]

    options: Any = {"cache": True, "pipeline_class": Catching}
    signature = (numba.float64, numba.float64)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(numba.config, "CACHE_DIR", str(tmp_path_factory.mktemp("kernels")))
        function: Any = numba.njit(**options)(added)
        function.compile(signature)
    made = function.get_compile_result(numba.float64(*signature))
    types: Any = numba.types
    where = caught["state"].func_ir.loc
    return {
        "the options of njit": {"pipeline_class", *dir(accepted)},
        "the type of a function": types.FunctionType(numba.float64(*signature)),
        "the type of a slice": types.slice2_type,
        "a compiled function": function,
        "its cache": function._cache,
        "where its cache lies": function._cache._impl,
        "what says where": function._cache._impl.locator,
        "the files of its cache": function._cache._cache_file,
        "what its compiler made": made,
        "its description": made.fndesc,
        "its library": made.library,
        "the machine code that it is made with": made.library.codegen,
        "its compiler": caught["compiler"],
        "the state of its compiler": caught["state"],
        "the flags of its compiler": caught["state"].flags,
        "the function in its compiler": caught["state"].func_id,
        "its text in its compiler": caught["state"].func_ir,
        "a sum in its text": next(
            one.value
            for block in caught["state"].func_ir.blocks.values()
            for one in block.body
            if getattr(getattr(one, "value", None), "op", None) == "binop"
        ),
        "a call in a text": statements.Expr.call(statements.Var(None, "called", where), (), (), where),
        "what its compiler knows of types": caught["state"].typingctx,
        "the type of an operation": caught["state"].typingctx.resolve_value_type(operator.add),
        "its target": caught["state"].targetctx,
    }


def found(path: str) -> Any:
    """What a dotted path leads to: a module, or something in one."""
    try:
        return importlib.import_module(path)
    except ModuleNotFoundError:
        module, _, name = path.rpartition(".")
        return getattr(importlib.import_module(module), name)


@pytest.mark.parametrize("where", INTERNALS)
def test_this_version_of_numba_has_what_is_used_of_it(where: str, specimens: dict[str, Any]) -> None:
    names = INTERNALS[where]
    has = f"numba {version('numba')}: {where}"
    thing = found(where) if where.startswith("numba.") else specimens[where]
    known = thing if isinstance(thing, set) else None
    missing = [name for name in names if not (name in known if known is not None else hasattr(thing, name))]
    assert not missing, f"{has} has no {', '.join(missing)}: mend engine/compile, or keep numba below this version"


def nodes_of(path: Path) -> list[ast.AST]:
    """All that a file is made of."""
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def attributes(nodes: list[ast.AST]) -> set[str]:
    """The names that follow a dot in a file, and the keywords of its calls and keys of its dictionaries."""
    dots = {node.attr for node in nodes if isinstance(node, ast.Attribute)}
    words = {node.arg for node in nodes if isinstance(node, ast.keyword) and node.arg}
    return dots | words


def test_the_list_is_whole() -> None:
    listed = {name for names in INTERNALS.values() for name in names}
    used = set().union(*(attributes(nodes_of(path)) for path in ONLY)) - set(dir(builtins)) - PLAIN - OWN
    assert sorted(used - listed) == [], "used in engine/compile; to be listed in INTERNALS"
    text = "\n".join(path.read_text(encoding="utf-8") for path in ONLY)
    assert not [name for name in listed if not re.search(rf"\b{name}\b", text)], "listed and not used"


@pytest.mark.parametrize("package", ["engine", "harness", "adapters", "cases", "reports"])
def test_no_other_file_touches_them(package: str) -> None:
    telling = {name for names in INTERNALS.values() for name in names} - COMMON
    words = re.compile(rf"\b(?:{'|'.join(sorted(telling))})\b")
    for path in sorted((ROOT / package).rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if path in (*ONLY, LIST) or not (THEIRS.search(text) or (OURS.search(text) and words.search(text))):
            continue
        nodes = nodes_of(path)
        imported = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
        imported |= {node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)}
        named = {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)}
        modules = {name for name in imported | named if re.fullmatch(r"(numba|llvmlite)(\.\w+)*", name)}
        assert not modules - PUBLIC, f"{path.relative_to(ROOT)}: {modules - PUBLIC}"
        if any(name.split(".")[0] in ("numba", "engine") for name in imported):
            assert not attributes(nodes) & telling, f"{path.relative_to(ROOT)}: {attributes(nodes) & telling}"


def test_the_version_that_is_tested_is_the_newest_that_is_let_in() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (bounds,) = [one for one in project["dependencies"] if one.startswith("numba")]
    locked = re.search(r"^numba==(\d+)\.(\d+)\.\d+ ", (ROOT / "requirements.lock").read_text(), re.MULTILINE)
    assert locked is not None
    assert bounds == f"numba>={locked[1]}.{locked[2]},<{locked[1]}.{int(locked[2]) + 1}"
    assert version("numba").startswith(f"{locked[1]}.{locked[2]}.")
