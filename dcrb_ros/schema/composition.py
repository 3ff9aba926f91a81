"""Parameter groups whose fields are declared by the modules that use them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from inspect import get_annotations
from typing import TypeVar, cast

from pydantic import create_model

from dcrb_ros.schema.fields import Group

Model = TypeVar("Model", bound=Group)


def with_fields_of(parts: Iterable[type[Group]]) -> Callable[[type[Model]], type[Model]]:
    """Return a class decorator that adds the fields of other groups, in their order, after those of the class itself.

    The class becomes a subclass of every part, so that a module takes the whole group where it asks for its own part. Parts may inherit
    the same field from a common base.

    Raises:
        TypeError: two parts declare a field of the same name.
    """
    added = [part for part in parts if part.model_fields]

    def composed(declared: type[Model]) -> type[Model]:
        groups: list[type[Group]] = [declared, *added]
        declaring = {kind for group in groups for kind in group.__mro__ if issubclass(kind, Group)}
        fields = [name for kind in declaring for name in get_annotations(kind) if name in kind.model_fields]
        twice = sorted({name for name in fields if fields.count(name) > 1})
        if twice:
            raise TypeError(f"{declared.__name__} has two fields with the name {twice[0]}: rename one")
        # Pydantic orders fields from the last base to the first.
        found = create_model(declared.__name__, __base__=tuple(reversed(groups)), __doc__=declared.__doc__, __module__=declared.__module__)
        return cast(type[Model], found)

    return composed
