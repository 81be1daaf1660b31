"""Kernels linked into an entry as one program (over 400 lines: all that is used of Numba undocumented, in one place).

Without it (`jit.linker`) Numba compiles every function by itself, with the same bits, in three to seven times the time of a
first step. A kernel stays what Numba made of its text until an entry is linked, which takes in every kernel that it reaches,
once, and is optimised as one program: what comes out does not depend on what else the process has compiled. Until then a kernel
is cleaned up and no more. It is compiled by half of Numba's passes; what an operation on numbers returns is looked up once a
process; a call of a kernel that raises nothing does not look at how it ended; and an array is a table to it (`table_type`).
"""

import hashlib
import operator
import pickle
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from types import SimpleNamespace
from typing import Any, TypeVar, cast

import llvmlite.binding
import numba
import numpy as np
from numba.core import (
    compiler,
    compiler_machinery,
    environment,
    ir,
    ir_utils,
    lowering,
    serialize,
    typed_passes,
    untyped_passes,
)
from numba.core.codegen import JITCodeLibrary
from numba.core.runtime.nrt import rtsys

from plumbline.engine.compile.kernel_cache import read_checked, write_checked
from plumbline.engine.compile.table_type import Table, as_given, get_item, set_item
from plumbline.engine.compile.table_type import table_within as table_within

Function = TypeVar("Function", bound=Callable[..., Any])
types: Any = numba.types
llvm: Any = llvmlite.binding
Base: Any = compiler.CompilerBase
Builder: Any = compiler.DefaultPassBuilder
Result: Any = compiler.CompileResult
Environment: Any = environment
Library: Any = JITCodeLibrary
Lower: Any = lowering.Lower
Statements: Any = ir
machinery: Any = compiler_machinery
typed: Any = typed_passes
untyped: Any = untyped_passes
runtime: Any = rtsys
get_definition: Any = ir_utils.get_definition
guard: Any = ir_utils.guard

NUMBA_RUNTIME = "NRT_"
"""How the symbols that Numba shares among all functions of a process begin."""
ENVIRONMENT = "_ZN08NumbaEnv"
"""How the symbols begin under which a function finds the Python objects that it was compiled with."""
ANSWERED = frozenset({0, -2})
"""What a function of Numba ends with that has an answer, or none to give."""
LONG = 300
"""Lines from which a kernel is called rather than put in place: what calls it is optimised again and again otherwise."""


class KernelLibrary(Library):
    """What a kernel is compiled into: a module to be linked, without machine code.

    Terms: inline: whether the optimiser decides where it is put in place of calls; raises: whether it can end otherwise than
    with an answer.
    """

    inline, raises = True, True

    @property
    def codegen(self) -> Any:
        """Takes no environment: the entry sets those of all its kernels."""
        return SimpleNamespace(set_env=lambda _name, _environment: None)

    def finalize(self) -> None:
        """End without machine code."""
        self._raise_if_finalized()
        self._finalize_dynamic_globals()
        self._finalized = True

    def add_ir_module(self, module: Any) -> None:
        """Take in what Numba wrote, cleaned up."""
        self.raises = may_raise(module)
        super().add_ir_module(module)

    def _optimize_functions(self, module: Any) -> None:
        tidy(module, self._codegen, self.inline)

    def alone(self) -> Any:
        """The module of this kernel, without what it calls.

        LLVM's linker leaves out what is 'linkonce' and not called so far; a kernel that is taken in later may call it.
        """
        module = super()._get_module_for_linking()
        for function in module.functions:
            if function.linkage.name == "linkonce_odr":
                function.linkage = "weak_odr"
        return module

    def _get_module_for_linking(self) -> Any:
        """For the libraries that Numba makes of the bodies of parallel loops: with all that it calls."""
        whole = self.alone().clone()
        link(whole, self._linking_libraries)
        return whole

    def get_pointer_to_function(self, _name: str) -> int:
        """Nothing that could be called: 0."""
        return 0


