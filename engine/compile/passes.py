"""How a kernel goes from its text to a module of LLVM: by Numba's own passes, of which kernels need a half.

Left out is what kernels do not have: closures, generators, `with`, lists of literals, annotated sources; and the analysis of
all variables after each pass. Added is that references are counted where a kernel makes arrays and nowhere else.
"""

from typing import Any

import numba
from numba.core import compiler_machinery, ir, ir_utils, ssa, typed_passes, untyped_passes
from numba.core.rewrites.registry import rewrite_registry

from engine.compile.lower_kernel import LowerKernel
from engine.compile.remembered import Remembering
from engine.compile.table_type import Table

__all__ = ["kernel_passes"]

types: Any = numba.types
machinery: Any = compiler_machinery
typed: Any = typed_passes
untyped: Any = untyped_passes
Statements: Any = ir
registry: Any = rewrite_registry
reconstruct_ssa: Any = ssa.reconstruct_ssa
build_definitions: Any = ir_utils.build_definitions
get_definition: Any = ir_utils.get_definition
guard: Any = ir_utils.guard

MAKERS = frozenset({"call", "binop", "inplace_binop", "unary", "arrayexpr"})
"""The operations that may make an array; others look into one that is held elsewhere."""


class Passes(machinery.PassManager):
    """Numba's passes in turn, without a whole analysis of variables after each of them: those that need it ask for it."""

    _ENFORCING = False


@machinery.register_pass(mutates_CFG=True, analysis_only=False)
class Rewrite(untyped.GenericRewrites):
    """As Numba does, without a whole analysis of variables after it."""

    _name = "plumbline_rewrite"

    def run_pass(self, state: Any) -> bool:
        for kind in registry.rewrites["before-inference"]:
            rewrite, ahead = kind(state), list(state.func_ir.blocks.items())
            while ahead:
                key, block = ahead.pop()
                if rewrite.match(state.func_ir, block, state.typemap, state.calltypes):
                    state.func_ir.blocks[key] = rewrite.apply()
                    ahead.append((key, state.func_ir.blocks[key]))
        return True


@machinery.register_pass(mutates_CFG=True, analysis_only=False)
class NameOnce(untyped.ReconstructSSA):
    """As Numba does (static single assignment), without that analysis."""

    _name = "plumbline_name_once"

    def run_pass(self, state: Any) -> bool:
        state.func_ir = reconstruct_ssa(state.func_ir)
        state.func_ir._definitions = build_definitions(state.func_ir.blocks)
        return True


@machinery.register_pass(mutates_CFG=True, analysis_only=False)
class StripPhis(typed.PreLowerStripPhis):
    """As Numba does, without that analysis."""

    _name = "plumbline_strip_phis"

    def run_pass(self, state: Any) -> bool:
        state.func_ir = self._strip_phi_nodes(state.func_ir)
        state.func_ir._definitions = build_definitions(state.func_ir.blocks)
        return True


@machinery.register_pass(mutates_CFG=True, analysis_only=False)
class InferTypes(typed.NopythonTypeInference):
    """As Numba does, with remembered answers."""

    _name = "plumbline_infer_types"

    def run_pass(self, state: Any) -> Any:
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
        return LowerKernel


@machinery.register_pass(mutates_CFG=False, analysis_only=True)
class Forget(machinery.AnalysisPass):
    """Lets go of what a kernel was made of: its statements know one another, and Python would have to search for them."""

    _name = "plumbline_forget"

    def __init__(self) -> None:
        machinery.AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        for block in state.func_ir.blocks.values():
            block.body.clear()
        return True


KERNEL_PASSES = (
    *(untyped.TranslateByteCode, untyped.FixupArgs, untyped.IRProcessing, untyped.RewriteSemanticConstants),
    *(untyped.DeadBranchPrune, Rewrite, NameOnce, InferTypes, StripPhis),
    *(typed.IRLegalization, CountNothing, WriteKernel, typed.NoPythonBackend, Forget),
)


def kernel_passes() -> Any:
    """The passes of a function that only compiled functions call."""
    manager = Passes("kernel")
    for one in KERNEL_PASSES:
        manager.add_pass(one, one.name())
    manager.finalize()
    return manager
