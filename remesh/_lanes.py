"""A few neighbouring values that a compiled loop keeps in one register: load, add products, store.

The loops over the nodes of a kernel are too short for a compiler to find this by itself. ``lanes``
is a tuple whose length, a constant to the compiler, is the number of values. Places are not
checked: whoever calls has seen to it that all lanes lie inside the array.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call, misc, import-untyped"
from __future__ import annotations

from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic, models, register_model


class Lanes(types.Type):
    """So many values of one kind."""

    def __init__(self, dtype, count):
        self.dtype = dtype
        self.count = count
        super().__init__(name=f"Lanes({dtype}, {count})")


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    """As the machine holds them: one vector."""

    def __init__(self, manager, kind):
        element = manager.lookup(kind.dtype).get_value_type()
        super().__init__(manager, kind, ir.VectorType(element, kind.count))


def _address(context, builder, array, value, place, kind):
    """Where the lanes begin, and the alignment that is sure: that of one value."""
    first = builder.gep(context.make_array(array)(context, builder, value).data, [place])
    start = builder.bitcast(first, context.get_value_type(kind).as_pointer())
    return start, context.get_abi_sizeof(context.get_value_type(kind.dtype))


def _spread_out(context, builder, kind, number):
    """The same number in all lanes."""
    index = ir.IntType(32)
    vector = context.get_value_type(kind)
    first = builder.insert_element(ir.Constant(vector, ir.Undefined), number, index(0))
    none = ir.Constant(ir.VectorType(index, kind.count), None)
    return builder.shuffle_vector(first, ir.Constant(vector, ir.Undefined), none)


@intrinsic
def none(typingctx, array, lanes):
    """Zeros of the array's kind."""
    kind = Lanes(array.dtype, len(lanes))

    def generate(context, builder, signature, arguments):
        return ir.Constant(context.get_value_type(kind), None)

    return kind(array, lanes), generate


@intrinsic
def load(typingctx, array, place, lanes):
    """The values from ``place`` on of a flat, contiguous array."""
    kind = Lanes(array.dtype, len(lanes))

    def generate(context, builder, signature, arguments):
        start, width = _address(context, builder, array, arguments[0], arguments[1], kind)
        found = builder.load(start)
        found.align = width
        return found

    return kind(array, types.intp, lanes), generate


@intrinsic
def store(typingctx, values, array, place):
    """Write the values to a flat, contiguous array from ``place`` on."""

    def generate(context, builder, signature, arguments):
        start, width = _address(context, builder, array, arguments[1], arguments[2], values)
        builder.store(arguments[0], start, align=width)
        return context.get_dummy_value()

    return types.none(values, array, types.intp), generate


@intrinsic
def times(typingctx, values, number):
    """values * number."""

    def generate(context, builder, signature, arguments):
        factor = _spread_out(context, builder, values, arguments[1])
        return builder.fmul(arguments[0], factor)

    return values(values, values.dtype), generate


@intrinsic
def plus(typingctx, total, values, factor):
    """total + values * factor, a number or lanes, rounded once where the machine can."""
    kind = values if isinstance(factor, Lanes) else values.dtype

    def generate(context, builder, signature, arguments):
        factor = arguments[2]
        if kind is not values:
            factor = _spread_out(context, builder, values, factor)
        product = builder.fmul(arguments[1], factor, flags=("contract",))
        return builder.fadd(arguments[0], product, flags=("contract",))

    return total(total, values, kind), generate


@intrinsic
def product(typingctx, one, other):
    """one * other, lane by lane."""

    def generate(context, builder, signature, arguments):
        return builder.fmul(*arguments, flags=("contract",))

    return one(one, other), generate


@intrinsic
def dot(typingctx, one, other):
    """Sum over the lanes of one * other, always in the same order."""

    def generate(context, builder, signature, arguments):
        index = ir.IntType(32)
        values = builder.fmul(arguments[0], arguments[1])
        count = one.count
        while count > 1:
            count //= 2
            halves = [
                builder.shuffle_vector(
                    values,
                    values,
                    ir.Constant(ir.VectorType(index, count), list(range(start, start + count))),
                )
                for start in (0, count)
            ]
            values = builder.fadd(*halves)
        return builder.extract_element(values, index(0))

    return one.dtype(one, one), generate