class EntryLibrary(Library):
    """What an entry is compiled into: one program with every kernel that it reaches."""

    def finalize(self) -> None:
        """Take in all kernels, end with machine code, and set what functions know of Python."""
        for one in link(self._final_module, self._linking_libraries):
            self._reload_init.update(one._reload_init)
        self._linking_libraries: list[Any] = []
        super().finalize()
        for one in self._final_module.global_variables:
            found = Environment.lookup_environment(one.name) if one.name.startswith(ENVIRONMENT) else None
            if found is not None:
                self._codegen.set_env(one.name, found)

    def _optimize_final_module(self) -> None:
        for one in self._final_module.functions:
            if one.linkage.name in {"linkonce_odr", "weak_odr"} and not one.name.startswith(NUMBA_RUNTIME):
                # The bodies of parallel loops are among them: the process that compiles has those in a library apart.
                # Not 'internal': the loader would find those by name, for callers that do not know what became of them.
                one.linkage = "private"
        super()._optimize_final_module()

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """As Numba keeps it, with the names that Python asks for in place of the program, which no other takes in.

        To read the program was half of the first step of a robot on the ground where machine code is kept.
        """
        self._ensure_finalized()
        defined = [one for one in self._final_module.functions if not one.is_declaration]
        exported = [one.name for one in defined if one.linkage.name == "external"]
        bodies = "\n".join(f'define void @"{name}"() {{ ret void }}' for name in exported)
        return self.name, "object", (self._get_compiled_object(), llvm.parse_assembly(bodies).as_bitcode())


def link(module: Any, libraries: list[Any]) -> list[Any]:
    """Take the libraries into a module, and through kernels all that those call, each once. Returns: all that were taken."""
    taken: dict[Any, None] = {}
    others = []
    ahead = list(reversed(libraries))
    while ahead:
        one = ahead.pop()
        if one in taken:
            continue
        taken[one] = None
        if isinstance(one, KernelLibrary):
            kernel: Any = one
            module.link_in(kernel.alone(), preserve=True)
            ahead.extend(reversed(kernel._linking_libraries))
        else:
            others.append(one)
    for library in others:  # once all that calls them is there
        module.link_in(library._get_module_for_linking(), preserve=True)
    return list(taken)


def tidy(module: Any, codegen: Any, inline: bool) -> None:
    """Clean a kernel's module up: variables into registers, what is known worked out. The entry optimises it with its own.

    Args: inline: whether the optimiser may choose to put it in place of calls; it then does so where it is short.
    """
    module.data_layout = codegen._data_layout
    builder = codegen._pass_builder()
    passes = llvm.create_new_function_pass_manager()
    passes.add_sroa_pass()
    passes.add_simplify_cfg_pass()
    passes.add_instruction_combine_pass()
    passes.add_simplify_cfg_pass()
    for function in module.functions:
        if not function.is_declaration:
            passes.run(function, builder)
            if inline and str(function).count("\n") > LONG:
                function.add_function_attribute("noinline")


def may_raise(module: Any) -> bool:
    """Whether a function of a module can end otherwise than with an answer."""
    ends = [block.terminator for function in module.functions for block in function.blocks if block.terminator.opname == "ret"]
    return any(getattr(end.operands[0], "constant", None) not in ANSWERED for end in ends)


