"""How kernels are written in LLVM: as Numba does, but for what a compiler of hundreds of small functions gains by."""

from typing import Any

import numba
from numba.core import ir, ir_utils, lowering

from engine.compile.remembered import Remembering
from engine.compile.table_type import Table, get_item, set_item

__all__ = ["LowerKernel"]

types: Any = numba.types
Lower: Any = lowering.Lower
Statements: Any = ir
guard: Any = ir_utils.guard
get_definition: Any = ir_utils.get_definition


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

    def lower_expr(self, kind: Any, expression: Any) -> Any:
        """As Numba does, but for the start of a loop."""
        if expression.op == "getiter":
            step = self.known_step(expression.value)
            if step != 0:
                return self.counter(self.loadvar(expression.value.name), step)
        return super().lower_expr(kind, expression)

    def known_step(self, span: Any) -> int:
        """The step of a range, where its text says it; else 0."""
        if self.typeof(span.name) is not types.range_state64_type:
            return 0
        made = guard(get_definition, self.func_ir, span)
        if getattr(made, "op", None) != "call":
            return 0
        step = self.typeof(made.args[2].name) if len(made.args) == 3 else types.literal(1)
        return int(step.literal_value) if isinstance(step, types.IntegerLiteral) else 0

    def counter(self, span: Any, step: int) -> Any:
        """What counts through a range by a known step, which need not be looked at before each loop: nothing can be raised."""
        builder, number = self.builder, self.context.get_value_type(types.int64)
        start, stop = builder.extract_value(span, 0), builder.extract_value(span, 1)
        count = builder.sub(stop, start) if step > 0 else builder.sub(start, stop)
        if abs(step) > 1:
            count = builder.sdiv(builder.add(count, number(abs(step) - 1)), number(abs(step)))
        made = self.context.make_helper(builder, types.range_iter64_type)
        with builder.goto_entry_block():
            made_at, left_at = builder.alloca(number), builder.alloca(number)
        builder.store(start, made_at)
        builder.store(count, left_at)
        made.iter, made.count, made.stop, made.step = made_at, left_at, stop, number(step)
        return made._getvalue()

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
