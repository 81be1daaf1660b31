"""What Numba compiles kernels and entries into: modules that wait to be linked, and whole programs.

Numba makes machine code of every function on its own, with all that it calls, once per caller. Here a kernel stays what Numba
made of its text until an entry is linked, which takes in every kernel that it reaches, once, and is optimised as one program.
What comes out does not depend on what else the process has compiled. Until then a kernel is cleaned up and no more: optimised
whole it would be only to be optimised again.
"""

from types import SimpleNamespace
from typing import Any

import llvmlite.binding
from numba.core import environment
from numba.core.codegen import JITCodeLibrary

__all__ = ["EntryLibrary", "KernelLibrary"]

Library: Any = JITCodeLibrary
Environment: Any = environment
llvm: Any = llvmlite.binding

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

    Terms: seldom: whether it stays a function, and small; inline: whether the optimiser decides so; raises: whether it can end
    otherwise than with an answer.
    """

    seldom, inline, raises = False, True, True

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
        """Take in what Numba wrote, cleaned up, and let go of the text."""
        self.raises = may_raise(module)
        if self.seldom:
            keep_apart(module)
        super().add_ir_module(module)
        forget(module)

    def _optimize_functions(self, module: Any) -> None:
        tidy(module, self._codegen, self.inline)

    def alone(self) -> Any:
        """The module of this kernel, without what it calls."""
        return super()._get_module_for_linking()

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
            module.link_in(one._get_module_for_linking(), preserve=True)
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


def keep_apart(module: Any) -> None:
    """Have the functions of a module small and called, wherever they are linked into."""
    for function in module.functions:
        if function.blocks:
            for attribute in ("cold", "noinline", "optsize"):
                function.attributes.add(attribute)


def forget(module: Any) -> None:
    """Let go of the instructions of a module that has been read: each knows the block that it stands in."""
    for function in module.functions:
        for block in function.blocks:
            block.instructions.clear()
            block.terminator = None
        function.blocks.clear()