class LowerKernel(Lower):
    """Numba's writer of LLVM for kernels."""

    def delvar(self, name: str) -> None:
        """Clear a variable where a count depends on it."""
        if self.context.enable_nrt:
            super().delvar(name)

    def alloca_lltype(self, name: str, kind: Any, datamodel: Any = None) -> Any:
        """Room for a variable, set to zero where a count depends on it."""
        if self.context.enable_nrt:
            return super().alloca_lltype(name, kind, datamodel)
        with self.builder.goto_entry_block():
            return self.builder.alloca(kind, name=name)

    def lower_binop(self, kind: Any, expression: Any, operation: Any) -> Any:
        """Of numbers, by the signature that was found when types were inferred, where Numba looks for it again."""
        names = expression.lhs.name, expression.rhs.name
        kinds = [self.typeof(name) for name in names]
        constants = expression.static_lhs, expression.static_rhs
        if any(one is not Statements.UNDEFINED for one in constants) or not all(isinstance(one, types.Number) for one in kinds):
            return super().lower_binop(kind, expression, operation)
        signature = self.fndesc.calltypes[expression]
        values = [
            self.context.cast(self.builder, self.loadvar(name), one, asked)
            for name, one, asked in zip(names, kinds, signature.args, strict=True)
        ]
        known = self.context.typing_context
        code = self.context.get_function(
            known.resolve_value_type(operation), Remembering(known).resolve_function_type(operation, signature.args, {})
        )
        return self.context.cast(self.builder, code(self.builder, values), signature.return_type, kind)

    def _lower_call_normal(self, kind: Any, expression: Any, signature: Any) -> Any:
        """Of kernels in which nothing is raised, without a look at how they ended."""
        made = kind.dispatcher.overloads.get(tuple(signature.args)) if isinstance(kind, types.Dispatcher) else None
        if made is None or getattr(made.library, "raises", True) or isinstance(signature.return_type, types.Optional):
            return super()._lower_call_normal(kind, expression, signature)
        context, builder, convention = self.context, self.builder, self.context.call_conv
        given = self.fold_call_args(kind, signature, expression.args, expression.vararg, expression.kws)
        function = self.module.globals.get(made.fndesc.mangled_name) or context.declare_function(self.module, made.fndesc)
        with builder.goto_entry_block():
            place = builder.alloca(convention.get_return_type(signature.return_type).pointee)
        words = convention._get_arg_packer(signature.args).as_arguments(builder, given)
        builder.call(function, [place, function.args[1].type(None), *words])
        context.add_linking_libs([made.library])
        return context.get_returned_value(builder, signature.return_type, builder.load(place))

    def lower_getitem(self, kind: Any, expression: Any, value: Any, index: Any, signature: Any) -> Any:
        """Of tables, at once."""
        if not isinstance(signature.args[0], Table):
            return super().lower_getitem(kind, expression, value, index, signature)
        given = self.loadvar(value.name), self.loadvar(index.name)
        exact = signature.replace(args=(signature.args[0], self.typeof(index.name)))
        return self.context.cast(self.builder, get_item(self.context, self.builder, exact, given), signature.return_type, kind)

    def lower_setitem(self, target: Any, index: Any, value: Any, signature: Any) -> Any:
        """Of tables, at once."""
        if not isinstance(signature.args[0], Table):
            return super().lower_setitem(target, index, value, signature)
        number = self.context.cast(self.builder, self.loadvar(value.name), self.typeof(value.name), signature.args[2])
        exact = signature.replace(args=(signature.args[0], self.typeof(index.name), signature.args[2]))
        given = self.loadvar(target.name), self.loadvar(index.name), number
        return set_item(self.context, self.builder, exact, given)


ANSWERS: dict[Any, tuple[Any, Any, Any]] = {}
"""By operation and types of arguments: the alternatives that it had, its signature, and which of them that is of."""

ROOMS = frozenset({np.empty, np.zeros})
"""What makes arrays: one function each of Numba's for every shape with a constant in it, unless it is told of numbers."""


def plain_shape(kind: Any) -> Any:
    """A shape as numbers, whichever of them are known."""
    if not isinstance(kind, types.BaseTuple):
        return types.unliteral(kind)
    return types.BaseTuple.from_types(tuple(types.unliteral(one) for one in kind.types))


class Remembering:
    """What Numba knows of types, with the answers to what it was asked before."""

    def __init__(self, known: Any) -> None:
        self._known = known

    def __getattr__(self, name: str) -> Any:
        return getattr(self._known, name)

    def resolve_function_type(self, function: Any, args: Any, kws: Any) -> Any:
        """The signature of a call. Numba tries all alternatives of an operation anew wherever it stands."""
        kind = function if isinstance(function, types.Type) else self._known._lookup_global(function)
        if kws or not isinstance(kind, types.Function):
            return self._known.resolve_function_type(function, args, kws)
        if kind.typing_key in ROOMS:
            args = (plain_shape(args[0]), *args[1:])
        key = kind.typing_key, args
        answer = ANSWERS.get(key)
        if answer is None or answer[0] is not kind.templates:
            signature = self._known.resolve_function_type(function, args, kws)
            if signature is not None:
                ANSWERS[key] = kind.templates, signature, kind.get_impl_key(signature)
            return signature
        _, signature, made = answer
        kind._impl_keys[signature.args] = made
        return signature

    def resolve_setitem(self, target: Any, index: Any, value: Any) -> Any:
        """The signature of what is put into something."""
        return self.resolve_function_type(operator.setitem, (target, index, value), {})


