"""Numbers so small that processors stumble over them, flushed to zero while compiled loops run.

Below 1e-38 in single and 1e-308 in double precision numbers are subnormal, and arithmetic with them
is up to a hundred times slower. The tails of vorticity are full of them.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call, misc, import-untyped, call-arg"
from __future__ import annotations

import platform

from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

FLUSH = 0x8040  # flush to zero, and take subnormal numbers as zero
KNOWN = platform.machine().lower() in ("x86_64", "amd64")


def _call(context, builder, name, place):
    kind = ir.FunctionType(ir.VoidType(), [cgutils.voidptr_t])
    law = cgutils.get_or_insert_function(builder.module, kind, name)
    builder.call(law, [builder.bitcast(place, cgutils.voidptr_t)])


@intrinsic
def control(typing):
    """The control word of the floating-point unit."""

    def make(context, builder, signature, arguments):
        place = cgutils.alloca_once_value(builder, ir.Constant(ir.IntType(32), 0))
        _call(context, builder, "llvm.x86.sse.stmxcsr", place)
        return builder.load(place)

    return types.uint32(), make


@intrinsic
def set_control(typing, word):
    """Set it."""

    def make(context, builder, signature, arguments):
        place = cgutils.alloca_once_value(builder, arguments[0])
        _call(context, builder, "llvm.x86.sse.ldmxcsr", place)
        return context.get_dummy_value()

    return types.void(types.uint32), make


@njit("uint32()", cache=True)
def _flush():
    word: int = control()
    set_control(types.uint32(word | FLUSH))
    return word


@njit("void(uint32)", cache=True)
def _restore(word):
    set_control(types.uint32(word))


def flush() -> int:
    """Flush subnormal numbers in this thread from now on; what to `restore`."""
    return int(_flush()) if KNOWN else 0


def restore(word: int) -> None:
    """Let this thread compute as before."""
    if KNOWN:
        _restore(word)
