"""A hint to the processor about memory that a later step reads."""

from __future__ import annotations

from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from dcrb_ros.core.layout.records import Integers

if getattr(numba.config, "DISABLE_JIT"):  # noqa: B009 - numba's configuration is untyped

    def prefetch(array: Integers, index: int) -> None:
        """Do nothing."""

else:

    @intrinsic
    def prefetch(typingctx: Any, array: Any, index: Any) -> Any:
        """Ask the processor to load an element of an array into its cache; the index may lie outside of the array."""

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
            number, byte = ir.IntType(32), cgutils.voidptr_t
            takes = ir.FunctionType(ir.VoidType(), [byte, number, number, number])
            function = cgutils.get_or_insert_function(builder.module, takes, "llvm.prefetch.p0")  # type: ignore[no-untyped-call]
            # Data that will be read, for the nearest cache.
            how = [number(0), number(3), number(1)]
            builder.call(function, [builder.bitcast(builder.gep(data, [arguments[1]]), byte), *how])
            return context.get_dummy_value()

        return types.none(array, types.int64), codegen