MAKERS = frozenset({"call", "binop", "inplace_binop", "unary", "arrayexpr"})
"""The operations that may make an array; others look into one that is held elsewhere."""


@machinery.register_pass(mutates_CFG=True, analysis_only=False)
class InferTypes(typed.NopythonTypeInference):
    """As Numba does, with remembered answers."""

    _name = "plumbline_infer_types"

    def run_pass(self, state: Any) -> Any:
        """Infer the types of one function."""
        known = state.typingctx
        state.typingctx = Remembering(known)
        try:
            return super().run_pass(state)
        finally:
            state.typingctx = known


def holds(kind: Any, sought: type) -> bool:
    """Whether values of a type hold one of another type: an array, whose users are counted, or a table, whose users are not."""
    if isinstance(kind, types.BaseTuple):
        return any(holds(one, sought) for one in kind.types)
    return isinstance(kind, sought)


def origin(state: Any, variable: Any) -> str:
    """The first name of what a variable is."""
    found = guard(get_definition, state.func_ir, variable, lhs_only=True)
    return str((found or variable).name)


@machinery.register_pass(mutates_CFG=False, analysis_only=True)
class CountNothing(machinery.AnalysisPass):
    """Where a kernel neither makes nor returns arrays, nothing counts their users: callers keep what they hand over."""

    _name = "plumbline_count_nothing"

    def __init__(self) -> None:
        machinery.AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Switch off the counting of users where no array is made or returned."""
        values = {
            one.target.name: one.value
            for block in state.func_ir.blocks.values()
            for one in block.find_insts(Statements.Assign)
            if isinstance(one.value, Statements.Expr) and one.value.op in MAKERS
        }
        made = {name for name in values if holds(state.typemap[name], types.Array)}
        for name, value in values.items():
            called = value.op == "call" and isinstance(state.typemap[value.func.name], types.Dispatcher)
            if called and holds(state.typemap[name], Table) and any(origin(state, one) in made for one in value.args):
                raise TypeError(f"{state.func_id.func_qualname}: a table of an array that is made here may outlive it")
        if not made and not holds(state.return_type, types.Array):
            state.targetctx = state.targetctx.subtarget(enable_nrt=False)
        return True


@machinery.register_pass(mutates_CFG=True, analysis_only=False)
class WriteKernel(typed.BaseNativeLowering):
    """As Numba does, by `LowerKernel`."""

    _name = "plumbline_write_kernel"

    @property
    def lowering_class(self) -> type:
        """The writer of LLVM."""
        return LowerKernel


KERNEL_PASSES = (
    *(untyped.TranslateByteCode, untyped.FixupArgs, untyped.IRProcessing, untyped.RewriteSemanticConstants),
    *(untyped.DeadBranchPrune, untyped.GenericRewrites, untyped.ReconstructSSA, InferTypes, typed.PreLowerStripPhis),
    *(typed.IRLegalization, CountNothing, WriteKernel, typed.NoPythonBackend),
)


class KernelCompiler(Base):
    """Numba's compiler for functions that are only ever linked into others."""

    def define_pipelines(self) -> list[Any]:
        """One, into a module that waits to be linked, without a whole analysis of variables after each pass."""
        self.state.library = KernelLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        self.state.library.inline = not self.state.flags.forceinline
        manager = machinery.PassManager("kernel")
        manager._ENFORCING = False
        for one in KERNEL_PASSES:
            manager.add_pass(one, one.name())
        manager.finalize()
        return [manager]


