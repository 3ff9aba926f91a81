"""Groups whose fields are declared by other modules."""

from __future__ import annotations

import pickle

import pytest

from dcrb_ros.schema.composition import with_fields_of
from dcrb_ros.schema.fields import Group, quantity


class Common(Group):
    common: float = quantity(3.0, "-", "Common", 0.0, 10.0)


class First(Common):
    first: float = quantity(1.0, "-", "First", 0.0, 10.0)


class Second(Common):
    second: float = quantity(2.0, "-", "Second", 0.0, 10.0)


class Nothing(Group):
    pass


@with_fields_of([First, Nothing, Second])
class Whole(Group):
    """The whole."""

    own: float = quantity(0.0, "-", "Own", 0.0, 10.0)


def test_the_group_has_the_fields_of_its_parts_after_its_own() -> None:
    assert list(Whole.model_fields)[-2:] == ["first", "second"]
    assert sorted(Whole.model_fields) == ["common", "first", "own", "second"]
    assert Whole.__doc__ == "The whole."


def test_the_group_is_an_instance_of_every_part() -> None:
    whole = Whole.model_validate({"first": 4.0})
    assert isinstance(whole, First)
    assert isinstance(whole, Second)
    assert (whole.first, whole.second, whole.common) == (4.0, 2.0, 3.0)
    assert pickle.loads(pickle.dumps(whole)) == whole


def test_a_field_of_two_parts_is_refused() -> None:
    class Other(Group):
        first: float = quantity(1.0, "-", "Another first", 0.0, 10.0)

    with pytest.raises(TypeError, match="Twice has two fields with the name first: rename one"):

        @with_fields_of([First, Other])
        class Twice(Group):
            pass
