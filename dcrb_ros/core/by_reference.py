"""Named tuples that a kernel receives as one pointer.

Numba hands a named tuple to a function field by field: payload, state and workspace of a lubricated bearing are 538 arguments, which are
written out at every call between kernels, and their types are a part of every kernel's name. A class marked `by_reference` is one argument
with a short name instead. Its fields do not change while a kernel runs. They are loaded at the beginning of a function, and the loads say
that they are invariant, so the compiler treats them as arguments: the samples are the same, bit for bit, and the time loop is as fast.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any, TypeVar, cast
from weakref import WeakKeyDictionary

import numba.core.cgutils
import numba.extending
from llvmlite import ir
from numba.core import types
from numba.core.typing.templates import AttributeTemplate

# Numba is untyped.
cgutils, extending = cast(Any, numba.core.cgutils), cast(Any, numba.extending)
PrimitiveModel: Any = extending.models.PrimitiveModel
Bundle = TypeVar("Bundle", bound=type)
Value = TypeVar("Value")


class Reference(types.Type):
    """The type of a named tuple that is handed over as a pointer; its name has a digest of the types of the fields."""

    def __init__(self, instance_class: Any, members: tuple[Any, ...]) -> None:
        self.instance_class, self.members = instance_class, members
        digest = hashlib.sha256(repr(members).encode()).hexdigest()[:16]
        super().__init__(name=f"{instance_class.__name__}_{digest}")

    def place(self, field: str) -> int:
        """Return the position of a field."""
        return cast(int, self.instance_class._fields.index(field))


@extending.register_model(Reference)
class ReferenceModel(PrimitiveModel):
    """A pointer to the fields, as kernels compute with them."""

    def __init__(self, manager: Any, reference: Reference) -> None:
        fields = ir.LiteralStructType([manager[member].get_value_type() for member in reference.members])
        super().__init__(manager, reference, fields.as_pointer())


def by_reference(bundle: Bundle) -> Bundle:
    """Mark a class of named tuples: kernels receive its instances as one pointer."""

    def typed(value: Any, context: Any) -> Reference | None:
        members = tuple(extending.typeof_impl(field, context) for field in value)
        return None if None in members else Reference(type(value), members)

    extending.typeof_impl.register(bundle)(typed)
    return bundle


@extending.infer_getattr
class _Fields(AttributeTemplate):
    key = Reference

    def generic_resolve(self, value: Any, attr: Any) -> Any:  # type: ignore[override] # declared as not implemented
        return value.members[value.place(attr)] if attr in value.instance_class._fields else None


def _part(builder: Any, pointer: Any, at: int) -> Any:
    """Return the pointer to a part of what a pointer points to."""
    return cgutils.gep_inbounds(builder, pointer, 0, at)


def _parts(pointer: Any) -> range | None:
    """Return the positions of the parts of what a pointer points to, None for a number."""
    kind = pointer.type.pointee
    return range(len(kind)) if isinstance(kind, (ir.LiteralStructType, ir.ArrayType)) else None


_LOADED: WeakKeyDictionary[Any, dict[tuple[Reference, int], Any]] = WeakKeyDictionary()
"""Fields that functions have loaded."""


@extending.lower_getattr_generic(Reference)
def _field(context: Any, builder: Any, reference: Reference, pointer: Any, name: str) -> Any:
    """Return a field, loaded where the function begins: what is calculated from it keeps its place, and with it its last bit."""
    at = reference.place(name)
    arguments = [argument for argument in builder.function.args if argument.type == pointer.type]
    if len(arguments) != 1:  # two of one type: which of them it is shows only here
        return _load(builder, _part(builder, pointer, at))
    loaded = _LOADED.setdefault(builder.function, {})
    if (reference, at) not in loaded:
        with builder.goto_entry_block():
            loaded[reference, at] = _load(builder, _part(builder, arguments[0], at))
    return loaded[reference, at]


def _load(builder: Any, pointer: Any) -> Any:
    """Load each part of a field by itself: the compiler would take a load of several apart and forget that it is invariant."""
    parts = _parts(pointer)
    if parts is not None:
        value = ir.Constant(pointer.type.pointee, ir.Undefined)
        for at in parts:
            value = builder.insert_value(value, _load(builder, _part(builder, pointer, at)), at)
        return value
    load = builder.load(pointer)
    load.set_metadata("invariant.load", builder.module.add_metadata([]))
    return load


def on_stack(bundle: Value) -> Value:
    """Return a named tuple; in a kernel, a copy on its stack, whose fields the compiler keeps in registers through the whole kernel."""
    return bundle


@extending.type_callable(on_stack)
def _type_on_stack(context: Any) -> Callable[[Any], Any]:
    def typed(bundle: Any) -> Any:
        return bundle if isinstance(bundle, Reference) else None

    return typed


@extending.lower_builtin(on_stack, Reference)
def _copy_to_stack(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    (source,) = arguments
    target = cgutils.alloca_once(builder, source.type.pointee)
    _copy(builder, source, target)
    return target


def _copy(builder: Any, source: Any, target: Any) -> None:
    """Copy number by number: the compiler would have to take a copy of the whole apart."""
    parts = _parts(source)
    if parts is None:
        builder.store(builder.load(source), target)
        return
    for at in parts:
        _copy(builder, _part(builder, source, at), _part(builder, target, at))


@extending.unbox(Reference)
def _unbox(reference: Reference, value: Any, c: Any) -> Any:
    """Write the fields of a Python object onto the caller's stack."""
    builder = c.builder
    pointer = cgutils.alloca_once(builder, c.context.get_value_type(reference).pointee)
    failed, cleanups = cgutils.alloca_once_value(builder, cgutils.false_bit), []
    for at, member in enumerate(reference.members):
        native = c.unbox(member, c.pyapi.tuple_getitem(value, at))
        builder.store(native.value, _part(builder, pointer, at))
        with builder.if_then(native.is_error, likely=False):
            builder.store(cgutils.true_bit, failed)
        if native.cleanup is not None:
            cleanups.append(native.cleanup)

    def cleanup() -> None:
        for each in reversed(cleanups):
            each()

    return extending.NativeValue(pointer, cleanup=cleanup, is_error=builder.load(failed))