class StreamCompiler(Base):
    """Numba's compiler with the promise that arrays do not overlap, which it knows as a flag but not as an option.

    It optimises such a function before the entry takes it in.
    """

    def define_pipelines(self) -> list[Any]:
        """Numba's own, so flagged."""
        self.state.flags.noalias = True
        return [Builder.define_nopython_pipeline(self.state)]


class EntryCompiler(Base):
    """Numba's compiler for functions that Python calls: they keep the kernels they were linked with to themselves."""

    def define_pipelines(self) -> list[Any]:
        """Numba's own, into one program."""
        self.state.library = EntryLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        self.state.library.enable_object_caching()
        return [Builder.define_nopython_pipeline(self.state)]


_UNCALLED = {"forceinline": False, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
OPTIONS: dict[str, dict[str, Any]] = {
    "entry": {"pipeline_class": EntryCompiler},
    "kernel": {**_UNCALLED, "pipeline_class": KernelCompiler},
    "stream": {**_UNCALLED, "pipeline_class": StreamCompiler},
    "inlined": {**_UNCALLED, "pipeline_class": KernelCompiler, "forceinline": True},
}
"""What `njit` is told of a function, by its kind."""


def for_all_values(function: Function) -> Function:
    """The compiled function that callers meet by the types of arguments alone, arrays as tables.

    Numba would compile it anew for each constant that a caller passes, `load3` for each column; inlining does that better.
    """
    compiled = cast(Any, function)
    template = compiled.get_call_template
    known: dict[Any, Any] = {}

    def by_type(args: Any, kws: Any) -> Any:
        given = as_given(args), tuple((name, *as_given((one,))) for name, one in kws.items())
        if given not in known:
            known[given] = template(given[0], dict(given[1]))
        return known[given]

    compiled.get_call_template = by_type
    return function


def kept(function: Function, directory: Path, around: Callable[[str], AbstractContextManager[None]]) -> Function:
    """The compiled function that comes from a directory, for exactly its sources, where that has it.

    Args: around: what the compiler, which looks there first, runs within, by the name of the function.
    """
    compiled = cast(Any, function)
    compiled._cache, compiler = Kept(compiled.py_func, directory), compiled.compile

    def guarded(signature: Any) -> Any:
        with around(function.__name__):
            return compiler(signature)

    compiled.compile = guarded
    return function


class Kept:
    """Machine code of a function on disk, a file for each signature, each with a digest: what was damaged is compiled anew.

    Numba's own cache asks where a source lies and when it was written, so that a fresh checkout would compile everything anew;
    and imports, before it looks, all that might be compiled, SciPy's linear algebra among it: .26 s of .36 s to the first step
    of ten boxes. Terms: cache_path: what Numba calls the directory.
    """

    def __init__(self, function: Any, directory: Path) -> None:
        self._stem = f"{Path(function.__code__.co_filename).stem}.{function.__name__}"
        self._directory, self.cache_path = directory, str(directory)

    def path(self, signature: Any, context: Any) -> Path:
        """The file for arguments of these types on this machine, for this version of Python."""
        key = str(signature), context.codegen().magic_tuple(), sys.implementation.cache_tag
        return self._directory / f"{self._stem}-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.nbc"

    def load_overload(self, signature: Any, context: Any) -> Any:
        """What was compiled for these types; None where there is none, or it is damaged."""
        runtime.initialize(context)
        try:
            content = read_checked(self.path(signature, context))
        except OSError:
            return None
        return None if content is None else Result._rebuild(context, *pickle.loads(content))

    def save_overload(self, signature: Any, made: Any) -> None:
        """Keep what was compiled, unless it names a place in this process's memory."""
        if not made.library.has_dynamic_globals:
            write_checked(self.path(signature, made.target_context), serialize.dumps(made._reduce()))


def entry_point(function: Any, signature: Any) -> tuple[Any, int]:
    """What a compiled function returns for arguments of these types, and where the machine code for them lies.

    It is compiled as a call from Python compiles it: asked for by what it returns too, it would be compiled and kept twice.
    """
    function.compile(tuple(signature.args))
    made = function.get_compile_result(signature)
    library = made._asdict()["library"]
    return made.signature.return_type, library.get_pointer_to_function(made.fndesc.llvm_cfunc_wrapper_name)
