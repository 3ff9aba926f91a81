"""The message types of ROS 2 Jazzy as rosbags has them."""

from __future__ import annotations

from functools import cache

from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore


@cache
def typestore() -> Typestore:
    """Return the store of all types."""
    return get_typestore(Stores.ROS2_JAZZY)
