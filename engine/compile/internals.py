"""All that this folder uses of Numba and that Numba does not document, so that a test can say what a version lacks.

Nothing of this project but the modules in `FILES` names Numba's own modules.
"""

__all__ = ["FILES", "INTERNALS"]

FILES = ("compilers", "libraries", "lower_kernel", "passes", "remembered", "table_type")
"""The modules of this folder that touch them."""

INTERNALS: dict[str, tuple[str, ...]] = {
    "numba.core.caching.IndexDataCacheFile": ("_data_path", "_load_data", "_load_index", "_open_for_write"),
    "numba.core.callconv.CPUCallConv": ("_get_arg_packer", "get_return_type"),
    "numba.core.cgutils": ("get_null_value", "pack_array", "unpack_tuple"),
    "numba.core.cgutils._StructProxy": ("_getvalue",),
    "numba.core.codegen.JITCodeLibrary": (
        *("codegen", "finalize", "enable_object_caching", "get_pointer_to_function", "_raise_if_finalized"),
        *("_finalize_dynamic_globals", "_get_module_for_linking", "_optimize_final_module", "_optimize_functions"),
        *("_ensure_finalized", "_get_compiled_object", "add_ir_module", "serialize_using_object_code"),
    ),
    "numba.core.compiler.CompilerBase": ("define_pipelines",),
    "numba.core.compiler.DefaultPassBuilder": ("define_nopython_pipeline",),
    "numba.core.compiler_machinery": ("AnalysisPass", "PassManager", "register_pass"),
    "numba.core.compiler_machinery.PassManager": ("_ENFORCING", "add_pass", "finalize"),
    "numba.core.config": ("CACHE_DIR", "DISABLE_JIT", "NUMBA_NUM_THREADS"),
    "numba.core.datamodel.packer.ArgPacker": ("as_arguments",),
    "numba.core.environment": ("lookup_environment",),
    "numba.core.imputils": ("lower_builtin", "lower_cast", "lower_getattr"),
    "numba.core.ir": ("Assign", "Expr", "UNDEFINED"),
    "numba.core.ir.Block": ("find_insts",),
    "numba.core.ir_utils": ("build_definitions", "get_definition", "guard"),
    "numba.core.lowering": ("Lower",),
    "numba.core.lowering.Lower": (
        *(
            "_lower_call_normal",
            "alloca_lltype",
            "delvar",
            "fold_call_args",
            "loadvar",
            "lower_binop",
            "lower_expr",
            "lower_getitem",
        ),
        *("lower_setitem", "typeof"),
    ),
    "numba.core.rewrites.registry": ("rewrite_registry",),
    "numba.core.rewrites.registry.Rewrite": ("apply", "match"),
    "numba.core.rewrites.registry.rewrite_registry": ("rewrites",),
    "numba.core.runtime.nrt.rtsys": ("initialize",),
    "numba.core.ssa": ("reconstruct_ssa",),
    "numba.core.typed_passes": (
        *("BaseNativeLowering", "IRLegalization", "NoPythonBackend", "NopythonTypeInference", "PreLowerStripPhis"),
    ),
    "numba.core.typed_passes.BaseNativeLowering": ("lowering_class",),
    "numba.core.typed_passes.PreLowerStripPhis": ("_strip_phi_nodes", "run_pass"),
    "numba.core.types": ("BaseNamedTuple", "FunctionType", "SliceType", "range_iter64_type", "range_state64_type"),
    "numba.core.types.BaseTuple": ("from_types",),
    "numba.core.typing.templates": ("AbstractTemplate", "AttributeTemplate", "infer_getattr", "infer_global", "signature"),
    "numba.core.untyped_passes": (
        *("DeadBranchPrune", "FixupArgs", "GenericRewrites", "IRProcessing", "ReconstructSSA", "RewriteSemanticConstants"),
        "TranslateByteCode",
    ),
    "numba.cpython.slicing": ("fix_slice", "get_slice_length", "guard_invalid_slice"),
    "numba.np.arrayobj": ("populate_array",),
    "the options of njit": ("forceinline", "no_cfunc_wrapper", "no_cpython_wrapper", "pipeline_class"),
    "the type of a function": ("ftype",),
    "the type of a slice": ("has_step",),
    "the type of an operation": ("_impl_keys", "get_impl_key", "templates", "typing_key"),
    "a compiled function": ("compile", "get_call_template", "get_compile_result", "overloads", "_cache"),
    "its cache": ("load_overload", "_cache_file", "_guard_against_spurious_io_errors", "_impl", "_load_overload"),
    "where its cache lies": ("filename_base", "locator"),
    "what says where": ("_cache_path",),
    "the files of its cache": ("_index_path", "_source_stamp", "_version"),
    "what its compiler made": ("fndesc", "library", "signature"),
    "its description": ("calltypes", "llvm_cfunc_wrapper_name", "mangled_name"),
    "its library": ("_codegen", "_final_module", "_finalized", "_linking_libraries", "_reload_init"),
    "the machine code that it is made with": ("_data_layout", "_pass_builder", "set_env"),
    "its compiler": ("state",),
    "the state of its compiler": (
        *("calltypes", "flags", "func_id", "func_ir", "library", "return_type", "targetctx", "typemap", "typingctx"),
    ),
    "the flags of its compiler": ("forceinline", "noalias"),
    "the function in its compiler": ("func_qualname",),
    "its text in its compiler": ("_definitions", "blocks"),
    "a sum in its text": ("lhs", "op", "rhs", "static_lhs", "static_rhs"),
    "a call in a text": ("args", "func", "kws", "vararg"),
    "what its compiler knows of types": ("_lookup_global", "resolve_function_type", "resolve_setitem", "resolve_value_type"),
    "its target": (
        *("add_linking_libs", "call_conv", "cast", "codegen", "declare_function", "enable_nrt", "fastmath", "get_abi_sizeof"),
        *("get_constant", "get_data_type", "get_dummy_value", "get_function", "get_returned_value", "get_value_type"),
        *("make_array", "make_helper", "make_tuple", "pack_value", "subtarget", "typing_context", "unpack_value"),
    ),
}
"""By where it is, or by what has it, its names."""
