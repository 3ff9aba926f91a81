"""Numba is imported, and compiled kernels are loaded from the cache, without what only a compilation needs.

Before numba loads a compiled function, it registers every function that a kernel could call, and reads the intermediate representation by
which the function is inlined into others. Here the compiler does both when it compiles. The objects that the import of numba makes stay
until the end of the process, so Python's garbage collector is kept from searching them again and again.

The kernels' own package would be the place for this. Its sources, however, are part of the fingerprint of the model, which names the
samples that a model makes, and loading changes none of them.
"""

from __future__ import annotations

import gc
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:  # every import of the package loads this module, also that of a program that must not miss a signal
    from typing import Any

KERNELS = "dcrb_ros.core"
"""Package that imports numba."""
KNOWN = ("0.68.1",)
"""Releases of numba with which this was tried; others load functions in their own way."""


class _BeforeKernels:
    """Finds no module, and imports numba when the kernels are about to be imported.

    It stays in the list of finders, which the import system is going through when it is asked.
    """

    def __init__(self) -> None:
        self._asked = False

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> None:
        """Import numba before `KERNELS`."""
        if fullname == KERNELS and not self._asked:
            self._asked = True
            _import_numba()


def load_kernels_quickly() -> None:
    """Import numba and load kernels without the compiler, as soon as the kernels are imported."""
    sys.meta_path.insert(0, _BeforeKernels())


def _import_numba() -> None:
    """Import numba with its objects exempt from garbage collection, and change how it loads this package's functions."""
    if "numba" not in sys.modules:
        collecting, unmeasured = gc.isenabled(), "coverage" not in sys.modules
        gc.collect()  # garbage of the program must not stay; that of the import, some 400 objects, may
        gc.disable()
        if unmeasured:
            sys.modules["coverage"] = None  # type: ignore[assignment]  # numba would import it to report the coverage of kernels
        try:
            import numba  # noqa: F401
        finally:
            if unmeasured:
                del sys.modules["coverage"]
            if collecting:
                gc.enable()
        gc.freeze()
    if sys.modules["numba"].__version__ in KNOWN:
        _replace_loading()


def _replace_loading() -> None:
    """Let numba load the functions of this package without its compiler."""
    from numba.core.caching import Cache
    from numba.core.dispatcher import Dispatcher
    from numba.core.runtime import nrt

    caches: Any = Cache
    functions: Any = Dispatcher
    runtime: Any = nrt.rtsys
    usual, extend = caches.load_overload, functions._compilation_chain_init_hook

    def load_overload(cache: Any, signature: Any, context: Any) -> Any:
        if not _own(cache._py_func):
            return usual(cache, signature, context)
        runtime.initialize(context)  # loaded functions that allocate call it
        data = cache._cache_file.load(cache._index_key(signature, context.codegen()))
        return None if data is None else _loaded(cache, context, data)

    def import_extensions(function: Any) -> None:
        if not _own(function.py_func):  # the compiler does it again
            extend(function)

    caches.load_overload = load_overload
    functions._compilation_chain_init_hook = import_extensions


def _own(function: Any) -> bool:
    """Return whether a function is one of this package."""
    return str(function.__module__).startswith("dcrb_ros.")


def _loaded(cache: Any, context: Any, data: Any) -> Any:
    """Return the function in the content of a file; its intermediate representation is read when it is compiled into another one."""
    import llvmlite.binding as llvm

    (name, kind, (code, representation)), description, *rest = data
    engine = context.codegen()._engine
    engine._defined_symbols |= {description.llvm_func_name, description.llvm_cpython_wrapper_name, description.llvm_cfunc_wrapper_name}
    nothing = llvm.parse_assembly("").as_bitcode()
    loaded = cache._impl.rebuild(context, ((name, kind, (code, nothing)), description, *rest))
    library = loaded.library

    def module_for_linking() -> Any:
        del library._get_module_for_linking
        library._shared_module = llvm.parse_bitcode(representation)
        engine._load_defined_symbols(library._shared_module)
        return library._shared_module

    library._get_module_for_linking = module_for_linking
    return loaded
